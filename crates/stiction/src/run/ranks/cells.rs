//! Cells of a mesh that no rank has as a whole.

use crate::mesh::{CellKind, Cells, ascending};
use crate::ranks::{put, take};

/// The kinds of the cells by their numbers, which run through the kinds in the order of [`CellKind::ALL`].
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Kinds {
    /// Where the numbers of each kind end.
    pub ends: [u64; CellKind::ALL.len()],
}

impl Kinds {
    /// The kind of a cell of the whole.
    pub(super) fn of(&self, number: u64) -> CellKind {
        CellKind::ALL[self.ends.partition_point(|&end| end <= number).min(CellKind::ALL.len() - 1)]
    }

    /// Cells of the whole.
    pub(super) fn count(&self) -> u64 {
        self.ends[CellKind::ALL.len() - 1]
    }
}

/// Some cells.
#[derive(Debug, Clone, Default)]
pub(super) struct CellList {
    /// Of each in the whole.
    pub numbers: Vec<u64>,
    /// Of each; what the classes are is known elsewhere.
    pub classes: Vec<u32>,
    /// The numbers of the nodes of all, one cell after the other.
    pub nodes: Vec<u64>,
}

impl CellList {
    pub(super) fn push(&mut self, number: u64, class: u32, nodes: &[u64]) {
        self.numbers.push(number);
        self.classes.push(class);
        self.nodes.extend_from_slice(nodes);
    }

    /// Number, class and nodes of each.
    pub(super) fn iter(&self, kinds: &Kinds) -> impl Iterator<Item = (u64, u32, &[u64])> {
        let mut first = 0;
        self.numbers.iter().zip(&self.classes).map(move |(&number, &class)| {
            let from = first;
            first += kinds.of(number).nodes();
            (number, class, &self.nodes[from..first])
        })
    }

    /// As a message.
    pub(super) fn to_bytes(&self) -> Vec<u8> {
        let mut to = Vec::new();
        put(&self.numbers, &mut to);
        put(&self.classes, &mut to);
        put(&self.nodes, &mut to);
        to
    }

    /// The cells of some messages of [`Self::to_bytes`], each once, ascending.
    pub(super) fn of(messages: Vec<Vec<u8>>, kinds: &Kinds) -> CellList {
        let mut all = CellList::default();
        for message in messages.into_iter().filter(|message| !message.is_empty()) {
            let from = &mut &message[..];
            all.numbers.extend(take::<u64>(from));
            all.classes.extend(take::<u32>(from));
            all.nodes.extend(take::<u64>(from));
        }
        all.in_order(kinds)
    }

    /// Each once, ascending.
    pub(super) fn in_order(self, kinds: &Kinds) -> CellList {
        if self.numbers.is_sorted_by(|a, b| a < b) {
            return self;
        }
        let (mut order, mut first) = (Vec::with_capacity(self.numbers.len()), 0);
        for (k, &number) in self.numbers.iter().enumerate() {
            order.push((number, k as u32, first));
            first += kinds.of(number).nodes();
        }
        order.sort_unstable();
        order.dedup_by_key(|(number, ..)| *number);
        let mut sorted = CellList::default();
        sorted.nodes.reserve_exact(self.nodes.len());
        for (number, k, first) in order {
            sorted.push(number, self.classes[k as usize], &self.nodes[first..first + kinds.of(number).nodes()]);
        }
        sorted
    }

    /// The numbers of their nodes, ascending.
    pub(super) fn node_numbers(&self) -> Vec<u64> {
        ascending(self.nodes.iter().copied())
    }

    /// Cells that ascend, kind by kind, by the places of their nodes in `numbers`.
    pub(super) fn blocks(&self, kinds: &Kinds, numbers: &[u64]) -> Vec<Cells> {
        let place = |&node: &u64| numbers.partition_point(|&other| other < node) as u32;
        let mut blocks: Vec<Cells> = Vec::new();
        for (number, _, nodes) in self.iter(kinds) {
            let kind = kinds.of(number);
            if blocks.last().is_none_or(|block| block.kind != kind) {
                blocks.push(Cells { kind, nodes: Vec::new() });
            }
            let last = blocks.len() - 1;
            blocks[last].nodes.extend(nodes.iter().map(place));
        }
        blocks
    }
}
