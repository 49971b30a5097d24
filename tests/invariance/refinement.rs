//! Meshes that are cut into tetrahedra and refined: what a refinement must leave as it is.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use rayon::prelude::*;
use stiction::io::gmsh;
use stiction::mesh::{
    Bisection, Block, BlockElement, CellArray, CellKind, Cells, Mesh, NodeArray, Order, RawCells, RawGroup, RawMesh,
    Refined, Ring, block, build, cut, info, join, quality, refine, ring, tetrahedra,
};

type V3 = [f64; 3];

const EDGES: [[usize; 2]; 6] = [[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]];

struct Random(u64);

impl Random {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn below(&mut self, n: usize) -> usize {
        ((self.unit() * n as f64) as usize).min(n - 1)
    }

    /// Cells with the share of all.
    fn some(&mut self, cells: usize, share: f64) -> Vec<u32> {
        (0..cells as u32).filter(|_| self.unit() < share).collect()
    }
}

fn case(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../cases").join(name)
}

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(name)
}

fn of_file(path: &Path) -> Mesh {
    gmsh::read(path, 1.0).unwrap_or_else(|e| panic!("{}: {e}", path.display())).0
}

fn of_block(cells: [usize; 3], element: BlockElement) -> Mesh {
    let [x, y, z] = cells.map(|n| n as f64);
    block(&Block { size: [x, 1.3 * y, 0.8 * z], cells, origin: [0.1, -2.0, 7.0], grading: [1.0, 1.5, 1.0], element })
        .unwrap()
}

/// The same cells with their nodes, and so all that follows from their numbers, in another order, and moved by a part of
/// the shortest edge; the groups are those of the cells.
fn shuffled(mesh: &Mesh, by: f64, random: &mut Random) -> Mesh {
    let mut number: Vec<u32> = (0..mesh.nodes.len() as u32).collect();
    (1..number.len()).rev().for_each(|i| number.swap(i, random.below(i + 1)));
    let mut nodes = vec![[0.0; 3]; number.len()];
    for (x, &to) in mesh.nodes.iter().zip(&number) {
        nodes[to as usize] = x.map(|c| c + by * (random.unit() - 0.5));
    }
    let of = |block: &Cells| {
        let nodes = block.nodes.iter().map(|&n| number[n as usize]).collect();
        RawCells { kind: block.kind, nodes, ids: Vec::new() }
    };
    build(RawMesh { nodes, cells: mesh.cells.iter().map(of).collect(), ..RawMesh::default() }).unwrap().0
}

fn sorted<const N: usize>(mut nodes: [u32; N]) -> [u32; N] {
    nodes.sort_unstable();
    nodes
}

/// What a mesh fills, and how its cells hang together.
#[derive(Debug)]
struct Figures {
    volume: f64,
    area: f64,
    /// Corners - edges + faces - cells.
    euler: i64,
    /// Volume of the cells, area of the faces and area of the faces between cells of each group.
    groups: Vec<(String, [f64; 3])>,
}

