//! Named arrays in one file (`.npz`), as `numpy.load` reads them.
//!
//! Reading trusts nothing: a damaged file is an error, and no number in it makes us reserve more than its size.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fmt::Display;
use std::fs::{self, File};
use std::io::{self, BufReader, Read, Seek, Write};
use std::ops::Range;
use std::path::Path;

use memchr::memmem;
use zip::read::read_zipfile_from_stream;
use zip::result::ZipError;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

use super::replace::Pending;
use crate::Error;

/// Numbers of one kind. What is written is borrowed where that can be: the matrix of a large problem is not copied.
#[derive(Debug, Clone, PartialEq)]
pub enum Data<'a> {
    /// `<f8`.
    F64(Cow<'a, [f64]>),
    /// `<i8`.
    I64(Vec<i64>),
    /// `<u4`.
    U32(Cow<'a, [u32]>),
    /// `|u1`.
    U8(Vec<u8>),
    /// The numbers at these places of a longer list, one part after the other; only written.
    U32Parts(&'a [u32], &'a [Range<usize>]),
    /// Likewise.
    F64Parts(&'a [f64], &'a [Range<usize>]),
}

/// An array with its shape, the last axis running fastest; a scalar has the shape `[]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Array<'a> {
    /// Lengths along its axes; empty for a single number.
    pub shape: Vec<usize>,
    /// Its numbers, row by row.
    pub data: Data<'a>,
}

/// The arrays of a file by their names.
pub type Arrays = BTreeMap<String, Array<'static>>;

impl<'a> Array<'a> {
    /// A list of numbers.
    pub fn f64(values: &'a [f64]) -> Self {
        Array { shape: vec![values.len()], data: Data::F64(values.into()) }
    }

    /// A list of node numbers or the like.
    pub fn u32(values: &'a [u32]) -> Self {
        Array { shape: vec![values.len()], data: Data::U32(values.into()) }
    }

    /// What stands in `parts` of a list, which are within it.
    pub fn u32_parts(values: &'a [u32], parts: &'a [Range<usize>]) -> Self {
        Array { shape: vec![parts.iter().map(Range::len).sum()], data: Data::U32Parts(values, parts) }
    }

    /// A list of counts or positions.
    pub fn usize(values: &[usize]) -> Self {
        Array { shape: vec![values.len()], data: Data::I64(values.iter().map(|&v| v as i64).collect()) }
    }

    /// A list of numbers that is given away.
    pub(crate) fn f64_owned(values: Vec<f64>) -> Array<'static> {
        Array { shape: vec![values.len()], data: Data::F64(values.into()) }
    }

    /// What stands in `parts` of a list, which are within it.
    pub(crate) fn f64_parts(values: &'a [f64], parts: &'a [Range<usize>]) -> Self {
        Array { shape: vec![parts.iter().map(Range::len).sum()], data: Data::F64Parts(values, parts) }
    }

    /// One number.
    pub fn scalar(value: f64) -> Self {
        Array { shape: Vec::new(), data: Data::F64(vec![value].into()) }
    }

    /// One count.
    pub fn count(value: usize) -> Self {
        Array { shape: Vec::new(), data: Data::I64(vec![value as i64]) }
    }

    /// A short text as its bytes in UTF-8.
    pub fn text(text: &str) -> Self {
        Array { shape: vec![text.len()], data: Data::U8(text.as_bytes().to_vec()) }
    }

    fn len(&self) -> usize {
        match &self.data {
            Data::F64(v) => v.len(),
            Data::I64(v) => v.len(),
            Data::U32(v) => v.len(),
            Data::U8(v) => v.len(),
            Data::U32Parts(_, parts) | Data::F64Parts(_, parts) => parts.iter().map(Range::len).sum(),
        }
    }

    fn kind(&self) -> &'static str {
        match &self.data {
            Data::F64(_) | Data::F64Parts(..) => "float64",
            Data::I64(_) => "int64",
            Data::U32(_) | Data::U32Parts(..) => "uint32",
            Data::U8(_) => "uint8",
        }
    }
}

/// Writes the arrays, stored without compression. Equal arrays make equal files.
///
/// # Errors
/// If the file cannot be written.
pub fn write(path: &Path, arrays: &[(&str, Array)]) -> Result<(), Error> {
    begin(path, arrays)?.commit()
}

