//! Work in bands: Newton steps counted, never timed. Bands follow a prototype that shares no code with this one.

use stiction::contact::SurfaceFriction;
use stiction::friction::{Settings, Status};
use stiction::mesh::BlockElement;
use stiction_fixtures::*;

fn assert_steps(load: BrickLoad, friction: SurfaceFriction, most: usize) {
    for n in [4, 8] {
        let p = brick(n, BlockElement::Tet4Six, load, friction.clone()).pose().problem;
        let s = attempt(&p, &settings(1e-8));
        println!("{load:?} {friction:?} n = {n}: {:?} {:?} worst {:.1e}", s.status, s.counts, s.certificate.worst);
        assert_solved(&s);
        assert!(s.counts.newton_steps <= most, "{load:?} {friction:?} n = {n}: {:?}", s.counts);
    }
}

#[test]
fn the_source_papers_load_takes_twelve_newton_steps_at_most() {
    for coefficient in [0.0, 0.1, 0.35, 1.0, 3.0] {
        assert_steps(BrickLoad::Lift, SurfaceFriction::Coulomb(coefficient), 12);
    }
}

#[test]
fn given_friction_under_the_source_papers_load_takes_few_steps() {
    for bound in [1.3e3, 1.3e4] {
        assert_steps(BrickLoad::Lift, SurfaceFriction::GivenForce(bound), 12);
    }
}

#[test]
fn a_restart_from_the_solution_takes_no_more_than_a_step_or_two() {
    for load in [BrickLoad::Lift, BrickLoad::Press] {
        for friction in [SurfaceFriction::Coulomb(0.35), SurfaceFriction::GivenStress(1e5)] {
            let p = brick(8, BlockElement::Tet4Six, load, friction).pose().problem;
            let first = solved(&p, 1e-8);
            let again = attempt(&p, &Settings { start: Some(first.lambda.clone()), ..settings(1e-8) });
            assert_solved(&again);
            assert!(again.counts.newton_steps <= 2, "{:?}", again.counts);
        }
    }
}

#[test]
fn a_solve_that_was_cut_short_says_so() {
    let p = brick(4, BlockElement::Tet4Six, BrickLoad::Press, SurfaceFriction::Coulomb(0.35)).pose().problem;
    for max_iterations in [0, 1, 2] {
        let s = attempt(&p, &Settings { max_iterations, ..settings(1e-8) });
        assert_eq!(s.status, Status::MaxIterations);
        assert!(!s.certificate.passed && s.counts.newton_steps <= max_iterations);
    }
    let stop = &mut |_: &stiction::friction::Progress| std::ops::ControlFlow::Break(());
    let s = stiction::friction::solve(&p, &dual_of(&p, stiction::dual::Form::Auto), &settings(1e-8), stop);
    assert_eq!(s.status, Status::Interrupted);
    assert!(!s.certificate.passed);
}

#[test]
fn newton_ends_quadratically() {
    // Near the end one step gains four digits or more; asked for more than the certificate needs, so that such a step
    // is not cut short. The very last may start at the rounding level.
    let p = brick(8, BlockElement::Tet4Six, BrickLoad::Lift, SurfaceFriction::Coulomb(0.35)).pose().problem;
    let s = solved(&p, 1e-11);
    let residuals: Vec<f64> = s.history.iter().map(|p| p.residual).collect();
    assert!(residuals.windows(2).any(|w| w[0] < 1e-2 && w[1] < 1e-4 * w[0]), "{residuals:?}");
}

// What the tuning of the globalisation is measured by.

#[test]
fn the_pressed_brick_takes_fifteen_newton_steps_at_most() {
    for coefficient in [0.35, 1.0] {
        assert_steps(BrickLoad::Press, SurfaceFriction::Coulomb(coefficient), 15);
    }
}

#[test]
fn given_friction_ten_times_the_source_papers_takes_fifteen_newton_steps_at_most() {
    assert_steps(BrickLoad::Lift, SurfaceFriction::GivenForce(5.25e5), 15);
    assert_steps(BrickLoad::Lift, SurfaceFriction::GivenStress(3e6), 15);
    assert_steps(BrickLoad::Press, SurfaceFriction::GivenStress(3e6), 15);
}

#[test]
fn a_coefficient_of_ten_is_no_harder_than_any_other() {
    assert_steps(BrickLoad::Lift, SurfaceFriction::Coulomb(10.0), 12);
}
