//! Bodies held by contact alone.

use std::ops::{ControlFlow, Range};

use stiction::contact::equilibrium::{in_words, no_equilibrium, unresisted};
use stiction::contact::rigid::rigid_motions;
use stiction::contact::sliding::least_resisted;
use stiction::contact::{Bodies, Body, ContactProblem, Friction, Obstacle, Side, Supports, SurfaceFriction};
use stiction::dual::Form;
use stiction::fem::{Field, Fix};
use stiction::friction::{Given, Method, MethodSettings, Status, solve_with};
use stiction::linalg::{Csr, SymmetricCsr, max_abs, norm};
use stiction::mesh::BlockElement;
use stiction::run::totals;
use stiction_fixtures::case_run;
use stiction_fixtures::*;

const YOUNG: f64 = 2.1e11;
const ELEMENTS: [BlockElement; 2] = [BlockElement::Tet4Six, BlockElement::Hex8];

/// Turned about a skew axis, and far from the origin.
fn turned(mut case: Case, degrees: f64) -> Case {
    let (axis, (s, c)) = ([1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0], degrees.to_radians().sin_cos());
    for x in &mut case.mesh.nodes {
        let along: f64 = (0..3).map(|k| axis[k] * x[k]).sum();
        let across = [0, 1, 2].map(|k| axis[(k + 1) % 3] * x[(k + 2) % 3] - axis[(k + 2) % 3] * x[(k + 1) % 3]);
        *x = [0, 1, 2].map(|k| c * x[k] + s * across[k] + (1.0 - c) * along * axis[k] + 30.0);
    }
    case
}

#[test]
fn rigid_motions_are_those_that_no_support_stops() {
    let z = |held: bool| [None, None, held.then_some(0.0)];
    for element in ELEMENTS {
        let block = || block_of([3.0, 1.0, 0.5], [6, 3, 2], element, YOUNG, 0.3);
        let corner = |case: Case| {
            let x = case.mesh.nodes[0];
            let nodes: Vec<u32> =
                (0..case.mesh.nodes.len() as u32).filter(|&n| case.mesh.nodes[n as usize] == x).collect();
            let mut case = case;
            case.fixes.push(Fix { nodes, value: [const { Some(Field::Constant(0.0)) }; 3], ..Fix::default() });
            case
        };
        let cases = [
            (block(), 6),
            (turned(block(), 30.0), 6),
            (block().fix("z-min", z(true)), 3),
            (turned(block(), 30.0).fix("z-min", z(true)), 3),
            (block().fix("z-min", z(true)).fix("y-min", [None, Some(0.0), None]), 1),
            (corner(block()), 3),
            (corner(turned(block(), 30.0)), 3),
            (block().fix("x-min", HELD), 0),
        ];
        for (number, (case, count)) in cases.into_iter().enumerate() {
            let free = block().fix("x-min", HELD).contact("z-min", FLOOR, SurfaceFriction::None).pose().problem;
            let mut model = case.assemble();
            let (problem, _) = stiction::contact::pose(&case.mesh, &mut model, &[]).unwrap();
            let motions = rigid_motions(&problem);
            assert_eq!(motions.len(), count, "case {number} {element:?}");
            // Unstrained, orthonormal, and stopped by the fixing unknowns.
            let unit = |k: usize| (0..count).map(|j| f64::from(u8::from(j == k))).collect::<Vec<f64>>();
            for k in 0..count {
                let mut u = vec![0.0; problem.unknowns()];
                motions.add(&unit(k), &mut u);
                assert!((norm(&u) - 1.0).abs() < 1e-12);
                assert!(max_abs(&problem.elastic.K.times(&u)) < 1e-12 * problem.elastic.K.max_abs());
                assert!(motions.work(&u).iter().zip(unit(k)).all(|(w, e)| (w - e).abs() < 1e-12));
                let moved = motions.fixing().iter().map(|&i| u[i as usize].powi(2)).sum::<f64>().sqrt();
                assert!(moved > 0.3 / (problem.unknowns() as f64).sqrt());
            }
            assert!(rigid_motions(&free).is_empty());
        }
    }
}

