//! The certificate must fail when it should: a good solution with one thing damaged at a time.

use std::ops::ControlFlow;

use stiction::certificate::{Certificate, certify};
use stiction::contact::{ContactProblem, SurfaceFriction};
use stiction::dual::Form;
use stiction::friction::{PointState, Solution, Status};
use stiction::io::case;
use stiction::linalg::{Csr, norm};
use stiction::mesh::BlockElement;
use stiction::run::{Outcome, Prepared, Settings, prepare, solve};
use stiction_fixtures::*;

const TOLERANCE: f64 = 1e-8;

fn good() -> (ContactProblem, Solution) {
    let p = brick(4, BlockElement::Tet4Six, BrickLoad::Lift, SurfaceFriction::Coulomb(0.35)).pose().problem;
    let s = solved(&p, 1e-11);
    assert!(certify(&p, &s.u, &s.lambda, TOLERANCE).passed);
    (p, s)
}

fn measure(c: &Certificate, name: &str) -> f64 {
    c.measures().into_iter().find(|(n, _)| *n == name).unwrap().1
}

/// The damaged answer is refused, and so it is by every measure named.
fn assert_refused(p: &ContactProblem, u: &[f64], lambda: &[f64], named: &[&str]) {
    let c = certify(p, u, lambda, TOLERANCE);
    assert!(!c.passed, "{:?}", c.measures());
    for name in named {
        assert!(measure(&c, name) > TOLERANCE, "{name} in {:?}", c.measures());
    }
}

fn assert_silent(p: &ContactProblem, u: &[f64], lambda: &[f64], names: &[&str]) {
    let c = certify(p, u, lambda, TOLERANCE);
    for name in names {
        assert!(measure(&c, name) <= TOLERANCE, "{name} in {:?}", c.measures());
    }
}

fn with_state(s: &Solution, state: PointState) -> usize {
    // The one with the largest normal force, so that its share is seen.
    let found = (0..s.states.len()).filter(|&j| s.states[j] == state);
    found.max_by(|&a, &b| s.lambda[a].total_cmp(&s.lambda[b])).unwrap()
}

fn turned(lambda: &[f64], m: usize, points: impl Iterator<Item = usize>, angle: f64) -> Vec<f64> {
    let mut turned = lambda.to_vec();
    let (s, c) = angle.sin_cos();
    for j in points {
        let (a, b) = (lambda[m + j], lambda[2 * m + j]);
        (turned[m + j], turned[2 * m + j]) = (c * a - s * b, s * a + c * b);
    }
    turned
}

#[test]
fn a_friction_force_that_pushes_along_is_refused() {
    let (p, s) = good();
    let j = with_state(&s, PointState::Slip);
    let flipped = turned(&s.lambda, p.points(), std::iter::once(j), std::f64::consts::PI);
    assert_refused(&p, &s.u, &flipped, &["slip_direction", "bipotential_gap", "natural_residual", "equilibrium"]);
    assert_silent(&p, &s.u, &flipped, &["penetration", "tension", "cone"]);
}

#[test]
fn friction_one_degree_off_the_slip_is_refused() {
    let (p, s) = good();
    let slipping = (0..p.points()).filter(|&j| s.states[j] == PointState::Slip);
    let off = turned(&s.lambda, p.points(), slipping, 1f64.to_radians());
    // Displacements are given to fit, so that equilibrium cannot tell.
    let u = dual_of(&p, Form::Auto).displacement(&p, &off);
    assert_refused(&p, &u, &off, &["slip_direction", "natural_residual"]);
    assert_silent(&p, &u, &off, &["equilibrium", "tension", "cone", "force_balance", "moment_balance"]);
}

#[test]
fn friction_below_its_bound_at_a_slipping_point_is_refused() {
    let (p, s) = good();
    let m = p.points();
    let j = with_state(&s, PointState::Slip);
    let mut weak = s.lambda.clone();
    [m + j, 2 * m + j].into_iter().for_each(|i| weak[i] *= 0.99);
    assert_refused(&p, &s.u, &weak, &["slip_direction", "natural_residual"]);
    assert_silent(&p, &s.u, &weak, &["cone"]);
}

