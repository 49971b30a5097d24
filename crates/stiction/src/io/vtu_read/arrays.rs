//! Numbers of arrays.

use std::io::Read;

use flate2::read::ZlibDecoder;
use rayon::prelude::*;

use super::document::{Array, Document, Format, Number, Section};
use super::stream::Stream;
use super::xml::DAMAGED;
use crate::Error;
use crate::io::number::{float, integer};

/// Most bytes that zlib makes of one.
const ZLIB_MOST: usize = 1032;
/// Bytes decoded at a time: a multiple of the size of every number.
const PART: usize = 1 << 16;
/// Bytes of the blocks that are decompressed at a time, by all threads.
const TOGETHER: usize = 1 << 20;

/// Makes room for `more` of `count` things: no more than a half beyond those that have come, since the count may be wrong.
fn grow<T>(things: &mut Vec<T>, more: usize, count: usize) {
    if things.capacity() - things.len() < more {
        let left = count.saturating_sub(things.len());
        things.reserve_exact((things.len() / 2).max(1024).min(left).max(more));
    }
}

impl<'a> Document<'a> {
    /// The array called `name` that every grid has.
    pub(super) fn needed(&self, section: Section, name: &str) -> Result<&Array<'a>, Error> {
        let found = self.arrays.iter().find(|a| a.section == section && (a.name == name || section == Section::Points));
        found.ok_or_else(|| Error::new("", format!("the grid has no array \"{name}\""), DAMAGED))
    }

    /// What `of` makes of `count` whole numbers.
    pub(super) fn integers<T: Send>(
        &self,
        array: &Array,
        count: usize,
        of: impl Fn(i64) -> T + Sync,
    ) -> Result<Vec<T>, Error> {
        if let Format::Ascii(text) = array.format {
            return self.words(array, text, count, |word| integer(word).map(&of));
        }
        let unused = 64 - 8 * array.size as u32;
        let value = |wide: u64| {
            of(match array.number {
                Number::Signed => (wide << unused) as i64 >> unused,
                // beyond 63 bits it is no number of anything
                _ => i64::try_from(wide).unwrap_or(i64::MAX),
            })
        };
        let eight = |b: &[u8; 8]| if self.big { u64::from_be_bytes(*b) } else { u64::from_le_bytes(*b) };
        let four = |b: &[u8; 4]| u64::from(if self.big { u32::from_be_bytes(*b) } else { u32::from_le_bytes(*b) });
        let two = |b: &[u8; 2]| u64::from(if self.big { u16::from_be_bytes(*b) } else { u16::from_le_bytes(*b) });
        self.numbers(array, count, |part, values| match array.size {
            8 => values.extend(part.as_chunks().0.iter().map(|b| value(eight(b)))),
            4 => values.extend(part.as_chunks().0.iter().map(|b| value(four(b)))),
            2 => values.extend(part.as_chunks().0.iter().map(|b| value(two(b)))),
            _ => values.extend(part.iter().map(|&byte| value(u64::from(byte)))),
        })
    }

    /// `count` floating point numbers.
    pub(super) fn floats(&self, array: &Array, count: usize) -> Result<Vec<f64>, Error> {
        if let Format::Ascii(text) = array.format {
            return self.words(array, text, count, float);
        }
        if array.number != Number::Float {
            return self.integers(array, count, |x| x as f64);
        }
        let short = |b: &[u8; 4]| f64::from(if self.big { f32::from_be_bytes(*b) } else { f32::from_le_bytes(*b) });
        let long = |b: &[u8; 8]| if self.big { f64::from_be_bytes(*b) } else { f64::from_le_bytes(*b) };
        self.numbers(array, count, |part, values| match array.size {
            4 => values.extend(part.as_chunks().0.iter().map(short)),
            _ => values.extend(part.as_chunks().0.iter().map(long)),
        })
    }

    fn fail(&self, array: &Array, what: String) -> Error {
        Error::new(format!("array \"{}\" (line {})", array.name, array.line), what, DAMAGED)
    }

    /// Text: exactly `count` words.
    fn words<T>(
        &self,
        array: &Array,
        text: &[u8],
        count: usize,
        of: impl Fn(&[u8]) -> Option<T>,
    ) -> Result<Vec<T>, Error> {
        let words = || text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        let wrong = |read: usize| self.fail(array, format!("it holds {read} numbers where {count} are needed"));
        if count > text.len() {
            return Err(wrong(words().count()));
        }
        let (mut values, mut rest) = (Vec::new(), words());
        for word in rest.by_ref().take(count) {
            let Some(value) = of(word) else {
                let shown = String::from_utf8_lossy(&word[..word.len().min(40)]).into_owned();
                return Err(self.fail(array, format!("\"{shown}\" stands where a number was expected")));
            };
            grow(&mut values, 1, count);
            values.push(value);
        }
        let read = values.len() + rest.count();
        if read == count { Ok(values) } else { Err(wrong(read)) }
    }

    /// `count` numbers; `read` appends those whose bytes it is given.
    fn numbers<T: Send>(
        &self,
        array: &Array<'a>,
        count: usize,
        read: impl Fn(&[u8], &mut Vec<T>) + Sync,
    ) -> Result<Vec<T>, Error> {
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
            let mut values = Vec::new();
            let mut left = needed;
            while left > 0 {
                let part = left.min(PART);
                grow(&mut values, part / array.size, count);
                read(&stream.take(part).ok_or_else(ends)?, &mut values);
                left -= part;
            }
            return Ok(values);
        }
        let blocks = self.head(&mut stream).ok_or_else(ends)?;
        if blocks == 0 {
            return checked(0).map(|()| Vec::new());
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
        self.admit(&format!("array \"{}\"", array.name), needed as f64)?;
        let unpacked = |i: usize, packed: &[u8]| {
            let expected = if i + 1 == blocks { last } else { block };
            if expected / ZLIB_MOST > packed.len() {
                return None;
            }
            let mut out = Vec::with_capacity(expected + 1);
            // one more byte than there may be, so that a longer block is seen
            let read = ZlibDecoder::new(packed).take(expected as u64 + 1).read_to_end(&mut out);
            (read.is_ok() && out.len() == expected).then_some(out)
        };
        let is_whole = block % array.size == 0;
        let decoded = |i: usize, packed: &[u8]| {
            let bytes = unpacked(i, packed)?;
            if !is_whole {
                return Some((bytes, Vec::new()));
            }
            let mut values = Vec::with_capacity(bytes.len() / array.size);
            read(&bytes, &mut values);
            Some((Vec::new(), values))
        };
        let mut values = Vec::new();
        // A number may go on in the next block.
        let mut rest: Vec<u8> = Vec::new();
        // By all threads, and no more at a time than they need: whole arrays would take memory twice.
        let at_once = rayon::current_num_threads().max(TOGETHER / block.max(1));
        for (group, sizes) in sizes.chunks(at_once).enumerate() {
            let packed = sizes.iter().map(|&size| stream.take(size)).collect::<Option<Vec<_>>>().ok_or_else(ends)?;
            let first = group * at_once;
            let parts: Vec<_> = packed.par_iter().enumerate().map(|(k, packed)| decoded(first + k, packed)).collect();
            for (i, part) in (first..).zip(parts) {
                let Some((bytes, mut part)) = part else {
                    return Err(self.fail(array, format!("block {i} of its compressed data is damaged")));
                };
                if values.is_empty() {
                    values = part;
                } else {
                    grow(&mut values, part.len(), count);
                    values.append(&mut part);
                }
                rest.extend_from_slice(&bytes);
                let whole = rest.len() - rest.len() % array.size;
                grow(&mut values, whole / array.size, count);
                read(&rest[..whole], &mut values);
                rest.drain(..whole);
            }
        }
        Ok(values)
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
