//! Contact between two surfaces with different meshes.

mod common;

use std::ops::ControlFlow;

use stiction::contact::{ContactProblem, ContactSurface, Counterpart, InitialGap, Master, Reason, Role, SurfaceFriction, pose};
use stiction::fem::{Field, Fix, Formulation, Load, Material, Solid, assemble, full_displacement};
use stiction::friction::Status;
use stiction::io::case;
use stiction::mesh::{Block, BlockElement, Mesh, Turn, block, join, place};
use stiction::run::{Outcome, Prepared, Settings, prepare, solve};

use common::{distance, solved};

type V3 = [f64; 3];

fn part(size: V3, cells: [usize; 3], origin: V3, element: BlockElement) -> Mesh {
    block(&Block { size, cells, origin, grading: [1.0; 3], element }).unwrap()
}

/// A block on another of other cells, `a.z-max` against `b.z-min` at `z = 1`, `over` wider than the lower one.
fn stack(cells: [[usize; 3]; 2], elements: [BlockElement; 2], over: f64) -> Mesh {
    let low = part([1.0; 3], cells[0], [0.0; 3], elements[0]);
    let top = part([1.0 + over, 1.0 + over, 0.8], cells[1], [-over / 3.0, -over / 2.0, 1.0], elements[1]);
    join(vec![("a".into(), low), ("b".into(), top)])
}

const TET: BlockElement = BlockElement::Tet4Five { parity: 0 };
const HEX: BlockElement = BlockElement::Hex8;
const SKEW: Turn = Turn { point: [0.3, -0.2, 0.9], axis: [2.0 / 7.0, 3.0 / 7.0, 6.0 / 7.0], degrees: 30.0 };

fn faces(mesh: &Mesh, group: &str) -> Vec<u32> {
    mesh.group(group).unwrap().faces.clone()
}

fn pair(mesh: &Mesh, slave: &str, master: &str, friction: SurfaceFriction) -> ContactSurface {
    let (gap, reason) = (InitialGap::AsMeshed, Reason::Asked);
    let master = Master { faces: faces(mesh, master), gap, search: None, slave: Role::On, reason };
    ContactSurface { name: slave.into(), faces: faces(mesh, slave), against: Counterpart::Surface(master), friction }
}

/// `u(x) = a x + b`, as prescribed displacements.
#[derive(Clone, Copy)]
struct Linear {
    a: [V3; 3],
    b: V3,
}

impl Linear {
    fn at(&self, x: V3) -> V3 {
        [0, 1, 2].map(|i| self.b[i] + (0..3).map(|j| self.a[i][j] * x[j]).sum::<f64>())
    }

    fn fix(self, mesh: &Mesh, group: &str) -> Fix {
        let component = |i: usize| {
            let value = std::sync::Arc::new(move |x: V3, _| self.at(x)[i]);
            Some(Field::Function { text: "in the test".into(), value })
        };
        Fix { nodes: mesh.face_nodes(&faces(mesh, group)), value: [0, 1, 2].map(component) }
    }

    /// The stress of a body with these constants.
    fn stress(&self, young: f64, poisson: f64) -> [V3; 3] {
        let strain = |i: usize, j: usize| 0.5 * (self.a[i][j] + self.a[j][i]);
        let trace: f64 = (0..3).map(|i| self.a[i][i]).sum();
        let (mu, lambda) = (young / (2.0 + 2.0 * poisson), young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)));
        [0, 1, 2].map(|i| [0, 1, 2].map(|j| 2.0 * mu * strain(i, j) + if i == j { lambda * trace } else { 0.0 }))
    }
}

const YOUNG: f64 = 2e11;
const POISSON: f64 = 0.3;

fn posed(mesh: &Mesh, fixes: &[Fix], loads: &[Load], surfaces: &[ContactSurface]) -> (ContactProblem, Posed) {
    let formulation = Formulation::Full;
    let materials = [Material { name: "m".into(), young: YOUNG, poisson: POISSON, density: 0.0, formulation }];
    let material_of_cell = vec![0; mesh.cell_count()];
    let solid = Solid { mesh, materials: &materials, material_of_cell: &material_of_cell };
    let mut model = assemble(&solid, loads, fixes, 1.0).unwrap();
    let (problem, facts) = pose(mesh, &mut model, surfaces).unwrap();
    problem.validate().unwrap();
    (problem, Posed { model, facts })
}

struct Posed {
    model: stiction::fem::FeModel,
    facts: Vec<stiction::contact::SurfaceFacts>,
}

/// Moves some nodes inside the interface `z = 1` (and above) so that faces are no parallelograms.
fn distort(mesh: &mut Mesh) {
    for x in &mut mesh.nodes {
        let inside = (0..2).all(|c| x[c] > 1e-9 && x[c] < 1.0 - 1e-9);
        if inside && (x[2] - 1.0).abs() < 1e-9 {
            let [p, q] = [x[0], x[1]];
            x[0] += 0.06 * (7.0 * q).sin();
            x[1] += 0.05 * (9.0 * p).cos();
        }
    }
}

