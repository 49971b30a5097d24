//! VTK XML files of pieces (`.pvtu`): a grid that several `.vtu` files hold together.
//!
//! Format: "VTK XML file formats", <https://docs.vtk.org/en/latest/vtk_file_formats/vtkxml_file_format.html>.

use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

use super::folder;
use super::replace::replace;
use super::text::escaped;
use super::vtu::{Array, Data};
use crate::Error;

/// Writes the file that names the pieces, all of which have arrays like these.
///
/// # Errors
/// If the file cannot be written.
pub fn write_pieces(
    path: &Path,
    pieces: &[String],
    point_arrays: &[Array],
    cell_arrays: &[Array],
) -> Result<(), Error> {
    let mut xml = String::from(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PUnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
         header_type=\"UInt64\">\n<PUnstructuredGrid GhostLevel=\"0\">\n",
    );
    for (tag, arrays) in [("PPointData", point_arrays), ("PCellData", cell_arrays)] {
        // Writing to a string cannot fail.
        let _ = writeln!(xml, "<{tag}>");
        for array in arrays {
            let kind = match array.data {
                Data::F64(_) => "Float64",
                Data::F32(_) => "Float32",
                Data::I32(_) => "Int32",
                Data::U64(_) => "Int64",
            };
            let (name, components) = (escaped(array.name), array.components);
            let _ = write!(xml, "<PDataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\"");
            for (k, component) in array.component_names.iter().enumerate() {
                let _ = write!(xml, " ComponentName{k}=\"{}\"", escaped(component));
            }
            xml += "/>\n";
        }
        let _ = writeln!(xml, "</{tag}>");
    }
    xml += "<PPoints>\n<PDataArray type=\"Float64\" Name=\"Points\" NumberOfComponents=\"3\"/>\n</PPoints>\n";
    for piece in pieces {
        let _ = writeln!(xml, "<Piece Source=\"{}\"/>", escaped(piece));
    }
    xml += "</PUnstructuredGrid>\n</VTKFile>\n";
    replace(path, |file| file.write_all(xml.as_bytes()))
}

/// The pieces that [`write_pieces`] named, beside the file.
///
/// # Errors
/// If the file cannot be read.
pub fn named_pieces(path: &Path) -> Result<Vec<PathBuf>, Error> {
    let text = folder::read_text(path)?;
    let names = text.split("<Piece Source=\"").skip(1).filter_map(|rest| rest.split_once('"').map(|(name, _)| name));
    // A name is one of a file in the folder, whatever the file says.
    Ok(names.filter(|name| !name.contains(['/', '\\', '&'])).map(|name| path.with_file_name(name)).collect())
}
