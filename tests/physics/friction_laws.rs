//! Friction that differs by direction or place, or has a limit: closed forms, both paths.

use std::f64::consts::TAU;
use std::ops::ControlFlow;
use std::sync::Arc;

use stiction::certificate::certify;
use stiction::contact::{Contact, ContactProblem, CoulombLaw, Friction, SurfaceFriction};
use stiction::dual::Form;
use stiction::fem::Field;
use stiction::friction::{
    Given, Method, MethodSettings, Multigrid, PointState, Solution, coulomb_facts, solve_multigrid, solve_with,
};
use stiction::mesh::BlockElement;
use stiction_fixtures::*;

const YOUNG: f64 = 2e9;
const SHORTENING: f64 = 2e-3;
const PRESSURE: f64 = YOUNG * SHORTENING / 2.0;

/// A cube of side 2 without lateral contraction pressed by `PRESSURE`, its top shifted, with the shear tractions on its
/// sides that keep the uniform shear stress `tau` in balance.
fn sheared(shift: [f64; 2], tau: [f64; 2], friction: SurfaceFriction) -> ContactProblem {
    let case = block_of([2.0; 3], [3, 2, 4], BlockElement::Hex8, YOUNG, 0.0)
        .fix("z-max", [Some(shift[0]), Some(shift[1]), Some(-SHORTENING)])
        .contact("z-min", FLOOR, friction)
        .traction("x-max", [0.0, 0.0, tau[0]])
        .traction("x-min", [0.0, 0.0, -tau[0]])
        .traction("y-max", [0.0, 0.0, tau[1]])
        .traction("y-min", [0.0, 0.0, -tau[1]]);
    case.pose().problem
}

/// Slips and friction forces over area along x and y; the rows of `B` say where the tangents point.
fn in_axes(p: &ContactProblem, s: &Solution) -> Vec<([f64; 2], [f64; 2])> {
    let m = p.points();
    let slip = p.contact.B.times(&s.u);
    let tangent = |j: usize, k: usize| {
        let (columns, values) = p.contact.B.row(k * m + j);
        let axis = |c: u32| {
            let motion = p.elastic.near_kernel.as_ref().unwrap();
            columns.iter().zip(values).filter(|(i, _)| motion[**i as usize][c as usize] == 1.0).map(|(_, v)| v).sum()
        };
        [axis(0), axis(1)]
    };
    let point = |j: usize| {
        let t: [[f64; 2]; 2] = [tangent(j, 1), tangent(j, 2)];
        let sum = |v: &[f64]| [0, 1].map(|c| t[0][c] * v[m + j] + t[1][c] * v[2 * m + j]);
        (sum(&slip), sum(&s.lambda).map(|f| f / p.labels.area[j]))
    };
    (0..m).map(point).collect()
}

#[test]
fn a_block_dragged_across_a_grain_is_held_back_along_the_normal_of_the_ellipse() {
    // The grain lies at 30 degrees. A slip s with components (a, b) along and across it meets the force
    // p (F1² a, F2² b) / |(F1 a, F2 b)|; the top is shifted by that shear's strain and the slip.
    let grain = [(TAU / 12.0).cos(), (TAU / 12.0).sin(), 0.0];
    for (f1, f2) in [(0.4, 0.1), (0.1, 0.4), (0.05, 0.5), (0.3, 0.0)] {
        for angle in [0.3, 1.2, 2.9, 4.4] {
            let size = 1e-5;
            let slip = [size * f64::cos(angle), size * f64::sin(angle)];
            let a = slip[0] * grain[0] + slip[1] * grain[1];
            let b = -slip[0] * grain[1] + slip[1] * grain[0];
            let length = f64::hypot(f1 * a, f2 * b);
            let [fa, fb] = [f1 * f1 * a / length, f2 * f2 * b / length].map(|f| f * PRESSURE);
            let tau = [fa * grain[0] - fb * grain[1], fa * grain[1] + fb * grain[0]];
            let shift = [0, 1].map(|c| slip[c] + tau[c] * 2.0 / (YOUNG / 2.0));
            let p = sheared(shift, tau, orthotropic(f1, f2, grain));
            let s = solved(&p, 1e-11);
            for (slip_found, force) in in_axes(&p, &s) {
                for c in 0..2 {
                    assert!(
                        (slip_found[c] - slip[c]).abs() < 1e-7 * size,
                        "{f1} {f2} {angle}: {slip_found:?} {slip:?}"
                    );
                    assert!((force[c] - tau[c]).abs() < 1e-8 * PRESSURE, "{f1} {f2} {angle}: {force:?} {tau:?}");
                }
            }
        }
    }
}

#[test]
fn a_block_inside_the_ellipse_sticks_and_just_outside_it_slips() {
    for (factor, state) in [(0.999, PointState::Stick), (1.001, PointState::Slip)] {
        // On the ellipse with half axes 0.4 p along y and 0.1 p along x.
        let tau = [0.1 * PRESSURE * f64::cos(0.8) * factor, 0.4 * PRESSURE * f64::sin(0.8) * factor];
        let p = sheared(tau.map(|t| t * 2.0 / (YOUNG / 2.0)), tau, orthotropic(0.4, 0.1, [0.0, 1.0, 0.0]));
        let s = solved(&p, 1e-11);
        assert!(s.states.iter().all(|&s| s == state), "{factor}");
    }
}

