//! Files stored in a zip archive without compression (PKWARE, APPNOTE 4.3).

use std::io::{self, Read, Seek, SeekFrom, Write};

use crc32fast::Hasher;

/// What each record begins with.
const LOCAL: &[u8] = b"PK\x03\x04";
const ENTRY: &[u8] = b"PK\x01\x02";
const WIDE_END: &[u8] = b"PK\x06\x06";
const LOCATOR: &[u8] = b"PK\x06\x07";
const END: &[u8] = b"PK\x05\x06";

/// Lengths of the records, without names and comments, in bytes.
const LOCAL_LENGTH: usize = 30;
const ENTRY_LENGTH: usize = 46;
const WIDE_END_LENGTH: usize = 56;
const LOCATOR_LENGTH: usize = 20;
const END_LENGTH: usize = 22;

/// Version of the format that has the wider fields.
const VERSION: u16 = 45;

/// Marks the extra field that holds the numbers too large for the record itself.
const WIDE: u16 = 1;

/// A file in the archive.
#[derive(Debug)]
pub(super) struct Entry {
    pub name: String,
    /// Neither compressed nor encrypted.
    pub is_plain: bool,
    /// Bytes.
    pub size: u64,
    crc: u32,
    /// Where its local header stands, bytes from the start of the archive.
    at: u64,
}

fn damaged(what: impl Into<String>) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, what.into())
}

/// The little-endian number of `N` bytes at this place; callers check the length of the record.
fn field<const N: usize>(record: &[u8], at: usize) -> u64 {
    record[at..at + N].iter().rev().fold(0, |number, &byte| number << 8 | u64::from(byte))
}

/// The `length` bytes at this place of an archive of `size` bytes; no number of a damaged file reserves more.
fn bytes_at(file: &mut (impl Read + Seek), size: u64, at: u64, length: u64) -> io::Result<Vec<u8>> {
    if at.checked_add(length).is_none_or(|end| end > size) {
        return Err(damaged("a part of it would lie beyond its end"));
    }
    let mut bytes = Vec::with_capacity(usize::try_from(length).map_err(|_| damaged("it does not fit into memory"))?);
    file.seek(SeekFrom::Start(at))?;
    file.take(length).read_to_end(&mut bytes)?;
    if bytes.len() as u64 == length { Ok(bytes) } else { Err(damaged("it ends early")) }
}

/// The entries that the directory at the end of an archive of `size` bytes lists; together they are no larger than it.
pub(super) fn directory(file: &mut (impl Read + Seek), size: u64) -> io::Result<Vec<Entry>> {
    let longest = (END_LENGTH + usize::from(u16::MAX) + LOCATOR_LENGTH) as u64;
    let tail = bytes_at(file, size, size.saturating_sub(longest), size.min(longest))?;
    let ends = tail.len().checked_sub(END_LENGTH).ok_or_else(|| damaged("it is too short"))?;
    let at = (0..=ends).rev().find(|&at| tail[at..].starts_with(END)).ok_or_else(|| damaged("it has no end record"))?;
    let end = &tail[at..];
    let (mut count, mut length, mut start) = (field::<2>(end, 10), field::<4>(end, 12), field::<4>(end, 16));
    let locator = at.checked_sub(LOCATOR_LENGTH).map(|at| &tail[at..]).filter(|record| record.starts_with(LOCATOR));
    if let Some(locator) = locator {
        let wide = bytes_at(file, size, field::<8>(locator, 8), WIDE_END_LENGTH as u64)?;
        if !wide.starts_with(WIDE_END) {
            return Err(damaged("the wide end record is not where its locator says"));
        }
        (count, length, start) = (field::<8>(&wide, 32), field::<8>(&wide, 40), field::<8>(&wide, 48));
    }
    let records = bytes_at(file, size, start, length)?;
    let (mut rest, mut entries, mut left) = (&records[..], Vec::new(), size);
    while !rest.is_empty() {
        let entry;
        (entry, rest) = Entry::parse(rest)?;
        // Entries that share their bytes would take memory out of proportion.
        let taken = if entry.is_plain { entry.size } else { 0 };
        left = left.checked_sub(taken).ok_or_else(|| damaged("its entries are larger than it is"))?;
        entries.push(entry);
    }
    if entries.len() as u64 == count {
        return Ok(entries);
    }
    Err(damaged(format!("it announces {count} entries and lists {}", entries.len())))
}

