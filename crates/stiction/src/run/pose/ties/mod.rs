//! Linear equations between displacements, couplings to a reference point, and supports that begin or end with a step, as
//! contact points that are tied: the rows of `B` are the equations, gap and slip reference their values. No law and no
//! solver knows more of them.

mod append;
mod eliminate;

use std::collections::{BTreeMap, HashSet};

use super::activity::{ALWAYS, Activity, Period, within};
use super::{place, regions};
use crate::Error;
use crate::contact::ContactProblem;
use crate::fem::{DofMap, Field, Fix};
use crate::io::case::{EquationSpec, Spot};
use crate::mesh::Mesh;
use crate::mesh::v3::{V3, add, dot, norm, scale, sub};

use append::append;
use eliminate::eliminate;
pub(crate) use eliminate::{Redundant, TiedPoint};

/// A normal that differs by less from what a support holds is held.
const SAME_DIRECTION: f64 = 1e-9;

/// Values that follow from one another agree to this part of the largest of them.
const SAME_VALUE: f64 = 1e-9;

/// The ties of a case on its mesh.
#[derive(Debug, Clone, Default)]
pub struct Ties {
    list: Vec<Tie>,
    /// The rows of `B` that hold them.
    rows: Vec<RowOfB>,
    redundant: Vec<Redundant>,
    /// Their points.
    first: usize,
    end: usize,
    /// The node of each point.
    nodes: Vec<u32>,
}

/// Ties and the points that hold them.
#[derive(Debug, Clone, Default)]
pub(crate) struct Tied {
    pub list: Vec<Tie>,
    pub points: Vec<TiedPoint>,
    pub redundant: Vec<Redundant>,
}

/// An equation with its value.
#[derive(Debug, Clone)]
pub(crate) struct Tie {
    /// Factors by degrees of freedom.
    pub entries: BTreeMap<u32, f64>,
    /// The sum of these times their factors.
    pub value: Vec<(f64, Field)>,
    /// Where the value is read; NaN where it has no place.
    pub at: V3,
    /// How it begins in the middle of the case.
    pub start: Start,
    /// When it holds.
    pub period: Period,
    pub spot: Spot,
    /// Whether it may follow from others and hold nothing that is free.
    pub idle: bool,
    /// Whether its forces come from outside the body, as those of supports do.
    pub is_support: bool,
    /// The node whose displacement it is meant to hold, if one.
    pub node: Option<u32>,
}

/// How a tie gets from where its nodes stand when it begins to its value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Start {
    /// It has its value at once.
    AtOnce,
    /// Its value counts from where they stand.
    Stays,
    /// On a line in time, until this time.
    Until(f64),
}

/// A row of `B` that holds ties.
#[derive(Debug, Clone)]
struct RowOfB {
    row: usize,
    /// The ties it is made of in each period, with their factors.
    periods: Vec<(Period, Vec<(usize, f64)>)>,
    /// The sum of its vectors.
    sum: V3,
}

impl RowOfB {
    fn made_of(&self, t: f64) -> &[(usize, f64)] {
        self.periods.iter().find(|(period, _)| within(*period, t)).map_or(&[], |(_, made_of)| made_of)
    }
}

impl Tie {
    /// A tie that always holds.
    pub(crate) fn always(entries: BTreeMap<u32, f64>, value: Vec<(f64, Field)>, spot: Spot) -> Tie {
        let (at, start) = ([f64::NAN; 3], Start::AtOnce);
        Tie { entries, value, at, start, period: ALWAYS, spot, idle: false, is_support: false, node: None }
    }

    /// Its value at time `t`; `stood` is what its sum was when it began.
    fn value(&self, stood: f64, t: f64) -> Result<f64, Error> {
        let at = |t| {
            self.value.iter().try_fold(0.0, |sum, (factor, field)| {
                let value = field.finite_at(self.at, t).map_err(|error| place::instead(&self.spot, error));
                value.map(|value| sum + factor * value)
            })
        };
        let begin = self.period[0];
        let left = match self.start {
            Start::AtOnce => 0.0,
            Start::Stays => 1.0,
            Start::Until(end) => ((end - t) / (end - begin)).clamp(0.0, 1.0),
        };
        Ok(if left == 0.0 { at(t)? } else { at(t)? + left * (stood - at(begin)?) })
    }
}