fn area_between(mesh: &Mesh, corners: &[u32; 4]) -> f64 {
    let x: Vec<V3> = corners.iter().filter(|&&n| n != u32::MAX).map(|&n| mesh.nodes[n as usize]).collect();
    let along = |a: V3, b: V3| [0, 1, 2].map(|c| b[c] - a[c]);
    let (a, b) = match x[..] {
        [a, b, c] => (along(a, b), along(a, c)),
        _ => (along(x[0], x[2]), along(x[1], x[3])),
    };
    let n = [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    0.5 * n.iter().map(|c| c * c).sum::<f64>().sqrt()
}

fn figures(mesh: &Mesh) -> Figures {
    let area = |faces: &mut dyn Iterator<Item = u32>| faces.map(|f| mesh.face_area(f as usize)).sum::<f64>();
    let groups = mesh.groups.iter().map(|group| {
        let volume = group.cells.iter().map(|&c| mesh.cell_volume(c as usize)).sum();
        let between = group.interior_faces.iter().map(|corners| area_between(mesh, corners)).sum();
        (group.name.clone(), [volume, area(&mut group.faces.iter().copied()), between])
    });
    let groups = groups.collect();
    let (mut corners, mut edges, mut faces) = (Vec::<u32>::new(), Vec::new(), Vec::new());
    for (kind, cell) in mesh.cell_iter() {
        let quadratic = match kind.linear() {
            CellKind::Tet4 => CellKind::Tet10,
            CellKind::Wedge6 => CellKind::Wedge15,
            _ => CellKind::Hex20,
        };
        corners.extend(&cell[..kind.linear().nodes()]);
        edges.extend(quadratic.edges().iter().map(|&[i, j]| sorted([cell[i], cell[j]])));
        let corner = |face: &[usize], i: usize| face.get(i).map_or(u32::MAX, |&i| cell[i]);
        faces.extend(kind.linear().faces().iter().map(|face| sorted([0, 1, 2, 3].map(|i| corner(face, i)))));
    }
    fn count<T: Ord>(mut list: Vec<T>) -> i64 {
        list.sort_unstable();
        list.dedup();
        list.len() as i64
    }
    Figures {
        volume: mesh.volume(),
        area: area(&mut (0..mesh.faces.len() as u32)),
        euler: count(corners) - count(edges) + count(faces) - mesh.cell_count() as i64,
        groups,
    }
}

/// Every face belongs to two cells, or to one and is then a boundary face; no corner of a cell lies inside an edge.
fn assert_conforming(mesh: &Mesh, name: &str) {
    let kind = mesh.cells[0].kind;
    assert!(mesh.cells.len() == 1 && kind.linear() == CellKind::Tet4, "{name}");
    let mut faces: Vec<[u32; 3]> = Vec::new();
    let mut is_corner = vec![false; mesh.nodes.len()];
    for (_, cell) in mesh.cell_iter() {
        cell[..4].iter().for_each(|&node| is_corner[node as usize] = true);
        faces.extend(kind.linear().faces().iter().map(|face| sorted([0, 1, 2].map(|i| cell[face[i]]))));
    }
    faces.sort_unstable();
    let single: Vec<[u32; 3]> =
        faces.chunk_by(|a, b| a == b).filter(|same| same.len() == 1).map(|same| same[0]).collect();
    assert!(faces.chunk_by(|a, b| a == b).all(|same| same.len() <= 2), "{name}");
    let mut listed: Vec<[u32; 3]> =
        mesh.faces.iter().map(|face| sorted([0, 1, 2].map(|i| face.corners()[i]))).collect();
    listed.sort_unstable();
    assert!(single == listed, "{name}");
    let place = |x: V3| x.map(|c| (c + 0.0).to_bits());
    let mut at: Vec<_> = mesh.nodes.iter().zip(&is_corner).filter(|(_, is)| **is).map(|(&x, _)| place(x)).collect();
    at.sort_unstable();
    for (_, cell) in mesh.cell_iter() {
        for (k, [i, j]) in EDGES.into_iter().enumerate() {
            let (a, b) = (mesh.nodes[cell[i] as usize], mesh.nodes[cell[j] as usize]);
            let is_free = match cell.get(4 + k) {
                Some(&middle) => !is_corner[middle as usize],
                None => at.binary_search(&place([0, 1, 2].map(|c| 0.5 * (a[c] + b[c])))).is_err(),
            };
            assert!(is_free, "{name}: a corner lies inside the edge {} {}", cell[i], cell[j]);
        }
    }
}

fn assert_same(before: &Figures, after: &Figures, name: &str) {
    let close = |a: f64, b: f64| (a - b).abs() <= 1e-12 * a.abs();
    assert!(close(before.volume, after.volume), "{name}: {} {}", before.volume, after.volume);
    assert!(close(before.area, after.area), "{name}: {} {}", before.area, after.area);
    assert_eq!(before.euler, after.euler, "{name}");
    assert_eq!(before.groups.len(), after.groups.len());
    for ((a, x), (b, y)) in before.groups.iter().zip(&after.groups) {
        assert!(a == b && (0..3).all(|i| close(x[i], y[i])), "{name}: group {a} {x:?} {y:?}");
    }
}

fn least_quality(mesh: &Mesh) -> f64 {
    mesh.cell_iter().map(|(kind, cell)| quality(&mesh.nodes, kind, cell)).fold(f64::INFINITY, f64::min)
}

/// A polynomial of that degree, three values a node.
fn field(mesh: &Mesh, degree: usize) -> Vec<f64> {
    let at = |&[x, y, z]: &V3| {
        let linear = [1.0 + x - 2.0 * y + 0.5 * z, 3.0 - z, x + y + z];
        let square = [x * x - y * z, 0.3 * z * z + x * y, x * z - 2.0 * y * y];
        [0, 1, 2].map(|c| linear[c] + if degree > 1 { square[c] } else { 0.0 })
    };
    mesh.nodes.iter().flat_map(at).collect()
}

fn assert_carried(old: &Mesh, refined: &Refined, degree: usize, name: &str) {
    let (before, after) = (field(old, degree), field(&refined.next.mesh, degree));
    let largest = before.iter().fold(0.0, |a: f64, v| a.max(v.abs()));
    let carried = refined.carry(&before).unwrap();
    assert_eq!(carried.len(), after.len(), "{name}");
    let off = carried.iter().zip(&after).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(off <= 1e-13 * largest, "{name}: {off} of {largest}");
    assert!(refined.carry(&before[1..]).is_err());
}

/// Every child lies in its parent: its corners have barycentric coordinates of 0 to 1 there.
fn assert_nested(old: &Mesh, refined: &Refined, name: &str) {
    let det = |[a, b, c]: [V3; 3]| {
        a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) + a[2] * (b[0] * c[1] - b[1] * c[0])
    };
    for (number, (_, cell)) in refined.next.mesh.cell_iter().enumerate() {
        let parent = old.cell(refined.parent[number] as usize).1;
        let x: Vec<V3> = parent[..4].iter().map(|&n| old.nodes[n as usize]).collect();
        for &node in &cell[..4] {
            let at = refined.next.mesh.nodes[node as usize];
            for i in 0..4 {
                let volume = |with: V3| {
                    let x: Vec<V3> = (0..4).map(|k| if k == i { with } else { x[k] }).collect();
                    det([1, 2, 3].map(|k| [0, 1, 2].map(|c| x[k][c] - x[0][c])))
                };
                let weight = volume(at) / volume(x[i]);
                assert!((-1e-9..=1.0 + 1e-9).contains(&weight), "{name}: cell {number}, {weight}");
            }
        }
    }
}