impl Entry {
    /// The entry that the directory begins with, and the rest of the directory.
    fn parse(directory: &[u8]) -> io::Result<(Entry, &[u8])> {
        let cut = || damaged("its directory ends within an entry");
        let (record, rest) = directory.split_at_checked(ENTRY_LENGTH).ok_or_else(cut)?;
        if !record.starts_with(ENTRY) {
            return Err(damaged("its directory is no list of entries"));
        }
        let (name, rest) = rest.split_at_checked(field::<2>(record, 28) as usize).ok_or_else(cut)?;
        let (mut extra, rest) = rest.split_at_checked(field::<2>(record, 30) as usize).ok_or_else(cut)?;
        let (_, rest) = rest.split_at_checked(field::<2>(record, 32) as usize).ok_or_else(cut)?;
        // Size, packed size and place, in the order in which the extra field gives what does not fit here.
        let mut numbers = [24, 20, 42].map(|at| field::<4>(record, at));
        while let Some((head, after)) = extra.split_at_checked(4) {
            let (value, after) = after.split_at_checked(field::<2>(head, 2) as usize).ok_or_else(cut)?;
            if field::<2>(head, 0) == u64::from(WIDE) {
                let missing = numbers.iter_mut().filter(|number| **number == u64::from(u32::MAX));
                missing.zip(value.as_chunks::<8>().0).for_each(|(number, b)| *number = u64::from_le_bytes(*b));
            }
            extra = after;
        }
        let [size, packed, at] = numbers;
        let is_encrypted = field::<2>(record, 8) & 1 != 0;
        let is_stored = field::<2>(record, 10) == 0;
        if is_stored && packed != size {
            return Err(damaged("the two sizes of an entry differ"));
        }
        let name = String::from_utf8_lossy(name).into_owned();
        Ok((Entry { name, is_plain: is_stored && !is_encrypted, size, crc: field::<4>(record, 16) as u32, at }, rest))
    }

    /// The bytes of this entry, which must be plain, in an archive of `size` bytes.
    pub(super) fn read(&self, file: &mut (impl Read + Seek), size: u64) -> io::Result<Vec<u8>> {
        let head = bytes_at(file, size, self.at, LOCAL_LENGTH as u64)?;
        if !head.starts_with(LOCAL) {
            return Err(damaged("it is not where the directory says"));
        }
        // No overflow: the header lies within the file.
        let start = self.at + LOCAL_LENGTH as u64 + field::<2>(&head, 26) + field::<2>(&head, 28);
        let bytes = bytes_at(file, size, start, self.size)?;
        if crc32fast::hash(&bytes) == self.crc { Ok(bytes) } else { Err(damaged("its check sum is wrong")) }
    }

    /// What the local header and the directory say alike; `wide` are the bytes of the extra field.
    fn common(&self, wide: &[u8]) -> Vec<u8> {
        const UTF_8: u16 = 1 << 11;
        const STORED: u16 = 0;
        const TIME: u16 = 0;
        /// 1 January 1980: equal arrays make equal files.
        const DATE: u16 = 1 << 5 | 1;
        let small = [VERSION, if self.name.is_ascii() { 0 } else { UTF_8 }, STORED, TIME, DATE];
        let lengths = [self.name.len() as u16, wide.len() as u16];
        let large = [self.crc, narrow(self.size), narrow(self.size)];
        let bytes = small.into_iter().flat_map(u16::to_le_bytes).chain(large.into_iter().flat_map(u32::to_le_bytes));
        bytes.chain(lengths.into_iter().flat_map(u16::to_le_bytes)).collect()
    }

