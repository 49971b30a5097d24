//! Posing contact: gaps, overlaps, supports on the contact surface, symmetry.

use stiction::contact::{Obstacle, Side, SurfaceFriction};
use stiction::io::case;
use stiction::mesh::{Block, BlockElement, block};
use stiction::run::prepare;
use stiction_fixtures::*;

const COULOMB: SurfaceFriction = SurfaceFriction::Coulomb(0.3);

fn cube() -> Case {
    block_of([1.0; 3], [4; 3], BlockElement::Hex8, 1e9, 0.3).fix("z-max", HELD)
}

/// Distances of the nodes at the bottom by a formula of the test.
fn expected(case: &Case, distance: impl Fn([f64; 3]) -> f64) -> (f64, f64, usize) {
    let all: Vec<f64> = case.nodes("z-min").iter().map(|&n| distance(case.mesh.nodes[n as usize])).collect();
    let low = all.iter().copied().fold(f64::INFINITY, f64::min);
    let high = all.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    (low, high, all.iter().filter(|&&d| d < 0.0).count())
}

#[test]
fn gaps_and_overlaps_to_round_obstacles_are_those_of_the_formula() {
    let (out, within) = (Side::Outside, Side::Inside);
    type Distance = fn([f64; 3]) -> f64;
    let cases: [(Obstacle, Distance); 5] = [
        (Obstacle::Sphere { center: [0.5, 0.5, -3.0], radius: 2.9, side: out }, |x| {
            ((x[0] - 0.5).powi(2) + (x[1] - 0.5).powi(2) + (x[2] + 3.0).powi(2)).sqrt() - 2.9
        }),
        (Obstacle::Sphere { center: [0.5, 0.5, -3.0], radius: 3.02, side: out }, |x| {
            ((x[0] - 0.5).powi(2) + (x[1] - 0.5).powi(2) + (x[2] + 3.0).powi(2)).sqrt() - 3.02
        }),
        (Obstacle::Sphere { center: [0.5, 0.5, 3.0], radius: 3.05, side: within }, |x| {
            3.05 - ((x[0] - 0.5).powi(2) + (x[1] - 0.5).powi(2) + (x[2] - 3.0).powi(2)).sqrt()
        }),
        (Obstacle::Cylinder { point: [9.0, 0.5, -2.0], axis: [-3.0, 0.0, 0.0], radius: 2.01, side: out }, |x| {
            (x[1] - 0.5).hypot(x[2] + 2.0) - 2.01
        }),
        (Obstacle::Cylinder { point: [0.0, 0.5, 2.0], axis: [1.0, 0.0, 0.0], radius: 2.05, side: within }, |x| {
            2.05 - (x[1] - 0.5).hypot(x[2] - 2.0)
        }),
    ];
    for (obstacle, formula) in cases {
        let case = cube().contact("z-min", obstacle.clone(), COULOMB);
        let posed = case.pose();
        let f = &posed.facts[0];
        let (low, high, overlapping) = expected(&case, formula);
        assert!((f.gap_min - low).abs() < 1e-14 && (f.gap_max - high).abs() < 1e-14, "{obstacle:?} {f:?}");
        assert_eq!((f.points, f.overlapping, f.facing_away, f.clamped), (25, overlapping, 0, 0), "{obstacle:?}");
        assert_eq!(f.overlapping > 0, f.overlapping_area > 0.0);
        assert!(close(f.area, 1.0, 1e-14));
        let least = posed.problem.contact.gap.iter().copied().fold(f64::INFINITY, f64::min);
        assert!((least - low).abs() < 1e-14);
    }
}

#[test]
fn overlapping_points_are_pushed_out_exactly_to_the_surface() {
    let obstacle = Obstacle::Sphere { center: [0.5, 0.5, -3.0], radius: 3.001, side: Side::Outside };
    let p = cube().contact("z-min", obstacle, COULOMB).pose().problem;
    let s = solved(&p, 1e-10);
    let jump = p.contact.B.times(&s.u);
    let deep: Vec<usize> = (0..p.points()).filter(|&j| s.lambda[j] > 0.0).collect();
    assert!(!deep.is_empty());
    assert!(deep.iter().all(|&j| (p.contact.gap[j] - jump[j]).abs() < 1e-12));
}

#[test]
fn a_surface_that_faces_away_is_counted() {
    let above = Obstacle::Plane { point: [0.0, 0.0, -1.0], normal: [0.0, 0.0, -1.0] };
    let posed = cube().contact("z-min", above, COULOMB).pose();
    assert_eq!(posed.facts[0].facing_away, 25);
}

