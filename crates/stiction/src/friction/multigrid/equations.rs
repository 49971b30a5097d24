//! Equations over many nodes, `G u = g`: motions that faces have in the mean, means of nodes.
//!
//! Where an equation eliminates one node, that node moves by the sum over all others divided by its own weight, some hundred times as far
//! as the mean, and this bump stands in the matrix of every level: 72 to over 1,000 cycles on a brick that is pushed by the mean of a face.
//! Here the equations stay out of the matrix, and their multipliers are unknowns beside the displacements. Iterate and directions are
//! projected on `G u = g` along displacements `Z`, one field for each equation, and the residual along their transposed: conjugate
//! gradients on the null space of `G` with the hierarchy as preconditioner (Gould, Hribar & Nocedal, SIAM J. Sci. Comput. 23, 2001). The
//! fields move nothing along the contact conditions, so that no projection undoes them. Among several ranks each has the entries at its
//! nodes, of displacements, fields and rows; multipliers and what is missing of each equation are the same on all.

use std::ops::Range;

use super::active_set::{ContactCondition, PointLaw, closed_condition};
use super::directions::{Vector, dot, norm};
use super::divided::Divided;
use super::iteration::{Iterate, Subproblem, residual};
use super::part::Part;
use super::points::Point;
use super::solve::{Multigrid, point_laws};
use super::transform::{Transformed, refused};
use crate::Error;
use crate::contact::rigid::RigidMotions;
use crate::contact::{ContactProblem, Division, Friction};
use crate::linalg::multigrid::{CoarseLevels, Hierarchy, NodeConstraint};
use crate::linalg::{SmallLu, dot as dot_of};
use crate::ranks::{Halo, sum};

/// A row with more entries, whose squares add up to more than this, is over many nodes: at the node that it would eliminate they add up
/// to one. Points between bodies have an area and are none.
const MANY: usize = 12;
const LARGE: f64 = 4.0;
/// With more equations, each of which has a field, nodes are eliminated.
pub(crate) const MOST: usize = 48;
/// What rounding leaves of an equation, over the sum of its terms.
const ROUNDING: f64 = 1e-13;

/// Whether a row with these entries is over many nodes.
pub(crate) fn is_over_many(entries: &[f64]) -> bool {
    entries.len() > MANY && dot_of(entries, entries) > LARGE
}

/// The points of a problem that are equations over many nodes, ascending. Where it is divided, those here: all ranks find them together.
pub(crate) fn equations(problem: &ContactProblem, division: Option<&Division>) -> Vec<u32> {
    counted(problem, division).0
}

/// The number of fields that equations over many nodes have, the same on all ranks.
pub(super) fn fields(problem: &ContactProblem, division: Option<&Division>) -> usize {
    counted(problem, division).1
}

/// The points, and the number of their rows on all ranks together.
fn counted(problem: &ContactProblem, division: Option<&Division>) -> (Vec<u32>, usize) {
    let laws = &problem.contact.friction;
    // What is out has another law until it is in.
    let is_bonded = |j: usize| laws[j] == Friction::Bonded || problem.contact.out.binary_search(&(j as u32)).is_ok();
    let is_tie = |j: usize| is_bonded(j) && problem.labels.area.get(j).is_none_or(|area| *area == 0.0);
    let is_large = |i: usize| is_over_many(problem.contact.B.row(i).1);
    let is_equation = |j: &u32| is_tie(*j as usize) && problem.rows(*j as usize).into_iter().any(is_large);
    let found: Vec<u32> = (0..problem.points() as u32).filter(is_equation).collect();
    let is_own = |j: &u32| division.is_none_or(|division| division.is_own(division.points[*j as usize]));
    let rows = rows_of(problem, &found.iter().copied().filter(is_own).collect::<Vec<_>>()).len();
    let has_strength = laws.iter().any(|law| law.tension() != 0.0);
    let mut sums = [rows as f64, f64::from(u8::from(has_strength))];
    if let Some(division) = division {
        sum(&*division.ranks, &mut sums);
    }
    let rows = sums[0] as usize;
    // The iteration without strengths knows no part of a problem.
    if rows > MOST || sums[1] > 0.0 { (Vec::new(), 0) } else { (found, rows) }
}

/// The rows of `B` of such points that are not zero, one equation each.
pub(super) fn rows_of(problem: &ContactProblem, points: &[u32]) -> Vec<usize> {
    let filled = |i: &usize| problem.contact.B.row(*i).1.iter().any(|v| *v != 0.0);
    points.iter().flat_map(|&j| problem.rows(j as usize)).filter(filled).collect()
}

