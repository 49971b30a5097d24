//! Numbers found by other programs: cross-checked with GetFEM 5.4.2 and an independent condensation code (without
//! friction also with Kratos), node-wise contact on 24 x 8 x 8 cells.

use stiction::contact::{Obstacle, SurfaceFriction};
use stiction::friction::{PointState, Solution};
use stiction::mesh::BlockElement;
use stiction_fixtures::*;

fn largest_displacement(posed: &Posed, s: &Solution) -> f64 {
    posed.full(&s.u).iter().map(|u| u.iter().map(|c| c * c).sum::<f64>().sqrt()).fold(0.0, f64::max)
}

fn in_contact(s: &Solution) -> usize {
    s.states.iter().filter(|&&s| s != PointState::Open).count()
}

#[test]
fn the_brick_without_friction_is_that_of_getfem_and_kratos() {
    let posed = brick(8, BlockElement::Tet4Six, BrickLoad::Lift, SurfaceFriction::None).pose();
    let s = solved(&posed.problem, 1e-10);
    assert!((normal_force(&posed.problem, &s.lambda) - 658_695.889).abs() < 1e-3);
    assert!((largest_displacement(&posed, &s) - 2.086_185_08e-4).abs() < 1e-12);
    assert_eq!((posed.problem.points(), in_contact(&s)), (216, 46));
}

#[test]
fn the_brick_with_friction_is_that_of_getfem() {
    let case = brick(8, BlockElement::Tet4Six, BrickLoad::Lift, SurfaceFriction::Coulomb(0.35));
    let posed = case.pose();
    let s = solved(&posed.problem, 1e-10);
    assert!((normal_force(&posed.problem, &s.lambda) - 741_388.885).abs() < 1e-3);
    assert!((friction_on_body(&posed.problem, &s.lambda)[0] + 256_971.789).abs() < 1e-3);
    assert!((largest_displacement(&posed, &s) - 2.036_576_91e-4).abs() < 1e-12);
    assert_eq!(in_contact(&s), 47);
    assert_eq!(s.states.iter().filter(|&&s| s == PointState::Slip).count(), 47);
    // Points follow the nodes of the surface in ascending order, without the clamped end.
    let end = case.nodes("x-min");
    let nodes: Vec<u32> = case.nodes("z-min").into_iter().filter(|n| !end.contains(n)).collect();
    let pressure = |j: usize| s.lambda[j] / posed.problem.labels.area[j];
    let top = (0..posed.problem.points()).max_by(|&a, &b| pressure(a).total_cmp(&pressure(b))).unwrap();
    assert!((pressure(top) - 2.353_366e6).abs() < 1.0, "{}", pressure(top));
    assert_eq!(case.mesh.nodes[nodes[top] as usize], [0.625, 0.0, 0.0]);
}

#[test]
fn the_brick_of_five_tetrahedra_a_cell_is_that_of_getfem() {
    let element = BlockElement::Tet4Five { parity: 1 };
    let p = brick(8, element, BrickLoad::Lift, SurfaceFriction::Coulomb(0.35)).pose().problem;
    let s = solved(&p, 1e-10);
    assert!((normal_force(&p, &s.lambda) - 7.259_282e5).abs() < 0.06, "{}", normal_force(&p, &s.lambda));
}

#[test]
fn a_floor_below_the_brick_given_by_a_normal_of_any_length_is_the_same_floor() {
    let case = brick(4, BlockElement::Tet4Six, BrickLoad::Lift, SurfaceFriction::Coulomb(0.35));
    let mut other = case.clone();
    other.surfaces[0].against = Obstacle::Plane { point: [7.0, -3.0, 0.0], normal: [0.0, 0.0, 0.01] }.into();
    let (a, b) = (solved(&case.pose().problem, 1e-10), solved(&other.pose().problem, 1e-10));
    assert!(distance(&a.lambda, &b.lambda) < 1e-12);
}