/// A block on the floor pressed by `p` on its top and pushed by `t` on the side `x-min`, half as large.
fn pressed(element: BlockElement, p: f64, t: f64, friction: SurfaceFriction) -> Case {
    block_of([1.0, 1.0, 0.5], [4, 4, 2], element, YOUNG, 0.3)
        .traction("z-max", [0.0, 0.0, -p])
        .traction("x-min", [t, 0.0, 0.0])
        .contact("z-min", FLOOR, friction)
}

/// How the loads carry a body away.
fn departure(problem: &ContactProblem) -> Option<String> {
    let motions = rigid_motions(problem);
    no_equilibrium(problem, &motions).map(|slide| in_words(problem, &motions, &slide.alpha))
}

fn free_motion(problem: &ContactProblem) -> Option<(String, bool)> {
    let motions = rigid_motions(problem);
    unresisted(problem, &motions).map(|slide| (in_words(problem, &motions, &slide.alpha), slide.work > 0.0))
}

/// Resultant of the force of the points on the body; normals point down, tangents along x and y.
fn resultant(lambda: &[f64], points: Range<usize>) -> [f64; 3] {
    let m = lambda.len() / 3;
    let sum = |row: usize| lambda[row * m + points.start..row * m + points.end].iter().sum::<f64>();
    [-sum(1), -sum(2), sum(0)]
}

/// Friction far below the rounding of the weight holds what it holds: pushed by more along the floor a block slides, however little that is.
#[test]
fn weak_friction_holds_its_limit_and_no_more() {
    for element in ELEMENTS {
        for coefficient in [1e-3, 1e-6, 1e-8, 1e-10] {
            for (part, slides) in [(0.5, false), (0.99, false), (1.01, true), (2.0, true)] {
                // The side has half the area of the floor.
                let case = pressed(element, 1e6, 2.0 * part * coefficient * 1e6, SurfaceFriction::Coulomb(coefficient));
                let found = departure(&case.pose().problem);
                assert_eq!(found.is_some(), slides, "{part} of the limit of {coefficient}: {found:?}");
                assert!(found.is_none_or(|motion| motion.contains("translation along x")));
            }
        }
    }
}

#[test]
fn a_block_pressed_on_the_floor_is_held_by_friction_alone() {
    for element in ELEMENTS {
        // Without Poisson's effect the pressure is uniform and nothing wants to slip.
        let mut floating = pressed(element, 1e6, 0.0, SurfaceFriction::Coulomb(0.3));
        floating.poisson = 0.0;
        let floating = floating.pose();
        let s = solved(&floating.problem, 1e-10);
        assert!(s.counts.newton_steps <= 4, "{:?}", s.counts);
        for (j, area) in floating.problem.labels.area.iter().enumerate() {
            assert!((s.lambda[j] - 1e6 * area).abs() < 1e-9 * 1e6 * area);
        }
        for (x, u) in floating.full(&s.u).iter().zip(&pressed(element, 1e6, 0.0, SurfaceFriction::None).mesh.nodes) {
            assert!((x[2] + 1e6 / YOUNG * u[2]).abs() < 1e-9 * 1e6 / YOUNG && x[0].hypot(x[1]) < 1e-9 * 1e6 / YOUNG);
        }
        // With it: the same forces and strains as with supports that carry nothing, one corner and two directions.
        let posed = |held: bool| {
            let mut case = pressed(element, 1e6, 0.0, SurfaceFriction::Coulomb(0.3));
            if held {
                let middle = |x: &[f64; 3]| x[0] == 0.5 && x[1] == 0.5;
                let nodes = case.mesh.nodes.iter().enumerate().filter(|(_, x)| middle(x)).map(|(n, _)| n as u32);
                let value = [Some(Field::Constant(0.0)), Some(Field::Constant(0.0)), None];
                case.fixes.push(Fix { nodes: nodes.collect(), value, ..Fix::default() });
            }
            case.pose()
        };
        let (free, held) = (posed(false), posed(true));
        let (a, b) = (solved(&free.problem, 1e-10), solved(&held.problem, 1e-10));
        assert!(a.counts.newton_steps <= b.counts.newton_steps + 3, "{:?} {:?}", a.counts, b.counts);
        if element == BlockElement::Hex8 {
            // Symmetric: the axis of the block stays where it is, and carries no friction.
            let (a, b) = (free.full(&a.u), held.full(&b.u));
            assert!(distance(a.as_flattened(), b.as_flattened()) < 1e-8);
        }
    }
}

