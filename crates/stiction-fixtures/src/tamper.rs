//! Result folders in which one number is changed, or the files of two steps change places: `check` has to notice each.
//!
//! Formats with checksums of their own (the archives of `.npz`, zlib in `.vtu`) get the right ones for the changed number,
//! so that nothing but `check` can notice.

use std::collections::BTreeMap;
use std::ops::{ControlFlow, Range};
use std::path::{Path, PathBuf};

use stiction::io::case;
use stiction::run::{self, Ahead, Origin, Settings};

use crate::case_run::CASE;
use crate::fuzz::Random;

/// A block that is pressed on and then lifted at its end, in five increments.
pub fn stepped_case() -> String {
    let steps =
        "[[step]]\nname = \"press\"\nuntil = 1\nincrements = 2\n[[step]]\nname = \"lift\"\nuntil = 2\nincrements = 3\n";
    CASE.replace("(3 - x)\"", "(3 - x)*min(t, 1)\"")
        .replace("traction = [0, 0, 1e6]", "traction = [0, 0, \"2e6*(t - 1)*(t - 0.5)\"]")
        + steps
}

/// Solves a case into a folder, as the command does.
pub fn solve_into(text: &str, folder: &Path) {
    let case = case::parse(text, "case.toml", &[]).unwrap_or_else(|e| panic!("{e}"));
    let mut prepared = run::prepare(&case).unwrap_or_else(|e| panic!("{e}"));
    let settings = Settings::of(&case.solver);
    let go_on = &mut |_: &run::Event| ControlFlow::Continue(());
    let outcome = if case.steps.is_empty() {
        run::solve(&prepared, &settings, go_on)
    } else {
        let (mut files, _) = run::begin_steps(&prepared, folder, false).unwrap_or_else(|e| panic!("{e}"));
        let mut keep = |prepared: &run::Prepared, step: &run::Step| run::keep_step(&mut files, prepared, step);
        run::solve_steps(&mut prepared, &settings, None, &mut keep, go_on)
    };
    let mut outcome = outcome.unwrap_or_else(|e| panic!("{e}"));
    let origin = Origin { case_text: text.into(), ..Origin::default() };
    let written = run::write_with(&prepared, &mut outcome, &origin, folder, Ahead::default());
    written.and_then(|_| run::write_report(folder)).unwrap_or_else(|e| panic!("{e}"));
}

/// What came of a number of changes.
#[derive(Debug, Default)]
pub struct Report {
    /// Changes of each kind of file.
    pub changes: BTreeMap<String, usize>,
    /// What was changed where `check` passed all the same.
    pub unnoticed: Vec<String>,
}

/// Makes `count` changes in a folder that passes its check, one at a time and each undone. The same seed makes the same
/// changes of the same files.
pub fn campaign(folder: &Path, seed: u64, count: usize) -> Report {
    let mut random = Random(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
    let mut files: Vec<PathBuf> = read_names(folder);
    files.sort();
    let mut report = Report::default();
    while report.changes.values().sum::<usize>() < count {
        let path = &files[random.below(files.len())];
        let other = if random.below(10) == 0 { partner(path, &files, &mut random) } else { None };
        let before = read(path);
        let (kind, what, noticed) = if let Some(other) = other {
            let after = read(other);
            if before == after {
                continue;
            }
            write(path, &after);
            write(other, &before);
            let noticed = notices(folder);
            write(other, &after);
            ("swapped steps".to_string(), format!("{} and {}", name(path), name(other)), noticed)
        } else {
            let Some((bytes, what)) = changed(path, &before, &mut random) else { continue };
            assert!(bytes != before, "{}: {what}", path.display());
            write(path, &bytes);
            (kind(path), format!("{}: {what}", name(path)), notices(folder))
        };
        write(path, &before);
        *report.changes.entry(kind).or_default() += 1;
        if !noticed {
            report.unnoticed.push(what);
        }
    }
    report
}

fn notices(folder: &Path) -> bool {
    run::check(folder).map_or(true, |checked| !checked.passed())
}

fn read_names(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).unwrap_or_else(|e| panic!("{}: {e}", folder.display()));
    entries.flatten().map(|entry| entry.path()).collect()
}

