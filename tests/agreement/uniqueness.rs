//! The uniqueness bound and the contraction of `g -> F lambda_n(g)` by dense second roads and a prototype's values.

use stiction::contact::{ContactProblem, Friction, SurfaceFriction};
use stiction::dual::Form;
use stiction::friction::{CoulombFacts, Multigrid, coulomb_facts, coulomb_facts_by_multigrid, solve, solve_multigrid};
use stiction::linalg::norm;
use stiction::mesh::BlockElement;
use stiction::{Csr, Kept, Settings, Solution, Start, Status, SymmetricCsr, solve_from_starts};
use stiction_fixtures::*;

const FIVE: BlockElement = BlockElement::Tet4Five { parity: 0 };

fn facts(p: &ContactProblem, form: Form) -> CoulombFacts {
    let dual = dual_of(p, form);
    let s = solve(p, &dual, &settings(1e-9), &mut |_| std::ops::ControlFlow::Continue(()));
    assert_solved(&s);
    coulomb_facts(p, &dual, &s).unwrap()
}

fn facts_by_multigrid(p: &ContactProblem) -> CoulombFacts {
    let mut multigrid = Multigrid::new(p).unwrap();
    let settings = Settings { max_iterations: 400, ..settings(1e-9) };
    let s = solve_multigrid(p, &mut multigrid, &settings, &mut |_| std::ops::ControlFlow::Continue(()));
    assert_solved(&s);
    coulomb_facts_by_multigrid(p, &mut multigrid, &s).unwrap()
}

/// `1 / sqrt(lmax(Q_tt) lmax((Q⁻¹)_nn))` from dense matrices.
fn exact_bound(p: &ContactProblem) -> f64 {
    let m = p.points();
    let (q, _) = dense::dual_data(p, &dense::Factor::new(&p.elastic.K));
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
        let by_solves = facts(&p, Form::Solves);
        let solves = by_solves.uniqueness_bound.unwrap();
        let multigrid = facts_by_multigrid(&p);
        println!("{element:?} n = {n}: exact {exact:.5} dense {dense:.5} {by_solves:?} {multigrid:?}");
        // The same bound of the inverse as that by solves.
        let by_multigrid = multigrid.uniqueness_bound.unwrap();
        assert!(by_multigrid <= exact && close(by_multigrid, solves, 0.05), "{by_multigrid} {solves} {exact}");
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
        let by_multigrid = facts_by_multigrid(&p);
        println!("n = {n}: {q:.4} and {by_multigrid:?} for {published}");
        assert!(close(by_multigrid.contraction, q, 0.02), "{by_multigrid:?} {q}");
        assert!(close(q, published, 0.05), "n = {n}: {q} {published}");
    }
}

/// Spectral radius of the Jacobian of `g -> F lambda_n(g)` at a solution, by differences of solves with given friction.
fn differenced_contraction(p: &ContactProblem, coefficient: f64) -> f64 {
    let m = p.points();
    let coulomb = solved(p, 1e-12);
    let g: Vec<f64> = coulomb.lambda[..m].iter().map(|l| coefficient * l).collect();
    let map = |g: &[f64]| -> Vec<f64> {
        let friction = g.iter().map(|&slip_bound| Friction::Given { slip_bound }).collect();
        let s = solved(&with_friction(p, friction), 1e-11);
        s.lambda[..m].iter().map(|l| coefficient * l).collect()
    };
    let size = 1e-4 * norm(&g);
    // Only points in contact: elsewhere the bound does not matter to the normal forces.
    let loaded: Vec<usize> = (0..m).filter(|&j| g[j] > 0.0).collect();
    let column = |j: usize| {
        let (mut more, mut less) = (g.clone(), g.clone());
        let step = size.min(0.1 * g[j]);
        (more[j], less[j]) = (g[j] + step, g[j] - step);
        let (a, b) = (map(&more), map(&less));
        loaded.iter().map(|&i| (a[i] - b[i]) / (2.0 * step)).collect::<Vec<f64>>()
    };
    let columns: Vec<Vec<f64>> = loaded.iter().map(|&j| column(j)).collect();
    // Gelfand: |J^k x|^(1/k), over the second half of many steps.
    let n = loaded.len();
    let mut x: Vec<f64> = (0..n).map(|i| 1.0 + 0.3 * (i as f64).sin()).collect();
    let mut logarithm = 0.0;
    for k in 0..400 {
        let mut y = vec![0.0; n];
        columns.iter().zip(&x).for_each(|(c, x)| y.iter_mut().zip(c).for_each(|(y, c)| *y += c * x));
        let growth = norm(&y);
        logarithm += if k < 200 { 0.0 } else { growth.ln() };
        x = y.iter().map(|v| v / growth).collect();
    }
    f64::exp(logarithm / 200.0)
}