/// An obstacle that no point of a contact can meet is named in a warning: it is on the other side. One that is met is not.
#[test]
fn an_obstacle_whose_normal_points_away_from_the_body_is_warned_of() {
    let warnings = |normal: f64| {
        let text = case_run::block([2.0, 1.0, 1.0], [4, 2, 2], "element = \"hex8\"")
            + "[materials.m]\nyoung = 1e4\npoisson = 0.3\n[[fix]]\non = \"z-max\"\nvalue = [0, 0, -2e-3]\n[[contact]]\non = \"z-min\"\n"
            + &format!(
                "against = {{ plane = {{ point = [0, 0, 0], normal = [0, 0, {normal}] }} }}\nfriction = \"none\"\n"
            );
        prepare(&case::parse(&text, "case.toml", &[]).unwrap()).unwrap().facts.warnings
    };
    assert_eq!(warnings(1.0), [""; 0]);
    let said = warnings(-1.0);
    assert!(
        said.len() == 1 && said[0].contains("all 15 points face away") && said[0].contains("turn its normal"),
        "{said:?}"
    );
}

#[test]
fn clamped_nodes_carry_no_multiplier_and_are_counted() {
    let posed = brick(4, BlockElement::Hex8, BrickLoad::Lift, COULOMB).pose();
    let f = &posed.facts[0];
    assert_eq!((f.clamped, f.points, f.held_along_normal, f.guided), (5, 60, 0, 0));
    assert!(close(f.dropped_area, 1.0 / 8.0, 1e-13));
    assert!((0..180).all(|i| !posed.problem.contact.B.row(i).0.is_empty()));
}

#[test]
fn nodes_on_symmetry_planes_are_guided_and_nodes_held_along_the_normal_dropped() {
    let planes = cube().fix("x-min", [Some(0.0), None, None]).fix("y-min", [None, Some(0.0), None]);
    let posed = planes.contact("z-min", FLOOR, COULOMB).pose();
    let f = &posed.facts[0];
    // 5 + 5 - 1 nodes lie on the two planes.
    assert_eq!((f.guided, f.points, f.clamped), (9, 25, 0));
    let held = cube().fix("x-min", [None, None, Some(0.0)]).contact("z-min", FLOOR, COULOMB).pose();
    let f = &held.facts[0];
    assert_eq!((f.held_along_normal, f.points, f.clamped), (5, 20, 0));
}

#[test]
fn problems_that_cannot_be_posed_are_refused_with_place_and_remedy() {
    let centre = Obstacle::Sphere { center: [0.5, 0.5, 0.0], radius: 0.1, side: Side::Outside };
    let axis = Obstacle::Cylinder { point: [0.0; 3], axis: [0.0, 1.0, 0.0], radius: 0.1, side: Side::Outside };
    let no_normal = Obstacle::Plane { point: [0.0; 3], normal: [0.0; 3] };
    let mut cases: Vec<Case> = [centre, axis, no_normal].map(|o| cube().contact("z-min", o, COULOMB)).into();
    // A clamped edge pushed into the floor; a guided one dragged along it; nothing left free; no faces.
    let loose = || block_of([1.0; 3], [4; 3], BlockElement::Hex8, 1e9, 0.3).contact("z-min", FLOOR, COULOMB);
    cases.push(loose().fix("x-min", [Some(0.0), Some(0.0), Some(-1e-3)]));
    cases.push(loose().fix("x-min", [Some(1e-3), None, None]));
    cases.push(cube().fix("z-min", HELD).contact("z-min", FLOOR, COULOMB));
    let mut none = cube().contact("z-min", FLOOR, COULOMB);
    none.surfaces[0].faces.clear();
    cases.push(none);
    for case in cases {
        let error = case.try_pose().map(|_| ()).unwrap_err();
        assert!(error.place.contains("z-min") && !error.remedy.is_empty(), "{error}");
    }
}

#[test]
fn bonded_nodes_that_are_prescribed_to_move_are_refused() {
    // Held along the normal with one tangential component, guided, and clamped.
    let moves = [
        [Some(0.0), None, Some(1e-3)],
        [Some(1e-3), None, Some(0.0)],
        [Some(1e-3), None, None],
        [None, None, Some(-1e-3)],
        [Some(0.0), Some(1e-3), Some(0.0)],
    ];
    for value in moves {
        let case = block_of([1.0; 3], [4; 3], BlockElement::Hex8, 1e9, 0.3).fix("x-min", value);
        let error = case.contact("z-min", FLOOR, SurfaceFriction::Bonded).try_pose().map(|_| ()).unwrap_err();
        let words = [&error.what, &error.remedy].map(String::as_str).join(" ");
        assert!(error.place.contains("z-min"), "{error}");
        assert!(["node 1 at [0.0, 0.0, 0.0]", "0.001", "prescribe zero"].iter().all(|w| words.contains(w)), "{error}");
    }
}

