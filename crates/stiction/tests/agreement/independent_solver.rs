//! Given friction as a cone program solved by Clarabel, from matrices formed by a dense factorisation of the test.

use clarabel::algebra::CscMatrix;
use clarabel::solver::{
    DefaultSettings, DefaultSettingsBuilder, DefaultSolver, IPSolver, SolverStatus, SupportedConeT,
};
use stiction::certificate::certify;
use stiction::contact::{ContactProblem, Friction, SurfaceFriction};
use stiction::mesh::BlockElement;
use stiction_fixtures::*;

/// `min 1/2 l'Ql - h'l` over `l_n >= 0` and `|l_t| <= bound`, scaled to forces and energies of order one.
fn clarabel(p: &ContactProblem, q: &[Vec<f64>], h: &[f64], force: f64) -> Vec<f64> {
    let (m, size) = (p.points(), 3 * p.points());
    let length = h.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
    let (mut rows, mut columns, mut values) = (Vec::new(), Vec::new(), Vec::new());
    for (j, column) in q.iter().enumerate() {
        for (i, v) in column.iter().enumerate().take(j + 1) {
            rows.push(i);
            columns.push(j);
            values.push(v * force / length);
        }
    }
    let objective = CscMatrix::new_from_triplets(size, size, rows, columns, values);
    let linear: Vec<f64> = h.iter().map(|h| -h / length).collect();
    // s = b - A x: normal forces, then (bound, l_t) in the second-order cone, point by point.
    let mut cones = vec![SupportedConeT::NonnegativeConeT(m)];
    let (mut rows, mut columns, mut b) = ((0..m).collect::<Vec<_>>(), (0..m).collect::<Vec<_>>(), vec![0.0; m]);
    for (j, law) in p.contact.friction.iter().enumerate() {
        let Friction::Given { slip_bound } = *law else { panic!("given friction only") };
        rows.extend([b.len() + 1, b.len() + 2]);
        columns.extend([m + j, 2 * m + j]);
        b.extend([slip_bound / force, 0.0, 0.0]);
        cones.push(SupportedConeT::SecondOrderConeT(3));
    }
    let minus = vec![-1.0; rows.len()];
    let a = CscMatrix::new_from_triplets(b.len(), size, rows, columns, minus);
    let settings: DefaultSettings<f64> = DefaultSettingsBuilder::default()
        .verbose(false)
        .tol_gap_abs(1e-12)
        .tol_gap_rel(1e-12)
        .tol_feas(1e-12)
        .build()
        .unwrap();
    let mut solver = DefaultSolver::new(&objective, &linear, &a, &b, &cones, settings).unwrap();
    solver.solve();
    let status = solver.solution.status;
    assert!(matches!(status, SolverStatus::Solved | SolverStatus::AlmostSolved), "{status:?}");
    solver.solution.x.iter().map(|x| x * force).collect()
}

fn times(q: &[Vec<f64>], x: &[f64]) -> Vec<f64> {
    q.iter().map(|row| row.iter().zip(x).map(|(a, b)| a * b).sum()).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[test]
fn clarabel_finds_the_same_energy_and_the_same_displacement() {
    let element = BlockElement::Tet4Six;
    let cases = [
        (2, BrickLoad::Lift, 1.3e4),
        (4, BrickLoad::Lift, 1.3e4),
        (4, BrickLoad::Lift, 1.3e5),
        (4, BrickLoad::Press, 2e3),
        (4, BrickLoad::Press, 1.3e4),
    ];
    for (n, load, bound) in cases {
        let p = brick(n, element, load, SurfaceFriction::GivenForce(bound)).pose().problem;
        let factor = dense::Factor::new(&p.elastic.K);
        let (q, h) = dense::dual_data(&p, &factor);
        let ours = solved(&p, 1e-11);
        let force = ours.lambda.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
        let theirs = clarabel(&p, &q, &h, force);
        let objective = |l: &[f64]| 0.5 * dot(l, &times(&q, l)) - dot(&h, l);
        let (a, b) = (objective(&ours.lambda), objective(&theirs));
        assert!((a - b).abs() < 1e-8 * b.abs(), "{n} {load:?} {bound}: {a} {b}");
        // The energy norm of the difference of displacements is the Q norm of that of the multipliers.
        let d: Vec<f64> = ours.lambda.iter().zip(&theirs).map(|(a, b)| a - b).collect();
        let error = dot(&d, &times(&q, &d)).sqrt() / dot(&ours.u, &p.elastic.K.times(&ours.u)).sqrt();
        assert!(error < 1e-5, "{n} {load:?} {bound}: {error}");
        // Ours is at most the gap away from the optimum, theirs cannot be better than that.
        let gap = certify(&p, &ours.u, &ours.lambda, 1e-11).duality_gap.unwrap();
        assert!(gap < 1e-9 * b.abs() && a - b <= gap + 1e-13 * b.abs(), "{gap} {}", a - b);
    }
}

#[test]
fn the_displacement_is_that_of_a_dense_factorisation() {
    let p = brick(4, BlockElement::Hex8, BrickLoad::Press, SurfaceFriction::Coulomb(0.35)).pose().problem;
    let s = solved(&p, 1e-10);
    let mut force = p.elastic.f.clone();
    force.iter_mut().zip(p.contact.B.transpose_times(&s.lambda)).for_each(|(f, b)| *f -= b);
    assert!(distance(&dense::Factor::new(&p.elastic.K).solve(&force), &s.u) < 1e-11);
}
