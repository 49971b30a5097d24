use super::active_set::{ContactCondition, PointLaw};
use super::directions::Vector;
use super::iteration::{Iterate, Subproblem};
use super::loose::{LooseMotions, resisted};
use super::part::Part;
use super::solve::{Multigrid, point_laws};
use super::transform::Transformed;
use crate::contact::among::Among;
use crate::contact::equilibrium::{Bearing, Slide, departs_along, departs_along_of, no_equilibrium, no_equilibrium_of};
use crate::contact::rigid::RigidMotions;
use crate::contact::sliding::{Sliding, largest_displacement, least_resisted, least_resisted_of};
use crate::contact::{ContactProblem, Friction};
use crate::dual::Dual;
use crate::friction::direct::rigid_start::{Foundation, along, keep_apart, unless_rounding, ways, without_rounding};
use crate::friction::law::parameters;
use crate::friction::rigid_equilibrium;
use crate::linalg::{Csr, axpy};
use crate::ranks::{Halo, from_bytes, gather_all, put, take, to_bytes};

/// Floating bodies, which contact alone supports, with the data of their rigid motions. Where points are divided among ranks each
/// has the data of all, and finds the same equilibrium.
pub(super) struct FloatingBodies<'a> {
    problem: &'a ContactProblem,
    motions: &'a RigidMotions,
    /// Jumps of the motions at all points, `3m x k`, and the laws there.
    jumps: Csr,
    friction: Vec<Friction>,
    /// Work of the loads on the motions, newton.
    resultant: Vec<f64>,
}

/// Numbers of the points of this rank, blocks with one for each, as such blocks of the points of all ranks.
fn of_all_points(halo: &Halo, blocks: usize, own: &[f64]) -> Vec<f64> {
    if !halo.is_divided() {
        return own.to_vec();
    }
    let parts: Vec<Vec<f64>> =
        gather_all(&**halo.ranks(), to_bytes(own)).iter().map(|bytes| from_bytes(bytes)).collect();
    let block = |of: &Vec<f64>, k: usize| {
        let m = of.len() / blocks;
        of[k * m..(k + 1) * m].to_vec()
    };
    (0..blocks).flat_map(|k| parts.iter().flat_map(move |of| block(of, k))).collect()
}

/// As [`of_all_points`], of the three rows of each point.
fn rows_of_all_points(halo: &Halo, own: Csr) -> Csr {
    if !halo.is_divided() {
        return own;
    }
    let mut message = Vec::new();
    put(&own.start.iter().map(|&start| start as u64).collect::<Vec<_>>(), &mut message);
    put(&own.column, &mut message);
    put(&own.value, &mut message);
    let part = |bytes: Vec<u8>| {
        let mut from = &bytes[..];
        let start: Vec<u64> = take(&mut from);
        let start: Vec<usize> = start.into_iter().map(|start| start as usize).collect();
        Csr { rows: start.len() - 1, cols: own.cols, start, column: take(&mut from), value: take(&mut from) }
    };
    let parts: Vec<Csr> = gather_all(&**halo.ranks(), message).into_iter().map(part).collect();
    let mut all = Csr::zero(0, own.cols);
    for k in 0..3 {
        for part in &parts {
            let m = part.rows as u32 / 3;
            all.append(&part.select_rows(&(k * m..(k + 1) * m).collect::<Vec<_>>()));
        }
    }
    all
}

/// The laws of the points of all ranks.
fn friction_of_all(halo: &Halo, problem: &ContactProblem) -> Vec<Friction> {
    let laws: Vec<[f64; 4]> = problem.contact.friction.iter().map(Friction::numbers).collect();
    let by_blocks: Vec<f64> = (0..4).flat_map(|c| laws.iter().map(move |law| law[c])).collect();
    let laws = of_all_points(halo, 4, &by_blocks);
    let m = laws.len() / 4;
    (0..m).map(|j| Friction::of_numbers([0, 1, 2, 3].map(|c| laws[c * m + j]))).collect()
}

/// What statics asks of the points of all ranks, see [`Bearing`].
struct AllPoints {
    jumps: Csr,
    friction: Vec<Friction>,
    out: Vec<u32>,
}

