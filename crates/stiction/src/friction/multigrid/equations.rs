//! Equations over many nodes, `G u = g`: motions that faces have in the mean, means of nodes.
//!
//! Where an equation eliminates one node, that node moves by the sum over all others divided by its own weight, some hundred times as far
//! as the mean, and this bump stands in the matrix of every level: 72 to over 1,000 cycles on a brick that is pushed by the mean of a face.
//! Here the equations stay out of the matrix, and their multipliers are unknowns beside the displacements. Iterate and directions are
//! projected on `G u = g` along displacements `Z`, one field for each equation, and the residual along their transposed: conjugate
//! gradients on the null space of `G` with the hierarchy as preconditioner (Gould, Hribar & Nocedal, SIAM J. Sci. Comput. 23, 2001). The
//! fields move nothing along the contact conditions, so that no projection undoes them.

use super::active_set::{ContactCondition, PointLaw, closed_condition};
use super::directions::{Vector, dot};
use super::iteration::{Iterate, Subproblem, residual};
use super::part::Part;
use super::points::Point;
use super::solve::{Multigrid, point_laws};
use super::transform::{Transformed, refused};
use crate::Error;
use crate::contact::rigid::RigidMotions;
use crate::contact::{ContactProblem, Friction};
use crate::linalg::multigrid::{CoarseLevels, Hierarchy, NodeConstraint};
use crate::linalg::{SmallLu, dot as dot_of};

/// A row with more entries, whose squares add up to more than this, is over many nodes: at the node that it would eliminate they add up
/// to one. Points between bodies have an area and are none.
const MANY: usize = 12;
const LARGE: f64 = 4.0;
/// With more equations, each of which has a field, nodes are eliminated.
const MOST: usize = 48;
/// What rounding leaves of an equation, over the sum of its terms.
const ROUNDING: f64 = 1e-13;

