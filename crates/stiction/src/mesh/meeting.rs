//! Cells of a part of a mesh, checked as those of a whole are, and how they meet.

use super::face_table::{Encounters, FaceTable};
use super::{Face, RawMesh, check};
use crate::Error;

/// How the cells of a part meet. A face all of whose cells are in the part is known as in the whole.
pub struct Meeting<'a> {
    table: FaceTable<'a>,
    seen: Encounters,
}

impl<'a> Meeting<'a> {
    /// Of a part without groups and arrays, in which no block of cells is empty.
    ///
    /// # Errors
    /// As of [`build`](super::build()).
    pub fn new(raw: &'a RawMesh) -> Result<Meeting<'a>, Error> {
        if raw.cell_count() > 0 {
            check::numbers(raw)?;
            check::shapes(raw)?;
        }
        let (table, seen) = FaceTable::new(raw);
        check::neighbours(raw, &seen)?;
        Ok(Meeting { table, seen })
    }

    /// The faces of one cell of the part, ascending by their cells.
    pub fn boundary(&self) -> impl Iterator<Item = Face> {
        self.seen.boundary.iter().map(|&face| self.table.face(face))
    }

    /// A face with these corners in any order, of which triangles end in `u32::MAX`, and whether it is of one cell of the part only.
    pub fn find(&self, corners: [u32; 4]) -> Option<(Face, bool)> {
        let found = self.table.find(corners);
        found.first().map(|&face| (self.table.face(face), found.len() == 1))
    }
}
