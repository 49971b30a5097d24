//! From ties to rows of `B` that no other row repeats, each with a node of its own.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use super::Tie;
use crate::Error;
use crate::fem::DofMap;
use crate::mesh::v3::{V3, dot};
use crate::run::pose::activity::Period;

/// Entries below this part of the largest of a tie are rounding once others have been taken from it.
const DEPENDENT: f64 = 1e-12;

/// A combination of ties by degrees of freedom.
#[derive(Clone, Debug)]
pub(super) struct Row {
    pub entries: BTreeMap<u32, f64>,
    /// The ties it is made of, with their factors.
    pub made_of: BTreeMap<usize, f64>,
}

impl Row {
    /// Adds `factor` times another.
    fn add(&mut self, factor: f64, other: &Row) {
        other.entries.iter().for_each(|(&dof, v)| *self.entries.entry(dof).or_default() += factor * v);
        other.made_of.iter().for_each(|(&k, v)| *self.made_of.entry(k).or_default() += factor * v);
    }

    fn scale(&mut self, factor: f64) {
        self.entries.values_mut().chain(self.made_of.values_mut()).for_each(|v| *v *= factor);
    }

    /// Its components at a node that are free.
    fn at(&self, dofs: &DofMap, node: u32) -> V3 {
        [0, 1, 2].map(|c| {
            let dof = 3 * node + c;
            let free = dofs.unknown[dof as usize] != u32::MAX;
            if free { self.entries.get(&dof).copied().unwrap_or(0.0) } else { 0.0 }
        })
    }

    fn free_nodes(&self, dofs: &DofMap) -> Vec<u32> {
        let free = self.entries.keys().filter(|&&dof| dofs.unknown[dof as usize] != u32::MAX);
        let mut nodes: Vec<u32> = free.map(|dof| dof / 3).collect();
        nodes.dedup();
        nodes
    }
}

/// Up to three rows at a node, with what they are made of in each period in which they hold.
#[derive(Debug, Clone)]
pub(crate) struct TiedPoint {
    pub node: u32,
    pub rows: Vec<BTreeMap<u32, f64>>,
    pub periods: Vec<(Period, Vec<BTreeMap<usize, f64>>)>,
}

/// What follows from other ties and supports: its value has to follow too.
#[derive(Debug, Clone)]
pub(crate) struct Redundant {
    pub period: Period,
    pub tie: usize,
    pub made_of: Vec<(usize, f64)>,
    /// What is left of it, at prescribed degrees of freedom.
    pub held: Vec<(u32, f64)>,
}

/// The rows of all ties, of which `taken` are the nodes that contact points reach.
///
/// Ties that share nodes are cut at the times at which one of them begins or ends. Within a period all hold at once: each
/// gets a node at which its row, less what the others hold, is of length one and across their rows there. Rows that are the
/// same in several periods are one.
///
/// # Errors
/// An equation that repeats or contradicts others.
pub(super) fn eliminate(
    ties: &[Tie],
    dofs: &DofMap,
    taken: &HashSet<u32>,
) -> Result<(Vec<TiedPoint>, Vec<Redundant>), Error> {
    let (mut points, mut redundant) = (Vec::new(), Vec::new());
    for together in components(ties, dofs) {
        let mut own: Vec<TiedPoint> = Vec::new();
        for (number, period) in periods(ties, &together).into_iter().enumerate() {
            let holds = |&&k: &&usize| ties[k].period[0] <= period[0] && period[1] <= ties[k].period[1];
            let list: Vec<usize> = together.iter().filter(holds).copied().collect();
            let made = rows(ties, &list, period, dofs, taken, &mut redundant)?;
            for (node, rows) in by_node(made) {
                let (rows, made_of): (Vec<_>, Vec<_>) = rows.into_iter().map(|row| (row.entries, row.made_of)).unzip();
                let same = |point: &&mut TiedPoint| number > 0 && point.node == node && point.rows == rows;
                match own.iter_mut().find(same) {
                    Some(point) => point.periods.push((period, made_of)),
                    None => own.push(TiedPoint { node, rows, periods: vec![(period, made_of)] }),
                }
            }
        }
        points.append(&mut own);
    }
    Ok((points, redundant))
}