#[test]
fn tension_is_refused() {
    let (p, s) = good();
    let mut glued = s.lambda.clone();
    glued[with_state(&s, PointState::Open)] = -1e-6 * s.lambda[with_state(&s, PointState::Slip)];
    assert_refused(&p, &s.u, &glued, &["tension", "natural_residual", "equilibrium"]);
}

#[test]
fn a_force_across_a_gap_is_refused() {
    let (p, s) = good();
    let mut remote = s.lambda.clone();
    remote[with_state(&s, PointState::Open)] = 0.1 * s.lambda[with_state(&s, PointState::Slip)];
    let u = dual_of(&p, Form::Auto).displacement(&p, &remote);
    assert_refused(&p, &u, &remote, &["bipotential_gap", "natural_residual"]);
    assert_silent(&p, &u, &remote, &["equilibrium", "tension"]);
}

#[test]
fn friction_outside_the_cone_is_refused() {
    let (p, s) = good();
    let m = p.points();
    let j = with_state(&s, PointState::Slip);
    let mut strong = s.lambda.clone();
    [m + j, 2 * m + j].into_iter().for_each(|i| strong[i] *= 1.0 + 1e-6);
    assert_refused(&p, &s.u, &strong, &["cone", "natural_residual"]);
    assert_silent(&p, &s.u, &strong, &["tension", "penetration"]);
}

#[test]
fn a_penetrating_point_is_refused() {
    let (p, s) = good();
    let largest = s.u.iter().fold(0.0, |a: f64, x| a.max(x.abs()));
    let j = with_state(&s, PointState::Slip);
    let mut deep = s.u.clone();
    let (columns, values) = p.contact.B.row(j);
    columns.iter().zip(values).for_each(|(&c, v)| deep[c as usize] += 1e-7 * largest * v);
    assert_refused(&p, &deep, &s.lambda, &["penetration"]);
    assert_silent(&p, &deep, &s.lambda, &["tension", "cone"]);
}

#[test]
fn a_scaled_displacement_is_refused() {
    let (p, s) = good();
    let longer: Vec<f64> = s.u.iter().map(|u| u * (1.0 + 1e-6)).collect();
    assert_refused(&p, &longer, &s.lambda, &["equilibrium"]);
}

#[test]
fn the_answer_to_other_loads_is_refused() {
    let (p, s) = good();
    let mut less = brick(4, BlockElement::Tet4Six, BrickLoad::Lift, SurfaceFriction::Coulomb(0.35));
    less.loads.remove(0);
    let less = less.pose().problem;
    assert_eq!(less.elastic.f.len(), p.elastic.f.len());
    assert_refused(&less, &s.u, &s.lambda, &["equilibrium", "force_balance", "moment_balance"]);
}

#[test]
fn the_answer_to_other_friction_is_refused() {
    let (p, s) = good();
    for coefficient in [0.3, 0.4] {
        let law = stiction::contact::Friction::Coulomb { coefficient };
        let other = with_friction(&p, vec![law; p.points()]);
        assert_refused(&other, &s.u, &s.lambda, &["natural_residual"]);
    }
}

#[test]
fn what_is_not_a_number_is_refused() {
    let (p, s) = good();
    for i in [0, p.unknowns() / 2] {
        let mut u = s.u.clone();
        u[i] = f64::NAN;
        assert!(!certify(&p, &u, &s.lambda, TOLERANCE).passed);
    }
    for value in [f64::NAN, f64::INFINITY] {
        let mut lambda = s.lambda.clone();
        lambda[with_state(&s, PointState::Slip)] = value;
        assert!(!certify(&p, &s.u, &lambda, TOLERANCE).passed);
    }
}

#[test]
fn a_bonded_point_that_moves_is_refused() {
    let p = brick(4, BlockElement::Hex8, BrickLoad::Lift, SurfaceFriction::Bonded).pose().problem;
    let s = solved(&p, 1e-11);
    let free = with_friction(&p, vec![stiction::contact::Friction::None; p.points()]);
    let loose = solved(&free, 1e-11);
    assert_refused(&p, &loose.u, &loose.lambda, &["penetration", "natural_residual"]);
    assert_refused(&free, &s.u, &s.lambda, &["tension", "cone"]);
}

