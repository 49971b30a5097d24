//! Memory of a run, predicted from counts before it is taken, and how much there is.

use std::path::Path;

use super::path::in_terms_of_the_case;
use crate::Error;
use crate::io::case::SolverSpec;
use crate::io::machine;
use crate::linalg::memory::{Room, ensure, room};
use crate::mesh::{BlockElement, CellKind, Mesh};

/// Part of what is available that a run takes at most.
const SHARE: f64 = 0.9;

/// Bytes by counts of the mesh: the most at a time over what was there before, in a phase. `tests/memory/predictions.rs` holds
/// them against what is allocated.
struct Bytes;

impl Bytes {
    /// A node of a mesh of each kind until its stiffness matrix stands and its contact is posed: coordinates, cells, boundary,
    /// matrix, with three unknowns at nearly all nodes. More prescribed ones are counted when the matrix is.
    const HEX8: f64 = 1750.0;
    const TET4: f64 = 1300.0;
    const HEX20: f64 = 3400.0;
    const TET10: f64 = 1800.0;
    const WEDGE6: f64 = 1550.0;
    const WEDGE15: f64 = 2600.0;
    /// A node of a mesh that is made and divided, and assembled elsewhere.
    const DIVIDED: f64 = 450.0;
    /// A node of a mesh that others have solved on, until the error of their answer is estimated.
    const LOOKED_AT: f64 = 1000.0;
    /// What comes on top of small meshes.
    const POSING: f64 = 6e6;
    /// Files of results: fields of nodes and cells in all their forms.
    const OUTPUT: [f64; 3] = [15e6, 250.0, 120.0];
    /// The pictures, whose size is fixed.
    const PICTURES: f64 = 80e6;
    /// The report, which reads some of the files again.
    const REPORT: [f64; 3] = [40e6, 90.0, 75.0];
    /// A byte of a mesh file of text or numbers, and of one that may be compressed, while it is read.
    const FILE: f64 = 3.0;
    const COMPRESSED_FILE: f64 = 10.0;
    /// The same of the range that one of several ranks reads, with what it is sent of the others.
    const RANGE: f64 = 5.0;
    const COMPRESSED_RANGE: f64 = 16.0;
    /// A byte of the stored problem while it is checked.
    const PROBLEM: f64 = 3.0;
    /// A byte of a compressed result that is read again.
    const RESULT: f64 = 3.0;
}

/// What a run may use, and what says so.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MemoryLimit {
    /// Bytes; no limit where the system does not tell.
    pub bytes: Option<u64>,
    /// What sets it, for messages.
    pub of: String,
    /// Whether the case asks for it: such a limit is one of stored matrices, not of what their files take.
    pub by_case: bool,
    /// Whether the mesh is made to be divided: no matrix of all of it follows.
    pub(crate) divided: bool,
}

impl MemoryLimit {
    /// What the case asks for; without that nine tenths of what is available now.
    pub fn of(spec: &SolverSpec) -> Self {
        Self::of_each(spec, 1)
    }

    /// The same for each of so many processes on this machine.
    pub(crate) fn of_each(spec: &SolverSpec, processes: usize) -> Self {
        if let Some(gigabytes) = spec.memory {
            let (bytes, of) = (Some((gigabytes * 1e9) as u64), "`memory` under [solver]".into());
            return MemoryLimit { bytes, of, by_case: true, divided: false };
        }
        machine::available_to(processes).map_or_else(Self::default, |available| {
            let among = if available.shared && processes > 1 {
                format!(", for each of {processes} ranks")
            } else {
                String::new()
            };
            MemoryLimit {
                bytes: Some((SHARE * available.bytes as f64) as u64),
                of: format!("{:.0} % of {}{among}", 100.0 * SHARE, available.of),
                by_case: false,
                divided: false,
            }
        })
    }

    /// An error of too little memory with what sets the limit, in terms of the case; others as they are.
    pub(crate) fn named(&self, error: Error) -> Error {
        let mut error = error;
        if is_of_memory(&error) && error.what.ends_with("may be used") && !self.of.is_empty() {
            error.what += &format!(" ({})", self.of);
        }
        in_terms_of_the_case(error)
    }
}

/// Whether an error is one of too little memory, which is a matter of the mesh.
pub(crate) fn is_of_memory(error: &Error) -> bool {
    error.remedy.contains("`settings.memory_limit`")
}

/// The same of an error in terms of the case.
pub(crate) fn was_of_memory(error: &Error) -> bool {
    error.remedy.contains("`memory` under [solver]")
}

/// Refuses a mesh whose matrix alone would not fit, before it is made or assembled: nobody should find that out by the machine
/// running out of memory.
pub(crate) fn posing_fits(nodes: f64, each: f64, limit: &MemoryLimit) -> Result<(), Error> {
    let (what, each) = match limit.divided {
        true => (format!("a mesh of {nodes:.0} nodes, which one rank divides,"), Bytes::DIVIDED),
        false => (format!("a mesh of {nodes:.0} nodes with its stiffness matrix"), each),
    };
    ensure(&what, Bytes::POSING + nodes * each, limit.bytes).map_err(|error| limit.named(error))
}

/// Refuses to look at the answer that others have found on a mesh of so many nodes.
pub(crate) fn looking_fits(nodes: f64, limit: &MemoryLimit) -> Result<(), Error> {
    let what = format!("looking at the answer of all ranks on a mesh of {nodes:.0} nodes");
    ensure(&what, Bytes::POSING + nodes * Bytes::LOOKED_AT, limit.bytes).map_err(|error| limit.named(error))
}