/// Straight meshes, of one order or the other.
fn straight(random: &mut Random) -> Vec<(String, Mesh)> {
    let mut all: Vec<(String, Mesh)> = Vec::new();
    for element in [
        BlockElement::Tet4Six,
        BlockElement::Tet4Five { parity: 1 },
        BlockElement::Tet10Six,
        BlockElement::Tet10Five { parity: 0 },
        BlockElement::Hex8,
        BlockElement::Hex20,
        BlockElement::Wedge6,
        BlockElement::Wedge15,
    ] {
        let mesh = of_block([2, 1, 2], element);
        let kind = mesh.cells[0].kind;
        if kind.linear() == kind {
            if kind == CellKind::Tet4 {
                all.push((format!("jittered {element:?}"), shuffled(&mesh, 0.4, random)));
            }
            let bent =
                Ring { radii: [1.0, 2.0], height: 1.0, degrees: 120.0, cells: [1, 3, 1], grading: [1.0; 3], element };
            all.push((format!("ring {element:?}"), ring(&bent).unwrap()));
        }
        all.push((format!("shuffled {element:?}"), shuffled(&mesh, 0.0, random)));
        all.push((format!("block {element:?}"), mesh));
    }
    for name in ["patch/low.msh", "joint/bolt.msh", "rings/inner.msh", "several/several.msh"] {
        all.push((name.into(), of_file(&case(name))));
    }
    all.push(("cylinders".into(), of_file(&data("meshes/cylinders-41-binary.msh"))));
    all.push(("bar".into(), of_file(&data("meshes/bar-41-binary.msh"))));
    all
}

