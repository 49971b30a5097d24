//! Where axes carry numbers, and how numbers are written.

/// Marks of an axis: their places and texts, and the power of ten taken out of the texts.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Ticks {
    pub marks: Vec<(f64, String)>,
    /// The texts are in units of ten to this power; 0 for numbers written in full.
    pub exponent: i32,
}

/// About `count` round marks between `low` and `high`, one, two or five times a power of ten apart.
pub(super) fn ticks(low: f64, high: f64, count: usize) -> Ticks {
    let span = high - low;
    if !(span.is_finite() && span > f64::MIN_POSITIVE) {
        return Ticks { marks: Vec::new(), exponent: 0 };
    }
    let step = round_up(span / count.max(1) as f64);
    let largest = low.abs().max(high.abs());
    let magnitude = largest.log10().floor() as i32;
    // Powers of a thousand, as engineers and prefixes count.
    let exponent = if (-1..4).contains(&magnitude) { 0 } else { 3 * magnitude.div_euclid(3) };
    let unit = power(exponent);
    let decimals = (-(step / unit * 1.000_001).log10().floor()).clamp(0.0, 17.0) as usize;
    let mut marks = Vec::new();
    // The slack lets a mark on the end itself survive rounding.
    let mut k = (low / step - 1e-6).ceil();
    while k <= high / step + 1e-6 && marks.len() <= 4 * count.max(1) {
        // Adding zero turns -0 into 0.
        let value = k * step + 0.0;
        marks.push((value, minus(&format!("{:.decimals$}", value / unit))));
        // Where the numbers are too large to be distinguished by the step, there is no next mark.
        k = if k + 1.0 > k { k + 1.0 } else { f64::INFINITY };
    }
    Ticks { marks, exponent }
}

/// The smallest of 1, 2 and 5 times a power of ten that is not below `x > 0`.
fn round_up(x: f64) -> f64 {
    let decade = power(x.log10().floor() as i32);
    [1.0, 2.0, 5.0].into_iter().map(|m| m * decade).find(|&n| n >= x * (1.0 - 1e-9)).unwrap_or(10.0 * decade)
}

/// The largest of 1, 2 and 5 times a power of ten that is not above `x`; zero if `x` is not positive and finite.
pub(super) fn round_down(x: f64) -> f64 {
    if !(x.is_finite() && x > f64::MIN_POSITIVE) {
        return 0.0;
    }
    let decade = power(x.log10().floor() as i32);
    [5.0, 2.0, 1.0].into_iter().map(|m| m * decade).find(|&n| n <= x * (1.0 + 1e-9)).unwrap_or(decade)
}

/// Ten to the power `k`, exact where that is possible: `powi(-2)` is a reciprocal and misses 0.01 by a bit.
fn power(k: i32) -> f64 {
    format!("1e{k}").parse().unwrap_or(0.0)
}

/// `10⁻³`, `5.2` and the like: four significant digits at most, exponents as superscripts.
pub(super) fn number(x: f64) -> String {
    if !x.is_finite() {
        return if x.is_nan() {
            "–"
        } else if x > 0.0 {
            "∞"
        } else {
            "−∞"
        }
        .to_string();
    }
    let scientific = format!("{x:.3e}");
    let (digits, exponent) = scientific.split_once('e').unwrap_or((&scientific, "0"));
    let exponent: i32 = exponent.parse().unwrap_or(0);
    if x == 0.0 {
        "0".to_string()
    } else if (-3..4).contains(&exponent) {
        minus(trim(&format!("{x:.*}", (3 - exponent).max(0) as usize)))
    } else if trim(digits) == "1" {
        ten_to(exponent)
    } else {
        format!("{}×{}", minus(trim(digits)), ten_to(exponent))
    }
}

/// `10⁻³`.
pub(super) fn ten_to(exponent: i32) -> String {
    let digit = |c| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        c => c.to_digit(10).and_then(|d| char::from_u32(0x2070 + d)).unwrap_or(c),
    };
    format!("10{}", exponent.to_string().chars().map(digit).collect::<String>())
}

fn trim(number: &str) -> &str {
    if number.contains('.') { number.trim_end_matches('0').trim_end_matches('.') } else { number }
}

/// The minus of print instead of the hyphen.
fn minus(number: &str) -> String {
    number.replace('-', "−")
}

/// `1234567` as `1 234 567`.
pub(super) fn grouped(n: usize) -> String {
    let digits = n.to_string();
    let mut text = String::new();
    for (i, c) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) && digits.len() > 4 {
            text.push('\u{2009}');
        }
        text.push(c);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(low: f64, high: f64) -> (Vec<String>, i32) {
        let t = ticks(low, high, 5);
        (t.marks.into_iter().map(|m| m.1).collect(), t.exponent)
    }

    #[test]
    fn marks_are_round_and_their_texts_short() {
        let strings = |s: &[&str]| s.iter().map(|s| s.to_string()).collect::<Vec<_>>();
        assert_eq!(texts(0.0, 1.0), (strings(&["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]), 0));
        assert_eq!(texts(0.0, 3.2e-7), (strings(&["0", "100", "200", "300"]), -9));
        assert_eq!(texts(-0.3, 0.3), (strings(&["−0.2", "0.0", "0.2"]), 0));
        assert_eq!(texts(0.0, 52_500.0), (strings(&["0", "20", "40"]), 3));
        for (low, high) in [(0.0, 0.07), (1e5, 1e5 + 3.0), (-1e300, 1e300), (0.0, 1e-300), (3.0, 7e8)] {
            let t = ticks(low, high, 6);
            assert!((2..=8).contains(&t.marks.len()), "{low} {high} {t:?}");
            assert!(t.marks.windows(2).all(|w| w[0].0 < w[1].0 && w[0].1 != w[1].1), "{t:?}");
        }
    }

    #[test]
    fn ranges_that_are_none_have_no_marks() {
        for (low, high) in [(1.0, 1.0), (2.0, 1.0), (0.0, f64::NAN), (f64::NEG_INFINITY, 0.0), (-f64::MAX, f64::MAX)] {
            assert!(ticks(low, high, 5).marks.is_empty());
        }
        assert!(ticks(1e300, 1e300 * (1.0 + 1e-15), 5).marks.len() < 21);
    }

    #[test]
    fn scale_factors_round_down_to_one_two_or_five() {
        let cases = [(1.0, 1.0), (1.99, 1.0), (4999.0, 2000.0), (0.0071, 0.005), (1000.0, 1000.0), (0.0, 0.0)];
        assert!(cases.iter().all(|&(x, rounded)| round_down(x) == rounded));
        assert_eq!(round_down(f64::INFINITY), 0.0);
    }

    #[test]
    fn numbers_are_written_as_in_print() {
        let cases = [
            (0.0, "0"),
            (1234.5, "1234"),
            (-0.25, "−0.25"),
            (0.001_234_9, "0.001235"),
            (1e-8, "10⁻⁸"),
            (-2.5e12, "−2.5×10¹²"),
            (2000.0, "2000"),
            (f64::NAN, "–"),
        ];
        cases.iter().for_each(|&(x, text)| assert_eq!(number(x), text));
        assert_eq!((grouped(1_234_567).as_str(), grouped(1234).as_str()), ("1\u{2009}234\u{2009}567", "1234"));
    }
}
