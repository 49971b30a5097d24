//! Linear equations between displacements, and supports that are released, as contact points that are tied: the rows of `B`
//! are the equations, the gap and the slip reference their values. No law and no solver knows more of them. A point that is
//! released has neither friction nor a gap that anything could close.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use super::{place, regions};
use crate::Error;
use crate::contact::{ContactProblem, Friction, Pair};
use crate::fem::{DofMap, Field, Fix};
use crate::io::case::{EquationSpec, Spot};
use crate::linalg::Csr;
use crate::mesh::v3::{V3, add, dot, scale};
use crate::mesh::{Bounds, Mesh};

/// What their points are called among the pairs.
const TIES: &str = "equations";

/// Entries below this part of the largest of an equation are rounding once others have been taken from it.
const DEPENDENT: f64 = 1e-12;

/// The gap of what is released over the size of the problem.
const WIDE: f64 = 1e6;

/// The ties of a case on its mesh.
#[derive(Debug, Clone, Default)]
pub struct Ties {
    /// Their values at a place, and where the case asks for them.
    values: Vec<(Field, V3, Spot)>,
    rows: Vec<RowOfB>,
    /// The first of their points.
    first: usize,
    /// The time until which each point is tied.
    until: Vec<f64>,
    /// The gap of a point that is released, length.
    wide: f64,
}

/// An equation with its value.
pub(crate) struct Tie {
    /// Factors by degrees of freedom.
    pub entries: BTreeMap<u32, f64>,
    value: Field,
    /// Where the value is read; NaN where it has no place.
    at: V3,
    /// When it is released.
    until: f64,
    spot: Spot,
    /// Whether it may hold nothing that is free.
    idle: bool,
}

/// A row of `B` that holds equations.
#[derive(Debug, Clone)]
struct RowOfB {
    row: usize,
    /// The equations it is made of, with their factors.
    made_of: Vec<(usize, f64)>,
    /// The sum of its vectors.
    sum: V3,
}

/// A combination of equations by degrees of freedom.
#[derive(Clone)]
struct Row {
    entries: BTreeMap<u32, f64>,
    made_of: BTreeMap<usize, f64>,
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
}

/// What a case asks for between displacements.
pub(crate) fn ties_of_equations(mesh: &Mesh, dofs: &DofMap, specs: &[EquationSpec]) -> Result<Vec<Tie>, Error> {
    let tie = |spec: &EquationSpec| {
        let (value, spot) = (spec.value.clone(), spec.spot.clone());
        Ok(Tie {
            entries: entries(mesh, dofs, spec)?,
            value,
            at: [f64::NAN; 3],
            until: f64::INFINITY,
            spot,
            idle: false,
        })
    };
    specs.iter().map(tie).collect()
}

/// Supports that are released, each with the time.
pub(crate) fn ties_of_supports(mesh: &Mesh, dofs: &DofMap, released: &[(Fix, f64, Spot)]) -> Result<Vec<Tie>, Error> {
    let mut ties = Vec::new();
    for (fix, until, spot) in released {
        for &node in &fix.nodes {
            let at = mesh.nodes[node as usize];
            for (c, value) in fix.value.iter().enumerate().filter_map(|(c, value)| Some((c, value.clone()?))) {
                let along = fix.axes.direction(c, at).ok_or_else(|| {
                    let what = format!("node {} at {at:?} lies on the axis of the cylinder", node + 1);
                    spot.error(what, "hold it by a [[fix]] of its own along x, y, z")
                })?;
                let parts = (0..3).zip(dofs.components(node, along)).filter(|(_, part)| *part != 0.0);
                let entries = parts.map(|(c, part)| (3 * node + c, part)).collect();
                ties.push(Tie { entries, value, at, until: *until, spot: spot.clone(), idle: true });
            }
        }
    }
    Ok(ties)
}