/// Ties that hang together through free displacements, each list ascending.
fn components(ties: &[Tie], dofs: &DofMap) -> Vec<Vec<usize>> {
    let mut parent: Vec<usize> = (0..ties.len()).collect();
    fn root(parent: &mut [usize], mut k: usize) -> usize {
        while parent[k] != k {
            parent[k] = parent[parent[k]];
            k = parent[k];
        }
        k
    }
    let mut first_at: HashMap<u32, usize> = HashMap::new();
    for (k, tie) in ties.iter().enumerate() {
        for &dof in tie.entries.keys().filter(|&&dof| dofs.unknown[dof as usize] != u32::MAX) {
            let other = *first_at.entry(dof / 3).or_insert(k);
            let (a, b) = (root(&mut parent, k), root(&mut parent, other));
            parent[a.max(b)] = a.min(b);
        }
    }
    let mut lists: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    (0..ties.len()).for_each(|k| lists.entry(root(&mut parent, k)).or_default().push(k));
    lists.into_values().collect()
}

/// The stretches of time between the beginnings and ends of some ties, where one of them holds.
fn periods(ties: &[Tie], together: &[usize]) -> Vec<Period> {
    let mut times: Vec<f64> = together.iter().flat_map(|&k| ties[k].period).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    let holds =
        |&[begin, end]: &Period| together.iter().any(|&k| ties[k].period[0] <= begin && end <= ties[k].period[1]);
    times.windows(2).map(|w| [w[0], w[1]]).filter(holds).collect()
}

/// The rows of ties that all hold in `period`, each with its node.
fn rows(
    ties: &[Tie],
    list: &[usize],
    period: Period,
    dofs: &DofMap,
    taken: &HashSet<u32>,
    redundant: &mut Vec<Redundant>,
) -> Result<Vec<(u32, Row)>, Error> {
    let mut reached: HashSet<u32> = HashSet::new();
    let mut made: Vec<(u32, Row)> = Vec::new();
    let mut at_node: HashMap<u32, Vec<usize>> = HashMap::new();
    for &number in list {
        let tie = &ties[number];
        let row = Row { entries: tie.entries.clone(), made_of: BTreeMap::from([(number, 1.0)]) };
        let mut row = reduced(row, &made, &at_node, dofs);
        let candidates = row.free_nodes(dofs);
        let size = |node: &u32| dot(row.at(dofs, *node), row.at(dofs, *node)).sqrt();
        // Nodes of other points last: multigrid wants a node for each.
        let is_taken = |node: &u32| taken.contains(node) || reached.contains(node);
        let best = |a: &u32, b: &u32| is_taken(b).cmp(&is_taken(a)).then(size(a).total_cmp(&size(b)));
        let meant = tie.node.filter(|node| candidates.contains(node) && size(node) > 0.0);
        let own = meant.or_else(|| candidates.iter().copied().filter(|node| size(node) > 0.0).max_by(best));
        let Some(node) = own else {
            if tie.idle {
                let (made_of, held) = (row.made_of.into_iter().collect(), row.entries.into_iter().collect());
                redundant.push(Redundant { period, tie: number, made_of, held });
                continue;
            }
            let what = "this equation holds nothing that is free: supports or equations above it hold all of it";
            return Err(tie.spot.error(what, "take it out, or the support"));
        };
        reached.extend(candidates);
        row.scale(1.0 / dot(row.at(dofs, node), row.at(dofs, node)).sqrt());
        at_node.entry(node).or_default().push(made.len());
        made.push((node, row));
    }
    Ok(made)
}

/// `row` without what the rows `made` hold at their own nodes. Each of these holds nothing of those before it there, so that
/// one pass in their order will do.
fn reduced(mut row: Row, made: &[(u32, Row)], at_node: &HashMap<u32, Vec<usize>>, dofs: &DofMap) -> Row {
    let largest = row.entries.values().fold(0.0, |a: f64, v| a.max(v.abs()));
    let at = |row: &Row| -> BTreeSet<usize> {
        row.entries.keys().filter_map(|dof| at_node.get(&(dof / 3))).flatten().copied().collect()
    };
    let mut next = at(&row);
    while let Some(number) = next.pop_first() {
        let (node, other) = &made[number];
        let along = dot(row.at(dofs, *node), other.at(dofs, *node));
        if along != 0.0 {
            row.add(-along, other);
            next.extend(at(other).into_iter().filter(|&later| later > number));
        }
    }
    // What has cancelled is rounding.
    row.entries.retain(|_, v| v.abs() > DEPENDENT * largest);
    row
}

/// The rows at each node, in the order of their first.
fn by_node(made: Vec<(u32, Row)>) -> Vec<(u32, Vec<Row>)> {
    let mut list: Vec<(u32, Vec<Row>)> = Vec::new();
    let mut place: HashMap<u32, usize> = HashMap::new();
    for (node, row) in made {
        let next = list.len();
        let at = *place.entry(node).or_insert(next);
        if at == next {
            list.push((node, Vec::new()));
        }
        list[at].1.push(row);
    }
    list
}
