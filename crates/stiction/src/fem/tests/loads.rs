//! Consistent loads against integrals done by hand, and the messages for loads that cannot be used.

use super::*;

/// Sum of nodal forces of one load.
fn resultant(mesh: &Mesh, load: Load) -> [f64; 3] {
    let force = forces(mesh, load).unwrap();
    force.chunks_exact(3).fold([0.0; 3], |sum, f| v3::add(sum, [f[0], f[1], f[2]]))
}

fn forces(mesh: &Mesh, load: Load) -> Result<Vec<f64>, crate::Error> {
    let materials = [Material { density: 7.8, ..material(1.0, 0.3) }];
    let solid = Solid { mesh, materials: &materials, material_of_cell: &vec![0; mesh.cell_count()] };
    external_forces(&solid, &[load], 0.0)
}

fn close(a: [f64; 3], b: [f64; 3]) -> bool {
    v3::norm(v3::sub(a, b)) < 1e-12 * (1.0 + v3::norm(b))
}

#[test]
fn nodal_forces_sum_to_the_integral_of_the_traction() {
    for kind in KINDS {
        let mesh = brick(kind, [2, 3, 1], [2.0, 3.0, 1.0]);
        let faces = faces_where(&mesh, |x| x[2] == 1.0);
        // ∫ over [0,2] x [0,3] of x^4, x^2 y^2 and 1 + x y^3.
        let value =
            [function(|x| x[0].powi(4)), function(|x| (x[0] * x[1]).powi(2)), function(|x| 1.0 + x[0] * x[1].powi(3))];
        let exact = [32.0 / 5.0 * 3.0, 8.0 / 3.0 * 9.0, 6.0 + 2.0 * 81.0 / 4.0];
        assert!(close(resultant(&mesh, Load::Traction { faces: faces.clone(), value }), exact), "{kind:?}");

        // The moment of a linear traction about the y axis: ∫ x (x) = 8/3 * 3.
        let value = [Field::Constant(0.0), Field::Constant(0.0), function(|x| x[0])];
        let force = forces(&mesh, Load::Traction { faces, value }).unwrap();
        let moment: f64 = mesh.nodes.iter().zip(force.chunks_exact(3)).map(|(x, f)| x[0] * f[2]).sum();
        assert!((moment - 8.0).abs() < 1e-12);
    }
}

#[test]
fn pressure_on_a_closed_surface_has_no_resultant_and_pushes_inwards() {
    for kind in KINDS {
        let mut mesh = brick(kind, [2, 2, 2], [1.0; 3]);
        // Warped quadrilaterals: every node moves, in a way that is not affine.
        mesh.nodes
            .iter_mut()
            .for_each(|x| *x = [x[0] + 0.2 * x[1] * x[2], x[1] - 0.1 * x[0] * x[2], x[2] + 0.3 * x[0] * x[1]]);
        let all: Vec<u32> = (0..mesh.faces.len() as u32).collect();
        let pressure = |faces| Load::Pressure { faces, value: Field::Constant(5.0) };
        assert!(close(resultant(&mesh, pressure(all)), [0.0; 3]));

        let block = brick(kind, [2, 2, 2], [1.0, 2.0, 3.0]);
        let top = faces_where(&block, |x| x[2] == 3.0);
        assert!(close(resultant(&block, pressure(top)), [0.0, 0.0, -10.0]));
    }
}

#[test]
fn a_total_force_arrives_whole_and_gravity_weighs_the_mass() {
    for kind in KINDS {
        let mut mesh = brick(kind, [3, 3, 3], [2.0, 1.0, 1.0]);
        distort(&mut mesh, 0.05);
        let faces = faces_where(&mesh, |x| x[0] == 2.0);
        let total = [1.0, -2.0, 3.0];
        assert!(close(resultant(&mesh, Load::Force { faces, total: total.map(Field::Constant) }), total));
        let cells = (0..mesh.cell_count() as u32).collect();
        let acceleration = [0.0, 0.0, -9.81].map(Field::Constant);
        let weight = resultant(&mesh, Load::Gravity { cells, acceleration });
        assert!(close(weight, [0.0, 0.0, -9.81 * 7.8 * 2.0]));
    }
}

