//! Meshes written by other programs: one brick in many files gives one mesh and one solution.
//!
//! `tests/data/make_inputs.py` made the files with Gmsh, meshio and VTK. The reference is Gmsh's own `.msh`.

use std::path::PathBuf;

use stiction::contact::SurfaceFriction;
use stiction::io::gmsh;
use stiction::mesh::{CellKind, Mesh};
use stiction::run::read_mesh;
use stiction_fixtures::folder::Folder;
use stiction_fixtures::*;

/// Files of the brick of hexahedra; groups are named alike, or `part-` and the number Gmsh gave them.
const BRICK: [&str; 11] = [
    "brick-gmsh.inp",
    "brick-meshio.inp",
    "brick-meshio-ascii.vtu",
    "brick-meshio-binary.vtu",
    "brick-meshio-zlib.vtu",
    "brick-vtk-raw.vtu",
    "brick-vtk-raw-zlib.vtu",
    "brick-vtk-base64.vtu",
    "brick-vtk-base64-zlib.vtu",
    "brick-vtk-inline-zlib.vtu",
    "brick-pyvista.vtu",
];
const TETS: [&str; 3] = ["tets-gmsh.inp", "tets-meshio.inp", "tets-meshio-zlib.vtu"];

fn path(name: &str) -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/data")).join(name)
}

fn mesh(name: &str) -> Mesh {
    read_mesh(&path(name), 1.0, &[]).unwrap_or_else(|e| panic!("{e}")).0
}

/// The name a group of `brick.msh` has in another file.
fn renamed(file: &str, group: &str) -> String {
    let number = ["body", "left", "right", "bottom", "top"].iter().position(|g| *g == group).unwrap();
    if file.ends_with("vtu") { format!("part-{}", number + 1) } else { group.to_string() }
}

/// Corners of things by their places, independent of any numbering.
fn places<'a>(mesh: &Mesh, things: impl Iterator<Item = &'a [u32]>) -> Vec<Vec<[i64; 3]>> {
    let place = |&n: &u32| mesh.nodes[n as usize].map(|x| (x * 1e9).round() as i64);
    let mut places: Vec<Vec<[i64; 3]>> = things.map(|nodes| nodes.iter().map(place).collect()).collect();
    places.iter_mut().for_each(|corners| corners.sort_unstable());
    places.sort_unstable();
    places
}

#[test]
fn every_program_and_encoding_gives_the_mesh_that_gmsh_wrote() {
    for (reference, files) in [("brick.msh", &BRICK[..]), ("tets.msh", &TETS)] {
        let expected = mesh(reference);
        assert!((expected.volume() - 2.0).abs() < 1e-12);
        let cells = |mesh: &Mesh| places(mesh, mesh.cell_iter().map(|(_, cell)| cell));
        let faces = |mesh: &Mesh, group: &str| {
            let group = mesh.group(group).unwrap_or_else(|| panic!("{group}"));
            places(mesh, group.faces.iter().map(|&f| mesh.faces[f as usize].nodes()))
        };
        for file in files {
            let found = mesh(file);
            assert_eq!(cells(&found), cells(&expected), "{file}");
            for side in ["left", "right", "bottom", "top"] {
                assert_eq!(faces(&found, &renamed(file, side)), faces(&expected, side), "{file} {side}");
            }
            let body = found.group(&renamed(file, "body")).unwrap();
            assert_eq!(body.cells.len(), found.cell_count(), "{file}");
            if file.contains("vtk") {
                // a mask of points names the nodes at the bottom, and with them its faces
                assert_eq!(faces(&found, "bottom"), faces(&expected, "bottom"), "{file}");
            }
        }
    }
}

/// Files of a quarter of a cylinder, curved; groups are named alike, or `part-` and the number Gmsh gave them, and the
/// input of meshio has none.
const CURVED: [&str; 4] = ["-22.msh", "-gmsh.inp", "-meshio.inp", "-meshio.vtu"];

