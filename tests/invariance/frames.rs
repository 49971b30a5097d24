//! What must not change the answer: units, position in space, mirrors, the numbering.

use stiction::contact::{Obstacle, SurfaceFriction};
use stiction::fem::{Field, Load};
use stiction::mesh::{BlockElement, RawCells, RawGroup, RawMesh, build};
use stiction_fixtures::*;

const COULOMB: SurfaceFriction = SurfaceFriction::Coulomb(0.35);
const TIGHT: f64 = 1e-11;

/// The same case in other units: one old length is `length` new ones, one old force `force` new ones.
fn in_units(case: &Case, length: f64, force: f64) -> Case {
    let stress = force / (length * length);
    let mut case = case.clone();
    case.mesh.nodes.iter_mut().for_each(|x| *x = x.map(|c| c * length));
    case.young *= stress;
    for load in &mut case.loads {
        let Load::Traction { value, .. } = load else { panic!("tractions only") };
        for field in value {
            let old = field.clone();
            let new = move |x: [f64; 3], t: f64| stress * old.at(x.map(|c| c / length), t);
            *field = Field::Function { text: "scaled".into(), value: std::sync::Arc::new(new) };
        }
    }
    for surface in &mut case.surfaces {
        surface.friction = match surface.friction.clone() {
            SurfaceFriction::GivenStress(s) => SurfaceFriction::GivenStress(s * stress),
            SurfaceFriction::GivenForce(s) => SurfaceFriction::GivenForce(s * force),
            other => other,
        };
    }
    case
}

#[test]
fn millimetres_and_megapascals_give_the_same_answer_in_the_same_iterations() {
    for friction in
        [SurfaceFriction::None, COULOMB, SurfaceFriction::GivenStress(1e5), SurfaceFriction::GivenForce(1e4)]
    {
        for load in [BrickLoad::Lift, BrickLoad::Press] {
            let case = brick(8, BlockElement::Tet4Six, load, friction.clone());
            let a = attempt(&case.pose().problem, &settings(1e-8));
            // m and Pa; mm and MPa; inch and pound-force; nm and GN
            for (length, force) in [(1e3, 1.0), (39.37, 0.2248), (1e9, 1e-9)] {
                let b = attempt(&in_units(&case, length, force).pose().problem, &settings(1e-8));
                assert_eq!(a.status, b.status);
                let line = |s: &stiction::friction::Solution| {
                    let steps = s.history.iter().map(|p| (p.iteration, p.open, p.stick, p.slip));
                    (s.counts.newton_steps, s.counts.restarts, steps.collect::<Vec<_>>())
                };
                assert_eq!(line(&a), line(&b), "{load:?} {friction:?} {length} {force}");
                let lambda: Vec<f64> = b.lambda.iter().map(|l| l / force).collect();
                let u: Vec<f64> = b.u.iter().map(|u| u / length).collect();
                assert!(distance(&a.lambda, &lambda) < 1e-9);
                assert!(distance(&a.u, &u) < 1e-9);
                // The certificate's dimensionless figures are the same up to the rounding that they measure.
                for ((name, x), (_, y)) in a.certificate.measures().into_iter().zip(b.certificate.measures()) {
                    assert!((x - y).abs() < 1e-10, "{name} {x} {y}");
                }
            }
        }
    }
}

/// The rotation by `angle` about `axis` (Rodrigues).
fn rotation(axis: [f64; 3], angle: f64) -> [[f64; 3]; 3] {
    let l = axis.iter().map(|a| a * a).sum::<f64>().sqrt();
    let [x, y, z] = axis.map(|a| a / l);
    let (s, c) = angle.sin_cos();
    let k = 1.0 - c;
    [
        [c + k * x * x, k * x * y - s * z, k * x * z + s * y],
        [k * x * y + s * z, c + k * y * y, k * y * z - s * x],
        [k * x * z - s * y, k * y * z + s * x, c + k * z * z],
    ]
}

fn apply(r: &[[f64; 3]; 3], x: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| (0..3).map(|j| r[i][j] * x[j]).sum())
}

fn apply_transposed(r: &[[f64; 3]; 3], x: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| (0..3).map(|j| r[j][i] * x[j]).sum())
}

