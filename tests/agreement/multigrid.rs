//! The multigrid path against the direct one, and its cycles in bands. Bands follow a prototype that shares no code
//! with this one.

use std::ops::ControlFlow;

use stiction::contact::{ContactProblem, Friction, Labels, Obstacle, SurfaceFriction};
use stiction::dual::{DualSettings, Form, choose, estimate};
use stiction::fem::{Formulation, Material, Solid, assemble};
use stiction::friction::{Multigrid, PointState, Settings, Solution, SolverPath, Status, solve_multigrid};
use stiction::linalg::Csr;
use stiction::mesh::{Block, BlockElement, block};
use stiction_fixtures::*;

fn by_multigrid(problem: &ContactProblem, tolerance: f64) -> Solution {
    let mut multigrid = Multigrid::new(problem).unwrap();
    let settings = Settings { max_iterations: 1000, ..settings(tolerance) };
    solve_multigrid(problem, &mut multigrid, &settings, &mut |_| ControlFlow::Continue(()))
}

fn assert_cycles(problem: &ContactProblem, most: usize, what: &str) -> usize {
    let s = by_multigrid(problem, 1e-8);
    println!("{what}: {:?} {:?} worst {:.1e}", s.status, s.counts, s.certificate.worst);
    assert_solved(&s);
    assert!(s.counts.cycles <= most, "{what}: {:?}", s.counts);
    s.counts.cycles
}

/// The clamped brick without contact.
fn elastic(n: usize, element: BlockElement, poisson: f64) -> ContactProblem {
    let mut case = brick(n, element, BrickLoad::Press, SurfaceFriction::None);
    case.surfaces.clear();
    case.poisson = poisson;
    case.pose().problem
}

/// Cycles until the residual has fallen by eight digits.
fn cycles_to_eight_digits(problem: &ContactProblem, what: &str) -> usize {
    let s = by_multigrid(problem, 1e-8);
    assert_solved(&s);
    let cycles = s.history.iter().find(|p| p.residual <= 1e-8).unwrap().iteration;
    println!("{what}: {cycles}");
    cycles
}

/// Quadratic elements begin with the linear space on their corners: at most 1.4 times the cycles of the linear mesh with the
/// same corners, and 1.5 times with wedges, of which the linear ones take the fewest cycles of all. With contact, and no coarser block to start from, they take up to twice the cycles of a linear solve.
#[test]
fn quadratic_elements_take_the_cycles_of_linear_ones() {
    for (element, linear, ratio) in [
        (BlockElement::Tet10Six, BlockElement::Tet4Six, 1.4),
        (BlockElement::Hex20, BlockElement::Hex8, 1.4),
        (BlockElement::Wedge15, BlockElement::Wedge6, 1.5),
    ] {
        for n in [5, 8] {
            let what = format!("{element:?} n = {n}");
            let least = cycles_to_eight_digits(&elastic(n, linear, 0.3), "linear").max(14);
            let most = (ratio * least as f64) as usize;
            assert!(cycles_to_eight_digits(&elastic(n, element, 0.3), &what) <= most, "{what} {most}");
            for (law, load) in [
                (SurfaceFriction::None, BrickLoad::Lift),
                (SurfaceFriction::Coulomb(0.35), BrickLoad::Lift),
                (SurfaceFriction::Coulomb(0.35), BrickLoad::Press),
            ] {
                let problem = brick(n, element, load, law.clone()).pose().problem;
                assert_cycles(&problem, 28, &format!("{what} {load:?} {law:?}"));
            }
        }
    }
}

/// Without the edges' ends multigrid aggregates all nodes alike and finds the same answer, in more cycles.
#[test]
fn the_linear_space_changes_the_cycles_and_not_the_answer() {
    let with = brick(4, BlockElement::Hex20, BrickLoad::Press, SurfaceFriction::Coulomb(0.35)).pose().problem;
    let mut without = with.clone();
    without.elastic.middles = None;
    let (with, without) = (by_multigrid(&with, 1e-9), by_multigrid(&without, 1e-9));
    assert_solved(&with);
    assert_solved(&without);
    assert!(with.counts.cycles + 8 < without.counts.cycles, "{:?} {:?}", with.counts, without.counts);
    assert!(distance(&with.lambda, &without.lambda) < 1e-7);
}

