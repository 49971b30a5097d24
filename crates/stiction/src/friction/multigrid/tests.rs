use std::ops::ControlFlow;

use super::active_set::PointLaw;
use super::descent::descend;
use super::iteration::{State, Subproblem};
use super::solve::point_laws;
use super::transform::Transformed;
use crate::contact::{ContactProblem, Division, Friction};
use crate::dual::{Dual, DualSettings, choose};
use crate::friction::{End, Settings, Status, solve};
use crate::linalg::{Csr, Stop, SymmetricCsr};
use crate::ranks::threads;

const SIZE: [usize; 3] = [9, 5, 4];

/// A lattice of springs along edges and face diagonals, supported weakly at x = 0, under a load that presses one half on
/// the plane z = 0, lifts the other and drags along x and y.
fn lattice(friction: Friction) -> ContactProblem {
    let [a, b, c] = SIZE;
    let node = |x: [usize; 3]| (x[0] * b + x[1]) * c + x[2];
    let place = |v: usize| [v / (b * c), v / c % b, v % c];
    let offsets = (0..27i64).map(|q| [q / 9 - 1, q / 3 % 3 - 1, q % 3 - 1]);
    let offsets: Vec<[i64; 3]> = offsets.filter(|o| (1..=2).contains(&o.iter().map(|v| v * v).sum::<i64>())).collect();
    let n = 3 * a * b * c;
    let mut k = Vec::new();
    for v in 0..n / 3 {
        let x = place(v);
        let support = if x[0] == 0 { 1.0 } else { 1e-9 };
        (0..3).for_each(|r| k.push((3 * v + r, 3 * v + r, support)));
        for o in &offsets {
            let y: [i64; 3] = std::array::from_fn(|d| x[d] as i64 + o[d]);
            if (0..3).any(|d| y[d] < 0 || y[d] >= SIZE[d] as i64) {
                continue;
            }
            let w = node(y.map(|v| v as usize));
            let length = o.iter().map(|v| v * v).sum::<i64>() as f64;
            for (r, s) in (0..9).map(|q| (q / 3, q % 3)) {
                let stiffness = (o[r] * o[s]) as f64 / length;
                k.push((3 * v + r, 3 * v + s, stiffness));
                k.push((3 * v + r, 3 * w + s, -stiffness));
            }
        }
    }
    let mut f = vec![0.0; n];
    for v in (0..n / 3).filter(|&v| place(v)[2] == c - 1) {
        let lift = (place(v)[0] as f64 - 5.0) / 5.0;
        [0.02, 0.01, 0.02 * lift].into_iter().enumerate().for_each(|(r, force)| f[3 * v + r] = force);
    }
    let contact: Vec<usize> = (0..n / 3).filter(|&v| place(v)[2] == 0).collect();
    let m = contact.len();
    let rows = contact
        .iter()
        .enumerate()
        .flat_map(|(j, &v)| [(j, 3 * v + 2, -1.0), (m + j, 3 * v, 1.0), (2 * m + j, 3 * v + 1, 1.0)]);
    let rows: Vec<(usize, usize, f64)> = rows.collect();
    let mut problem = ContactProblem::from_matrices(
        SymmetricCsr::from_full(&Csr::from_triplets(n, n, &k), "K").unwrap(),
        f,
        Csr::from_triplets(3 * m, n, &rows),
        (0..m).map(|j| 1e-3 * (j % 3) as f64).collect(),
        vec![friction; m],
    );
    problem.elastic.node_of = Some((0..n as u32).map(|i| i / 3).collect());
    let motions = |i: usize| {
        let [x, y, z] = place(i / 3).map(|v| v as f64);
        [[1., 0., 0., 0., z, -y], [0., 1., 0., -z, 0., x], [0., 0., 1., y, -x, 0.]][i % 3]
    };
    problem.elastic.near_kernel = Some((0..n).map(motions).collect());
    problem.validate().unwrap();
    problem
}

/// `1/2 u'Ku - f'u + sum of g |s|`, with the slip across the first tangent scaled by the orthotropy ratio.
fn energy(problem: &ContactProblem, u: &[f64]) -> f64 {
    let dot = |x: &[f64], y: &[f64]| x.iter().zip(y).map(|(x, y)| x * y).sum::<f64>();
    let m = problem.points();
    let jump = problem.contact.B.times(u);
    let friction = problem.contact.friction.iter().enumerate().map(|(j, law)| match law {
        Friction::Given { slip_bound } => slip_bound * jump[m + j].hypot(problem.orthotropy_ratio(j) * jump[2 * m + j]),
        _ => 0.0,
    });
    0.5 * dot(u, &problem.elastic.K.times(u)) - dot(&problem.elastic.f, u) + friction.sum::<f64>()
}

/// Descends from displacements without order.
fn descend_for(problem: &ContactProblem, cycles: usize) -> (End, usize, Vec<f64>) {
    let (transformed, mut hierarchy) = Transformed::new(problem, &Stop::never()).unwrap();
    let laws = point_laws(problem, &transformed);
    let mut state = State::at(transformed.to_frames(&disorder(problem)), &transformed.k);
    let subproblem = subproblem(&transformed, &laws, cycles);
    let end = descend(&subproblem, &mut hierarchy, &mut state, &|| false, &mut |_, _, _| ControlFlow::Continue(()));
    (end, state.cycles, transformed.out_of_frames(&state.iterate.u))
}

