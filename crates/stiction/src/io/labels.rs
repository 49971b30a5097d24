//! Numbers a file gives its nodes or elements, turned into indices.

/// From the number of a thing to its place in the file.
pub(super) enum Labels {
    /// Counted from 1 without gaps.
    Counted(usize),
    /// Few gaps: index by number, `u32::MAX` for none.
    Dense(Vec<u32>),
    /// Number and index, sorted.
    Sparse(Vec<(u64, u32)>),
}

impl Labels {
    /// Fails with a number that is given more than once. At most `u32::MAX - 1` numbers.
    pub(super) fn new(labels: impl ExactSizeIterator<Item = u64> + Clone) -> Result<Labels, u64> {
        let count = labels.len();
        if labels.clone().enumerate().all(|(i, label)| label == i as u64 + 1) {
            return Ok(Labels::Counted(count));
        }
        let highest = labels.clone().max().unwrap_or(0);
        if highest <= 4 * count as u64 + 1000 {
            // numbers without large gaps, as nearly always
            let mut table = vec![u32::MAX; highest as usize + 1];
            for (i, label) in labels.enumerate() {
                if std::mem::replace(&mut table[label as usize], i as u32) != u32::MAX {
                    return Err(label);
                }
            }
            return Ok(Labels::Dense(table));
        }
        let mut table: Vec<(u64, u32)> = labels.enumerate().map(|(i, label)| (label, i as u32)).collect();
        table.sort_unstable();
        match table.windows(2).find(|w| w[0].0 == w[1].0) {
            Some(twice) => Err(twice[0].0),
            None => Ok(Labels::Sparse(table)),
        }
    }

    /// The index of the thing with that number.
    pub(super) fn find(&self, label: u64) -> Option<u32> {
        match self {
            Labels::Counted(count) => label.checked_sub(1).filter(|&i| i < *count as u64).map(|i| i as u32),
            Labels::Dense(table) => {
                usize::try_from(label).ok().and_then(|i| table.get(i).copied()).filter(|&i| i != u32::MAX)
            }
            Labels::Sparse(table) => table.binary_search_by_key(&label, |e| e.0).ok().map(|at| table[at].1),
        }
    }

    /// The lowest number not below `label` that something has.
    pub(super) fn next(&self, label: u64) -> Option<u64> {
        match self {
            Labels::Counted(count) => Some(label.max(1)).filter(|&l| l <= *count as u64),
            Labels::Dense(table) => (label..table.len() as u64).find(|&l| table[l as usize] != u32::MAX),
            Labels::Sparse(table) => table.get(table.partition_point(|e| e.0 < label)).map(|e| e.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_three_tables_agree_with_a_search() {
        for labels in [vec![1, 2, 3], vec![7, 3, 9], vec![5_000_000_000, 2, 70_000], vec![]] {
            let table = Labels::new(labels.iter().copied()).ok().unwrap();
            for label in [0, 1, 2, 3, 4, 6, 7, 8, 9, 10, 70_000, 70_001, 5_000_000_000, u64::MAX] {
                assert_eq!(table.find(label), labels.iter().position(|&l| l == label).map(|i| i as u32));
                assert_eq!(
                    table.next(label),
                    labels.iter().copied().filter(|&l| l >= label).min(),
                    "{label} {labels:?}"
                );
            }
        }
        assert_eq!(Labels::new([4, 5, 4].into_iter()).err(), Some(4));
        assert_eq!(Labels::new([1, 70_000_000, 70_000_000].into_iter()).err(), Some(70_000_000));
    }
}