#[test]
fn a_linear_solve_takes_thirty_cycles_at_most_at_every_size() {
    let elements = [BlockElement::Tet4Five { parity: 0 }, BlockElement::Tet4Six, BlockElement::Hex8];
    for element in elements {
        for poisson in [0.0, 0.277, 0.45] {
            for n in [4, 8, 16] {
                let what = format!("{element:?} nu {poisson} n = {n}");
                assert!(cycles_to_eight_digits(&elastic(n, element, poisson), &what) <= 30, "{what}");
            }
        }
    }
}

#[test]
fn materials_with_a_contrast_of_ten_thousand_take_thirty_cycles_at_most() {
    for element in [BlockElement::Tet4Six, BlockElement::Hex8] {
        let mut case = brick(8, element, BrickLoad::Press, SurfaceFriction::None);
        case.surfaces.clear();
        let problem = layered(&case, 0.3, 1e4);
        assert!(cycles_to_eight_digits(&problem, &format!("{element:?}")) <= 30);
    }
}

/// The clamped brick with cells of any shape: how many, and the length of the last over that of the first.
type Shape = ([usize; 3], [f64; 3]);

/// Twenty times as long along x as across.
const LONG: Shape = ([4, 26, 26], [1.0; 3]);
/// Twenty times as flat along z.
const FLAT: Shape = ([12, 4, 80], [1.0; 3]);
/// Graded along all axes: from 20 times as long to 20 times as flat.
const GRADED: Shape = ([20, 14, 14], [20.0, 20.0, 0.05]);

fn stretched((cells, grading): Shape, element: BlockElement) -> Case {
    let mut case = brick(1, element, BrickLoad::Press, SurfaceFriction::None);
    case.mesh = block(&Block { size: [3.0, 1.0, 1.0], cells, origin: [0.0; 3], grading, element }).unwrap();
    (case.loads, case.fixes, case.surfaces) = Default::default();
    case.fix("x-min", HELD).traction("x-max", [1e6, 5e5, 0.0]).traction("z-max", [0.0, 0.0, -1e6])
}

/// Four layers along z, every other one softer.
fn layered(case: &Case, poisson: f64, contrast: f64) -> ContactProblem {
    let material = |young: f64| Material {
        name: "layer".into(),
        young,
        poisson,
        density: 0.0,
        formulation: Formulation::Full,
        ..Material::default()
    };
    let materials = [material(2e11), material(2e11 / contrast)];
    let cells = case.mesh.cell_count();
    let material_of_cell: Vec<u32> = (0..cells).map(|c| u32::from(c * 4 / cells % 2 == 1)).collect();
    let solid = Solid { mesh: &case.mesh, materials: &materials, material_of_cell: &material_of_cell };
    let mut model = assemble(&solid, &case.loads, &case.fixes, 1.0).unwrap();
    stiction::contact::pose(&case.mesh, &mut model, &[]).unwrap().0
}

#[test]
fn stretched_cells_take_thirty_cycles_at_most() {
    for (element, shapes) in [
        (BlockElement::Hex8, [LONG, FLAT, GRADED].as_slice()),
        (BlockElement::Tet4Six, &[LONG, FLAT, GRADED]),
        (BlockElement::Tet4Five { parity: 0 }, &[LONG]),
    ] {
        for &shape in shapes {
            for (poisson, contrast) in [(0.277, 1.0), (0.45, 1.0), (0.3, 1e4)] {
                let what = format!("{element:?} {shape:?} nu {poisson} contrast {contrast:e}");
                let problem = layered(&stretched(shape, element), poisson, contrast);
                assert!(cycles_to_eight_digits(&problem, &what) <= 30, "{what}");
            }
        }
    }
}

/// The central tetrahedron of a flat cell resists the mixed second difference across with its short side: what
/// oscillates along one long side alone stays soft, and neither sweeps by nodes nor aggregates along the short side
/// take care of both. These meshes lock as well.
#[test]
fn five_flat_tetrahedra_a_cell_take_more_cycles_and_end() {
    for (shape, most) in [(FLAT, 70), (GRADED, 35)] {
        let problem = layered(&stretched(shape, BlockElement::Tet4Five { parity: 0 }), 0.277, 1.0);
        assert!(cycles_to_eight_digits(&problem, &format!("{shape:?}")) <= most);
    }
}

