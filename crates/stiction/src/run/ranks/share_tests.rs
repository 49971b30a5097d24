//! Meshes that ranks read by ranges of the file, against the same file read by rank 0 as a whole.

use std::path::{Path, PathBuf};

use super::*;
use crate::io::case;
use crate::io::gmsh::written::{PLAIN, Style, written};
use crate::io::vtu_mesh::write_mesh;
use crate::mesh::{Block, BlockElement, block, join};
use crate::ranks::{Alone, threads};

const SIZES: [usize; 4] = [1, 2, 3, 5];

/// A file in the folder for such things.
fn path(name: &str) -> PathBuf {
    std::env::temp_dir().join(format!("stiction-ranges-{}-{name}", std::process::id()))
}

fn case_on(path: &Path, more: &str) -> Case {
    let text = format!("[mesh]\nfile = {path:?}\n{more}");
    case::parse(&text, "case.toml", &[]).unwrap_or_else(|error| panic!("{error}\n{text}"))
}

fn same(case: &Case, what: &str) {
    same_on(case, what, &SIZES);
}

/// Every part of the shares is the same.
fn same_on(case: &Case, what: &str, sizes: &[usize]) {
    for &size in sizes {
        let expected = threads(size, |ranks| of_whole(case, None, &*ranks).unwrap());
        let found =
            threads(size, |ranks| of_parts(case, &*ranks).unwrap().unwrap_or_else(|error| panic!("{what}: {error:?}")));
        for (rank, (found, expected)) in found.iter().zip(&expected).enumerate() {
            let at = format!("{what}, rank {rank} of {size}");
            let MeshPiece { mesh, nodes, owner, cells } = &found.piece;
            assert_eq!(nodes, &expected.piece.nodes, "{at}");
            assert_eq!(owner, &expected.piece.owner, "{at}");
            assert_eq!(cells, &expected.piece.cells, "{at}");
            assert_eq!(mesh.nodes, expected.piece.mesh.nodes, "{at}");
            assert_eq!(mesh.cells, expected.piece.mesh.cells, "{at}");
            assert_eq!(mesh.faces, expected.piece.mesh.faces, "{at}");
            assert_eq!(mesh.groups, expected.piece.mesh.groups, "{at}");
            assert_eq!(found.piece, expected.piece, "{at}");
            assert_eq!(found.material_of_cell, expected.material_of_cell, "{at}");
            assert_eq!(
                (&found.symmetry, &found.kinds, &found.contact_of),
                (&expected.symmetry, &expected.kinds, &expected.contact_of)
            );
            let moments = |share: &Share| share.moments.iter().map(FaceMoments::numbers).collect::<Vec<_>>();
            assert_eq!(moments(found), moments(expected), "{at}");
            assert_eq!(
                (found.center, found.diagonal, found.sizes),
                (expected.center, expected.diagonal, expected.sizes)
            );
            let all: Vec<u64> = (0..nodes.len() as u64).collect();
            let [a, b] = [&found.points, &expected.points].map(|points| points.message(&points.by_node(), &all));
            assert_eq!(a, b, "{at}");
            assert_eq!(found.bodies, expected.bodies, "{at}");
            assert_eq!(found.body_of_node, expected.body_of_node, "{at}");
        }
    }
}

fn of_block(element: BlockElement, size: [f64; 3], cells: [usize; 3], origin: [f64; 3]) -> Mesh {
    block(&Block { size, cells, origin, grading: [1.0, 0.8, 1.2], element }).unwrap()
}