#[test]
fn curved_cells_have_the_volume_and_the_area_gmsh_finds_whatever_the_order_of_their_nodes_in_the_file() {
    let reference = std::fs::read_to_string(path("curved.txt")).unwrap();
    let expected = |model: &str, what: &str| -> f64 {
        let line = reference.lines().find(|line| line.starts_with(&format!("{model}\t{what}\t"))).unwrap();
        line.rsplit('\t').next().unwrap().parse().unwrap()
    };
    for (model, kind, files) in [
        ("curved-tet10", CellKind::Tet10, &CURVED[..]),
        ("curved-hex20", CellKind::Hex20, &CURVED[..]),
        ("curved-wedge15", CellKind::Wedge15, &CURVED[..2]),
    ] {
        let whole = mesh(&format!("{model}-41.msh"));
        let [volume, area] = ["body", "curved"].map(|what| expected(model, what));
        assert!(whole.cell_iter().all(|cell| cell.0 == kind));
        for file in std::iter::once("-41.msh").chain(files.iter().copied()) {
            let found = mesh(&format!("{model}{file}"));
            // Gmsh's own rule gives the two meshes of the same geometry volumes that differ by 2e-13
            assert!((found.volume() - volume).abs() < 1e-12, "{model}{file} {} {volume}", found.volume());
            let cells = |mesh: &Mesh| places(mesh, mesh.cell_iter().map(|(_, cell)| cell));
            assert_eq!(cells(&found), cells(&whole), "{model}{file}");
            // wrong places of mid-side nodes would bend edges and spoil this
            let worst = stiction::mesh::info(&found).cells[0].min_quality;
            assert!(worst > 0.2, "{model}{file} {worst}");
            let named = |name: &str, number: usize| {
                let group = found.group(name).or(found.group(&format!("part-{number}")));
                group.map(|g| g.faces.iter().map(|&f| found.face_area(f as usize)).sum::<f64>())
            };
            let (Some(side), Some(bottom)) = (named("curved", 2), named("bottom", 3)) else {
                assert_eq!(file, "-meshio.inp");
                continue;
            };
            if let Some(group) = found.group("curved") {
                // A parabola through three points of an arc of 45 degrees leans 0.8 degrees less at its ends; chords 22.5.
                for (node, normal) in stiction::fem::nodal_normals(&found, &group.faces) {
                    let x = found.nodes[node as usize];
                    let across = normal[0] * x[1] - normal[1] * x[0];
                    assert!(across.abs() < 0.0145 && normal[2].abs() < 1e-7, "{model}{file} {x:?} {normal:?}");
                }
            }
            assert!(
                (side - area).abs() < 1e-5 && (bottom - volume).abs() < 1e-6,
                "{model}{file}: {side} {area} {bottom}"
            );
        }
    }
}

/// From disk the bytes are given back while they are read; messages count lines from the beginning all the same.
#[test]
fn errors_name_the_same_line_from_disk_and_from_memory() {
    for (file, from) in
        [("brick.msh", "$EndElements"), ("brick-gmsh.inp", "*ELSET"), ("fields-22-ascii.msh", "$EndElementData")]
    {
        let text = std::fs::read_to_string(path(file)).unwrap();
        let damaged = text.replacen(from, &format!("7 x 7 8\n{from}"), 1);
        let line = 1 + text[..text.find(from).unwrap()].lines().count();
        let there = std::path::Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("damaged-{file}"));
        std::fs::write(&there, &damaged).unwrap();
        let name = there.display().to_string();
        let memory = match file.ends_with("inp") {
            true => stiction::io::abaqus::parse(damaged.as_bytes(), &name, 1.0, &|_| Err(String::new())),
            false => gmsh::parse(damaged.as_bytes(), &name, 1.0),
        };
        let messages = [read_mesh(&there, 1.0, &[]), memory].map(|read| read.map(|_| ()).unwrap_err().to_string());
        assert!(messages[0] == messages[1] && messages[0].contains(&format!("line {line}")), "{line} {messages:?}");
    }
}

/// Gmsh meshes one model with 15 and with 18 nodes: the cells are the same.
#[test]
fn prisms_of_18_nodes_become_those_of_15() {
    let whole = mesh("curved-wedge15-41.msh");
    let cells = |mesh: &Mesh| places(mesh, mesh.cell_iter().map(|(_, cell)| cell));
    for file in ["curved-wedge18-22.msh", "curved-wedge18-41.msh"] {
        let (found, notes) = read_mesh(&path(file), 1.0, &[]).unwrap();
        assert_eq!(cells(&found), cells(&whole), "{file}");
        assert!(notes.to_string().contains("prisms of 18 nodes, which become those of 15"), "{notes}");
    }
    // A node in the middle of a face that was moved.
    let text = std::fs::read_to_string(path("curved-wedge18-22.msh")).unwrap();
    let prism = text.lines().find(|line| line.split(' ').nth(1) == Some("13")).unwrap();
    let last = prism.split_whitespace().last().unwrap();
    let line = text.lines().find(|line| line.starts_with(&format!("{last} "))).unwrap();
    let moved = text.replace(&format!("\n{line}\n"), &format!("\n{last} 9 9 9\n"));
    let message = gmsh::parse(moved.as_bytes(), "a.msh", 1.0).map(|_| ()).unwrap_err().to_string();
    assert!(message.contains(&format!("its node {last} lies")) && message.contains("prism of 15"), "{message}");
}