/// What a case asks for between displacements.
pub(crate) fn ties_of_equations(mesh: &Mesh, dofs: &DofMap, specs: &[EquationSpec]) -> Result<Vec<Tie>, Error> {
    let tie = |spec: &EquationSpec| {
        let value = vec![(1.0, spec.value.clone())];
        Ok(Tie::always(entries(mesh, dofs, spec)?, value, spec.spot.clone()))
    };
    specs.iter().map(tie).collect()
}

/// A support that does not hold in all steps.
#[derive(Debug, Clone)]
pub(crate) struct TimedFix {
    pub fix: Fix,
    pub period: Period,
    pub start: Start,
    pub spot: Spot,
}

/// Supports that begin or end with a step.
pub(crate) fn ties_of_supports(mesh: &Mesh, dofs: &DofMap, supports: &[TimedFix]) -> Result<Vec<Tie>, Error> {
    let mut ties = Vec::new();
    for TimedFix { fix, period, start, spot } in supports {
        for &node in &fix.nodes {
            let at = mesh.nodes[node as usize];
            for (c, value) in fix.value.iter().enumerate().filter_map(|(c, value)| Some((c, value.clone()?))) {
                let along = fix.axes.direction(c, at).ok_or_else(|| {
                    let what = format!("node {} at {at:?} lies on the axis of the cylinder", node + 1);
                    spot.error(what, "hold it by a [[fix]] of its own along x, y, z")
                })?;
                let (start, period) = (*start, *period);
                let spot = spot.clone();
                let of_support = Tie {
                    at,
                    start,
                    period,
                    idle: true,
                    is_support: true,
                    ..Tie::always(along_at(dofs, node, along), vec![(1.0, value)], spot)
                };
                ties.push(Tie { node: Some(node), ..of_support });
            }
        }
    }
    Ok(ties)
}

/// Of contact points on obstacles at rest, each with its node, those that a support which begins or ends with a step holds still along
/// their normals, and when: their constraint says what the support says already, as that of nodes that are always held, which carry no
/// points. Where a support moves its nodes, or the other surface can come nearer, contact has more to say.
pub(crate) fn held_along_normal(
    mesh: &Mesh,
    dofs: &DofMap,
    problem: &ContactProblem,
    points: &[(usize, u32)],
    supports: &[TimedFix],
) -> Vec<(usize, Period)> {
    let mut found = Vec::new();
    for TimedFix { fix, period, .. } in supports {
        let held: HashSet<u32> = fix.nodes.iter().copied().collect();
        let still = |value: &Option<Field>| matches!(value, None | Some(Field::Constant(0.0)));
        if !fix.value.iter().all(still) {
            continue;
        }
        for &(j, node) in points.iter().filter(|(_, node)| held.contains(node)) {
            let at = mesh.nodes[node as usize];
            let along = (0..3).filter(|&c| fix.value[c].is_some()).filter_map(|c| fix.axes.direction(c, at));
            let (columns, values) = problem.contact.B.row(j);
            let own = columns.iter().zip(values).map(|(&k, &v)| (dofs.free[k as usize], v));
            let own = own.filter(|(dof, _)| dof / 3 == node).map(|(dof, v)| scale(v, dofs.direction(dof)));
            let normal = own.fold([0.0; 3], add);
            // The axes of a support are across one another.
            let left = along.fold(normal, |left, axis| sub(left, scale(dot(left, axis), axis)));
            if norm(normal) > 0.0 && norm(left) <= SAME_DIRECTION * norm(normal) {
                found.push((j, *period));
            }
        }
    }
    found
}

/// The displacement of a node along a direction by degrees of freedom.
pub(crate) fn along_at(dofs: &DofMap, node: u32, along: V3) -> BTreeMap<u32, f64> {
    let parts = (0..3).zip(dofs.components(node, along)).filter(|(_, part)| *part != 0.0);
    parts.map(|(c, part)| (3 * node + c, part)).collect()
}

