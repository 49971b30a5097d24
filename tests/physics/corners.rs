//! Contacts with obstacles that meet at an edge: its nodes carry two points, `Q` is singular and forces are not unique.

use stiction::contact::{Obstacle, SurfaceFriction};
use stiction::mesh::BlockElement;
use stiction::run::{Outcome, Prepared, Totals, pair_totals};
use stiction_fixtures::case_run::{displacement, solved};
use stiction_fixtures::*;

const WALL: Obstacle = Obstacle::Plane { point: [0.0; 3], normal: [1.0, 0.0, 0.0] };

/// A block in a corner, its top moved by `top`.
fn cornered(element: BlockElement, n: usize, top: [f64; 3], friction: SurfaceFriction) -> Case {
    let case = block_of([1.0; 3], [n; 3], element, 1e9, 0.3).fix("z-max", top.map(Some));
    below_the_top(case.contact("z-min", FLOOR, friction.clone()).contact("x-min", WALL, friction))
}

/// The last wall without the faces at the moved top, whose nodes cannot give way.
fn below_the_top(mut case: Case) -> Case {
    let top = case.nodes("z-max");
    let mesh = &case.mesh;
    let wall = &mut case.surfaces.last_mut().unwrap().faces;
    wall.retain(|&f| mesh.faces[f as usize].nodes().iter().all(|n| !top.contains(n)));
    case
}

fn assert_all_solved(cases: Vec<(String, Case)>) {
    let mut failed = Vec::new();
    for (name, case) in cases {
        let p = case.pose().problem;
        let s = attempt(&p, &settings(1e-8));
        println!("{name}: {:?} {:?} worst {:.1e}", s.status, s.counts, s.certificate.worst);
        if !s.certificate.passed {
            failed.push(format!("{name}: {:?} {:?} {:?}", s.status, s.counts, s.certificate.measures()));
        }
    }
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}

const PUSHES: [[f64; 3]; 4] = [[-1e-3, 0.0, -1e-3], [-1e-3, 5e-4, -1e-3], [5e-4, 2e-4, -1e-3], [-1e-3, 1e-3, 2e-4]];

#[test]
fn a_block_in_a_corner_without_friction_is_certified() {
    let make = |top| (format!("{top:?}"), cornered(BlockElement::Hex8, 4, top, SurfaceFriction::None));
    assert_all_solved(PUSHES.map(make).into());
}

/// Shared nodes stick, slip, open and change to and fro between a floor and a wall.
#[test]
fn a_block_in_a_corner_with_friction_is_certified() {
    let mut cases = Vec::new();
    for element in [BlockElement::Hex8, BlockElement::Tet4Six, BlockElement::Tet10Six] {
        for coefficient in [0.1, 0.3, 0.8, 1.5] {
            for top in PUSHES {
                let case = cornered(element, 4, top, SurfaceFriction::Coulomb(coefficient));
                cases.push((format!("{element:?} F = {coefficient} {top:?}"), case));
            }
        }
    }
    assert_all_solved(cases);
}

#[test]
fn a_floor_and_a_wall_that_share_no_nodes_are_certified() {
    let mut cases = Vec::new();
    for element in [BlockElement::Hex8, BlockElement::Tet4Six] {
        for coefficient in [0.1, 0.3, 0.8] {
            for top in PUSHES {
                let mut case = cornered(element, 4, top, SurfaceFriction::Coulomb(coefficient));
                let floor = case.nodes("z-min");
                let mesh = &case.mesh;
                case.surfaces[1].faces.retain(|&f| mesh.faces[f as usize].nodes().iter().all(|n| !floor.contains(n)));
                cases.push((format!("{element:?} F = {coefficient} {top:?}"), case));
            }
        }
    }
    assert_all_solved(cases);
}

/// A block of 20 mm that its loads press into a corner of planes, `walls` of x, y and z; its modulus is a thousand times what loads it.
fn loose(element: &str, cells: usize, walls: &str, coefficient: f64) -> String {
    let traction = ["x", "y", "z"].map(|axis| if walls.contains(axis) { -1.0 } else { 0.0 });
    let [x, y] = [2.0 * traction[0], traction[1]];
    let mut text = format!(
        "[mesh]\nblock = {{ size = [20, 20, 20], cells = [{cells}, {cells}, {cells}], element = \"{element}\" }}\n\
         [materials.m]\nyoung = 5000\npoisson = 0.3\n[[load]]\non = \"z-max\"\ntraction = [{x}, {y}, -5]\n"
    );
    if !walls.contains('y') {
        text += "[[fix]]\non = \"y-min\"\ncomponents = \"y\"\n";
    }
    for (axis, normal) in [("x", [1, 0, 0]), ("y", [0, 1, 0]), ("z", [0, 0, 1])] {
        if walls.contains(axis) {
            text += &format!(
                "[[contact]]\nname = \"{axis}\"\non = \"{axis}-min\"\nfriction = {{ coulomb = {coefficient} }}\n\
                 against = {{ plane = {{ point = [0, 0, 0], normal = {normal:?} }} }}\n"
            );
        }
    }
    text
}