/// Gmsh meshes one model with 20 and with 27 nodes: the cells are the same.
#[test]
fn hexahedra_of_27_nodes_become_those_of_20() {
    let whole = mesh("curved-hex20-41.msh");
    let cells = |mesh: &Mesh| places(mesh, mesh.cell_iter().map(|(_, cell)| cell));
    let faces = |mesh: &Mesh, group: &str| {
        let group = mesh.group(group).unwrap();
        places(mesh, group.faces.iter().map(|&f| mesh.faces[f as usize].nodes()))
    };
    for file in ["curved-hex27-22.msh", "curved-hex27-41.msh"] {
        let (found, notes) = read_mesh(&path(file), 1.0, &[]).unwrap();
        assert_eq!((cells(&found), faces(&found, "curved")), (cells(&whole), faces(&whole, "curved")), "{file}");
        assert!(notes.to_string().contains("within the 6 hexahedra of 27 nodes, which become those of 20"), "{notes}");
    }
    let text = std::fs::read_to_string(path("curved-hex27-22.msh")).unwrap();
    let hexahedron = text.lines().find(|line| line.split(' ').nth(1) == Some("12")).unwrap();
    let words: Vec<&str> = hexahedron.split_whitespace().collect();
    let (element, [.., centre]) = (words[0], &words[..]) else { panic!() };
    let refused = |text: &str| {
        let message = gmsh::parse(text.as_bytes(), "a.msh", 1.0).map(|_| ()).unwrap_err().to_string();
        assert!(message.contains("Mesh.SecondOrderIncomplete = 1"), "{message}");
        message
    };
    // A node that was moved, and a cell that hangs on one.
    let line = text.lines().find(|line| line.starts_with(&format!("{centre} "))).unwrap();
    let message = refused(&text.replace(&format!("\n{line}\n"), &format!("\n{centre} 0.1 0.1 0.1\n")));
    assert!(message.contains(&format!("element {element}: its node {centre} lies")), "{message}");
    let count: usize = text.lines().skip_while(|line| *line != "$Elements").nth(1).unwrap().parse().unwrap();
    let tet = format!("999 4 2 1 1 {centre} {} {} {}\n$EndElements", words[5], words[6], words[7]);
    let more = text.replace(&format!("$Elements\n{count}\n"), &format!("$Elements\n{}\n", count + 1));
    let message = refused(&more.replace("$EndElements", &tet));
    assert!(message.contains(&format!("element 999: its node {centre} is the middle")), "{message}");
}

#[test]
fn the_solution_does_not_depend_on_the_format() {
    for (reference, files) in [("brick.msh", &BRICK[..]), ("tets.msh", &TETS)] {
        let solution = |file: &str| {
            let name = |group| if file == reference { String::from(group) } else { renamed(file, group) };
            let case = Case {
                mesh: mesh(file),
                young: 21.19e10,
                poisson: 0.277,
                loads: Vec::new(),
                fixes: Vec::new(),
                surfaces: Vec::new(),
            };
            let case = case.fix(&name("left"), HELD).contact(&name("bottom"), FLOOR, SurfaceFriction::Coulomb(0.3));
            let case = case.traction(&name("top"), [0.0, 0.0, -1e6]).traction(&name("right"), [1e6, 5e5, 0.0]);
            let posed = case.pose();
            let solved = solved(&posed.problem, 1e-10);
            // by place, since numbers of nodes differ
            let mut at: Vec<([i64; 3], [f64; 3])> = case
                .mesh
                .nodes
                .iter()
                .map(|x| x.map(|c| (c * 1e9).round() as i64))
                .zip(posed.full(&solved.u))
                .collect();
            at.sort_by_key(|entry| entry.0);
            at.into_iter().flat_map(|entry| entry.1).collect::<Vec<f64>>()
        };
        let expected = solution(reference);
        for file in files {
            // the contact problem is solved to 1e-10
            assert!(distance(&solution(file), &expected) < 1e-8, "{file}");
        }
    }
}

