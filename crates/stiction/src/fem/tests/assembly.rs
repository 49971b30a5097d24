//! The split into unknown and prescribed, threads, and the messages for prescriptions that cannot be used.

use super::super::elements::{Hex8, Law, Tet4};
use super::*;

fn clamp(nodes: Vec<u32>, value: f64) -> Fix {
    Fix { nodes, value: [Some(Field::Constant(value)), Some(Field::Constant(value)), None], ..Fix::default() }
}

#[test]
fn the_split_matrices_are_the_parts_of_the_free_body() {
    for kind in KINDS {
        let mesh = brick(kind, [3, 2, 2], [3.0, 1.0, 1.0]);
        let material = material(2.0, 0.3);
        let total = [1.0, 2.0, 3.0].map(Field::Constant);
        let load = Load::Force { faces: (0..mesh.faces.len() as u32).collect(), total };
        let whole = model_of(&mesh, &material, std::slice::from_ref(&load), &[]).unwrap();
        let fix = clamp(nodes_where(&mesh, |x| x[0] == 0.0), 0.25);
        let part = model_of(&mesh, &material, &[load], &[fix]).unwrap();
        assert_eq!(part.dofs.free.len() + part.dofs.prescribed.len(), whole.stiffness.rows);

        let same = |found: &Csr, rows: &[u32], columns: &[u32]| {
            found.validate("part").unwrap();
            assert_eq!((found.rows, found.cols), (rows.len(), columns.len()));
            for (i, &row) in rows.iter().enumerate() {
                for (j, &column) in columns.iter().enumerate() {
                    assert_eq!(found.entry(i, j), whole.stiffness.entry(row as usize, column as usize));
                }
            }
        };
        let (free, prescribed) = (&part.dofs.free, &part.dofs.prescribed);
        part.stiffness.validate("K").unwrap();
        same(&part.stiffness.full(), free, free);
        same(&part.support_stiffness, prescribed, free);
        same(&part.support_support, prescribed, prescribed);

        let demanded = part.support_stiffness.transpose_times(&part.dofs.value);
        for ((&dof, load), demanded) in free.iter().zip(&part.load).zip(demanded) {
            assert!((load - (whole.load[dof as usize] - demanded)).abs() < 1e-13);
        }
        assert!(prescribed.iter().zip(&part.support_load).all(|(&dof, &load)| load == whole.load[dof as usize]));
    }
}

#[test]
fn the_result_is_the_same_to_the_bit_for_any_number_of_threads() {
    for kind in KINDS {
        // Enough nodes for other ranges with other numbers of threads.
        let cells = if kind.edges().is_empty() { [36, 24, 20] } else { [20, 12, 12] };
        let mut mesh = brick(kind, cells, [3.0, 1.0, 1.0]);
        distort(&mut mesh, 0.01);
        let run = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let cells = (0..mesh.cell_count() as u32).collect();
            let load = Load::Gravity { cells, acceleration: [0, 1, 2].map(|c| function(move |x| x[c].sin())) };
            let fix = clamp(nodes_where(&mesh, |x| x[0] == 0.0), 0.1);
            pool.install(|| model_of(&mesh, &material(2.0, 0.47), &[load], &[fix]).unwrap())
        };
        let (one, two) = (run(1), run(5));
        assert!(one.stiffness.start.len() == two.stiffness.start.len() && one.stiffness == two.stiffness);
        assert!(one.load == two.load && one.support_load == two.support_load);
        assert!(one.support_stiffness == two.support_stiffness && one.support_support == two.support_support);
    }
}

#[test]
fn two_different_prescriptions_of_one_component_are_refused() {
    let mesh = brick(CellKind::Tet4, [1, 1, 1], [1.0; 3]);
    let pose = |second| model_of(&mesh, &material(1.0, 0.3), &[], &[clamp(vec![0, 1], 1.0), clamp(vec![1], second)]);
    assert_eq!(pose(1.0 + 1e-15).unwrap().dofs.prescribed.len(), 4);
    let error = pose(1.5).unwrap_err().to_string();
    assert!(error.contains("(1, 0, 0)") && error.contains("1 and 1.5") && error.contains("fix 2"), "{error}");
}

