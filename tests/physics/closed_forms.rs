//! Solutions known by hand, and the same answer by a second road.

use stiction::contact::{Friction, SurfaceFriction};
use stiction::dual::Form;
use stiction::fem::{Field, Fix};
use stiction::friction::{PointState, Status};
use stiction::mesh::BlockElement;
use stiction_fixtures::*;

const YOUNG: f64 = 2e9;
const ELEMENTS: [BlockElement; 7] = [
    BlockElement::Hex8,
    BlockElement::Tet4Six,
    BlockElement::Tet4Five { parity: 1 },
    BlockElement::Tet10Six,
    BlockElement::Hex20,
    BlockElement::Wedge6,
    BlockElement::Wedge15,
];

/// A cube of side 2 without lateral contraction, its top moved by `-shortening` along z and by `shift` along
/// `direction`, and shear tractions `shear` on its sides that keep a state of uniform stress in balance.
fn pushed(element: BlockElement, direction: f64, shift: f64, shear: f64, friction: SurfaceFriction) -> Posed {
    let (c, s) = (direction.cos(), direction.sin());
    let case = block_of([2.0; 3], [3, 2, 4], element, YOUNG, 0.0)
        .fix("z-max", [Some(shift * c), Some(shift * s), Some(-SHORTENING)])
        .contact("z-min", FLOOR, friction)
        .traction("x-max", [0.0, 0.0, shear * c])
        .traction("x-min", [0.0, 0.0, -shear * c])
        .traction("y-max", [0.0, 0.0, shear * s])
        .traction("y-min", [0.0, 0.0, -shear * s]);
    case.pose()
}

const SHORTENING: f64 = 2e-3;
const PRESSURE: f64 = YOUNG * SHORTENING / 2.0;
const COEFFICIENT: f64 = 0.4;
/// The shift of the top whose shear stress is the friction limit: `tau = G shift / height`, `G = E / 2`.
const LIMIT: f64 = COEFFICIENT * PRESSURE * 2.0 / (YOUNG / 2.0);

#[test]
fn a_block_pushed_below_the_friction_limit_does_not_move() {
    for element in ELEMENTS {
        for direction in [0.0, 0.7, 4.0] {
            let shear = 0.999 * COEFFICIENT * PRESSURE;
            let posed = pushed(element, direction, 0.999 * LIMIT, shear, SurfaceFriction::Coulomb(COEFFICIENT));
            let (p, m) = (&posed.problem, posed.problem.points());
            let s = solved(p, 1e-11);
            assert!(s.states.iter().all(|&s| s == PointState::Stick));
            for j in 0..m {
                let friction = s.lambda[m + j].hypot(s.lambda[2 * m + j]);
                assert!(close(s.lambda[j], PRESSURE * p.labels.area[j], 1e-9));
                assert!(close(friction, shear * p.labels.area[j], 1e-9));
            }
            assert!(p.contact.B.times(&s.u)[m..].iter().all(|slip| slip.abs() < 1e-11 * LIMIT));
            let [fx, fy] = friction_on_body(p, &s.lambda);
            assert!(fx.hypot(fy) < COEFFICIENT * normal_force(p, &s.lambda));
        }
    }
}

#[test]
fn a_block_pushed_above_the_friction_limit_slips_along_the_push_by_the_excess() {
    for element in ELEMENTS {
        for direction in [0.0, 0.7, 4.0] {
            let law = SurfaceFriction::Coulomb(COEFFICIENT);
            let posed = pushed(element, direction, 1.001 * LIMIT, COEFFICIENT * PRESSURE, law);
            let (p, m) = (&posed.problem, posed.problem.points());
            let s = solved(p, 1e-11);
            assert!(s.states.iter().all(|&s| s == PointState::Slip));
            let slip = &p.contact.B.times(&s.u)[m..];
            for j in 0..m {
                assert!(close(s.lambda[j], PRESSURE * p.labels.area[j], 1e-9));
                let slipped = 0.001 * LIMIT * p.labels.unity_sum[j];
                assert!((slip[j] - slipped * direction.cos()).abs() < 1e-9 * LIMIT);
                assert!((slip[m + j] - slipped * direction.sin()).abs() < 1e-9 * LIMIT);
            }
            // The friction ON the body is against its slip, F times the normal force.
            let [fx, fy] = friction_on_body(p, &s.lambda);
            let limit = COEFFICIENT * normal_force(p, &s.lambda);
            assert!((fx + limit * direction.cos()).abs() < 1e-10 * limit);
            assert!((fy + limit * direction.sin()).abs() < 1e-10 * limit);
        }
    }
}

#[test]
fn given_friction_slips_where_coulomb_friction_of_the_same_bound_does() {
    let stress = COEFFICIENT * PRESSURE;
    for (factor, state) in [(0.999, PointState::Stick), (1.001, PointState::Slip)] {
        let law = SurfaceFriction::GivenStress(stress);
        let posed = pushed(BlockElement::Hex8, 1.0, factor * LIMIT, factor.min(1.0) * stress, law);
        let s = solved(&posed.problem, 1e-11);
        assert!(s.states.iter().all(|&s| s == state));
    }
}