fn read(path: &Path) -> Vec<u8> {
    std::fs::read(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

fn write(path: &Path, bytes: &[u8]) {
    std::fs::write(path, bytes).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
}

fn name(path: &Path) -> String {
    path.file_name().map_or(String::new(), |name| name.to_string_lossy().into_owned())
}

/// The name of a file without the number of its step.
fn kind(path: &Path) -> String {
    name(path).replace(|c: char| c.is_ascii_digit(), "").replace("-.", ".").replace("SHASUMS", "SHA256SUMS")
}

/// The file of the same kind of another step.
fn partner<'a>(path: &Path, files: &'a [PathBuf], random: &mut Random) -> Option<&'a PathBuf> {
    let same: Vec<&PathBuf> = files.iter().filter(|other| *other != path && kind(other) == kind(path)).collect();
    same.get(random.below(same.len())).copied()
}

/// The file with one number changed, and what was done.
fn changed(path: &Path, bytes: &[u8], random: &mut Random) -> Option<(Vec<u8>, String)> {
    match path.extension().and_then(|e| e.to_str()) {
        Some("npz") => change_npz(bytes, random),
        Some("vtu") => change_vtu(bytes, random),
        Some("png") => Some(change_byte(bytes, 0..bytes.len(), random)),
        _ => change_text(bytes, random),
    }
}

fn change_byte(bytes: &[u8], range: Range<usize>, random: &mut Random) -> (Vec<u8>, String) {
    let at = range.start + random.below(range.len());
    let mut bytes = bytes.to_vec();
    bytes[at] = bytes[at].wrapping_add(1 + random.below(255) as u8);
    (bytes, format!("byte {at}"))
}

/// A number that differs from `value` by at least 1e-6 of it.
fn other_number(value: f64, random: &mut Random) -> f64 {
    if !value.is_finite() {
        return 1.0;
    }
    match random.below(20) {
        0 => 0.0 - value - 1.0,
        1 => 2.0 * value + 1.0,
        _ => {
            let part = 1.1 * 10f64.powi(-(random.below(7) as i32)) * if random.below(2) == 0 { 1.0 } else { -1.0 };
            if value == 0.0 { part } else { value * (1.0 + part) }
        }
    }
}

/// One number in a text; words that are numbers in part count as well.
fn change_text(bytes: &[u8], random: &mut Random) -> Option<(Vec<u8>, String)> {
    let text = std::str::from_utf8(bytes).ok()?;
    // From a random place on, the first digit.
    let start = random.below(bytes.len());
    let digit = bytes.iter().skip(start).position(u8::is_ascii_digit)? + start;
    let of_number = |b: &u8| b.is_ascii_digit() || b".eE+-".contains(b);
    let first = digit - bytes[..digit].iter().rev().take_while(|b| of_number(b)).count();
    let last = digit + bytes[digit..].iter().take_while(|b| of_number(b)).count();
    let token = text.get(first..last)?;
    let (first, last, token) =
        if token.parse::<f64>().is_ok() { (first, last, token) } else { (digit, digit + 1, text.get(digit..=digit)?) };
    let new = match token.parse::<i64>() {
        Ok(value) => format!("{}", value.wrapping_add(1 + random.below(9) as i64)),
        Err(_) => {
            let value: f64 = token.parse().ok()?;
            format!("{:?}", other_number(value, random))
        }
    };
    let changed = [&bytes[..first], new.as_bytes(), &bytes[last..]].concat();
    (changed != bytes).then_some((changed, format!("{token} became {new} at byte {first}")))
}

fn u16_at(bytes: &[u8], at: usize) -> usize {
    usize::from(u16::from_le_bytes([bytes[at], bytes[at + 1]]))
}

fn u32_at(bytes: &[u8], at: usize) -> usize {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]) as usize
}

fn u64_at(bytes: &[u8], at: usize) -> Option<usize> {
    Some(u64::from_le_bytes(bytes.get(at..at + 8)?.try_into().ok()?) as usize)
}

/// Changes the number of `width` bytes at `at`: 8 for `f64` and `i64`, 4 for the others.
fn change_number(bytes: &mut [u8], at: usize, kind: &str, random: &mut Random) -> String {
    if kind == "f8" {
        let old = f64::from_le_bytes(bytes[at..at + 8].try_into().unwrap_or_default());
        let new = if random.below(20) == 0 && !old.is_nan() { f64::NAN } else { other_number(old, random) };
        bytes[at..at + 8].copy_from_slice(&new.to_le_bytes());
        format!("{old:?} became {new:?}")
    } else if kind == "f4" {
        let old = f32::from_le_bytes(bytes[at..at + 4].try_into().unwrap_or_default());
        // The next number that there is, where single precision tells no nearer one.
        let new = Some(other_number(old.into(), random) as f32).filter(|new| *new != old).unwrap_or(old.next_up());
        bytes[at..at + 4].copy_from_slice(&new.to_le_bytes());
        format!("{old:?} became {new:?}")
    } else {
        let old = bytes[at];
        bytes[at] = old.wrapping_add(1 + random.below(3) as u8);
        format!("the lowest byte {old} became {}", bytes[at])
    }
}

