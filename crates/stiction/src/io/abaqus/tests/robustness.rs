//! Whatever the bytes: a mesh or an error, never a panic.

use super::*;

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

fn decks() -> Vec<Vec<u8>> {
    let sets =
        "*NSET,NSET=A,GENERATE\n10,40,10\n*ELSET,ELSET=B\nEall,9\n*SURFACE,NAME=S\nB,S2\n9,S4\n*INCLUDE,INPUT=x\n";
    let part = "*PART,NAME=P\n*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n*ELEMENT,TYPE=C3D4,ELSET=E\n1,1,2,3,4\n*END PART\n*ASSEMBLY\n\
                *INSTANCE,NAME=I,PART=P\n0,0,3\n0,0,0,1,0,0,90\n*END INSTANCE\n*NSET,NSET=N,INSTANCE=I\n1,2\n*END ASSEMBLY\n";
    let curved = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data/curved-hex20-gmsh.inp");
    vec![cubes(sets).into_bytes(), part.as_bytes().to_vec(), std::fs::read(curved).unwrap()]
}

fn include(_: &str) -> Result<Vec<u8>, String> {
    Ok(b"8,S3\n*NSET,NSET=A\n10,20\n".to_vec())
}

#[test]
fn decks_cut_anywhere_do_not_panic() {
    for deck in decks() {
        assert!(parse(&deck, "a.inp", 1.0, &include).is_ok());
        for end in 0..deck.len() {
            drop(parse(&deck[..end], "a.inp", 1.0, &include));
        }
    }
}

#[test]
fn changed_bytes_do_not_panic() {
    let mut noise = Noise(0x9e37_79b9_7f4a_7c15);
    let mut good = 0;
    for deck in decks() {
        for _ in 0..4000 {
            let mut changed = deck.clone();
            for _ in 0..1 + noise.below(3) {
                let at = noise.below(changed.len());
                match noise.below(5) {
                    0 => changed[at] = noise.below(256) as u8,
                    1 => changed[at] ^= 1 << noise.below(8),
                    2 => changed[at] = b"0123456789-.e,*=S \n"[noise.below(19)],
                    3 => drop(changed.drain(at..(at + 20).min(changed.len()))),
                    _ => {
                        let from = noise.below(changed.len());
                        let piece = changed[from..(from + 30).min(changed.len())].to_vec();
                        changed.splice(at..at, piece);
                    }
                }
                if changed.is_empty() {
                    break;
                }
            }
            if let Ok((mesh, _)) = parse(&changed, "a.inp", 1.0, &include) {
                info(&mesh).to_string();
                good += 1;
            }
        }
    }
    assert!(good > 100, "{good}");
}