#[test]
fn a_block_that_slips_everywhere_carries_friction_times_the_normal_force_also_without_uniform_stress() {
    // No tractions on the sides: stresses vary, but the resultant of points that all slip one way is known.
    let case = block_of([2.0, 2.0, 1.0], [4, 4, 2], BlockElement::Hex8, YOUNG, 0.3)
        .fix("z-max", [Some(3e-3), Some(0.0), Some(-1e-3)])
        .contact("z-min", FLOOR, SurfaceFriction::Coulomb(0.2));
    let p = case.pose().problem;
    let s = solved(&p, 1e-11);
    let m = p.points();
    assert!(s.states.iter().all(|&s| s == PointState::Slip));
    let limit: f64 = 0.2 * normal_force(&p, &s.lambda);
    let magnitudes: f64 = (0..m).map(|j| s.lambda[m + j].hypot(s.lambda[2 * m + j])).sum();
    assert!(close(magnitudes, limit, 1e-10));
    let [fx, fy] = friction_on_body(&p, &s.lambda);
    assert!(fx < -0.95 * limit && fx.hypot(fy) <= limit * (1.0 + 1e-10));
    assert!(fy.abs() < 1e-9 * limit, "the block is symmetric about the push: {fy}");
}

#[test]
fn without_friction_a_shortened_block_has_uniform_pressure_whatever_its_contraction() {
    for element in ELEMENTS {
        let case = block_of([2.0; 3], [3, 2, 4], element, YOUNG, 0.3)
            .fix("z-max", [None, None, Some(-SHORTENING)])
            .fix("x-min", [Some(0.0), None, None])
            .fix("y-min", [None, Some(0.0), None])
            .contact("z-min", FLOOR, SurfaceFriction::None);
        let posed = case.pose();
        let s = solved(&posed.problem, 1e-11);
        for (force, area) in s.lambda.iter().zip(&posed.problem.labels.area) {
            assert!(close(*force, PRESSURE * area, 1e-9));
        }
        // u_x = nu p x / E
        for (x, u) in case.mesh.nodes.iter().zip(posed.full(&s.u)) {
            let exact = [0.3 * PRESSURE / YOUNG * x[0], 0.3 * PRESSURE / YOUNG * x[1], -SHORTENING * x[2] / 2.0];
            assert!((0..3).all(|c| (u[c] - exact[c]).abs() < 1e-9 * SHORTENING));
        }
    }
}

#[test]
fn a_block_above_the_floor_stays_free_and_is_certified() {
    let posed = {
        let mut case = block_of([1.0; 3], [2; 3], BlockElement::Hex8, YOUNG, 0.3);
        case.mesh.nodes.iter_mut().for_each(|x| x[2] += 0.5);
        case.fix("z-max", HELD).traction("x-max", [1e5, 0.0, 0.0]).contact(
            "z-min",
            FLOOR,
            SurfaceFriction::Coulomb(0.5),
        )
    }
    .pose();
    let s = solved(&posed.problem, 1e-10);
    assert!(s.lambda.iter().all(|&l| l == 0.0));
    assert!(s.states.iter().all(|&s| s == PointState::Open));
}

#[test]
fn bonded_contact_is_the_same_as_fixed_nodes() {
    for (load, element, n) in [
        (BrickLoad::Lift, BlockElement::Tet4Six, 4),
        (BrickLoad::Press, BlockElement::Tet4Six, 4),
        (BrickLoad::Press, BlockElement::Hex20, 2),
    ] {
        let bonded = brick(n, element, load, SurfaceFriction::Bonded).pose();
        let s = solved(&bonded.problem, 1e-11);
        let mut clamped = brick(n, element, load, SurfaceFriction::None).fix("z-min", HELD);
        clamped.surfaces.clear();
        let model = clamped.assemble();
        let u = dense::Factor::new(&model.stiffness).solve(&model.load);
        let second = Posed { model, problem: bonded.problem.clone(), facts: Vec::new() };
        assert!(distance(bonded.full(&s.u).as_flattened(), second.full(&u).as_flattened()) < 1e-9);
    }
}

#[test]
fn given_friction_without_a_bound_is_no_friction() {
    let none = brick(4, BlockElement::Hex8, BrickLoad::Lift, SurfaceFriction::None).pose().problem;
    let zero = brick(4, BlockElement::Hex8, BrickLoad::Lift, SurfaceFriction::GivenStress(0.0)).pose().problem;
    let coulomb = brick(4, BlockElement::Hex8, BrickLoad::Lift, SurfaceFriction::Coulomb(0.0)).pose().problem;
    let reference = solved(&none, 1e-11);
    for other in [zero, coulomb] {
        let s = solved(&other, 1e-11);
        assert!(distance(&s.u, &reference.u) < 1e-9);
        assert!(distance(&s.lambda, &reference.lambda) < 1e-9);
    }
}