/// The same up to giving the file its name.
pub(crate) fn begin<S: AsRef<str> + PartialEq + Display>(path: &Path, arrays: &[(S, Array)]) -> Result<Pending, Error> {
    for (i, (name, array)) in arrays.iter().enumerate() {
        let place = || path.display().to_string();
        if array.shape.iter().try_fold(1usize, |n, &k| n.checked_mul(k)) != Some(array.len()) {
            let what = format!("array \"{name}\" has {} numbers but the shape {:?}", array.len(), array.shape);
            return Err(Error::new(place(), what, "give a shape whose product is the number of numbers"));
        }
        if arrays[..i].iter().any(|(other, _)| other == name) {
            return Err(Error::new(place(), format!("two arrays are called \"{name}\""), "rename one of them"));
        }
    }
    Pending::write(path, |file| {
        let mut archive = ZipWriter::new(Quiet { to: file, at: 0, failed: false });
        for (name, array) in arrays {
            let (shape, to) = (&array.shape[..], (&mut archive, &format!("{name}.npy")[..]));
            match &array.data {
                Data::F64(v) => put(to, shape, [&v[..]].into_iter())?,
                Data::I64(v) => put(to, shape, [&v[..]].into_iter())?,
                Data::U32(v) => put(to, shape, [&v[..]].into_iter())?,
                Data::U8(v) => put(to, shape, [&v[..]].into_iter())?,
                Data::U32Parts(v, parts) => put(to, shape, parts.iter().map(|part| &v[part.clone()]))?,
                Data::F64Parts(v, parts) => put(to, shape, parts.iter().map(|part| &v[part.clone()]))?,
            }
        }
        archive.finish()?;
        Ok(())
    })
}

/// A file that, once it could not be written, takes whatever else comes: an archive that is dropped before its end tries to end itself, and
/// prints what it meets.
struct Quiet<W> {
    to: W,
    /// Where the next byte goes, or would go.
    at: u64,
    failed: bool,
}

impl<W> Quiet<W> {
    fn attempt<T>(&mut self, otherwise: T, act: impl FnOnce(&mut W) -> io::Result<T>) -> io::Result<T> {
        if self.failed {
            return Ok(otherwise);
        }
        let done = act(&mut self.to);
        self.failed = done.as_ref().is_err_and(|error| error.kind() != io::ErrorKind::Interrupted);
        done
    }
}

impl<W: Write> Write for Quiet<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.attempt(bytes.len(), |to| to.write(bytes))?;
        self.at += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.attempt((), Write::flush)
    }
}

impl<W: Seek> Seek for Quiet<W> {
    fn seek(&mut self, place: io::SeekFrom) -> io::Result<u64> {
        let otherwise = match place {
            io::SeekFrom::Start(at) => at,
            io::SeekFrom::Current(by) => self.at.saturating_add_signed(by),
            io::SeekFrom::End(_) => self.at,
        };
        self.at = self.attempt(otherwise, |to| to.seek(place))?;
        Ok(self.at)
    }
}

/// Numbers as the file stores them, little endian.
trait Number: Copy {
    const KIND: &str;
    /// Fills `bytes`, which is as long as `numbers` are.
    fn store(numbers: &[Self], bytes: &mut [u8]);
}

macro_rules! number {
    ($type:ty, $kind:literal) => {
        impl Number for $type {
            const KIND: &str = $kind;
            fn store(numbers: &[Self], bytes: &mut [u8]) {
                let places = bytes.as_chunks_mut().0;
                places.iter_mut().zip(numbers).for_each(|(place, number)| *place = number.to_le_bytes());
            }
        }
    };
}
number!(f64, "<f8");
number!(i64, "<i8");
number!(u32, "<u4");
number!(u8, "|u1");

/// Bytes handed on at a time: the archive takes its check sum over them, and they stay in the cache meanwhile.
const PIECE: usize = 1 << 18;