/// Nonzero entries of a row of `G`.
type Row = Vec<(u32, [f64; 3])>;
/// Which components of each point contact holds.
type Held = Vec<[bool; 3]>;

/// The equations of a part of a problem, in the frames of its points.
#[derive(Debug)]
pub(super) struct Equations {
    /// Their points in the whole problem; where that is divided, those of this rank.
    points: Vec<u32>,
    /// The equations of these points among those of all ranks.
    own: Range<usize>,
    /// `G`, at the nodes of this rank.
    rows: Vec<Row>,
    /// `g`, length.
    values: Vec<f64>,
    /// Where all points are closed, and stick where there is friction.
    fields: Fields,
    /// `G Gᵀ`.
    gram: Vec<Vec<f64>>,
    /// Rigid motions that neither supports nor these equations hold.
    pub motions: RigidMotions,
}

/// `Z`: what the hierarchy makes of the forces `Gᵀ`.
#[derive(Debug, Clone)]
struct Fields {
    of_rows: Vec<Vector>,
    /// `G Z`, and its transposed.
    along: SmallLu,
    across: SmallLu,
}

/// The fields that an iteration projects along, made anew where contact conditions have changed and come to rest: those of other
/// conditions cost cycles. A block that is bent by the means of its ends (12 equations) takes 21 cycles, with those of closed points alone 51,
/// one that is tipped by the mean of its top 18 and 38 (tetrahedra of 10 nodes), 15 and 39 (hexahedra).
#[derive(Debug, Clone, Default)]
pub(super) struct Projection {
    fields: Option<Fields>,
    /// What contact held when they were made, and in the last cycle.
    of: Held,
    last: Held,
    /// The cycle before which they are not made again: they take as long as one for each equation.
    next: usize,
}

impl Equations {
    /// Those of `part`, as they were found before where they stand in `multigrid`, with the values of `whole`.
    ///
    /// # Errors
    /// If the equations depend on one another.
    pub(super) fn of_part(
        whole: &ContactProblem,
        part: &Part,
        multigrid: &mut Multigrid,
    ) -> Result<Option<Equations>, Error> {
        let points = &part.equations;
        if !multigrid.transformed.halo().any(!points.is_empty()) {
            return Ok(None);
        }
        let laws = point_laws(&part.problem, &multigrid.transformed);
        let Multigrid { transformed, hierarchy, equations, divided, .. } = multigrid;
        let halo = transformed.halo();
        let kept = equations.take();
        let is_other = halo.any(kept.as_ref().is_none_or(|kept| kept.points != *points));
        let mut found = match kept.filter(|_| !is_other) {
            Some(kept) => kept,
            None => Equations::new(whole, points.clone(), (transformed, &laws, divided.as_ref()), hierarchy)?,
        };
        let values = whole.gap_and_slip(&vec![0.0; whole.unknowns()]);
        found.values = vec![0.0; found.rows.len()];
        let own = &mut found.values[found.own.clone()];
        own.iter_mut().zip(rows_of(whole, points)).for_each(|(value, i)| *value = values[i]);
        halo.sum(&mut found.values);
        Ok(Some(found))
    }

