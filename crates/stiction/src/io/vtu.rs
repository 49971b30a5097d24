//! VTK XML unstructured grids (`.vtu`): compressed appended binary, read by ParaView, PyVista and meshio.
//!
//! Format: "VTK XML file formats", <https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html>.

use std::fmt::Write as _;
use std::fs::File;
use std::io::{self, BufWriter, Write as _};
#[cfg(unix)]
use std::io::{Seek as _, SeekFrom};
use std::path::Path;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use rayon::prelude::*;

use super::replace::replace;
use super::text::escaped;
use crate::Error;
use crate::mesh::{CellKind, Mesh};

/// Bytes compressed at a time, a multiple of eight; fixed, so that a file does not depend on the number of threads.
const BLOCK: usize = 1 << 20;

/// Codes of cells in VTK.
pub const VERTEX: u8 = 1;
/// VTK's number of this kind of cell: three nodes.
pub const TRIANGLE: u8 = 5;
/// VTK's number of this kind of cell: four nodes.
pub const QUAD: u8 = 9;
/// VTK's number of this kind of cell: four nodes.
pub const TETRA: u8 = 10;
/// VTK's number of this kind of cell: eight nodes.
pub const HEXAHEDRON: u8 = 12;
/// VTK's number of this kind of cell: six nodes.
pub const QUADRATIC_TRIANGLE: u8 = 22;
/// VTK's number of this kind of cell: eight nodes.
pub const QUADRATIC_QUAD: u8 = 23;
/// VTK's number of this kind of cell: ten nodes.
pub const QUADRATIC_TETRA: u8 = 24;
/// VTK's number of this kind of cell: twenty nodes.
pub const QUADRATIC_HEXAHEDRON: u8 = 25;
/// VTK code of a linear wedge.
pub const WEDGE: u8 = 13;
/// VTK code of a quadratic wedge with 15 nodes.
pub const QUADRATIC_WEDGE: u8 = 26;

/// The code of a face with 3, 4, 6 or 8 nodes.
pub fn face_code(nodes: usize) -> u8 {
    match nodes {
        3 => TRIANGLE,
        4 => QUAD,
        6 => QUADRATIC_TRIANGLE,
        _ => QUADRATIC_QUAD,
    }
}

/// Points and cells of a file; the cells keep their order.
#[derive(Debug, Clone)]
pub struct Grid<'a> {
    /// Coordinates, length.
    pub points: &'a [[f64; 3]],
    /// Nodes of all cells, one cell after the other.
    pub connectivity: Vec<u32>,
    /// Where each cell ends in `connectivity`.
    pub ends: Vec<u64>,
    /// VTK code of each cell.
    pub codes: Vec<u8>,
}

impl<'a> Grid<'a> {
    /// A grid without cells.
    pub fn new(points: &'a [[f64; 3]]) -> Self {
        Grid { points, connectivity: Vec::new(), ends: Vec::new(), codes: Vec::new() }
    }

    /// Adds a cell with its nodes in VTK's order.
    pub fn push(&mut self, code: u8, nodes: &[u32]) {
        self.connectivity.extend_from_slice(nodes);
        self.ends.push(self.connectivity.len() as u64);
        self.codes.push(code);
    }

    /// The cells of a mesh, in the mesh's numbering.
    pub fn from_mesh(mesh: &'a Mesh) -> Self {
        let mut grid = Grid::new(&mesh.nodes);
        grid.connectivity.reserve(mesh.cells.iter().map(|c| c.nodes.len()).sum());
        for cells in &mesh.cells {
            let code = match cells.kind {
                CellKind::Tet4 => TETRA,
                CellKind::Hex8 => HEXAHEDRON,
                CellKind::Tet10 => QUADRATIC_TETRA,
                CellKind::Hex20 => QUADRATIC_HEXAHEDRON,
                CellKind::Wedge6 => WEDGE,
                CellKind::Wedge15 => QUADRATIC_WEDGE,
            };
            (0..cells.len()).for_each(|i| grid.push(code, cells.cell(i)));
        }
        grid
    }
}