#[test]
fn a_block_under_more_than_the_limit_slides_at_the_limit_and_under_less_at_the_coefficient() {
    for (limit, stress) in [(0.2 * PRESSURE, 0.2 * PRESSURE), (0.6 * PRESSURE, 0.4 * PRESSURE)] {
        let tau = [stress, 0.0];
        let p = sheared([1e-5 + stress * 2.0 / (YOUNG / 2.0), 0.0], tau, limited(0.4, limit));
        let s = solved(&p, 1e-11);
        assert!(s.states.iter().all(|&s| s == PointState::Slip));
        for (j, (slip, force)) in in_axes(&p, &s).into_iter().enumerate() {
            assert!(close(slip[0], 1e-5, 1e-7) && close(force[0], stress, 1e-9), "{slip:?} {force:?}");
            assert!(close(s.lambda[j], PRESSURE * p.labels.area[j], 1e-9));
        }
    }
}

fn brick_with(friction: SurfaceFriction, load: BrickLoad) -> ContactProblem {
    brick(4, BlockElement::Hex8, load, friction).pose().problem
}

#[test]
fn friction_that_varies_in_space_is_that_of_two_contacts_with_their_own() {
    let step = Field::Function { text: "step".into(), value: Arc::new(|x, _| if x[0] < 1.6 { 0.1 } else { 0.6 }) };
    let varying = brick_with(
        SurfaceFriction::Law(CoulombLaw { coefficient: step.into(), across: None, limit: None, cohesion: None }),
        BrickLoad::Press,
    );
    let mut two = brick(4, BlockElement::Hex8, BrickLoad::Press, SurfaceFriction::Coulomb(0.1));
    // The nodes of the second contact are those of whole faces: those of the first keep them, as both contacts would.
    let (low, high): (Vec<u32>, Vec<u32>) = two.surfaces[0].faces.iter().partition(|&&face| {
        let nodes = two.mesh.faces[face as usize].nodes();
        nodes.iter().all(|&node| two.mesh.nodes[node as usize][0] < 1.6)
    });
    let middle = two.mesh.face_nodes(&low);
    let mut other = two.surfaces[0].clone();
    (two.surfaces[0].faces, other.faces) = (low, high);
    other.friction = SurfaceFriction::Coulomb(0.6);
    other.name = "other".into();
    two.surfaces.push(other);
    let posed = two.pose();
    // Nodes between the two carry points of both; friction varies from node to node, so the first alone is left.
    let nodes: Vec<u32> = posed.facts.iter().flat_map(|f| f.nodes.clone()).collect();
    let laws: Vec<(u32, Friction)> =
        nodes.iter().copied().zip(posed.problem.contact.friction.iter().copied()).collect();
    let found = brick(4, BlockElement::Hex8, BrickLoad::Press, SurfaceFriction::None).pose();
    for (j, node) in found.facts[0].nodes.iter().enumerate() {
        let owner = laws.iter().find(|(n, _)| n == node).unwrap().1;
        assert_eq!(varying.contact.friction[j], owner);
        assert!(!middle.contains(node) || owner == Friction::Coulomb { coefficient: 0.1 });
    }
    let s = solved(&varying, 1e-10);
    let m = varying.points();
    assert!(s.states.iter().filter(|&&s| s == PointState::Slip).count() > m / 4);
    for j in (0..m).filter(|&j| s.states[j] == PointState::Slip) {
        let Friction::Coulomb { coefficient } = varying.contact.friction[j] else { panic!() };
        assert!((s.lambda[m + j].hypot(s.lambda[2 * m + j]) - coefficient * s.lambda[j]).abs() < 1e-3);
    }
}

#[test]
fn both_paths_agree_up_to_a_ratio_of_ten_and_with_a_limit() {
    let laws = [
        orthotropic(0.5, 0.05, [1.0, 0.3, 0.0]),
        orthotropic(0.05, 0.5, [1.0, 0.0, 0.0]),
        orthotropic(0.3, 0.15, [1.0, 1.0, 0.0]),
        orthotropic(0.4, 0.0, [1.0, 1.0, 0.0]),
        limited(0.5, 3e5),
    ];
    for (law, load) in laws.iter().flat_map(|law| [BrickLoad::Press, BrickLoad::Lift].map(|load| (law, load))) {
        let p = brick(6, BlockElement::Hex8, load, law.clone()).pose().problem;
        let direct = solved(&p, 1e-10);
        assert!(direct.counts.newton_steps <= 25, "{law:?} {load:?}: {:?}", direct.counts);
        if p.contact.orthotropy.as_ref().is_some_and(|across| across.contains(&0.0)) {
            continue; // multigrid goes round in circles and leaves it to the direct path
        }
        let mut multigrid = Multigrid::new(&p).unwrap();
        let cycles = stiction::friction::Settings { max_iterations: 300, ..settings(1e-10) };
        let found = solve_multigrid(&p, &mut multigrid, &cycles, &mut |_| ControlFlow::Continue(()));
        assert_solved(&found);
        assert!(found.counts.cycles <= 50, "{law:?} {load:?}: {:?}", found.counts);
        assert!(distance(&direct.u, &found.u) < 1e-7);
        assert!(distance(&direct.lambda, &found.lambda) < 1e-6);
    }
}

