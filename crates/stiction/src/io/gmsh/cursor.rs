//! A place in the bytes of a file, and the numbers that follow it.

use rayon::slice::ParallelSlice;

use crate::Error;
use crate::io::newlines;
use crate::io::number::{float, integer};

/// The remedy for whatever a writer would not have written.
pub(super) const DAMAGED: &str = "the file is damaged or incomplete; write it again";

/// How numbers outside text sections are written.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub(super) enum Encoding {
    #[default]
    Text,
    /// Big-endian or not; bytes of a `size_t`, 4 or 8.
    Binary { big: bool, size: usize },
}

/// Records of binary numbers of type `size_t`.
#[derive(Clone, Copy)]
pub(super) struct Records<'a> {
    bytes: &'a [u8],
    big: bool,
    /// Bytes of a number.
    size: usize,
    /// Numbers of a record.
    numbers: usize,
}

impl<'a> Records<'a> {
    pub(super) fn iter(&self) -> std::slice::ChunksExact<'a, u8> {
        self.bytes.chunks_exact(self.size * self.numbers)
    }

    pub(super) fn par_iter(&self) -> rayon::slice::ChunksExact<'a, u8> {
        self.bytes.par_chunks_exact(self.size * self.numbers)
    }

    /// Number `place` of a record.
    pub(super) fn size(&self, record: &[u8], place: usize) -> u64 {
        size_t(&record[place * self.size..][..self.size], self.big)
    }
}

/// The number in the four or eight bytes of a `size_t`.
pub(super) fn size_t(bytes: &[u8], big: bool) -> u64 {
    let mut wide = [0; 8];
    wide[..bytes.len()].copy_from_slice(bytes);
    if big {
        wide[..bytes.len()].reverse();
    }
    u64::from_le_bytes(wide)
}

pub(super) struct Cursor<'a> {
    bytes: &'a [u8],
    pub pos: usize,
    pub encoding: Encoding,
    /// The section being read, `$Nodes`, for messages and for its end.
    pub section: &'a str,
    /// Bytes and lines of the file before `bytes`, for messages.
    pub before: [usize; 2],
}

