//! Contact between two surfaces with different meshes.

use std::ops::ControlFlow;

use stiction::contact::{
    ContactProblem, ContactSurface, Counterpart, InitialGap, Master, Reason, Role, SurfaceFriction, pose,
};
use stiction::fem::{Field, Fix, Formulation, Load, Material, Solid, assemble, full_displacement};
use stiction::friction::Status;
use stiction::io::case;
use stiction::mesh::{Block, BlockElement, Mesh, Turn, block, join, place};
use stiction::run::{Outcome, Prepared, Settings, prepare, solve};

use stiction_fixtures::case_run::solved_case;
use stiction_fixtures::{distance, solved};

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
const TET10: BlockElement = BlockElement::Tet10Five { parity: 1 };
const HEX20: BlockElement = BlockElement::Hex20;
const WEDGE: BlockElement = BlockElement::Wedge6;
const WEDGE15: BlockElement = BlockElement::Wedge15;
const SKEW: Turn = Turn { point: [0.3, -0.2, 0.9], axis: [2.0 / 7.0, 3.0 / 7.0, 6.0 / 7.0], degrees: 30.0 };

fn faces(mesh: &Mesh, group: &str) -> Vec<u32> {
    mesh.group(group).unwrap().faces.clone()
}

fn pair(mesh: &Mesh, slave: &str, master: &str, friction: SurfaceFriction) -> ContactSurface {
    let (gap, reason) = (InitialGap::AsMeshed, Reason::Asked);
    let master = Master { faces: faces(mesh, master), gap, search: None, slave: Role::On, reason, nodes: None };
    ContactSurface {
        name: slave.into(),
        faces: faces(mesh, slave),
        against: Counterpart::Surface(master),
        friction,
        stiffness: None,
        periods: vec![stiction::contact::ALWAYS],
    }
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
        Fix { nodes: mesh.face_nodes(&faces(mesh, group)), value: [0, 1, 2].map(component), ..Fix::default() }
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
    let materials = [Material {
        name: "m".into(),
        young: YOUNG,
        poisson: POISSON,
        density: 0.0,
        formulation,
        ..Material::default()
    }];
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

/// Moves some nodes inside the interface `z = 1` (and above) so that faces are no parallelograms, the middles of edges by
/// less.
fn distort(mesh: &mut Mesh) {
    let mut corner = vec![false; mesh.nodes.len()];
    mesh.cell_iter()
        .for_each(|(kind, nodes)| nodes[..kind.linear().nodes()].iter().for_each(|&n| corner[n as usize] = true));
    for (x, corner) in mesh.nodes.iter_mut().zip(corner) {
        let part = if corner { 1.0 } else { 0.6 };
        let inside = (0..2).all(|c| x[c] > 1e-9 && x[c] < 1.0 - 1e-9);
        if inside && (x[2] - 1.0).abs() < 1e-9 {
            let [p, q] = [x[0], x[1]];
            x[0] += part * 0.06 * (7.0 * q).sin();
            x[1] += part * 0.05 * (9.0 * p).cos();
        }
    }
}

/// Linear fields, rigid motions among them, do not open a flat interface nor slide on it, whatever the meshes, how much
/// of each face is covered, and which nodes are dropped.
#[test]
fn a_linear_field_is_no_jump_on_a_flat_interface() {
    let field = Linear { a: [[0.3, -0.2, 0.7], [0.1, 0.5, -0.9], [-0.4, 0.8, 0.6]], b: [0.1, -0.7, 0.4] };
    for (elements, over) in [
        ([TET, HEX], 0.0),
        ([HEX, TET], 0.3),
        ([HEX, HEX], 0.17),
        ([TET, TET], 0.41),
        ([TET10, HEX20], 0.0),
        ([HEX20, TET10], 0.3),
        ([HEX20, TET], 0.17),
        ([TET, TET10], 0.41),
        ([WEDGE, HEX], 0.17),
        ([WEDGE15, WEDGE], 0.3),
        ([TET10, WEDGE15], 0.0),
    ] {
        let mut mesh = stack([[3, 4, 2], [4, 3, 2]], elements, over);
        distort(&mut mesh);
        place(&mut mesh, Some(&SKEW), [0.1, 0.2, 0.3]);
        for (slave, master) in [("a.z-max", "b.z-min"), ("b.z-min", "a.z-max")] {
            let fixes = [field.fix(&mesh, "a.z-min"), field.fix(&mesh, "b.z-max"), field.fix(&mesh, "a.x-min")];
            let surfaces = [pair(&mesh, slave, master, SurfaceFriction::Coulomb(0.3))];
            let (problem, Posed { model, facts }) = posed(&mesh, &fixes, &[], &surfaces);
            let u: Vec<f64> =
                model.dofs.free.iter().map(|&d| field.at(mesh.nodes[d as usize / 3])[d as usize % 3]).collect();
            let gap = problem.gap_and_slip(&u);
            let worst = gap.iter().fold(0.0, |a: f64, v| a.max(v.abs()));
            // Functions of six and eight nodes over a part of their face are further from orthogonal.
            let quadratic = [TET10, HEX20, WEDGE15].contains(&elements[usize::from(slave == "b.z-min")]);
            let bound = if quadratic { 1e-11 } else { 3e-13 };
            assert!(worst < bound, "{elements:?} {over} {slave}: {worst:e}");
            assert!(problem.points() > 8);
            if slave == "a.z-max" {
                let pair = facts[0].pair.as_ref().unwrap();
                let clamped = if [TET10, HEX20, WEDGE15].contains(&elements[0]) { 9 } else { 5 };
                assert!((pair.covered_area - 1.0).abs() < 1e-12 && pair.uncovered == 0);
                assert_eq!(facts[0].clamped, clamped);
            }
        }
    }
}

/// A pressure of one on the whole interface, dropped nodes included, is the load of a constant traction on both bodies.
#[test]
fn a_constant_pressure_is_carried_past_dropped_nodes() {
    for (elements, clamped) in [([TET, HEX], 5), ([TET10, HEX20], 9), ([HEX20, TET10], 9), ([HEX20, TET], 9)] {
        let mut mesh = stack([[3, 4, 2], [4, 3, 2]], elements, 0.0);
        place(&mut mesh, Some(&SKEW), [0.0; 3]);
        let zero = Linear { a: [[0.0; 3]; 3], b: [0.0; 3] };
        let fixes = [zero.fix(&mesh, "a.z-min"), zero.fix(&mesh, "b.z-max"), zero.fix(&mesh, "a.x-min")];
        let (problem, Posed { model, facts }) =
            posed(&mesh, &fixes, &[], &[pair(&mesh, "a.z-max", "b.z-min", SurfaceFriction::None)]);
        assert_eq!(facts[0].clamped, clamped);
        let m = problem.points();
        let mut lambda = vec![0.0; 3 * m];
        lambda[..m].copy_from_slice(&problem.labels.area);
        let mut force = vec![[0.0; 3]; mesh.nodes.len()];
        let free = problem.contact.B.transpose_times(&lambda).into_iter().zip(&model.dofs.free);
        let held = problem
            .labels
            .supports
            .as_ref()
            .unwrap()
            .B
            .transpose_times(&lambda)
            .into_iter()
            .zip(&model.dofs.prescribed);
        free.chain(held).for_each(|(f, &dof)| force[dof as usize / 3][dof as usize % 3] = f);
        for group in ["a.z-max", "b.z-min"] {
            let normal = mesh.face_normal(faces(&mesh, group)[0] as usize);
            for (node, area) in stiction_fixtures::nodal_areas(&mesh, &faces(&mesh, group)) {
                // On the master the normal is the opposite one, and so is the force.
                let n = normal.map(|c| c * area);
                let f = force[node as usize];
                assert!((0..3).all(|c| (f[c] - n[c]).abs() < 1e-13), "{group} {node}: {f:?} {n:?}");
            }
        }
        let total: f64 = (0..m).map(|j| problem.labels.unity_sum[j] * lambda[j]).sum();
        assert!((total - 1.0).abs() < 1e-13);
    }
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
    let spread = stiction_fixtures::nodal_areas(&mesh, &faces(&mesh, "a.z-max"));
    for (j, (_, area)) in spread.into_iter().enumerate() {
        let (columns, values) = problem.contact.B.row(j);
        assert_eq!(columns.len(), 6);
        let of = |k: usize| model.dofs.free[columns[k] as usize] as usize;
        assert_eq!(of(0) / 3, facts[0].nodes[j] as usize);
        assert!((0..3).all(|c| values[c] == -values[3 + c]), "{values:?}");
        let away = (0..3).map(|c| (mesh.nodes[of(0) / 3][c] - mesh.nodes[of(3) / 3][c]).abs()).fold(0.0, f64::max);
        assert!(away < 1e-14 && problem.contact.gap[j].abs() < 1e-14 && (problem.labels.area[j] - area).abs() < 1e-14);
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
    for (field, friction) in [
        (pressed, SurfaceFriction::Coulomb(2.0)),
        (pressed, SurfaceFriction::Bonded),
        (pulled, SurfaceFriction::Bonded),
    ] {
        for (elements, sided) in
            [([TET, HEX], false), ([HEX, TET], true), ([HEX, HEX], true), ([WEDGE, HEX], false), ([TET, WEDGE], true)]
        {
            for (slave, master) in [("a.z-max", "b.z-min"), ("b.z-min", "a.z-max")] {
                let mut mesh = stack([[3, 4, 3], [4, 3, 2]], elements, 0.0);
                distort(&mut mesh);
                tilt(&mut mesh);
                place(&mut mesh, Some(&SKEW), [0.0; 3]);
                let stress = field.stress(YOUNG, POISSON);
                let mut fixes = vec![field.fix(&mesh, "a.z-min"), field.fix(&mesh, "b.z-max")];
                let mut loads = Vec::new();
                for side in
                    ["x-min", "x-max", "y-min", "y-max"].iter().flat_map(|s| [format!("a.{s}"), format!("b.{s}")])
                {
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
                    posed(&mesh, &fixes, &loads, &[pair(&mesh, slave, master, friction.clone())]);
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
                    let pressure = solution.lambda[j] / problem.labels.area[j];
                    assert!((pressure - normal).abs() < 1e-9 * normal.abs(), "{pressure} {normal}");
                }
                assert_eq!(facts[0].clamped > 0, sided);
                assert_eq!(problem.labels.unity_sum.iter().any(|&s| s > 1.0 + 1e-9), sided);
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

/// Two blocks with different meshes and materials; `{}` are more lines of `[mesh]` and of `[[contact]]`.
fn two_blocks(mesh: &str, press: [f64; 3], contact: &str, cells: usize) -> String {
    let (n, k) = (3 * cells, 4 * cells);
    format!(
        "[mesh]\n{mesh}\n\
         [mesh.parts.a]\nblock = {{ size = [1, 1, 1], cells = [{n}, {n}, {n}], element = \"tet4\" }}\n\
         [mesh.parts.b]\nblock = {{ size = [0.7, 0.8, 0.5], cells = [{k}, {n}, {n}], element = \"hex8\" }}\nmove = [0.1, 0.1, 1]\n\
         [materials.steel]\non = \"a\"\nyoung = 2e11\npoisson = 0.3\n\
         [materials.brass]\non = \"b\"\nyoung = 1e11\npoisson = 0.35\n\
         [[fix]]\non = \"a.z-min\"\n\
         [[fix]]\non = \"b.z-max\"\nvalue = {press:?}\n\
         [[contact]]\non = \"b.z-min\"\nagainst = \"a.z-max\"\n{contact}\n"
    )
}

fn pair_totals(run: &(Prepared, Outcome)) -> Vec<(String, stiction::run::Totals)> {
    stiction::run::pair_totals(&run.0, &run.1)
}

/// What turns with the bodies is the same, what has a direction turns, and units are only numbers.
#[test]
fn a_pair_turned_in_space_or_told_in_other_units_is_the_same_pair() {
    let press = [2e-5, 1e-5, -1e-4];
    let law = "friction = { coulomb = 0.2 }";
    let straight = pair_totals(&run(&two_blocks("", press, law, 1))).remove(0).1;
    assert!(straight.stick > 0 && straight.slip > 0 && straight.normal_force > 1e6, "{straight:?}");
    let about = Turn { point: [0.0; 3], ..SKEW };
    let turn = format!("turn = {{ axis = {:?}, degrees = {}, point = {:?} }}", SKEW.axis, SKEW.degrees, SKEW.point);
    let turned = pair_totals(&run(&two_blocks(&turn, about.apply(press), law, 1))).remove(0).1;
    let same = |a: f64, b: f64| assert!((a - b).abs() < 1e-9 * straight.normal_force, "{a} {b}");
    same(straight.normal_force, turned.normal_force);
    let friction = about.apply(straight.tangential_force);
    (0..3).for_each(|c| same(friction[c], turned.tangential_force[c]));
    assert_eq!((straight.stick, straight.slip, straight.open), (turned.stick, turned.slip, turned.open));
    // Micrometres and newtons: moduli over 1e12, lengths times 1e6.
    let small = two_blocks("", press.map(|v| 1e6 * v), law, 1);
    let small = small.replace("2e11", "0.2").replace("1e11", "0.1").replace("[1, 1, 1]", "[1e6, 1e6, 1e6]");
    let small =
        small.replace("[0.7, 0.8, 0.5]", "[0.7e6, 0.8e6, 0.5e6]").replace("[0.1, 0.1, 1]", "[0.1e6, 0.1e6, 1e6]");
    let other = pair_totals(&run(&small)).remove(0).1;
    same(straight.normal_force, other.normal_force);
    (0..3).for_each(|c| same(straight.tangential_force[c], other.tangential_force[c]));
}

/// Which side carries the points is a matter of discretisation, and forces are reported for the body of `on` either way.
#[test]
fn the_choice_of_the_slave_matters_less_and_less() {
    let law = |slave: &str| format!("friction = {{ coulomb = 0.2 }}\nslave = \"{slave}\"");
    let press = [2e-5, 1e-5, -1e-4];
    let mut apart = Vec::new();
    for cells in [1, 2, 3] {
        let [on, against] =
            ["on", "against"].map(|slave| pair_totals(&run(&two_blocks("", press, &law(slave), cells))).remove(0).1);
        let difference = |f: fn(&stiction::run::Totals) -> f64| (f(&on) - f(&against)).abs() / on.normal_force;
        apart.push([difference(|t| t.normal_force), difference(|t| t.tangential_force[0])]);
        // The upper body is dragged back.
        assert!([&on, &against].iter().all(|t| t.tangential_force[0] < -0.05 * t.normal_force));
    }
    apart.iter().for_each(|d| println!("{:.2e} {:.2e}", d[0], d[1]));
    assert!(apart[2][0] < 0.5 * apart[0][0], "{apart:?}");
    assert!(apart.iter().flatten().all(|d| *d < 2e-3), "{apart:?}");
    // The finer surface, or else the softer body, is chosen, whichever is named first.
    let chosen = |text: &str| {
        let pair = run(text).0.facts.contacts[0].surface.pair.clone().unwrap();
        (pair.slave, pair.reason)
    };
    let text = two_blocks("", press, "friction = \"none\"", 1);
    let swapped = text.replace("on = \"b.z-min\"\nagainst = \"a.z-max\"", "on = \"a.z-max\"\nagainst = \"b.z-min\"");
    assert_eq!((chosen(&text), chosen(&swapped)), ((Role::On, Reason::Softer), (Role::Against, Reason::Softer)));
    let finer = text.replace("cells = [3, 3, 3]", "cells = [6, 6, 3]");
    assert_eq!(chosen(&finer), (Role::Against, Reason::Finer));
}

/// Faces whose sizes have the ratio 5 / 4, up to which sizes are alike: the softer body carries the points wherever the blocks
/// stand, however they are turned and in every unit, although rounding makes the ratio a little more or less.
#[test]
fn rounding_does_not_choose_the_slave() {
    for k in 0..24 {
        let (place, unit) = (0.37 * f64::from(k), [1.0, 1e-3, 25.4][k as usize % 3]);
        let turn = format!("turn = {{ axis = [1, 2, 3], degrees = {}, point = [0, 0, 0] }}", 15 * k);
        let upper = format!("move = [{place}, {}, {unit}]", place / 7.0);
        let blocks = two_blocks(&turn, [0.0; 3], "friction = \"none\"", 1)
            .replace(
                "size = [1, 1, 1], cells = [3, 3, 3]",
                &format!("size = [{unit}, {unit}, {unit}], cells = [5, 5, 2]"),
            )
            .replace(
                "size = [0.7, 0.8, 0.5], cells = [4, 3, 3]",
                &format!("size = [{unit}, {unit}, {unit}], cells = [4, 4, 2]"),
            )
            .replace("element = \"tet4\" }", &format!("element = \"hex8\" }}\nmove = [{place}, {}, 0]", place / 7.0))
            .replace("move = [0.1, 0.1, 1]", &upper);
        let case = case::parse(&blocks, "case.toml", &[]).unwrap_or_else(|e| panic!("{e}"));
        let pair = prepare(&case).unwrap().facts.contacts[0].surface.pair.clone().unwrap();
        assert_eq!((pair.slave, pair.reason), (Role::On, Reason::Softer), "{blocks}");
    }
}

/// A block dragged over another slips everywhere: friction is F N against its motion, whoever carries the points.
#[test]
fn a_dragged_block_slips_everywhere() {
    for slave in ["on", "against"] {
        let law = format!("friction = {{ coulomb = 0.2 }}\nslave = \"{slave}\"");
        let totals = pair_totals(&run(&two_blocks("", [3e-2, 0.0, -1e-4], &law, 1))).remove(0).1;
        assert!(totals.slip > 0 && totals.stick == 0);
        let ratio = totals.tangential_force[0] / totals.normal_force;
        assert!((ratio + 0.2).abs() < 0.01, "{ratio}");
        let given = format!("friction = {{ tresca = 1e3 }}\nslave = \"{slave}\"");
        let totals = pair_totals(&run(&two_blocks("", [3e-2, 0.0, -1e-4], &given, 1))).remove(0).1;
        // All of the upper block's foot, 0.56, bears the given stress; what slips sideways by Poisson is little.
        assert!((totals.tangential_force[0] + 560.0).abs() < 0.01 * 560.0, "{:?}", totals.tangential_force);
    }
}

/// What contact does to one body it does to the other: forces exactly, moments up to the gap.
#[test]
fn contact_forces_are_in_equilibrium_between_the_bodies() {
    for gap in [0.0, 0.02] {
        let mut mesh = stack([[3, 4, 2], [4, 3, 2]], [TET, HEX], 0.23);
        let top = mesh.group("b").unwrap().cells.clone();
        mesh.cell_nodes(&top).into_iter().for_each(|node| mesh.nodes[node as usize][2] += gap);
        let zero = Linear { a: [[0.0; 3]; 3], b: [0.0; 3] };
        let fixes = [zero.fix(&mesh, "a.z-min"), zero.fix(&mesh, "b.z-max")];
        let (problem, Posed { model, .. }) =
            posed(&mesh, &fixes, &[], &[pair(&mesh, "b.z-min", "a.z-max", SurfaceFriction::None)]);
        assert!(problem.contact.gap.iter().zip(&problem.labels.unity_sum).all(|(g, s)| (g - s * gap).abs() < 1e-14));
        let m = problem.points();
        let lambda: Vec<f64> = (0..3 * m).map(|i| ((i * 7919) % 1009) as f64 / 1009.0 - 0.3).collect();
        let force = problem.contact.B.transpose_times(&lambda);
        let (mut sum, mut moment) = ([0.0; 3], [0.0; 3]);
        for (f, &dof) in force.iter().zip(&model.dofs.free) {
            let (x, c) = (mesh.nodes[dof as usize / 3], dof as usize % 3);
            sum[c] += f;
            moment[(c + 1) % 3] += x[(c + 2) % 3] * f;
            moment[(c + 2) % 3] -= x[(c + 1) % 3] * f;
        }
        assert!(sum.iter().all(|f| f.abs() < 1e-12), "{sum:?}");
        // Tangential forces act at both surfaces, a gap apart; the tangents are x and y.
        let tangential =
            |from: usize| (from..from + m).map(|i| problem.labels.unity_sum[i % m] * lambda[i]).sum::<f64>();
        let wanted = [-gap * tangential(2 * m), gap * tangential(m), 0.0];
        assert!((0..3).all(|c| (moment[c] - wanted[c]).abs() < 1e-12), "{moment:?} {wanted:?}");
    }
}

/// Three blocks that meet along an edge, every pair in contact or tied: a uniform compression goes through, although no
/// node can carry the multipliers of two pairs.
#[test]
fn three_bodies_that_meet_along_an_edge_pass_the_patch_test() {
    let field = Linear { a: [[-2e-4, 0.0, 2e-5], [0.0, -1e-4, 0.0], [1e-5, 0.0, -2e-4]], b: [0.0; 3] };
    let parts = [
        ("base", part([2.0, 1.0, 1.0], [5, 3, 3], [0.0; 3], HEX)),
        ("left", part([0.9, 1.0, 1.0], [3, 4, 4], [0.0, 0.0, 1.0], TET)),
        ("right", part([1.1, 1.0, 1.0], [3, 3, 3], [0.9, 0.0, 1.0], HEX)),
    ];
    let mesh = join(parts.map(|(name, mesh)| (name.to_string(), mesh)).into());
    let outer = ["base.z-min", "base.x-min", "base.x-max", "left.x-min", "left.z-max", "right.x-max", "right.z-max"];
    let sides = ["base", "left", "right"].map(|p| [format!("{p}.y-min"), format!("{p}.y-max")]);
    let outer = outer.iter().map(ToString::to_string).chain(sides.into_iter().flatten());
    let fixes: Vec<Fix> = outer.map(|group| field.fix(&mesh, &group)).collect();
    for friction in [SurfaceFriction::Coulomb(0.5), SurfaceFriction::Bonded] {
        let pairs = [("left.x-max", "right.x-min"), ("left.z-min", "base.z-max"), ("right.z-min", "base.z-max")];
        let mut forces = Vec::new();
        for order in [[0, 1, 2], [2, 1, 0]] {
            let surfaces = order.map(|i: usize| pair(&mesh, pairs[i].0, pairs[i].1, friction.clone()));
            let (problem, Posed { model, facts }) = posed(&mesh, &fixes, &[], &surfaces);
            assert!(facts.iter().any(|facts| facts.taken > 0));
            let solution = solved(&problem, 1e-10);
            let exact: Vec<f64> = mesh.nodes.iter().flat_map(|&x| field.at(x)).collect();
            let wrong = distance(&full_displacement(&model, &solution.u), &exact);
            assert!(wrong < 1e-10, "{friction:?} {order:?}: {wrong:e}");
            let force = |name: &str| {
                let pair = problem.labels.pairs.iter().find(|p| p.name == name).unwrap();
                pair.points.clone().map(|j| solution.lambda[j]).sum::<f64>()
            };
            forces.push(force("left.z-min"));
        }
        assert!(forces.iter().all(|f| *f > 0.0));
    }
}

/// A pile of three held blocks with two pairs, named in either order.
#[test]
fn the_order_of_the_pairs_does_not_matter() {
    let text = two_blocks("", [2e-5, 1e-5, -1e-4], "friction = { coulomb = 0.2 }", 1);
    let third = "[mesh.parts.c]\nblock = { size = [0.5, 0.5, 0.3], cells = [4, 4, 2], element = \"hex8\" }\nmove = [0.2, 0.2, -0.3]\n";
    let text = text.replace("[materials.steel]\non = \"a\"", &format!("{third}[materials.steel]\non = [\"a\", \"c\"]"));
    let text = text.replace("on = \"a.z-min\"", "on = [\"a.x-min\", \"c.z-min\"]");
    let second = "[[contact]]\non = \"c.z-max\"\nagainst = \"a.z-min\"\nfriction = { coulomb = 0.4 }\n";
    let (head, first) = text.split_at(text.find("[[contact]]").unwrap());
    let [a, b] = [format!("{head}{first}{second}"), format!("{head}{second}{first}")].map(|t| pair_totals(&run(&t)));
    for (name, totals) in &a {
        let other = &b.iter().find(|(n, _)| n == name).unwrap().1;
        assert!((totals.normal_force - other.normal_force).abs() < 1e-9 * totals.normal_force);
        let drift = (0..3).map(|c| (totals.tangential_force[c] - other.tangential_force[c]).abs()).fold(0.0, f64::max);
        assert!(drift < 1e-9 * totals.normal_force && totals.normal_force > 1e5, "{name} {totals:?} {drift:e}");
    }
}

/// What is reported before the solve.
#[test]
fn pairs_that_cannot_be_meant_are_pointed_out() {
    let notes = |edit: &dyn Fn(String) -> String| {
        let text = edit(two_blocks("", [0.0, 0.0, -1e-4], "friction = \"none\"", 1));
        let case = case::parse(&text, "case.toml", &[]).unwrap_or_else(|e| panic!("{e}"));
        prepare(&case).map(|p| format!("{}", p.facts)).unwrap_or_else(|e| e.to_string())
    };
    let told = |edit: &dyn Fn(String) -> String, words: &[&str]| {
        let notes = notes(edit);
        words.iter().for_each(|word| assert!(notes.contains(word), "{word:?} is not in:\n{notes}"));
    };
    let replaced = |from: &'static str, to: &'static str| {
        move |text: String| {
            assert!(text.contains(from));
            text.replace(from, to)
        }
    };
    told(&|text| text, &["points on b.z-min (its body is the softer one)", "gap 0; touching on 0.56"]);
    told(
        &replaced("[0.1, 0.1, 1]", "[0.1, 0.1, 3]"),
        &["nowhere face one another within", "nearest points are 2 apart", "`search`"],
    );
    told(&replaced("against = \"a.z-max\"", "against = \"a.z-min\""), &["nowhere face one another"]);
    told(&replaced("on = \"b.z-min\"", "on = \"b.z-max\"\nsearch = 2"), &["look the same way", "name the sides"]);
    told(&replaced("[0.1, 0.1, 1]", "[0.1, 0.1, 0.98]"), &["the meshes overlap by up to 0.02", "gap = \"closed\""]);
    told(&replaced("[0.1, 0.1, 1]", "[0.1, 0.1, 0.75]\n#"), &["overlap by 0.25, more than a face", "units"]);
    told(&replaced("against = \"a.z-max\"", "against = \"b.z-min\""), &["case.toml", "no face can touch itself"]);
    told(&replaced("against = \"a.z-max\"", "against = \"a.z_max\""), &["case.toml", "did you mean \"a.z-max\"?"]);
    told(&replaced("against = \"a.z-max\"", "against = \"a\""), &["case.toml", "no boundary faces"]);
    let twice = "friction = \"none\"\n[[contact]]\nname = \"again\"\non = \"a.z-max\"\nagainst = \"b.z-min\"\nfriction = \"none\"";
    told(&replaced("friction = \"none\"", twice), &["used by other contacts"]);
    // A uniform gap is taken as it is asked for, whatever the mesh.
    told(&replaced("friction = \"none\"", "gap = -1e-3\nfriction = \"none\""), &["gap -0.001, as asked"]);
}

#[test]
fn the_coupling_does_not_depend_on_the_number_of_threads() {
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let mesh = stack([[9, 8, 2], [7, 10, 2]], [TET, HEX], 0.23);
        let zero = Linear { a: [[0.0; 3]; 3], b: [0.0; 3] };
        let fixes = [zero.fix(&mesh, "a.z-min"), zero.fix(&mesh, "b.z-max")];
        let surfaces = [pair(&mesh, "b.z-min", "a.z-max", SurfaceFriction::None)];
        pool.install(|| posed(&mesh, &fixes, &[], &surfaces).0)
    };
    assert_eq!(on(1), on(3));
}

/// Turning a model changes nothing. Products of functions of faces that do not match are integrated exactly, however rounding cuts them.
#[test]
fn contact_forces_of_bodies_that_do_not_match_turn_with_them() {
    let pressed = |element: &str, degrees: f64| {
        let part = |name: &str, block: &str| {
            format!(
                "[mesh.parts.{name}]\nblock = {{ {block}, element = \"{element}\" }}\nturn = {{ axis = [1, 2, 3], degrees = {degrees} }}\n"
            )
        };
        let text = part("a", "size = [4, 3, 1], cells = [7, 6, 2]")
            + &part("b", "size = [2, 1.6, 1.2], cells = [5, 4, 2], origin = [0.9, 0.6, 1]")
            + "[materials.s]\nyoung = 1000\npoisson = 0.3\n[[fix]]\non = \"a.z-min\"\n[[load]]\non = \"b.z-max\"\npressure = 3\n\
               [[load]]\non = \"b.x-min\"\npressure = 0.5\n[[contact]]\non = \"b.z-min\"\nagainst = \"a.z-max\"\nslave = \"against\"\n\
               friction = { coulomb = 0.4 }\n";
        let (outcome, prepared) = solved_case(&case::parse(&text, "turned", &[]).unwrap());
        outcome.solution.lambda[..prepared.problem.points()].to_vec()
    };
    for element in ["hex8", "hex20", "tet10"] {
        let [plain, turned] = [0.0, 37.0].map(|degrees| pressed(element, degrees));
        let largest = plain.iter().fold(0.0f64, |m, p| m.max(p.abs()));
        assert_eq!(plain.len(), turned.len());
        let apart = plain.iter().zip(&turned).fold(0.0f64, |m, (a, b)| m.max((a - b).abs()));
        assert!(apart < 1e-8 * largest, "{element}: {apart:e} of {largest:e}");
    }
}
