//! Files that promise much in few bytes must not take memory out of proportion.

use std::fmt::Write;
use std::path::Path;

use stiction::contact::{Side, Triangles};
use stiction::io::{abaqus, arrays, case, gmsh, npz, surface, vtu, vtu_read};
use stiction::mesh::{Block, BlockElement, block};
use stiction::run::read_mesh;

use stiction_fixtures::{counting, written};

use crate::ALONE;

/// Memory besides ten times the file: what the readers grant small files.
const BESIDES: usize = 128 << 20;
/// The same in the promise to users.
const GRANTED: usize = 64 << 20;

const TET: &str = "*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n*ELEMENT,TYPE=C3D4,ELSET=E\n1,1,2,3,4\n";

/// Lines made by `line`, `bytes` long altogether.
fn lines(begin: &str, bytes: usize, line: impl Fn(usize, &mut String)) -> String {
    let mut text = begin.to_string();
    let mut i = 0;
    while text.len() < bytes {
        line(i, &mut text);
        i += 1;
    }
    text
}

#[test]
fn memory_stays_in_proportion_to_the_file() {
    let _alone = ALONE.lock();
    let many = 3 << 20;
    let nodes = lines("*NODE\n", many / 2, |i, t| writeln!(t, "{},0", i + 1).unwrap());
    let whole = format!("{nodes}{}", &TET[6..]).replace("*NODE\n1,0,0,0\n2,1,0,0\n3,0,1,0\n4,0,0,1\n", "");
    let part = TET.replace("*NODE", "*PART,NAME=P\n*NODE") + "*END PART\n*ASSEMBLY\n";
    let big_part = nodes.replace("*NODE", "*PART,NAME=P\n*NODE") + "*END PART\n*ASSEMBLY\n";
    let inputs = [
        ("bare nodes", nodes.clone()),
        ("blank lines", lines(TET, many, |_, t| t.push('\n'))),
        ("empty sets", lines(TET, many, |i, t| writeln!(t, "*NSET,NSET={i}").unwrap())),
        ("empty blocks", lines(TET, many, |_, t| t.push_str("*ELEMENT,TYPE=C3D4\n"))),
        ("names in a set", lines(&format!("{TET}*ELSET,ELSET=A\n"), many, |_, t| t.push_str("E,\n"))),
        ("surfaces of everything", lines(TET, many, |i, t| writeln!(t, "*SURFACE,NAME={i}\nE").unwrap())),
        (
            "sets of everything",
            lines(&whole, 2 * many, |i, t| write!(t, "*NSET,NSET={i},GENERATE\n1,99999999\n").unwrap()),
        ),
        (
            "overlapping ranges",
            lines(&format!("{whole}*NSET,NSET=A,GENERATE\n"), many, |i, t| {
                writeln!(t, "{},4000000000,2", i % 1000).unwrap()
            }),
        ),
        (
            "sets in sets",
            lines(TET, many, |i, t| write!(t, "*ELSET,ELSET={i}a\n{}a,{}a\n", i.saturating_sub(1), i + 1).unwrap()),
        ),
        ("many instances", lines(&part, many, |i, t| writeln!(t, "*INSTANCE,NAME={i},PART=P").unwrap())),
        ("large instances", lines(&big_part, many, |i, t| writeln!(t, "*INSTANCE,NAME={i},PART=P").unwrap())),
        ("unknown keywords", lines(TET, many, |i, t| writeln!(t, "*K{i}").unwrap())),
        ("a long keyword", lines("*NODE", many, |_, t| t.push_str(",A,\n"))),
    ];
    let grid = |points: &str, data: &str| {
        format!(
            "<VTKFile type=\"UnstructuredGrid\" byte_order=\"LittleEndian\" compressor=\"vtkZLibDataCompressor\"><UnstructuredGrid>\
             <Piece NumberOfPoints=\"{points}\" NumberOfCells=\"1\"><Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" \
             format=\"binary\">{data}</DataArray></Points></Piece></UnstructuredGrid></VTKFile>"
        )
    };
    let grids = [
        // one block that promises 96 GB, and four thousand million blocks
        grid("4000000000", "AQAAAP////8AAAAAEAAAAA==AAAAAAAAAAAAAAAAAAAA"),
        grid("4000000000", "/////wAAAEAAAAAAEAAAAA==AAAAAAAAAAAAAAAAAAAA"),
        lines("<VTKFile type=\"UnstructuredGrid\">", many, |_, t| t.push_str("<a b=''/>")),
        lines("<VTKFile ", many, |_, t| t.push_str("b='' ")),
    ];
    let tet = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Elements\n1\n1 4 0 1 2 3 4\n$EndElements\n$Nodes\n200000\n";
    let corners = "1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n";
    let many_nodes = (5..=200_000).fold(format!("{tet}{corners}"), |mut t, i| {
        writeln!(t, "{i} 0 0 0").unwrap();
        t
    });
    let data = lines(&(many_nodes + "$EndNodes\n"), 2 * many, |i, t| {
        writeln!(t, "$NodeData\n1\n\"{i}\"\n0\n3\n0\n1\n1\n1 0\n$EndNodeData").unwrap()
    });
    let meshes = [
        data.as_str(),
        "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 4000000000 1 4000000000\n3 1 0 4000000000\n1\n",
    ];

    let corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 1\n";
    let strip = |i: usize, t: &mut String| {
        let [a, b] = [2 * i + 1, 2 * i + 2];
        writeln!(t, "v {i} 0 0\nv {i} 1 0").unwrap();
        if i > 0 {
            writeln!(t, "f {} {} {b} {a}", a - 2, b - 2).unwrap();
        }
    };
    let surfaces = [
        ("faces", lines(corners, many, |_, t| t.push_str("f 1 2 3\n"))),
        ("polygons", lines(corners, many, |_, t| t.push_str("f 1 2 4 3\n"))),
        ("a strip", lines("", many, strip)),
        ("vertices", lines("f 1 2 3\n", many, |i, t| writeln!(t, "v {i} 0 0").unwrap())),
        ("collapsed", lines(corners, many, |_, t| t.push_str("f 1 1 1\n"))),
        ("words", lines(corners, many, |_, t| t.push_str("g a\n"))),
    ];

    let check = |name: &str, text: &str, parse: &dyn Fn(&[u8]) -> bool| {
        let used = counting::measured(|| parse(text.as_bytes())).1.peak;
        assert!(used <= 10 * text.len() + BESIDES, "{name}: {} bytes took {used}", text.len());
    };
    for (name, text) in &inputs {
        check(name, text, &|bytes| abaqus::parse(bytes, "a.inp", 1.0, &|_| Err(String::new())).is_ok());
    }
    for (name, text) in &surfaces {
        check(name, text, &|bytes| {
            let raw = surface::parse_obj(bytes, "a.obj", 1.0);
            raw.and_then(|raw| Triangles::new(raw, "a.obj", Side::Outside, 30.0)).is_ok()
        });
    }
    for text in &grids {
        check("grid", text, &|bytes| vtu_read::parse(bytes, "a.vtu", 1.0).is_ok());
    }
    from_disk();
    for text in meshes {
        check("mesh", text, &|bytes| gmsh::parse(bytes, "a.msh", 1.0).is_ok());
    }
}