#[test]
fn contact_on_stretched_cells_has_the_solution_of_the_direct_path() {
    for cells in [[2, 13, 13], [6, 2, 40]] {
        let case = stretched((cells, [1.0; 3]), BlockElement::Hex8);
        let p = case.contact("z-min", FLOOR, SurfaceFriction::Coulomb(0.35)).pose().problem;
        let (a, b) = (solved(&p, 1e-10), by_multigrid(&p, 1e-10));
        println!("{cells:?}: {:?}", b.counts);
        assert_solved(&b);
        assert!(b.counts.cycles <= 45, "{:?}", b.counts);
        assert!(distance(&a.u, &b.u) < 1e-8 && distance(&a.lambda, &b.lambda) < 1e-7);
    }
}

const LAWS: [SurfaceFriction; 7] = [
    SurfaceFriction::None,
    SurfaceFriction::Coulomb(0.1),
    SurfaceFriction::Coulomb(0.35),
    SurfaceFriction::Coulomb(1.0),
    SurfaceFriction::GivenForce(1.3e4),
    SurfaceFriction::GivenStress(3e6),
    SurfaceFriction::Bonded,
];

#[test]
fn both_paths_find_the_same_solution() {
    use BlockElement::{Hex8, Hex20, Tet4Six, Tet10Six};
    for (element, n) in [(Tet4Six, 5), (Hex8, 5), (Tet10Six, 2), (Hex20, 3)] {
        for load in [BrickLoad::Lift, BrickLoad::Press] {
            for law in LAWS {
                let p = brick(n, element, load, law.clone()).pose().problem;
                let (a, b) = (solved(&p, 1e-10), by_multigrid(&p, 1e-10));
                println!("{element:?} {load:?} {law:?}: {:?}", b.counts);
                assert_solved(&b);
                assert!(distance(&a.u, &b.u) < 1e-8, "{load:?} {law:?}: {:.1e}", distance(&a.u, &b.u));
                assert!(distance(&a.lambda, &b.lambda) < 1e-7, "{:.1e}", distance(&a.lambda, &b.lambda));
                if law == SurfaceFriction::Bonded {
                    continue; // Bonded points stick under tension too.
                }
                // Open is what bears no pressure, also where friction is given and acts without one.
                let largest = a.lambda[..p.points()].iter().copied().fold(0.0, f64::max);
                for solution in [&a, &b] {
                    for (state, normal) in solution.states.iter().zip(&solution.lambda) {
                        assert!(*state != PointState::Open || *normal < 1e-6 * largest, "{state:?} {normal:e}");
                        assert!(*state == PointState::Open || *normal > 0.0, "{state:?} {normal:e}");
                    }
                }
            }
        }
    }
}

#[test]
fn contact_costs_little_more_cycles_than_a_linear_solve_and_no_more_on_finer_meshes() {
    let linear = [8, 16, 20, 28].map(|n| by_multigrid(&elastic(n, BlockElement::Tet4Six, 0.277), 1e-8).counts.cycles);
    // The coarsest of these meshes have no second coarse level to start from.
    for (load, coefficient, most) in [
        (BrickLoad::Press, 0.35, [1.35, 1.25]),
        (BrickLoad::Press, 1.0, [1.5, 1.4]),
        (BrickLoad::Lift, 0.35, [1.6, 1.1]),
        (BrickLoad::Lift, 0.0, [1.5, 1.1]),
    ] {
        for (sizes, most) in
            [[(8, linear[0]), (16, linear[1])], [(20, linear[2]), (28, linear[3])]].into_iter().zip(most)
        {
            let counts = sizes.map(|(n, linear)| {
                let p = brick(n, BlockElement::Tet4Six, load, SurfaceFriction::Coulomb(coefficient)).pose().problem;
                let what = format!("{load:?} {coefficient} n = {n}, linear {linear}");
                assert_cycles(&p, (most * linear as f64) as usize, &what)
            });
            assert!(counts[1] as f64 <= 1.1 * counts[0] as f64, "{counts:?}");
        }
    }
}

