//! Text that goes into a page.

use base64::Engine as _;
use base64::engine::general_purpose::STANDARD;

/// Base64 (RFC 4648, section 4).
pub(super) fn base64(bytes: impl IntoIterator<Item = u8>) -> String {
    STANDARD.encode(bytes.into_iter().collect::<Vec<u8>>())
}

/// JSON that may stand inside a script element: no tag can begin in it.
pub(super) fn script_json(value: &serde_json::Value) -> String {
    value.to_string().replace('<', "\\u003c")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_tag_begins_in_a_script() {
        assert_eq!(script_json(&serde_json::json!("</script>")), "\"\\u003c/script>\"");
    }
}
