//! Linear cells made quadratic.

use super::v3::{add, scale};
use super::{CellKind, RawCells, ascending};

/// The quadratic cells with the same corners and straight edges. The nodes in the middles of the edges are appended to
/// `nodes`, sorted by the lower and then the higher corner of their edge.
pub(super) fn quadratic(nodes: &mut Vec<[f64; 3]>, cells: RawCells) -> RawCells {
    let kind = match cells.kind.linear() {
        CellKind::Tet4 | CellKind::Tet10 => CellKind::Tet10,
        CellKind::Hex8 | CellKind::Hex20 => CellKind::Hex20,
        CellKind::Wedge6 | CellKind::Wedge15 => CellKind::Wedge15,
    };
    let ends = |cell: &[u32], [a, b]: [usize; 2]| [cell[a].min(cell[b]), cell[a].max(cell[b])];
    let corners = cells.kind.nodes();
    let each = || cells.nodes.chunks_exact(corners);
    let edges = ascending(each().flat_map(|cell| kind.edges().iter().map(|&e| ends(cell, e))));
    let first = nodes.len() as u32;
    let mut all = Vec::with_capacity(cells.nodes.len() / corners * kind.nodes());
    for cell in each() {
        all.extend_from_slice(cell);
        all.extend(kind.edges().iter().map(|&e| {
            let end = ends(cell, e);
            first + edges.partition_point(|edge| *edge < end) as u32
        }));
    }
    let middle = |[a, b]: &[u32; 2]| scale(0.5, add(nodes[*a as usize], nodes[*b as usize]));
    let middles: Vec<[f64; 3]> = edges.iter().map(middle).collect();
    nodes.extend(middles);
    RawCells { kind, nodes: all, ids: cells.ids }
}