/// One array in the format of numpy as an entry of an archive, its numbers given in parts that fill the shape.
fn put<'a, T: Number + 'a, W: Write + Seek>(
    (archive, name): (&mut ZipWriter<W>, &str),
    shape: &[usize],
    parts: impl Iterator<Item = &'a [T]>,
) -> io::Result<()> {
    let header = header(T::KIND, shape);
    let size = header.len() + shape.iter().product::<usize>() * size_of::<T>();
    let stored = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .large_file(u32::try_from(size).is_err())
        // The same whenever it is written: equal arrays make equal files.
        .last_modified_time(DateTime::default());
    archive.start_file(name, stored)?;
    archive.write_all(&header)?;
    let (mut piece, mut filled) = (vec![0; PIECE], 0);
    for mut part in parts {
        while !part.is_empty() {
            let (now, later) = part.split_at(part.len().min((PIECE - filled) / size_of::<T>()));
            let bytes = size_of_val(now);
            T::store(now, &mut piece[filled..filled + bytes]);
            (part, filled) = (later, filled + bytes);
            if filled == PIECE {
                archive.write_all(&piece)?;
                filled = 0;
            }
        }
    }
    archive.write_all(&piece[..filled])
}

/// What comes before the numbers: its length is a multiple of 64.
fn header(kind: &str, shape: &[usize]) -> Vec<u8> {
    let lengths: String = shape.iter().map(|n| format!("{n}, ")).collect();
    let comma = if shape.len() == 1 { "," } else { "" };
    let lengths = lengths.trim_end_matches(", ");
    let text = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({lengths}{comma}), }}");
    let length = (10 + text.len() + 1).next_multiple_of(64) - 10;
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((length as u16).to_le_bytes());
    bytes.extend(text.bytes().chain(std::iter::repeat_n(b' ', length - text.len() - 1)).chain([b'\n']));
    bytes
}

/// Reads all arrays of a file written by [`write()`] or by `numpy.savez`.
///
/// # Errors
/// If the file cannot be read or is no archive of arrays.
pub fn read(path: &Path) -> Result<Arrays, Error> {
    let open = || -> io::Result<_> { Ok((fs::metadata(path)?.len(), File::open(path)?)) };
    let (size, file) = open().map_err(|error| super::unreadable(path, &error))?;
    archive(BufReader::new(file), size).map_err(|error| error.at(&path.display().to_string()))
}

/// The same from the bytes of a file.
///
/// # Errors
/// If they are no archive of arrays.
pub fn parse(bytes: &[u8]) -> Result<Arrays, Error> {
    archive(io::Cursor::new(bytes), bytes.len() as u64)
}

fn damaged(what: String) -> Error {
    Error::new("", what, "the file is damaged or incomplete; write it again")
}

fn archive(mut file: impl Read, size: u64) -> Result<Arrays, Error> {
    let (mut arrays, mut entries, mut left) = (BTreeMap::new(), 0usize, size);
    // From the beginning to the end: for the entries that a directory announces `ZipArchive` reserves memory at once.
    loop {
        let entry = read_zipfile_from_stream(&mut file).map_err(|e| match e {
            ZipError::UnsupportedArchive(_) | ZipError::CompressionMethodNotSupported(_) => {
                let what = "an array is compressed or encrypted, or its length does not stand before it".to_string();
                Error::new("", what, "write it without compression (numpy.savez) to a file, not to a pipe")
            }
            e if entries == 0 => damaged(format!("not an npz file ({e})")),
            e => damaged(format!("the array after {entries} others cannot be read ({e})")),
        })?;
        let Some(mut entry) = entry else { break };
        entries += 1;
        let Some(name) = entry.name().strip_suffix(".npy").map(str::to_string) else { continue };
        let unreadable = |e: &dyn std::fmt::Display| damaged(format!("array \"{name}\" cannot be read ({e})"));
        let larger = || damaged("its arrays are larger than it is".to_string());
        left = left.checked_sub(entry.size()).ok_or_else(larger)?;
        let mut bytes = Vec::with_capacity(usize::try_from(entry.size()).map_err(|e| unreadable(&e))?);
        entry.read_to_end(&mut bytes).map_err(|e| unreadable(&e))?;
        let array = npy(&bytes).map_err(|e| Error { what: format!("array \"{name}\": {}", e.what), ..e })?;
        arrays.insert(name, array);
    }
    // The last record of the directory tells how many entries there are: nothing is cut off, nothing left out.
    let mut directory = Vec::new();
    file.read_to_end(&mut directory).map_err(|e| damaged(format!("its directory cannot be read ({e})")))?;
    let end = memmem::rfind(&directory, b"PK\x05\x06").and_then(|at| directory[at..].get(..22));
    if end.map(|end| &end[10..12]) != Some(&(entries.min(0xffff) as u16).to_le_bytes()[..]) {
        return Err(damaged(format!("its directory does not end after {entries} arrays")));
    }
    Ok(arrays)
}

