//! Text that goes into a page.

/// `text` with what means something in HTML replaced.
pub(super) fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            '\'' => out += "&#39;",
            // Control characters may not stand in HTML at all.
            c if c.is_control() && !matches!(c, '\n' | '\t') => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

/// Base64 (RFC 4648, section 4).
pub(super) fn base64(bytes: impl IntoIterator<Item = u8>) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut bytes = bytes.into_iter();
    let mut out = String::new();
    while let Some(first) = bytes.next() {
        let rest = [bytes.next(), bytes.next()];
        let all = [first, rest[0].unwrap_or(0), rest[1].unwrap_or(0)].map(u32::from);
        let word = all[0] << 16 | all[1] << 8 | all[2];
        let letter = |i: u32| char::from(LETTERS[(word >> (18 - 6 * i) & 63) as usize]);
        out.extend([letter(0), letter(1)]);
        out.push(if rest[0].is_some() { letter(2) } else { '=' });
        out.push(if rest[1].is_some() { letter(3) } else { '=' });
    }
    out
}

/// JSON that may stand inside a script element: no tag can begin in it.
pub(super) fn script_json(value: &serde_json::Value) -> String {
    value.to_string().replace('<', "\\u003c")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_agrees_with_the_vectors_of_rfc_4648() {
        let known =
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foob", "Zm9vYg=="), ("foobar", "Zm9vYmFy")];
        known.iter().for_each(|(plain, coded)| assert_eq!(base64(plain.bytes()), *coded));
    }

    #[test]
    fn nothing_of_a_text_can_become_markup() {
        assert_eq!(escaped("<a href='x'>&\"\u{1b}ü"), "&lt;a href=&#39;x&#39;&gt;&amp;&quot;\u{fffd}ü");
        assert_eq!(script_json(&serde_json::json!("</script>")), "\"\\u003c/script>\"");
    }
}