/// Numbers of an array, `components` a point or cell.
#[derive(Debug, Clone, Copy)]
pub enum Data<'a> {
    /// Double precision.
    F64(&'a [f64]),
    /// Single precision.
    F32(&'a [f32]),
    /// Whole numbers.
    I32(&'a [i32]),
    /// Numbers of what there may be more of than 32 bits count; stored with a sign, as VTK's own are.
    U64(&'a [u64]),
}

impl Data<'_> {
    fn len(&self) -> usize {
        match self {
            Data::F64(v) => v.len(),
            Data::F32(v) => v.len(),
            Data::I32(v) => v.len(),
            Data::U64(v) => v.len(),
        }
    }
}

/// A named array over points, over cells or of the whole file.
#[derive(Debug, Clone, Copy)]
pub struct Array<'a> {
    /// Its name.
    pub name: &'a str,
    /// Numbers a point or cell: 1 scalar, 3 vector, 6 symmetric tensor in the order xx yy zz xy yz xz.
    pub components: usize,
    /// Names of the components, or empty.
    pub component_names: &'a [&'a str],
    /// Its numbers, entity by entity.
    pub data: Data<'a>,
}

impl<'a> Array<'a> {
    /// One number a point or cell.
    pub fn scalar(name: &'a str, values: &'a [f64]) -> Self {
        Array { name, components: 1, component_names: &[], data: Data::F64(values) }
    }

    /// One number a point or cell in single precision.
    pub fn single(name: &'a str, values: &'a [f32]) -> Self {
        Array { name, components: 1, component_names: &[], data: Data::F32(values) }
    }

    /// One integer a point or cell.
    pub fn integer(name: &'a str, values: &'a [i32]) -> Self {
        Array { name, components: 1, component_names: &[], data: Data::I32(values) }
    }

    /// The number of something, a point or cell.
    pub fn number(name: &'a str, values: &'a [u64]) -> Self {
        Array { name, components: 1, component_names: &[], data: Data::U64(values) }
    }

    /// A vector a point or cell.
    pub fn vector(name: &'a str, values: &'a [[f64; 3]]) -> Self {
        Array { name, components: 3, component_names: &["x", "y", "z"], data: Data::F64(values.as_flattened()) }
    }

    /// A symmetric tensor a point or cell in single precision, in the order xx yy zz xy yz xz.
    pub fn tensor(name: &'a str, values: &'a [[f32; 6]]) -> Self {
        let component_names = &["xx", "yy", "zz", "xy", "yz", "xz"];
        Array { name, components: 6, component_names, data: Data::F32(values.as_flattened()) }
    }
}

/// Points and cells as the file stores them, of use for several files or before their arrays are there.
#[derive(Debug, Clone)]
pub struct EncodedGrid {
    points: usize,
    cells: usize,
    coordinates: Encoded,
    /// Connectivity, offsets and types.
    of_cells: [Encoded; 3],
}

impl EncodedGrid {
    /// Encodes a grid, by the threads of rayon or by the caller alone.
    ///
    /// # Errors
    /// If the cells do not fit together or name points that are not there.
    pub fn new(grid: &Grid, by_threads: bool) -> Result<Self, Error> {
        validate_cells(grid)?;
        let of_cells = [
            Encoded::new("Int64", "", "connectivity", &grid.connectivity, by_threads),
            Encoded::new("Int64", "", "offsets", &grid.ends, by_threads),
            Encoded::new("UInt8", "", "types", &grid.codes, by_threads),
        ];
        let attributes = "NumberOfComponents=\"3\"";
        let coordinates = Encoded::new("Float64", attributes, "Points", grid.points.as_flattened(), by_threads);
        Ok(EncodedGrid { points: grid.points.len(), cells: grid.codes.len(), coordinates, of_cells })
    }
}

/// Writes a grid with its arrays.
///
/// # Errors
/// If an array does not have as many numbers as the grid has points or cells, the cells do not fit together, or the file
/// cannot be written.
pub fn write(path: &Path, grid: &Grid, point_arrays: &[Array], cell_arrays: &[Array]) -> Result<(), Error> {
    let encoded = EncodedGrid::new(grid, true).map_err(|e| e.at(&path.display().to_string()))?;
    write_encoded(path, &encoded, point_arrays, cell_arrays)
}

/// [`write()`] for points and cells that are encoded already.
///
/// # Errors
/// As `write`.
pub fn write_encoded(
    path: &Path,
    grid: &EncodedGrid,
    point_arrays: &[Array],
    cell_arrays: &[Array],
) -> Result<(), Error> {
    validate_arrays(grid, point_arrays, cell_arrays).map_err(|e| e.at(&path.display().to_string()))?;
    let EncodedGrid { points, cells, coordinates, of_cells } = grid;
    let mut xml = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\" compressor=\"vtkZLibDataCompressor\">\n<UnstructuredGrid>\n<FieldData>\n</FieldData>\n",
    );
    let [point_data, cell_data] =
        [point_arrays, cell_arrays].map(|arrays| arrays.iter().map(encoded).collect::<Vec<_>>());
    let mut appended = Appended::default();
    let _ = writeln!(xml, "<Piece NumberOfPoints=\"{points}\" NumberOfCells=\"{cells}\">");
    appended.section(&mut xml, "PointData", &point_data);
    appended.section(&mut xml, "CellData", &cell_data);
    appended.section(&mut xml, "Points", std::slice::from_ref(coordinates));
    appended.section(&mut xml, "Cells", of_cells);
    xml.push_str("</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_");
    replace(path, |file| {
        file.write_all(xml.as_bytes())?;
        write_together(file, &appended.parts)?;
        file.write_all(b"\n</AppendedData>\n</VTKFile>\n")
    })
}