/// What is asked for and no more: each digit beyond costs two cycles.
#[test]
fn cycles_end_where_the_certificate_passes() {
    for (load, tolerance) in [(BrickLoad::Press, 1e-3), (BrickLoad::Press, 1e-8), (BrickLoad::Lift, 1e-6)] {
        let p = brick(8, BlockElement::Hex8, load, SurfaceFriction::Coulomb(0.35)).pose().problem;
        let s = by_multigrid(&p, tolerance);
        assert_solved(&s);
        let within = s.history.iter().filter(|progress| progress.residual <= tolerance).count();
        assert!(within == 1 && s.certificate.worst > 1e-3 * tolerance, "{load:?} {tolerance}: {within} {:?}", s.counts);
    }
}

/// From here on there are levels below the first coarse one, which know nothing of held components by themselves. A body
/// held at more points is stiffer, so that alone is no reason for more cycles.
#[test]
fn a_face_in_contact_does_not_slow_the_coarse_levels() {
    let on_floor = |law| brick(28, BlockElement::Tet4Six, BrickLoad::Press, law).pose().problem;
    let linear = by_multigrid(&elastic(28, BlockElement::Tet4Six, 0.277), 1e-8).counts.cycles;
    assert_cycles(&on_floor(SurfaceFriction::Bonded), linear, &format!("bonded, linear {linear}"));
    let most = (1.35 * linear as f64) as usize;
    assert_cycles(&on_floor(SurfaceFriction::Coulomb(0.35)), most, &format!("Coulomb, linear {linear}"));
}

/// A body carried along by its supports away from the obstacle is free of forces: nothing but rounding is left of them.
#[test]
fn a_body_that_moves_away_as_a_whole_is_certified() {
    let away = [Some(1.6e-4), Some(1.1e-5), Some(2.2e-4)];
    let case = block_of([0.1, 0.03, 0.03], [7, 2, 5], BlockElement::Tet4Six, 5.5e7, 0.45).fix("z-max", away);
    let floor = stiction::contact::Obstacle::Plane { point: [0.0; 3], normal: [0.0, 0.0, 1.0] };
    let problem = case.contact("z-min", floor, SurfaceFriction::Coulomb(2.0)).pose().problem;
    let s = by_multigrid(&problem, 1e-8);
    assert_solved(&s);
    assert!(s.lambda.iter().all(|&x| x == 0.0));
    let largest = s.u.iter().fold(0.0, |a: f64, u| a.max(u.abs()));
    assert!((largest - 2.2e-4).abs() < 1e-12, "{largest}");
}

#[test]
fn large_coefficients_converge() {
    for load in [BrickLoad::Lift, BrickLoad::Press] {
        for coefficient in [2.0, 5.0, 10.0, 100.0] {
            let p = brick(8, BlockElement::Tet4Six, load, SurfaceFriction::Coulomb(coefficient)).pose().problem;
            assert_cycles(&p, 150, &format!("{load:?} {coefficient}"));
        }
    }
}

#[test]
fn the_estimate_of_the_direct_path_is_of_the_size_of_the_symbolic_counts() {
    for (size, cells) in [
        ([3.0, 1.0, 1.0], [30, 10, 10]),
        ([1.0, 1.0, 1.0], [12, 12, 12]),
        ([1.0, 1.0, 0.05], [60, 60, 3]),
        ([10.0, 1.0, 1.0], [80, 8, 8]),
    ] {
        for element in [BlockElement::Tet4Five { parity: 0 }, BlockElement::Hex8] {
            let case = block_of(size, cells, element, 1.0, 0.3).fix("x-min", HELD);
            let p = case.contact("z-min", FLOOR, SurfaceFriction::Coulomb(0.3)).pose().problem;
            let guess = estimate(&p);
            let counted = choose(&p, &DualSettings { form: Form::Solves, ..Default::default() }).unwrap();
            let [flops, bytes] = [guess.flops / counted.flops, guess.bytes / counted.bytes as f64];
            println!("{element:?} {cells:?}: flops {flops:.2}, bytes {bytes:.2} of what was counted");
            assert!((0.2..5.0).contains(&flops) && (0.2..5.0).contains(&bytes), "{flops} {bytes}");
        }
    }
}

