//! Numbers of arrays.

use std::borrow::Cow;
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
        let mut give = |wide: u64| {
            push(match array.number {
                Number::Signed => (wide << unused) as i64 >> unused,
                // beyond 63 bits it is no number of anything
                _ => i64::try_from(wide).unwrap_or(i64::MAX),
            });
        };
        let eight = |b: &[u8; 8]| if self.big { u64::from_be_bytes(*b) } else { u64::from_le_bytes(*b) };
        let four = |b: &[u8; 4]| u64::from(if self.big { u32::from_be_bytes(*b) } else { u32::from_le_bytes(*b) });
        let two = |b: &[u8; 2]| u64::from(if self.big { u16::from_be_bytes(*b) } else { u16::from_le_bytes(*b) });
        self.numbers(array, count, &mut |part| match array.size {
            8 => part.as_chunks().0.iter().map(eight).for_each(&mut give),
            4 => part.as_chunks().0.iter().map(four).for_each(&mut give),
            2 => part.as_chunks().0.iter().map(two).for_each(&mut give),
            _ => part.iter().map(|&byte| u64::from(byte)).for_each(&mut give),
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
        let short = |b: &[u8; 4]| f64::from(if self.big { f32::from_be_bytes(*b) } else { f32::from_le_bytes(*b) });
        let long = |b: &[u8; 8]| if self.big { f64::from_be_bytes(*b) } else { f64::from_le_bytes(*b) };
        self.numbers(array, count, &mut |part| {
            let mut push = |x| {
                grow(&mut values, count);
                values.push(x);
            };
            if array.size == 4 {
                part.as_chunks().0.iter().map(short).for_each(&mut push);
            } else {
                part.as_chunks().0.iter().map(long).for_each(&mut push);
            }
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

    /// The bytes of `count` numbers, given to `visit` as they are decoded: some whole numbers each time.
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
                visit(&stream.take(part).ok_or_else(ends)?);
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
        let unpacked = |(i, packed): (usize, &Cow<[u8]>)| {
            let expected = if i + 1 == blocks { last } else { block };
            // The promise alone takes no memory out of proportion.
            let mut out = Vec::with_capacity((expected + 1).min(8 * packed.len()));
            // one more byte than there may be, so that a longer block is seen
            let read = ZlibDecoder::new(&**packed).take(expected as u64 + 1).read_to_end(&mut out);
            (read.is_ok() && out.len() == expected).then_some(out)
        };
        let mut out: Vec<u8> = Vec::new();
        // By all threads, and no more at a time than they need: whole arrays would take memory twice.
        let at_once = rayon::current_num_threads().max(TOGETHER / block.max(1));
        for (group, sizes) in sizes.chunks(at_once).enumerate() {
            let packed = sizes.iter().map(|&size| stream.take(size)).collect::<Option<Vec<_>>>().ok_or_else(ends)?;
            let first = group * at_once;
            let parts: Vec<_> =
                packed.par_iter().enumerate().map(|(k, packed)| unpacked((first + k, packed))).collect();
            for (i, part) in (first..).zip(parts) {
                let Some(part) = part else {
                    return Err(self.fail(array, format!("block {i} of its compressed data is damaged")));
                };
                if out.is_empty() && part.len() % array.size == 0 {
                    visit(&part);
                    continue;
                }
                out.extend_from_slice(&part);
                let whole = out.len() - out.len() % array.size;
                visit(&out[..whole]);
                out.drain(..whole); // a number may go on in the next block
            }
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