/// A body that nothing holds has flown so far that the rounding of its inner forces is larger than the load: the load is balanced by
/// nothing all the same.
#[test]
fn a_body_that_has_flown_away_is_refused() {
    let mut case = brick(2, BlockElement::Hex8, BrickLoad::Press, SurfaceFriction::Coulomb(0.3));
    case.fixes.clear();
    let mut p = case.pose().problem;
    p.elastic.f.iter_mut().for_each(|f| *f = -*f);
    let rigid = p.elastic.near_kernel.clone().unwrap();
    let far: Vec<f64> = rigid.iter().map(|motion| 1e12 * motion[2]).collect();
    assert_refused(&p, &far, &vec![0.0; 3 * p.points()], &["force_balance"]);
}

fn scaled(a: &Csr, by: f64) -> Csr {
    Csr { value: a.value.iter().map(|v| v * by).collect(), ..a.clone() }
}

/// The problem in units of which one old length is `length` new ones and one old force `force` new ones.
fn in_units(p: &ContactProblem, length: f64, force: f64) -> ContactProblem {
    let times = |v: &[f64], by: f64| -> Vec<f64> { v.iter().map(|x| x * by).collect() };
    let rows = |rows: &[[f64; 6]]| -> Vec<[f64; 6]> {
        rows.iter().map(|r| [r[0], r[1], r[2], r[3] * length, r[4] * length, r[5] * length]).collect()
    };
    let mut q = p.clone();
    std::sync::Arc::make_mut(&mut q.elastic.K).value = times(&p.elastic.K.value, force / length);
    q.elastic.f = times(&p.elastic.f, force);
    q.contact.gap = times(&p.contact.gap, length);
    q.contact.slip_reference = times(&p.contact.slip_reference, length);
    q.elastic.near_kernel = p.elastic.near_kernel.as_deref().map(rows);
    let s = q.labels.supports.as_mut().unwrap();
    (s.K, s.K_own) = (scaled(&s.K, force / length), scaled(&s.K_own, force / length));
    (s.load, s.free_load) = (times(&s.load, force), times(&s.free_load, force));
    (s.displacement, s.rigid) = (times(&s.displacement, length), rows(&s.rigid));
    q
}

#[test]
fn the_measures_have_no_units() {
    let (p, s) = good();
    // A thoroughly wrong answer, so that every measure is more than rounding.
    let m = p.points();
    let lambda: Vec<f64> = s.lambda.iter().enumerate().map(|(i, l)| 1.3 * l + 400.0 * (i as f64).sin()).collect();
    let u: Vec<f64> = s.u.iter().enumerate().map(|(i, u)| u + 1e-6 * (1.0 + i as f64).cos()).collect();
    let here = certify(&p, &u, &lambda, TOLERANCE).measures();
    assert!(here.iter().all(|(name, x)| *x > 1e-9 || panic!("{name} {x}")) && m > 0);
    for (length, force) in
        [(1e3, 1e-3), (1e-6, 1.0), (39.37, 0.2248), (1.0, 1e12), (1e-12, 1e9), (1e9, 1e-12), (1e-12, 1e-12), (1e9, 1e9)]
    {
        let scale = |v: &[f64], by: f64| -> Vec<f64> { v.iter().map(|x| x * by).collect() };
        let there = certify(&in_units(&p, length, force), &scale(&u, length), &scale(&lambda, force), TOLERANCE);
        for ((name, a), (_, b)) in here.iter().zip(there.measures()) {
            assert!(close(*a, b, 1e-12), "{name}: {a} {b}");
        }
    }
}

