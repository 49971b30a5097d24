use std::fmt;
use std::sync::Arc;

use super::ContactProblem;
use crate::ranks::Ranks;

/// Which part of a problem belongs to a rank, where each rank has a problem of its own: that of its nodes and of those around
/// them. The rows of `K` at own nodes, the load and the contact points there are complete.
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

    /// The node of each contact point: the label of the first unknown that its rows reach. None of a point without a row.
    pub fn nodes_of_points(&self, problem: &ContactProblem) -> Vec<Option<u32>> {
        let labels = problem.elastic.node_of.as_deref().unwrap_or_default();
        let unknown = |j: usize| {
            let mut rows = problem.rows(j).into_iter().map(|i| problem.contact.B.row(i));
            rows.find_map(|(columns, values)| values.iter().position(|v| *v != 0.0).map(|at| columns[at]))
        };
        (0..problem.points()).map(|j| Some(labels[unknown(j)? as usize])).collect()
    }
}
