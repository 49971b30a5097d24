use super::*;
use crate::mesh::{bodies, info};

fn unit(cells: [usize; 3], element: BlockElement) -> Block {
    Block { size: [1.0; 3], cells, origin: [0.0; 3], grading: [1.0; 3], element }
}

pub(in crate::mesh) const ELEMENTS: [BlockElement; 10] = [
    BlockElement::Tet10Five { parity: 0 },
    BlockElement::Tet10Five { parity: 1 },
    BlockElement::Tet10Six,
    BlockElement::Hex20,
    BlockElement::Wedge6,
    BlockElement::Wedge15,
    BlockElement::Tet4Five { parity: 0 },
    BlockElement::Tet4Five { parity: 1 },
    BlockElement::Tet4Six,
    BlockElement::Hex8,
];

#[test]
fn volume_and_area_are_those_of_the_box() {
    for element in ELEMENTS {
        let b = Block {
            size: [3.0, 1.0, 0.5],
            cells: [4, 3, 5],
            origin: [-1.0, 2.0, 7.0],
            grading: [2.0, 1.0, 0.1],
            element,
        };
        let mesh = block(&b).unwrap();
        assert!((mesh.volume() - 1.5).abs() < 1e-13);
        let area = |name| mesh.group(name).unwrap().faces.iter().map(|&f| mesh.face_area(f as usize)).sum::<f64>();
        for (names, expected) in [(["x-min", "x-max"], 0.5), (["y-min", "y-max"], 1.5), (["z-min", "z-max"], 3.0)] {
            for name in names {
                assert!((area(name) - expected).abs() < 1e-13, "{name} {element:?}");
            }
        }
        // conforming: what is not on a side is shared by two cells, so the sides are the whole boundary
        let on_sides: usize = mesh.groups[..6].iter().map(|g| g.faces.len()).sum();
        assert_eq!(on_sides, mesh.faces.len());
        let info = info(&mesh);
        assert!((info.area - 10.0).abs() < 1e-12);
        assert_eq!((info.open_edges, info.non_manifold_edges, info.bodies), (0, 0, 1));
        assert_eq!(mesh.group("body").unwrap().cells.len(), mesh.cell_count());
        assert_eq!(bodies(&mesh), vec![0; mesh.nodes.len()]);
    }
}

#[test]
fn normals_point_outward() {
    for element in ELEMENTS {
        let mesh = block(&Block { origin: [5.0, -3.0, 2.0], ..unit([2, 3, 4], element) }).unwrap();
        // divergence theorem: sum of x.n A = 3 V for the field x, sum of n A = 0 for constants
        let mut flux = 0.0;
        let mut closed = [0.0; 3];
        for (f, face) in mesh.faces.iter().enumerate() {
            let area = mesh.face_vector_area(f);
            let x = mesh.nodes[face.nodes()[0] as usize];
            for c in 0..3 {
                flux += x[c] * area[c];
                closed[c] += area[c];
            }
        }
        assert!((flux - 3.0).abs() < 1e-12);
        assert!(closed.iter().all(|c| c.abs() < 1e-14));
        for (name, axis, sign) in [("x-min", 0, -1.0), ("y-max", 1, 1.0), ("z-min", 2, -1.0)] {
            for &f in &mesh.group(name).unwrap().faces {
                assert!((mesh.face_normal(f as usize)[axis] - sign).abs() < 1e-14);
            }
        }
    }
}

#[test]
fn parity_chooses_the_corners_of_the_central_tetrahedron() {
    let corners = |parity| {
        let mesh = block(&unit([1, 1, 1], BlockElement::Tet4Five { parity })).unwrap();
        // the central one is the largest: a third of the cube, the others a sixth
        let central = (0..5).find(|&i| mesh.cell_volume(i) > 0.3).unwrap();
        let mut x: Vec<[f64; 3]> = mesh.cell(central).1.iter().map(|&n| mesh.nodes[n as usize]).collect();
        x.sort_by(|a, b| a.partial_cmp(b).unwrap());
        assert!((mesh.cell_volume(central) - 1.0 / 3.0).abs() < 1e-15);
        x
    };
    assert_eq!(corners(0), [[0.0, 0.0, 1.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 1.0]]);
    assert_eq!(corners(1), [[0.0, 0.0, 0.0], [0.0, 1.0, 1.0], [1.0, 0.0, 1.0], [1.0, 1.0, 0.0]]);
}

#[test]
fn six_tetrahedra_share_the_main_diagonal_of_their_cell() {
    let mesh = block(&unit([1, 1, 1], BlockElement::Tet4Six)).unwrap();
    assert_eq!(mesh.cell_count(), 6);
    assert!(mesh.cell_iter().all(|(_, c)| c.contains(&0) && c.contains(&7)));
    assert!((0..6).all(|i| (mesh.cell_volume(i) - 1.0 / 6.0).abs() < 1e-16));
}

#[test]
fn uniform_nodes_are_exact_and_numbered_with_x_fastest() {
    let b =
        Block { size: [3.0, 0.7, 1.1], cells: [7, 3, 2], origin: [0.1, 0.2, 0.3], ..unit([1; 3], BlockElement::Hex8) };
    let mesh = block(&b).unwrap();
    assert_eq!(mesh.nodes.len(), 8 * 4 * 3);
    let node = mesh.nodes[5 + 8 * (2 + 4)];
    assert_eq!(node, [0.1 + 3.0 * 5.0 / 7.0, 0.2 + 0.7 * 2.0 / 3.0, 0.3 + 1.1 * 1.0 / 2.0]);
}

#[test]
fn graded_cells_grow_in_geometric_progression() {
    let b = Block { cells: [4, 1, 1], grading: [8.0, 1.0, 1.0], ..unit([4, 1, 1], BlockElement::Hex8) };
    let mesh = block(&b).unwrap();
    // lengths 1 2 4 8 over 15
    for (node, expected) in mesh.nodes.iter().zip([0.0, 1.0, 3.0, 7.0, 15.0]) {
        assert!((node[0] - expected / 15.0).abs() < 1e-15);
    }
}

#[test]
fn blocks_that_cannot_be_are_refused() {
    let good = unit([2, 2, 2], BlockElement::Hex8);
    let bad = [
        Block { size: [1.0, 0.0, 1.0], ..good.clone() },
        Block { size: [1.0, f64::NAN, 1.0], ..good.clone() },
        Block { size: [1e-300, 1.0, 1.0], origin: [1.0; 3], ..good.clone() },
        Block { cells: [2, 2, 0], ..good.clone() },
        Block { cells: [usize::MAX; 3], ..good.clone() },
        Block { cells: [2000; 3], ..good.clone() },
        Block { origin: [f64::INFINITY, 0.0, 0.0], ..good.clone() },
        Block { grading: [-1.0, 1.0, 1.0], ..good.clone() },
        Block { grading: [1.0, f64::INFINITY, 1.0], ..good.clone() },
        Block { cells: [2000, 1, 1], grading: [1e300, 1.0, 1.0], origin: [1.0; 3], ..good.clone() },
        Block { element: BlockElement::Tet4Five { parity: 2 }, ..good.clone() },
        Block { size: [1.0, 1.0, 1e-200], element: BlockElement::Tet4Six, ..good },
    ];
    for b in bad {
        let result = block(&b);
        assert!(result.is_err(), "{b:?}");
        assert!(result.unwrap_err().to_string().starts_with("block"));
    }
}