    fn new(
        whole: &ContactProblem,
        points: Vec<u32>,
        (transformed, laws, divided): (&Transformed, &[PointLaw], Option<&Divided>),
        hierarchy: &mut Hierarchy,
    ) -> Result<Equations, Error> {
        let halo = transformed.halo();
        let of_points = rows_of(whole, &points);
        let (own, count) = places(halo, of_points.len());
        // Of each equation its entries, none where it is of another rank.
        let mut entries: Vec<Vec<(u32, f64)>> = vec![Vec::new(); count];
        let of_own = entries[own.clone()].iter_mut().zip(of_points);
        of_own.for_each(|(entries, i)| *entries = whole.contact.B.entries_of(i).collect());
        let row = |entries: &Vec<(u32, f64)>| {
            let mut dense = vec![0.0; whole.unknowns()];
            entries.iter().for_each(|&(i, value)| dense[i as usize] += value);
            // A node may be measured from nodes of this rank and be one of another.
            let dense = divided.map_or_else(|| dense.clone(), |divided| divided.everywhere(&dense));
            let row = transformed.forces(&dense);
            (0u32..).zip(row).filter(|(_, x)| *x != [0.0; 3]).collect::<Vec<_>>()
        };
        let rows: Vec<Row> = entries.iter().map(row).collect();
        let closed: Vec<NodeConstraint> =
            laws.iter().zip(&transformed.points).map(|(law, point)| closed_condition(law, point).constraint).collect();
        hierarchy.forget_coarse_constraints();
        hierarchy.constrain(&closed, CoarseLevels::Change, true);
        let held: Held = closed.iter().map(|constraint| constraint.constrained).collect();
        let fields = Fields::new(&rows, transformed, &held, hierarchy);
        hierarchy.forget_coarse_constraints();
        let dependent = || refused("equations over many nodes depend on one another, on supports or on closed contact");
        let fields = fields.ok_or_else(dependent)?;
        let all: Vec<Vector> = rows.iter().map(|row| dense(row, transformed.f.len())).collect();
        let gram = products(halo, count, |i, j| product(&rows[j], &all[i]));
        let motions = transformed.motions.beside(&entries, &|sums| halo.sum(sums));
        Ok(Equations { points, own, rows, values: Vec::new(), fields, gram, motions })
    }

    /// The multipliers of the points of this rank among those of all.
    pub(super) fn own<'a>(&self, multipliers: &'a [f64]) -> &'a [f64] {
        multipliers.get(self.own.clone()).unwrap_or_default()
    }

    /// Whether they prescribe more than that nothing moves.
    pub(super) fn move_something(&self) -> bool {
        self.values.iter().any(|value| *value != 0.0)
    }

    /// Moves the iterate to where the equations hold, and their multipliers to where nothing along the fields is out of balance.
    pub(super) fn balance(&self, problem: &Subproblem<'_>, projection: &Projection, at: &mut Iterate) {
        let Fields { of_rows, along, across } = projection.fields.as_ref().unwrap_or(&self.fields);
        let halo = problem.transformed.halo();
        at.multipliers.resize(self.rows.len(), 0.0);
        let moved = |row: &Row| {
            let terms = row.iter().flat_map(|(v, x)| (0..3).map(|c| x[c] * at.u[*v as usize][c]));
            terms.fold([0.0; 2], |[sum, size], term: f64| [sum + term, size + term.abs()])
        };
        let mut moved: Vec<[f64; 2]> = self.rows.iter().map(moved).collect();
        halo.sum(moved.as_flattened_mut());
        let missing = |(&[sum, size], value): (&[f64; 2], &f64)| {
            if (value - sum).abs() <= ROUNDING * size { 0.0 } else { value - sum }
        };
        let missing: Vec<f64> = moved.iter().zip(&self.values).map(missing).collect();
        if missing.iter().any(|missing| *missing != 0.0) {
            of_rows.iter().zip(along.solve(&missing)).for_each(|(field, way)| add(way, field, &mut at.u));
            at.ku = problem.forces_within(at);
        }
        let r = residual(problem, at);
        let mut left: Vec<f64> = of_rows.iter().map(|field| dot(field, &r)).collect();
        halo.sum(&mut left);
        let change = across.solve(&left);
        at.multipliers.iter_mut().zip(&change).for_each(|(multiplier, change)| *multiplier += change);
        self.add_forces(&change, &mut at.ku);
    }

    /// Adds `Gᵀ μ`.
    pub(super) fn add_forces(&self, multipliers: &[f64], ku: &mut Vector) {
        for (row, &multiplier) in self.rows.iter().zip(multipliers) {
            row.iter().for_each(|(v, x)| (0..3).for_each(|c| ku[*v as usize][c] += multiplier * x[c]));
        }
    }

    /// Takes off a direction what changes the equations.
    pub(super) fn project(&self, halo: &Halo, projection: &Projection, p: &mut Vector) {
        let Fields { of_rows, along, .. } = projection.fields.as_ref().unwrap_or(&self.fields);
        let mut of_direction: Vec<f64> = self.rows.iter().map(|row| product(row, p)).collect();
        halo.sum(&mut of_direction);
        of_rows.iter().zip(along.solve(&of_direction)).for_each(|(field, way)| add(-way, field, p));
    }

    /// The square of `Gᵀ μ`, newton, that of all ranks together.
    pub(super) fn force_square(&self, multipliers: &[f64]) -> f64 {
        let rows = self.gram.iter().zip(multipliers);
        rows.map(|(row, a)| a * row.iter().zip(multipliers).map(|(g, b)| g * b).sum::<f64>()).sum()
    }
}

