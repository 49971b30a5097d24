//! What a summary says of several ranks beside what it says of one machine.

use serde::{Deserialize, Serialize};

use crate::ranks::Wire;

/// What one rank has had and sent.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct RankRecord {
    /// Nodes with unknown displacements that it owns.
    pub nodes: usize,
    /// Nodes of others that these are coupled to.
    pub ghosts: usize,
    /// Contact points that it owns.
    pub points: usize,
    /// Exchanges of values at the borders of all levels, a cycle.
    pub exchanges_per_cycle: f64,
    /// Bytes sent in these, a cycle.
    pub bytes_per_cycle: f64,
    /// Messages of all kinds sent, a cycle; those of the certificate are counted.
    pub messages_per_cycle: f64,
    /// Sums and maxima over all ranks, for which every rank waits, a cycle; those of the start and of the certificate are counted.
    pub sums_per_cycle: f64,
    /// Largest memory of its process, bytes. Ranks that are threads share one.
    pub peak_memory_bytes: Option<u64>,
}

impl RankRecord {
    pub(in crate::run) fn to_bytes(self) -> Vec<u8> {
        let mut bytes = Vec::new();
        let peak = self.peak_memory_bytes.unwrap_or(u64::MAX);
        [self.nodes as u64, self.ghosts as u64, self.points as u64, peak].write(&mut bytes);
        [self.exchanges_per_cycle, self.bytes_per_cycle, self.messages_per_cycle, self.sums_per_cycle]
            .write(&mut bytes);
        bytes
    }

    pub(in crate::run) fn from_bytes(bytes: &[u8]) -> RankRecord {
        let [nodes, ghosts, points, peak] = <[u64; 4]>::read(bytes);
        let [exchanges_per_cycle, bytes_per_cycle, messages_per_cycle, sums_per_cycle] = <[f64; 4]>::read(&bytes[32..]);
        RankRecord {
            nodes: nodes as usize,
            ghosts: ghosts as usize,
            points: points as usize,
            exchanges_per_cycle,
            bytes_per_cycle,
            messages_per_cycle,
            sums_per_cycle,
            peak_memory_bytes: Some(peak).filter(|&peak| peak != u64::MAX),
        }
    }
}

/// What `summary.json` says of a run on several ranks beside what it says of one machine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RanksRecord {
    /// Nodes of the mesh.
    pub nodes: u64,
    /// Cells of the mesh.
    pub cells: u64,
    /// Whether rank 0 has found the answer alone, as `stiction solve` does: after all ranks together had not, or on a small mesh of those
    /// that are refined.
    pub found_by_first: bool,
    /// Nodes of each level, the finest first, and entries of its matrix.
    pub levels: Vec<(usize, usize)>,
    /// What each rank has had.
    pub ranks: Vec<RankRecord>,
}