#[test]
fn bonded_nodes_held_in_part_are_the_same_as_fixed_ones() {
    for value in [[Some(0.0), None, Some(0.0)], [None, None, Some(0.0)], [Some(0.0), None, None]] {
        let pushed = || cube().fix("x-min", value).traction("x-max", [1e6, 5e5, -2e6]);
        let bonded = pushed().contact("z-min", FLOOR, SurfaceFriction::Bonded).pose();
        let tied = bonded.full(&solved(&bonded.problem, 1e-11).u);
        // Contact that never closes: the second is an elastic body on supports.
        let far = Obstacle::Plane { point: [9.0, 0.0, 0.0], normal: [-1.0, 0.0, 0.0] };
        let fixed = pushed().fix("z-min", HELD).contact("x-max", far, SurfaceFriction::None).pose();
        let held = fixed.full(&solved(&fixed.problem, 1e-11).u);
        assert!(distance(tied.as_flattened(), held.as_flattened()) < 1e-9, "{value:?}");
    }
}

/// A block whose top is pushed down on an obstacle symmetric about x = 1 and y = 1; the whole of
/// it or the quarter beyond the two planes.
fn pressed(quarter: bool, obstacle: Obstacle) -> Case {
    let side = if quarter { 1.0 } else { 2.0 };
    let cells = if quarter { [3, 3, 2] } else { [6, 6, 2] };
    let origin = if quarter { [1.0, 1.0, 0.0] } else { [0.0; 3] };
    let size = [side, side, 1.0];
    let mesh = block(&Block { size, cells, origin, grading: [1.0; 3], element: BlockElement::Hex8 }).unwrap();
    let case = Case { mesh, ..block_of([1.0; 3], [1; 3], BlockElement::Hex8, 1e9, 0.4) };
    let case = case.fix("z-max", [Some(0.0), Some(0.0), Some(-0.02)]).contact("z-min", obstacle, COULOMB);
    if !quarter {
        return case;
    }
    case.fix("x-min", [Some(0.0), None, None]).fix("y-min", [None, Some(0.0), None])
}

#[test]
fn a_quarter_with_symmetry_planes_carries_the_same_forces_as_the_whole() {
    let sphere = Obstacle::Sphere { center: [1.0, 1.0, -20.0], radius: 20.0, side: Side::Outside };
    let cylinder =
        Obstacle::Cylinder { point: [1.0, 1.0, -20.0], axis: [0.0, 1.0, 0.0], radius: 20.0, side: Side::Outside };
    for obstacle in [FLOOR, sphere, cylinder] {
        let (whole, quarter) = (pressed(false, obstacle.clone()), pressed(true, obstacle.clone()));
        let forces = |case: &Case| {
            let posed = case.pose();
            let p = &posed.problem;
            let s = solved(p, 1e-11);
            // Contact force per area in space, by the place of the node.
            let force = p.contact.B.transpose_times(&s.lambda);
            let mut at_node = vec![[0.0; 3]; case.mesh.nodes.len()];
            posed.model.dofs.free.iter().zip(&force).for_each(|(&d, f)| at_node[d as usize / 3][d as usize % 3] = *f);
            let nodes = case.nodes("z-min");
            assert_eq!(nodes.len(), p.points());
            let per_area = |(&n, a): (&u32, &f64)| (case.mesh.nodes[n as usize], at_node[n as usize].map(|f| f / a));
            nodes.iter().zip(&p.labels.area).map(per_area).collect::<Vec<_>>()
        };
        let (all, part) = (forces(&whole), forces(&quarter));
        let largest = all.iter().flat_map(|(_, f)| f).fold(0.0, |a: f64, f| a.max(f.abs()));
        assert!(largest > 0.0);
        for (x, f) in part {
            let near = |y: &[f64; 3]| (0..3).all(|c| (x[c] - y[c]).abs() < 1e-9);
            let (_, g) = all.iter().find(|(y, _)| near(y)).unwrap();
            // On a plane of symmetry of the quarter its support carries what lies across the plane.
            for c in (0..3).filter(|&c| c == 2 || x[c] > 1.0 + 1e-9) {
                assert!((f[c] - g[c]).abs() < 1e-8 * largest, "{obstacle:?} {x:?} {f:?} {g:?}");
            }
        }
    }
}
