//! Files that are no Gmsh mesh, recognised by how they begin.

use crate::Error;

/// Beginnings of other formats: bytes, what they mean, what to do.
const BEGINNINGS: [(&[u8], &str, &str); 14] = [
    (b"solid", "an STL surface", STL),
    (b"<?xml", "an XML file, perhaps VTU", VTU),
    (b"<VTKFile", "a VTU file", VTU),
    (b"# vtk", "a legacy VTK file", GMSH),
    (b"*", "an Abaqus or CalculiX input", "name it with the extension .inp"),
    (b"$NOD", "a Gmsh mesh of version 1", GMSH),
    (b"(", "a Fluent mesh", GMSH),
    (b"ply", "a PLY surface", STL),
    (b"ISO-10303", "a STEP geometry, not a mesh", STL),
    (b"\x89HDF", "an HDF5 file, perhaps MED or CGNS", GMSH),
    (b"\x1f\x8b", "compressed with gzip", "decompress it first"),
    (b"PK\x03\x04", "a zip archive", "unpack it first"),
    (b"SetFactory", "a Gmsh geometry, not a mesh", GEO),
    (b"Point(", "a Gmsh geometry, not a mesh", GEO),
];

const GMSH: &str = "convert it to a Gmsh mesh, MSH 4.1 or 2.2, for instance by opening and saving it in Gmsh";
const STL: &str = "mesh the volume it encloses, for instance in Gmsh, and save MSH 4.1";
const VTU: &str = "name it with the extension .vtu";
const GEO: &str = "mesh it: gmsh -3 -format msh41";

/// Extensions of other formats, for files whose beginning tells nothing.
const EXTENSIONS: [(&str, &str, &str); 6] = [
    ("stl", "an STL surface", STL),
    ("geo", "a Gmsh geometry, not a mesh", GEO),
    ("obj", "an OBJ surface", STL),
    ("unv", "an I-deas universal file", GMSH),
    ("bdf", "a Nastran input", GMSH),
    ("nas", "a Nastran input", GMSH),
];

/// An error unless the bytes begin as a Gmsh mesh does.
pub(super) fn refuse(bytes: &[u8], source_name: &str) -> Result<(), Error> {
    let start = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    if start.is_empty() {
        return Err(Error::new("", "the file is empty", "was writing it interrupted?"));
    }
    let extension = source_name.rsplit_once('.').map_or("", |(_, e)| e);
    let by_bytes = BEGINNINGS.iter().find(|(b, ..)| start.starts_with(b)).map(|&(_, what, remedy)| (what, remedy));
    let by_name = EXTENSIONS.iter().find(|(e, ..)| extension.eq_ignore_ascii_case(e)).map(|&(_, what, r)| (what, r));
    match by_bytes.or(by_name.filter(|_| start[0] != b'$')) {
        Some((what, remedy)) => Err(Error::new("", format!("this is {what}, not a Gmsh mesh"), remedy)),
        None if start[0] != b'$' => {
            Err(Error::new("", "this is not a Gmsh mesh: it does not begin with $MeshFormat", GMSH))
        }
        None => Ok(()),
    }
}
