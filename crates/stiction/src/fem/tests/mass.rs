//! The mass matrix against integrals done by hand.

use super::*;

const DENSITY: f64 = 7.8;

fn mass_of(mesh: &Mesh) -> Result<Csr, crate::Error> {
    let materials = [Material { density: DENSITY, ..material(1.0, 0.3) }];
    mass(&Solid { mesh, materials: &materials, material_of_cell: &vec![0; mesh.cell_count()] })
}

/// `a' M b` for values at nodes of two fields.
fn form(mass: &Csr, mesh: &Mesh, a: impl Fn([f64; 3]) -> f64, b: impl Fn([f64; 3]) -> f64) -> f64 {
    let [a, b]: [Vec<f64>; 2] =
        [mesh.nodes.iter().map(|&x| a(x)).collect(), mesh.nodes.iter().map(|&x| b(x)).collect()];
    crate::linalg::dot(&a, &mass.times(&b))
}

#[test]
fn rigid_motions_have_the_mass_and_the_inertia_of_the_block() {
    let [a, b, c] = [2.0, 3.0, 0.5];
    for kind in KINDS {
        let mesh = brick(kind, [2, 3, 1], [a, b, c]);
        let mass = mass_of(&mesh).unwrap();
        let whole = DENSITY * a * b * c;
        // Moments about the corner in the origin, the x y one included: ∫ 1, x, x², x y of a box.
        let found = [
            form(&mass, &mesh, |_| 1.0, |_| 1.0),
            form(&mass, &mesh, |x| x[0], |_| 1.0),
            form(&mass, &mesh, |x| x[0], |x| x[0]),
            form(&mass, &mesh, |x| x[0], |x| x[1]),
            form(&mass, &mesh, |x| x[2], |x| x[2]),
        ];
        let exact = [1.0, a / 2.0, a * a / 3.0, a * b / 4.0, c * c / 3.0].map(|mean| whole * mean);
        for (found, exact) in found.into_iter().zip(exact) {
            assert!((found - exact).abs() < 1e-12 * whole * b * b, "{kind:?}: {found} {exact}");
        }
        assert_eq!(mass, mass.transpose(), "{kind:?}");
    }
}

#[test]
fn quadratic_cells_hold_the_mass_of_quadratic_motions() {
    for kind in [CellKind::Tet10, CellKind::Hex20] {
        let mesh = brick(kind, [2, 1, 2], [1.0, 2.0, 3.0]);
        let mass = mass_of(&mesh).unwrap();
        // ∫ (x z)² and ∫ y² z² over the box: a³/3 b c³/3, a b³/3 c³/3; ∫ y⁴ = a b⁵/5 c.
        let squares = [
            (form(&mass, &mesh, |x| x[0] * x[2], |x| x[0] * x[2]), 1.0 / 3.0 * 2.0 * 9.0),
            (form(&mass, &mesh, |x| x[1] * x[2], |x| x[1] * x[2]), 8.0 / 3.0 * 9.0),
            (form(&mass, &mesh, |x| x[1] * x[1], |x| x[1] * x[1]), 32.0 / 5.0 * 3.0),
        ];
        for (found, exact) in squares {
            assert!((found - DENSITY * exact).abs() < 1e-11 * exact, "{kind:?}: {found} {exact}");
        }
    }
}

#[test]
fn inner_nodes_that_move_leave_the_mass_as_it_is() {
    for kind in KINDS {
        let mut mesh = brick(kind, [3, 3, 3], [1.0; 3]);
        distort(&mut mesh, 0.06);
        let mass = mass_of(&mesh).unwrap();
        assert!((form(&mass, &mesh, |_| 1.0, |_| 1.0) - DENSITY).abs() < 1e-12, "{kind:?}");
    }
}

#[test]
fn a_body_without_density_has_no_mass_matrix() {
    let mesh = brick(CellKind::Hex8, [1; 3], [1.0; 3]);
    let materials = [Material { density: 0.0, ..material(1.0, 0.3) }];
    let error = mass(&Solid { mesh: &mesh, materials: &materials, material_of_cell: &[0] }).unwrap_err();
    assert!(error.remedy.contains("density"), "{error}");
}