/// Writes the parts one after the other, by all threads where the system can write at a place: most of the time goes into
/// fresh pages of its cache.
#[cfg(unix)]
fn write_together(file: &mut BufWriter<File>, parts: &[&[u8]]) -> io::Result<()> {
    use std::os::unix::fs::FileExt;
    let begin = file.stream_position()?;
    let ends = parts.iter().scan(begin, |end, part| {
        *end += part.len() as u64;
        Some(*end)
    });
    let ends: Vec<u64> = ends.collect();
    file.flush()?;
    let target = file.get_ref();
    let write = |(part, end): (&&[u8], &u64)| target.write_all_at(part, end - part.len() as u64);
    parts.par_iter().zip(&ends).try_for_each(write)?;
    file.seek(SeekFrom::Start(ends.last().copied().unwrap_or(begin))).map(|_| ())
}

#[cfg(not(unix))]
fn write_together(file: &mut BufWriter<File>, parts: &[&[u8]]) -> io::Result<()> {
    parts.iter().try_for_each(|part| file.write_all(part))
}

fn invalid<T>(what: String) -> Result<T, Error> {
    Err(Error::new("", what, "give as many numbers as the grid has points or cells"))
}

fn validate_cells(grid: &Grid) -> Result<(), Error> {
    let Grid { points, connectivity, ends, codes } = grid;
    if ends.len() != codes.len() || ends.last().copied().unwrap_or(0) != connectivity.len() as u64 {
        return invalid(format!("{} cell ends for {} cells", ends.len(), codes.len()));
    }
    if ends.windows(2).any(|w| w[0] > w[1]) {
        return invalid("the cells' ends descend".to_string());
    }
    if let Some(&node) = connectivity.iter().find(|&&node| node as usize >= points.len()) {
        return invalid(format!("a cell has node {node}, but there are {} points", points.len()));
    }
    Ok(())
}

fn validate_arrays(grid: &EncodedGrid, point_arrays: &[Array], cell_arrays: &[Array]) -> Result<(), Error> {
    let of_points = point_arrays.iter().map(|a| (a, grid.points));
    for (array, tuples) in of_points.chain(cell_arrays.iter().map(|a| (a, grid.cells))) {
        let (name, components, len) = (array.name, array.components, array.data.len());
        if components == 0 || tuples * components != len {
            let expected = format!("for {tuples} points or cells");
            return invalid(format!("array \"{name}\" has {len} numbers by {components} components {expected}"));
        }
        if !array.component_names.is_empty() && array.component_names.len() != components {
            return invalid(format!("array \"{name}\" does not name each of its {components} components"));
        }
    }
    Ok(())
}

/// Writes a collection of files over time (`.pvd`), which ParaView opens as one; names are relative to its folder.
///
/// # Errors
/// If the file cannot be written.
pub fn write_collection(path: &Path, files: &[(f64, String)]) -> Result<(), Error> {
    let mut xml =
        String::from("<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n");
    for (t, name) in files {
        // Writing to a string cannot fail.
        let _ = writeln!(xml, "<DataSet timestep=\"{t:?}\" file=\"{}\"/>", escaped(name));
    }
    xml += "</Collection>\n</VTKFile>\n";
    replace(path, |file| file.write_all(xml.as_bytes()))
}

/// The binary section of the file, growing with the description of its arrays.
#[derive(Default)]
struct Appended<'a> {
    parts: Vec<&'a [u8]>,
    bytes: usize,
}

impl<'a> Appended<'a> {
    fn section(&mut self, xml: &mut String, tag: &str, arrays: &'a [Encoded]) {
        let _ = writeln!(xml, "<{tag}>");
        for array in arrays {
            let (described, offset) = (&array.described, self.bytes);
            let _ = writeln!(xml, "<DataArray {described} format=\"appended\" offset=\"{offset}\"/>");
            self.parts.extend(array.parts.iter().map(Vec::as_slice));
            self.bytes += array.parts.iter().map(Vec::len).sum::<usize>();
        }
        let _ = writeln!(xml, "</{tag}>");
    }
}

