//! Numbers sorted into buckets by counting, by several threads.

use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering};

use rayon::prelude::*;

/// Parts a list is divided into at most, each with a counter for every bucket.
const MOST_PARTS: usize = 8;

/// Items are not divided into parts shorter than that.
const SHORT_PART: usize = 1 << 14;

/// Bucket `k` holds `items[start[k]..start[k + 1]]`, in the order in which they came.
#[derive(Debug, Default)]
pub(crate) struct Buckets {
    pub start: Vec<usize>,
    pub items: Vec<u32>,
}

impl Buckets {
    /// Sorts what `of(range)` lists as `[bucket, item]` for the ranges that `0..length` is divided into; buckets are below
    /// `count`. The result does not depend on the number of threads.
    pub(crate) fn new<I: Iterator<Item = [u32; 2]>>(
        count: usize,
        length: usize,
        of: impl Fn(Range<usize>) -> I + Sync,
    ) -> Buckets {
        let parts = rayon::current_num_threads().min(MOST_PARTS).min(length / SHORT_PART).max(1);
        let part = |p: usize| p * length / parts..(p + 1) * length / parts;
        let counted = |p: usize| {
            let mut counts = vec![0u32; count];
            of(part(p)).for_each(|[bucket, _]| counts[bucket as usize] += 1);
            counts
        };
        let mut counts: Vec<Vec<u32>> = (0..parts).into_par_iter().map(counted).collect();
        let mut start = Vec::with_capacity(count + 1);
        start.push(0);
        let mut filled = 0;
        for bucket in 0..count {
            // From here on where the part puts its next item, counted from the start of the bucket.
            let mut before = 0;
            for counts in &mut counts {
                before += std::mem::replace(&mut counts[bucket], before);
            }
            filled += before as usize;
            start.push(filled);
        }
        // Each place is written once, by the part whose item it is.
        let items: Vec<AtomicU32> = (0..filled).into_par_iter().map(|_| AtomicU32::new(0)).collect();
        (0..parts).into_par_iter().zip(counts).for_each(|(p, mut next)| {
            of(part(p)).for_each(|[bucket, item]| {
                let next = &mut next[bucket as usize];
                items[start[bucket as usize] + *next as usize].store(item, Ordering::Relaxed);
                *next += 1;
            });
        });
        Buckets { start, items: items.into_iter().map(AtomicU32::into_inner).collect() }
    }

    /// What bucket `k` holds.
    pub(crate) fn at(&self, k: usize) -> &[u32] {
        &self.items[self.start[k]..self.start[k + 1]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn items_come_in_their_order_whatever_the_number_of_threads() {
        // Enough for as many parts as there may be, with buckets that stay empty.
        let (count, length) = (1000, MOST_PARTS * SHORT_PART + 17);
        let bucket = |item: usize| (item * item % count) as u32;
        let mut expected = vec![Vec::new(); count];
        (0..length).for_each(|item| expected[bucket(item) as usize].push(item as u32));
        for threads in [1, 2, 5, 16] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let of = |range: Range<usize>| range.map(|item| [bucket(item), item as u32]);
            let buckets = pool.install(|| Buckets::new(count, length, of));
            assert!(expected.iter().any(Vec::is_empty));
            assert!((0..count).all(|k| buckets.at(k) == expected[k]), "{threads}");
        }
    }
}