#[test]
fn normals_at_nodes_point_outwards() {
    for kind in KINDS {
        let mesh = brick(kind, [2, 3, 2], [2.0, 3.0, 1.0]);
        let top = faces_where(&mesh, |x| x[2] == 1.0);
        let normals = nodal_normals(&mesh, &top);
        let on_top = nodes_where(&mesh, |x| x[2] == 1.0).len();
        assert!(normals.windows(2).all(|w| w[0].0 < w[1].0) && normals.len() == on_top);
        assert!(normals.iter().all(|(_, n)| close(*n, [0.0, 0.0, 1.0])));
        let all: Vec<u32> = (0..mesh.faces.len() as u32).collect();
        let corner = nodal_normals(&mesh, &all)[0].1;
        assert!(corner.iter().all(|c| *c < 0.0) && (v3::norm(corner) - 1.0).abs() < 1e-14);
    }
    // One face seen from both sides, as on a plate without thickness: the normals cancel.
    let mut plate = brick(CellKind::Hex8, [1, 1, 1], [1.0; 3]);
    plate.faces[1] = Face::of_cell(CellKind::Hex8, &[0, 1, 2, 3, 0, 1, 2, 3].map(|i| plate.cells[0].nodes[i]), 0, 1);
    let normals = nodal_normals(&plate, &[0, 1]);
    assert!(normals.iter().all(|(_, n)| *n == [0.0; 3]), "{normals:?}");
}

#[test]
fn a_pressure_on_a_closed_curved_surface_pushes_nowhere_and_turns_nothing() {
    // The divergence theorem, to rounding, because the rules are exact on curved quadratic faces.
    for kind in [CellKind::Tet10, CellKind::Hex20] {
        let mut mesh = brick(kind, [2, 2, 2], [1.0; 3]);
        mesh.nodes.iter_mut().enumerate().for_each(|(i, x)| x[i % 3] += 0.03 * (1.3 * i as f64).sin());
        let all: Vec<u32> = (0..mesh.faces.len() as u32).collect();
        let f = forces(&mesh, Load::Pressure { faces: all, value: Field::Constant(2.0) }).unwrap();
        let mut sums = [[0.0; 3]; 2];
        for (f, x) in f.chunks_exact(3).zip(&mesh.nodes) {
            let f = [f[0], f[1], f[2]];
            sums = [v3::add(sums[0], f), v3::add(sums[1], v3::cross(*x, f))];
        }
        assert!(sums.as_flattened().iter().all(|s| s.abs() < 1e-14), "{kind:?} {sums:?}");
        // and a field with unit divergence finds the volume, which the cells add up to
        let flux: f64 = f.chunks_exact(3).zip(&mesh.nodes).map(|(f, x)| f[0] * x[0] + f[1] * x[1] + f[2] * x[2]).sum();
        assert!((flux + 2.0 * 3.0 * mesh.volume()).abs() < 1e-13);
    }
}

#[test]
fn loads_that_cannot_be_used_say_what_is_wrong() {
    let mesh = brick(CellKind::Tet4, [1, 1, 1], [1.0; 3]);
    let says = |load, words: &str| {
        let error = forces(&mesh, load).unwrap_err().to_string();
        assert!(error.contains(words) && error.starts_with("load 1"), "{error}");
    };
    let inverse = || Field::Function { text: "1/x".into(), value: Arc::new(|x, _| 1.0 / (x[0] * 0.0)) };
    let zero = || Field::Constant(0.0);
    let total = [Field::Function { text: "x".into(), value: Arc::new(|x, _| x[0]) }, zero(), zero()];
    says(Load::Pressure { faces: vec![0], value: inverse() }, "\"1/x\" is inf at (");
    says(Load::Traction { faces: vec![], value: [zero(), zero(), zero()] }, "no boundary face");
    says(Load::Traction { faces: vec![99], value: [zero(), zero(), zero()] }, "99 does not exist");
    says(Load::Force { faces: vec![0], total }, "time t only");
    says(Load::Gravity { cells: vec![99], acceleration: [zero(), zero(), zero()] }, "cell 99");

    let weightless = Material { density: 0.0, ..material(1.0, 0.3) };
    let gravity = Load::Gravity { cells: vec![0], acceleration: [zero(), zero(), zero()] };
    assert!(model_of(&mesh, &weightless, &[gravity], &[]).unwrap_err().to_string().contains("density"));

    let mut flat = mesh.clone();
    flat.nodes.iter_mut().for_each(|x| *x = [0.0; 3]);
    let force = Load::Force { faces: vec![0], total: [zero(), zero(), zero()] };
    assert!(forces(&flat, force).unwrap_err().to_string().contains("no area"));
}