#[test]
fn a_rotated_model_has_the_rotated_displacement_and_the_same_normal_forces() {
    for load in [BrickLoad::Lift, BrickLoad::Press] {
        for element in [BlockElement::Tet4Six, BlockElement::Hex8] {
            let case = brick(4, element, load, COULOMB);
            let posed = case.pose();
            let a = solved(&posed.problem, TIGHT);
            let r = rotation([1.0, -2.0, 0.7], 1.234);
            let shift = [5.0, -7.0, 3.0];
            let mut turned = case.clone();
            for x in &mut turned.mesh.nodes {
                let y = apply(&r, *x);
                *x = [y[0] + shift[0], y[1] + shift[1], y[2] + shift[2]];
            }
            for load in &mut turned.loads {
                let Load::Traction { value, .. } = load else { panic!("tractions only") };
                let old = value.clone();
                *value = [0, 1, 2].map(|c| {
                    let old = old.clone();
                    let turned = move |x: [f64; 3], t: f64| {
                        let y = apply_transposed(&r, [0, 1, 2].map(|c| x[c] - shift[c]));
                        apply(&r, [0, 1, 2].map(|c| old[c].at(y, t)))[c]
                    };
                    Field::Function { text: "turned".into(), value: std::sync::Arc::new(turned) }
                });
            }
            turned.surfaces[0].against = Obstacle::Plane { point: shift, normal: apply(&r, [0.0, 0.0, 1.0]) }.into();
            let turned = turned.pose();
            let b = solved(&turned.problem, TIGHT);
            let m = posed.problem.points();
            assert!(distance(&a.lambda[..m], &b.lambda[..m]) < 1e-8);
            let expected: Vec<f64> = posed.full(&a.u).iter().flat_map(|u| apply(&r, *u)).collect();
            assert!(distance(&expected, turned.full(&b.u).as_flattened()) < 1e-8);
            let magnitude = |l: &[f64]| (0..m).map(|j| l[m + j].hypot(l[2 * m + j])).collect::<Vec<_>>();
            assert!(distance(&magnitude(&a.lambda), &magnitude(&b.lambda)) < 1e-8);
        }
    }
}

#[test]
fn a_mirrored_model_has_the_mirrored_answer() {
    // y -> 1 - y takes an even number of cells of five tetrahedra into themselves.
    for element in [BlockElement::Tet4Five { parity: 0 }, BlockElement::Hex8] {
        let pull = |sideways: f64| {
            let case = brick(4, element, BrickLoad::Press, COULOMB);
            case.traction("x-max", [0.0, sideways - 5e5, 0.0]).pose()
        };
        let (a, b) = (pull(5e5), pull(-5e5));
        let (sa, sb) = (solved(&a.problem, TIGHT), solved(&b.problem, TIGHT));
        let (ua, ub) = (a.full(&sa.u), b.full(&sb.u));
        let mirror = |node: usize| {
            let (i, j, k) = (node % 13, node / 13 % 5, node / 65);
            i + 13 * (4 - j + 5 * k)
        };
        let expected: Vec<f64> = (0..ua.len()).map(mirror).flat_map(|n| [ua[n][0], -ua[n][1], ua[n][2]]).collect();
        assert!(distance(&expected, ub.as_flattened()) < 1e-8);
    }
}

/// The same mesh with its nodes, cells and corners of faces numbered otherwise, and the new number of each node.
fn renumbered(case: &Case) -> (Case, Vec<u32>) {
    let mesh = &case.mesh;
    let n = mesh.nodes.len();
    let stride = (n / 2..).find(|&s| gcd(s, n) == 1).unwrap();
    let new: Vec<u32> = (0..n).map(|i| ((i * stride + 3) % n) as u32).collect();
    let mut nodes = vec![[0.0; 3]; n];
    new.iter().zip(&mesh.nodes).for_each(|(&i, &x)| nodes[i as usize] = x);
    let cells = mesh.cells.iter().map(|c| {
        let all = (0..c.len()).rev().flat_map(|i| c.cell(i)).map(|&i| new[i as usize]);
        RawCells { kind: c.kind, nodes: all.collect(), ids: Vec::new() }
    });
    let groups = mesh.groups.iter().filter(|g| !g.faces.is_empty()).map(|g| {
        let face = |&f: &u32| {
            let mut corners = [u32::MAX; 4];
            let nodes = mesh.faces[f as usize].nodes();
            corners.iter_mut().zip(nodes).for_each(|(c, &i)| *c = new[i as usize]);
            corners
        };
        RawGroup { name: g.name.clone(), faces: g.faces.iter().map(face).collect(), ..RawGroup::default() }
    });
    let raw = RawMesh { nodes, cells: cells.collect(), groups: groups.collect(), ..RawMesh::default() };
    (Case { mesh: build(raw).unwrap().0, loads: vec![], fixes: vec![], surfaces: vec![], ..case.clone() }, new)
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

#[test]
fn the_numbering_of_nodes_and_cells_does_not_matter() {
    let case = brick(4, BlockElement::Tet4Six, BrickLoad::Press, COULOMB);
    let (other, new) = renumbered(&case);
    let other = other
        .fix("x-min", HELD)
        .contact("z-min", FLOOR, COULOMB)
        .traction("x-max", [1e6, 5e5, 0.0])
        .traction("z-max", [0.0, 0.0, -1e6]);
    let (a, b) = (case.pose(), other.pose());
    let (sa, sb) = (solved(&a.problem, TIGHT), solved(&b.problem, TIGHT));
    let (ua, ub) = (a.full(&sa.u), b.full(&sb.u));
    let expected: Vec<f64> = new.iter().flat_map(|&i| ub[i as usize]).collect();
    assert!(distance(ua.as_flattened(), &expected) < 1e-8);
    let m = a.problem.points();
    let sorted = |l: &[f64]| {
        let mut l = l[..m].to_vec();
        l.sort_by(f64::total_cmp);
        l
    };
    assert!(distance(&sorted(&sa.lambda), &sorted(&sb.lambda)) < 1e-8);
}