/// The model brick; without its supports `f` can be changed alone.
fn brick_without_supports() -> ContactProblem {
    let p = brick(6, BlockElement::Tet4Six, BrickLoad::Lift, SurfaceFriction::Coulomb(0.35)).pose().problem;
    ContactProblem { labels: Labels { supports: None, ..p.labels }, ..p }
}

#[test]
fn units_and_threads_change_nothing() {
    let metres = brick_without_supports();
    let one = by_multigrid(&metres, 1e-8);
    // Newton and millimetre: K in N/mm, lengths a thousand times as many.
    let mut millimetres = metres.clone();
    std::sync::Arc::make_mut(&mut millimetres.elastic.K).value.iter_mut().for_each(|k| *k *= 1e-3);
    let scaled = by_multigrid(&millimetres, 1e-8);
    assert_eq!(one.counts.cycles, scaled.counts.cycles);
    let back: Vec<f64> = scaled.u.iter().map(|u| u * 1e-3).collect();
    assert!(distance(&one.u, &back) < 1e-9 && distance(&one.lambda, &scaled.lambda) < 1e-7);
    for threads in [1, 2, 3] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let again = pool.install(|| by_multigrid(&metres, 1e-8));
        assert_eq!((&one.u, &one.lambda), (&again.u, &again.lambda), "{threads} threads");
    }
}

#[test]
fn one_set_up_serves_many_loads() {
    let p = brick_without_supports();
    let mut twice = p.clone();
    twice.elastic.f.iter_mut().for_each(|f| *f *= 2.0);
    let mut multigrid = Multigrid::new(&p).unwrap();
    let mut go =
        |p: &ContactProblem| solve_multigrid(p, &mut multigrid, &settings(1e-8), &mut |_| ControlFlow::Continue(()));
    let (first, second, third) = (go(&p), go(&twice), go(&p));
    [&first, &second, &third].into_iter().for_each(assert_solved);
    // Without a gap the problem is positively homogeneous.
    let half: Vec<f64> = second.u.iter().map(|u| 0.5 * u).collect();
    assert!(distance(&first.u, &half) < 1e-8 && distance(&first.u, &third.u) < 1e-8);
}