impl AllPoints {
    /// From the jumps at the points of this rank.
    fn new(halo: &Halo, problem: &ContactProblem, jumps: Csr) -> Self {
        let (friction, out) = (friction_of_all(halo, problem), out_of_all(halo, problem));
        AllPoints { jumps: rows_of_all_points(halo, jumps), friction, out }
    }

    fn bearing(&self) -> Bearing<'_> {
        Bearing { jumps: &self.jumps, friction: &self.friction, out: &self.out }
    }
}

/// The points of all ranks that take no part.
fn out_of_all(halo: &Halo, problem: &ContactProblem) -> Vec<u32> {
    let mut flags = vec![0.0; problem.points()];
    problem.contact.out.iter().for_each(|&j| flags[j as usize] = 1.0);
    let flags = of_all_points(halo, 1, &flags);
    (0..).zip(flags).filter(|(_, flag)| *flag > 0.0).map(|(j, _)| j).collect()
}

fn is_own(transformed: &Transformed, unknown: usize) -> bool {
    (transformed.nodes.of[unknown].0 as usize) < transformed.halo().own()
}

/// The loads at nodes of this rank; those at others are theirs.
fn own_loads(problem: &ContactProblem, transformed: &Transformed) -> Vec<f64> {
    let own = |(i, &f): (usize, &f64)| if is_own(transformed, i) { f } else { 0.0 };
    problem.elastic.f.iter().enumerate().map(own).collect()
}

/// The sum of the sizes of what the work of the loads on the motions adds up, newton.
fn work_size(problem: &ContactProblem, transformed: &Transformed, motions: &RigidMotions) -> f64 {
    let mut size = [motions.work_size(&own_loads(problem, transformed))];
    transformed.halo().sum(&mut size);
    size[0]
}

/// Work of the loads on the motions of floating bodies, newton.
fn resultant(problem: &ContactProblem, transformed: &Transformed, motions: &RigidMotions) -> Vec<f64> {
    let (halo, load) = (transformed.halo(), own_loads(problem, transformed));
    let mut work = motions.work(&load);
    work.push(motions.work_size(&load));
    halo.sum(&mut work);
    let size = work.pop().unwrap_or(0.0);
    without_rounding(work, size)
}

impl Multigrid {
    /// As [`rigid_equilibrium`](crate::friction::rigid_equilibrium) of the problem of the points of this rank, of which `part` is solved:
    /// `u` and `slices` are displacements of all unknowns here. All ranks find the same.
    pub(crate) fn rigid_equilibrium(
        &self,
        (problem, part): (&ContactProblem, Option<&Part>),
        slices: &[Vec<f64>],
        pull: &[f64],
        mut u: Vec<f64>,
    ) -> (Vec<f64>, Vec<f64>) {
        let transformed = &self.transformed;
        let (halo, motions, rows) = (transformed.halo(), &transformed.motions, problem.isotropic_rows());
        if halo.is_alone() {
            return rigid_equilibrium(problem, motions, slices, pull, u);
        }
        let of_slices: Vec<Vec<f64>> = slices.iter().map(|slice| rows.times(slice)).collect();
        let jumps = rows_of_all_points(halo, motions.jumps(&rows).beside(&of_slices));
        let mut gap = of_all_points(halo, 3, &problem.isotropic().gap_and_slip(&u));
        let friction = friction_of_all(halo, problem);
        keep_apart(&friction, &mut gap);
        let stiffness = of_all_points(halo, 1, &self.stiffness(problem, part));
        let load = own_loads(problem, transformed);
        let mut work: Vec<f64> = slices.iter().flat_map(|slice| along(slice, &load, 0.0)).collect();
        halo.sum(&mut work);
        let pulled = work.as_chunks().0.iter().zip(pull);
        let pulled = pulled.map(|([sum, size], pull)| unless_rounding([sum + pull, size + pull.abs()]));
        let resultant = [resultant(problem, transformed, motions), pulled.collect()].concat();
        let (friction, jumps, resultant) = (&friction[..], &jumps, &resultant[..]);
        let foundation = Foundation { friction, jumps, resultant, gap: &gap, stiffness: &stiffness };
        let alpha = foundation.equilibrium().alpha;
        let (rigid, way) = alpha.split_at(motions.len());
        motions.add(rigid, &mut u);
        slices.iter().zip(way).for_each(|(slice, &way)| axpy(way, slice, &mut u));
        (u, ways(way, &resultant[motions.len()..]))
    }