/// The tree of a case file takes much more than its text: a limit on the file keeps it within what is granted.
#[test]
fn the_largest_case_file_takes_no_more_memory_than_any_file_may() {
    let _alone = ALONE.lock();
    let most = 100 << 10;
    let texts = [
        ("empty lists", lines("a = [", most, |_, t| t.push_str("[],")) + "]"),
        ("numbers", lines("a = [", most, |_, t| t.push_str("0,")) + "]"),
        ("inline tables", lines("a = [", most, |_, t| t.push_str("{a=0},")) + "]"),
        ("keys", lines("", most, |i, t| writeln!(t, "{i:x}=0").unwrap())),
        ("dotted keys", lines("", most, |i, t| writeln!(t, "{i:x}.a.a.a=0").unwrap())),
        ("deep keys", lines("", most, |i, t| writeln!(t, "{i:x}{}=0", ".a".repeat(60)).unwrap())),
        ("tables", lines("", most, |i, t| writeln!(t, "[{i:x}]").unwrap())),
        ("lists of tables", lines("", most, |_, t| t.push_str("[[a]]\n"))),
        ("the same key", lines("", most, |_, t| t.push_str("a={b=[0,0]}\n"))),
        ("no TOML", lines("", most, |_, t| t.push_str("]\n"))),
    ];
    for (name, text) in &texts {
        let (read, used) = counting::measured(|| case::parse(text, "case.toml", &[]).map(|_| ()));
        let factor = used.peak as f64 / text.len() as f64;
        assert!(read.is_err() && used.peak <= 10 * text.len() + GRANTED, "{name}: {factor} times the file");
    }
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("large.toml");
    std::fs::write(&path, "#".repeat(most + 1)).unwrap();
    assert!(case::read(&path, &[]).unwrap_err().to_string().contains("more than 100 kB"));
    std::fs::write(&path, "#".repeat(most)).unwrap();
    assert!(!case::read(&path, &[]).unwrap_err().to_string().contains("more than"));
}

