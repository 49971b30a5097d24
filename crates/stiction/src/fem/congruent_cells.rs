//! The stiffness of linear hexahedra that are equal, integrated once.

use super::elements::{Hex8, Law};
use crate::mesh::geometry::HexEdges;
use crate::mesh::v3::V3;

/// Places at which a cell's edges are looked up, 5 MB where all hold a shape: meshes of equal cells have some hundred
/// shapes by the rounding of their coordinates, most of which are rare.
const PLACES: usize = 1 << 10;

/// Lookups in a row without an equal cell after which no more are made: the cells are all different.
const IN_VAIN: u32 = 1 << 12;

/// The rows of blocks `K_00 K_01 .. K_10 ..` of a linear hexahedron.
pub(super) type HexRows = [[[V3; 3]; 8]; 8];

/// The shapes of linear hexahedra that were met more than once lately, for one thread.
///
/// Cells whose edges and material are equal to the bit have the same stiffness, so that what is handed out depends on
/// nothing but the cell. A shape is kept when its second cell comes: where all are different, none is written.
pub(super) struct Shapes {
    places: Vec<Place>,
    /// Lookups since the last that found an equal cell.
    in_vain: u32,
}

#[derive(Clone, Default)]
struct Place {
    /// Number and hash of the last cell that came here and was not known.
    last: (usize, u64),
    shape: Option<Box<Shape>>,
}

#[derive(Clone)]
struct Shape {
    edges: HexEdges,
    material: u32,
    rows: HexRows,
}

impl Shapes {
    pub(super) fn new() -> Self {
        Shapes { places: vec![Place::default(); PLACES], in_vain: 0 }
    }

    /// The rows of `cell` with corners `x`, if another equal to it was met before; also `None` if it is folded.
    pub(super) fn rows(&mut self, cell: usize, x: &[V3; 8], material: u32, law: Law) -> Option<&HexRows> {
        if self.in_vain > IN_VAIN {
            return None;
        }
        let edges = HexEdges::new(x);
        let hash = hash(&edges, material);
        let place = &mut self.places[(hash >> 40) as usize % PLACES];
        let is_known = |shape: &Shape| shape.material == material && is_equal(&shape.edges, &edges);
        if !place.shape.as_deref().is_some_and(is_known) {
            // A cell at two ranges of nodes comes twice, and is not equal to another by that.
            let is_second = place.last.1 == hash && place.last.0 != cell;
            place.last = (cell, hash);
            if !is_second {
                self.in_vain += 1;
                return None;
            }
            let element = Hex8::new(x)?;
            let rows = std::array::from_fn(|i| element.row(i, law));
            place.shape = Some(Box::new(Shape { edges, material, rows }));
        }
        self.in_vain = 0;
        place.shape.as_deref().map(|shape| &shape.rows)
    }
}

/// Whether all bits are equal: zeros of either sign are the same number but need not lead to the same bits.
fn is_equal(a: &HexEdges, b: &HexEdges) -> bool {
    bits(a).eq(bits(b))
}

fn bits(edges: &HexEdges) -> impl Iterator<Item = u64> {
    edges.0.as_flattened().as_flattened().iter().map(|x| x.to_bits())
}

/// A number that depends on every bit.
fn hash(edges: &HexEdges, material: u32) -> u64 {
    // Multiplication by an odd constant (the golden ratio, Knuth 6.4) carries low bits up, the turn high ones down.
    const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;
    bits(edges).fold(u64::from(material), |sum, bits| (sum.rotate_left(29) ^ bits).wrapping_mul(GOLDEN))
}
