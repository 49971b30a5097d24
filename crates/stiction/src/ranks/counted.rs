use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::Ranks;

/// What a rank has sent so far.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Traffic {
    /// Calls of [`Ranks::exchange`].
    pub exchanges: u64,
    /// Messages sent, and their bytes.
    pub messages: u64,
    /// Bytes of these.
    pub bytes: u64,
    /// Exchanges of values at the border of the mesh or of a coarse level.
    pub halo_exchanges: u64,
    /// Bytes sent in these.
    pub halo_bytes: u64,
    /// Sums and maxima over all ranks.
    pub sums: u64,
}

/// Ranks whose messages are counted, also by what they stand for if that counts too.
#[derive(Debug)]
pub struct Counted {
    ranks: Arc<dyn Ranks>,
    counts: [AtomicU64; 6],
}

impl Counted {
    /// Counts what `ranks` sends from now on.
    pub fn new(ranks: Arc<dyn Ranks>) -> Self {
        Counted { ranks, counts: Default::default() }
    }

    /// Up to now.
    pub fn traffic(&self) -> Traffic {
        let [exchanges, messages, bytes, halo_exchanges, halo_bytes, sums] =
            [0, 1, 2, 3, 4, 5].map(|k| self.counts[k].load(Ordering::Relaxed));
        Traffic { exchanges, messages, bytes, halo_exchanges, halo_bytes, sums }
    }

    fn add(&self, which: usize, more: usize) {
        self.counts[which].fetch_add(more as u64, Ordering::Relaxed);
    }
}

impl Ranks for Counted {
    fn rank(&self) -> usize {
        self.ranks.rank()
    }

    fn size(&self) -> usize {
        self.ranks.size()
    }

    fn exchange(&self, out: Vec<(usize, Vec<u8>)>, from: &[usize]) -> Vec<Vec<u8>> {
        self.add(0, 1);
        self.add(1, out.len());
        self.add(2, out.iter().map(|(_, message)| message.len()).sum());
        self.ranks.exchange(out, from)
    }

    fn count_halo(&self, bytes: usize) {
        self.add(3, 1);
        self.add(4, bytes);
        self.ranks.count_halo(bytes);
    }

    fn count_sum(&self) {
        self.add(5, 1);
        self.ranks.count_sum();
    }
}