/// The first letter of the type that Arnold, Mukherjee and Pouly give a tetrahedron by the longest edges of its faces.
fn letter(x: [V3; 4]) -> char {
    let square = |[i, j]: [usize; 2]| (0..3).map(|c| (x[i][c] - x[j][c]).powi(2)).sum::<f64>();
    let longest =
        |of: &mut dyn Iterator<Item = [usize; 2]>| of.max_by(|a, b| square(*a).total_cmp(&square(*b))).unwrap();
    let cut = longest(&mut EDGES.into_iter());
    let mark = |i: usize| longest(&mut EDGES.into_iter().filter(|edge| !edge.contains(&cut[i])));
    let (a, b) = (mark(0), mark(1));
    let meets = |edge: [usize; 2]| edge.iter().any(|i| cut.contains(i));
    match (meets(a), meets(b)) {
        (true, true) if a.iter().any(|i| b.contains(i)) => 'P',
        (true, true) => 'A',
        (false, false) => 'O',
        _ => 'M',
    }
}

/// Squares of the six edges over their sum, in the order of corners that makes them smallest, rounded.
fn shape(mesh: &Mesh, cell: &[u32]) -> [i64; 6] {
    let square =
        |i: u32, j: u32| (0..3).map(|c| (mesh.nodes[i as usize][c] - mesh.nodes[j as usize][c]).powi(2)).sum::<f64>();
    let sum: f64 = EDGES.iter().map(|&[i, j]| square(cell[i], cell[j])).sum();
    let mut least = [i64::MAX; 6];
    for (a, b, c) in (0..64).map(|n| (n / 16, n / 4 % 4, n % 4)).filter(|&(a, b, c)| a != b && b != c && c != a) {
        let order = [a, b, c, 6 - a - b - c].map(|i| cell[i]);
        least = least.min(EDGES.map(|[i, j]| (square(order[i], order[j]) / sum * 1e7).round() as i64));
    }
    least
}

/// `marked` ten times in a hundred, each bisected once to three times.
fn at_random(at: &Bisection, random: &mut Random) -> Refined {
    let marked = random.some(at.mesh.cell_count(), 0.1);
    refine(at, &marked, 1 + random.below(3) as u32).unwrap()
}