/// One number of one array of an archive without compression, whose entries keep their CRC.
fn change_npz(bytes: &[u8], random: &mut Random) -> Option<(Vec<u8>, String)> {
    let mut bytes = bytes.to_vec();
    let end = bytes.len() - 22;
    let (entries, mut central) = (u16_at(&bytes, end + 10), u32_at(&bytes, end + 16));
    for _ in 0..random.below(entries) {
        central += 46 + u16_at(&bytes, central + 28) + u16_at(&bytes, central + 30) + u16_at(&bytes, central + 32);
    }
    let (size, local) = (u32_at(&bytes, central + 20), u32_at(&bytes, central + 42));
    let entry = String::from_utf8_lossy(&bytes[central + 46..][..u16_at(&bytes, central + 28)]).into_owned();
    let data = local + 30 + u16_at(&bytes, local + 26) + u16_at(&bytes, local + 28);
    let header = 10 + u16_at(&bytes, data + 8);
    let described = String::from_utf8_lossy(&bytes[data..data + header]).into_owned();
    let (kind, width) = match described {
        text if text.contains("<f8") => ("f8", 8),
        text if text.contains("<i8") => ("i8", 8),
        text if text.contains("<u4") => ("u4", 4),
        _ => ("u1", 1),
    };
    let count = (size - header) / width;
    if count == 0 {
        return None;
    }
    let number = random.below(count);
    let what = change_number(&mut bytes, data + header + number * width, kind, random);
    let crc = crc32(&bytes[data..data + size]).to_le_bytes();
    bytes[local + 14..local + 18].copy_from_slice(&crc);
    bytes[central + 16..central + 20].copy_from_slice(&crc);
    Some((bytes, format!("entry {number} of {entry}: {what}")))
}

/// CRC-32 of ISO 3309.
fn crc32(bytes: &[u8]) -> u32 {
    let step = |crc: u32| if crc & 1 == 1 { 0xedb8_8320 ^ (crc >> 1) } else { crc >> 1 };
    !bytes.iter().fold(!0, |crc, &byte| (0..8).fold(crc ^ u32::from(byte), |crc, _| step(crc)))
}

/// One number of an array that is stored as it is, with the checksum of its block; of one that is compressed a byte.
fn change_vtu(bytes: &[u8], random: &mut Random) -> Option<(Vec<u8>, String)> {
    let mark = b"<AppendedData encoding=\"raw\">\n_";
    let xml_end = bytes.windows(mark.len()).position(|window| window == mark)?;
    let xml = std::str::from_utf8(&bytes[..xml_end]).ok()?;
    let arrays: Vec<&str> = xml.lines().filter(|line| line.starts_with("<DataArray")).collect();
    let line = arrays.get(random.below(arrays.len()))?;
    let of = |key: &str| line.split_once(&format!("{key}=\""))?.1.split('"').next();
    let header = xml_end + mark.len() + of("offset")?.parse::<usize>().ok()?;
    let blocks = u64_at(bytes, header)?;
    if blocks == 0 {
        return None;
    }
    let block = header + 24 + 8 * blocks;
    let length = u64_at(bytes, header + 24)?;
    let name = of("Name")?.to_string();
    // The first stored part of the first block, if that is all of it.
    let part = u16_at(bytes, block + 3);
    if bytes[block + 2] != 1 || part + 11 != length {
        let (bytes, what) = change_byte(bytes, block..block + length, random);
        return Some((bytes, format!("{name}, {what}")));
    }
    let (kind, width) = match of("type")? {
        "Float64" => ("f8", 8),
        "Float32" => ("f4", 4),
        "UInt8" => ("u1", 1),
        "Int32" => ("i4", 4),
        _ => ("i8", 8),
    };
    let (mut bytes, number) = (bytes.to_vec(), random.below(part / width));
    let what = change_number(&mut bytes, block + 7 + number * width, kind, random);
    let sum = adler32(&bytes[block + 7..block + 7 + part]).to_be_bytes();
    bytes[block + 7 + part..block + length].copy_from_slice(&sum);
    Some((bytes, format!("number {number} of {name}: {what}")))
}

/// RFC 1950.
fn adler32(bytes: &[u8]) -> u32 {
    let (a, b) = bytes.iter().fold((1u32, 0u32), |(a, b), &byte| {
        let a = (a + u32::from(byte)) % 65521;
        (a, (b + a) % 65521)
    });
    b << 16 | a
}
