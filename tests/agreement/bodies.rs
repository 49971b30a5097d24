//! Two bodies in contact, posed by hand (rows of `B` that reach nodes of both) and as a case.

use std::ops::ControlFlow;

use stiction::contact::{ContactProblem, Friction, SurfaceFriction};
use stiction::fem::full_displacement;
use stiction::friction::{Multigrid, Settings, Solution, Status, solve_multigrid};
use stiction::io::case;
use stiction::linalg::{Csr, SymmetricCsr};
use stiction::mesh::BlockElement;
use stiction::run;
use stiction_fixtures::*;

fn triplets(m: &Csr, rows: usize, columns: usize) -> Vec<(usize, usize, f64)> {
    let row = |i: usize| m.row(i).0.iter().zip(m.row(i).1).map(move |(&j, &v)| (rows + i, columns + j as usize, v));
    (0..m.rows).flat_map(row).collect()
}

/// An upper block on a lower one with another mesh: each lower node of the upper block meets the point of the lower
/// block's upper face under it, whose displacement is interpolated bilinearly.
fn stacked(cells: [usize; 2], upper_side: Option<&str>, friction: Friction, shear: f64) -> ContactProblem {
    let [n, m] = cells;
    let element = BlockElement::Hex8;
    let lower = block_of([1.0, 1.0, 0.5], [m, m, m.div_ceil(2)], element, 7e10, 0.3).fix("z-min", HELD);
    let upper = block_of([1.0, 1.0, 0.5], [n, n, n.div_ceil(2)], element, 2.1e11, 0.3)
        .contact("z-min", FLOOR, SurfaceFriction::None)
        .traction_z("z-max", |x| -1e6 * (1.5 - x[0]))
        .traction("z-max", [shear, 0.0, 0.0]);
    let upper = match upper_side {
        Some(side) => upper.fix(side, HELD),
        None => upper,
    };
    let (a, b) = (upper.pose(), lower.pose());
    let shift = a.problem.unknowns();
    let size = shift + b.problem.unknowns();
    let points = a.problem.points();
    let mut rows = triplets(&a.problem.contact.B, 0, 0);
    let unknown_of = |node: usize, c: usize| b.model.dofs.free.iter().position(|&d| d as usize == 3 * node + c);
    let top: Vec<(usize, [f64; 3])> =
        lower.mesh.nodes.iter().copied().enumerate().filter(|(_, x)| x[2] > 0.5 - 1e-9).collect();
    let h = 1.0 / m as f64;
    for j in 0..points {
        let (columns, values) = a.problem.contact.B.row(j);
        let own = columns[values.iter().position(|v| v.abs() > 0.5).unwrap()] as usize;
        let node = a.model.dofs.free[own] as usize / 3;
        let x = upper.mesh.nodes[node];
        for &(v, y) in &top {
            let w = (1.0 - (x[0] - y[0]).abs() / h).max(0.0) * (1.0 - (x[1] - y[1]).abs() / h).max(0.0);
            if w < 1e-12 {
                continue;
            }
            for i in a.problem.rows(j) {
                let (columns, values) = a.problem.contact.B.row(i);
                for (&column, &value) in columns.iter().zip(values) {
                    let c = a.model.dofs.free[column as usize] as usize % 3;
                    rows.push((i, shift + unknown_of(v, c).unwrap(), -w * value));
                }
            }
        }
    }
    let k = [triplets(&a.problem.elastic.K.full(), 0, 0), triplets(&b.problem.elastic.K.full(), shift, shift)].concat();
    let both = |x: &Option<Vec<[f64; 6]>>, y: &Option<Vec<[f64; 6]>>, up: f64| {
        // Rigid motions about one centre: the upper block stands half a unit higher.
        let lifted = x.iter().flatten().zip(&a.model.dofs.free).map(|(r, d)| {
            let mut r = *r;
            match d % 3 {
                0 => r[4] += up,
                1 => r[3] -= up,
                _ => {}
            }
            r
        });
        Some(lifted.chain(y.iter().flatten().copied()).collect::<Vec<_>>())
    };
    let nodes = a.problem.elastic.node_of.iter().flatten().copied();
    let nodes_b = b.problem.elastic.node_of.iter().flatten().map(|v| v + upper.mesh.nodes.len() as u32);
    let mut problem = ContactProblem::from_matrices(
        SymmetricCsr::from_full(&Csr::from_triplets(size, size, &k), "K").unwrap(),
        [a.problem.elastic.f.clone(), b.problem.elastic.f.clone()].concat(),
        Csr::from_triplets(3 * points, size, &rows),
        vec![0.0; points],
        vec![friction; points],
    );
    problem.elastic.node_of = Some(nodes.chain(nodes_b).collect());
    problem.elastic.near_kernel = both(&a.problem.elastic.near_kernel, &b.problem.elastic.near_kernel, 0.5);
    problem.validate().unwrap();
    problem
}