/// Bytes a node of a block costs until its contact is posed.
pub(crate) fn of_block(element: BlockElement) -> f64 {
    match element {
        BlockElement::Hex8 => Bytes::HEX8,
        BlockElement::Hex20 => Bytes::HEX20,
        BlockElement::Wedge6 => Bytes::WEDGE6,
        BlockElement::Wedge15 => Bytes::WEDGE15,
        BlockElement::Tet4Five { .. } | BlockElement::Tet4Six => Bytes::TET4,
        BlockElement::Tet10Five { .. } | BlockElement::Tet10Six => Bytes::TET10,
    }
}

/// The same of a mesh, by the kinds of its cells.
pub(crate) fn of_mesh(mesh: &Mesh) -> f64 {
    of_kinds(mesh.cells.iter().filter(|cells| !cells.is_empty()).map(|cells| cells.kind))
}

/// The same of cells of these kinds.
pub(crate) fn of_kinds(kinds: impl Iterator<Item = CellKind>) -> f64 {
    let of_kind = |kind: CellKind| match kind {
        CellKind::Tet4 => Bytes::TET4,
        CellKind::Hex8 => Bytes::HEX8,
        CellKind::Tet10 => Bytes::TET10,
        CellKind::Hex20 => Bytes::HEX20,
        CellKind::Wedge6 => Bytes::WEDGE6,
        CellKind::Wedge15 => Bytes::WEDGE15,
    };
    kinds.map(of_kind).fold(0.0, f64::max)
}

/// Refuses a mesh file that cannot be read in the memory there is.
pub(super) fn reading_fits(path: &Path) -> Result<(), Error> {
    let each = if may_be_compressed(path) { Bytes::COMPRESSED_FILE } else { Bytes::FILE };
    ensure("this mesh file", each * length(path), None).map_err(in_terms_of_the_case)
}

/// Refuses one that so many ranks cannot read together.
pub(crate) fn range_fits(path: &Path, ranks: usize) -> Result<(), Error> {
    let each = if may_be_compressed(path) { Bytes::COMPRESSED_RANGE } else { Bytes::RANGE };
    let what = format!("a range of this mesh file, one of {ranks},");
    ensure(&what, each * length(path) / ranks as f64, None).map_err(in_terms_of_the_case)
}

fn may_be_compressed(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("vtu"))
}

/// Takes hold of what the files of a result need, so that a solution that has been found can be written.
pub(crate) fn output_room(mesh: &Mesh, pictures: bool, limit: &MemoryLimit) -> Result<Room, Error> {
    let (output, report) = (of_output(mesh, pictures), by_counts(Bytes::REPORT, mesh));
    let most = limit.bytes.filter(|_| !limit.by_case);
    room("writing the results", output.max(report), most).map_err(|error| limit.named(error))
}

/// Refuses output for which there is no memory.
pub(crate) fn output_fits(mesh: &Mesh, pictures: bool) -> Result<(), Error> {
    ensure("writing the results", of_output(mesh, pictures), None).map_err(in_terms_of_the_case)
}

fn of_output(mesh: &Mesh, pictures: bool) -> f64 {
    by_counts(Bytes::OUTPUT, mesh) + if pictures { Bytes::PICTURES } else { 0.0 }
}

/// Refuses a report for which there is no memory; without a mesh at hand it reads that of the result in `folder`.
#[cfg(feature = "report")]
pub(crate) fn report_fits(folder: &Path, mesh: Option<&Mesh>) -> Result<(), Error> {
    let bytes = match mesh {
        Some(mesh) => by_counts(Bytes::REPORT, mesh),
        None => Bytes::REPORT[0] + Bytes::RESULT * length(&folder.join("result.vtu")),
    };
    ensure("the report", bytes, None).map_err(in_terms_of_the_case)
}

/// Refuses a report for which there is no memory, of bodies in these pieces, which are read and then joined.
#[cfg(feature = "report")]
pub(crate) fn report_of_pieces_fits(pieces: &[std::path::PathBuf]) -> Result<(), Error> {
    let bytes = 2.0 * pieces.iter().map(|path| length(path)).sum::<f64>();
    ensure("the report", Bytes::REPORT[0] + Bytes::RESULT * bytes, None).map_err(in_terms_of_the_case)
}

/// Refuses a check for which there is no memory.
pub(crate) fn check_fits(folder: &Path) -> Result<(), Error> {
    judging_fits(length(&folder.join("problem.npz")), length(&folder.join("result.vtu")))
}

/// The same by the bytes of the problem and of the body.
fn judging_fits(problem: f64, body: f64) -> Result<(), Error> {
    let bytes = Bytes::POSING + Bytes::PROBLEM * problem + Bytes::RESULT * body;
    ensure("the check", bytes, None).map_err(in_terms_of_the_case)
}

/// Refuses a check of the pieces called `names` for which there is no memory.
pub(crate) fn check_of_pieces_fits(folder: &Path, names: &[String]) -> Result<(), Error> {
    judging_fits(names.iter().map(|name| length(&folder.join(name))).sum(), 0.0)
}

/// Bytes of a file; none of one that cannot be looked at, which its reader tells.
fn length(path: &Path) -> f64 {
    std::fs::metadata(path).map_or(0, |data| data.len()) as f64
}

fn by_counts([fixed, of_node, of_cell]: [f64; 3], mesh: &Mesh) -> f64 {
    fixed + of_node * mesh.nodes.len() as f64 + of_cell * mesh.cell_count() as f64
}