#[test]
fn problems_that_cannot_be_posed_say_why() {
    let mesh = brick(CellKind::Tet4, [1, 1, 1], [1.0; 3]);
    let steel = material(1.0, 0.3);
    let error = |mesh: &Mesh, fixes: &[Fix]| model_of(mesh, &steel, &[], fixes).unwrap_err().to_string();
    let nan = Field::Function { text: "0/0".into(), value: Arc::new(|_, _| f64::NAN) };
    let fix = Fix { nodes: vec![7], value: [None, None, Some(nan)], ..Fix::default() };
    let found = error(&mesh, &[fix]);
    assert!(found.contains("\"0/0\" is NaN at (1, 1, 1)"), "{found}");
    assert!(error(&mesh, &[clamp(vec![8], 0.0)]).contains("node 8 does not exist"));

    let empty = Mesh { cells: vec![], ..mesh.clone() };
    assert!(error(&empty, &[]).contains("no cell"));
    let mut lonely = mesh.clone();
    lonely.nodes.push([9.0, 0.0, 0.0]);
    assert!(error(&lonely, &[]).contains("(9, 0, 0)"));
    let solid = Solid { mesh: &mesh, materials: &[], material_of_cell: &[0; 5] };
    assert!(assemble(&solid, &[], &[], 0.0).unwrap_err().to_string().contains("no material"));
    let solid = Solid { mesh: &mesh, materials: &[], material_of_cell: &[] };
    assert!(assemble(&solid, &[], &[], 0.0).is_err());
}

/// Cells of which some are equal, of two materials, and some like no other; of one kind and of both.
#[test]
fn the_stiffness_is_the_sum_over_the_cells_to_the_bit() {
    for kinds in [&[CellKind::Tet4][..], &[CellKind::Hex8], &[CellKind::Hex8, CellKind::Tet4]] {
        let mut mesh = brick(kinds[0], [32, 15, 10], [32.0, 15.0, 10.0]);
        for &kind in &kinds[1..] {
            let mut other = brick(kind, [5, 4, 3], [5.0, 4.0, 3.0]);
            let first = mesh.nodes.len() as u32;
            other.cells[0].nodes.iter_mut().for_each(|i| *i += first);
            mesh.nodes.append(&mut other.nodes);
            mesh.cells.append(&mut other.cells);
        }
        for x in mesh.nodes.iter_mut().filter(|x| x[0] > 6.0) {
            x[2] += 0.1 * (x[0] + 1.7 * x[1]).sin();
        }
        let materials = [material(2.0, 0.3), material(3.0, 0.47)];
        let material_of_cell: Vec<u32> = (0..mesh.cell_count() as u32).map(|cell| cell / 7 % 2).collect();
        let solid = Solid { mesh: &mesh, materials: &materials, material_of_cell: &material_of_cell };
        let mut entries = Vec::new();
        for ((kind, nodes), &m) in mesh.cell_iter().zip(&material_of_cell) {
            let law = Law::new(&materials[m as usize]);
            let corners = |i: usize| mesh.nodes[nodes[i] as usize];
            let (tet, hex) = match kind {
                CellKind::Tet4 => (Tet4::new(&std::array::from_fn(corners)), None),
                _ => (None, Hex8::new(&std::array::from_fn(corners))),
            };
            for (i, &row) in nodes.iter().enumerate() {
                let tet = tet.iter().flat_map(|e| e.row(i, law));
                for (&j, block) in nodes.iter().zip(tet.chain(hex.iter().flat_map(|e| e.row(i, law)))) {
                    let places = (0..9).map(|k| (k / 3, k % 3));
                    entries.extend(places.map(|(a, b)| (3 * row as usize + a, 3 * j as usize + b, block[a][b])));
                }
            }
        }
        let n = 3 * mesh.nodes.len();
        let found = assemble(&solid, &[], &[], 0.0).unwrap().stiffness.full();
        assert!(found == Csr::from_triplets(n, n, &entries), "{kinds:?}");
    }
}