#[test]
fn a_pushed_block_sticks_up_to_the_limit_of_friction_and_slides_beyond() {
    for element in ELEMENTS {
        for (part, holds) in [(0.5, true), (1.0 - 1e-6, true), (1.0 + 1e-6, false), (1.5, false)] {
            let problem = pressed(element, 1e6, 6e5 * part, SurfaceFriction::Coulomb(0.3)).pose().problem;
            let s = attempt(&problem, &settings(1e-9));
            if holds {
                assert_solved(&s);
                let force = resultant(&s.lambda, 0..problem.points());
                assert!(distance(&force, &[-3e5 * part, 0.0, 1e6]) < 1e-8, "{force:?}");
                assert_eq!(departure(&problem), None);
            } else {
                assert_eq!(s.status, Status::NoEquilibrium);
                assert_eq!(departure(&problem).unwrap(), "the body: translation along x");
            }
        }
    }
}

#[test]
fn bodies_that_cannot_rest_are_told_how_they_leave() {
    let tall = |push: [f64; 3]| {
        block_of([1.0, 1.0, 3.0], [2, 2, 6], BlockElement::Hex8, YOUNG, 0.3)
            .traction("z-max", push)
            .contact("z-min", FLOOR, SurfaceFriction::Coulomb(0.9))
            .pose()
            .problem
    };
    // The line of action meets the floor at x = 0.5 + 3 tx/p: inside the base up to p/6.
    assert_solved(&attempt(&tall([0.16e6, 0.0, -1e6]), &settings(1e-9)));
    let over = tall([0.18e6, 0.0, -1e6]);
    assert_eq!(attempt(&over, &settings(1e-9)).status, Status::NoEquilibrium);
    assert_eq!(departure(&over).unwrap(), "the body: rotation about the axis along y through (1, 0.5, 0)");
    assert_eq!(departure(&tall([0.0, 0.0, 1e6])).unwrap(), "the body: translation along z");
    let smooth = |push: f64| pressed(BlockElement::Hex8, 1e6, push, SurfaceFriction::None).pose().problem;
    assert_eq!(free_motion(&smooth(1e5)).unwrap(), ("the body: translation along x".into(), true));
    assert!(!free_motion(&smooth(0.0)).unwrap().1);
    assert_eq!(free_motion(&over), None);
    // Given friction holds as much as its bound says, whatever the pressure.
    let given = |push: f64| pressed(BlockElement::Hex8, 1e6, push, SurfaceFriction::GivenStress(1e5)).pose().problem;
    assert_solved(&attempt(&given(1.99e5), &settings(1e-9)));
    assert_eq!(departure(&given(2.01e5)).unwrap(), "the body: translation along x");
}