/// The points of a problem that are equations over many nodes, up to three each, ascending.
pub(crate) fn equations(problem: &ContactProblem) -> Vec<u32> {
    let laws = &problem.contact.friction;
    // The iteration without strengths knows no part of a problem.
    if laws.iter().any(|law| law.tension() != 0.0) {
        return Vec::new();
    }
    let is_over_many = |i: usize| {
        let (_, entries) = problem.contact.B.row(i);
        entries.len() > MANY && dot_of(entries, entries) > LARGE
    };
    let is_tie = |j: usize| laws[j] == Friction::Bonded && problem.labels.area.get(j).is_none_or(|area| *area == 0.0);
    let is_equation = |j: &u32| is_tie(*j as usize) && problem.rows(*j as usize).into_iter().any(is_over_many);
    let found: Vec<u32> = (0..problem.points() as u32).filter(is_equation).collect();
    if rows_of(problem, &found).len() > MOST { Vec::new() } else { found }
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
    /// Their points in the whole problem.
    points: Vec<u32>,
    /// `G`.
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
        if points.is_empty() {
            return Ok(None);
        }
        let laws = point_laws(&part.problem, &multigrid.transformed);
        let Multigrid { transformed, hierarchy, equations, .. } = multigrid;
        let mut found = match equations.take() {
            Some(kept) if kept.points == *points => kept,
            _ => Equations::new(whole, points.clone(), (transformed, &laws), hierarchy)?,
        };
        let values = whole.gap_and_slip(&vec![0.0; whole.unknowns()]);
        found.values = rows_of(whole, points).into_iter().map(|i| values[i]).collect();
        Ok(Some(found))
    }

    fn new(
        whole: &ContactProblem,
        points: Vec<u32>,
        (transformed, laws): (&Transformed, &[PointLaw]),
        hierarchy: &mut Hierarchy,
    ) -> Result<Equations, Error> {
        let row = |i: usize| {
            let mut dense = vec![0.0; whole.unknowns()];
            whole.contact.B.entries_of(i).for_each(|(i, value)| dense[i as usize] += value);
            let row = transformed.forces(&dense);
            (0u32..).zip(row).filter(|(_, x)| *x != [0.0; 3]).collect::<Vec<_>>()
        };
        let rows: Vec<Row> = rows_of(whole, &points).into_iter().map(row).collect();
        let closed: Vec<NodeConstraint> =
            laws.iter().zip(&transformed.points).map(|(law, point)| closed_condition(law, point).constraint).collect();
        hierarchy.forget_coarse_constraints();
        hierarchy.constrain(&closed, CoarseLevels::Change, true);
        let held: Held = closed.iter().map(|constraint| constraint.constrained).collect();
        let fields = Fields::new(&rows, transformed, &held, hierarchy);
        hierarchy.forget_coarse_constraints();
        let dependent = || refused("equations over many nodes depend on one another, or on the supports");
        let fields = fields.ok_or_else(dependent)?;
        let of_all = |row: &Row| {
            let other = dense(row, transformed.f.len());
            rows.iter().map(|row| product(row, &other)).collect()
        };
        let gram = rows.iter().map(of_all).collect();
        let of_unknowns = |i: usize| whole.contact.B.entries_of(i).collect();
        let motions =
            transformed.motions.beside(&rows_of(whole, &points).into_iter().map(of_unknowns).collect::<Vec<_>>());
        Ok(Equations { points, rows, values: Vec::new(), fields, gram, motions })
    }

    /// Moves the iterate to where the equations hold, and their multipliers to where nothing along the fields is out of balance.
    pub(super) fn balance(&self, problem: &Subproblem<'_>, projection: &Projection, at: &mut Iterate) {
        let Fields { of_rows, along, across } = projection.fields.as_ref().unwrap_or(&self.fields);
        at.multipliers.resize(self.rows.len(), 0.0);
        let missing = |(row, value): (&Row, &f64)| {
            let terms = row.iter().flat_map(|(v, x)| (0..3).map(|c| x[c] * at.u[*v as usize][c]));
            let [sum, size] = terms.fold([0.0; 2], |[sum, size], term: f64| [sum + term, size + term.abs()]);
            if (value - sum).abs() <= ROUNDING * size { 0.0 } else { value - sum }
        };
        let missing: Vec<f64> = self.rows.iter().zip(&self.values).map(missing).collect();
        if missing.iter().any(|missing| *missing != 0.0) {
            of_rows.iter().zip(along.solve(&missing)).for_each(|(field, way)| add(way, field, &mut at.u));
            at.ku = problem.forces_within(at);
        }
        let r = residual(problem, at);
        let left: Vec<f64> = of_rows.iter().map(|field| dot(field, &r)).collect();
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
    pub(super) fn project(&self, projection: &Projection, p: &mut Vector) {
        let Fields { of_rows, along, .. } = projection.fields.as_ref().unwrap_or(&self.fields);
        let of_direction: Vec<f64> = self.rows.iter().map(|row| product(row, p)).collect();
        of_rows.iter().zip(along.solve(&of_direction)).for_each(|(field, way)| add(-way, field, p));
    }

    /// The square of `Gᵀ μ`, newton.
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
            hierarchy.cycle_in_units(dot(&r, &r).sqrt().max(f64::MIN_POSITIVE), &r)
        };
        Fields::of(rows.iter().map(field).collect(), (rows, transformed, held))
    }

    /// These fields where contact holds them.
    fn of(mut of_rows: Vec<Vector>, (rows, transformed, held): (&[Row], &Transformed, &Held)) -> Option<Fields> {
        of_rows.iter_mut().for_each(|field| hold(&transformed.points, held, field));
        let along = SmallLu::new(products(rows.len(), |i, j| product(&rows[i], &of_rows[j])));
        let across = SmallLu::new(products(rows.len(), |i, j| product(&rows[j], &of_rows[i])));
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
        if held == self.last && held != self.of && cycle >= self.next {
            let fields = Fields::new(&equations.rows, transformed, &held, hierarchy);
            self.fields = fields.or(self.fields.take());
            self.next = cycle + equations.rows.len();
            self.of.clone_from(&held);
        } else if held != self.last {
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

fn products(count: usize, of: impl Fn(usize, usize) -> f64) -> Vec<Vec<f64>> {
    (0..count).map(|i| (0..count).map(|j| of(i, j)).collect()).collect()
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