/// The same on several ranks, each of which is given all of the problem and owns some of its slices.
fn descend_on_ranks(problem: &ContactProblem, size: usize, cycles: usize) -> (End, Vec<f64>) {
    let nodes = problem.unknowns() / 3;
    let parts = threads(size, |ranks| {
        let node_of = |j: usize| problem.contact.B.row(problem.rows(j)[0]).0[0] / 3;
        let division = Division {
            ranks,
            owner: (0..nodes).map(|v| (v * size / nodes) as u32).collect(),
            global: (0..nodes as u64).collect(),
            supports: Vec::new(),
            points: (0..problem.points()).map(node_of).collect(),
        };
        let (transformed, mut hierarchy, divided) = Transformed::divided(problem, &division, &Stop::never()).unwrap();
        let laws = point_laws(&divided.own(), &transformed);
        let mut state = State::at(transformed.to_frames(&disorder(problem)), &transformed.k);
        let subproblem = subproblem(&transformed, &laws, cycles);
        let end = descend(&subproblem, &mut hierarchy, &mut state, &|| false, &mut |_, _, _| ControlFlow::Continue(()));
        (end, transformed.out_of_frames(&state.iterate.u))
    });
    let mut u = vec![0.0; problem.unknowns()];
    parts.iter().for_each(|(_, part)| u.iter_mut().zip(part).for_each(|(u, x)| *u += x));
    assert!(parts.iter().all(|part| part.0 == parts[0].0));
    (parts[0].0, u)
}

/// Displacements without order, with nodes inside the obstacle.
fn disorder(problem: &ContactProblem) -> Vec<f64> {
    (0..problem.unknowns()).map(|i| (i as f64 * 0.618).fract() - 0.5).collect()
}

fn subproblem<'a>(transformed: &'a Transformed, laws: &'a [PointLaw], cycles: usize) -> Subproblem<'a> {
    Subproblem {
        transformed,
        laws,
        tolerance: 1e-10,
        max_cycles: cycles,
        max_resets: 0,
        max_violation: f64::INFINITY,
        floating: None,
        tightening: None,
        equations: None,
    }
}

/// The direct path is the second road.
fn by_factor(problem: &ContactProblem) -> Vec<f64> {
    let dual = Dual::new(problem, choose(problem, &DualSettings::default()).unwrap()).unwrap();
    let settings = Settings { tolerance: 1e-10, ..Settings::default() };
    let solution = solve(problem, &dual, &settings, &mut |_| ControlFlow::Continue(()));
    assert_eq!(solution.status, Status::Solved);
    solution.u
}

#[test]
fn the_descent_for_given_friction_loses_energy_in_every_step_and_ends_at_the_solution() {
    for (friction, ratio) in [
        (Friction::None, None),
        (Friction::Given { slip_bound: 0.02 }, None),
        (Friction::Given { slip_bound: 0.02 }, Some(0.2)),
    ] {
        let mut problem = lattice(friction);
        problem.contact.orthotropy = ratio.map(|ratio| vec![ratio; problem.points()]);
        let reference = by_factor(&problem);
        let least = energy(&problem, &reference);
        let mut before = f64::INFINITY;
        for cycles in 0..12 {
            let now = energy(&problem, &descend_for(&problem, cycles).2);
            assert!(now <= before + 1e-13 * least.abs() && now >= least - 1e-9 * least.abs(), "{before} {now} {least}");
            before = now;
        }
        let (end, cycles, u) = descend_for(&problem, 300);
        assert!(end == End::Converged && cycles <= 80, "{friction:?} {ratio:?}: {end:?} after {cycles}");
        let size = reference.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
        let error = u.iter().zip(&reference).fold(0.0, |a: f64, (x, y)| a.max((x - y).abs()));
        assert!(error < 1e-7 * size, "{friction:?} {ratio:?}: {error:e} of {size:e}");
    }
}

#[test]
fn the_descent_loses_energy_in_every_step_on_ranks_too() {
    let problem = lattice(Friction::Given { slip_bound: 0.02 });
    let reference = by_factor(&problem);
    let least = energy(&problem, &reference);
    let size = reference.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
    for ranks in [2, 3, 6] {
        let mut before = f64::INFINITY;
        for cycles in 0..6 {
            let now = energy(&problem, &descend_on_ranks(&problem, ranks, cycles).1);
            assert!(now <= before + 1e-13 * least.abs() && now >= least - 1e-9 * least.abs(), "{before} {now} {least}");
            before = now;
        }
        let (end, u) = descend_on_ranks(&problem, ranks, 300);
        let error = u.iter().zip(&reference).fold(0.0, |a: f64, (x, y)| a.max((x - y).abs()));
        assert!(end == End::Converged && error < 1e-7 * size, "{ranks} ranks: {end:?}, {error:e} of {size:e}");
    }
}
