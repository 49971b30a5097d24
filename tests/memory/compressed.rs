//! Files of which zlib makes a thousand times their bytes.

use std::path::Path;

use stiction::io::vtu::{self, Array, Grid};
use stiction::io::vtu_read;
use stiction_fixtures::counting::measured;

use crate::ALONE;

/// What every reader promises: this many times the file, and so much besides.
const FACTOR: usize = 10;
const BESIDES: usize = 64 << 20;

const CORNERS: [[f64; 3]; 4] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
const TETRAHEDRON: u8 = 10;
const LINE: u8 = 3;

/// A tetrahedron, so many more points in one place, so many times the same cell, and arrays of zeros.
struct Bomb(&'static str, usize, (u8, &'static [u32], usize), usize);

#[test]
fn what_zlib_promises_is_refused_before_it_takes_memory() {
    let _alone = ALONE.lock();
    let million = 1_000_000;
    let bombs = [
        Bomb("points", 3 * million, (TETRAHEDRON, &[], 0), 0),
        Bomb("tetrahedra", 0, (TETRAHEDRON, &[0, 1, 2, 3], 5 * million), 0),
        Bomb("triangles", 0, (vtu::TRIANGLE, &[0, 1, 2], 3 * million), 0),
        Bomb("lines", 0, (LINE, &[0, 1], 3 * million), 0),
        Bomb("long lines", 0, (LINE, &[0; 200], 100_000), 0),
        Bomb("arrays", million / 2, (TETRAHEDRON, &[], 0), 20),
        // Within the promise: what is read then must keep it too.
        Bomb("fewer points", 700_000, (TETRAHEDRON, &[], 0), 0),
        Bomb("fewer tetrahedra", 0, (TETRAHEDRON, &[0, 1, 2, 3], 900_000), 0),
        Bomb("fewer triangles", 0, (vtu::TRIANGLE, &[0, 1, 2], million), 0),
        Bomb("fewer lines", 0, (LINE, &[0, 1], million), 0),
    ];
    for Bomb(name, more, (code, cell, cells), arrays) in bombs {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join("bomb.vtu");
        let mut points = CORNERS.to_vec();
        points.resize(4 + more, [0.0; 3]);
        let mut grid = Grid::new(&points);
        grid.push(TETRAHEDRON, &[0, 1, 2, 3]);
        (0..cells).for_each(|_| grid.push(code, cell));
        let zeros = vec![0; points.len()];
        let names: Vec<String> = (0..arrays).map(|i| format!("group{i}")).collect();
        let fields: Vec<Array> = names.iter().map(|name| Array::integer(name, &zeros)).collect();
        vtu::write(&path, &grid, &fields, &[]).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        std::fs::remove_file(&path).unwrap();
        let (read, memory) = measured(|| vtu_read::parse(&bytes, "a.vtu", 1.0).map(|_| ()));
        let most = FACTOR * bytes.len() + BESIDES;
        assert!(memory.peak <= most, "{name}: {} bytes took {}: {read:?}", bytes.len(), memory.peak);
        // The others may be what they promise, and their files are larger.
        if name == "points" {
            let error = read.unwrap_err().to_string();
            assert!(error.contains("out of proportion") && error.contains("compression"), "{name}: {error}");
        }
    }
}

/// Found by the fuzzer: an array was begun for all nodes that lie between two ends.
#[test]
fn a_line_that_ends_beyond_all_nodes_takes_no_memory_for_them() {
    let _alone = ALONE.lock();
    let array = |kind: &str, name: &str, values: &str| {
        format!("<DataArray type=\"{kind}\" Name=\"{name}\" format=\"ascii\">{values}</DataArray>\n")
    };
    let points = array("Float64", "Points", "0 0 0 1 0 0 0 1 0 0 0 1").replace("Name", "NumberOfComponents=\"3\" Name");
    let file = |end: u32| {
        let cells = [
            array("Int64", "connectivity", "0 1 2 3 0 1 0 1 2 3"),
            array("Int64", "offsets", &format!("4 {end} 10")),
            array("UInt8", "types", "10 3 10"),
        ];
        format!(
            "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid><Piece NumberOfPoints=\"4\" NumberOfCells=\"3\">\n\
             <Points>{points}</Points>\n<Cells>{}</Cells>\n</Piece></UnstructuredGrid></VTKFile>\n",
            cells.concat()
        )
    };
    for (end, wanted) in [(6, "twice"), (u32::MAX, "its nodes end at 4294967295"), (11, "its nodes end at 11")] {
        let text = file(end);
        let (read, memory) = measured(|| vtu_read::parse(text.as_bytes(), "a.vtu", 1.0).map(|_| ()));
        let error = read.unwrap_err().to_string();
        assert!(error.contains(wanted), "{error}");
        assert!(memory.peak < 1 << 16, "{end}: {} bytes: {error}", memory.peak);
    }
}