impl Ties {
    /// Whether there are none.
    pub(crate) fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Adds to `motion`, `3m`, what the sums are at time `t`, while supports travel by `travel`.
    ///
    /// # Errors
    /// A value that is not finite.
    pub(crate) fn put_into(&self, motion: &mut [f64], travel: V3, t: f64) -> Result<(), Error> {
        let at =
            |(field, x, spot): &(Field, V3, Spot)| field.finite_at(*x, t).map_err(|error| place::instead(spot, error));
        let values: Vec<f64> = self.values.iter().map(at).collect::<Result<_, _>>()?;
        for RowOfB { row, made_of, sum } in &self.rows {
            motion[*row] += made_of.iter().map(|(k, factor)| factor * values[*k]).sum::<f64>() - dot(*sum, travel);
        }
        Ok(())
    }

    /// The laws at time `t`, of which `changed` has those that change otherwise and `posed` all as they are; nothing where
    /// none changes.
    pub(crate) fn laws(&self, changed: Option<Vec<Friction>>, posed: &[Friction], t: f64) -> Option<Vec<Friction>> {
        if self.until.iter().all(|until| until.is_infinite()) {
            return changed;
        }
        let mut laws = changed.unwrap_or_else(|| posed.to_vec());
        for (law, &until) in laws[self.first..].iter_mut().zip(&self.until) {
            // The time at the end of a step is that of the case to the last digit.
            *law = if t <= until { Friction::Bonded } else { Friction::None };
        }
        Some(laws)
    }

    /// Opens the gaps of what is released by `laws`.
    pub(crate) fn open_released(&self, gap: &mut [f64], laws: &[Friction]) {
        for j in self.first..self.first + self.until.len() {
            if laws[j] == Friction::None {
                gap[j] += self.wide;
            }
        }
    }

    /// The number of contact points of `problem` that are none of ties.
    pub(crate) fn points_before(&self, problem: &ContactProblem) -> usize {
        if self.until.is_empty() { problem.points() } else { self.first }
    }

