//! Numbers in the bytes of a text file.

/// A whole number that fits into 64 bits with its sign.
pub(super) fn integer(word: &[u8]) -> Option<i64> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// A floating point number, correctly rounded; may be infinite or NaN. Fortran's exponent `1.5D-3` is read too.
pub(super) fn float(word: &[u8]) -> Option<f64> {
    let text = std::str::from_utf8(word).ok()?;
    match text.parse() {
        Ok(value) => Some(value),
        // Fortran; "d" occurs in no other number
        Err(_) => text.replace(['d', 'D'], "e").parse().ok().filter(|_| text.starts_with(|c: char| !c.is_alphabetic())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_give_the_number_of_the_standard_library_to_the_bit() {
        let words = [
            "0",
            "-0",
            "1",
            "+1.5",
            "-.5",
            "5.",
            "1e3",
            "1E+3",
            "-1.25e-3",
            "0.1",
            "0.30000000000000004",
            "1e22",
            "1e23",
            "9007199254740993",
            "123456789012345678901234567890",
            "0.000000000000000000000001",
            "1e-400",
            "1e400",
            "4.9e-324",
            "2.2250738585072011e-308",
            "inf",
            "-inf",
            "00000000000000000000012",
            "1e-22",
            "8.5e-23",
        ];
        for word in words {
            assert_eq!(
                float(word.as_bytes()).map(f64::to_bits),
                Some(word.parse::<f64>().unwrap().to_bits()),
                "{word}"
            );
        }
        // coordinates as programs write them
        let mut state = 1u64;
        for _ in 0..20_000 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let x = (state >> 11) as f64 / (1u64 << 40) as f64 - 4000.0;
            for word in [format!("{x}"), format!("{x:.3}"), format!("{x:.6e}"), format!("{:.16e}", x * 1e-9)] {
                assert_eq!(
                    float(word.as_bytes()).map(f64::to_bits),
                    Some(word.parse::<f64>().unwrap().to_bits()),
                    "{word}"
                );
            }
        }
    }

    #[test]
    fn fortran_is_read_and_nonsense_is_not() {
        assert_eq!(float(b"-1.5D-3"), Some(-1.5e-3));
        assert_eq!(float(b"1.2345678901234567890123d2"), Some(123.456_789_012_345_68));
        for word in ["", ".", "-", "e5", "1e", "1e5.", "1.2.3", "0x10", "1,2", "d", "1e+", "--1", "1d5d"] {
            assert_eq!(float(word.as_bytes()), None, "{word}");
        }
        assert_eq!(
            (integer(b"-12"), integer(b"+3"), integer(b"999999999999999999")),
            (Some(-12), Some(3), Some(999_999_999_999_999_999))
        );
        for word in ["", "-", "1.0", "9999999999999999999", "1a"] {
            assert_eq!(integer(word.as_bytes()), None, "{word}");
        }
    }
}