#[test]
fn the_contraction_is_that_of_the_differenced_fixed_point_map() {
    let mut wrong = Vec::new();
    for (n, load, coefficient) in [
        (2, BrickLoad::Lift, 0.35),
        (4, BrickLoad::Lift, 0.35),
        (4, BrickLoad::Lift, 1.0),
        (4, BrickLoad::Press, 0.35),
        (4, BrickLoad::Press, 0.02),
    ] {
        let p = brick(n, BlockElement::Tet4Six, load, SurfaceFriction::Coulomb(coefficient)).pose().problem;
        let predicted = facts(&p, Form::Auto).contraction;
        let observed = differenced_contraction(&p, coefficient);
        let by_multigrid = facts_by_multigrid(&p);
        println!("n = {n} {load:?} {coefficient}: predicted {predicted:.4} differenced {observed:.4} {by_multigrid:?}");
        if !close(predicted, observed, 0.1) || !close(by_multigrid.contraction, observed, 0.1) {
            wrong.push((n, load, coefficient, predicted, observed));
        }
    }
    assert!(wrong.is_empty(), "{wrong:?}");
}

#[test]
fn below_the_bound_every_start_leads_to_the_same_solution() {
    let p = brick(4, FIVE, BrickLoad::Press, SurfaceFriction::Coulomb(0.025)).pose().problem;
    let found = facts(&p, Form::Dense);
    assert!(found.proved_unique() && found.contraction < 1.0, "{found:?}");
    let first = solved(&p, 1e-11);
    for seed in [1.0, 2.0, 3.0] {
        let start = (0..3 * p.points()).map(|i| 1e5 * (seed * (i as f64 + 0.5)).sin()).collect();
        let settings = Settings { start: Some(start), ..settings(1e-11) };
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

/// A node on springs that couple its two directions (Klarbring, Ing. Arch. 60, 1990, 529-541): `k_tn` draws it off the ground
/// as it slips. `load` is `[along, towards the ground]`.
fn coupled_springs([k_tt, k_tn, k_nn]: [f64; 3], load: [f64; 2], coefficient: f64) -> ContactProblem {
    let k = [(0, 0, k_tt), (0, 2, k_tn), (2, 0, k_tn), (2, 2, k_nn), (1, 1, 1.0)];
    let k = SymmetricCsr::from_full(&Csr::from_triplets(3, 3, &k), "K").unwrap();
    let b = Csr::from_triplets(3, 3, &[(0, 2, 1.0), (1, 0, 1.0), (2, 1, 1.0)]);
    let friction = vec![Friction::Coulomb { coefficient }];
    ContactProblem::from_matrices(k, vec![load[0], 0.0, load[1]], b, vec![0.0], friction)
}

fn solutions(p: &ContactProblem, starts: usize) -> Vec<Solution> {
    let mut kept = Kept::default();
    let go_on = &mut |_: &stiction::SolveEvent| std::ops::ControlFlow::Continue(());
    let settings = Settings { tolerance: 1e-12, ..Settings::default() };
    let first = stiction::solve_with_kept(p, &settings, &mut kept, go_on).unwrap();
    let found = solve_from_starts(p, &settings, &first, starts, &mut kept, go_on);
    assert!(found.ended.is_none() && found.attempts.len() == starts && found.attempts[0].start == Start::Default);
    assert!(found.distinct.iter().all(|s| s.status == Status::Solved));
    found.distinct
}

#[test]
fn all_solutions_of_the_node_on_coupled_springs_are_found() {
    // Stick: lambda = load. Slip along the load: u = (f_t - F f_n) / (k_tt - F k_tn), lambda_n = f_n - k_tn u. Open: K u = f.
    let (k, coefficient) = ([1.0, 1.0, 2.0], 2.0);
    let p = coupled_springs(k, [1.8, 1.0], coefficient);
    let slip = (1.8 - coefficient) / (k[0] - coefficient * k[1]);
    let mut wanted = vec![vec![1.0, 1.8, 0.0], vec![1.0 - slip, coefficient * (1.0 - slip), 0.0], vec![0.0; 3]];
    let mut found: Vec<Vec<f64>> = solutions(&p, 10).into_iter().map(|s| s.lambda).collect();
    let order = |a: &Vec<f64>, b: &Vec<f64>| a[0].total_cmp(&b[0]);
    wanted.sort_by(order);
    found.sort_by(order);
    assert_eq!(found.len(), 3, "{found:?}");
    for (found, wanted) in found.iter().zip(&wanted) {
        assert!(distance(found, wanted) < 1e-10, "{found:?} {wanted:?}");
    }
    // Less friction than k_tt / k_tn: one solution, whatever the start.
    assert_eq!(solutions(&coupled_springs(k, [1.8, 1.0], 0.9), 10).len(), 1);
}