/// Linear fields, rigid motions among them, do not open a flat interface nor slide on it, whatever the meshes, how much
/// of each face is covered, and which nodes are dropped.
#[test]
fn a_linear_field_is_no_jump_on_a_flat_interface() {
    let field = Linear { a: [[0.3, -0.2, 0.7], [0.1, 0.5, -0.9], [-0.4, 0.8, 0.6]], b: [0.1, -0.7, 0.4] };
    for (elements, over) in [([TET, HEX], 0.0), ([HEX, TET], 0.3), ([HEX, HEX], 0.17), ([TET, TET], 0.41)] {
        let mut mesh = stack([[3, 4, 2], [4, 3, 2]], elements, over);
        distort(&mut mesh);
        place(&mut mesh, Some(&SKEW), [0.1, 0.2, 0.3]);
        for (slave, master) in [("a.z-max", "b.z-min"), ("b.z-min", "a.z-max")] {
            let fixes = [field.fix(&mesh, "a.z-min"), field.fix(&mesh, "b.z-max"), field.fix(&mesh, "a.x-min")];
            let surfaces = [pair(&mesh, slave, master, SurfaceFriction::Coulomb(0.3))];
            let (problem, Posed { model, facts }) = posed(&mesh, &fixes, &[], &surfaces);
            let u: Vec<f64> =
                model.dofs.free.iter().map(|&d| field.at(mesh.nodes[d as usize / 3])[d as usize % 3]).collect();
            let opening = problem.opening(&u);
            let worst = opening.iter().fold(0.0, |a: f64, v| a.max(v.abs()));
            assert!(worst < 3e-13, "{elements:?} {over} {slave}: {worst:e}");
            assert!(problem.points() > 8);
            if slave == "a.z-max" {
                let pair = facts[0].pair.as_ref().unwrap();
                assert!((pair.covered_area - 1.0).abs() < 1e-12 && facts[0].clamped == 5 && pair.uncovered == 0);
            }
        }
    }
}

/// A pressure of one on the whole interface, dropped nodes included, is the load of a constant traction on both bodies.
#[test]
fn a_constant_pressure_is_carried_past_dropped_nodes() {
    let mut mesh = stack([[3, 4, 2], [4, 3, 2]], [TET, HEX], 0.0);
    place(&mut mesh, Some(&SKEW), [0.0; 3]);
    let zero = Linear { a: [[0.0; 3]; 3], b: [0.0; 3] };
    let fixes = [zero.fix(&mesh, "a.z-min"), zero.fix(&mesh, "b.z-max"), zero.fix(&mesh, "a.x-min")];
    let (problem, Posed { model, facts }) =
        posed(&mesh, &fixes, &[], &[pair(&mesh, "a.z-max", "b.z-min", SurfaceFriction::None)]);
    assert_eq!(facts[0].clamped, 5);
    let m = problem.points();
    let mut lambda = vec![0.0; 3 * m];
    lambda[..m].copy_from_slice(&problem.area);
    let mut force = vec![[0.0; 3]; mesh.nodes.len()];
    let free = problem.B.transpose_times(&lambda).into_iter().zip(&model.dofs.free);
    let held = problem.supports.as_ref().unwrap().B.transpose_times(&lambda).into_iter().zip(&model.dofs.prescribed);
    free.chain(held).for_each(|(f, &dof)| force[dof as usize / 3][dof as usize % 3] = f);
    for (group, sign) in [("a.z-max", 1.0), ("b.z-min", -1.0)] {
        let normal = mesh.face_normal(faces(&mesh, group)[0] as usize);
        for (node, area) in stiction::fem::nodal_areas(&mesh, &faces(&mesh, group)) {
            // On the master the normal is the opposite one, and so is the force.
            let n = normal.map(|c| c * area);
            let f = force[node as usize];
            assert!((0..3).all(|c| (f[c] - n[c]).abs() < 1e-13), "{group} {node} {sign}: {f:?} {n:?}");
        }
    }
    let total: f64 = (0..m).map(|j| problem.share[j] * lambda[j]).sum();
    assert!((total - 1.0).abs() < 1e-13);
}