    /// As [`no_equilibrium`](crate::contact::equilibrium::no_equilibrium) of the problem of the points of this rank. All ranks find the same.
    pub(crate) fn no_equilibrium(&self, problem: &ContactProblem) -> Option<Slide> {
        let transformed = &self.transformed;
        let (halo, motions) = (transformed.halo(), &transformed.motions);
        if halo.is_alone() {
            return no_equilibrium(problem, motions);
        }
        let load = resultant(problem, transformed, motions);
        // Its rounding is left out already.
        if load.iter().all(|&work| work == 0.0) {
            return None;
        }
        let all = AllPoints::new(halo, problem, motions.jumps(&problem.isotropic_rows()));
        no_equilibrium_of(&all.bearing(), motions, (&load, work_size(problem, transformed, motions)))
    }

    /// As [`departs_along`](crate::contact::equilibrium::departs_along), likewise; `slices` are displacements of all unknowns here.
    pub(crate) fn departs_along(
        &self,
        problem: &ContactProblem,
        slices: &[Vec<f64>],
        pull: &[f64],
    ) -> Option<Vec<f64>> {
        let transformed = &self.transformed;
        let (halo, motions, rows) = (transformed.halo(), &transformed.motions, problem.isotropic_rows());
        if halo.is_alone() {
            return departs_along(problem, motions, slices, pull);
        }
        let f = own_loads(problem, transformed);
        let of_slice = |slice: &Vec<f64>| -> [f64; 3] {
            let own = slice.iter().enumerate().filter(|(i, _)| is_own(transformed, *i));
            let terms = f.iter().zip(slice).map(|(f, s)| f * s);
            [own.map(|(_, s)| s * s).sum(), terms.clone().sum(), terms.map(f64::abs).sum()]
        };
        let mut sums: Vec<f64> = slices.iter().flat_map(of_slice).collect();
        halo.sum(&mut sums);
        let (mut load, mut terms) =
            (resultant(problem, transformed, motions), work_size(problem, transformed, motions));
        let mut of_slices = Vec::new();
        for ((slice, pull), [square, work, size]) in slices.iter().zip(pull).zip(sums.as_chunks::<3>().0) {
            let length = square.sqrt();
            load.push((work + pull) / length);
            terms += (size + pull.abs()) / length;
            of_slices.push(rows.times(slice).iter().map(|jump| jump / length).collect());
        }
        let all = AllPoints::new(halo, problem, motions.jumps(&rows).beside(&of_slices));
        departs_along_of(&all.bearing(), (&load, terms), slices.len())
    }

    /// As [`least_resisted`] at the multipliers of the points of this rank, `3m`, newton.
    pub(crate) fn least_resisted(&self, problem: &ContactProblem, lambda: &[f64]) -> Option<Sliding> {
        let transformed = &self.transformed;
        let (halo, motions) = (transformed.halo(), &transformed.motions);
        if halo.is_alone() {
            return least_resisted(problem, motions, lambda);
        }
        let (load, lambda) = (resultant(problem, transformed, motions), of_all_points(halo, 3, lambda));
        let all = AllPoints::new(halo, problem, motions.jumps(&problem.isotropic_rows()));
        let largest = |alpha: &[f64]| largest_displacement(problem, motions, alpha);
        // Each rank has all rows: nothing is added up.
        let among = Among { max: &|values| halo.max(values), ..Among::ALONE };
        let scale = problem.contact.B.max_abs();
        least_resisted_of((&all.bearing(), motions), (&lambda, &load), scale, &largest, &among)
    }

    /// Of the foundation at the points of this rank, force per length.
    fn stiffness(&self, problem: &ContactProblem, part: Option<&Part>) -> Vec<f64> {
        let of = |problem: &ContactProblem| point_laws(problem, &self.transformed).into_iter().map(|law| law.parameter);
        let Some(part) = part else { return of(problem).collect() };
        // The others have no node of their own whose compliance is known.
        let mut all = parameters(problem, &Dual::local_stiffness(problem));
        part.points.iter().zip(of(&part.problem)).for_each(|(&j, stiffness)| all[j as usize] = stiffness);
        all
    }
}