/// A block of two volumes that share nodes, with a curve, a point inside, and faces between the volumes.
fn halves(element: BlockElement) -> Mesh {
    let mut mesh = of_block(element, [4.0, 2.0, 1.0], [8, 5, 4], [0.0; 3]);
    let middle = |nodes: &[u32]| nodes.iter().map(|&v| mesh.nodes[v as usize][0]).sum::<f64>() / nodes.len() as f64;
    let left: Vec<bool> = mesh.cell_iter().map(|(_, nodes)| middle(nodes) < 2.0).collect();
    let of = |side: bool| (0..left.len() as u32).filter(|&cell| left[cell as usize] == side).collect();
    let within = |has: &dyn Fn([f64; 3]) -> bool| {
        (0..mesh.nodes.len() as u32).filter(|&v| has(mesh.nodes[v as usize])).collect()
    };
    let between = mesh.cell_iter().flat_map(|(kind, nodes)| {
        kind.faces().iter().map(move |face| face.iter().map(|&i| nodes[i]).collect::<Vec<u32>>())
    });
    let across = |face: &Vec<u32>| face.iter().all(|&v| mesh.nodes[v as usize][0] == 2.0);
    let corners = |face: Vec<u32>| {
        let count = match face.len() {
            3 | 6 => 3,
            _ => 4,
        };
        let mut corners = [u32::MAX; 4];
        corners[..count].copy_from_slice(&face[..count]);
        corners
    };
    let interior_faces = between.filter(across).map(corners).collect();
    let edge = within(&|x: [f64; 3]| x[1] == 2.0 && x[2] == 1.0);
    let inside =
        within(&|x: [f64; 3]| (x[0] - 1.5).abs() < 0.1 && (x[1] - 1.0).abs() < 0.4 && (x[2] - 0.5).abs() < 0.2);
    let group = |name: &str| Group { name: name.into(), ..Group::default() };
    let more = [
        Group { cells: of(true), ..group("left") },
        Group { cells: of(false), ..group("right") },
        Group { nodes: edge, ..group("edge") },
        Group { nodes: inside, ..group("inside") },
        Group { interior_faces, ..group("between") },
    ];
    mesh.groups.extend(more);
    mesh
}

const STEEL: &str = "[materials.steel]\nyoung = 2e11\npoisson = 0.3\ndensity = 7800\nexpansion = 12e-6\n";

/// Regions of all kinds on [`halves`].
fn on_halves() -> String {
    format!(
        "scale = 0.5\nturn = {{ axis = [0, 0, 1], degrees = 90 }}\nmove = [0.3, 0, 1]\n{STEEL}on = [\"left\"]\n\
         [materials.soft]\nyoung = 2e9\npoisson = 0.3\non = [\"right\"]\n\
         [[fix]]\non = \"x-min\"\n[[fix]]\non = \"edge\"\ncomponents = \"x\"\n[[fix]]\non = {{ point = [0, 1, 1.2] }}\ncomponents = \"y\"\n\
         [[fix]]\non = \"between\"\ncomponents = \"y\"\n\
         [[fix]]\non = {{ box = [[-1, 0, 1], [1, 0.4, 1.3]] }}\n[[load]]\ntemperature = \"60*x\"\non = \"left\"\n\
         [[load]]\ngravity = [0, 0, -9.81]\n[[load]]\nnodal = [0, 0, -1]\non = \"right\"\n[[load]]\nnodal = [0, 0, -1]\non = \"inside\"\n\
         [[load]]\non = \"x-max\"\nforce = [0, 0, -1e4]\n[[load]]\ngravity = [0, 0, -9.81]\non = {{ box = [[-1, 0, 1], [1, 1.2, 1.4]] }}\n\
         [[contact]]\non = \"z-min\"\nagainst = {{ plane = {{ point = [0, 0, 0.9999], normal = [0, 0, 1] }} }}\nfriction = {{ coulomb = 0.3 }}\n"
    )
}

const STYLES: [(&str, Style); 4] = [
    ("plain", PLAIN),
    ("shuffled", Style { tag: |i| (i * 977 + 5) % 1_000_003 + 1, block: 37, ..PLAIN }),
    ("unused", Style { unused: 3, block: 50, size: 4, ..PLAIN }),
    ("big", Style { big: true, tag: |i| (i ^ 0b1101) + 1, unused: 7, block: 101, ..PLAIN }),
];

#[test]
fn shares_of_a_file_read_by_ranges_are_those_of_the_whole() {
    let elements = [
        BlockElement::Tet4Six,
        BlockElement::Hex8,
        BlockElement::Tet10Five { parity: 0 },
        BlockElement::Hex20,
        BlockElement::Wedge6,
        BlockElement::Wedge15,
    ];
    for (k, element) in elements.into_iter().enumerate() {
        let mesh = halves(element);
        let (style, written_as) = STYLES[k % STYLES.len()];
        let file = path(&format!("halves-{k}.msh"));
        std::fs::write(&file, written(&mesh, written_as)).unwrap();
        same(&case_on(&file, &on_halves()), &format!("{element:?} {style}"));
        std::fs::remove_file(&file).unwrap();
    }
}

