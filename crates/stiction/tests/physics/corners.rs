//! Contact pairs that meet at an edge: its nodes carry two points, `Q` is singular and forces are not unique. With
//! friction on both pairs of a shared edge the solver does not always converge (`docs/limits.md`).

use stiction::contact::{Obstacle, SurfaceFriction};
use stiction::mesh::BlockElement;
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

#[test]
fn a_bonded_wall_and_a_floor_with_friction_are_certified() {
    let case = block_of([1.0; 3], [4; 3], BlockElement::Hex8, 1e9, 0.3)
        .fix("z-max", [Some(1e-4), Some(0.0), Some(-1e-3)])
        .contact("z-min", FLOOR, SurfaceFriction::Coulomb(0.3))
        .contact("x-min", WALL, SurfaceFriction::Bonded);
    assert_all_solved(vec![("bonded".into(), below_the_top(case))]);
}