#[test]
fn given_friction_with_a_huge_bound_is_a_floor_that_holds_the_tangents() {
    let element = BlockElement::Hex8;
    let rough = brick(4, element, BrickLoad::Lift, SurfaceFriction::GivenStress(1e9)).pose();
    let s = solved(&rough.problem, 1e-10);
    // Second road: tangents fixed as supports, frictionless contact. The clamped end stays clamped.
    let mut held = brick(4, element, BrickLoad::Lift, SurfaceFriction::None);
    let end = held.nodes("x-min");
    let floor: Vec<u32> = held.nodes("z-min").into_iter().filter(|n| !end.contains(n)).collect();
    held.fixes.push(Fix {
        nodes: floor,
        value: [Some(Field::Constant(0.0)), Some(Field::Constant(0.0)), None],
        ..Fix::default()
    });
    let held = held.pose();
    let second = solved(&held.problem, 1e-10);
    assert!(distance(rough.full(&s.u).as_flattened(), held.full(&second.u).as_flattened()) < 1e-8);
    let m = rough.problem.points();
    assert!(distance(&s.lambda[..m], &second.lambda[..m]) < 1e-8);
}

#[test]
fn coulomb_friction_is_a_fixed_point_of_given_friction() {
    for load in [BrickLoad::Lift, BrickLoad::Press] {
        let p = brick(4, BlockElement::Tet4Six, load, SurfaceFriction::Coulomb(0.35)).pose().problem;
        let coulomb = solved(&p, 1e-11);
        let given = |j: usize| Friction::Given { slip_bound: 0.35 * coulomb.lambda[j] };
        let frozen = with_friction(&p, (0..p.points()).map(given).collect());
        let s = solved(&frozen, 1e-11);
        assert!(distance(&s.lambda, &coulomb.lambda) < 1e-8);
        assert!(distance(&s.u, &coulomb.u) < 1e-8);
    }
}

#[test]
fn the_form_of_the_dual_operator_does_not_change_the_answer() {
    let p = brick(8, BlockElement::Tet4Six, BrickLoad::Press, SurfaceFriction::Coulomb(0.35)).pose().problem;
    let solve = |form| {
        let dual = dual_of(&p, form);
        let s = stiction::friction::solve(&p, &dual, &settings(1e-11), &mut |_| std::ops::ControlFlow::Continue(()));
        assert_solved(&s);
        s
    };
    let (dense, solves) = (solve(Form::Dense), solve(Form::Solves));
    assert!(distance(&dense.u, &solves.u) < 1e-9);
    assert!(distance(&dense.lambda, &solves.lambda) < 1e-9);
}

#[test]
fn areas_of_contact_points_add_up_to_the_surface() {
    for element in ELEMENTS {
        let case = brick(4, element, BrickLoad::Lift, SurfaceFriction::None);
        let all: f64 = stiction_fixtures::nodal_areas(&case.mesh, &case.faces("z-min")).iter().map(|a| a.1).sum();
        let posed = case.pose();
        let kept: f64 = posed
            .problem
            .labels
            .area
            .iter()
            .zip(&posed.problem.labels.unity_sum)
            .map(|(area, share)| area * share)
            .sum();
        assert!(close(all, 3.0, 1e-13) && close(kept + posed.facts[0].dropped_area, 3.0, 1e-13));
        assert!(close(posed.facts[0].area, 3.0, 1e-13));
    }
}

/// A heavy strip lifted at its end lies on the plane but for a length `(24 E I h / q)^(1/4)`: there the deflection, slope and
/// moment of a beam vanish at the point where it leaves. Cells 4 long, 2 and 1; each reaches the tolerance, though the strip
/// is 1e8 times as compliant in bending as a cell is in itself.
#[test]
fn a_heavy_strip_lifted_at_its_end_is_certified_on_both_paths() {
    let (young, weight, height): (f64, f64, f64) = (210e3, 0.018_028_846_153_846_156, 0.1);
    let lifted = (24.0 * young / 12.0 * height / weight).powf(0.25);
    for (cells, path) in [(30, "dense"), (60, "dense"), (120, "dense"), (60, "solves"), (60, "multigrid")] {
        let run = case_run::solved(&format!(
            r#"
[mesh]
block = {{ size = [120, 1, 1], cells = [{cells}, 1, 1], element = "hex20" }}
[materials.steel]
young = {young}
poisson = 0
density = 1
[[fix]]
on = {{ box = [[0, 0, 0], [120, 1, 1]] }}
components = "y"
[[fix]]
on = "x-max"
components = "x"
[[fix]]
on = {{ box = [[0, 0, 0], [0, 1, 0]] }}
components = "z"
value = {height}
[[load]]
gravity = [0, 0, -{weight}]
[[contact]]
on = "z-min"
against = {{ plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }} }}
friction = "none"
[solver]
path = "{path}"
"#
        ));
        assert_eq!(run.0.solution.status, Status::Solved, "{cells} {path}");
        // The first node on the plane beyond the lifted length.
        let open = case_run::displacement(&run)
            .iter()
            .zip(&run.1.mesh.nodes)
            .filter(|(u, x)| x[2] == 0.0 && u[2] > 1e-6 * height)
            .fold(0.0, |far: f64, (_, x)| far.max(x[0]));
        assert!((open - lifted).abs() < 120.0 / f64::from(cells) + 2.0, "{cells} {path}: {open} {lifted}");
    }
}