/// An array from the bytes of a `.npy` file: magic, version, length of the header, header, numbers.
///
/// Format: <https://numpy.org/doc/stable/reference/generated/numpy.lib.format.html>. The header is read here and not
/// by a reader of Python literals, whose recursion a hostile file can drive to the end of the stack.
fn npy(bytes: &[u8]) -> Result<Array<'static>, Error> {
    let short = || damaged("it ends within its header".to_string());
    if !bytes.starts_with(b"\x93NUMPY") {
        return Err(damaged("it is not in the npy format".to_string()));
    }
    let (length, rest) = match bytes.get(6..).ok_or_else(short)? {
        [1, _, a, b, rest @ ..] => (usize::from(u16::from_le_bytes([*a, *b])), rest),
        [2 | 3, _, a, b, c, d, rest @ ..] => (u32::from_le_bytes([*a, *b, *c, *d]) as usize, rest),
        _ => return Err(short()),
    };
    let (header, numbers) = rest.split_at_checked(length).ok_or_else(short)?;
    let header = str::from_utf8(header).map_err(|_| damaged("its header is not text".to_string()))?;
    let value =
        |key: &str| -> Option<&str> { header.split_once(&format!("'{key}':")).map(|(_, rest)| rest.trim_start()) };
    let no = |key: &str| damaged(format!("its header gives no {key}"));
    let kind = value("descr").and_then(|v| v.strip_prefix('\'')?.split('\'').next()).ok_or_else(|| no("descr"))?;
    let shape = value("shape").and_then(|v| v.strip_prefix('(')?.split_once(')')).ok_or_else(|| no("shape"))?.0;
    let shape: Vec<usize> = shape
        .split(',')
        .map(str::trim)
        .filter(|n| !n.is_empty())
        .map(|n| n.parse().map_err(|_| damaged(format!("its shape ({shape}) is not a list of lengths"))))
        .collect::<Result<_, _>>()?;
    let by_columns = value("fortran_order").ok_or_else(|| no("fortran_order"))?.starts_with("True");
    let width = match kind {
        "<f8" | "<i8" => 8,
        "<f4" | "<u4" | "<i4" => 4,
        "|u1" => 1,
        _ => {
            let what = format!("its numbers are of kind {kind}, not one of <f8 <f4 <i8 <i4 <u4 |u1");
            return Err(Error::new("", what, "store it as one of these, for instance by astype(float) of numpy"));
        }
    };
    if shape.iter().try_fold(width, |n: usize, &k| n.checked_mul(k)) != Some(numbers.len()) {
        return Err(damaged(format!("its shape ({shape:?}) does not fit its {} bytes", numbers.len())));
    }
    let numbers = if by_columns && shape.len() > 1 { by_rows(numbers, width, &shape) } else { numbers.into() };
    let data = match kind {
        "<f8" => Data::F64(numbers.as_chunks().0.iter().map(|b| f64::from_le_bytes(*b)).collect()),
        "<f4" => Data::F64(numbers.as_chunks().0.iter().map(|b| f64::from(f32::from_le_bytes(*b))).collect()),
        "<i8" => Data::I64(numbers.as_chunks().0.iter().map(|b| i64::from_le_bytes(*b)).collect()),
        "<i4" => Data::I64(numbers.as_chunks().0.iter().map(|b| i64::from(i32::from_le_bytes(*b))).collect()),
        "<u4" => Data::U32(numbers.as_chunks().0.iter().map(|b| u32::from_le_bytes(*b)).collect()),
        _ => Data::U8(numbers.into_owned()),
    };
    Ok(Array { shape, data })
}

/// Numbers of `width` bytes whose first axis runs fastest, with the last running fastest; their count is that of the shape.
fn by_rows<'a>(numbers: &[u8], width: usize, shape: &[usize]) -> Cow<'a, [u8]> {
    let mut index = vec![0; shape.len()];
    let mut rows = Vec::with_capacity(numbers.len());
    for _ in 0..numbers.len() / width {
        let place = index.iter().zip(shape).rev().fold(0, |place, (i, length)| place * length + i);
        rows.extend_from_slice(&numbers[width * place..][..width]);
        for (i, length) in index.iter_mut().zip(shape).rev() {
            *i += 1;
            if *i < *length {
                break;
            }
            *i = 0;
        }
    }
    rows.into()
}