#[test]
fn ten_thousand_random_refinements_conform_and_keep_volumes_areas_and_groups() {
    let meshes = straight(&mut Random(7));
    assert!(meshes.iter().any(|(_, mesh)| figures(mesh).groups.iter().any(|group| group.1[2] > 0.0)));
    let of_mesh = |(number, (name, mesh)): (usize, &(String, Mesh))| {
        let kind = mesh.cells[0].kind;
        let (order, degree) = if kind == kind.linear() { (Order::Linear, 1) } else { (Order::Quadratic, 2) };
        let first = cut(mesh, order).unwrap();
        let before = figures(mesh);
        assert_conforming(&first.next.mesh, name);
        assert_same(&before, &figures(&first.next.mesh), name);
        let is_tetrahedra = kind.linear() == CellKind::Tet4;
        assert_carried(mesh, &first, degree, name);
        assert!(!is_tetrahedra || (first.next.mesh.nodes == mesh.nodes && first.parent.is_sorted()));
        // Five tetrahedra in a cube have edges of one length, and the marks follow from the numbers.
        let bound = if is_tetrahedra && !name.contains("Five") { 1.0 / 3.0 } else { 0.25 };
        let worst = bound * least_quality(&first.next.mesh);
        let mut random = Random(number as u64);
        let mut done = 0;
        let small = first.parent.len() < 100;
        while done < if small { 540 } else { 100 } {
            let mut at = first.next.clone();
            while at.mesh.cell_count() < if small { 200 } else { 2 * first.parent.len() } {
                let refined = at_random(&at, &mut random);
                done += 1;
                let mesh = &refined.next.mesh;
                assert_conforming(mesh, name);
                assert_same(&before, &figures(mesh), name);
                assert!(least_quality(mesh) >= worst, "{name}: {} of {worst}", least_quality(mesh));
                assert_nested(&at.mesh, &refined, name);
                assert_carried(&at.mesh, &refined, degree, name);
                at = refined.next;
            }
        }
        done
    };
    assert!(meshes.par_iter().enumerate().map(of_mesh).sum::<usize>() >= 10_000);
}

/// The children are parts of the map of the parent: volumes and vector areas, which are integrals of polynomials, stay to
/// rounding, and coordinates are carried like any other field.
#[test]
fn curved_cells_keep_their_volume_and_their_faces() {
    let mut random = Random(3);
    let bent =
        |element| Ring { radii: [1.0, 2.0], height: 1.0, degrees: 200.0, cells: [1, 4, 1], grading: [1.0; 3], element };
    let of_ring = |element| ring(&bent(element)).unwrap();
    let warped = shuffled(&of_block([2, 2, 2], BlockElement::Hex8), 0.4, &mut random);
    let meshes = [
        ("ring", of_ring(BlockElement::Tet10Six)),
        ("ring of hexahedra", of_ring(BlockElement::Hex20)),
        ("ring of wedges", of_ring(BlockElement::Wedge15)),
        ("curved-tet10", of_file(&data("data/curved-tet10-41.msh"))),
        ("curved-hex20", of_file(&data("data/curved-hex20-41.msh"))),
        ("warped", warped),
    ];
    let shown = |mesh: &Mesh| -> Vec<f64> {
        let of = |faces: &[u32]| faces.iter().map(|&f| mesh.face_vector_area(f as usize)).collect::<Vec<V3>>();
        let sum = |faces: &[u32]| of(faces).into_iter().fold([0.0; 3], |a, b| [0, 1, 2].map(|c| a[c] + b[c]));
        mesh.groups.iter().flat_map(|group| sum(&group.faces)).collect()
    };
    for (name, mesh) in meshes {
        let first = cut(&mesh, Order::Quadratic).unwrap().next;
        let close = |a: f64, b: f64, to: f64| assert!((a - b).abs() <= to * mesh.volume(), "{name}: {a} {b}");
        // A face of eight nodes is no more than its border to two faces of six: what it shows stays, its bulge does not.
        let is_same = mesh.cells[0].kind != CellKind::Hex20;
        close(first.mesh.volume(), mesh.volume(), if is_same { 1e-12 } else { 0.02 });
        shown(&first.mesh).into_iter().zip(shown(&mesh)).for_each(|(a, b)| close(a, b, 1e-12));
        let mut at = first.clone();
        while at.mesh.cell_count() < 2000 {
            let refined = at_random(&at, &mut random);
            let after = &refined.next.mesh;
            assert_conforming(after, name);
            close(after.volume(), first.mesh.volume(), 1e-12);
            shown(after).into_iter().zip(shown(&mesh)).for_each(|(a, b)| close(a, b, 1e-12));
            let places = refined.carry(at.mesh.nodes.as_flattened()).unwrap();
            let off = places.iter().zip(after.nodes.as_flattened()).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off < 1e-14 * 16.0, "{name}: {off}");
            at = refined.next;
        }
    }
}

