use super::*;
use crate::mesh::{MeshNote, RawCells, RawGroup, bodies, info};

/// Corners of the unit cube, x fastest, and the point (2, 1, 1) beyond it.
fn corners() -> Vec<[f64; 3]> {
    let mut nodes: Vec<[f64; 3]> = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f64::from)).collect();
    nodes.push([2.0, 1.0, 1.0]);
    nodes
}

fn tets(nodes: &[u32]) -> RawCells {
    RawCells {
        kind: CellKind::Tet4,
        nodes: nodes.to_vec(),
        ids: (0..).map(|i| 101 + i).take(nodes.len() / 4).collect(),
    }
}

fn mesh_of(cells: Vec<RawCells>) -> RawMesh {
    RawMesh { nodes: corners(), cells, ..RawMesh::default() }
}

fn message(raw: RawMesh) -> String {
    build(raw).unwrap_err().to_string()
}

const TWO: [u32; 8] = [0, 1, 2, 4, 1, 2, 4, 7];

#[test]
fn two_tetrahedra_share_one_face() {
    let mut raw = mesh_of(vec![tets(&TWO)]);
    let faces =
        vec![[2, 4, 1, u32::MAX], [1, 2, 4, u32::MAX], [1, 2, 0, u32::MAX], [0, 1, 3, u32::MAX], [0, 1, 7, u32::MAX]];
    raw.groups.push(RawGroup { name: "g".into(), faces, nodes: vec![7, 3, 7], ..RawGroup::default() });
    raw.groups.push(RawGroup { name: "none".into(), ..RawGroup::default() });
    let (mesh, notes) = build(raw).unwrap();
    assert_eq!((mesh.faces.len(), mesh.nodes.len()), (6, 5));
    let g = &mesh.groups[0];
    // 0 1 2 is boundary, 1 2 4 lies between (given twice), 0 1 7 is no face; 3 belongs to no cell; 7 is node 4 now
    assert_eq!((g.faces.len(), g.interior_faces.len(), g.nodes.as_slice()), (1, 2, &[4][..]));
    assert!(mesh.face_normal(g.faces[0] as usize)[2] == -1.0);
    assert_eq!(
        notes.0,
        [
            MeshNote::OrphanNodes { count: 4, first: vec![4, 6, 7, 9] },
            MeshNote::InteriorFaces { group: "g".into(), count: 2 },
            MeshNote::LooseFaces { group: "g".into(), count: 2 },
            MeshNote::GroupNodesDropped { group: "g".into(), count: 1, first: vec![4] },
            MeshNote::EmptyGroup { group: "none".into() },
        ]
    );
    assert_eq!(mesh.group_nodes(g), [0, 1, 2, 3, 4]);
}

#[test]
fn unusable_cells_are_named_by_their_numbers_in_the_file() {
    let cases: [(&[u32], &[&str]); 7] = [
        (&[0, 1, 2, 4, 1, 4, 2, 7], &["element 102", "1 cell inside out", "smoothed"]),
        (&[0, 1, 2, 3], &["element 101", "without volume"]),
        (&[0, 1, 1, 3], &["element 101", "repeated node"]),
        (&[0, 1, 2, 4, 0, 1, 2, 99], &["element 102", "broken node list"]),
        (&[0, 1, 2, 4, 1, 2, 0, 4], &["2 cells given more than once: 101, 102"]),
        (&[0, 1, 2, 4, 0, 1, 2, 7], &["2 cells on the same side of a face", "101, 102"]),
        (&[1, 2, 4, 7, 0, 1, 2, 4, 1, 2, 4, 8], &["at a face that more than two cells share", "101, 102, 103"]),
    ];
    for (cells, words) in cases {
        let said = message(mesh_of(vec![tets(cells)]));
        assert!(words.iter().all(|w| said.contains(w)), "{said}");
    }
    let mut raw = mesh_of(vec![tets(&TWO)]);
    raw.nodes[2][1] = f64::NAN;
    assert!(message(raw).starts_with("node 3: 1 node with a coordinate that is not a finite number: 3"));
    assert!(message(mesh_of(vec![])).contains("no cells"));
    assert!(message(mesh_of(vec![tets(&[0, 1, 2])])).contains("broken node list"));
    let mut raw = mesh_of(vec![tets(&TWO)]);
    raw.groups.push(RawGroup { name: "g".into(), faces: vec![[0, 1, 2, 77]], ..RawGroup::default() });
    assert!(message(raw).starts_with("group \"g\""));
}