/// Blocks on one another on the floor, node on node, lifted by `clearance` from what is below.
fn stack(levels: usize, cells: [usize; 3], clearance: f64, poisson: f64, push: f64) -> (ContactProblem, Vec<[f64; 3]>) {
    let one = |level: usize| {
        let mut case = block_of([1.0, 1.0, 0.5], cells, BlockElement::Hex8, YOUNG, poisson);
        case.mesh.nodes.iter_mut().for_each(|x| x[2] += level as f64 * (0.5 + clearance) + clearance);
        let case = case.contact("z-min", FLOOR, SurfaceFriction::Coulomb(0.3));
        if level + 1 == levels { case.traction("z-max", [push, 0.0, -1e6]) } else { case }
    };
    let cases: Vec<Case> = (0..levels).map(one).collect();
    let parts: Vec<ContactProblem> = cases.iter().map(|case| case.pose().problem).collect();
    let (n, m) = (parts[0].unknowns(), parts[0].points());
    let tops = cases[0].nodes("z-max");
    let (mut k, mut b) = (Vec::new(), Vec::new());
    for (level, part) in parts.iter().enumerate() {
        let full = part.elastic.K.full();
        for i in 0..n {
            let (columns, values) = full.row(i);
            columns.iter().zip(values).for_each(|(&j, &v)| k.push((level * n + i, level * n + j as usize, v)));
        }
        for i in 0..3 * m {
            let (columns, values) = part.contact.B.row(i);
            for (&j, &v) in columns.iter().zip(values) {
                let row = (i / m * levels + level) * m + i % m;
                b.push((row, level * n + j as usize, v));
                if level > 0 {
                    b.push((row, (level - 1) * n + 3 * tops[i % m] as usize + j as usize % 3, -v));
                }
            }
        }
    }
    let all = |of: fn(&ContactProblem) -> &Vec<f64>| parts.iter().flat_map(of).copied().collect::<Vec<f64>>();
    let friction: Vec<Friction> = parts.iter().flat_map(|p| &p.contact.friction).copied().collect();
    let k = SymmetricCsr::from_full(&Csr::from_triplets(levels * n, levels * n, &k), "K").unwrap();
    let b = Csr::from_triplets(3 * levels * m, levels * n, &b);
    let mut problem = ContactProblem::from_matrices(k, all(|p| &p.elastic.f), b, vec![clearance; levels * m], friction);
    problem.elastic.near_kernel = Some(parts.iter().flat_map(|p| p.elastic.near_kernel.clone().unwrap()).collect());
    let body = |level: usize| {
        let part = parts[level].labels.bodies.as_ref().unwrap();
        let name = if level + 1 == levels { "highest".into() } else { format!("block {level}") };
        Body { name, ..part.list[0].clone() }
    };
    problem.labels.bodies = Some(Bodies {
        list: (0..levels).map(body).collect(),
        of: (0..levels * n).map(|i| (i / n) as u32).collect(),
        of_support: Vec::new(),
        origin: [0.0; 3],
    });
    problem.labels.supports = Some(Supports {
        K: Csr::zero(0, levels * n),
        K_own: Csr::zero(0, 0),
        load: Vec::new(),
        free_load: problem.elastic.f.clone(),
        displacement: Vec::new(),
        B: Csr::zero(3 * levels * m, 0),
        rigid: Vec::new(),
        springs: None,
    });
    problem.validate().unwrap();
    (problem, cases.iter().flat_map(|case| case.mesh.nodes.clone()).collect())
}

#[test]
fn stacked_blocks_rest_on_one_another() {
    for clearance in [0.0, 0.1] {
        let (problem, nodes) = stack(3, [3, 3, 2], clearance, 0.0, 0.0);
        assert_eq!(rigid_motions(&problem).len(), 18);
        let s = solved(&problem, 1e-10);
        let strain = 1e6 / YOUNG;
        for (x, u) in nodes.iter().zip(s.u.as_chunks::<3>().0) {
            let level = (x[2] / (0.5 + clearance) - 1e-9).floor();
            let down = (level + 1.0) * clearance + strain * (x[2] - (level + 1.0) * clearance);
            let error = [u[0], u[1], u[2] + down];
            assert!(max_abs(&error) < 1e-9 * (strain + clearance), "{clearance} {x:?} {u:?} {down}");
        }
    }
    // Pushed at the top the force goes through all of them, and the certificate says so for each.
    let (problem, _) = stack(3, [3, 3, 2], 0.0, 0.3, 2e5);
    let s = solved(&problem, 1e-10);
    let m = problem.points() / 3;
    for level in 0..3 {
        let force = resultant(&s.lambda, level * m..(level + 1) * m);
        assert!(distance(&force, &[-2e5, 0.0, 1e6]) < 1e-8, "{force:?}");
        let body = &s.certificate.bodies[level];
        let load = if level == 2 { [2e5, 0.0, -1e6] } else { [0.0; 3] };
        assert!(distance(&body.load, &load) < 1e-12 && max_abs(&body.support) == 0.0);
        assert!((0..3).all(|c| (body.contact[c] + load[c]).abs() < 1e-8 * 1e6), "{body:?}");
    }
    let (problem, _) = stack(3, [3, 3, 2], 0.0, 0.3, 3.1e5);
    assert_eq!(departure(&problem).unwrap(), "body \"highest\": translation along x");
}