    fn local(&self) -> Vec<u8> {
        let wide = wide(&[self.size; 2]);
        [LOCAL, &self.common(&wide), self.name.as_bytes(), &wide].concat()
    }

    fn listed(&self) -> Vec<u8> {
        let wide = wide(&[self.size, self.size, self.at]);
        let made_by = VERSION.to_le_bytes();
        // No comment, on the first disk, no attributes.
        let rest = [0; 10];
        let at = narrow(self.at).to_le_bytes();
        [ENTRY, &made_by, &self.common(&wide), &rest, &at, self.name.as_bytes(), &wide].concat()
    }
}

/// The number, or the mark that it stands in the extra field.
fn narrow(number: u64) -> u32 {
    u32::try_from(number).unwrap_or(u32::MAX)
}

/// The extra field with those of the numbers that do not fit into 32 bits; empty without any.
fn wide(numbers: &[u64]) -> Vec<u8> {
    let large: Vec<u8> = numbers.iter().filter(|&&n| narrow(n) == u32::MAX).flat_map(|n| n.to_le_bytes()).collect();
    if large.is_empty() {
        return large;
    }
    [&WIDE.to_le_bytes(), &(large.len() as u16).to_le_bytes(), &large[..]].concat()
}

/// An archive under way in a file that was empty.
pub(super) struct Writer<'a, W> {
    file: &'a mut W,
    at: u64,
    entries: Vec<Entry>,
}

impl<'a, W: Write + Seek> Writer<'a, W> {
    pub(super) fn new(file: &'a mut W) -> Self {
        Writer { file, at: 0, entries: Vec::new() }
    }

    /// An entry of `size` bytes, which `fill` writes. The name is shorter than 64 KiB.
    pub(super) fn entry(
        &mut self,
        name: &str,
        size: u64,
        fill: impl FnOnce(&mut Summed<W>) -> io::Result<()>,
    ) -> io::Result<()> {
        /// Where the check sum stands in a local header.
        const CRC: u64 = 14;
        let mut entry = Entry { name: name.to_string(), is_plain: true, size, crc: 0, at: self.at };
        let head = entry.local();
        self.file.write_all(&head)?;
        let mut body = Summed { file: &mut *self.file, sum: Hasher::new(), bytes: 0 };
        fill(&mut body)?;
        debug_assert_eq!(body.bytes, size, "{name}");
        entry.crc = body.sum.finalize();
        self.file.seek(SeekFrom::Start(entry.at + CRC))?;
        self.file.write_all(&entry.crc.to_le_bytes())?;
        self.at += head.len() as u64 + size;
        self.file.seek(SeekFrom::Start(self.at))?;
        self.entries.push(entry);
        Ok(())
    }

    /// Writes the directory.
    pub(super) fn finish(self) -> io::Result<()> {
        let records: Vec<u8> = self.entries.iter().flat_map(Entry::listed).collect();
        self.file.write_all(&records)?;
        let (count, length, start) = (self.entries.len() as u64, records.len() as u64, self.at);
        let few = u16::try_from(count).unwrap_or(u16::MAX);
        if few == u16::MAX || narrow(start + length) == u32::MAX {
            let versions = [VERSION; 2].map(u16::to_le_bytes);
            let numbers = [count, count, length, start].map(u64::to_le_bytes);
            let bytes = (WIDE_END_LENGTH as u64 - 12).to_le_bytes();
            let wide = [WIDE_END, &bytes, versions.as_flattened(), &[0; 8], numbers.as_flattened()].concat();
            self.file.write_all(&wide)?;
            let at = (start + length).to_le_bytes();
            self.file.write_all(&[LOCATOR, &[0; 4], &at, &1u32.to_le_bytes()].concat())?;
        }
        let (few, large) = ([few; 2].map(u16::to_le_bytes), [length, start].map(|n| narrow(n).to_le_bytes()));
        self.file.write_all(&[END, &[0; 4], few.as_flattened(), large.as_flattened(), &[0; 2]].concat())
    }
}

