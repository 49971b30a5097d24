//! Wedges beside other cells, and the faces of wedges in decks.

use std::fmt::Write;

use stiction::io::deck;
use stiction::mesh::CellKind;
use stiction::run::{Outcome, Prepared, body_fields};
use stiction_fixtures::case_run::{at, solved_case};

fn solved(text: &str) -> (Outcome, Prepared) {
    let deck = deck::parse(text.as_bytes(), "deck.inp", &|name| Err(format!("there is no {name}")));
    let deck = deck.unwrap_or_else(|e| panic!("{e}"));
    solved_case(&deck.case(&[]).unwrap_or_else(|e| panic!("{e}\n{}", deck.text)))
}

/// An L of unit boxes: at its corner two wedges, beside them a hexahedron, on them six tetrahedra. Under the pressure p
/// all around each length shrinks by `(1 - 2 nu) p / E`, whatever the cells.
#[test]
fn tetrahedra_wedges_and_hexahedra_of_one_body_share_a_uniform_state() {
    let label = |[i, j, k]: [usize; 3]| 1 + i + 3 * j + 6 * k;
    let mut text = String::from("*NODE\n");
    for at in (0..18).map(|n| [n % 3, n / 3 % 2, n / 6]).filter(|at| at[0] < 2 || at[2] < 2) {
        writeln!(text, "{}, {}, {}, {}", label(at), at[0], at[1], at[2]).unwrap();
    }
    // Corners of a box by bits: 1 for x, 2 for y, 4 for z.
    let corner = |[i, k]: [usize; 2], bits: usize| label([i + (bits & 1), bits >> 1 & 1, k + (bits >> 2)]);
    let tets = [[0, 1, 3, 7], [0, 2, 6, 7], [0, 4, 5, 7], [0, 5, 1, 7], [0, 3, 2, 7], [0, 6, 4, 7]];
    let cells = [
        ("C3D6", [0, 0], vec![vec![0, 1, 3, 4, 5, 7], vec![0, 3, 2, 4, 7, 6]]),
        ("C3D8", [1, 0], vec![vec![0, 1, 3, 2, 4, 5, 7, 6]]),
        ("C3D4", [0, 1], tets.map(|tet| tet.to_vec()).to_vec()),
    ];
    let mut number = 0;
    for (kind, place, cells) in cells {
        writeln!(text, "*ELEMENT, TYPE={kind}, ELSET=ALL").unwrap();
        for cell in cells {
            number += 1;
            let nodes: Vec<String> = cell.into_iter().map(|bits| corner(place, bits).to_string()).collect();
            writeln!(text, "{number}, {}", nodes.join(", ")).unwrap();
        }
    }
    text += "*SURFACE, NAME=SKIN\nALL,\n*MATERIAL, NAME=M\n*ELASTIC\n1000., 0.3\n*SOLID SECTION, ELSET=ALL, MATERIAL=M\n*BOUNDARY\n";
    for at in (0..18).map(|n| [n % 3, n / 3 % 2, n / 6]).filter(|at| at[0] < 2 || at[2] < 2) {
        (0..3).filter(|&c| at[c] == 0).for_each(|c| writeln!(text, "{}, {}", label(at), c + 1).unwrap());
    }
    text += "*STEP\n*STATIC\n*DSLOAD\nSKIN, P, 5.\n*END STEP\n";
    let run = solved(&text);
    let kinds: Vec<CellKind> = run.1.mesh.cells.iter().filter(|cells| !cells.is_empty()).map(|c| c.kind).collect();
    assert_eq!(kinds, [CellKind::Tet4, CellKind::Hex8, CellKind::Wedge6]);
    let shrinks = 5.0 * (1.0 - 0.6) / 1000.0;
    for x in run.1.mesh.nodes.clone() {
        let u = at(&run, x);
        assert!((0..3).all(|c| (u[c] + shrinks * x[c]).abs() < 1e-12), "{x:?} {u:?}");
    }
}

/// P1 is the first triangle, P2 the second, P3 to P5 the quadrilaterals over the edges 12, 23 and 31 (CalculiX manual,
/// section "*DLOAD"): the reaction is against the pressure times the area of the face.
#[test]
fn the_faces_of_wedges_have_the_numbers_of_the_manual() {
    let corners =
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]];
    let edges = [[0, 1], [1, 2], [2, 0], [3, 4], [4, 5], [5, 3], [0, 3], [1, 4], [2, 5]];
    for quadratic in [false, true] {
        let mut nodes = corners.to_vec();
        if quadratic {
            nodes.extend(edges.map(|[a, b]: [usize; 2]| [0, 1, 2].map(|c| 0.5 * (corners[a][c] + corners[b][c]))));
        }
        let half = 0.5f64.sqrt();
        let inward = [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0], [-half, -half, 0.0], [1.0, 0.0, 0.0]];
        for (face, inward) in (1..).zip(inward) {
            let mut text = String::from("*NODE, NSET=N\n");
            for (i, [x, y, z]) in (1..).zip(&nodes) {
                writeln!(text, "{i}, {x}, {y}, {z}").unwrap();
            }
            let list: Vec<String> = (1..=nodes.len()).map(|i| i.to_string()).collect();
            writeln!(text, "*ELEMENT, TYPE=C3D{}, ELSET=E\n1, {}", nodes.len(), list.join(", ")).unwrap();
            // The bottom is held, for a load on it the top.
            let level = if face == 1 { 1.0 } else { 0.0 };
            let held: Vec<usize> = (0..nodes.len()).filter(|&i| nodes[i][2] == level).collect();
            text += "*MATERIAL, NAME=M\n*ELASTIC\n1000., 0.\n*SOLID SECTION, ELSET=E, MATERIAL=M\n*BOUNDARY\n";
            held.iter().for_each(|i| writeln!(text, "{}, 1, 3", i + 1).unwrap());
            writeln!(text, "*STEP\n*STATIC\n*DLOAD\nE, P{face}, 1.\n*END STEP").unwrap();
            let run = solved(&text);
            let mut sum = [0.0; 3];
            for force in body_fields(&run.1, &run.0).reaction {
                (0..3).for_each(|c| sum[c] += force[c]);
            }
            let area = if face < 3 { 0.5 } else { [1.0, 2f64.sqrt(), 1.0][face - 3] };
            assert!(
                (0..3).all(|c| (sum[c] + area * inward[c]).abs() < 1e-12),
                "{} nodes, P{face}: {sum:?}",
                nodes.len()
            );
        }
    }
}