/// A tower of 40 blocks falls over the edge of its foot where the push at its top turns it more than its load holds it:
/// `push * height = load * width / 2`.
#[test]
fn a_tower_of_many_blocks_stands_until_the_push_turns_it_over() {
    let (levels, load) = (40, 1e6);
    let most = load * 0.5 / (0.5 * levels as f64);
    let pushed = |part: f64| stack(levels, [1, 1, 1], 0.0, 0.3, part * most).0;
    assert_eq!(departure(&pushed(0.9999)), None);
    let fall = departure(&pushed(1.0001)).unwrap();
    assert!(fall.starts_with("body \"highest\": rotation"), "{fall}");
    let problem = pushed(0.9);
    let s = solved(&problem, 1e-10);
    let m = problem.points() / levels;
    for level in 0..levels {
        let force = resultant(&s.lambda, level * m..(level + 1) * m);
        assert!(distance(&force, &[-0.9 * most, 0.0, load]) < 1e-8, "{level} {force:?}");
        // About the edge that it leans on, through points at y = 0 and y = 1.
        let held = 0.5 * load - 0.9 * most * 0.5 * (levels - level) as f64;
        let first = level * m;
        let left: f64 = (0..m).filter(|j| j % 2 == 0).map(|j| s.lambda[first + j]).sum();
        assert!((left - held).abs() < 1e-8 * load, "{level} {left} {held}");
    }
}

#[test]
fn methods_that_cannot_keep_the_balance_refuse() {
    let problem = pressed(BlockElement::Hex8, 1e6, 0.0, SurfaceFriction::GivenStress(1e5)).pose().problem;
    let dual = dual_of(&problem, Form::Auto);
    let method = MethodSettings::new(Method::Given(Given::Discs));
    let error = solve_with(&problem, &dual, &settings(1e-8), &method, &mut |_| ControlFlow::Continue(()));
    assert!(error.unwrap_err().to_string().contains("held by contact alone"));
}

#[test]
fn both_forms_of_the_dual_operator_hold_a_floating_block() {
    let problem = pressed(BlockElement::Tet4Six, 1e6, 4e5, SurfaceFriction::Coulomb(0.3)).pose().problem;
    let solve = |form| {
        let s = stiction::friction::solve(&problem, &dual_of(&problem, form), &settings(1e-10), &mut |_| {
            ControlFlow::Continue(())
        });
        assert_solved(&s);
        s
    };
    let (a, b) = (solve(Form::Dense), solve(Form::Solves));
    assert!(distance(&a.u, &b.u) < 1e-8 && distance(&a.lambda, &b.lambda) < 1e-8);
}

/// Blocks dropped by a tenth of their height into a trough and into a bowl, which they touch at edges and at corners.
#[test]
fn bodies_that_start_far_from_what_they_touch_come_to_rest() {
    for coefficient in [0.2, 0.6] {
        let hollow = |obstacle: Obstacle| {
            let mut case = block_of([1.0, 1.0, 0.5], [6, 4, 3], BlockElement::Hex8, 1e9, 0.3)
                .traction("z-max", [0.0, 0.0, -1e6])
                .contact("z-min", obstacle, SurfaceFriction::Coulomb(coefficient));
            case.mesh.nodes.iter_mut().for_each(|x| x[2] += 0.6);
            case.pose().problem
        };
        let (radius, side) = (2.0, Side::Inside);
        let trough = Obstacle::Cylinder { point: [0.5, 0.0, 2.0], axis: [0.0, 1.0, 0.0], radius, side };
        let bowl = Obstacle::Sphere { center: [0.5, 0.5, 3.0], radius: 3.0, side };
        for obstacle in [trough, bowl] {
            let problem = hollow(obstacle);
            let s = solved(&problem, 1e-9);
            assert!(s.counts.newton_steps <= 15 && s.counts.fixed_point_steps == 0, "{:?}", s.counts);
            assert!(s.certificate.bodies[0].balance.moment < 1e-9);
        }
    }
}

