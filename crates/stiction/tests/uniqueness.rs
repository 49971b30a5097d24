//! The uniqueness bound and the contraction of `g -> F lambda_n(g)` by dense second roads and a prototype's values.

mod common;

use common::*;
use stiction::contact::{ContactProblem, Friction, SurfaceFriction};
use stiction::dual::Form;
use stiction::friction::{CoulombFacts, coulomb_facts, solve};
use stiction::linalg::norm;
use stiction::mesh::BlockElement;

const FIVE: BlockElement = BlockElement::Tet4Five { parity: 0 };

fn facts(p: &ContactProblem, form: Form) -> CoulombFacts {
    let dual = dual_of(p, form);
    let s = solve(p, &dual, &settings(1e-9), &mut |_| std::ops::ControlFlow::Continue(()));
    assert_solved(&s);
    coulomb_facts(p, &dual, &s).unwrap()
}

/// `1 / sqrt(lmax(Q_tt) lmax((Q⁻¹)_nn))` from dense matrices.
fn exact_bound(p: &ContactProblem) -> f64 {
    let m = p.points();
    let (q, _) = dense::dual_data(p, &dense::Factor::new(&p.K));
    let tangential = dense::largest_eigenvalue(&dense::block(&q, m..3 * m));
    let normal = dense::largest_eigenvalue(&dense::block(&dense::inverse(&q), 0..m));
    1.0 / (tangential * normal).sqrt()
}

#[test]
fn the_uniqueness_bound_is_a_lower_bound_and_near_the_exact_one() {
    for (n, element, load) in [
        (2, FIVE, BrickLoad::Lift),
        (4, FIVE, BrickLoad::Lift),
        (4, BlockElement::Tet4Six, BrickLoad::Press),
        (4, BlockElement::Hex8, BrickLoad::Press),
    ] {
        let p = brick(n, element, load, SurfaceFriction::Coulomb(0.02)).pose().problem;
        let exact = exact_bound(&p);
        let dense = facts(&p, Form::Dense).uniqueness_bound.unwrap();
        let solves = facts(&p, Form::Solves).uniqueness_bound.unwrap();
        println!("{element:?} n = {n}: exact {exact:.5} dense {dense:.5} solves {solves:.5}");
        assert!(dense <= exact && dense >= 0.9 * exact);
        assert!(solves <= exact && solves > 0.0);
    }
}

#[test]
fn the_uniqueness_bound_of_the_model_brick_is_the_prototypes() {
    for (n, published) in [(2, 0.0463), (4, 0.0310), (8, 0.0222)] {
        let p = brick(n, FIVE, BrickLoad::Lift, SurfaceFriction::Coulomb(0.35)).pose().problem;
        let found = facts(&p, Form::Dense);
        let bound = found.uniqueness_bound.unwrap();
        println!("n = {n}: {bound:.5} for {published}");
        assert!(bound <= published * 1.002 && bound >= 0.9 * published, "n = {n}: {bound} {published}");
        assert!(!found.proved_unique() && found.largest_coefficient == 0.35);
    }
    for (n, published) in [(2, 0.0463), (4, 0.0310)] {
        let p = brick(n, FIVE, BrickLoad::Lift, SurfaceFriction::Coulomb(0.35)).pose().problem;
        assert!(close(exact_bound(&p), published, 2e-3), "n = {n}: {} {published}", exact_bound(&p));
    }
}

#[test]
fn the_contraction_on_the_model_brick_is_the_prototypes() {
    for (n, published) in [(2, 0.085), (4, 0.111), (8, 0.120)] {
        let p = brick(n, FIVE, BrickLoad::Lift, SurfaceFriction::Coulomb(0.35)).pose().problem;
        let q = facts(&p, Form::Auto).contraction;
        println!("n = {n}: {q:.4} for {published}");
        assert!(close(q, published, 0.05), "n = {n}: {q} {published}");
    }
}

#[test]
fn the_contraction_is_the_ratio_of_successive_steps_of_the_fixed_point() {
    for (load, coefficient) in [(BrickLoad::Lift, 0.35), (BrickLoad::Lift, 1.0), (BrickLoad::Press, 0.35)] {
        let p = brick(4, BlockElement::Tet4Six, load, SurfaceFriction::Coulomb(coefficient)).pose().problem;
        let dual = dual_of(&p, Form::Auto);
        let coulomb = solve(&p, &dual, &settings(1e-11), &mut |_| std::ops::ControlFlow::Continue(()));
        assert_solved(&coulomb);
        let predicted = coulomb_facts(&p, &dual, &coulomb).unwrap().contraction;
        let m = p.points();
        let mut g: Vec<f64> = coulomb.lambda[..m].iter().map(|l| 1.05 * coefficient * l).collect();
        let (mut step, mut ratio) = (f64::NAN, f64::NAN);
        for _ in 0..7 {
            let friction = g.iter().map(|&slip_bound| Friction::Given { slip_bound }).collect();
            let s = solved(&ContactProblem { friction, ..p.clone() }, 1e-11);
            let next: Vec<f64> = s.lambda[..m].iter().map(|l| coefficient * l).collect();
            let moved = norm(&next.iter().zip(&g).map(|(a, b)| a - b).collect::<Vec<_>>());
            if moved < 1e-7 * norm(&g) {
                break; // the rest is rounding
            }
            (ratio, step, g) = (moved / step, moved, next);
        }
        println!("{load:?} {coefficient}: predicted {predicted:.4} observed {ratio:.4}");
        assert!(close(predicted, ratio, 0.1), "{load:?} {coefficient}: {predicted} {ratio}");
    }
}

#[test]
fn below_the_bound_every_start_leads_to_the_same_solution() {
    let p = brick(4, FIVE, BrickLoad::Press, SurfaceFriction::Coulomb(0.025)).pose().problem;
    let found = facts(&p, Form::Dense);
    assert!(found.proved_unique() && found.contraction < 1.0, "{found:?}");
    let first = solved(&p, 1e-11);
    for seed in [1.0, 2.0, 3.0] {
        let start = (0..3 * p.points()).map(|i| 1e5 * (seed * (i as f64 + 0.5)).sin()).collect();
        let settings = stiction::friction::Settings { start: Some(start), ..settings(1e-11) };
        let s = attempt(&p, &settings);
        assert_solved(&s);
        assert!(distance(&s.lambda, &first.lambda) < 1e-8);
    }
}

#[test]
fn nothing_is_said_where_no_friction_is_coulombs() {
    let p = brick(2, FIVE, BrickLoad::Press, SurfaceFriction::GivenStress(1e5)).pose().problem;
    let dual = dual_of(&p, Form::Auto);
    let s = solved(&p, 1e-8);
    assert_eq!(coulomb_facts(&p, &dual, &s), None);
}
