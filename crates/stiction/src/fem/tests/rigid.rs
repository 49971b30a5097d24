//! Which rigid motions are left free, against cases anyone can picture.

use super::*;

/// What is left free when each listed component of each listed node is constrained.
fn unconstrained(mesh: &Mesh, constrained: &[(Vec<u32>, [bool; 3])]) -> Vec<Unconstrained> {
    let fix = |(nodes, constrained): &(Vec<u32>, [bool; 3])| Fix {
        nodes: nodes.clone(),
        value: constrained.map(|constrained| constrained.then_some(Field::Constant(0.0))),
        ..Fix::default()
    };
    let fixes: Vec<Fix> = constrained.iter().map(fix).collect();
    let dofs = dof_map(mesh, &fixes, 0.0).unwrap();
    let unconstrained = unconstrained_motions(mesh, &dofs, &vec![0; mesh.nodes.len()]);
    // Whatever is called free must leave the constrained components alone.
    for motion in unconstrained.iter().flat_map(|unconstrained| &unconstrained.motions) {
        for &dof in &dofs.prescribed {
            let moved = displacement(motion, mesh.nodes[dof as usize / 3])[dof as usize % 3];
            assert!(moved.abs() < 1e-11, "{motion} moves a constrained node by {moved:e}");
        }
    }
    unconstrained
}

/// Displacement of the point `x` under the unit motion.
fn displacement(motion: &Motion, x: [f64; 3]) -> [f64; 3] {
    match *motion {
        Motion::Translation { along } => along,
        Motion::Rotation { along, through, advance } => {
            v3::add(v3::cross(along, v3::sub(x, through)), v3::scale(advance, along))
        }
    }
}

fn names(unconstrained: &[Unconstrained]) -> Vec<String> {
    unconstrained.iter().flat_map(|unconstrained| unconstrained.motions.iter().map(Motion::to_string)).collect()
}

fn block() -> Mesh {
    brick(CellKind::Tet4, [2, 2, 2], [2.0, 1.0, 1.0])
}

#[test]
fn a_clamped_face_holds_the_body() {
    let mesh = block();
    assert!(unconstrained(&mesh, &[(nodes_where(&mesh, |x| x[0] == 0.0), [true; 3])]).is_empty());
}

#[test]
fn an_unsupported_body_is_not_held_at_all() {
    let found = unconstrained(&block(), &[]);
    assert_eq!((found[0].body, found[0].motions.len()), (0, 6));
}

#[test]
fn symmetry_planes_normal_to_x_and_y_leave_the_translation_along_z() {
    let mesh = block();
    let x = (nodes_where(&mesh, |x| x[0] == 0.0), [true, false, false]);
    let y = (nodes_where(&mesh, |x| x[1] == 0.0), [false, true, false]);
    let found = unconstrained(&mesh, &[x, y]);
    assert_eq!((found[0].body, names(&found)), (0, vec!["translation along z".to_string()]));
}

#[test]
fn a_smooth_floor_leaves_three_motions_of_the_plane() {
    let mesh = block();
    let found = unconstrained(&mesh, &[(nodes_where(&mesh, |x| x[2] == 0.0), [false, false, true])]);
    let about_z = "rotation about the axis along z through (1, 0.5, 0.5)";
    assert_eq!(names(&found), ["translation along x", "translation along y", about_z]);
}

#[test]
fn one_held_node_leaves_three_rotations_through_it() {
    let found = unconstrained(&block(), &[(vec![0], [true; 3])]);
    let names = names(&found);
    assert_eq!(names.len(), 3);
    // Each axis runs through the origin; named is its point nearest to the centre (1, 0.5, 0.5).
    assert_eq!(names[0], "rotation about the axis along x through (1, 0, 0)");
    assert_eq!(names[1], "rotation about the axis along y through (0, 0.5, 0)");
    assert_eq!(names[2], "rotation about the axis along z through (0, 0, 0.5)");
}

#[test]
fn a_hinge_on_a_diagonal_is_named_by_its_direction() {
    let mesh = brick(CellKind::Hex8, [2, 2, 2], [1.0; 3]);
    let found = unconstrained(&mesh, &[(nodes_where(&mesh, |x| x[0] == x[1] && x[2] == 0.0), [true; 3])]);
    let name = "rotation about the axis along (0.707107, 0.707107, 0) through (0.5, 0.5, 0)";
    assert_eq!(names(&found), [name]);
}

#[test]
fn a_screw_is_named_with_its_advance() {
    // About the centre of a cube of side 2 the motion (z + 1, 1 - z, y - x) turns about (1, 1, 0) and advances by one
    // per radian. Its x vanishes on the floor, its y on the top and its z where x = y; nothing else does all three.
    let mesh = brick(CellKind::Hex8, [2, 2, 2], [2.0; 3]);
    let floor = (nodes_where(&mesh, |x| x[2] == 0.0), [true, false, false]);
    let top = (nodes_where(&mesh, |x| x[2] == 2.0), [false, true, false]);
    let diagonal = (nodes_where(&mesh, |x| x[0] == x[1]), [false, false, true]);
    let name = "rotation about the axis along (0.707107, 0.707107, 0) through (1, 1, 1), combined with a translation \
                along it of 1 per radian";
    assert_eq!(names(&unconstrained(&mesh, &[floor, top, diagonal])), [name]);
}

#[test]
fn a_turn_about_an_axis_far_away_is_described_as_a_translation() {
    // A body of radius 2 at (10, 0, 0) that turns about an axis along y through (10, 0, -distance) moves along x there.
    let (omega, centre) = ([0.0, 1.0, 0.0], [10.0, 0.0, 0.0]);
    let told = |distance: f64| Motion::of([0.0; 3], omega, [10.0, 0.0, -distance], centre, 2.0).to_string();
    assert_eq!(told(1e3), "translation along x");
    assert_eq!(told(1e2), "rotation about the axis along y through (10, 0, -100)");
}

#[test]
fn each_body_is_judged_alone() {
    let mut mesh = block();
    let second = brick(CellKind::Tet4, [1, 1, 1], [1.0; 3]);
    let count = mesh.nodes.len() as u32;
    mesh.nodes.extend(second.nodes.iter().map(|x| v3::add(*x, [5.0, 0.0, 0.0])));
    mesh.cells[0].nodes.extend(second.cells[0].nodes.iter().map(|i| i + count));
    let fix = Fix {
        nodes: nodes_where(&mesh, |x| x[0] == 0.0),
        value: [0.0; 3].map(|v| Some(Field::Constant(v))),
        ..Fix::default()
    };
    let dofs = dof_map(&mesh, &[fix], 0.0).unwrap();
    let body: Vec<u32> = (0..mesh.nodes.len() as u32).map(|i| (i >= count) as u32).collect();
    let found = unconstrained_motions(&mesh, &dofs, &body);
    assert_eq!(found.len(), 1);
    assert_eq!((found[0].body, found[0].motions.len()), (1, 6));
}

#[test]
fn the_decision_depends_neither_on_units_nor_on_a_far_origin() {
    let mut mesh = block();
    for x in &mut mesh.nodes {
        *x = v3::add(v3::scale(1e-6, *x), [1e-3, 0.0, 0.0]);
    }
    let floor = nodes_where(&mesh, |x| x[2] == 0.0);
    assert_eq!(unconstrained(&mesh, &[(floor.clone(), [false, false, true])])[0].motions.len(), 3);
    assert!(unconstrained(&mesh, &[(floor, [true; 3])]).is_empty());
}