impl<'a> Cursor<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        let pos = if bytes.starts_with(b"\xef\xbb\xbf") { 3 } else { 0 }; // a byte order mark of UTF-8
        Cursor { bytes, pos, encoding: Encoding::Text, section: "", before: [0; 2] }
    }

    pub(super) fn binary(&self) -> bool {
        self.encoding != Encoding::Text
    }

    /// An error here.
    pub(super) fn fail(&self, what: impl Into<String>, remedy: &str) -> Error {
        self.fail_at(self.pos, what, remedy)
    }

    /// An error at byte `pos`, named by its line unless the file is binary.
    pub(super) fn fail_at(&self, pos: usize, what: impl Into<String>, remedy: &str) -> Error {
        let before = &self.bytes[..pos.min(self.bytes.len())];
        let [bytes, lines] = self.before;
        let place = match self.encoding {
            Encoding::Text => format!("line {}", 1 + lines + newlines(before)),
            Encoding::Binary { .. } => format!("byte {}", bytes + pos),
        };
        Error::new(place, what, remedy)
    }

    fn rest(&self) -> &'a [u8] {
        &self.bytes[self.pos..]
    }

    /// Moves to the next byte that is no white space; whether there is one.
    pub(super) fn skip_space(&mut self) -> bool {
        match self.rest().iter().position(|b| !b.is_ascii_whitespace()) {
            Some(n) => self.pos += n,
            None => self.pos = self.bytes.len(),
        }
        self.pos < self.bytes.len()
    }

    /// The rest of the line without surrounding white space; moves behind its end.
    pub(super) fn line(&mut self) -> &'a [u8] {
        let rest = self.rest();
        let end = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        self.pos += (end + 1).min(rest.len());
        rest[..end].trim_ascii()
    }

    /// The next `n` bytes.
    pub(super) fn take(&mut self, n: usize) -> Result<&'a [u8], Error> {
        match self.rest().split_at_checked(n) {
            Some((taken, _)) => {
                self.pos += n;
                Ok(taken)
            }
            None => Err(self.fail_at(self.bytes.len(), format!("the file ends within {}", self.section), DAMAGED)),
        }
    }

    /// The next `N` bytes, lowest first.
    fn little<const N: usize>(&mut self, big: bool) -> Result<[u8; N], Error> {
        let mut out = [0; N];
        out.copy_from_slice(self.take(N)?);
        if big {
            out.reverse();
        }
        Ok(out)
    }

    /// The next word of text.
    fn word(&mut self, what: &str) -> Result<&'a [u8], Error> {
        if !self.skip_space() {
            return Err(self.fail(format!("the file ends within {} before {what}", self.section), DAMAGED));
        }
        let rest = self.rest();
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.pos += end;
        Ok(&rest[..end])
    }

    fn not_a_number(&self, word: &[u8], what: &str) -> Error {
        let shown = String::from_utf8_lossy(&word[..word.len().min(40)]).into_owned();
        self.fail_at(self.pos - word.len(), format!("\"{shown}\" stands where {what} was expected"), DAMAGED)
    }

    /// A whole number written as text.
    pub(super) fn text_integer(&mut self, what: &str) -> Result<i64, Error> {
        let word = self.word(what)?;
        integer(word).ok_or_else(|| self.not_a_number(word, what))
    }

    /// An `int`: four bytes in binary files.
    pub(super) fn integer(&mut self, what: &str) -> Result<i64, Error> {
        match self.encoding {
            Encoding::Text => self.text_integer(what),
            Encoding::Binary { big, .. } => Ok(i64::from(i32::from_le_bytes(self.little(big)?))),
        }
    }

    /// A number >= 0 of type `int`.
    pub(super) fn natural(&mut self, what: &str) -> Result<u64, Error> {
        let value = self.integer(what)?;
        u64::try_from(value).map_err(|_| self.fail(format!("{value} stands where {what} was expected"), DAMAGED))
    }

    /// A `size_t`.
    pub(super) fn size(&mut self, what: &str) -> Result<u64, Error> {
        match self.encoding {
            Encoding::Text => self.natural(what),
            Encoding::Binary { big, size } => Ok(size_t(self.take(size)?, big)),
        }
    }

    /// The next `count` records of `numbers` of type `size_t` each, of a binary file.
    pub(super) fn records(&mut self, count: usize, numbers: usize) -> Result<Records<'a>, Error> {
        let Encoding::Binary { big, size } = self.encoding else {
            return Err(self.fail("records are those of binary files", DAMAGED));
        };
        // Whoever asks has seen that they are there.
        let bytes = self.take(count * numbers * size)?;
        Ok(Records { bytes, big, size, numbers })
    }

    /// Bytes of a `size_t`, or of the shortest text that could stand for one.
    pub(super) fn size_bytes(&self) -> usize {
        match self.encoding {
            Encoding::Text => 2,
            Encoding::Binary { size, .. } => size,
        }
    }

    /// A floating point number written as text.
    pub(super) fn text_float(&mut self, what: &str) -> Result<f64, Error> {
        let word = self.word(what)?;
        float(word).ok_or_else(|| self.not_a_number(word, what))
    }

    /// A floating point number; may be infinite or NaN.
    pub(super) fn float(&mut self, what: &str) -> Result<f64, Error> {
        match self.encoding {
            Encoding::Text => self.text_float(what),
            Encoding::Binary { big, .. } => Ok(f64::from_le_bytes(self.little(big)?)),
        }
    }

    /// `count` records of at least `bytes` bytes follow: an error if the file is too short for them.
    pub(super) fn room(&self, count: u64, what: &str, bytes: usize) -> Result<usize, Error> {
        // the last number of a text may end with the file, without the space after it
        let left = self.rest().len() + 1;
        match usize::try_from(count).ok().filter(|&n| n.checked_mul(bytes).is_some_and(|need| need <= left)) {
            Some(n) => Ok(n),
            None => Err(self.fail(format!("{count} {what} are announced, but only {left} bytes follow"), DAMAGED)),
        }
    }

    /// Moves behind the `$End` line of the section.
    pub(super) fn expect_end(&mut self) -> Result<(), Error> {
        self.skip_space();
        let start = self.pos;
        let line = self.line();
        if line.strip_prefix(b"$End").is_some_and(|name| name == &self.section.as_bytes()[1..]) {
            return Ok(());
        }
        let what = format!("{} does not end here, with $End{}", self.section, &self.section[1..]);
        Err(self.fail_at(start, what, DAMAGED))
    }

    /// Moves behind the `$End` line of a section of unknown contents.
    pub(super) fn skip_section(&mut self) -> Result<(), Error> {
        let start = self.pos;
        let end = format!("$End{}", &self.section[1..]);
        loop {
            let Some(n) = self.rest().iter().position(|&b| b == b'$') else {
                return Err(self.fail_at(start, format!("{} has no {end}", self.section), DAMAGED));
            };
            self.pos += n;
            if self.rest().starts_with(end.as_bytes()) {
                self.line();
                return Ok(());
            }
            self.pos += 1;
        }
    }
}
