//! Numbers of elements, which nearly always count up by one.

/// A list of numbers, kept as stretches in which each is one more than the last.
#[derive(Default)]
pub(super) struct Tags {
    /// The first number of each stretch and its place in the list.
    stretches: Vec<(u64, usize)>,
    count: usize,
}

impl Tags {
    pub(super) fn push(&mut self, tag: u64) {
        let goes_on = self
            .stretches
            .last()
            .is_some_and(|&(first, place)| first.checked_add((self.count - place) as u64) == Some(tag));
        if !goes_on {
            self.stretches.push((tag, self.count));
        }
        self.count += 1;
    }

    pub(super) fn len(&self) -> usize {
        self.count
    }

    /// The number at place `i < len()`.
    pub(super) fn get(&self, i: usize) -> u64 {
        let (first, place) = self.stretches[self.stretches.partition_point(|stretch| stretch.1 <= i) - 1];
        first + (i - place) as u64
    }

    /// All numbers in their order.
    pub(super) fn iter(&self) -> impl ExactSizeIterator<Item = u64> + Clone {
        (0..self.count).map(|i| self.get(i))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_come_back_as_they_went_in() {
        for list in [vec![1, 2, 3], vec![7, 8, 3, 4, 4, 5], vec![u64::MAX - 1, u64::MAX, 0, 1], vec![]] {
            let mut tags = Tags::default();
            list.iter().for_each(|&tag| tags.push(tag));
            assert_eq!((tags.len(), tags.iter().collect::<Vec<_>>()), (list.len(), list));
        }
    }
}