/// Bodies of several elements that contact holds, of which one is hollow: cells at its outer and at its inner boundary do not
/// hang together.
fn bodies() -> Mesh {
    let low = of_block(BlockElement::Hex8, [3.0, 3.0, 1.0], [7, 6, 3], [0.0; 3]);
    let high = of_block(BlockElement::Tet4Six, [2.0, 2.0, 1.0], [5, 4, 4], [0.3, 0.2, 1.0]);
    let long = of_block(BlockElement::Tet10Six, [0.4, 3.0, 1.0], [1, 9, 2], [2.5, 0.1, 1.0]);
    let wedge = of_block(BlockElement::Wedge6, [1.0, 1.0, 0.5], [3, 3, 2], [0.5, 0.5, 2.0]);
    let parts = [("low", low), ("high", high), ("long", long), ("wedge", wedge)];
    join(parts.map(|(name, mesh)| (name.to_string(), mesh)).into())
}

const ON_BODIES: &str = "\
    on = [\"low\"]\n[materials.soft]\nyoung = 2e9\npoisson = 0.3\non = [\"high.body\", \"long\"]\n\
    [materials.other]\nyoung = 3e9\npoisson = 0.2\non = [\"wedge\"]\n\
    [[fix]]\non = \"low.z-min\"\n[[load]]\non = \"wedge.z-max\"\ntraction = [0, 0, -1e5]\n\
    [[contact]]\nname = \"seat\"\non = [\"high.z-min\", \"long.z-min\"]\nagainst = \"low.z-max\"\nfriction = { coulomb = 0.2 }\n\
    [[contact]]\nname = \"top\"\non = \"wedge.z-min\"\nagainst = \"high.z-max\"\nfriction = { coulomb = 0.2 }\n";

#[test]
fn shares_of_several_bodies_read_by_ranges_are_those_of_the_whole() {
    let (mesh, file) = (bodies(), path("bodies.msh"));
    for (style, written_as) in STYLES {
        std::fs::write(&file, written(&mesh, written_as)).unwrap();
        same(&case_on(&file, &format!("{STEEL}{ON_BODIES}")), style);
    }
    std::fs::remove_file(&file).unwrap();
}

/// A hollow cube: shell of hexahedra three cells thick.
#[test]
fn a_hollow_body_is_one() {
    let mut mesh = of_block(BlockElement::Hex8, [9.0; 3], [9, 9, 9], [0.0; 3]);
    let cells: Vec<u32> = mesh
        .cell_iter()
        .zip(0..)
        .filter(|(_, k): &(_, usize)| ![k % 9, k / 9 % 9, k / 81].iter().all(|at| *at == 4))
        .flat_map(|((_, nodes), _)| nodes.to_vec())
        .collect();
    mesh.cells[0].nodes = cells;
    mesh.groups.clear();
    let file = path("hollow.msh");
    std::fs::write(&file, written(&mesh, STYLES[1].1)).unwrap();
    let more = "[[fix]]\non = { box = [[0, 0, 9], [9, 9, 9]] }\n[[contact]]\non = { box = [[0, 0, 0], [9, 9, 0]] }\n\
                against = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }\nfriction = \"none\"\n";
    same(&case_on(&file, &format!("{STEEL}{more}")), "hollow");
    // A mesh of fewer cells than a rank that reads some of another one has.
    std::fs::write(&file, written(&of_block(BlockElement::Hex8, [9.0; 3], [3, 1, 1], [0.0; 3]), STYLES[2].1)).unwrap();
    same_on(&case_on(&file, &format!("{STEEL}{more}").replace("[0, 0, 9]", "[0, 9, 9]")), "few", &[1, 6]);
    std::fs::remove_file(&file).unwrap();
}