#[test]
fn the_fixed_point_on_discs_finds_the_same() {
    for law in [orthotropic(0.1, 0.4, [1.0, 1.0, 0.0]), limited(0.5, 3e5)] {
        let p = brick(2, BlockElement::Hex8, BrickLoad::Press, law).pose().problem;
        let dual = dual_of(&p, Form::Auto);
        let method = MethodSettings::new(Method::FixedPoint(Given::Discs));
        let answer = solve_with(&p, &dual, &settings(1e-7), &method, &mut |_| ControlFlow::Continue(())).unwrap();
        assert_solved(&answer.solution);
        assert!(distance(&answer.solution.u, &solved(&p, 1e-10).u) < 1e-5);
    }
}

#[test]
fn the_uniqueness_bound_of_an_ellipse_lies_between_those_of_its_discs() {
    // Smaller rows across make a smaller Q: the ellipse with the larger coefficient F is closer to unique than the disc
    // with F, and farther than with the disc of the smaller one.
    let facts = |law: SurfaceFriction| {
        let p = brick(2, BlockElement::Hex8, BrickLoad::Press, law).pose().problem;
        let facts = coulomb_facts(&p, &dual_of(&p, Form::Auto), &solved(&p, 1e-10)).unwrap();
        facts.uniqueness_bound.unwrap() / facts.largest_coefficient
    };
    let [small, ellipse, large] = [
        facts(SurfaceFriction::Coulomb(0.02)),
        facts(orthotropic(0.02, 0.04, [1.0, 0.0, 0.0])),
        facts(SurfaceFriction::Coulomb(0.04)),
    ];
    // Both bounds are estimates from above to some per cent.
    assert!(ellipse <= 1.05 * small && ellipse >= 0.95 * large, "{small} {ellipse} {large}");
}

#[test]
fn the_certificate_refuses_other_laws() {
    let p = brick_with(orthotropic(0.4, 0.1, [0.0, 1.0, 0.0]), BrickLoad::Press);
    let s = solved(&p, 1e-11);
    let m = p.points();
    let judge = |p: &ContactProblem, lambda: &[f64]| certify(p, &s.u, lambda, 1e-7);
    assert!(judge(&p, &s.lambda).passed);
    assert!(s.states.contains(&PointState::Slip));
    // The disc of either coefficient, axes exchanged, an ellipse a little thinner or thicker.
    let with_ratio = |orthotropy: Option<Vec<f64>>| {
        let contact = Contact { orthotropy, ..p.contact.clone() };
        ContactProblem { contact, ..p.clone() }
    };
    let with = |ratios: Vec<f64>| with_ratio(Some(ratios));
    assert!(!judge(&with(vec![1.0; m]), &s.lambda).passed);
    assert!(!judge(&with_ratio(None), &s.lambda).passed);
    for across in [0.2499, 0.2501, 0.0] {
        assert!(!judge(&with(vec![across; m]), &s.lambda).passed, "{across}");
    }
    // Friction parallel to the slip, as in a disc, within the ellipse; and against it.
    let slip = p.contact.B.times(&s.u);
    let (mut parallel, mut against) = (s.lambda.clone(), s.lambda.clone());
    for j in (0..m).filter(|&j| s.states[j] == PointState::Slip) {
        let (a, b) = (slip[m + j], slip[2 * m + j]);
        let size = 0.4 * s.lambda[j] / a.hypot(b / 0.25);
        (parallel[m + j], parallel[2 * m + j]) = (size * a, size * b);
        (against[m + j], against[2 * m + j]) = (-s.lambda[m + j], -s.lambda[2 * m + j]);
    }
    for lambda in [&parallel, &against] {
        let c = judge(&p, lambda);
        let direction = c.measures().into_iter().find(|(name, _)| *name == "slip_direction").unwrap().1;
        assert!(direction > 1e-7 && c.cone < 1e-7, "{:?}", c.measures());
    }
    // A limit that does not hold, and one that is not reached.
    let p = brick_with(limited(0.5, 3e5), BrickLoad::Press);
    let s = solved(&p, 1e-11);
    let with = |factor: f64| {
        let other = |law: &Friction| match *law {
            Friction::Limited { coefficient, limit } => Friction::Limited { coefficient, limit: factor * limit },
            other => other,
        };
        with_friction(&p, p.contact.friction.iter().map(other).collect())
    };
    assert!(certify(&with(1.0), &s.u, &s.lambda, 1e-7).passed);
    let (less, more) = (certify(&with(0.999), &s.u, &s.lambda, 1e-7), certify(&with(1.001), &s.u, &s.lambda, 1e-7));
    assert!(less.cone > 1e-7 && more.slip_direction > 1e-7 && !more.passed, "{less:?} {more:?}");
}