#[test]
fn matching_meshes_are_tied_node_by_node() {
    let mut mesh = stack([[3, 3, 2], [3, 3, 2]], [HEX, HEX], 0.0);
    place(&mut mesh, Some(&SKEW), [0.0; 3]);
    let zero = Linear { a: [[0.0; 3]; 3], b: [0.0; 3] };
    let fixes = [zero.fix(&mesh, "a.z-min"), zero.fix(&mesh, "b.z-max")];
    let (problem, Posed { model, facts }) =
        posed(&mesh, &fixes, &[], &[pair(&mesh, "a.z-max", "b.z-min", SurfaceFriction::None)]);
    assert_eq!(problem.points(), 16);
    let spread = stiction::fem::nodal_areas(&mesh, &faces(&mesh, "a.z-max"));
    for j in 0..16 {
        let (columns, values) = problem.B.row(j);
        assert_eq!(columns.len(), 6);
        let of = |k: usize| model.dofs.free[columns[k] as usize] as usize;
        assert_eq!(of(0) / 3, facts[0].nodes[j] as usize);
        assert!((0..3).all(|c| values[c] == -values[3 + c]), "{values:?}");
        let away = (0..3).map(|c| (mesh.nodes[of(0) / 3][c] - mesh.nodes[of(3) / 3][c]).abs()).fold(0.0, f64::max);
        assert!(away < 1e-14 && problem.gap[j].abs() < 1e-14 && (problem.area[j] - spread[j].1).abs() < 1e-14);
    }
}

/// Uniform stress in two bodies whose meshes do not match, across a tilted interface (Taylor & Papadopoulos 1991).
///
/// Both ends follow a linear displacement, the sides carry its stress; the interface must pass it on to the last digits,
/// with the friction that its shear needs, or tied.
#[test]
fn patch_tests_pass_in_contact_and_bonded() {
    // Shears the blocks, so that the interface is tilted against their sides.
    let tilt = |mesh: &mut Mesh| mesh.nodes.iter_mut().for_each(|x| x[2] += 0.3 * x[0] + 0.2 * x[1]);
    let pressed = Linear { a: [[3e-5, 2e-5, 0.0], [0.0, 2e-5, 1e-5], [1e-5, 0.0, -2e-4]], b: [1e-4, 0.0, -2e-4] };
    let pulled = Linear { a: [[0.0, 1e-4, 2e-4], [0.0, 0.0, -1e-4], [0.0, 5e-5, 3e-4]], b: [0.0; 3] };
    for (field, friction) in [(pressed, SurfaceFriction::Coulomb(2.0)), (pressed, SurfaceFriction::Bonded), (pulled, SurfaceFriction::Bonded)]
    {
        for (elements, sided) in [([TET, HEX], false), ([HEX, TET], true), ([HEX, HEX], true)] {
            for (slave, master) in [("a.z-max", "b.z-min"), ("b.z-min", "a.z-max")] {
                let mut mesh = stack([[3, 4, 3], [4, 3, 2]], elements, 0.0);
                tilt(&mut mesh);
                place(&mut mesh, Some(&SKEW), [0.0; 3]);
                let stress = field.stress(YOUNG, POISSON);
                let mut fixes = vec![field.fix(&mesh, "a.z-min"), field.fix(&mesh, "b.z-max")];
                let mut loads = Vec::new();
                for side in ["x-min", "x-max", "y-min", "y-max"].iter().flat_map(|s| [format!("a.{s}"), format!("b.{s}")]) {
                    if sided && side.ends_with("x-min") {
                        fixes.push(field.fix(&mesh, &side)); // slave nodes are prescribed here
                        continue;
                    }
                    let faces = faces(&mesh, &side);
                    let n = mesh.face_normal(faces[0] as usize);
                    let value = stress.map(|row| Field::Constant((0..3).map(|c| row[c] * n[c]).sum()));
                    loads.push(Load::Traction { faces, value });
                }
                let (problem, Posed { model, facts }) =
                    posed(&mesh, &fixes, &loads, &[pair(&mesh, slave, master, friction)]);
                let solution = solved(&problem, 1e-10);
                let u = full_displacement(&model, &solution.u);
                let exact: Vec<f64> = mesh.nodes.iter().flat_map(|&x| field.at(x)).collect();
                let wrong = distance(&u, &exact);
                assert!(wrong < 1e-10, "{friction:?} {elements:?} {slave} {sided}: {wrong:e}");
                // The traction on the interface is that of the stress.
                let n = mesh.face_normal(faces(&mesh, slave)[0] as usize);
                let traction = stress.map(|row| (0..3).map(|c| row[c] * n[c]).sum::<f64>());
                let normal: f64 = (0..3).map(|c| -traction[c] * n[c]).sum();
                let m = problem.points();
                for j in 0..m {
                    let pressure = solution.lambda[j] / problem.area[j];
                    assert!((pressure - normal).abs() < 1e-9 * normal.abs(), "{pressure} {normal}");
                }
                assert_eq!(facts[0].clamped > 0, sided);
                assert_eq!(problem.share.iter().any(|&s| s > 1.0 + 1e-9), sided);
            }
        }
    }
}

fn run(text: &str) -> (Prepared, Outcome) {
    let case = case::parse(text, "case.toml", &[]).unwrap_or_else(|e| panic!("{e}"));
    let prepared = prepare(&case).unwrap_or_else(|e| panic!("{e}"));
    let outcome = solve(&prepared, &Settings::of(&case.solver), &mut |_| ControlFlow::Continue(())).unwrap();
    assert_eq!(outcome.solution.status, Status::Solved);
    (prepared, outcome)
}
