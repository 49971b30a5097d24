//! Contact problems as cone programs solved by Clarabel, and dense factorisations of the tests' own.

use stiction::certificate::certify;
use stiction::contact::equilibrium::unresisted;
use stiction::contact::rigid::rigid_motions;
use stiction::contact::{Across, ContactProblem, CoulombLaw, Friction, Obstacle, SurfaceFriction};
use stiction::fem::Field;
use stiction::linalg::Csr;
use stiction::mesh::BlockElement;
use stiction_fixtures::*;

use crate::cone_program::{Cones, dot, objective, scaled, times};

/// `min 1/2 l'Ql - h'l` over `l_n >= 0` and `|(l_1, l_2 / a)| <= bound`, scaled to forces and energies of order one.
fn clarabel(p: &ContactProblem, q: &[Vec<f64>], h: &[f64], bounds: &[f64], force: f64) -> Vec<f64> {
    let m = p.points();
    let length = h.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
    let mut cones = Cones::default();
    for (j, bound) in bounds.iter().enumerate() {
        let across = p.contact.orthotropy.as_ref().map_or(1.0, |across| across[j]);
        cones.nonnegative(0.0, &[(j, -1.0)]);
        cones.disc(bound / force, &[(m + j, -1.0)], &[(2 * m + j, -1.0 / across)]);
    }
    let linear: Vec<f64> = h.iter().map(|h| h / length).collect();
    let (x, _) = cones.minimum(&scaled(q, force / length), &linear, 1e-12);
    x.iter().map(|x| x * force).collect()
}

/// Bounds of the friction forces with these forces.
fn bounds_at(p: &ContactProblem, lambda: &[f64]) -> Vec<f64> {
    let bound = |(law, normal): (&Friction, &f64)| match *law {
        Friction::Coulomb { coefficient } => coefficient * normal,
        Friction::Limited { coefficient, limit } => (coefficient * normal).min(limit),
        Friction::Given { slip_bound } => slip_bound,
        _ => panic!("{law:?} has no bound"),
    };
    p.contact.friction.iter().zip(lambda).map(bound).collect()
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
        let bounds = bounds_at(&p, &ours.lambda);
        let theirs = clarabel(&p, &q, &h, &bounds, force);
        let (a, b) = (objective(&q, &h, &ours.lambda), objective(&q, &h, &theirs));
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
fn clarabel_finds_the_same_energy_over_ellipses() {
    // Given ellipses, and those a solution of the Coulomb problem ends with: it is the optimum for its own bounds.
    let brick_with = |law: SurfaceFriction| brick(4, BlockElement::Hex8, BrickLoad::Press, law).pose().problem;
    let mut given = brick_with(orthotropic(0.5, 0.1, [1.0, 1.0, 0.0]));
    given.contact.friction.fill(Friction::Given { slip_bound: 1e4 });
    let coulomb = brick_with(orthotropic(0.5, 0.1, [1.0, 1.0, 0.0]));
    let both = brick_with(SurfaceFriction::Law(CoulombLaw {
        coefficient: Field::Constant(0.1).into(),
        across: Some(Across { coefficient: Field::Constant(0.5).into(), direction: [1.0, 1.0, 0.0] }),
        limit: Some(2.5e5),
        cohesion: None,
    }));
    for p in [given, coulomb, both] {
        let factor = dense::Factor::new(&p.elastic.K);
        let (q, h) = dense::dual_data(&p, &factor);
        let ours = solved(&p, 1e-11);
        let bounds = bounds_at(&p, &ours.lambda);
        let force = ours.lambda.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
        let theirs = clarabel(&p, &q, &h, &bounds, force);
        let (a, b) = (objective(&q, &h, &ours.lambda), objective(&q, &h, &theirs));
        assert!((a - b).abs() < 1e-8 * b.abs(), "{a} {b}");
        let d: Vec<f64> = ours.lambda.iter().zip(&theirs).map(|(a, b)| a - b).collect();
        let error = dot(&d, &times(&q, &d)).sqrt() / dot(&ours.u, &p.elastic.K.times(&ours.u)).sqrt();
        assert!(error < 1e-5, "{error}");
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

/// `min 1/2 u'Ku - f'u` over `N u <= gap`: the displacements' own quadratic program, `K` singular.
#[test]
fn clarabel_finds_the_same_rest_of_a_block_in_a_corner() {
    let wall = |normal: [f64; 3]| Obstacle::Plane { point: [0.0; 3], normal };
    let mut case = block_of([1.0, 0.8, 0.6], [3, 3, 3], BlockElement::Hex8, 2.1e11, 0.3)
        .traction("x-max", [-1e6, 0.0, 0.0])
        .traction("y-max", [0.0, -2e6, 0.0])
        .traction_z("z-max", |x| -4e6 * x[0])
        .contact("x-min", wall([1.0, 0.0, 0.0]), SurfaceFriction::None)
        .contact("y-min", wall([0.0, 1.0, 0.0]), SurfaceFriction::None)
        .contact("z-min", FLOOR, SurfaceFriction::None);
    // Off the walls by more than it deforms.
    case.mesh.nodes.iter_mut().for_each(|x| *x = [x[0] + 1e-3, x[1] + 2e-3, x[2] + 1e-4]);
    let p = case.pose().problem;
    let motions = rigid_motions(&p);
    assert!(motions.len() == 6 && unresisted(&p, &motions).is_none());
    let s = solved(&p, 1e-10);
    let (m, n) = (p.points(), p.unknowns());
    let row = |a: &Csr, i: usize| {
        let (columns, values) = a.row(i);
        columns.iter().zip(values).map(|(&j, &v)| (j as usize, v)).collect::<Vec<_>>()
    };
    // Displacements over 1e-5, forces over 1e5.
    let (length, force) = (1e-5, 1e5);
    let mut cones = Cones::default();
    (0..m).for_each(|j| cones.nonnegative(p.contact.gap[j] / length, &row(&p.contact.B, j)));
    let full = p.elastic.K.full();
    let mut k = vec![vec![0.0; n]; n];
    (0..n).for_each(|i| row(&full, i).into_iter().for_each(|(j, v)| k[i][j] = v * length / force));
    let f: Vec<f64> = p.elastic.f.iter().map(|f| f / force).collect();
    let (x, z) = cones.minimum(&k, &f, 1e-12);
    let theirs: Vec<f64> = x.iter().map(|x| x * length).collect();
    let forces: Vec<f64> = z.iter().map(|x| x * force).collect();
    assert!(distance(&s.lambda[..m], &forces) < 1e-5, "{}", distance(&s.lambda[..m], &forces));
    assert!(distance(&s.u, &theirs) < 1e-7, "{}", distance(&s.u, &theirs));
}
