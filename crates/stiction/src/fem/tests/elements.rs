//! The element matrices: what every elastic body must satisfy, whatever the element.

use super::*;
use crate::fem::elements::Hex8;

/// Stiffness of a free body, all three formulations that differ.
fn stiffness_of(mesh: &Mesh, poisson: f64, formulation: Formulation) -> SymmetricCsr {
    let material = Material { formulation, ..material(2.0, poisson) };
    model_of(mesh, &material, &[], &[]).unwrap().stiffness
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m, v| m.max(v.abs()))
}

fn distorted(kind: CellKind) -> Mesh {
    let mut mesh = brick(kind, [3, 3, 3], [1.0, 1.1, 0.9]);
    distort(&mut mesh, 0.06);
    mesh
}

const FORMULATIONS: [Formulation; 2] = [Formulation::Full, Formulation::BBar];

/// Unit translations along x, y, z and rotations by one radian about these axes (linearised) as displacements `3 i + c`.
fn rigid_motions(nodes: &[[f64; 3]]) -> [Vec<f64>; 6] {
    std::array::from_fn(|k| {
        let axis = std::array::from_fn(|c| f64::from(u8::from(c == k % 3)));
        nodes.iter().flat_map(|x| if k < 3 { axis } else { v3::cross(axis, *x) }).collect()
    })
}

#[test]
fn rigid_motions_cost_no_energy() {
    for kind in KINDS {
        let mesh = distorted(kind);
        for formulation in FORMULATIONS {
            let k = stiffness_of(&mesh, 0.3, formulation);
            for motion in rigid_motions(&mesh.nodes) {
                let force = largest(&k.times(&motion));
                assert!(force <= 1e-12 * largest(&k.value) * largest(&motion), "{kind:?} {formulation:?} {force:e}");
            }
        }
    }
}

#[test]
fn the_stiffness_is_symmetric_to_the_bit_and_positive() {
    for kind in KINDS {
        let mesh = distorted(kind);
        for formulation in FORMULATIONS {
            let k = stiffness_of(&mesh, 0.3, formulation);
            k.validate("K").unwrap();
            // Where everything is prescribed both triangles are summed.
            let zero = Some(Field::Constant(0.0));
            let value = [zero.clone(), zero.clone(), zero];
            let fix = Fix { nodes: (0..mesh.nodes.len() as u32).collect(), value, ..Fix::default() };
            let material = Material { formulation, ..material(2.0, 0.3) };
            let constrained = model_of(&mesh, &material, &[], &[fix]).unwrap();
            assert_eq!(constrained.stiffness.rows, 0);
            assert_eq!(constrained.support_support, constrained.support_support.transpose());
            assert_eq!(constrained.support_support, k.full());
            let u: Vec<f64> = (0..k.rows).map(|i| (i as f64 * i as f64).sin()).collect();
            assert!(k.times(&u).iter().zip(&u).map(|(f, u)| f * u).sum::<f64>() > 0.0);
        }
    }
}

