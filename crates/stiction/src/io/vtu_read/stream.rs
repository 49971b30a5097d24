//! Bytes of binary data: as they are, or in base64.

use std::borrow::Cow;

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
    pub fn base64(text: &'a [u8]) -> Self {
        Stream::Base64 { text, left: Vec::new() }
    }

    /// At most this many bytes follow.
    pub fn remaining(&self) -> usize {
        match self {
            Stream::Raw(bytes) => bytes.len(),
            Stream::Base64 { text, left } => text.len() / 4 * 3 + left.len(),
        }
    }

    /// The next `n` bytes; `None` if there are fewer, or letters that are no base64.
    ///
    /// Heads and data may be encoded together or one by one: a padded group may stand anywhere.
    pub fn take(&mut self, n: usize) -> Option<Cow<'a, [u8]>> {
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
                    match text.split_first_chunk::<4>() {
                        // Nearly always: four letters that stand for numbers.
                        Some((letters, rest)) if letters.iter().all(|&letter| VALUE[usize::from(letter)] < 64) => {
                            let bits = letters.iter().fold(0, |bits, &l| bits << 6 | u32::from(VALUE[usize::from(l)]));
                            out.extend_from_slice(&bits.to_be_bytes()[1..]);
                            *text = rest;
                        }
                        _ => group(text, &mut out)?,
                    }
                }
                *left = out.split_off(n);
                Some(Cow::Owned(out))
            }
        }
    }
}

/// What each letter of base64 stands for (RFC 4648), 64 for what is none.
const VALUE: [u8; 256] = {
    let letters = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let (mut table, mut value) = ([64; 256], 0);
    while value < 64 {
        table[letters[value] as usize] = value as u8;
        value += 1;
    }
    table
};

/// Decodes the next four letters.
fn group(text: &mut &[u8], out: &mut Vec<u8>) -> Option<()> {
    let (mut bits, mut letters, mut padding) = (0u32, 0, 0);
    while letters < 4 {
        let (&letter, rest) = text.split_first()?;
        *text = rest;
        let value = match (letter, VALUE[usize::from(letter)]) {
            (_, value @ 0..64) => value,
            (b'=', _) if letters >= 2 => {
                padding += 1;
                0
            }
            (b' ' | b'\t' | b'\r' | b'\n', _) => continue,
            _ => return None,
        };
        if padding > 0 && letter != b'=' {
            return None;
        }
        bits = bits << 6 | u32::from(value);
        letters += 1;
    }
    out.extend_from_slice(&bits.to_be_bytes()[1..4 - padding]);
    Some(())
}
