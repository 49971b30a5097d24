/// A number that differs where words do (FNV-1a, by words).
pub(super) struct Hash(u64);

impl Default for Hash {
    fn default() -> Hash {
        Hash(0xcbf2_9ce4_8422_2325)
    }
}

impl Hash {
    pub(super) fn word(&mut self, word: u64) {
        self.0 = (self.0 ^ word).wrapping_mul(0x0100_0000_01b3);
        // The low bits would never learn of the high ones.
        self.0 ^= self.0 >> 32;
    }

    pub(super) fn text(&mut self, text: &str) {
        text.bytes().for_each(|byte| self.word(byte.into()));
        // Where it ends.
        self.word(u64::MAX);
    }

    pub(super) fn value(&self) -> u64 {
        self.0
    }
}