/// The equation by degrees of freedom.
fn entries(mesh: &Mesh, dofs: &DofMap, spec: &EquationSpec) -> Result<BTreeMap<u32, f64>, Error> {
    let mut entries: BTreeMap<u32, f64> = BTreeMap::new();
    for term in &spec.terms {
        for node in regions::nodes(mesh, &term.on, &term.spot)? {
            for (dof, part) in along_at(dofs, node, scale(term.factor, term.along)) {
                *entries.entry(dof).or_default() += part;
            }
        }
    }
    entries.retain(|_, v| *v != 0.0);
    Ok(entries)
}

impl Tied {
    /// The points of ties, of which `taken` are the nodes that contact points reach.
    ///
    /// # Errors
    /// An equation that repeats or contradicts others.
    pub(crate) fn new(dofs: &DofMap, list: Vec<Tie>, taken: &HashSet<u32>) -> Result<Tied, Error> {
        let (points, redundant) = eliminate(&list, dofs, taken)?;
        Ok(Tied { list, points, redundant })
    }

    /// What each tie is to be at time `t`. `stood` has what each sum was when its tie began; nothing has begun where it is empty.
    ///
    /// # Errors
    /// A value that is not finite, or one that contradicts others then.
    pub(crate) fn values(&self, dofs: &DofMap, stood: &[f64], t: f64) -> Result<Vec<f64>, Error> {
        values((&self.list, &self.redundant), dofs, stood, t)
    }
}

/// As [`Tied::values`].
fn values((list, redundant): (&[Tie], &[Redundant]), dofs: &DofMap, stood: &[f64], t: f64) -> Result<Vec<f64>, Error> {
    let value = |(k, tie): (usize, &Tie)| match within(tie.period, t) {
        true => tie.value(stood.get(k).copied().unwrap_or(0.0), t),
        false => Ok(0.0),
    };
    let values: Vec<f64> = list.iter().enumerate().map(value).collect::<Result<_, _>>()?;
    for redundant in redundant.iter().filter(|redundant| within(redundant.period, t)) {
        // Where it stood is known when it is solved, and then agrees.
        if redundant.made_of.iter().any(|(k, _)| list[*k].start != Start::AtOnce) {
            continue;
        }
        let held =
            |(dof, factor): &(u32, f64)| dofs.prescribed.binary_search(dof).map_or(0.0, |p| factor * dofs.value[p]);
        let own = redundant.made_of.iter().map(|(k, factor)| factor * values[*k]);
        let terms: Vec<f64> = own.chain(redundant.held.iter().map(|entry| -held(entry))).collect();
        let size = terms.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        if terms.iter().sum::<f64>().abs() > SAME_VALUE * size {
            let what = format!("at t = {t} other supports or couplings prescribe another value of the same");
            let remedy = "keep one of them, or let them agree where they meet";
            return Err(list[redundant.tie].spot.error(what, remedy));
        }
    }
    Ok(values)
}

impl Ties {
    /// Adds the points of ties to `problem`, and when they take part to `activity`.
    ///
    /// # Errors
    /// An equation that repeats or contradicts others.
    pub(crate) fn new(
        dofs: &DofMap,
        list: Vec<Tie>,
        problem: &mut ContactProblem,
        activity: &mut Activity,
    ) -> Result<Ties, Error> {
        if list.is_empty() {
            return Ok(Ties::none(problem));
        }
        let tied = Tied::new(dofs, list, &nodes_of_points(dofs, problem))?;
        Ok(Ties::of(tied, dofs, problem, activity))
    }

    /// No ties.
    pub(crate) fn none(problem: &ContactProblem) -> Ties {
        Ties { first: problem.points(), end: problem.points(), ..Ties::default() }
    }

    /// The same of points that are known, which are a pair even if there are none.
    pub(crate) fn of(tied: Tied, dofs: &DofMap, problem: &mut ContactProblem, activity: &mut Activity) -> Ties {
        let (first, Tied { list, points, redundant }) = (problem.points(), tied);
        append(dofs, &points, problem);
        let (m, mut rows) = (problem.points(), Vec::new());
        for (j, point) in points.iter().enumerate() {
            activity.add(first + j, joined(point.periods.iter().map(|(period, _)| *period)));
            for (k, row) in point.rows.iter().enumerate() {
                let vectors = row.iter().map(|(&dof, &v)| scale(v, dofs.direction(dof)));
                let sum = vectors.fold([0.0; 3], add);
                let of = |made_of: &BTreeMap<usize, f64>| made_of.iter().map(|(&k, &v)| (k, v)).collect();
                let periods = point.periods.iter().map(|(period, rows)| (*period, of(&rows[k]))).collect();
                rows.push(RowOfB { row: k * m + first + j, periods, sum });
            }
        }
        let nodes = points.iter().map(|point| point.node).collect();
        Ties { list, rows, redundant, first, end: m, nodes }
    }