    /// Adds the points of `ties` to `problem`.
    ///
    /// Each tie gets a node at which its row, less what others hold that are released no earlier, is of length one and across
    /// their rows there; up to three rows at a node are a point.
    ///
    /// # Errors
    /// An equation that repeats or contradicts others.
    pub(crate) fn new(
        mesh: &Mesh,
        dofs: &DofMap,
        mut ties: Vec<Tie>,
        problem: &mut ContactProblem,
    ) -> Result<Ties, Error> {
        if ties.is_empty() {
            return Ok(Ties::default());
        }
        ties.sort_by(|a, b| b.until.total_cmp(&a.until));
        let mut taken = nodes_of_points(dofs, problem);
        let mut made: Vec<(u32, Row)> = Vec::new();
        let mut at_node: HashMap<u32, Vec<usize>> = HashMap::new();
        for (number, tie) in ties.iter().enumerate() {
            let row = Row { entries: tie.entries.clone(), made_of: BTreeMap::from([(number, 1.0)]) };
            let mut row = reduced(row, &made, &at_node, dofs);
            let mut candidates: Vec<u32> = row.entries.keys().map(|dof| dof / 3).collect();
            candidates.dedup();
            let size = |node: &u32| dot(row.at(dofs, *node), row.at(dofs, *node)).sqrt();
            // Nodes of other points last: multigrid wants a node for each.
            let best = |a: &u32, b: &u32| taken.contains(b).cmp(&taken.contains(a)).then(size(a).total_cmp(&size(b)));
            let own = candidates.iter().copied().filter(|node| size(node) > 0.0).max_by(best);
            let Some(node) = own else {
                if tie.idle {
                    continue;
                }
                let what = "this equation holds nothing that is free: supports or equations above it hold all of it";
                return Err(tie.spot.error(what, "take it out, or the support"));
            };
            taken.extend(candidates);
            row.scale(1.0 / dot(row.at(dofs, node), row.at(dofs, node)).sqrt());
            at_node.entry(node).or_default().push(made.len());
            made.push((node, row));
        }
        // Points: the rows at a node that are released together.
        let mut own: Vec<(f64, Vec<&Row>)> = Vec::new();
        let mut place_of: HashMap<(u32, u64), usize> = HashMap::new();
        for (node, row) in &made {
            let until = row.made_of.keys().map(|&k| ties[k].until).fold(f64::INFINITY, f64::min);
            let next = own.len();
            let at = *place_of.entry((*node, until.to_bits())).or_insert(next);
            if at == next {
                own.push((until, Vec::new()));
            }
            own[at].1.push(row);
        }
        let first = problem.points();
        append(dofs, &own, problem);
        let m = problem.points();
        let mut rows = Vec::new();
        for (j, (_, of_point)) in own.iter().enumerate() {
            for (k, row) in of_point.iter().enumerate() {
                let vectors = row.entries.iter().map(|(&dof, &v)| scale(v, dofs.direction(dof)));
                let (made_of, sum) = (row.made_of.iter().map(|(&k, &v)| (k, v)).collect(), vectors.fold([0.0; 3], add));
                rows.push(RowOfB { row: k * m + first + j, made_of, sum });
            }
        }
        let until = own.iter().map(|point| point.0).collect();
        let wide = WIDE * Bounds::around(mesh.nodes.iter().copied()).diagonal();
        let values = ties.into_iter().map(|tie| (tie.value, tie.at, tie.spot)).collect();
        Ok(Ties { values, rows, first, until, wide })
    }
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

/// The equation by degrees of freedom.
fn entries(mesh: &Mesh, dofs: &DofMap, spec: &EquationSpec) -> Result<BTreeMap<u32, f64>, Error> {
    let mut entries: BTreeMap<u32, f64> = BTreeMap::new();
    for term in &spec.terms {
        for node in regions::nodes(mesh, &term.on, &term.spot)? {
            for (c, part) in (0..3).zip(dofs.components(node, scale(term.factor, term.along))) {
                if part != 0.0 {
                    *entries.entry(3 * node + c).or_default() += part;
                }
            }
        }
    }
    entries.retain(|_, v| *v != 0.0);
    Ok(entries)
}

/// Nodes that contact points reach.
fn nodes_of_points(dofs: &DofMap, problem: &ContactProblem) -> HashSet<u32> {
    problem.contact.B.column.iter().map(|&unknown| dofs.free[unknown as usize] / 3).collect()
}

/// Adds the points: tied, without an area, and with forces that are none between bodies.
fn append(dofs: &DofMap, own: &[(f64, Vec<&Row>)], problem: &mut ContactProblem) {
    let (before, more) = (problem.points(), own.len());
    let m = before + more;
    let (mut free, mut prescribed) = (Vec::new(), Vec::new());
    for (j, (_, rows)) in own.iter().enumerate() {
        for (k, row) in rows.iter().enumerate() {
            for (&dof, &value) in &row.entries {
                let unknown = dofs.unknown[dof as usize];
                if unknown != u32::MAX {
                    free.push((k * m + before + j, unknown as usize, value));
                } else if let Ok(p) = dofs.prescribed.binary_search(&dof) {
                    prescribed.push((k * m + before + j, p, value));
                }
            }
        }
    }
    let wider = |old: &Csr, mut entries: Vec<(usize, usize, f64)>| {
        let moved = |i: usize| (i / before.max(1)) * m + i % before.max(1);
        entries.extend(old.entries().map(|(i, j, v)| (moved(i), j, v)));
        Csr::from_triplets(3 * m, old.cols, &entries)
    };
    let ContactProblem { contact, labels, .. } = problem;
    contact.B = wider(&contact.B, free);
    let held = match &mut labels.supports {
        Some(supports) => {
            supports.B = wider(&supports.B, prescribed);
            supports.B.times(&supports.displacement)
        }
        None => vec![0.0; 3 * m],
    };
    // As posed, the sums are zero.
    let at = |k: usize| (0..more).map(|j| 0.0 - held[k * m + before + j]).collect::<Vec<f64>>();
    contact.gap.extend(at(0));
    let second = contact.slip_reference.split_off(before);
    contact.slip_reference.extend(at(1));
    contact.slip_reference.extend(second);
    contact.slip_reference.extend(at(2));
    contact.friction.resize(m, Friction::Bonded);
    if let Some(orthotropy) = &mut contact.orthotropy {
        orthotropy.resize(m, 1.0);
    }
    labels.area.resize(m, 0.0);
    labels.unity_sum.resize(m, 0.0);
    labels.pairs.push(Pair { name: TIES.into(), points: before..m });
}
