//! Whatever the bytes: a mesh or an error, never a panic.

use super::*;

fn files() -> Vec<(String, Vec<u8>)> {
    let models = ["cylinders", "bar"].iter().flat_map(|m| SUFFIXES.map(|s| format!("{m}-{s}.msh")));
    let curved = ["tet10-22", "hex20-41"].map(|name| format!("../data/curved-{name}.msh"));
    models.chain(curved).map(|name| (name.clone(), std::fs::read(path(&name)).unwrap())).collect()
}

/// Deterministic noise (Marsaglia's xorshift).
struct Noise(u64);

impl Noise {
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % n as u64) as usize
    }
}

#[test]
fn truncated_files_are_refused() {
    for (name, bytes) in files() {
        // without its last line and what precedes it the file is incomplete; only white space may be missing
        let whole = bytes.trim_ascii_end().len();
        for i in 0..500 {
            let result = parse(&bytes[..i * whole / 500], &name, 1.0);
            assert!(result.is_err(), "{name} cut at {}", i * whole / 500);
        }
        assert!(parse(&bytes[..whole], &name, 1.0).is_ok());
    }
}

#[test]
fn flipped_bytes_do_not_panic() {
    let mut noise = Noise(0x9e37_79b9_7f4a_7c15);
    for (name, bytes) in files() {
        for _ in 0..600 {
            let mut changed = bytes.clone();
            for _ in 0..1 + noise.below(3) {
                let at = noise.below(changed.len());
                changed[at] = match noise.below(4) {
                    0 => noise.below(256) as u8,
                    1 => changed[at] ^ 1 << noise.below(8),
                    2 => b"0123456789-.e $\n"[noise.below(16)],
                    _ => 0xff,
                };
            }
            if let Ok((mesh, _)) = parse(&changed, &name, 1.0) {
                info(&mesh).to_string();
            }
        }
    }
}

#[test]
fn shuffled_pieces_do_not_panic() {
    let mut noise = Noise(0x2545_f491_4f6c_dd1d);
    for (name, bytes) in files() {
        for _ in 0..200 {
            let mut changed = bytes.clone();
            let [from, to] = [noise.below(bytes.len()), noise.below(bytes.len())];
            let length = noise.below(60).min(bytes.len() - from.max(to));
            changed.copy_within(from..from + length, to);
            drop(parse(&changed, &name, 1.0));
            changed.drain(from..from + length);
            drop(parse(&changed, &name, 1.0));
        }
    }
}
