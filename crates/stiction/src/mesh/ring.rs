//! Pieces of rings and tubes: a block bent about the z axis.

use super::{Block, BlockElement, Mesh, block};
use crate::Error;

/// A piece of a ring about the z axis, from the x axis towards the y axis, standing on z = 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Ring {
    /// Inner and outer radius, 0 < inner < outer; length.
    pub radii: [f64; 2],
    /// Length along z, > 0.
    pub height: f64,
    /// The angle it spans, 0 < degrees <= [`MOST_DEGREES`].
    pub degrees: f64,
    /// Cells along the radius, around and along z, >= 1.
    pub cells: [usize; 3],
    /// Length of the last cell over that of the first in the same directions.
    pub grading: [f64; 3],
    /// Kind of its cells.
    pub element: BlockElement,
}

/// A ring that is nearly closed would touch itself without being joined.
pub const MOST_DEGREES: f64 = 270.0;

/// Groups of a block and what they become.
pub(super) const SIDES: [(&str, &str); 4] =
    [("x-min", "inner"), ("x-max", "outer"), ("y-min", "start"), ("y-max", "end")];

/// The mesh of a piece of a ring, with the groups `inner` `outer` `start` `end` `z-min` `z-max` and `body`. Its nodes
/// lie on the cylinders, its faces are those of the cells.
///
/// # Errors
/// If lengths, angles or numbers of cells are not as [`Ring`] says.
pub fn ring(ring: &Ring) -> Result<Mesh, Error> {
    ring_error(ring)?;
    let mut mesh = block(&ring.straight())?;
    for node in &mut mesh.nodes {
        let [r, angle, z] = *node;
        *node = [r * angle.cos(), r * angle.sin(), z];
    }
    for group in &mut mesh.groups {
        if let Some((_, name)) = SIDES.iter().find(|(old, _)| *old == group.name) {
            group.name = (*name).to_string();
        }
    }
    Ok(mesh)
}

/// Refuses radii and angles that no ring has.
pub(super) fn ring_error(ring: &Ring) -> Result<(), Error> {
    let fail = |what: String, remedy: &str| Err(Error::new("ring", what, remedy));
    let [inner, outer] = ring.radii;
    if !(inner > 0.0 && inner < outer && outer.is_finite()) {
        return fail(format!("its radii are {inner} and {outer}"), "give 0 < inner radius < outer radius");
    }
    if !(ring.degrees > 0.0 && ring.degrees <= MOST_DEGREES) {
        let remedy = "give at most 270; of a whole ring take a half between planes of symmetry";
        return fail(format!("it spans {} degrees", ring.degrees), remedy);
    }
    Ok(())
}

impl Ring {
    /// The block that is bent: radius, angle and height along its axes.
    pub(super) fn straight(&self) -> Block {
        let [inner, outer] = self.radii;
        Block {
            size: [outer - inner, self.degrees.to_radians(), self.height],
            cells: self.cells,
            origin: [inner, 0.0, 0.0],
            grading: self.grading,
            element: self.element,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::info;

    fn tube(element: BlockElement) -> Ring {
        Ring { radii: [2.0, 5.0], height: 4.0, degrees: 90.0, cells: [3, 12, 2], grading: [1.0; 3], element }
    }

    /// Chords cut `sin a / a` of the area of a sector, `a` the angle of a cell.
    #[test]
    fn volume_and_sides_are_those_of_a_tube_of_chords() {
        for element in [BlockElement::Hex8, BlockElement::Tet4Six] {
            let mesh = ring(&tube(element)).unwrap();
            let a: f64 = (90.0f64 / 12.0).to_radians();
            let volume = std::f64::consts::PI / 4.0 * (25.0 - 4.0) * 4.0 * a.sin() / a;
            assert!((info(&mesh).volume / volume - 1.0).abs() < 1e-12);
            let on = |group: &str, test: &dyn Fn([f64; 3]) -> f64| {
                let nodes = mesh.group_nodes(mesh.group(group).unwrap());
                assert!(
                    nodes.len() >= 12 && nodes.iter().all(|&n| test(mesh.nodes[n as usize]).abs() < 1e-12),
                    "{group}"
                );
            };
            on("inner", &|[x, y, _]| x.hypot(y) - 2.0);
            on("outer", &|[x, y, _]| x.hypot(y) - 5.0);
            on("start", &|[_, y, _]| y);
            on("end", &|[x, _, _]| x);
            on("z-max", &|[_, _, z]| z - 4.0);
        }
    }

    #[test]
    fn rings_that_cannot_be_are_refused_with_a_remedy() {
        let good = tube(BlockElement::Hex8);
        let bad = [
            (Ring { radii: [0.0, 1.0], ..good.clone() }, "radii are 0 and 1"),
            (Ring { radii: [2.0, 1.0], ..good.clone() }, "radii are 2 and 1"),
            (Ring { degrees: 360.0, ..good.clone() }, "spans 360 degrees"),
            (Ring { height: f64::NAN, ..good.clone() }, "size along z"),
        ];
        for (ring_, words) in bad {
            let error = ring(&ring_).unwrap_err();
            assert!(error.what.contains(words) && !error.remedy.is_empty(), "{error:?}");
        }
    }
}
