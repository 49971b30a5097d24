//! Solutions every conforming element must reproduce, and beams.

use super::*;

/// `u = A x + b` with a full gradient.
const A: [[f64; 3]; 3] = [[0.010, 0.003, -0.002], [0.004, -0.006, 0.005], [0.001, -0.007, 0.008]];

fn linear(x: [f64; 3]) -> [f64; 3] {
    v3::add(A.map(|row| v3::dot(row, x)), [0.1, -0.2, 0.3])
}

#[test]
fn a_linear_displacement_and_its_stress_are_exact_on_distorted_cells() {
    for (kind, formulation) in [
        (CellKind::Tet4, Formulation::Full),
        (CellKind::Hex8, Formulation::Full),
        (CellKind::Hex8, Formulation::BBar),
        (CellKind::Tet10, Formulation::Full),
        (CellKind::Hex20, Formulation::Full),
        (CellKind::Wedge6, Formulation::Full),
        (CellKind::Wedge6, Formulation::BBar),
        (CellKind::Wedge15, Formulation::Full),
    ] {
        let mut mesh = brick(kind, [3, 4, 3], [1.0, 1.2, 1.0]);
        distort(&mut mesh, if kind.edges().is_empty() { 0.07 } else { 0.03 });
        let material = Material { formulation, ..material(3.0, 0.3) };
        let value = [0, 1, 2].map(|c| Some(function(move |x| linear(x)[c])));
        let u = solve(&mesh, &material, &[], &[Fix { nodes: boundary_nodes(&mesh), value, ..Fix::default() }]);
        for (x, u) in mesh.nodes.iter().zip(u.chunks_exact(3)) {
            assert!(linear(*x).iter().zip(u).all(|(exact, u)| (exact - u).abs() < 1e-11), "{kind:?} {formulation:?}");
        }

        // Hooke's law by E and nu rather than by Lamé's parameters.
        let (young, nu, strain) = (3.0, 0.3, |a: usize, b: usize| 0.5 * (A[a][b] + A[b][a]));
        let direct = |a: usize, b: usize, c: usize| {
            young * ((1.0 - nu) * strain(a, a) + nu * (strain(b, b) + strain(c, c))) / ((1.0 + nu) * (1.0 - 2.0 * nu))
        };
        let shear = |a: usize, b: usize| young / (1.0 + nu) * strain(a, b);
        let exact = [direct(0, 1, 2), direct(1, 2, 0), direct(2, 0, 1), shear(0, 1), shear(1, 2), shear(0, 2)];
        let solid = Solid { mesh: &mesh, materials: &[material], material_of_cell: &vec![0; mesh.cell_count()] };
        for stress in cell_stress(&solid, &u, &[]) {
            assert!(stress.iter().zip(&exact).all(|(s, e)| (s - e).abs() < 1e-10), "{kind:?} {stress:?} {exact:?}");
        }
    }
}

#[test]
fn a_pulled_bar_stretches_by_e_and_narrows_by_nu() {
    let (young, nu, pull) = (200.0, 0.25, 4.0);
    for kind in KINDS {
        let mesh = brick(kind, [4, 2, 2], [4.0, 1.0, 2.0]);
        let roller = |c: usize| {
            let mut value = [None, None, None];
            value[c] = Some(Field::Constant(0.0));
            Fix { nodes: nodes_where(&mesh, |x| x[c] == 0.0), value, ..Fix::default() }
        };
        let faces = faces_where(&mesh, |x| x[0] == 4.0);
        let load = Load::Traction { faces, value: [pull, 0.0, 0.0].map(Field::Constant) };
        let fixes = [roller(0), roller(1), roller(2)];
        let materials = [material(young, nu)];
        let model = model_of(&mesh, &materials[0], std::slice::from_ref(&load), &fixes).unwrap();
        let u_free = solve_spd(&model.stiffness, &model.load);
        let u = full_displacement(&model, &u_free);
        for (x, u) in mesh.nodes.iter().zip(u.chunks_exact(3)) {
            let exact = [pull / young * x[0], -nu * pull / young * x[1], -nu * pull / young * x[2]];
            assert!(exact.iter().zip(u).all(|(e, u)| (e - u).abs() < 1e-11));
        }
        // The wall pulls back with stress times area.
        let along_x = |(dof, _): &(&u32, f64)| **dof % 3 == 0;
        let constrained: f64 =
            model.dofs.prescribed.iter().zip(reactions(&model, &u_free)).filter(along_x).map(|r| r.1).sum();
        assert!((constrained + pull * 2.0).abs() < 1e-9, "{constrained}");

        let solid = Solid { mesh: &mesh, materials: &materials, material_of_cell: &vec![0; mesh.cell_count()] };
        assert!(cell_stress(&solid, &u, &[]).iter().all(|s| (von_mises(s) - pull).abs() < 1e-9));
    }
}

#[test]
fn a_nearly_incompressible_beam_bends_by_b_bar_and_locks_without() {
    // Length 10, height and width 1, 40 x 4 x 4 cells; Timoshenko: w = P L^3 / (3 E I) + P L / (k G A), k = 5/6.
    let (young, nu, length, force) = (1.0e6, 0.4999, 10.0, 12.0f64);
    let mesh = brick(CellKind::Hex8, [40, 4, 4], [length, 1.0, 1.0]);
    let theory =
        force * length.powi(3) / (3.0 * young / 12.0) + force * length / (5.0 / 6.0 * young / (2.0 + 2.0 * nu));
    let tip = |formulation| {
        let material = Material { formulation, ..material(young, nu) };
        let total = [0.0, 0.0, force].map(Field::Constant);
        let load = Load::Force { faces: faces_where(&mesh, |x| x[0] == length), total };
        // The root may contract freely, as the theory of beams supposes.
        let fixes = [
            Fix {
                nodes: nodes_where(&mesh, |x| x[0] == 0.0),
                value: [Some(Field::Constant(0.0)), None, None],
                ..Fix::default()
            },
            Fix {
                nodes: nodes_where(&mesh, |x| x[0] == 0.0 && x[1] == 0.5),
                value: [None, Some(Field::Constant(0.0)), None],
                ..Fix::default()
            },
            Fix {
                nodes: nodes_where(&mesh, |x| x[0] == 0.0 && x[2] == 0.5),
                value: [None, None, Some(Field::Constant(0.0))],
                ..Fix::default()
            },
        ];
        let u = solve(&mesh, &material, &[load], &fixes);
        u[3 * nodes_where(&mesh, |x| x == [length, 0.5, 0.5])[0] as usize + 2]
    };
    let (bbar, auto, full) = (tip(Formulation::BBar), tip(Formulation::Auto), tip(Formulation::Full));
    assert!((bbar / theory - 1.0).abs() < 0.04, "B-bar {bbar:e}, beam {theory:e}");
    assert_eq!(bbar, auto);
    assert!(full < 0.9 * bbar, "full {full:e}, B-bar {bbar:e}");
}