/// A block on the floor with uniform normal forces, pushed along x at the distance `arm` from its middle: friction over load
/// of the motion that friction resists least, against all centres of rotation of a grid.
#[test]
fn the_least_resisted_motion_is_the_least_of_all_motions() {
    let posed = pressed(BlockElement::Hex8, 1e6, 0.0, SurfaceFriction::Coulomb(0.3)).pose();
    let mut p = posed.problem;
    let m = p.points();
    let mut lambda = p.labels.area.clone();
    lambda.resize(3 * m, 0.0);
    let at: Vec<[f64; 2]> = (posed.facts[0].nodes.iter())
        .map(|&node| pressed(BlockElement::Hex8, 1e6, 0.0, SurfaceFriction::None).mesh.nodes[node as usize])
        .map(|x| [x[0] - 0.5, x[1] - 0.5])
        .collect();
    for arm in [0.0, 0.1, 0.3, 1.0, 10.0] {
        // Unit force along x and the moment about the middle, as forces on the unknowns.
        let motions = rigid_motions(&p);
        let six = p.elastic.near_kernel.clone().unwrap();
        let n = six.len() as f64 / 3.0;
        let turns: f64 = six.iter().map(|r| r[5] * r[5]).sum();
        p.elastic.f = six.iter().map(|r| r[0] / n - arm * r[5] / turns).collect();
        let found = least_resisted(&p, &motions, &lambda).unwrap();
        let ratio = found.friction / found.load;
        let friction =
            |x: f64, y: f64| -> f64 { at.iter().zip(&lambda).map(|(a, l)| 0.3 * l * (a[0] - x).hypot(a[1] - y)).sum() };
        // Along x, and about centres on the y axis, where symmetry puts the best.
        let mut least: f64 = 0.3 * lambda[..m].iter().sum::<f64>();
        for k in -200_000..200_000 {
            let y = f64::from(k) * 1e-4;
            let work = (y - arm).abs();
            least = least.min(friction(0.0, y) / work.max(1e-12));
        }
        println!("{arm}: {ratio} {least}");
        assert!((ratio / least - 1.0).abs() < 1e-6, "{arm}: {ratio} {least}");
    }
}

/// A wall beside the block: pushed against it the block is stopped, pushed away from it nothing but friction resists.
#[test]
fn a_motion_that_a_wall_will_stop_is_not_told() {
    let wall = Obstacle::Plane { point: [1.01, 0.0, 0.0], normal: [-1.0, 0.0, 0.0] };
    for (push, stopped) in [(1.0, true), (-1.0, false)] {
        let case = pressed(BlockElement::Hex8, 1e6, push * 5e5, SurfaceFriction::Coulomb(0.3));
        let p = case.contact("x-max", wall.clone(), SurfaceFriction::None).pose().problem;
        let mut lambda = vec![0.0; 3 * p.points()];
        let floor = p.labels.pairs[0].points.clone();
        floor.for_each(|j| lambda[j] = 1e6 * p.labels.area[j]);
        let motions = rigid_motions(&p);
        let found = least_resisted(&p, &motions, &lambda);
        assert_eq!(found.is_none(), stopped);
        if let Some(found) = found {
            // 1e6 on the unit square of the base; 5e5 on the side, half as high.
            assert!(close(found.friction, 3e5, 1e-6) && close(found.load, 2.5e5, 1e-9), "{found:?}");
            assert_eq!(in_words(&p, &motions, &found.alpha), "the body: translation along (-1, 0, 0)");
        }
    }
}

/// A column of blocks that contact alone holds, on meshes that do not match. On the coarse levels each of them becomes a single
/// node, whose rigid motions cost nothing: the inverse of that rounding was infinite, or made 124 cycles of 20.
#[test]
fn a_column_of_fifty_blocks_is_solved_in_the_cycles_of_a_few() {
    const BLOCKS: usize = 52;
    let mut text = "[materials.steel]\nyoung = 210e3\npoisson = 0.3\n[[fix]]\non = \"b0.z-min\"\n".to_string();
    let mut side = 20.0;
    for i in 0..BLOCKS {
        side = 20.0 - 0.02 * i as f64;
        let (cells, corner) = (2 + i % 2, 0.5 * (20.0 - side));
        text += &format!(
            "[mesh.parts.b{i}]\nblock = {{ size = [{side}, {side}, 4], cells = [{cells}, {cells}, 1], element = \"hex8\" }}\n\
             move = [{corner}, {corner}, {z}]\n",
            z = 4 * i
        );
        if i > 0 {
            let below = i - 1;
            text += &format!(
                "[[contact]]\non = \"b{i}.z-min\"\nagainst = \"b{below}.z-max\"\nfriction = {{ coulomb = 0.3 }}\n"
            );
        }
    }
    text += &format!("[[load]]\non = \"b{}.z-max\"\npressure = 20\n[solver]\npath = \"multigrid\"\n", BLOCKS - 1);
    let (outcome, prepared) = case_run::solved(&text);
    assert!(outcome.solution.counts.cycles <= 30, "{} cycles", outcome.solution.counts.cycles);
    // Each contact carries the whole load.
    let wanted = (BLOCKS - 1) as f64 * 20.0 * side * side;
    let found = totals(&prepared, &outcome).normal_force;
    assert!((found / wanted - 1.0).abs() < 1e-7, "{found} for {wanted}");
}