#[test]
fn the_duality_gap_bounds_the_energy_of_the_error() {
    for load in [BrickLoad::Lift, BrickLoad::Press] {
        let p = brick(4, BlockElement::Tet4Six, load, SurfaceFriction::GivenForce(1.3e4)).pose().problem;
        let m = p.points();
        let s = solved(&p, 1e-12);
        let dual = dual_of(&p, Form::Auto);
        let mut before = f64::INFINITY;
        for size in [3.0, 1.0, 0.1, 1e-2, 1e-3, 1e-4] {
            let largest = s.lambda[..m].iter().fold(0.0, |a: f64, x| a.max(*x));
            let mut lambda = s.lambda.clone();
            for j in 0..m {
                let noise = |k: f64| size * (k + 7.3 * j as f64).sin();
                lambda[j] = (lambda[j] + largest * noise(1.0)).max(0.0);
                let (a, b) = (lambda[m + j] + 1.3e4 * noise(2.0), lambda[2 * m + j] + 1.3e4 * noise(3.0));
                let shrink = (1.3e4 / f64::hypot(a, b)).min(1.0);
                (lambda[m + j], lambda[2 * m + j]) = (a * shrink, b * shrink);
            }
            let u = dual.displacement(&p, &lambda);
            let d: Vec<f64> = u.iter().zip(&s.u).map(|(a, b)| a - b).collect();
            let error = 0.5 * d.iter().zip(p.elastic.K.times(&d)).map(|(a, b)| a * b).sum::<f64>();
            let gap = certify(&p, &u, &lambda, TOLERANCE).duality_gap.unwrap();
            println!("{load:?} {size}: error {error:.3e} gap {gap:.3e}");
            assert!(error <= gap, "{size}: {error} {gap}");
            // Small errors are bounded by small gaps.
            assert!(size > 0.05 || gap < 0.5 * before);
            before = gap;
        }
    }
    let (p, s) = good();
    assert_eq!(certify(&p, &s.u, &s.lambda, TOLERANCE).duality_gap, None);
}

/// A softer block lies loose on a stiffer one with smaller cells, pressed and sheared, Coulomb friction.
fn soft_on_stiff(ratio: f64, path: &str) -> (Prepared, Outcome) {
    let text = format!(
        r#"
[mesh.parts.low]
block = {{ size = [30, 20, 10], cells = [16, 12, 2], element = "hex8" }}
[mesh.parts.high]
block = {{ size = [30, 20, 10], cells = [7, 5, 2], element = "tet4" }}
move = [0, 0, 10]
[materials.soft]
on = "high"
young = 1.0
poisson = 0.3
[materials.stiff]
on = "low"
young = {ratio:e}
poisson = 0.3
[[fix]]
on = "low.z-min"
[[load]]
on = "high.z-max"
traction = [2e-3, 1e-3, "-1e-2*(1 + x/30)"]
[[contact]]
on = "high.z-min"
against = "low.z-max"
friction = {{ coulomb = 0.4 }}
"#
    );
    let case = case::parse(&text, "soft.toml", &[("solver.path".into(), path.into())]).unwrap();
    let prepared = prepare(&case).unwrap();
    let outcome = solve(&prepared, &Settings::of(&case.solver), &mut |_| ControlFlow::Continue(())).unwrap();
    (prepared, outcome)
}

/// Compliances add across an interface: what a wrong force shows in the natural residual is its own size, however stiff
/// the other body is. Judged by the stiffness of the stiff body, rounding of the soft body's displacement does not pass
/// from a ratio of 1e6 on.
#[test]
fn unlike_bodies_are_judged_by_what_yields() {
    for ratio in [1.0, 1e2, 1e4, 1e6] {
        for path in ["solves", "dense", "multigrid"] {
            let (Prepared { problem: p, .. }, Outcome { solution: s, .. }) = soft_on_stiff(ratio, path);
            println!("{ratio:e} {path:?}: {:?} {:.1e}", s.status, s.certificate.worst);
            assert_eq!(s.status, Status::Solved, "{ratio:e} {path:?} {:?}", s.certificate.measures());
            // Forces of points that stick, wrong by 1e-6; displacements are given to fit.
            let m = p.points();
            let mut wrong = s.lambda.clone();
            let stick = |j: &usize| s.states[*j] == PointState::Stick;
            let size = norm(&wrong);
            let held: Vec<usize> = (0..m).filter(stick).collect();
            assert!(held.len() > m / 4, "{} of {m} stick", held.len());
            for &j in &held {
                wrong[m + j] += 1e-6 * size / (held.len() as f64).sqrt() * (1.0 + j as f64).sin().signum();
            }
            let dual = dual_of(&p, Form::Auto);
            let mut u = dual.displacement(&p, &wrong);
            // The rigid motions stay those of the answer.
            let motions = &dual.floating.motions;
            let alpha: Vec<f64> = motions.work(&s.u).iter().zip(motions.work(&u)).map(|(a, b)| a - b).collect();
            motions.add(&alpha, &mut u);
            let c = certify(&p, &u, &wrong, TOLERANCE);
            println!("    wrong by 1e-6: {:.1e}", c.natural_residual);
            assert!(!c.passed && (1e-7..1e-5).contains(&c.natural_residual), "{ratio:e} {:?}", c.measures());
        }
    }
}
