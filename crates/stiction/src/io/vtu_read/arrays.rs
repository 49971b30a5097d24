//! Numbers of arrays.

use std::io::Read;

use flate2::read::ZlibDecoder;

use super::document::{Array, Document, Format, Number, Section};
use super::stream::Stream;
use super::xml::DAMAGED;
use crate::Error;
use crate::io::number::{float, integer};

/// Most bytes that zlib makes of one.
const ZLIB_MOST: usize = 1032;
/// Bytes decoded at a time: a multiple of the size of every number.
const PART: usize = 1 << 16;

/// Makes room for another of `count` things: no more than a half beyond those that have come, since the count may be wrong.
pub(super) fn grow<T>(things: &mut Vec<T>, count: usize) {
    if things.len() == things.capacity() {
        things.reserve_exact((things.len() / 2).max(1024).min(count.saturating_sub(things.len()).max(1)));
    }
}

impl<'a> Document<'a> {
    /// The array called `name` that every grid has.
    pub fn needed(&self, section: Section, name: &str) -> Result<&Array<'a>, Error> {
        let found = self.arrays.iter().find(|a| a.section == section && (a.name == name || section == Section::Points));
        found.ok_or_else(|| Error::new("", format!("the grid has no array \"{name}\""), DAMAGED))
    }

    /// `count` whole numbers, each given to `push`.
    pub fn integers(&self, array: &Array, count: usize, mut push: impl FnMut(i64)) -> Result<(), Error> {
        if let Format::Ascii(text) = array.format {
            return self.words(array, text, count, |word| integer(word).map(&mut push));
        }
        let unused = 64 - 8 * array.size as u32;
        self.numbers(array, count, &mut |chunk| {
            let mut bytes = [0; 8];
            bytes[..chunk.len()].copy_from_slice(chunk);
            if self.big {
                bytes[..chunk.len()].reverse();
            }
            let wide = u64::from_le_bytes(bytes);
            push(match array.number {
                Number::Signed => (wide << unused) as i64 >> unused,
                // beyond 63 bits it is no number of anything
                _ => i64::try_from(wide).unwrap_or(i64::MAX),
            });
        })
    }

    /// `count` floating point numbers.
    pub fn floats(&self, array: &Array, count: usize) -> Result<Vec<f64>, Error> {
        let mut values = Vec::new();
        if let Format::Ascii(text) = array.format {
            values.reserve_exact(count.min(text.len()));
            self.words(array, text, count, |word| float(word).map(|x| values.push(x)))?;
            return Ok(values);
        }
        if array.number != Number::Float {
            values.reserve_exact(count.min(1 << 16)); // grows once the bytes are known to be there
            self.integers(array, count, |x| values.push(x as f64))?;
            return Ok(values);
        }
        let (mut short, mut long) = ([0; 4], [0; 8]);
        self.numbers(array, count, &mut |chunk| {
            grow(&mut values, count);
            values.push(if chunk.len() == 4 {
                short.copy_from_slice(chunk);
                f64::from(if self.big { f32::from_be_bytes(short) } else { f32::from_le_bytes(short) })
            } else {
                long.copy_from_slice(chunk);
                if self.big { f64::from_be_bytes(long) } else { f64::from_le_bytes(long) }
            });
        })?;
        Ok(values)
    }

    fn fail(&self, array: &Array, what: String) -> Error {
        Error::new(format!("array \"{}\" (line {})", array.name, array.line), what, DAMAGED)
    }

    /// Text: exactly `count` words.
    fn words(
        &self,
        array: &Array,
        text: &[u8],
        count: usize,
        mut push: impl FnMut(&[u8]) -> Option<()>,
    ) -> Result<(), Error> {
        if count > text.len() {
            let read = text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()).count();
            return Err(self.fail(array, format!("it holds {read} numbers where {count} are needed")));
        }
        let mut read = 0;
        for word in text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()) {
            if read < count && push(word).is_none() {
                let shown = String::from_utf8_lossy(&word[..word.len().min(40)]).into_owned();
                return Err(self.fail(array, format!("\"{shown}\" stands where a number was expected")));
            }
            read += 1;
        }
        if read == count {
            return Ok(());
        }
        Err(self.fail(array, format!("it holds {read} numbers where {count} are needed")))
    }

    /// The bytes of each of `count` numbers, given to `visit` as they are decoded.
    fn numbers(&self, array: &Array<'a>, count: usize, visit: &mut dyn FnMut(&[u8])) -> Result<(), Error> {
        let ends = || self.fail(array, "its data end too early or are no base64".to_string());
        let mut stream = match array.format {
            Format::Ascii(text) => Stream::Raw(text),
            Format::Binary(text) => Stream::base64(text.trim_ascii()),
            Format::Appended(offset) => {
                let (appended, base64) = self.appended.ok_or_else(ends)?;
                let rest = usize::try_from(offset).ok().and_then(|o| appended.get(o..)).ok_or_else(ends)?;
                if base64 { Stream::base64(rest) } else { Stream::Raw(rest) }
            }
        };
        let needed = count.checked_mul(array.size).ok_or_else(ends)?;
        let checked = |found: usize| {
            if found == needed {
                return Ok(());
            }
            Err(self.fail(array, format!("it holds {found} bytes where {count} numbers of {} are needed", array.size)))
        };
        if !self.zlib {
            checked(self.head(&mut stream).ok_or_else(ends)?)?;
            if needed > stream.remaining() {
                return Err(ends());
            }
            let mut left = needed;
            while left > 0 {
                let part = left.min(PART);
                stream.take(part).ok_or_else(ends)?.chunks_exact(array.size).for_each(&mut *visit);
                left -= part;
            }
            return Ok(());
        }
        let blocks = self.head(&mut stream).ok_or_else(ends)?;
        if blocks == 0 {
            return checked(0);
        }
        let block = self.head(&mut stream).ok_or_else(ends)?;
        let partial = self.head(&mut stream).ok_or_else(ends)?;
        // a size stands for each block
        let room = blocks.checked_mul(self.header).filter(|&bytes| bytes <= stream.remaining());
        let sizes = (0..room.ok_or_else(ends)? / self.header).map(|_| self.head(&mut stream));
        let sizes = sizes.collect::<Option<Vec<usize>>>().ok_or_else(ends)?;
        let last = if partial == 0 { block } else { partial };
        checked(block.saturating_mul(blocks - 1).saturating_add(last))?;
        if needed / ZLIB_MOST > stream.remaining() {
            return Err(ends());
        }
        let mut out: Vec<u8> = Vec::new();
        for (i, size) in sizes.into_iter().enumerate() {
            let packed = stream.take(size).ok_or_else(ends)?;
            let expected = if i + 1 == blocks { last } else { block };
            let before = out.len();
            // one more byte than there may be, so that a longer block is seen
            let read = ZlibDecoder::new(&*packed).take(expected as u64 + 1).read_to_end(&mut out);
            if read.is_err() || out.len() - before != expected {
                return Err(self.fail(array, format!("block {i} of its compressed data is damaged")));
            }
            let whole = out.len() - out.len() % array.size;
            out[..whole].chunks_exact(array.size).for_each(&mut *visit);
            out.drain(..whole); // a number may go on in the next block
        }
        Ok(())
    }

    /// A number that heads binary data.
    fn head(&self, stream: &mut Stream) -> Option<usize> {
        let bytes = stream.take(self.header)?;
        let mut wide = [0; 8];
        wide[..bytes.len()].copy_from_slice(&bytes);
        if self.big {
            wide[..bytes.len()].reverse();
        }
        usize::try_from(u64::from_le_bytes(wide)).ok()
    }
}