/// A plate that is pushed and whose table has no support: it goes away without a force, which hardly anybody means.
#[test]
fn a_body_without_support_that_nothing_presses_is_named() {
    let text = |fix: &str| {
        format!(
            "[mesh.parts.table]\nblock = {{ size = [4, 4, 1], cells = [2, 2, 1], element = \"hex8\" }}\n\
             [mesh.parts.plate]\nblock = {{ size = [3, 3, 1], origin = [0.5, 0.5, 1], cells = [2, 2, 1], element = \"hex8\" }}\n\
             [materials.m]\nyoung = 1000\npoisson = 0.3\n[[fix]]\non = \"plate.z-max\"\nvalue = [0, 0, -0.05]\n{fix}\
             [[contact]]\non = \"plate.z-min\"\nagainst = \"table.z-max\"\nfriction = {{ coulomb = 0.4 }}\n"
        )
    };
    let told = |fix: &str| {
        let run = case_run::solved(&text(fix));
        stiction::run::report(&run.1, &run.0).to_string()
    };
    let free = told("");
    assert!(free.contains("body \"table\" has no support, and nothing presses on it"), "{free}");
    let held = told("[[fix]]\non = \"table.z-min\"\n");
    assert!(!held.contains("has no support"), "{held}");
}

/// A block under a lid that is lifted and put back. With given friction, which acts on open points too, nothing holds it across the lid
/// meanwhile.
#[test]
fn a_body_that_given_friction_alone_holds_is_named() {
    let layer = "size = [10, 6, 3], cells = [4, 2, 1], element = \"hex8\"";
    for law in ["{ tresca = 0.002 }", "{ coulomb = 0.1 }"] {
        let (outcome, _) = case_run::solved(&format!(
            "[mesh.parts.a]\nblock = {{ {layer} }}\n[mesh.parts.b]\nblock = {{ {layer} }}\nmove = [0, 0, 3]\n\
             [materials.m]\nyoung = 100\npoisson = 0.3\n\
             [[fix]]\non = \"b.z-max\"\nvalue = [\"1e-3*t\", 0, \"-2e-3*min(t, 1) + 4e-3*min(max(t - 1, 0), 1) - 4e-3*max(t - 2, 0)\"]\n\
             [[contact]]\non = \"a.z-min\"\nagainst = {{ plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }} }}\nfriction = {{ coulomb = 0.3 }}\n\
             [[contact]]\non = \"b.z-min\"\nagainst = \"a.z-max\"\nfriction = {law}\n\
             [[step]]\nuntil = 1\n[[step]]\nuntil = 2\n[[step]]\nuntil = 3\n"
        ));
        let unheld: Vec<_> = outcome.steps.iter().map(|step| step.answer.unheld.join(" ")).collect();
        assert_eq!(unheld, ["", "a", ""], "{law}");
    }
}

/// Heat has no resultant: what rounding leaves of it pushes nothing.
#[test]
fn heat_does_not_push_a_body_away() {
    for (height, young) in [(3.81061, 4839.38872398), (3.3, 2.1e5), (0.7, 1.7e11)] {
        let refused = case_run::refused(&format!(
            "[mesh.parts.low]\nblock = {{ size = [10, 6, 2.57898], cells = [5, 3, 2], element = \"hex8\" }}\n\
             [mesh.parts.mid]\nblock = {{ size = [10, 6, {height}], cells = [5, 3, 1], element = \"hex8\" }}\nmove = [0, 0, 2.57898]\n\
             [materials.m]\nyoung = {young}\npoisson = 0.499\nexpansion = 1.36393577675e-05\n\
             [[fix]]\non = \"low.z-min\"\n[[load]]\ntemperature = 20\n\
             [[contact]]\non = \"mid.z-min\"\nagainst = \"low.z-max\"\nfriction = \"none\"\n"
        ));
        assert!(refused.contains("its displacement is not determined"), "{refused}");
    }
}

