//! Order of convergence by a manufactured solution.

use super::*;
use crate::fem::elements::{Hex20, Tet10, Wedge15, volume_points};
use crate::mesh::geometry::corners;
use std::f64::consts::PI;

const YOUNG: f64 = 2.5;
const POISSON: f64 = 0.25; // lambda = mu = 1

/// A displacement and the acceleration that keeps unit density in equilibrium: `-div σ(u)` with `λ = μ = 1`, which
/// is `-Δu - 2 ∇ div u`. With `u = (s, 0, 0)`, `s = sin πx sin πy cos πz`, it is `3π² s` and twice the second
/// derivatives of `s` along `x` with each coordinate.
fn displacement(x: [f64; 3]) -> [f64; 3] {
    [(PI * x[0]).sin() * (PI * x[1]).sin() * (PI * x[2]).cos(), 0.0, 0.0]
}

fn acceleration(x: [f64; 3]) -> [f64; 3] {
    let [(s0, c0), (s1, c1), (s2, c2)] = x.map(|x| (PI * x).sin_cos());
    let pi2 = PI * PI;
    [5.0 * pi2 * s0 * s1 * c2, -2.0 * pi2 * c0 * c1 * c2, 2.0 * pi2 * c0 * s1 * s2]
}

/// The derivatives of the first component; the others vanish.
fn slope(x: [f64; 3]) -> [f64; 3] {
    let [(s0, c0), (s1, c1), (s2, c2)] = x.map(|x| (PI * x).sin_cos());
    [PI * c0 * s1 * c2, PI * s0 * c1 * c2, -PI * s0 * s1 * s2]
}

/// The shape functions' gradients at the points of `volume_points` of a quadratic cell.
fn gradients(mesh: &Mesh, kind: CellKind, nodes: &[u32]) -> Vec<Vec<[f64; 3]>> {
    match kind {
        CellKind::Tet10 => Tet10::new(&corners(&mesh.nodes, nodes)).unwrap().gradient.map(|g| g.to_vec()).into(),
        CellKind::Wedge15 => Wedge15::new(&corners(&mesh.nodes, nodes)).unwrap().gradient.map(|g| g.to_vec()).into(),
        _ => Hex20::new(&corners(&mesh.nodes, nodes)).unwrap().gradient.map(|g| g.to_vec()).into(),
    }
}

/// `‖∇(u - u_h)‖` in L2 on quadratic cells: by Korn's inequality the energy of the error, up to constants.
fn slope_error(mesh: &Mesh, u: &[f64]) -> f64 {
    let (mut sum, kind) = (0.0, mesh.cells[0].kind);
    for nodes in mesh.cells[0].nodes.chunks_exact(kind.nodes()) {
        let points = volume_points(kind, mesh, nodes).unwrap();
        for (point, gradient) in points.iter().zip(gradients(mesh, kind, nodes)) {
            let exact = slope(point.position);
            for (a, b) in (0..3).flat_map(|a| (0..3).map(move |b| (a, b))) {
                let found: f64 = nodes.iter().zip(&gradient).map(|(&i, g)| g[b] * u[3 * i as usize + a]).sum();
                sum += point.weight * (if a == 0 { exact[b] } else { 0.0 } - found).powi(2);
            }
        }
    }
    sum.sqrt()
}

/// `‖u - u_h‖` in L2, integrated by the rule of the elements.
fn error(mesh: &Mesh, u: &[f64]) -> f64 {
    let mut sum = 0.0;
    let kind = mesh.cells[0].kind;
    for nodes in mesh.cells[0].nodes.chunks_exact(kind.nodes()) {
        for point in volume_points(kind, mesh, nodes).unwrap() {
            let exact = displacement(point.position);
            for (c, exact) in exact.into_iter().enumerate() {
                let found: f64 = nodes.iter().zip(point.shape).map(|(&i, s)| s * u[3 * i as usize + c]).sum();
                sum += point.weight * (exact - found).powi(2);
            }
        }
    }
    sum.sqrt()
}

#[test]
fn the_displacement_converges_with_the_square_of_the_mesh_width_and_quadratic_elements_with_the_cube() {
    use Formulation::{BBar, Full};
    for (kind, formulation, widths, expected) in [
        (CellKind::Tet4, Full, [8, 16], 2.0),
        (CellKind::Hex8, Full, [8, 16], 2.0),
        (CellKind::Hex8, BBar, [8, 16], 2.0),
        (CellKind::Tet10, Full, [4, 8], 3.0),
        (CellKind::Hex20, Full, [4, 8], 3.0),
        (CellKind::Hex20, BBar, [4, 8], 3.0),
        (CellKind::Wedge6, Full, [8, 16], 2.0),
        (CellKind::Wedge6, BBar, [8, 16], 2.0),
        (CellKind::Wedge15, Full, [4, 8], 3.0),
    ] {
        let material = Material { formulation, ..material(YOUNG, POISSON) };
        let errors = widths.map(|cells| {
            let mesh = brick(kind, [cells; 3], [1.0; 3]);
            let value = [0, 1, 2].map(|c| Some(function(move |x| displacement(x)[c])));
            let acceleration = [0, 1, 2].map(|c| function(move |x| acceleration(x)[c]));
            let all = (0..mesh.cell_count() as u32).collect();
            let u = solve(
                &mesh,
                &material,
                &[Load::Gravity { cells: all, acceleration }],
                &[Fix { nodes: boundary_nodes(&mesh), value, ..Fix::default() }],
            );
            [error(&mesh, &u), if kind.edges().is_empty() { f64::NAN } else { slope_error(&mesh, &u) }]
        });
        let [order, energy] = [0, 1].map(|i| (errors[0][i] / errors[1][i]).log2());
        assert!(energy.is_nan() || (energy - 2.0).abs() < 0.3, "{kind:?}: {errors:?}, order {energy} in energy");
        assert!((order - expected).abs() < 0.3, "{kind:?} {formulation:?}: {errors:?}, order {order}");
    }
}
