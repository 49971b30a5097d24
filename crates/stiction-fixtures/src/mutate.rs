//! Changes of files that know lines, words and numbers: cards and their parameters in decks, keys and tables of case files,
//! tags and attributes, sections, headers of arrays. Bytes that are no text stay whole, as lines of their own.

use crate::fuzz::{MOST, Random, WORDS};

/// One to four changes of a file.
pub(crate) fn structured(seeds: &[Vec<u8>], random: &mut Random) -> Vec<u8> {
    let other = &seeds[random.below(seeds.len())];
    let others: Vec<&[u8]> = other.split_inclusive(|&b| b == b'\n').collect();
    let mut lines: Vec<Vec<u8>> = {
        let file = &seeds[random.below(seeds.len())];
        file.split_inclusive(|&b| b == b'\n').map(<[u8]>::to_vec).collect()
    };
    for _ in 0..=random.below(4) {
        if lines.is_empty() {
            break;
        }
        let at = random.below(lines.len());
        // From the line on, to the end of a card or a table.
        let end = (at + 1 + random.below(6)).min(lines.len());
        match random.below(12) {
            0 => drop(lines.drain(at..end)),
            1 => {
                let copies = lines[at..end].to_vec();
                let to = random.below(lines.len());
                lines.splice(to..to, copies);
            }
            2 => {
                let with = random.below(lines.len());
                lines.swap(at, with);
            }
            3 => {
                let from = random.below(others.len());
                let to = (from + 1 + random.below(6)).min(others.len());
                lines.splice(at..at, others[from.min(to)..to].iter().map(|line| line.to_vec()));
            }
            4 => {
                let line = lines[at].clone();
                lines.splice(at..at, std::iter::repeat_n(line, 1 + random.below(40)));
            }
            _ => {
                let line = lines[random.below(lines.len())].clone();
                let from =
                    if random.below(2) == 0 || others.is_empty() { &line } else { others[random.below(others.len())] };
                let from = words(from);
                lines[at] = changed_line(&lines[at], &from, random);
            }
        }
    }
    let mut file = lines.concat();
    file.truncate(MOST);
    file
}

/// One word of a line dropped, doubled, swapped, replaced by one of `others`, or its number by another number.
fn changed_line(line: &[u8], others: &[&[u8]], random: &mut Random) -> Vec<u8> {
    let mut list: Vec<Vec<u8>> = words(line).into_iter().map(<[u8]>::to_vec).collect();
    if list.is_empty() {
        return line.to_vec();
    }
    let at = random.below(list.len());
    let with = random.below(list.len());
    match random.below(9) {
        0 => drop(list.remove(at)),
        1 => list.insert(with, list[at].clone()),
        2 => list.swap(at, with),
        3 | 4 if !others.is_empty() => list[at] = others[random.below(others.len())].to_vec(),
        5 => list[at].iter_mut().for_each(|b| *b ^= if b.is_ascii_alphabetic() { 0x20 } else { 0 }),
        _ => {
            // The next number from here on.
            let digit = |word: &Vec<u8>| word.iter().any(u8::is_ascii_digit);
            let at = (at..list.len()).find(|&k| digit(&list[k])).unwrap_or(at);
            list[at] = number(&list[at], random);
        }
    }
    list.concat()
}

/// A number beside the one that stands there, or one that breaks things.
fn number(word: &[u8], random: &mut Random) -> Vec<u8> {
    let value = std::str::from_utf8(word).ok().and_then(|word| word.parse::<f64>().ok());
    match (random.below(6), value) {
        (0, Some(value)) => format!("{}", value + 1.0),
        (1, Some(value)) => format!("{}", value - 1.0),
        (2, Some(value)) => format!("{}", -value),
        (3, Some(value)) => format!("{:e}", value * 10f64.powi(random.below(600) as i32 - 300)),
        _ => WORDS[random.below(WORDS.len())].to_string(),
    }
    .into_bytes()
}

/// The words of a line and what stands between them: names and numbers in one piece, every other byte of its own.
fn words(line: &[u8]) -> Vec<&[u8]> {
    let joins = |a: u8, b: u8| {
        let part = |b: u8| b.is_ascii_alphanumeric() || b"._+-".contains(&b) || !b.is_ascii();
        part(a) && part(b)
    };
    line.chunk_by(|&a, &b| joins(a, b)).collect()
}