/// An array as the file stores it.
#[derive(Debug, Clone)]
struct Encoded {
    /// Type, name and components, as attributes.
    described: String,
    /// The header and the blocks.
    parts: Vec<Vec<u8>>,
}

fn encoded(array: &Array) -> Encoded {
    let mut attributes = format!("NumberOfComponents=\"{}\"", array.components);
    for (i, name) in array.component_names.iter().enumerate() {
        let _ = write!(attributes, " ComponentName{i}=\"{}\"", escaped(name));
    }
    match array.data {
        Data::F64(values) => Encoded::new("Float64", &attributes, array.name, values, true),
        Data::F32(values) => Encoded::new("Float32", &attributes, array.name, values, true),
        Data::I32(values) => Encoded::new("Int32", &attributes, array.name, values, true),
        Data::U64(values) => Encoded::new("Int64", &attributes, array.name, values, true),
    }
}

impl Encoded {
    fn new<T: Number>(kind: &str, attributes: &str, name: &str, values: &[T], by_threads: bool) -> Encoded {
        let described = format!("type=\"{kind}\" Name=\"{}\" {attributes}", escaped(name));
        let level = level(values);
        let length = BLOCK / T::BYTES;
        let blocks: Vec<Vec<u8>> = if by_threads {
            values.par_chunks(length).map(|part| compress(part, level)).collect()
        } else {
            values.chunks(length).map(|part| compress(part, level)).collect()
        };
        // Header: number of blocks, bytes of a block, bytes of the last block if it is a partial one, compressed bytes.
        let partial = values.len() * T::BYTES % BLOCK;
        let sizes = blocks.iter().map(Vec::len);
        let header = [blocks.len(), BLOCK, partial].into_iter().chain(sizes).flat_map(|n| (n as u64).to_le_bytes());
        Encoded { described, parts: std::iter::once(header.collect()).chain(blocks).collect() }
    }
}

/// Full digits hardly shrink, and trying costs more than all the rest of the file: a sample from the middle decides.
fn level<T: Number>(values: &[T]) -> Compression {
    let count = values.len().min(SAMPLE / T::BYTES);
    let sample = &values[(values.len() - count) / 2..][..count];
    let shrinks = 10 * compress(sample, Compression::fast()).len() < 8 * count * T::BYTES;
    if shrinks { Compression::fast() } else { Compression::none() }
}

/// Bytes of the sample.
const SAMPLE: usize = 1 << 16;

fn compress<T: Number>(values: &[T], level: Compression) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(values.len() * T::BYTES);
    values.iter().for_each(|v| v.put(&mut bytes));
    if level == Compression::none() {
        return stored(&bytes);
    }
    let mut encoder = ZlibEncoder::new(Vec::with_capacity(bytes.len() / 2), level);
    encoder.write_all(&bytes).and_then(|()| encoder.finish()).expect("memory takes every byte")
}

/// Bytes, at least one, as they are in the format of zlib (RFC 1950 and 1951); the encoder would move each of them several times.
fn stored(bytes: &[u8]) -> Vec<u8> {
    const MOST: usize = u16::MAX as usize;
    let parts = bytes.len().div_ceil(MOST);
    let mut stream = Vec::with_capacity(bytes.len() + 5 * parts + 6);
    // Deflate with a window of 32 KB, compressed as fast as can be.
    stream.extend([0x78, 0x01]);
    for (number, part) in (1..).zip(bytes.chunks(MOST)) {
        let length = part.len() as u16;
        stream.push(u8::from(number == parts));
        stream.extend(length.to_le_bytes());
        stream.extend((!length).to_le_bytes());
        stream.extend_from_slice(part);
    }
    stream.extend(simd_adler32::adler32(&bytes).to_be_bytes());
    stream
}

/// A number as the file stores it, little endian.
trait Number: Copy + Sync {
    const BYTES: usize;
    fn put(self, bytes: &mut Vec<u8>);
}

macro_rules! number {
    ($type:ty, $stored:ty) => {
        impl Number for $type {
            const BYTES: usize = size_of::<$stored>();
            fn put(self, bytes: &mut Vec<u8>) {
                bytes.extend_from_slice(&(self as $stored).to_le_bytes());
            }
        }
    };
}
number!(f64, f64);
number!(f32, f32);
number!(i32, i32);
number!(u32, i64);
number!(u64, i64);
number!(u8, u8);

#[cfg(test)]
#[path = "vtu_tests.rs"]
mod tests;