/// A hub on a clamped shaft (a quarter of both) resists a pull up to `mu N`, `N` from the overlap that was meshed. Beyond, it slides off;
/// at 1e14 mm rounding of axial directions in the rows of the curved faces amounts to a taper that makes any normal force.
#[test]
fn a_hub_pulled_beyond_friction_is_not_certified_where_rounding_wedges_it() {
    let case = |pull: f64, path: &str| {
        format!(
            "[mesh.parts.S]\nring = {{ radii = [6, 10], height = 8, degrees = 90, cells = [1, 3, 2], element = \"hex8\" }}\n\
             [mesh.parts.H]\nring = {{ radii = [10, 16], height = 6, degrees = 90, cells = [1, 2, 2], element = \"hex8\" }}\n\
             move = [0, 0, 1]\n[materials.steel]\nyoung = 210e3\npoisson = 0.3\n\
             [[fix]]\non = [\"S.start\", \"H.start\"]\ncondition = \"symmetry\"\n\
             [[fix]]\non = [\"S.end\", \"H.end\"]\ncondition = \"symmetry\"\n[[fix]]\non = \"S.inner\"\n\
             [[load]]\non = \"H.z-max\"\nforce = [0, 0, {pull}]\n\
             [[contact]]\non = \"H.inner\"\nagainst = \"S.outer\"\nfriction = {{ coulomb = 0.1 }}\ngap = -0.002\n\
             slave = \"against\"\n[solver]\npath = \"{path}\"\n"
        )
    };
    for path in ["dense", "solves"] {
        let (outcome, _) = case_run::solved(&case(60.0, path));
        assert_eq!(outcome.solution.status, Status::Solved);
        for pull in [150.0, 200.0, 300.0, 1000.0] {
            let case = stiction::io::case::parse(&case(pull, path), "case.toml", &[]).unwrap();
            let prepared = stiction::run::prepare(&case).unwrap();
            let settings = stiction::run::Settings::of(&case.solver);
            let outcome = stiction::run::solve(&prepared, &settings, &mut |_| ControlFlow::Continue(())).unwrap();
            let most = max_abs(&outcome.solution.u);
            assert_ne!(outcome.solution.status, Status::Solved, "{path} {pull}: {most:e}");
        }
    }
}

/// Where the load is taken off a body that contact alone holds above what it was pressed on, no forces are left, and it stays there
/// without strain: before, it was pressed on the floor a thousandth below it.
#[test]
fn a_body_whose_load_is_taken_off_stays_where_it_was() {
    for (element, cells) in [("hex8", [3, 3, 2]), ("hex8", [12, 12, 5]), ("tet10", [3, 3, 2]), ("hex20", [3, 3, 2])] {
        for path in ["auto", "dense", "multigrid"] {
            let text = format!(
                "[mesh]\nblock = {{ size = [2, 2, 1], cells = {cells:?}, element = \"{element}\" }}\n[materials.m]\nyoung = 1e3\npoisson = 0.3\n\
                 [[fix]]\non = {{ point = [0, 0, 0] }}\ncomponents = \"xy\"\n[[fix]]\non = {{ point = [2, 0, 0] }}\ncomponents = \"y\"\n\
                 [[load]]\non = \"z-max\"\npressure = \"t*(2 - t)\"\n[[contact]]\non = \"z-min\"\nfriction = {{ coulomb = 0.3 }}\n\
                 against = {{ plane = {{ point = [0, 0, -0.001], normal = [0, 0, 1] }} }}\n[[step]]\nuntil = 2\nincrements = 2\n\
                 [solver]\npath = \"{path}\"\n"
            );
            let run = case_run::solved(&text);
            let contact = totals(&run.1, &run.0);
            assert!(run.0.steps.len() == 2 && contact.normal_force == 0.0, "{element} {path}: {contact:?}");
            for [x, y, z] in case_run::displacement(&run) {
                assert!(x.hypot(y) < 1e-5 && (z + 1e-3).abs() < 2e-5, "{element} {path}: {:?}", [x, y, z]);
            }
        }
    }
}