/// A type A or P has 36 shapes of descendants at most; O and M are not met again, and their children are of type P.
#[test]
fn a_tetrahedron_has_finitely_many_shapes_of_descendants() {
    let mut random = Random(7);
    let mut most: HashMap<char, usize> = HashMap::new();
    for _ in 0..200 {
        let x: [V3; 4] = [0; 4].map(|_| [0; 3].map(|_| random.unit()));
        let cells = vec![RawCells { kind: CellKind::Tet4, nodes: vec![0, 1, 2, 3], ids: Vec::new() }];
        // Half of them are inside out.
        let Ok((mesh, _)) = build(RawMesh { nodes: x.to_vec(), cells, ..RawMesh::default() }) else { continue };
        let mut at = tetrahedra(&mesh, Order::Linear).unwrap();
        let mut shapes = Vec::new();
        for _ in 0..9 {
            shapes.extend(at.mesh.cell_iter().map(|(_, cell)| shape(&at.mesh, cell)));
            let all: Vec<u32> = (0..at.mesh.cell_count() as u32).collect();
            at = refine(&at, &all, 1).unwrap().next;
        }
        shapes.sort_unstable();
        shapes.dedup();
        let most = most.entry(letter(x)).or_default();
        *most = shapes.len().max(*most);
    }
    assert!(most[&'A'] == 36 && most[&'P'] == 36, "{most:?}");
    assert!([most[&'O'], most[&'M']].iter().all(|&most| (37..=73).contains(&most)), "{most:?}");

    // Cubes cut by Kuhn's rule have three, those of Maubach's bisection.
    let cubes =
        Block { size: [2.0; 3], cells: [2; 3], origin: [0.0; 3], grading: [1.0; 3], element: BlockElement::Hex8 };
    let mut at = tetrahedra(&block(&cubes).unwrap(), Order::Linear).unwrap();
    (0..6).for_each(|_| at = at_random(&at, &mut random).next);
    let mut shapes: Vec<_> = at.mesh.cell_iter().map(|(_, cell)| shape(&at.mesh, cell)).collect();
    shapes.sort_unstable();
    shapes.dedup();
    assert_eq!(shapes.len(), 3);
}

#[test]
fn the_cells_do_not_depend_on_numbers_and_order() {
    let mut random = Random(5);
    let mesh = shuffled(&of_block([2, 2, 3], BlockElement::Tet4Six), 0.3, &mut random);
    let other = shuffled(&mesh, 0.0, &mut random);
    let marked = random.some(mesh.cell_count(), 0.1);
    let cells = |mesh: &Mesh, marked: &[u32]| {
        let refined = refine(&tetrahedra(mesh, Order::Linear).unwrap(), marked, 3).unwrap().next.mesh;
        let corners = |cell: &[u32]| {
            let mut x: Vec<[u64; 3]> = cell.iter().map(|&n| refined.nodes[n as usize].map(f64::to_bits)).collect();
            x.sort_unstable();
            x
        };
        let mut cells: Vec<_> = refined.cell_iter().map(|(_, cell)| corners(cell)).collect();
        cells.sort_unstable();
        (cells, refined)
    };
    let (first, refined) = cells(&mesh, &marked);
    assert!(first == cells(&other, &marked).0 && first.len() > mesh.cell_count() + 7 * marked.len());
    let reversed: Vec<u32> = marked.iter().rev().flat_map(|&cell| [cell, cell]).collect();
    assert_eq!(cells(&mesh, &reversed).1, refined);
}

