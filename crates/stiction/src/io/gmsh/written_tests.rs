//! Binary files of MSH 4.1 for tests.

use super::types::order;
use crate::mesh::{CellKind, Mesh};

/// How a file is written.
#[derive(Clone, Copy)]
pub(crate) struct Style {
    pub big: bool,
    /// Bytes of a `size_t`.
    pub size: usize,
    /// The number of node `i`, counted from zero.
    pub tag: fn(u64) -> u64,
    /// Every so many nodes one of no cell goes before them; none at zero.
    pub unused: usize,
    /// Nodes of a block.
    pub block: usize,
}

pub(crate) const PLAIN: Style = Style { big: false, size: 8, tag: |i| i + 1, unused: 0, block: usize::MAX };

struct Out {
    bytes: Vec<u8>,
    style: Style,
}

impl Out {
    fn text(&mut self, text: &str) {
        self.bytes.extend_from_slice(text.as_bytes());
    }

    fn turned(&mut self, mut bytes: Vec<u8>) {
        if self.style.big {
            bytes.reverse();
        }
        self.bytes.extend(bytes);
    }

    fn int(&mut self, value: i64) {
        self.turned((value as i32).to_le_bytes().to_vec());
    }

    fn size(&mut self, value: u64) {
        self.turned(value.to_le_bytes()[..self.style.size].to_vec());
    }

    fn float(&mut self, value: f64) {
        self.turned(value.to_le_bytes().to_vec());
    }
}

/// Elements of one entity: dimension, Gmsh's type, groups, and the nodes of each.
type Block = (u8, i64, Vec<usize>, Vec<Vec<u32>>);

/// Cells by the groups they are in, as volumes; faces and nodes of groups as surfaces and points.
fn blocks(mesh: &Mesh) -> Vec<Block> {
    let mut blocks: Vec<Block> = Vec::new();
    for (k, group) in mesh.groups.iter().enumerate() {
        if !group.nodes.is_empty() {
            blocks.push((0, 15, vec![k], group.nodes.iter().map(|&node| vec![node]).collect()));
        }
        for corners in [3, 4] {
            let of_boundary = group.faces.iter().map(|&face| mesh.faces[face as usize].corners().to_vec());
            let inside = group.interior_faces.iter().map(|f| f.iter().copied().filter(|&n| n != u32::MAX).collect());
            let faces: Vec<Vec<u32>> = of_boundary.chain(inside).filter(|f: &Vec<u32>| f.len() == corners).collect();
            if !faces.is_empty() {
                blocks.push((2, corners as i64 - 1, vec![k], faces));
            }
        }
    }
    for (cell, (kind, nodes)) in (0..).zip(mesh.cell_iter()) {
        let number = match kind {
            CellKind::Tet4 => 4,
            CellKind::Hex8 => 5,
            CellKind::Wedge6 => 6,
            CellKind::Tet10 => 11,
            CellKind::Hex20 => 17,
            CellKind::Wedge15 => 18,
        };
        let of = |(k, group): (usize, &crate::mesh::Group)| group.cells.binary_search(&cell).is_ok().then_some(k);
        let groups: Vec<usize> = mesh.groups.iter().enumerate().filter_map(of).collect();
        let mut listed = vec![0; nodes.len()];
        order(kind).iter().zip(nodes).for_each(|(&place, &node)| listed[place] = node);
        match blocks.iter_mut().find(|block| block.0 == 3 && block.1 == number && block.2 == groups) {
            Some(block) => block.3.push(listed),
            None => blocks.push((3, number, groups, vec![listed])),
        }
    }
    blocks
}

/// The bytes of a file with that mesh, whose groups are physical ones.
pub(crate) fn written(mesh: &Mesh, style: Style) -> Vec<u8> {
    let mut out = Out { bytes: Vec::new(), style };
    out.text(&format!("$MeshFormat\n4.1 1 {}\n", style.size));
    out.int(1);
    out.text(&format!("\n$EndMeshFormat\n$PhysicalNames\n{}\n", 4 * mesh.groups.len()));
    for dimension in 0..4 {
        for (k, group) in (1..).zip(&mesh.groups) {
            out.text(&format!("{dimension} {k} \"{}\"\n", group.name));
        }
    }
    out.text("$EndPhysicalNames\n$Entities\n");
    let blocks = blocks(mesh);
    for dimension in 0..4 {
        out.size(blocks.iter().filter(|block| block.0 == dimension).count() as u64);
    }
    for dimension in 0..4 {
        for (tag, block) in (1..).zip(&blocks).filter(|(_, block)| block.0 == dimension) {
            out.int(tag);
            (0..if dimension == 0 { 3 } else { 6 }).for_each(|_| out.float(0.0));
            out.size(block.2.len() as u64);
            block.2.iter().for_each(|&k| out.int(k as i64 + 1));
            if dimension > 0 {
                out.size(0);
            }
        }
    }
    out.text("\n$EndEntities\n$Nodes\n");
    // Those of no cell among the others.
    let mut nodes: Vec<[f64; 3]> = Vec::new();
    let mut place = Vec::new();
    for (k, x) in mesh.nodes.iter().enumerate() {
        if style.unused > 0 && k % style.unused == 0 {
            nodes.push([7.0, 8.0, 9.0]);
        }
        place.push(nodes.len() as u64);
        nodes.push(*x);
    }
    let chunks: Vec<&[[f64; 3]]> = nodes.chunks(style.block).collect();
    [chunks.len() as u64, nodes.len() as u64, 1, 1].into_iter().for_each(|n| out.size(n));
    let mut first = 0;
    for (k, chunk) in chunks.into_iter().enumerate() {
        // Every other block has parameters.
        let parameters = k % 2;
        [2, 1, parameters as i64].into_iter().for_each(|n| out.int(n));
        out.size(chunk.len() as u64);
        (first..).take(chunk.len()).for_each(|i| out.size((style.tag)(i)));
        for x in chunk {
            x.iter().for_each(|&c| out.float(c));
            (0..2 * parameters).for_each(|_| out.float(f64::NAN));
        }
        first += chunk.len() as u64;
    }
    out.text("\n$EndNodes\n$Elements\n");
    let count: usize = blocks.iter().map(|block| block.3.len()).sum();
    [blocks.len() as u64, count as u64, 1, 1].into_iter().for_each(|n| out.size(n));
    let mut number = 0;
    for (tag, (dimension, kind, _, elements)) in (1..).zip(&blocks) {
        [i64::from(*dimension), tag, *kind].into_iter().for_each(|n| out.int(n));
        out.size(elements.len() as u64);
        for element in elements {
            number += 1;
            out.size(number);
            element.iter().for_each(|&node| out.size((style.tag)(place[node as usize])));
        }
    }
    out.text("\n$EndElements\n");
    out.bytes
}
