//! Linear equations between displacements, as contact points that are tied: the rows of `B` are the equations, the gap and
//! the slip reference their values. No law and no solver knows more of them.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use super::{place, regions};
use crate::Error;
use crate::contact::{ContactProblem, Friction, Pair};
use crate::fem::{DofMap, Field};
use crate::io::case::{EquationSpec, Spot};
use crate::linalg::Csr;
use crate::mesh::Mesh;
use crate::mesh::v3::{V3, add, dot, scale};

/// What the points of equations are called among the pairs.
pub(crate) const EQUATIONS: &str = "equations";

/// Entries below this part of the largest of an equation are rounding once others have been taken from it.
const DEPENDENT: f64 = 1e-12;

/// The equations of a case on its mesh.
#[derive(Debug, Clone, Default)]
pub struct Equations {
    /// Their values by the number of the equation, and where the case asks for them.
    values: Vec<(Field, Spot)>,
    rows: Vec<RowOfB>,
    /// The first of their points.
    first: usize,
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

impl Equations {
    /// Whether there are none.
    pub(crate) fn is_empty(&self) -> bool {
        self.values.is_empty()
    }

    /// Adds to `motion`, `3m`, what the sums are at time `t`, while supports travel by `travel`.
    ///
    /// # Errors
    /// A value that is not finite.
    pub(crate) fn put_into(&self, motion: &mut [f64], travel: V3, t: f64) -> Result<(), Error> {
        let at = |(field, spot): &(Field, Spot)| {
            field.finite_at([f64::NAN; 3], t).map_err(|error| place::instead(spot, error))
        };
        let values: Vec<f64> = self.values.iter().map(at).collect::<Result<_, _>>()?;
        for RowOfB { row, made_of, sum } in &self.rows {
            motion[*row] += made_of.iter().map(|(k, factor)| factor * values[*k]).sum::<f64>() - dot(*sum, travel);
        }
        Ok(())
    }

    /// The number of contact points of `problem` that are none of equations.
    pub(crate) fn points_before(&self, problem: &ContactProblem) -> usize {
        if self.is_empty() { problem.points() } else { self.first }
    }
}

/// The equations and how many displacements they hold; their points are added to `problem`.
///
/// Each equation gets a node at which its row, less what earlier ones hold, is of length one and across their rows there; up
/// to three rows at a node are a point.
///
/// # Errors
/// A region that is not of the mesh, or an equation that repeats or contradicts those above it.
pub(crate) fn equations(
    mesh: &Mesh,
    dofs: &DofMap,
    specs: &[EquationSpec],
    problem: &mut ContactProblem,
) -> Result<(Equations, usize), Error> {
    if specs.is_empty() {
        return Ok((Equations::default(), 0));
    }
    let mut taken = nodes_of_points(dofs, problem);
    let mut made: Vec<(u32, Row)> = Vec::new();
    let mut at_node: HashMap<u32, Vec<usize>> = HashMap::new();
    let (mut values, mut held) = (Vec::new(), HashSet::new());
    for (number, spec) in specs.iter().enumerate() {
        let entries = entries(mesh, dofs, spec)?;
        held.extend(entries.keys().copied());
        values.push((spec.value.clone(), spec.spot.clone()));
        let row = reduced(Row { entries, made_of: BTreeMap::from([(number, 1.0)]) }, &made, &at_node, dofs);
        let mut candidates: Vec<u32> = row.entries.keys().map(|dof| dof / 3).collect();
        candidates.dedup();
        let size = |node: &u32| dot(row.at(dofs, *node), row.at(dofs, *node)).sqrt();
        // Nodes of other points last: multigrid wants a node for each.
        let best = |a: &u32, b: &u32| taken.contains(b).cmp(&taken.contains(a)).then(size(a).total_cmp(&size(b)));
        let own = candidates.iter().copied().filter(|node| size(node) > 0.0).max_by(best);
        let Some(node) = own else {
            let what = "this equation holds nothing that is free: supports or equations above it hold all of it";
            return Err(spec.spot.error(what, "take it out, or the support"));
        };
        taken.extend(candidates);
        let mut row = row;
        row.scale(1.0 / dot(row.at(dofs, node), row.at(dofs, node)).sqrt());
        at_node.entry(node).or_default().push(made.len());
        made.push((node, row));
    }
    let mut own: Vec<(u32, Vec<&Row>)> = Vec::new();
    let mut place_of: HashMap<u32, usize> = HashMap::new();
    for (node, row) in &made {
        let next = own.len();
        let at = *place_of.entry(*node).or_insert(next);
        if at == next {
            own.push((*node, Vec::new()));
        }
        own[at].1.push(row);
    }
    let first = problem.points();
    append(dofs, &own, problem);
    let m = problem.points();
    let mut rows = Vec::new();
    for (j, (_, of_node)) in own.iter().enumerate() {
        for (k, row) in of_node.iter().enumerate() {
            let vectors = row.entries.iter().map(|(&dof, &v)| scale(v, dofs.direction(dof)));
            let (made_of, sum) = (row.made_of.iter().map(|(&k, &v)| (k, v)).collect(), vectors.fold([0.0; 3], add));
            rows.push(RowOfB { row: k * m + first + j, made_of, sum });
        }
    }
    Ok((Equations { values, rows, first }, held.len()))
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
    problem.contact.B.column.iter().map(|&unknown| dofs.mesh_node(dofs.free[unknown as usize] / 3)).collect()
}

/// Adds the points: tied, without an area, and with forces that are none between bodies.
fn append(dofs: &DofMap, own: &[(u32, Vec<&Row>)], problem: &mut ContactProblem) {
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
    labels.pairs.push(Pair { name: EQUATIONS.into(), points: before..m });
}