impl Fields {
    /// One cycle for each row; the hierarchy is constrained as `held`. `None` where rows depend on one another.
    fn new(rows: &[Row], transformed: &Transformed, held: &Held, hierarchy: &Hierarchy) -> Option<Fields> {
        let field = |row: &Row| {
            let mut r = dense(row, transformed.f.len());
            hold(&transformed.points, held, &mut r);
            hierarchy.cycle_in_units(norm(transformed.halo(), &r).max(f64::MIN_POSITIVE), &r)
        };
        Fields::of(rows.iter().map(field).collect(), (rows, transformed, held))
    }

    /// These fields where contact holds them.
    fn of(mut of_rows: Vec<Vector>, (rows, transformed, held): (&[Row], &Transformed, &Held)) -> Option<Fields> {
        of_rows.iter_mut().for_each(|field| hold(&transformed.points, held, field));
        let along = products(transformed.halo(), rows.len(), |i, j| product(&rows[i], &of_rows[j]));
        let across = SmallLu::new((0..rows.len()).map(|i| along.iter().map(|row| row[i]).collect()).collect());
        let along = SmallLu::new(along);
        (!along.singular && !across.singular).then_some(Fields { of_rows, along, across })
    }
}

impl Projection {
    /// Keeps the fields from what contact holds now, as the hierarchy does, and makes them anew where this has come to rest.
    pub(super) fn update(
        &mut self,
        equations: &Equations,
        problem: &Subproblem<'_>,
        (conditions, cycle): (&[ContactCondition], usize),
        hierarchy: &Hierarchy,
    ) {
        let held: Held = conditions.iter().map(|condition| condition.constraint.constrained).collect();
        let transformed = problem.transformed;
        let mut ranks = [held != self.last, held != self.of].map(|differs| f64::from(u8::from(differs)));
        transformed.halo().sum(&mut ranks);
        let [has_changed, is_other] = ranks.map(|ranks| ranks > 0.0);
        if !has_changed && is_other && cycle >= self.next {
            let fields = Fields::new(&equations.rows, transformed, &held, hierarchy);
            self.fields = fields.or(self.fields.take());
            self.next = cycle + equations.rows.len();
            self.of.clone_from(&held);
        } else if has_changed {
            let Fields { of_rows, .. } = self.fields.take().unwrap_or_else(|| equations.fields.clone());
            self.fields = Fields::of(of_rows, (&equations.rows, transformed, &held));
        }
        self.last = held;
    }
}

/// Takes what contact holds off displacements or forces.
fn hold(points: &[Point], held: &Held, x: &mut Vector) {
    for (point, held) in points.iter().zip(held) {
        (0..3).filter(|&c| held[c]).for_each(|c| x[point.node][c] = 0.0);
    }
}

/// A matrix with a row for each equation, whose entries are sums over the ranks.
fn products(halo: &Halo, count: usize, of: impl Fn(usize, usize) -> f64) -> Vec<Vec<f64>> {
    let mut all: Vec<f64> = (0..count).flat_map(|i| (0..count).map(move |j| (i, j))).map(|(i, j)| of(i, j)).collect();
    halo.sum(&mut all);
    all.chunks(count).map(<[f64]>::to_vec).collect()
}

/// The places of so many equations of this rank among those of all, and their number.
fn places(halo: &Halo, own: usize) -> (Range<usize>, usize) {
    let mut counts = vec![0.0; halo.ranks().size()];
    let rank = halo.ranks().rank();
    counts[rank] = own as f64;
    halo.sum(&mut counts);
    let first = counts[..rank].iter().sum::<f64>() as usize;
    (first..first + own, counts.iter().sum::<f64>() as usize)
}

fn dense(row: &Row, nodes: usize) -> Vector {
    let mut all = vec![[0.0; 3]; nodes];
    row.iter().for_each(|(v, x)| all[*v as usize] = *x);
    all
}

fn product(row: &Row, u: &Vector) -> f64 {
    row.iter().map(|(v, x)| (0..3).map(|c| x[c] * u[*v as usize][c]).sum::<f64>()).sum()
}

fn add(factor: f64, x: &Vector, to: &mut Vector) {
    to.as_flattened_mut().iter_mut().zip(x.as_flattened()).for_each(|(to, x)| *to += factor * x);
}