/// The array called `name`.
///
/// # Errors
/// If there is no such array.
pub fn get<'a>(arrays: &'a Arrays, name: &str) -> Result<&'a Array<'static>, Error> {
    arrays.get(name).ok_or_else(|| {
        let present = arrays.keys().map(String::as_str).collect::<Vec<_>>().join(", ");
        let present =
            if present.is_empty() { "the file has no arrays".to_string() } else { format!("it has {present}") };
        Error::new("", format!("there is no array \"{name}\""), present)
    })
}

fn wrong(name: &str, array: &Array, wanted: &str) -> Error {
    let what = format!("array \"{name}\" holds {} of shape {:?}", array.kind(), array.shape);
    Error::new("", what, format!("{wanted} expected"))
}

/// A list of `float64`, of length `len` if given.
///
/// # Errors
/// If there is no such array, or it has another type or length.
pub fn f64s<'a>(arrays: &'a Arrays, name: &str, len: Option<usize>) -> Result<&'a [f64], Error> {
    let array = get(arrays, name)?;
    match &array.data {
        Data::F64(v) if array.shape.len() == 1 && len.is_none_or(|n| n == v.len()) => Ok(v),
        _ => Err(wrong(name, array, &list("float64", len))),
    }
}

/// A list of `uint32`, of length `len` if given.
///
/// # Errors
/// If there is no such array, or it has another type or length.
pub fn u32s<'a>(arrays: &'a Arrays, name: &str, len: Option<usize>) -> Result<&'a [u32], Error> {
    let array = get(arrays, name)?;
    match &array.data {
        Data::U32(v) if array.shape.len() == 1 && len.is_none_or(|n| n == v.len()) => Ok(v),
        _ => Err(wrong(name, array, &list("uint32", len))),
    }
}

/// A list of counts, stored as `int64`, none negative; of length `len` if given.
///
/// # Errors
/// If there is no such array, it has another type or length, or a number is negative.
pub fn usizes(arrays: &Arrays, name: &str, len: Option<usize>) -> Result<Vec<usize>, Error> {
    let array = get(arrays, name)?;
    let counts = match &array.data {
        Data::I64(v) if array.shape.len() == 1 && len.is_none_or(|n| n == v.len()) => {
            v.iter().map(|&n| usize::try_from(n).ok()).collect()
        }
        _ => None,
    };
    counts.ok_or_else(|| wrong(name, array, &(list("int64", len) + ", none negative,")))
}

/// One number.
///
/// # Errors
/// If there is no such array or it is not one number.
pub fn scalar(arrays: &Arrays, name: &str) -> Result<f64, Error> {
    let array = get(arrays, name)?;
    match &array.data {
        Data::F64(v) if v.len() == 1 => Ok(v[0]),
        _ => Err(wrong(name, array, "one float64")),
    }
}

/// One count.
///
/// # Errors
/// If there is no such array or it is not one whole number.
pub fn count(arrays: &Arrays, name: &str) -> Result<usize, Error> {
    let array = get(arrays, name)?;
    let count = match &array.data {
        Data::I64(v) if v.len() == 1 => usize::try_from(v[0]).ok(),
        _ => None,
    };
    count.ok_or_else(|| wrong(name, array, "one int64 that is not negative"))
}

/// A text.
///
/// # Errors
/// If there is no such array or it is not UTF-8.
pub fn text<'a>(arrays: &'a Arrays, name: &str) -> Result<&'a str, Error> {
    let array = get(arrays, name)?;
    let text = if let Data::U8(v) = &array.data { str::from_utf8(v).ok() } else { None };
    text.ok_or_else(|| wrong(name, array, "uint8 that spell a text in UTF-8"))
}

fn list(kind: &str, len: Option<usize>) -> String {
    len.map_or(format!("a list of {kind}"), |n| format!("a list of {n} {kind}"))
}

#[cfg(test)]
#[path = "npz_tests.rs"]
mod tests;