#[test]
fn the_scale_multiplies_lengths_in_every_format() {
    for file in ["brick.msh", "brick-gmsh.inp", "brick-vtk-raw.vtu"] {
        let (mesh, _) = read_mesh(&path(file), 1e-3, &[]).unwrap();
        assert!((mesh.volume() - 2e-9).abs() < 1e-20, "{file}");
        let message = read_mesh(&path(file), -1.0, &[]).unwrap_err().to_string();
        assert!(message.contains("scale -1") && message.contains(file), "{message}");
    }
}

#[test]
fn what_programs_write_and_we_cannot_use_is_named() {
    for (file, words) in [
        ("pyramid-meshio.vtu", ["1 x pyramid", "tetrahedra, wedges and hexahedra", "pyramid-meshio.vtu"]),
        ("brick-vtk-lz4.vtu", ["vtkLZ4DataCompressor", "zlib", "line 1"]),
        ("make_inputs.py", [".py", ".inp", ".vtu"]),
        ("missing.inp", ["missing.inp", "cannot be read", "path"]),
    ] {
        let message = read_mesh(&path(file), 1.0, &[]).unwrap_err().to_string();
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
    }
}

/// A deck from elsewhere reads no file of the machine but those beside it, and no message shows what another holds.
#[cfg(unix)]
#[test]
fn an_input_includes_regular_files_below_its_folder_only() {
    let top = Folder::new("includes");
    std::fs::create_dir_all(top.at("deck/below")).unwrap();
    std::fs::create_dir_all(top.at("other")).unwrap();
    let nodes = "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n";
    let secret = "root:x:0:0:secret\n";
    top.write("deck/beside.inp", nodes);
    top.write("deck/below/nodes.inp", nodes);
    top.write("other/nodes.inp", nodes);
    top.write("other/secret", secret);
    top.write("deck/secret", secret);
    std::os::unix::fs::symlink(top.at("other/nodes.inp"), top.at("deck/link.inp")).unwrap();
    assert!(std::process::Command::new("mkfifo").arg(top.at("deck/pipe")).status().unwrap().success());
    let read = |name: &str, include: &[std::path::PathBuf]| {
        let text = format!("*INCLUDE, INPUT={name}\n*ELEMENT, TYPE=C3D4, ELSET=body\n1,1,2,3,4\n");
        read_mesh(&top.write("deck/deck.inp", text), 1.0, include).map(|_| ()).map_err(|e| e.to_string())
    };
    for name in ["beside.inp", "below/nodes.inp", "below/../beside.inp"] {
        assert_eq!(read(name, &[]), Ok(()), "{name}");
    }
    let outside = top.at("other/nodes.inp").display().to_string();
    for name in ["../other/nodes.inp", outside.as_str(), "link.inp", "/dev/zero", "/etc/passwd"] {
        let message = read(name, &[]).unwrap_err();
        assert!(message.contains("outside the folder") && message.contains("--include DIR"), "{message}");
    }
    for name in ["../other/nodes.inp", outside.as_str(), "link.inp"] {
        assert_eq!(read(name, &[top.at("other")]), Ok(()), "{name}");
    }
    for (name, folder) in [("pipe", None), ("/dev/zero", Some("/dev"))] {
        let message = read(name, &folder.map(std::path::PathBuf::from).into_iter().collect::<Vec<_>>()).unwrap_err();
        assert!(message.contains("no regular file"), "{message}");
    }
    for (name, folder) in [("secret", top.at("deck")), ("../other/secret", top.at("other"))] {
        let message = read(name, &[folder]).unwrap_err();
        assert!(message.contains("neither keywords nor numbers") && !message.contains("root"), "{message}");
    }
    let message = read_mesh(&top.at("deck/pipe"), 1.0, &[]).unwrap_err().to_string();
    assert!(message.contains("pipe"), "{message}");
    assert!(std::process::Command::new("mkfifo").arg(top.at("deck/pipe.inp")).status().unwrap().success());
    let message = read_mesh(&top.at("deck/pipe.inp"), 1.0, &[]).unwrap_err().to_string();
    assert!(message.contains("no regular file"), "{message}");
}