/// The file of an entry under way, with the check sum of what was written.
pub(super) struct Summed<'a, W> {
    file: &'a mut W,
    sum: Hasher,
    bytes: u64,
}

impl<W: Write> Write for Summed<'_, W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.file.write(bytes)?;
        self.sum.update(&bytes[..written]);
        self.bytes += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn archive(files: &[(&str, &[u8])]) -> Vec<u8> {
        let mut file = io::Cursor::new(Vec::new());
        let mut writer = Writer::new(&mut file);
        files.iter().for_each(|(n, bytes)| writer.entry(n, bytes.len() as u64, |f| f.write_all(bytes)).unwrap());
        writer.finish().unwrap();
        file.into_inner()
    }

    fn listed(bytes: &[u8]) -> io::Result<Vec<Entry>> {
        directory(&mut io::Cursor::new(bytes), bytes.len() as u64)
    }

    #[test]
    fn check_sums_are_those_of_the_standard_and_wrong_ones_are_seen() {
        let mut bytes = archive(&[("a", b"123456789")]);
        // The check value that catalogues of CRC-32 give.
        assert_eq!(bytes[14..18], 0xcbf4_3926u32.to_le_bytes());
        let size = bytes.len() as u64;
        let entries = listed(&bytes).unwrap();
        assert_eq!(entries[0].read(&mut io::Cursor::new(&bytes), size).unwrap(), b"123456789");
        bytes[LOCAL_LENGTH + 3] ^= 1;
        assert!(entries[0].read(&mut io::Cursor::new(&bytes), size).unwrap_err().to_string().contains("check sum"));
    }

    #[test]
    fn numbers_of_more_than_32_bits_stand_in_the_extra_field() {
        let entry = Entry { name: "K".into(), is_plain: true, size: 1 << 33, crc: 7, at: 1 << 34 };
        let bytes = entry.listed();
        let (read, rest) = Entry::parse(&bytes).unwrap();
        assert_eq!((read.size, read.at, read.crc, rest.len()), (entry.size, entry.at, 7, 0));
        assert_eq!((field::<4>(&bytes, 24), field::<4>(&bytes, 42)), (u64::from(u32::MAX), u64::from(u32::MAX)));
        assert_eq!(entry.local().len(), LOCAL_LENGTH + 1 + 20);
        let small = Entry { at: 9, size: 4, ..entry };
        assert_eq!(small.listed().len(), ENTRY_LENGTH + 1);
    }

    #[test]
    fn archives_of_more_entries_than_16_bits_count_are_read_back() {
        let names: Vec<String> = (0..70_000).map(|i| i.to_string()).collect();
        let files: Vec<(&str, &[u8])> = names.iter().map(|n| (n.as_str(), &b"x"[..])).collect();
        let entries = listed(&archive(&files)).unwrap();
        assert!(entries.len() == 70_000 && entries[69_999].name == "69999");
    }

    #[test]
    fn entries_that_share_their_bytes_or_lie_outside_are_refused() {
        let bytes = archive(&[("a", &[1; 500]), ("b", &[2; 500])]);
        let end = bytes.len() - END_LENGTH;
        let start = field::<4>(&bytes, end + 16) as usize;
        let with = |at: usize, value: u32| {
            let mut bytes = bytes.clone();
            bytes[at..at + 4].copy_from_slice(&value.to_le_bytes());
            listed(&bytes)
        };
        assert!(with(end + 12, u32::MAX).is_err() && with(end + 16, u32::MAX).is_err());
        // The directory claims more for one entry than the other leaves.
        let mut greedy = bytes.clone();
        let size = (bytes.len() as u32 - 499).to_le_bytes();
        [20, 24].into_iter().for_each(|at| greedy[start + at..start + at + 4].copy_from_slice(&size));
        assert!(listed(&greedy).unwrap_err().to_string().contains("larger"));
        let moved = with(start + 42, u32::MAX - 1).unwrap();
        assert!(moved[0].read(&mut io::Cursor::new(&bytes), bytes.len() as u64).is_err());
        assert!(listed(&[]).is_err() && listed(END).is_err());
    }
}
