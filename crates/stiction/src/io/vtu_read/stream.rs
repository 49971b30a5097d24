//! Bytes of binary data: as they are, or in base64.

use std::borrow::Cow;

use base64::alphabet::STANDARD;
use base64::engine::general_purpose::{GeneralPurpose, GeneralPurposeConfig};
use base64::{DecodeError, DecodeSliceError, Engine as _};

/// Bytes to come.
pub(super) enum Stream<'a> {
    Raw(&'a [u8]),
    Base64 {
        text: &'a [u8],
        /// Bytes of the last group of four letters that nobody has taken yet.
        left: Vec<u8>,
    },
}

impl<'a> Stream<'a> {
    pub(super) fn base64(text: &'a [u8]) -> Self {
        Stream::Base64 { text, left: Vec::new() }
    }

    /// At most this many bytes follow.
    pub(super) fn remaining(&self) -> usize {
        match self {
            Stream::Raw(bytes) => bytes.len(),
            Stream::Base64 { text, left } => text.len() / 4 * 3 + left.len(),
        }
    }

    /// The next `n` bytes; `None` if there are fewer, or letters that are no base64.
    ///
    /// Heads and data may be encoded together or one by one: a padded group may stand anywhere.
    pub(super) fn take(&mut self, n: usize) -> Option<Cow<'a, [u8]>> {
        if n > self.remaining() {
            return None;
        }
        match self {
            Stream::Raw(bytes) => {
                let (taken, rest) = bytes.split_at_checked(n)?;
                *bytes = rest;
                Some(Cow::Borrowed(taken))
            }
            Stream::Base64 { text, left } => {
                let mut out = std::mem::take(left);
                out.reserve(n + 2);
                while out.len() < n {
                    decode(text, n - out.len(), &mut out)?;
                }
                *left = out.split_off(n);
                Some(Cow::Owned(out))
            }
        }
    }
}

/// Base64 of RFC 4648; what the bits after the last byte are does not matter.
const BASE64: GeneralPurpose =
    GeneralPurpose::new(&STANDARD, GeneralPurposeConfig::new().with_decode_allow_trailing_bits(true));

/// Decodes the next letters, at least a group of four, for at most `wanted` bytes and two more.
fn decode(text: &mut &[u8], wanted: usize, out: &mut Vec<u8>) -> Option<()> {
    /// Letters decoded at a time: white space among them costs no more than so many again.
    const PART: usize = 1024;
    let mut bytes = [0; PART / 4 * 3];
    let mut letters = PART.min(4 * wanted.div_ceil(3)).min(text.len() / 4 * 4);
    if let Err(error) = BASE64.decode_slice(&text[..letters], &mut bytes) {
        // Up to the group with white space or in which padding ends one of several codes.
        letters = match error {
            DecodeSliceError::DecodeError(DecodeError::InvalidByte(at, _)) => at.min(letters) / 4 * 4,
            _ => letters.saturating_sub(4),
        };
    }
    if letters == 0 {
        return group(text, out);
    }
    let (part, rest) = text.split_at(letters);
    let count = BASE64.decode_slice(part, &mut bytes).ok()?;
    out.extend_from_slice(&bytes[..count]);
    *text = rest;
    Some(())
}

/// Decodes the next four letters, white space left out.
fn group(text: &mut &[u8], out: &mut Vec<u8>) -> Option<()> {
    let (mut letters, mut bytes) = ([0; 4], [0; 3]);
    for letter in &mut letters {
        let start = text.iter().position(|byte| !b" \t\r\n".contains(byte))?;
        (*letter, *text) = (text[start], &text[start + 1..]);
    }
    let count = BASE64.decode_slice(letters, &mut bytes).ok()?;
    out.extend_from_slice(&bytes[..count]);
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// All bytes, taken in pieces of 1, 2, 3 .. up to `most` and again from 1.
    fn taken(text: &str, most: usize) -> Option<Vec<u8>> {
        let (mut stream, mut bytes, mut piece) = (Stream::base64(text.as_bytes()), Vec::new(), 1);
        let total = text.split('=').map(|code| code.bytes().filter(u8::is_ascii_alphanumeric).count() * 3 / 4).sum();
        while bytes.len() < total {
            piece = (piece % most + 1).min(total - bytes.len());
            bytes.extend_from_slice(&stream.take(piece)?);
        }
        Some(bytes)
    }

    #[test]
    fn codes_may_follow_each_other_and_have_white_space_anywhere() {
        let plain: Vec<u8> = "foobar".repeat(700).into_bytes();
        let code = "Zm9vYmFy".repeat(700);
        let broken = |every: usize| {
            let lines: Vec<&str> = code.as_bytes().chunks(every).map(|c| str::from_utf8(c).unwrap()).collect();
            lines.join("\r\n ")
        };
        for text in [code.clone(), broken(1), broken(3), broken(76), broken(1023)] {
            assert!([1, 7, 5000].iter().all(|&most| taken(&text, most).as_ref() == Some(&plain)), "{}", text.len());
        }
        assert_eq!(taken("Zg==Zm8=Zm9v Z g = =", 2).unwrap(), b"ffofoof");
        // The bits after the last byte are not zero.
        assert_eq!(taken("Zh==", 1).unwrap(), b"f");
    }

    #[test]
    fn what_is_no_code_is_refused() {
        let cases = [("Zm9*", 1), ("Z===", 1), ("=m9v", 1), ("Zg=v", 1), ("Zm 9", 1), ("Zm9vZg=", 4), ("Zm9vYm+", 4)];
        for (text, bytes) in cases {
            assert!(Stream::base64(text.as_bytes()).take(bytes).is_none(), "{text}");
        }
    }
}