    /// Whether there are none.
    pub(crate) fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// The number of ties.
    pub(crate) fn len(&self) -> usize {
        self.list.len()
    }

    /// Their contact points.
    pub(crate) fn points(&self) -> std::ops::Range<usize> {
        self.first..self.end
    }

    /// The node of each of them.
    pub(crate) fn nodes(&self) -> &[u32] {
        &self.nodes
    }

    /// Where the case asks for the tie that point `k` of them holds.
    pub(crate) fn spot(&self, k: usize) -> Spot {
        // The points of ties are the last.
        let row = self.rows.iter().find(|row| row.row % self.end == self.first + k);
        let tie = row.and_then(|row| row.periods.first()?.1.first());
        tie.map_or(Spot::default(), |(tie, _)| self.list[*tie].spot.clone())
    }

    /// Adds to `motion`, `3m`, what the sums are at time `t`, while supports travel by `travel`. `stood` has what each sum
    /// was when its tie began; nothing has begun where it is empty.
    ///
    /// # Errors
    /// A value that is not finite, or one that contradicts others then.
    pub(crate) fn put_into(
        &self,
        motion: &mut [f64],
        dofs: &DofMap,
        stood: &[f64],
        travel: V3,
        t: f64,
    ) -> Result<(), Error> {
        let values = values((&self.list, &self.redundant), dofs, stood, t)?;
        for row in &self.rows {
            let sum: f64 = row.made_of(t).iter().map(|(k, factor)| factor * values[*k]).sum();
            motion[row.row] += sum - dot(row.sum, travel);
        }
        Ok(())
    }

    /// Notes in `stood` what the sums of those are that begin at time `t` or later, for displacements by degrees of freedom.
    pub(crate) fn note(&self, stood: &mut [f64], dofs: &DofMap, u: &[f64], travel: V3, t: f64) {
        for (tie, stood) in self.list.iter().zip(stood) {
            if tie.start != Start::AtOnce && t <= tie.period[0] {
                let parts = tie.entries.iter();
                *stood = parts.map(|(&dof, v)| v * (u[dof as usize] + dot(dofs.direction(dof), travel))).sum();
            }
        }
    }

    /// Forces on the body that hold the sums at time `t`, newton per factor: those of tie `k` are `force[k]` times its
    /// entries. `lambda`, `3m`.
    pub(crate) fn forces(&self, lambda: &[f64], t: f64) -> Vec<f64> {
        let mut force = vec![0.0; self.list.len()];
        for row in &self.rows {
            row.made_of(t).iter().for_each(|(k, factor)| force[*k] -= factor * lambda[row.row]);
        }
        force
    }

    /// Forces of supports at degrees of freedom, newton, at time `t`. `lambda`, `3m`.
    pub(crate) fn reactions(&self, lambda: &[f64], t: f64) -> Vec<(u32, f64)> {
        let forces = self.list.iter().zip(self.forces(lambda, t)).filter(|(tie, _)| tie.is_support);
        forces.flat_map(|(tie, force)| tie.entries.iter().map(move |(&dof, v)| (dof, force * v))).collect()
    }
}

/// Periods that follow one another as one.
fn joined(periods: impl Iterator<Item = Period>) -> Vec<Period> {
    let mut list: Vec<Period> = Vec::new();
    for [begin, end] in periods {
        match list.last_mut().filter(|last| last[1] == begin) {
            Some(last) => last[1] = end,
            None => list.push([begin, end]),
        }
    }
    list
}

/// Nodes that contact points reach.
pub(crate) fn nodes_of_points(dofs: &DofMap, problem: &ContactProblem) -> HashSet<u32> {
    problem.contact.B.column.iter().map(|&unknown| dofs.free[unknown as usize] / 3).collect()
}