#[test]
fn a_hexahedron_with_a_dent_is_refused_though_its_volume_is_positive() {
    let hex = |nodes: Vec<[f64; 3]>| {
        let cells = RawCells { kind: CellKind::Hex8, nodes: vec![0, 1, 3, 2, 4, 5, 7, 6], ids: vec![55] };
        build(RawMesh { nodes, cells: vec![cells], ..RawMesh::default() })
    };
    let mut nodes = corners();
    nodes.pop();
    assert!((hex(nodes.clone()).unwrap().0.volume() - 1.0).abs() < 1e-15);
    // the corner (1, 1, 1) pushed behind the plane of its three neighbours: their edges there turn left-handed
    nodes[7] = [0.45; 3];
    assert!(hex(nodes).unwrap_err().to_string().contains("1 cell inside out"));
}

#[test]
fn nodes_at_the_same_place_are_noted_but_not_joined() {
    let mut raw = mesh_of(vec![tets(&[0, 1, 2, 4, 8, 9, 10, 7])]);
    raw.nodes.truncate(8);
    raw.nodes.extend([[1.0, 0.0, 0.0], [0.0, 1.0, 1e-12], [0.0, 0.0, 1.0]]);
    let (mesh, notes) = build(raw).unwrap();
    assert_eq!(bodies(&mesh), [0, 0, 0, 0, 1, 1, 1, 1]);
    let found = notes.0.iter().find_map(|n| match n {
        MeshNote::CoincidentNodes { pairs, first, .. } => Some((*pairs, *first)),
        _ => None,
    });
    assert_eq!(found, Some((3, [2, 9])));
}

#[test]
fn tetrahedra_against_a_hexahedron_are_noted_as_not_joined() {
    let hex = RawCells { kind: CellKind::Hex8, nodes: vec![0, 1, 3, 2, 4, 5, 7, 6], ids: vec![55] };
    // two tetrahedra on the face x = 1 of the cube, with their tip at (2, 1, 1)
    let (mesh, notes) = build(mesh_of(vec![tets(&[1, 3, 7, 8, 1, 7, 5, 8]), hex])).unwrap_or_else(|e| panic!("{e}"));
    assert_eq!(notes.0, [MeshNote::UnjoinedFaces { count: 1, first: vec![55] }]);
    assert_eq!(mesh.cell(2).0, CellKind::Hex8);
    // the edges of the touching faces belong to both boundaries
    assert_eq!(info(&mesh).non_manifold_edges, 4);
}

#[test]
fn two_bodies_that_touch_along_an_edge_have_a_non_manifold_edge() {
    // 0 1 2 4 and a mirrored copy on the other side of the edge 1-2, which share only that edge
    let mut raw = mesh_of(vec![tets(&[0, 1, 2, 4, 3, 2, 1, 8])]);
    raw.nodes[8] = [1.0, 1.0, 1.0];
    let (mesh, _) = build(raw).unwrap();
    let info = info(&mesh);
    assert_eq!((info.open_edges, info.non_manifold_edges, info.bodies), (0, 1, 1));
    assert!((info.volume - 1.0 / 3.0).abs() < 1e-15);
}

#[test]
fn the_summary_reads_as_a_table() {
    let mut raw = mesh_of(vec![tets(&TWO)]);
    raw.groups.push(RawGroup { name: "all of it".into(), cells: vec![0, 1], ..RawGroup::default() });
    let said = info(&build(raw).unwrap().0).to_string();
    for line in ["nodes       5", "volume      0.5", "bodies      1", "all of it         2"] {
        assert!(said.contains(line), "{said}");
    }
}