/// Without what makes the steps of shared nodes unique none of these is solved; with it they take 6 to 17 steps.
#[test]
fn a_loose_block_that_is_pressed_into_a_corner_takes_few_steps() {
    for (element, cells) in [("hex8", 8), ("tet4", 8), ("tet10", 4), ("hex20", 4)] {
        for (walls, coefficient) in [("xz", 0.3), ("xz", 0.9), ("xyz", 0.1), ("xyz", 0.3), ("xyz", 0.9)] {
            let run = solved(&loose(element, cells, walls, coefficient));
            let steps = run.0.solution.counts.newton_steps;
            assert!(steps <= 24, "{element} {walls} {coefficient}: {steps} steps");
        }
    }
}

/// A point that sticks to the floor and one that is to move to the wall, on one node, contradict one another however near the wall is.
/// The answer depends on its distance continuously.
#[test]
fn a_wall_that_is_a_hair_away_is_as_one_that_touches() {
    for element in ["hex8", "tet4"] {
        let run = |away: f64| {
            let text = format!(
                "[mesh]\nblock = {{ size = [2, 2, 1], cells = [4, 4, 2], element = \"{element}\" }}\n\
                 [materials.m]\nyoung = 1e3\npoisson = 0.3\n[[load]]\non = \"x-max\"\ntraction = [-8, 0, 0]\n\
                 [[load]]\non = \"z-max\"\ntraction = [0, 1, -6]\n\
                 [[contact]]\nname = \"z\"\non = \"z-min\"\nfriction = {{ coulomb = 0.3 }}\n\
                 against = {{ plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }} }}\n\
                 [[contact]]\nname = \"x\"\non = \"x-min\"\nfriction = {{ coulomb = 0.3 }}\n\
                 against = {{ plane = {{ point = [{}, 0, 0], normal = [1, 0, 0] }} }}\n",
                -away
            );
            displacement(&solved(&text))
        };
        let touching = run(0.0);
        let largest = touching.iter().flatten().fold(0.0, |a: f64, u| a.max(u.abs()));
        for away in [1e-11, 1e-10, 1e-8, 1e-7, 1e-6] {
            let apart = run(away)
                .iter()
                .zip(&touching)
                .flat_map(|(a, b)| (0..3).map(move |i| (a[i] - b[i]).abs()))
                .fold(0.0, f64::max);
            println!("{element} {away}: {apart:.1e}");
            assert!(apart <= 10.0 * away + 1e-7 * largest, "{element} {away}: {apart:e}");
        }
    }
}

fn totals(run: &(Outcome, Prepared), pair: &str) -> Totals {
    pair_totals(&run.1, &run.0).into_iter().find(|(name, _)| name == pair).unwrap().1
}

/// Dragged a hundred times as far along the edge as it deforms everything slips along it: friction is the coefficient times what
/// presses, and that of shared nodes counts whole (Coulomb's law).
#[test]
fn a_block_that_is_dragged_along_the_edge_of_a_corner_has_all_its_friction_against_it() {
    for element in ["hex8", "tet10"] {
        let held = "[[fix]]\non = \"y-min\"\ncomponents = \"y\"\n";
        let dragged = "[[fix]]\non = \"z-max\"\nvalue = [-0.02, 4, -0.03]\n[[load]]\non = \"x-max\"\npressure = 20\n";
        // The wall is where the top is moved to: nodes there touch it and are not pushed into it.
        let corner = loose(element, 4, "xz", 0.3)
            .replace(held, dragged)
            .replace("point = [0, 0, 0], normal = [1, 0, 0]", "point = [-0.02, 0, 0], normal = [1, 0, 0]");
        let run = solved(&corner);
        for pair in ["x", "z"] {
            let Totals { normal_force, tangential_force, slip_area, .. } = totals(&run, pair);
            assert!(normal_force > 500.0 && slip_area > 300.0, "{element} {pair}: {normal_force} on {slip_area}");
            assert!((tangential_force[1] / normal_force + 0.3).abs() < 1e-4, "{element} {pair}: {tangential_force:?}");
        }
    }
}

/// Nothing slips where all-round pressure hardly strains a body: a corner then holds it as if it were glued there.
#[test]
fn a_block_that_sticks_in_a_corner_is_as_one_that_is_held_there() {
    for cells in [3, 4, 6] {
        let pressed = |text: String| {
            let around = "[[load]]\non = [\"x-max\", \"y-max\", \"z-max\"]\npressure = 5\n";
            text.replace("poisson = 0.3", "poisson = 0.45").replace("traction = ", "traction = [0, 0, 0] # ") + around
        };
        let sticking = pressed(loose("hex8", cells, "xz", 4.0));
        let held = pressed(loose("hex8", cells, "", 0.0)) + "[[fix]]\non = [\"x-min\", \"z-min\"]\n";
        let [sticking, held] = [sticking, held].map(|text| displacement(&solved(&text)));
        let largest = held.iter().flatten().fold(0.0, |a: f64, u| a.max(u.abs()));
        for (a, b) in sticking.iter().zip(&held) {
            (0..3).for_each(|i| assert!((a[i] - b[i]).abs() < 1e-6 * largest, "{cells} cells: {a:?} and {b:?}"));
        }
    }
}

#[test]
fn a_bonded_wall_and_a_floor_with_friction_are_certified() {
    let case = block_of([1.0; 3], [4; 3], BlockElement::Hex8, 1e9, 0.3)
        .fix("z-max", [Some(1e-4), Some(0.0), Some(-1e-3)])
        .contact("z-min", FLOOR, SurfaceFriction::Coulomb(0.3))
        .contact("x-min", WALL, SurfaceFriction::Bonded);
    assert_all_solved(vec![("bonded".into(), below_the_top(case))]);
}
