//! What ranks keep of each node by its number, and how others come by it.

use crate::ranks::{Ranks, Wire, all_to_all, from_bytes, gather_all, to_bytes};

/// Which rank keeps each number: every rank a range of them.
pub(super) struct Homes {
    /// The first number of each rank, and the one after the last of all.
    starts: Vec<u64>,
    rank: usize,
}

impl Homes {
    /// This rank keeps so many, after those of the ranks before it.
    pub(super) fn new(ranks: &dyn Ranks, own: usize) -> Homes {
        let counts = gather_all(ranks, to_bytes(&[own as u64]));
        let mut starts = vec![0];
        let count = |message: &Vec<u8>| from_bytes::<u64>(message)[0];
        starts.extend(counts.iter().map(count).scan(0, |sum, count| {
            *sum += count;
            Some(*sum)
        }));
        Homes { starts, rank: ranks.rank() }
    }

    /// How many there are.
    pub(super) fn count(&self) -> u64 {
        self.starts[self.starts.len() - 1]
    }

    /// The first that this rank keeps.
    pub(super) fn first(&self) -> u64 {
        self.starts[self.rank]
    }

    /// The rank that keeps a number, which is below [`Self::count`].
    pub(super) fn of(&self, number: u64) -> usize {
        self.starts.partition_point(|&start| start <= number) - 1
    }

    /// Where this rank keeps a number of its own.
    pub(super) fn place(&self, number: u64) -> usize {
        (number - self.first()) as usize
    }
}

/// The node that leads some, at whose rank they meet: one of them by an order that has nothing to do with their numbers. By the lowest the
/// first ranks would have most of a mesh whose numbers are spread over it.
pub(super) fn leader(nodes: impl Iterator<Item = u64>) -> u64 {
    // A product with an odd number is another for each of them.
    nodes.min_by_key(|node| node.wrapping_mul(0x9e37_79b9_7f4a_7c15)).unwrap_or(0)
}

/// The way between what a rank keeps and those that have asked for it.
pub(super) struct Plan {
    /// Places at this rank of what each rank wants.
    theirs: Vec<Vec<u32>>,
    /// What this rank wants of each: ends in the list of all that it wants.
    ends: Vec<usize>,
}

impl Plan {
    /// For numbers that ascend.
    pub(super) fn new(ranks: &dyn Ranks, homes: &Homes, numbers: &[u64]) -> Plan {
        debug_assert!(numbers.is_sorted());
        let end = |rank: usize| numbers.partition_point(|&number| number < homes.starts[rank + 1]);
        let ends: Vec<usize> = (0..ranks.size()).map(end).collect();
        let asked = parts(&ends).map(|part| to_bytes(&numbers[part])).collect();
        let place = |number: u64| homes.place(number) as u32;
        let theirs =
            all_to_all(ranks, asked).into_iter().map(|message| from_bytes(&message).into_iter().map(place).collect());
        Plan { theirs: theirs.collect(), ends }
    }

    /// What is kept of all that was wanted, in its order; `own` is kept here.
    pub(super) fn fetch<T: Wire>(&self, ranks: &dyn Ranks, own: &[T]) -> Vec<T> {
        let give = |list: &Vec<u32>| to_bytes(&list.iter().map(|&place| own[place as usize]).collect::<Vec<T>>());
        let given = self.theirs.iter().map(give).collect();
        all_to_all(ranks, given).iter().flat_map(|message| from_bytes::<T>(message)).collect()
    }

    /// Tells each rank what is known here of each number that was wanted; what others tell of the numbers kept here, with its place,
    /// in the order of the ranks.
    pub(super) fn tell<T: Wire>(&self, ranks: &dyn Ranks, known: &[T]) -> Vec<(u32, T)> {
        let told = parts(&self.ends).map(|part| to_bytes(&known[part])).collect();
        let told = all_to_all(ranks, told);
        let of_rank = |(list, message): (&Vec<u32>, &Vec<u8>)| list.iter().copied().zip(from_bytes(message)).collect();
        self.theirs.iter().zip(&told).flat_map(|pair| -> Vec<(u32, T)> { of_rank(pair) }).collect()
    }

    /// The same of some of the numbers, by their places in the list that was wanted, which ascend.
    pub(super) fn tell_some<T: Wire>(&self, ranks: &dyn Ranks, known: &[(u32, T)]) -> Vec<(u32, T)> {
        let of_rank = |part: std::ops::Range<usize>| {
            let at = |end: usize| known.partition_point(|(place, _)| (*place as usize) < end);
            let mut message = Vec::new();
            for (place, value) in &known[at(part.start)..at(part.end)] {
                ((*place as usize - part.start) as u32).write(&mut message);
                value.write(&mut message);
            }
            message
        };
        let told = all_to_all(ranks, parts(&self.ends).map(of_rank).collect());
        let read = |(list, message): (&Vec<u32>, &Vec<u8>)| -> Vec<(u32, T)> {
            let entries = message.chunks_exact(u32::SIZE + T::SIZE);
            entries.map(|entry| (list[u32::read(entry) as usize], T::read(&entry[u32::SIZE..]))).collect()
        };
        self.theirs.iter().zip(&told).flat_map(read).collect()
    }
}

/// The parts of a list that end there.
fn parts(ends: &[usize]) -> impl Iterator<Item = std::ops::Range<usize>> {
    let starts = std::iter::once(0).chain(ends.iter().copied());
    starts.zip(ends).map(|(start, &end)| start..end)
}