#[test]
fn a_rotated_or_mirrored_body_has_the_rotated_stiffness() {
    let (c, s) = (0.8, 0.6);
    let rotation = [[c, -s, 0.0], [0.6 * s, 0.6 * c, -0.8], [0.8 * s, 0.8 * c, 0.6]];
    let mirror = [[-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let apply = |q: [[f64; 3]; 3], x: [f64; 3]| q.map(|row| v3::dot(row, x));
    for (kind, q) in KINDS.into_iter().flat_map(|kind| [(kind, rotation), (kind, mirror)]) {
        let mesh = distorted(kind);
        let mut moved = mesh.clone();
        moved.nodes.iter_mut().for_each(|x| *x = apply(q, *x));
        if q == mirror {
            // Mirroring turns a cell inside out; its nodes are renumbered to be counter-clockwise again.
            for cell in moved.cells[0].nodes.chunks_exact_mut(kind.nodes()) {
                match kind.linear() {
                    CellKind::Tet4 => cell.swap(1, 2),
                    CellKind::Wedge6 => cell[..6].rotate_left(3),
                    _ => cell[..8].rotate_left(4),
                }
                match kind {
                    CellKind::Tet10 => [(4, 6), (8, 9)].into_iter().for_each(|(a, b)| cell.swap(a, b)),
                    CellKind::Hex20 => cell[8..16].rotate_left(4),
                    CellKind::Wedge15 => cell[6..12].rotate_left(3),
                    _ => {}
                }
            }
        }
        for formulation in FORMULATIONS {
            let (k, k_moved) = (stiffness_of(&mesh, 0.47, formulation), stiffness_of(&moved, 0.47, formulation));
            let u: Vec<f64> = (0..k.rows).map(|i| (1.0 + i as f64 * i as f64).sin()).collect();
            let turn = |u: &[f64]| u.chunks_exact(3).flat_map(|u| apply(q, [u[0], u[1], u[2]])).collect::<Vec<f64>>();
            let (expected, found) = (turn(&k.times(&u)), k_moved.times(&turn(&u)));
            let difference: Vec<f64> = expected.iter().zip(&found).map(|(a, b)| a - b).collect();
            assert!(largest(&difference) < 1e-12 * largest(&expected), "{kind:?} {formulation:?}");
        }
    }
}

/// The integrand of a mean gradient of a trilinear cell is a polynomial that eight Gauss points integrate exactly.
#[test]
fn mean_gradients_of_hexahedra_by_their_faces_are_those_of_the_gauss_points() {
    let mesh = distorted(CellKind::Hex8);
    for far in [0.0, 1e6] {
        for nodes in mesh.cells[0].nodes.chunks_exact(8) {
            let x = std::array::from_fn(|i| v3::add(mesh.nodes[nodes[i] as usize], [far, -far, far]));
            let (averaged, cell) = (Hex8::averaged(&x).unwrap(), Hex8::new(&x).unwrap());
            let accuracy = if far == 0.0 { 1e-14 } else { 1e-9 };
            assert!((averaged.weight[0] - cell.volume()).abs() < accuracy * cell.volume());
            for (mean, sum) in averaged.gradient[0].iter().zip(cell.integrated_gradient()) {
                let expected = v3::scale(1.0 / cell.volume(), sum);
                assert!(v3::norm(v3::sub(*mean, expected)) < accuracy * v3::norm(averaged.gradient[0][0]));
            }
        }
    }
    let mut folded: [[f64; 3]; 8] = std::array::from_fn(|i| mesh.nodes[mesh.cells[0].nodes[i] as usize]);
    folded.rotate_left(4);
    assert!(Hex8::averaged(&folded).is_none());
}

#[test]
fn metres_and_pascal_agree_with_millimetres_and_megapascal() {
    // Force per length: 1 N/m = 1e-3 N/mm.
    for kind in KINDS {
        let metres = distorted(kind);
        let mut millimetres = metres.clone();
        millimetres.nodes.iter_mut().flatten().for_each(|x| *x *= 1e3);
        let si = model_of(&metres, &material(2.1e11, 0.3), &[], &[]).unwrap().stiffness;
        let mm = model_of(&millimetres, &material(2.1e5, 0.3), &[], &[]).unwrap().stiffness;
        // Entries of quadratic cells are sums over many points, whose rounding is that of the largest.
        let bound = if kind.edges().is_empty() { 1e-12 * 2.1e5 } else { 1e-14 * largest(&mm.value) };
        for (si, mm) in si.value.iter().zip(&mm.value) {
            assert!((1e-3 * si - mm).abs() < bound);
        }
    }
}

#[test]
fn a_folded_cell_is_refused_and_named() {
    for kind in KINDS {
        let mut mesh = brick(kind, [2, 1, 1], [2.0, 1.0, 1.0]);
        mesh.nodes[1] = [5.0, 0.0, 0.0];
        let error = model_of(&mesh, &material(1.0, 0.3), &[], &[]).unwrap_err().to_string();
        assert!(error.contains("folded") && error.contains(kind.name()), "{error}");
    }
}

#[test]
fn materials_without_a_positive_stiffness_are_refused() {
    let mesh = brick(CellKind::Tet4, [1, 1, 1], [1.0; 3]);
    for (young, poisson) in [(0.0, 0.3), (-1.0, 0.3), (f64::NAN, 0.3), (1.0, 0.5), (1.0, -1.0), (1.0, f64::NAN)] {
        assert!(model_of(&mesh, &material(young, poisson), &[], &[]).is_err(), "{young} {poisson}");
    }
    let light = Material { density: -1.0, ..material(1.0, 0.3) };
    assert!(model_of(&mesh, &light, &[], &[]).unwrap_err().to_string().contains("density"));
}

#[test]
fn notes_say_where_tetrahedra_lock_and_b_bar_is_chosen() {
    let notes_of = |kind, poisson| {
        let mesh = brick(kind, [1, 1, 1], [1.0; 3]);
        let materials = [material(1.0, poisson)];
        let solid = Solid { mesh: &mesh, materials: &materials, material_of_cell: &vec![0; mesh.cell_count()] };
        notes(&materials, &cells_of_materials(&solid))
    };
    assert!(notes_of(CellKind::Tet4, 0.3).is_empty() && notes_of(CellKind::Hex8, 0.3).is_empty());
    assert!(notes_of(CellKind::Tet4, 0.49)[0].contains("lock"));
    assert!(notes_of(CellKind::Hex8, 0.49)[0].contains("B-bar"));
}
