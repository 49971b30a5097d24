use std::fmt;
use std::sync::Arc;

use crate::ranks::Ranks;

/// Which part of a problem belongs to a rank, where each rank has a problem of its own: that of its nodes and of those around
/// them. The rows of `K` at own nodes, the load and the contact points there are complete. Where points between bodies reach own
/// nodes, `K` and the load are also complete at the nodes of these points, and `K` at those that the points of nodes here reach.
#[derive(Clone)]
pub struct Division {
    /// The ranks.
    pub ranks: Arc<dyn Ranks>,
    /// The rank of each node, by the labels of `elastic.node_of`.
    pub owner: Vec<u32>,
    /// Its number among the nodes of all ranks, by the same labels.
    pub global: Vec<u64>,
    /// The label of the node of each prescribed displacement.
    pub supports: Vec<u32>,
    /// The label of the node of each contact point, on which its rows are a frame.
    pub points: Vec<u32>,
}

impl fmt::Debug for Division {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Division of {} nodes, {:?}", self.owner.len(), self.ranks)
    }
}

impl Division {
    /// Whether a node is one of this rank.
    pub fn is_own(&self, label: u32) -> bool {
        self.owner[label as usize] as usize == self.ranks.rank()
    }
}
