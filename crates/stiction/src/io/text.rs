//! Numbers as a person reads them.

use crate::Error;

/// What was typed to start `program`, with quotes where a shell needs them.
pub fn command_line(program: &str, typed: impl Iterator<Item = String>) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./=,:@%+".contains(c);
    let quoted = |word: String| match word.chars().all(plain) && !word.is_empty() {
        true => word,
        false => format!("'{}'", word.replace('\'', "'\\''")),
    };
    std::iter::once(program.to_string()).chain(typed.map(quoted)).collect::<Vec<_>>().join(" ")
}

/// Five significant digits.
pub fn number(x: f64) -> String {
    Error::number(x)
}

/// Two digits of a measure of a certificate. Where answer and data hold nothing to count an error in, its measure is the largest
/// number there is, which says nothing to a person.
pub fn measure(x: f64) -> String {
    if x.is_finite() && x < f64::MAX { format!("{x:.1e}") } else { "beyond all bounds".into() }
}

/// `text` with what means something in XML and HTML replaced.
pub fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            '\'' => out += "&#39;",
            // Control characters may not stand there at all.
            c if misleads(c) => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

/// `text` without what would command a terminal, or show it in another order than it has.
pub fn plain(text: &str) -> String {
    text.chars().map(|c| if misleads(c) { '\u{fffd}' } else { c }).collect()
}

/// Control characters except ends of lines and tabs, and those that turn the direction of what follows (Unicode Standard
/// Annex 9).
fn misleads(c: char) -> bool {
    let turns = matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    turns || c.is_control() && !matches!(c, '\n' | '\t')
}

/// Three numbers of five digits.
pub fn triple(x: [f64; 3]) -> String {
    // What rounding left of a zero component is not worth reading.
    let largest = x.iter().fold(0.0f64, |a, b| a.max(b.abs()));
    let [a, b, c] = x.map(|v| number(if v.abs() < 1e-9 * largest { 0.0 } else { v }));
    format!("({a}, {b}, {c})")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_measure_without_a_scale_is_words() {
        assert_eq!(
            [2.64e-10, f64::MAX, f64::INFINITY].map(measure),
            ["2.6e-10", "beyond all bounds", "beyond all bounds"]
        );
    }

    #[test]
    fn nothing_of_a_text_can_become_markup() {
        assert_eq!(escaped("<a href='x'>&\"\u{1b}ü"), "&lt;a href=&#39;x&#39;&gt;&amp;&quot;\u{fffd}ü");
    }

    #[test]
    fn nothing_of_a_text_commands_a_terminal_or_turns_what_follows() {
        assert_eq!(plain("a\u{1b}[2J\rb\u{202e}c\u{9b}\td\n<ü>"), "a\u{fffd}[2J\u{fffd}b\u{fffd}c\u{fffd}\td\n<ü>");
        assert_eq!(escaped("a\u{2066}b\u{0}"), "a\u{fffd}b\u{fffd}");
    }

    #[test]
    fn numbers_are_short_and_keep_their_size() {
        let texts = [0.0, -0.0, 1.0, 1234.5678, 0.333333, 2.5e-7, 1e5, -3e12].map(number);
        assert_eq!(texts, ["0", "0", "1", "1234.6", "0.33333", "2.5e-7", "1e5", "-3e12"]);
        assert_eq!(triple([1e-12, 2.0, f64::NAN]), "(0, 2, NaN)");
    }
}