fn by_multigrid(problem: &ContactProblem, tolerance: f64) -> Solution {
    let mut multigrid = Multigrid::new(problem).unwrap();
    let settings = Settings { max_iterations: 1000, ..settings(tolerance) };
    let s = solve_multigrid(problem, &mut multigrid, &settings, &mut |_| ControlFlow::Continue(()));
    println!("{:?} {:?} worst {:.1e}", s.status, s.counts, s.certificate.worst);
    s
}

#[test]
fn two_bodies_with_different_meshes_have_one_solution_on_both_paths() {
    for friction in [Friction::None, Friction::Coulomb { coefficient: 0.3 }, Friction::Bonded] {
        for cells in [[4, 4], [5, 4], [4, 6]] {
            let p = stacked(cells, Some("x-max"), friction, 3e5);
            let (a, b) = (solved(&p, 1e-10), by_multigrid(&p, 1e-10));
            assert_solved(&b);
            assert!(distance(&a.u, &b.u) < 1e-8, "{friction:?} {cells:?}: {:.1e}", distance(&a.u, &b.u));
            assert!(distance(&a.lambda, &b.lambda) < 1e-7, "{:.1e}", distance(&a.lambda, &b.lambda));
        }
    }
}

#[test]
fn contact_between_bodies_costs_hardly_more_cycles_than_a_tie() {
    let [tie, contact] = [Friction::Bonded, Friction::Coulomb { coefficient: 0.3 }].map(|friction| {
        let s = by_multigrid(&stacked([10, 12], Some("x-max"), friction, 3e5), 1e-8);
        assert_solved(&s);
        s.counts.cycles
    });
    assert!(tie <= 25 && contact as f64 <= 2.8 * tie as f64, "{tie} {contact}");
}

#[test]
fn a_body_held_by_contact_alone_needs_no_more_than_one_on_supports() {
    for (friction, shear) in [(0.3, 2e5), (0.5, 3e5), (0.0, 0.0)] {
        let floating = stacked([6, 5], None, Friction::Coulomb { coefficient: friction }, shear);
        let s = by_multigrid(&floating, 1e-8);
        assert_solved(&s);
        let m = floating.points();
        let sum = |range: std::ops::Range<usize>| s.lambda[range].iter().sum::<f64>();
        let tangential = sum(m..2 * m).hypot(sum(2 * m..3 * m));
        println!("{friction}: {} {tangential}", sum(0..m));
        // Balance of the floating body: the pressed top carries 1e6 (1.5 - x) on the unit square.
        assert!((sum(0..m) - 1e6).abs() < 1e-2 && (tangential - shear).abs() < 1e-2);
        // The same at a distance: nothing touches at first.
        let mut lifted = floating.clone();
        lifted.contact.gap.fill(1e-5);
        assert_solved(&by_multigrid(&lifted, 1e-8));
    }
    // Beyond the limit of friction there is no equilibrium, and no answer that claims one.
    let sliding = stacked([6, 5], None, Friction::Coulomb { coefficient: 0.3 }, 4e5);
    assert_ne!(by_multigrid(&sliding, 1e-8).status, stiction::friction::Status::Solved);
}

