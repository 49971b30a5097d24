//! Tags and text of an XML file, one after the other. Raw data behind the last tag of interest are never looked at.

use crate::Error;
use crate::io::newlines;

/// The remedy for whatever a writer would not have written.
pub(super) const DAMAGED: &str = "the file is damaged or incomplete; write it again";

/// A piece of the file.
pub(super) enum Event<'a> {
    Start(Tag<'a>),
    End(&'a [u8]),
    Text(&'a [u8]),
}

/// `<name key="value" ..>`.
pub(super) struct Tag<'a> {
    pub name: &'a [u8],
    attributes: Vec<(&'a [u8], &'a [u8])>,
    /// Whether it ends itself, `/>`.
    pub closed: bool,
    /// Where it stands.
    pub pos: usize,
}

impl Tag<'_> {
    /// The value of an attribute with its entities resolved.
    pub(super) fn get(&self, key: &str) -> Option<String> {
        let value = self.attributes.iter().find(|a| a.0 == key.as_bytes())?.1;
        let text = String::from_utf8_lossy(value.trim_ascii());
        let entities = [("&lt;", "<"), ("&gt;", ">"), ("&quot;", "\""), ("&apos;", "'"), ("&amp;", "&")];
        Some(entities.iter().fold(text.into_owned(), |text, (entity, plain)| text.replace(entity, plain)))
    }
}

pub(super) struct Xml<'a> {
    pub bytes: &'a [u8],
    pub pos: usize,
}

impl<'a> Xml<'a> {
    /// An error at byte `pos`, named by its line.
    pub(super) fn fail_at(&self, pos: usize, what: impl Into<String>, remedy: &str) -> Error {
        let before = &self.bytes[..pos.min(self.bytes.len())];
        Error::new(format!("line {}", 1 + newlines(before)), what, remedy)
    }

    /// The next piece; `None` at the end of the file. Comments and declarations are passed over.
    pub(super) fn next(&mut self) -> Result<Option<Event<'a>>, Error> {
        loop {
            let rest = &self.bytes[self.pos..];
            if rest.is_empty() {
                return Ok(None);
            }
            if rest[0] != b'<' {
                let end = memchr::memchr(b'<', rest).unwrap_or(rest.len());
                self.pos += end;
                return Ok(Some(Event::Text(&rest[..end])));
            }
            let passed = [(&b"<!--"[..], &b"-->"[..]), (b"<?", b"?>"), (b"<!", b">")];
            match passed.iter().find(|(begin, _)| rest.starts_with(begin)) {
                Some((_, end)) => {
                    let length = rest.windows(end.len()).position(|w| w == *end);
                    let length = length.ok_or_else(|| self.fail_at(self.pos, "a comment does not end", DAMAGED))?;
                    self.pos += length + end.len();
                }
                None => return self.tag().map(Some),
            }
        }
    }

    /// The tag that begins here.
    fn tag(&mut self) -> Result<Event<'a>, Error> {
        let start = self.pos;
        let rest = &self.bytes[start + 1..];
        let fail = || self.fail_at(start, "a tag is not complete", DAMAGED);
        if rest.first() == Some(&b'/') {
            let end = rest.iter().position(|&b| b == b'>').ok_or_else(fail)?;
            self.pos = start + 1 + end + 1;
            return Ok(Event::End(rest[1..end].trim_ascii()));
        }
        let name_end = rest.iter().position(|&b| b.is_ascii_whitespace() || b == b'>' || b == b'/').ok_or_else(fail)?;
        let mut tag = Tag { name: &rest[..name_end], attributes: Vec::new(), closed: false, pos: start };
        let mut at = name_end;
        loop {
            at += rest[at..].iter().position(|b| !b.is_ascii_whitespace()).ok_or_else(fail)?;
            match rest[at] {
                b'>' => break,
                b'/' => {
                    tag.closed = true;
                    at += 1;
                }
                _ => {
                    let equals = at + rest[at..].iter().position(|&b| b == b'=' || b == b'>').ok_or_else(fail)?;
                    let key = rest[at..equals].trim_ascii();
                    let open = equals
                        + 1
                        + rest[equals + 1..].iter().position(|b| !b.is_ascii_whitespace()).ok_or_else(fail)?;
                    let quote = rest[open];
                    if rest[equals] != b'=' || !matches!(quote, b'"' | b'\'') {
                        return Err(fail());
                    }
                    let close = open + 1 + rest[open + 1..].iter().position(|&b| b == quote).ok_or_else(fail)?;
                    tag.attributes.push((key, &rest[open + 1..close]));
                    at = close + 1;
                }
            }
        }
        self.pos = start + 1 + at + 1;
        Ok(Event::Start(tag))
    }
}