impl<'a> FloatingBodies<'a> {
    /// With these rigid motions; `None` where no body floats.
    pub(super) fn new(
        problem: &'a ContactProblem,
        transformed: &Transformed,
        motions: &'a RigidMotions,
    ) -> Option<FloatingBodies<'a>> {
        let halo = transformed.halo();
        if !transformed.floats() || motions.is_empty() {
            return None;
        }
        let jumps = rows_of_all_points(halo, motions.jumps(&problem.isotropic_rows()));
        let (friction, resultant) = (friction_of_all(halo, problem), resultant(problem, transformed, motions));
        Some(FloatingBodies { problem, motions, jumps, friction, resultant })
    }

    /// Moves the bodies as rigid ones to where the admissible augmented multipliers balance their loads: the points then in
    /// contact support the bodies, and the sticking ones keep them from sliding. Once the active constraints do not support a
    /// body, cycles do not find these motions, because no level resists them.
    pub(super) fn balance(&self, problem: &Subproblem<'_>, at: &mut Iterate) {
        // Rigid motions take no forces: `ku` stays.
        let motion = self.motion(problem, at);
        at.u.iter_mut().flatten().zip(motion.iter().flatten()).for_each(|(u, d)| *u += d);
    }

    /// Takes what nothing resists under these conditions off a direction; `loose` is what it was the last time.
    pub(super) fn keep_in_place(
        &self,
        transformed: &Transformed,
        conditions: &[ContactCondition],
        (loose, direction): (&mut LooseMotions, &mut Vector),
    ) {
        let of_points: Vec<[bool; 3]> = conditions.iter().map(resisted).collect();
        let rows: Vec<f64> = (0..3).flat_map(|c| of_points.iter().map(move |of| f64::from(u8::from(of[c])))).collect();
        let rows = of_all_points(transformed.halo(), 3, &rows);
        loose.update(rows.into_iter().map(|row| row > 0.0).collect(), &self.jumps, &self.resultant);
        loose.take_off(transformed, self.motions, direction);
    }

    /// Whether the loads move some body along the surfaces that press against one another with these normal forces (newton, `m`)
    /// by more than the friction that is given by them resists. The energy then falls without bound along this motion. Not known
    /// where points are divided among ranks: such a descent ends with its cycles.
    pub(super) fn slide_off(&self, normals: &[f64]) -> bool {
        let mut lambda = normals.to_vec();
        lambda.resize(3 * normals.len(), 0.0);
        least_resisted(self.problem, self.motions, &lambda).is_some_and(|found| found.load > found.friction)
    }

    /// That motion, in the frames.
    pub(super) fn motion(&self, problem: &Subproblem<'_>, at: &Iterate) -> Vector {
        let m = problem.laws.len();
        let mut gap = vec![0.0; 3 * m];
        for (j, (p, law)) in problem.points().enumerate() {
            let lambda = at.force(problem.transformed, p.node);
            for c in (0..3).filter(|&c| p.has_row[c]) {
                gap[c * m + j] = law.target[c] - at.u[p.node][c] - lambda[c] / law.parameter;
            }
        }
        let gap = of_all_points(problem.transformed.halo(), 3, &gap);
        problem.transformed.to_frames(&self.equilibrium(problem.transformed, problem.laws, &gap))
    }

    /// Displacements of the unknowns here in the equilibrium of rigid bodies without any displacement before.
    pub(super) fn start(&self, transformed: &Transformed, laws: &[PointLaw]) -> Vec<f64> {
        let targets: Vec<f64> = (0..3).flat_map(|c| laws.iter().map(move |law| law.target[c])).collect();
        let mut gap = of_all_points(transformed.halo(), 3, &targets);
        keep_apart(&self.friction, &mut gap);
        self.equilibrium(transformed, laws, &gap)
    }

    /// `gap` is that of all points, `3m`.
    fn equilibrium(&self, transformed: &Transformed, laws: &[PointLaw], gap: &[f64]) -> Vec<f64> {
        let stiffness: Vec<f64> = laws.iter().map(|law| law.parameter).collect();
        let stiffness = of_all_points(transformed.halo(), 1, &stiffness);
        let (jumps, resultant) = (&self.jumps, &self.resultant[..]);
        let (friction, stiffness) = (&self.friction[..], &stiffness[..]);
        let equilibrium = Foundation { friction, jumps, resultant, gap, stiffness }.equilibrium();
        let mut u = vec![0.0; transformed.nodes.of.len()];
        self.motions.add(&equilibrium.alpha, &mut u);
        u
    }
}
