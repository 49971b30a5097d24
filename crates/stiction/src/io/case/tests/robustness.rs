//! Damaged files: any answer will do, except a panic.

use super::super::templates;
use super::{parse, set};

/// A linear congruential generator (Knuth's MMIX constants): the same mutations in every run.
struct Random(u64);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) as usize % n.max(1)
    }
}

fn mutate(text: &str, random: &mut Random) -> String {
    if text.is_empty() {
        return String::new();
    }
    let mut bytes = text.as_bytes().to_vec();
    let mut lines: Vec<&str> = text.lines().collect();
    let i = random.below(bytes.len());
    match random.below(6) {
        0 => bytes[i] ^= 1 << random.below(8),
        1 => bytes.truncate(i),
        2 => bytes.insert(i, b"[]{}\"'=,.#\n\\-0e"[random.below(15)]),
        3 => drop(bytes.remove(i)),
        4 => {
            let (a, b) = (random.below(lines.len()), random.below(lines.len()));
            lines.swap(a, b);
            bytes = lines.join("\n").into_bytes();
        }
        _ => {
            let words = ["nan", "-1", "[]", "{}", "\"\"", "true", "1e999", "[[[1]]]", "\"x^\"", "9223372036854775807"];
            let value = words[random.below(words.len())];
            let line = random.below(lines.len());
            let changed = lines[line].split_once('=').map(|(key, _)| format!("{key}= {value}"));
            let mut lines: Vec<String> = lines.iter().map(|l| l.to_string()).collect();
            lines[line] = changed.unwrap_or_default();
            bytes = lines.join("\n").into_bytes();
        }
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

#[test]
fn no_damage_to_a_case_file_makes_the_reader_panic() {
    let mut random = Random(7);
    let (mut accepted, mut refused) = (0, 0);
    for template in templates() {
        // Without its comments a template is hit more often where it counts.
        let bare: String =
            template.text.lines().map(|l| l.split('#').next().unwrap_or("").trim_end().to_string() + "\n").collect();
        for _ in 0..2000 {
            let mut text = bare.clone();
            for _ in 0..1 + random.below(3) {
                text = mutate(&text, &mut random);
            }
            match parse(&text, "case.toml", &[]) {
                Ok(_) => accepted += 1,
                Err(error) => {
                    refused += 1;
                    assert!(!error.place.is_empty() && !error.what.is_empty() && !error.remedy.is_empty(), "{error}");
                }
            }
        }
    }
    assert!(accepted > 100 && refused > 1000, "{accepted} {refused}");
}

#[test]
fn no_override_makes_the_reader_panic() {
    let mut random = Random(11);
    let keys =
        ["mesh", "block", "contact", "0", "1", "friction", "coulomb", "on", "", "\"", "fix", "value", "é", "materials"];
    let values = ["", "1", "[", "[1, 2]", "{ a = 1 }", "x", "\"", "nan", "[[]]", "'", "1979-05-27"];
    for _ in 0..3000 {
        let count = 1 + random.below(4);
        let path: Vec<_> = (0..count).map(|_| keys[random.below(keys.len())]).collect();
        let pair = set(&[(&path.join("."), values[random.below(values.len())])]);
        let _ = parse(templates()[0].text, "case.toml", &pair);
    }
}

#[test]
fn deep_nesting_does_not_exhaust_the_stack() {
    for open in ["a = [", "[", "{a=", "a."] {
        assert!(parse(&open.repeat(50_000), "case.toml", &[]).is_err());
    }
    assert!(parse("", "case.toml", &set(&[(&"a.".repeat(50_000), "1")])).is_err());
    assert!(parse("", "case.toml", &set(&[("a", &"[".repeat(50_000))])).is_err());
}