/// Two blocks with different meshes under uniform pressure; of the surface with the contact points the part `x <= held` is
/// prescribed to move as it does anyway. There the other body carries the points, and the stress remains what it was.
#[test]
fn a_constant_pressure_passes_where_the_slave_is_prescribed_in_part() {
    let strain = 1e-4;
    for (low, high) in [("hex8", "tet4"), ("tet4", "hex8"), ("hex20", "tet10"), ("tet10", "hex20")] {
        // Points on the other body have no nodes of their own, which multigrid needs.
        for (held, friction, path) in [
            (Some(0.5), "\"none\"", "dense"),
            (Some(0.74), "{ coulomb = 0.2 }", "dense"),
            (Some(1.1), "\"none\"", "dense"),
            (Some(0.5), "\"bonded\"", "dense"),
            (None, "\"none\"", "multigrid"),
            (None, "{ coulomb = 0.2 }", "multigrid"),
            (None, "\"bonded\"", "multigrid"),
        ] {
            let fixed = held.map_or(String::new(), |held| {
                let part = format!("{{ box = [[-1, -1, 0.99], [{held}, 2, 1.01]] }}");
                format!("[[fix]]\non = {part}\nvalue = [0, 0, -{strain}]\n")
            });
            let text = format!(
                r#"
[mesh.parts.low]
block = {{ size = [1, 1, 1], cells = [8, 5, 2], element = "{low}" }}
[mesh.parts.high]
block = {{ size = [1, 1, 0.8], cells = [7, 4, 2], element = "{high}" }}
move = [0, 0, 1.1]
[materials.steel]
young = 2e11
poisson = 0
[[fix]]
on = "low.z-min"
{fixed}[[fix]]
on = "high.z-max"
value = [0, 0, -1.8e-4]
[[contact]]
on = "low.z-max"
against = "high.z-min"
gap = "closed"
slave = "on"
friction = {friction}
[solver]
tolerance = 1e-11
path = "{path}"
"#
            );
            let case = case::parse(&text, "case.toml", &[]).unwrap_or_else(|e| panic!("{e}"));
            let prepared = run::prepare(&case).unwrap_or_else(|e| panic!("{e}"));
            let settings = run::Settings::of(&case.solver);
            let outcome = run::solve(&prepared, &settings, &mut |_| ControlFlow::Continue(())).unwrap();
            let label = format!("{low} {high} {held:?} {friction} {path}");
            assert_eq!(outcome.solution.status, Status::Solved, "{label}");
            let u = full_displacement(&prepared.model, &outcome.solution.u);
            for (x, u) in prepared.mesh.nodes.iter().zip(u.chunks(3)) {
                let expected = -strain * if x[2] > 1.05 { x[2] - 0.1 } else { x[2] };
                assert!((u[2] - expected).abs() < 1e-10 * strain, "{label} {x:?} {u:?}");
                assert!(u[0].abs().max(u[1].abs()) < 1e-10 * strain, "{label} {x:?} {u:?}");
            }
            let p = &prepared.problem;
            for (lambda, area) in outcome.solution.lambda.iter().zip(&p.labels.area) {
                assert!((lambda / area / (2e11 * strain) - 1.0).abs() < 1e-8, "{label} {}", lambda / area);
            }
            let whole: f64 = (0..p.points()).map(|j| p.labels.unity_sum[j] * p.labels.area[j]).sum();
            assert!((whole - 1.0).abs() < 1e-9, "{label}: points stand for {whole} of the unit square");
        }
    }
}

/// Middles of edges are relative to the ends, and these to the other body. One block stands on the other, held at its side or
/// by contact alone, or hangs on it. Where it stands beyond the edge of the other but for a hundredth of a face, middles of
/// edges leave their functions to their neighbours. The direct path is the second road.
#[test]
fn quadratic_surfaces_of_two_bodies_have_the_forces_of_the_direct_path_on_multigrid() {
    let held = "[[fix]]\non = \"high.x-max\"\nvalue = [1e-5, 0, 0]\n";
    for (low, high, place) in [
        ("tet10", "tet10", 0.1),
        ("hex20", "hex20", 0.1),
        ("hex20", "tet10", 0.1),
        ("tet10", "hex8", 0.1),
        ("tet4", "tet10", 0.1),
        ("hex8", "tet10", 0.448),
        ("tet10", "hex20", 0.448),
    ] {
        for (friction, support) in [
            ("\"none\"", held),
            ("{ coulomb = 0.3 }", held),
            ("{ coulomb = 0.3 }", ""),
            ("{ tresca = 1e6 }", held),
            ("\"bonded\"", ""),
        ] {
            // Beyond the edge it tips over unless it is held.
            let support = if place > 0.4 { held } else { support };
            let solve = |path: &str| {
                let text = format!(
                    r#"
[mesh.parts.low]
block = {{ size = [1.2, 1, 0.5], cells = [5, 4, 3], element = "{low}" }}
[mesh.parts.high]
block = {{ size = [1, 1, 0.5], cells = [4, 5, 3], element = "{high}" }}
move = [{place}, 0, 0.5]
[materials.steel]
young = 2e11
poisson = 0.3
[[fix]]
on = "low.z-min"
{support}[[load]]
on = "high.z-max"
traction = ["1e6*x", 2e5, "-1e7*(1.2 - x)"]
[[contact]]
on = "high.z-min"
against = "low.z-max"
slave = "on"
friction = {friction}
[solver]
path = "{path}"
tolerance = 1e-9
"#
                );
                let case = case::parse(&text, "case.toml", &[]).unwrap_or_else(|e| panic!("{e}"));
                let prepared = run::prepare(&case).unwrap_or_else(|e| panic!("{e}"));
                let settings = run::Settings::of(&case.solver);
                run::solve(&prepared, &settings, &mut |_| ControlFlow::Continue(())).unwrap().solution
            };
            let (direct, found) = (solve("dense"), solve("multigrid"));
            let label = format!("{low} {high} {place} {friction} {}", !support.is_empty());
            println!("{label}: {:?}", found.counts);
            assert_solved(&direct);
            assert_solved(&found);
            assert!(distance(&direct.u, &found.u) < 1e-7, "{label} {:.1e}", distance(&direct.u, &found.u));
            let apart = distance(&direct.lambda, &found.lambda);
            assert!(apart < 1e-7, "{label} {apart:.1e}");
            assert!(found.counts.cycles <= 45, "{label} {:?}", found.counts);
        }
    }
}