#[test]
fn shares_of_a_vtu_file_read_by_ranges_are_those_of_the_whole() {
    let (mut mesh, file) = (bodies(), path("bodies.vtu"));
    mesh.groups.retain(|group| !group.name.contains('-') || !group.name.contains("body"));
    write_mesh(&file, &mesh).unwrap();
    same(&case_on(&file, &format!("{STEEL}{ON_BODIES}")), "vtu");
    std::fs::remove_file(&file).unwrap();
}

/// Files of other programs: each held at its upper end and pressed onto a plane.
#[test]
fn shares_of_files_of_other_programs_are_those_of_the_whole() {
    let files = [
        "meshes/cylinders-41-binary.msh",
        "meshes/bar-41-binary.msh",
        "data/brick-vtk-raw.vtu",
        "data/brick-vtk-raw-zlib.vtu",
        "data/curved-tet10-41.msh",
        "data/curved-hex20-41.msh",
        "data/curved-wedge15-41.msh",
    ];
    for name in files {
        let path = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests")).join(name);
        let (mesh, _) = crate::run::pose::read_mesh(&path, 1.0, &[]).unwrap();
        let [low, high] = mesh.bounding_box();
        let end = |z: f64| {
            format!("{{ box = [[{:?}, {:?}, {z:?}], [{:?}, {:?}, {z:?}]] }}", low[0], low[1], high[0], high[1])
        };
        let (upper, lower) = (end(high[2]), end(low[2]));
        let more = format!(
            "{STEEL}[[fix]]\non = {upper}\n[[contact]]\non = {lower}\nfriction = {{ coulomb = 0.3 }}\n\
             against = {{ plane = {{ point = [0, 0, {:?}], normal = [0, 0, 1] }} }}\n",
            low[2]
        );
        same(&case_on(&path, &more), name);
    }
}

/// The messages are those of the reader of the whole, on all ranks, and the ranges have seen that something is wrong.
#[test]
fn what_is_wrong_with_a_file_ends_all_ranks_with_the_words_of_the_whole() {
    let mesh = of_block(BlockElement::Hex8, [4.0, 2.0, 1.0], [8, 5, 4], [0.0; 3]);
    let more = "[[fix]]\non = \"x-min\"\n[[contact]]\non = \"z-min\"\n\
                against = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }\nfriction = \"none\"\n";
    let good = written(&mesh, PLAIN);
    let (mut inverted, mut twice, mut flat) = (mesh.clone(), mesh.clone(), mesh.clone());
    inverted.cells[0].nodes[80..88].rotate_left(4);
    twice.cells[0].nodes.copy_within(0..8, 80);
    flat.nodes[7][2] = f64::NAN;
    let mut missing = good.clone();
    let at = missing.len() - "\n$EndElements\n".len() - 8;
    missing[at..at + 8].copy_from_slice(&9999u64.to_le_bytes());
    let mut files = vec![written(&inverted, STYLES[1].1), written(&twice, PLAIN), written(&flat, PLAIN), missing];
    files.push(written(&mesh, Style { tag: |i| i / 2 * 2 + 1, ..PLAIN }));
    files.extend([5, 50, 500, 5000].map(|short| good[..good.len() - short].to_vec()));
    let file = path("wrong.msh");
    for (k, bytes) in files.into_iter().enumerate() {
        std::fs::write(&file, bytes).unwrap();
        let case = case_on(&file, &format!("{STEEL}{more}"));
        let Err(expected) = Whole::made(&case, &Helpers::new(&Alone), None) else { panic!("file {k} is read") };
        let found = threads(3, |ranks| {
            (of_parts(&case, &*ranks).unwrap().err().unwrap(), share(&case, &*ranks).err().unwrap())
        });
        for (by_ranges, error) in found {
            assert!(by_ranges.is_some(), "file {k}");
            assert_eq!(error, expected, "file {k}");
        }
    }
    std::fs::remove_file(&file).unwrap();
}

/// What ranges do not say is read as a whole, by all ranks alike.
#[test]
fn text_and_arrays_are_read_as_a_whole() {
    let file = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/meshes/bar-41-ascii.msh"));
    let case = case_on(file, &format!("{STEEL}[[fix]]\non = {{ box = [[-9, -9, -9], [9, 9, 9]] }}\n"));
    assert!(threads(3, |ranks| of_parts(&case, &*ranks).unwrap().err().unwrap()).iter().all(Option::is_none));
}