/// Two legs of a curve that meet in the corner of a block, a surface, a volume, a point and a cut between cells, all given
/// by nodes or faces alone.
#[test]
fn groups_and_arrays_go_where_their_points_are() {
    let mut random = Random(11);
    let on = |[x, y, z]: V3| {
        let low = [x - 0.1, y + 2.0, z - 7.0].map(|c| c.abs() < 1e-9);
        [low[2] && (low[0] || low[1]), low[0], x < 2.1 + 1e-9, low == [true; 3]]
    };
    for element in [
        BlockElement::Tet4Six,
        BlockElement::Tet4Five { parity: 0 },
        BlockElement::Hex8,
        BlockElement::Tet10Six,
        BlockElement::Tet10Five { parity: 0 },
        BlockElement::Hex20,
        BlockElement::Wedge6,
        BlockElement::Wedge15,
    ] {
        let mesh = of_block([4, 3, 3], element);
        let quadratic = mesh.cells[0].kind != mesh.cells[0].kind.linear();
        let mut raw = RawMesh { nodes: mesh.nodes.clone(), ..RawMesh::default() };
        raw.cells =
            mesh.cells.iter().map(|c| RawCells { kind: c.kind, nodes: c.nodes.clone(), ids: Vec::new() }).collect();
        for (i, name) in ["curve", "surface", "volume", "point"].into_iter().enumerate() {
            let nodes = (0..).zip(&mesh.nodes).filter(|(_, x)| on(**x)[i]).map(|(node, _)| node).collect();
            raw.groups.push(RawGroup { name: name.into(), nodes, ..RawGroup::default() });
        }
        let mut cut_faces = Vec::new();
        for (kind, cell) in mesh.cell_iter() {
            for face in kind.linear().faces() {
                if face.iter().all(|&i| (mesh.nodes[cell[i] as usize][0] - 2.1).abs() < 1e-9) {
                    cut_faces.push([0, 1, 2, 3].map(|i| face.get(i).map_or(u32::MAX, |&i| cell[i])));
                }
            }
        }
        raw.groups.push(RawGroup { name: "cut".into(), faces: cut_faces, ..RawGroup::default() });
        raw.arrays
            .nodes
            .push(NodeArray { name: "t".into(), values: mesh.nodes.iter().map(|[x, y, z]| x - y + 2.0 * z).collect() });
        let own = |cell: u32| f64::from(cell) + 0.5;
        raw.arrays.cells.push(CellArray {
            name: "c".into(),
            values: (0..mesh.cell_count() as u32).map(own).collect(),
            faces: Vec::new(),
        });
        let (mut mesh, _) = build(raw).unwrap();
        let numbered = (0..mesh.faces.len() as u32).map(|face| (face, mesh.face_normal(face as usize)[0])).collect();
        mesh.arrays.cells[0].faces = numbered;

        let mut at = cut(&mesh, if quadratic { Order::Quadratic } else { Order::Linear }).unwrap();
        if [BlockElement::Hex8, BlockElement::Tet4Six, BlockElement::Wedge6].contains(&element) {
            // The middles are asked as well.
            at = cut(&mesh, Order::Quadratic).unwrap();
        }
        let mut old = mesh.clone();
        for _ in 0..4 {
            let new = &at.next.mesh;
            for (i, name) in ["curve", "surface", "volume", "point"].into_iter().enumerate() {
                let expected: Vec<u32> =
                    (0..).zip(&new.nodes).filter(|(_, x)| on(**x)[i]).map(|(node, _)| node).collect();
                assert_eq!(new.group(name).unwrap().nodes, expected, "{name} {element:?}");
            }
            let cut_nodes = new.group_nodes(new.group("cut").unwrap());
            let expected = (0..).zip(&new.nodes).filter(|(_, x)| (x[0] - 2.1).abs() < 1e-9).map(|(node, _)| node);
            assert_eq!(cut_nodes, expected.collect::<Vec<u32>>(), "{element:?}");
            let t = &new.arrays.nodes[0].values;
            assert!(new.nodes.iter().zip(t).all(|([x, y, z], t)| (x - y + 2.0 * z - t).abs() < 1e-12));
            let array = &new.arrays.cells[0];
            assert!(
                (0..new.cell_count()).all(|c| array.values[c] == old.arrays.cells[0].values[at.parent[c] as usize])
            );
            for (face, own) in (0..).zip(&new.faces) {
                assert!((array.of_face(face, own.cell) - new.face_normal(face as usize)[0]).abs() < 1e-9);
            }
            old = new.clone();
            at = at_random(&at.next, &mut random);
        }
    }
}

