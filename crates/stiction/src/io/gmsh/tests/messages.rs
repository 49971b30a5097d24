//! What cannot be read is refused with a place, a reason and a remedy.

use super::*;

/// The message must hold all of `words`.
fn refused(bytes: &[u8], words: &[&str]) {
    let message = parse(bytes, "part.msh", 1.0).map(|_| ()).unwrap_err().to_string();
    for word in words.iter().chain(&["part.msh"]) {
        assert!(message.contains(word), "\"{word}\" is not in: {message}");
    }
}

/// The tetrahedron with `from` replaced by `to`.
fn edited(from: &str, to: &str) -> Vec<u8> {
    let text = tet22(1, "7 4 2 1 1 1 2 3 9\n");
    assert!(text.contains(from));
    text.replacen(from, to, 1).into_bytes()
}

#[test]
fn damaged_text_is_refused_by_line() {
    refused(&edited("2 1 0 0", "2 1 zero 0"), &["line 7", "\"zero\"", "y was expected"]);
    refused(&edited("$Nodes\n4", "$Nodes\n-4"), &["line 5", "-4"]);
    refused(&edited("$Nodes\n4", "$Nodes\n4000000000000"), &["line 5", "4000000000000 nodes", "only"]);
    refused(&edited("$Nodes\n4", "$Nodes\n99999999999999999999999"), &["line 5", "9999"]);
    refused(&edited("$Nodes\n4", "$Nodes\n3"), &["line 9", "$EndNodes"]);
    refused(&edited("$EndElements\n", ""), &["line 14", "$EndElements"]);
    refused(&edited("7 4 2", "7 4444 2"), &["line 13", "element type 4444"]);
    refused(&edited("$EndMeshFormat", "$EndMesh"), &["line 3", "$EndMeshFormat"]);
    refused(&edited("$Elements", "stray"), &["line 11", "section"]);
    refused(&edited("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n", ""), &["$MeshFormat"]);
}

#[test]
fn unusable_contents_are_refused_by_number() {
    refused(&edited("2 1 0 0", "2 1 nan 0"), &["node 2", "finite"]);
    refused(&edited("2 1 0 0", "2 1e999 0 0"), &["node 2", "finite"]);
    refused(&edited("2 1 0 0", "1 1 0 0"), &["node 1", "more than once"]);
    refused(&edited("1 2 3 9\n$End", "1 2 3 8\n$End"), &["element 7", "node 8"]);
    refused(&edited("1 2 3 9\n$End", "2 1 3 9\n$End"), &["element 7", "inside out", "mirrored"]);
    refused(&edited("1 2 3 9\n$End", "1 2 2 9\n$End"), &["element 7", "repeated node"]);
    refused(&edited("9 0 0 1", "9 1 1 0"), &["element 7", "without volume"]);
    let twice = tet22(2, "7 4 2 1 1 1 2 3 9\n8 4 2 1 1 1 2 3 9\n");
    refused(twice.as_bytes(), &["element 7", "2 cells given more than once: 7, 8"]);
    let message = parse(&edited("4", "4"), "part.msh", f64::NAN).unwrap_err().to_string();
    assert!(message.contains("scale NaN"));
}

#[test]
fn unsupported_elements_are_refused_with_their_count() {
    let nodes = ["1 2 3 9"; 5].join(" ");
    let cubic = tet22(1, &format!("7 29 2 1 1 {nodes}\n"));
    refused(cubic.as_bytes(), &["1 x 20-node tetrahedron", "Mesh.ElementOrder = 1 or 2"]);
    let complete = tet22(1, &format!("7 12 2 1 1 {nodes} 1 2 3 9 1 2 3\n"));
    refused(complete.as_bytes(), &["element 7", "its node 2 lies", "Mesh.SecondOrderIncomplete = 1"]);
    refused(tet22(1, "7 11 2 1 1 1 2 3 9 1 2 3 9 1 2\n").as_bytes(), &["element 7", "repeated node"]);
    let pyramid = tet22(2, "7 7 2 1 1 1 2 3 9 1\n8 7 2 1 1 1 2 3 9 1\n");
    refused(pyramid.as_bytes(), &["2 x 5-node pyramid", "tetrahedra, prisms and hexahedra", "cut pyramids"]);
    refused(tet22(1, "7 2 2 1 1 1 2 3\n").as_bytes(), &["no volume cells", "gmsh -3"]);
}

#[test]
fn other_files_are_recognised() {
    refused(b"", &["empty"]);
    refused(b"solid part\nfacet", &["STL", "mesh the volume"]);
    refused(b"<?xml version=\"1.0\"?><VTKFile>", &["VTU"]);
    refused(b"*HEADING\n*NODE\n", &["Abaqus", ".inp"]);
    refused(b"$NOD\n1\n", &["version 1"]);
    refused(b"\x1f\x8b\x08", &["gzip"]);
    refused(b"\0\0\0\0 something", &["not a Gmsh mesh"]);
    refused(&edited("2.2 0 8", "4 0 8"), &["line 2", "MSH version 4 ", "msh41"]);
    refused(&edited("2.2 0 8", "2.2 1 8"), &["byte order"]);
    refused(&edited("$Nodes", "$ParametricNodes"), &["line 4", "parametric", "SaveParametric"]);
    refused(&edited("$Nodes", "$PartitionedEntities"), &["line 4", "partitioned"]);
    let binary_stl = parse(&[b'x'; 100], "part.STL", 1.0).unwrap_err().to_string();
    assert!(binary_stl.contains("STL"));
    let missing = read(&path("no-such.msh"), 1.0).unwrap_err().to_string();
    assert!(missing.contains("no-such.msh") && missing.contains("cannot be read"));
}