/// For every entry that the end of an archive announces `zip` reserves 200 bytes before it looks for one.
#[test]
fn an_archive_takes_no_memory_for_entries_that_it_only_announces() {
    let _alone = ALONE.lock();
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("announced.npz");
    npz::write(&path, &[("q", npz::Array::f64(&[1.0; 20_000]))]).unwrap();
    let whole = std::fs::read(&path).unwrap();
    let read = |bytes: &[u8]| counting::measured(|| arrays::parse_npz(bytes).map(|_| ()).unwrap_err().to_string());
    let (missing, used) = read(&whole);
    assert!(missing.contains("no matrix") && used.peak < 3 * whole.len(), "{missing}: {} bytes", used.peak);
    let mut lies = whole.clone();
    let end = lies.len() - 22;
    assert_eq!(lies[end..][8..12], [1, 0, 1, 0]);
    lies[end + 8..end + 12].fill(0xff);
    let (error, used) = read(&lies);
    assert!(error.contains("does not end after 1 array") && used.peak < 3 * whole.len(), "{error}: {}", used.peak);
}

/// Part of the first test, since the counter is the process's: meshes as other programs write them, the file included.
fn from_disk() {
    for element in [BlockElement::Hex8, BlockElement::Tet4Six] {
        // sizes that do not end after a few digits
        let size = [std::f64::consts::PI, std::f64::consts::E, std::f64::consts::SQRT_2];
        let mesh = block(&Block { size, cells: [30; 3], origin: [-0.3; 3], grading: [1.0; 3], element }).unwrap();
        let at = |ending: &str| Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("memory-{element:?}.{ending}"));
        std::fs::write(at("msh"), written::msh(&mesh)).unwrap();
        std::fs::write(at("inp"), written::inp(&mesh)).unwrap();
        vtu::write(&at("vtu"), &vtu::Grid::from_mesh(&mesh), &[], &[]).unwrap();
        for ending in ["msh", "inp", "vtu"] {
            let (read, used) = counting::measured(|| read_mesh(&at(ending), 1.0, &[]));
            let (nodes, most) = (read.unwrap().0.nodes.len(), used.peak as f64 / used.kept as f64);
            assert!(nodes == mesh.nodes.len() && most <= 3.0, "{element:?} {ending}: {most} times the mesh");
        }
    }
}