#[test]
fn what_the_path_is_not_for_is_refused_and_bad_numbers_end_it() {
    let p = brick(3, BlockElement::Tet4Six, BrickLoad::Lift, SurfaceFriction::Coulomb(0.35)).pose().problem;
    let triplets = |m: &Csr| -> Vec<(usize, usize, f64)> {
        (0..m.rows).flat_map(|i| m.row(i).0.iter().zip(m.row(i).1).map(move |(&j, &v)| (i, j as usize, v))).collect()
    };
    let with_rows = |rows: Vec<(usize, usize, f64)>| {
        let mut changed = p.clone();
        changed.contact.B = Csr::from_triplets(p.contact.B.rows, p.contact.B.cols, &rows);
        changed
    };
    // Two points at one node: one of them has none of its own.
    let (m, of_b) = (p.points(), triplets(&p.contact.B));
    let twice = of_b.iter().filter(|(i, ..)| i % m != 1).flat_map(|&(i, j, v)| {
        let same = (i % m == 0).then_some((i + 1, j, v));
        [(i, j, v)].into_iter().chain(same)
    });
    match Multigrid::new(&with_rows(twice.collect())) {
        Err(error) => {
            assert!(error.what.contains("node of their own"), "{error}");
            assert!(
                ["point 0 of pair \"z-min\"", "point 1 of pair \"z-min\""].iter().all(|of| error.what.contains(of)),
                "{error}"
            );
            let node = p.elastic.node_of.as_ref().unwrap()[p.contact.B.row(0).0[0] as usize];
            assert!(error.what.contains(&format!("node {node} ")), "{error}");
        }
        Ok(_) => panic!("a hierarchy without a node for each point"),
    }
    // Points whose rows reach each other's nodes: by half of their own they have coordinates, by all of it none.
    let [here, there] = [0, 1].map(|j| p.contact.B.row(j).0[0] as usize);
    let coupled = |by: f64| with_rows([of_b.clone(), vec![(0, there, by), (1, here, by)]].concat());
    let half = coupled(0.5);
    let found = by_multigrid(&half, 1e-10);
    assert_solved(&found);
    let expected = stiction::solve(&half, &Settings { path: SolverPath::Dense, ..settings(1e-10) }).unwrap();
    let largest = expected.u.iter().fold(0.0, |most: f64, u| most.max(u.abs()));
    assert!(found.u.iter().zip(&expected.u).all(|(a, b)| (a - b).abs() <= 1e-7 * largest));
    assert!(Multigrid::new(&coupled(1.0)).is_err_and(|error| error.what.contains("relative to one another")));
    // Without `node_of` every unknown is a node of its own, and no node has the three rows of a point.
    let mut bare = p.clone();
    bare.elastic.node_of = None;
    match Multigrid::new(&bare) {
        Err(error) => assert!(
            error.what.contains("`elastic.node_of`") && error.remedy.contains("`elastic.near_kernel`"),
            "{error}"
        ),
        Ok(_) => panic!("a hierarchy without nodes"),
    }
    // Indefinite and not a number: an end that says so, no solution, no hang.
    for value in [f64::NAN, -1e20] {
        let mut bad = p.clone();
        *std::sync::Arc::make_mut(&mut bad.elastic.K).entry_mut(30, 30).unwrap() = value;
        if let Ok(mut multigrid) = Multigrid::new(&bad) {
            let s = solve_multigrid(&bad, &mut multigrid, &settings(1e-8), &mut |_| ControlFlow::Continue(()));
            assert!(matches!(s.status, Status::Stalled | Status::MaxIterations), "{:?}", s.status);
        }
    }
    let stop = &mut |_: &stiction::friction::Progress| ControlFlow::Break(());
    let s = solve_multigrid(&p, &mut Multigrid::new(&p).unwrap(), &settings(1e-8), stop);
    assert_eq!(s.status, Status::Interrupted);
    // A coefficient of zero is no friction.
    let mut smooth = p.clone();
    smooth.contact.friction.fill(Friction::Coulomb { coefficient: 0.0 });
    assert_solved(&by_multigrid(&smooth, 1e-8));
}

/// A block that tapers by the angle `a` to both sides is pressed into the V between two planes and slips everywhere: the load
/// `F` is carried by `N = F / (2 (sin a + mu cos a))` on each plane, but for what slip along the groove takes of friction.
/// Friction carries most of the load, and only its dependence on the normal force resists the way in: without the Coulomb
/// coupling far from the answer these take 116 and 146 cycles.
#[test]
fn a_block_that_slips_into_a_groove_takes_few_cycles() {
    for (degrees, coefficient, most) in [(5f64, 0.2, 28), (3.0, 0.4, 75)] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let mut case = block_of([1.0, 1.0, 2.0], [8, 8, 16], BlockElement::Hex8, 1000.0, 0.3);
        let widen = |x: &mut [f64; 3]| x[0] = 0.5 + (x[0] - 0.5) * (1.0 + 2.0 * sin / cos * x[2]);
        case.mesh.nodes.iter_mut().for_each(widen);
        for (group, x, normal) in [("x-min", 0.0, cos), ("x-max", 1.0, -cos)] {
            let plane = Obstacle::Plane { point: [x, 0.0, 0.0], normal: [normal, 0.0, sin] };
            case = case.contact(group, plane, SurfaceFriction::Coulomb(coefficient));
        }
        let problem = case.traction("z-max", [0.0, 0.0, -1.0]).pose().problem;
        let s = by_multigrid(&problem, 1e-8);
        println!("{degrees} degrees: {:?}", s.counts);
        assert_solved(&s);
        assert!(s.states.iter().all(|state| *state == PointState::Slip));
        let load = 1.0 + 4.0 * sin / cos;
        assert!(close(normal_force(&problem, &s.lambda), load / (sin + coefficient * cos), 1e-3), "{degrees}");
        assert!(s.counts.cycles <= most, "{degrees} degrees: {:?}", s.counts);
    }
}