#[test]
fn bodies_stay_apart_and_mixed_orders_find_their_middles() {
    let parts = vec![
        ("a".to_string(), of_block([1, 2, 1], BlockElement::Tet4Six)),
        ("b".to_string(), of_block([2, 1, 1], BlockElement::Hex20)),
        ("c".to_string(), of_block([1, 1, 1], BlockElement::Hex8)),
    ];
    let mesh = join(parts);
    let first = tetrahedra(&mesh, Order::Quadratic).unwrap();
    let refined = at_random(&first, &mut Random(1)).next.mesh;
    for mesh in [&first.mesh, &refined] {
        assert_conforming(mesh, "joined");
        assert_eq!(info(mesh).bodies, 3);
    }
    assert_same(&figures(&mesh), &figures(&refined), "joined");
    // Two tetrahedra that share an edge only, of four and of ten nodes.
    let x = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]];
    let middle = |[i, j]: [usize; 2]| [0, 1, 2].map(|c| 0.5 * (x[i][c] + x[j][c]));
    let mut nodes = x.to_vec();
    nodes.extend(EDGES.map(middle));
    let raw = |kind, nodes: Vec<u32>| RawCells { kind, nodes, ids: Vec::new() };
    let quadratic = raw(CellKind::Tet10, vec![0, 1, 2, 3, 6, 7, 8, 9, 10, 11]);
    let cells = vec![raw(CellKind::Tet4, vec![0, 1, 4, 5]), quadratic];
    let (mesh, _) = build(RawMesh { nodes, cells, ..RawMesh::default() }).unwrap();
    let cut = tetrahedra(&mesh, Order::Quadratic).unwrap().mesh;
    assert_eq!(cut.nodes.len(), mesh.nodes.len() + 5);
    assert!([0, 1].iter().all(|&cell| cut.cell(cell).1.contains(&6)));
}

#[test]
fn what_cannot_be_cut_is_refused_with_a_remedy() {
    let mesh = of_block([1, 1, 1], BlockElement::Hex20);
    let refused = tetrahedra(&mesh, Order::Linear).unwrap_err();
    assert!(refused.what.contains("curved edges") && !refused.remedy.is_empty(), "{refused}");
    let at = tetrahedra(&mesh, Order::Quadratic).unwrap();
    assert!(refine(&at, &[99], 1).unwrap_err().what.contains("cell 99 is marked, of 6"));
    // Some hexahedra can be used as they are, and not be cut.
    let cube = block(&Block {
        size: [1.0; 3],
        cells: [1; 3],
        origin: [0.0; 3],
        grading: [1.0; 3],
        element: BlockElement::Hex8,
    });
    let (cube, mut random) = (cube.unwrap(), Random(1));
    let warped = |_| {
        let nodes = cube.nodes.iter().map(|x| x.map(|c| c + 0.9 * (random.unit() - 0.5))).collect();
        let cells = vec![RawCells { kind: CellKind::Hex8, nodes: cube.cells[0].nodes.clone(), ids: Vec::new() }];
        build(RawMesh { nodes, cells, ..RawMesh::default() }).ok().map(|built| built.0)
    };
    let errors = (0..2000).filter_map(warped).filter_map(|mesh| tetrahedra(&mesh, Order::Linear).err());
    let errors: Vec<_> = errors.collect();
    assert!(!errors.is_empty() && errors.iter().all(|e| e.what.contains("hexahedron 1 at") && !e.remedy.is_empty()));
}
