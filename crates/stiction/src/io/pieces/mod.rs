//! A problem that is divided among ranks, its solution and its load steps as a file of each rank, and the whole that these make.
//!
//! A file holds what belongs to its rank: the rows of the matrices at own nodes, the numbers at own points. Nodes have their
//! numbers in the whole mesh, so that pieces of any number of ranks fit together. All pieces of a run carry its number.

mod join;
mod piece;
mod steps;
mod write;

use std::collections::HashMap;

pub use join::{Places, WholeProblem, read_pieces};
pub(crate) use steps::{displacements_of_step, of_points_of_step};
pub(crate) use write::{write_problem_piece, write_solution_piece, write_step_piece};

use crate::contact::{ContactProblem, Division};

/// Which piece of which run a file is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Head {
    /// The number of the run: other numbers in the files, other number.
    pub run: u64,
    /// The rank that has written the piece, from zero.
    pub rank: usize,
    /// How many there are.
    pub ranks: usize,
}

/// The names in the whole of what a rank has, and what of it is its own.
#[derive(Debug, Clone, Default)]
pub(crate) struct NamedPiece {
    /// Of each unknown: three times the number of its node, and its direction there; they ascend.
    pub unknowns: Vec<u64>,
    /// Of each prescribed displacement, likewise.
    pub supports: Vec<u64>,
    /// Of each point: its pair, the number of its node, and which of the points of that pair at the node it is.
    pub points: Vec<[u64; 3]>,
    /// Places of the own unknowns.
    pub own_unknowns: Vec<u32>,
    /// Places of the own prescribed displacements.
    pub own_supports: Vec<u32>,
    /// Places of the own points.
    pub own_points: Vec<u32>,
}

impl NamedPiece {
    /// Names what `problem` has; `free` and `prescribed` are the degrees of freedom of its unknowns and of its prescribed
    /// displacements, three at a node.
    pub(crate) fn new(problem: &ContactProblem, division: &Division, [free, prescribed]: [&[u32]; 2]) -> NamedPiece {
        let name = |&dof: &u32| 3 * division.global[(dof / 3) as usize] + u64::from(dof % 3);
        let own = |list: &mut dyn Iterator<Item = u32>| -> Vec<u32> {
            list.enumerate().filter(|(_, node)| division.is_own(*node)).map(|(place, _)| place as u32).collect()
        };
        let mut seen: HashMap<(u64, u64), u64> = HashMap::new();
        let mut points = Vec::with_capacity(division.points.len());
        for (j, &node) in division.points.iter().enumerate() {
            let pair = problem.labels.pairs.partition_point(|pair| pair.points.end <= j) as u64;
            let node = division.global[node as usize];
            let count = seen.entry((pair, node)).or_insert(0);
            points.push([pair, node, *count]);
            *count += 1;
        }
        NamedPiece {
            unknowns: free.iter().map(name).collect(),
            supports: prescribed.iter().map(name).collect(),
            points,
            own_unknowns: own(&mut free.iter().map(|dof| dof / 3)),
            own_supports: own(&mut prescribed.iter().map(|dof| dof / 3)),
            own_points: own(&mut division.points.iter().copied()),
        }
    }

    /// The values at own unknowns, of those at all.
    pub(crate) fn of_unknowns<T: Copy>(&self, values: &[T]) -> Vec<T> {
        self.own_unknowns.iter().map(|&i| values[i as usize]).collect()
    }

    /// The values at own prescribed displacements, of those at all.
    pub(crate) fn of_supports<T: Copy>(&self, values: &[T]) -> Vec<T> {
        self.own_supports.iter().map(|&i| values[i as usize]).collect()
    }

    /// The values at own points, of those at all: one list, or several of the same length one after the other.
    pub(crate) fn of_points<T: Copy>(&self, values: &[T]) -> Vec<T> {
        let lists = values.chunks_exact(self.points.len().max(1));
        lists.flat_map(|list| self.own_points.iter().map(|&j| list[j as usize])).collect()
    }
}

/// The file of the problem of a rank.
pub(crate) fn problem_name(rank: usize) -> String {
    format!("problem-{rank:04}.npz")
}

/// The file of the solution of a rank.
pub(crate) fn solution_name(rank: usize) -> String {
    format!("solution-{rank:04}.npz")
}

/// The file of solution `number`, from 2, of a rank.
pub(crate) fn other_solution_name(number: usize, rank: usize) -> String {
    format!("solution-{number:04}-{rank:04}.npz")
}

/// The file of load step `number`, from 1, of a rank.
pub(crate) fn step_name(number: usize, rank: usize) -> String {
    format!("step-{number:04}-{rank:04}.npz")
}

/// Whether a file of this name is a piece of a problem, of a solution or of a load step.
pub(crate) fn is_piece(name: &str) -> bool {
    let Some(stem) = name.strip_suffix(".npz") else { return false };
    let digits = |text: &str| text.len() >= 4 && text.bytes().all(|b| b.is_ascii_digit());
    match stem.split('-').collect::<Vec<_>>()[..] {
        ["problem" | "solution", rank] => digits(rank),
        ["step" | "solution", number, rank] => digits(number) && digits(rank),
        _ => false,
    }
}

/// What a number of an unknown or of a prescribed displacement means.
fn of_node(name: u64) -> String {
    format!("displacement {} of node {}", ["x", "y", "z"][(name % 3) as usize], name / 3)
}
