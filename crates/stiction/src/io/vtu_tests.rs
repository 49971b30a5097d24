use std::collections::BTreeMap;
use std::io::Read;

use flate2::read::ZlibDecoder;

use super::*;
use crate::mesh::Cells;

/// Every array of a file by name, decoded as the format's description says.
fn decode(file: &[u8]) -> BTreeMap<String, Vec<u8>> {
    let marker = b"<AppendedData encoding=\"raw\">\n_";
    let start = file.windows(marker.len()).position(|w| w == marker).unwrap();
    let (xml, data) = (std::str::from_utf8(&file[..start]).unwrap(), &file[start + marker.len()..]);
    let attribute = |line: &str, key: &str| {
        let from = line.find(&format!(" {key}=\"")).unwrap() + key.len() + 3;
        line[from..from + line[from..].find('"').unwrap()].to_string()
    };
    let mut arrays = BTreeMap::new();
    for line in xml.lines().filter(|l| l.starts_with("<DataArray")) {
        let mut at: usize = attribute(line, "offset").parse().unwrap();
        let mut word = || {
            at += 8;
            u64::from_le_bytes(data[at - 8..at].try_into().unwrap()) as usize
        };
        let (blocks, block, partial) = (word(), word(), word());
        let sizes: Vec<usize> = (0..blocks).map(|_| word()).collect();
        let mut bytes = Vec::new();
        for (i, size) in sizes.into_iter().enumerate() {
            ZlibDecoder::new(&data[at..at + size]).read_to_end(&mut bytes).unwrap();
            let full = i + 1 < blocks || partial == 0;
            assert_eq!(bytes.len(), i * block + if full { block } else { partial });
            at += size;
        }
        arrays.insert(attribute(line, "Name"), bytes);
    }
    arrays
}

fn doubles(bytes: &[u8]) -> Vec<f64> {
    bytes.as_chunks::<8>().0.iter().map(|b| f64::from_le_bytes(*b)).collect()
}

fn singles(bytes: &[u8]) -> Vec<f32> {
    bytes.as_chunks::<4>().0.iter().map(|b| f32::from_le_bytes(*b)).collect()
}

fn longs(bytes: &[u8]) -> Vec<i64> {
    bytes.as_chunks::<8>().0.iter().map(|b| i64::from_le_bytes(*b)).collect()
}

fn scratch(name: &str) -> std::path::PathBuf {
    std::env::temp_dir().join(format!("stiction-{}-{name}", std::process::id()))
}

/// A unit cube with a tetrahedron on its top.
fn cube_and_tip() -> Mesh {
    let corner = |i: u32| [f64::from((i ^ (i >> 1)) & 1), f64::from((i >> 1) & 1), f64::from(i >> 2)];
    let mut nodes: Vec<[f64; 3]> = (0..8).map(corner).collect();
    nodes.push([0.1, 0.2, 1.7]);
    let cells = vec![
        Cells { kind: CellKind::Hex8, nodes: (0..8).collect() },
        Cells { kind: CellKind::Tet4, nodes: vec![4, 5, 6, 8] },
    ];
    Mesh { nodes, cells, faces: Vec::new(), groups: Vec::new(), arrays: Default::default() }
}

#[test]
fn what_is_written_is_read_back_bit_by_bit() {
    let mesh = cube_and_tip();
    let displacement: Vec<[f64; 3]> = (0..9).map(|i| [f64::from(i) / 3.0, -0.0, f64::NAN]).collect();
    let stress = [[1.0, 2.0, 3.0, 4.0, 5.0, 6.0], [0.1, 0.2, 0.3, 0.4, 0.5, 0.6]];
    let path = scratch("mixed.vtu");
    let point_arrays = [Array::vector("displacement", &displacement)];
    let cell_arrays = [Array::tensor("stress", &stress), Array::integer("a < b & \"c\"", &[-1, 7])];
    write(&path, &Grid::from_mesh(&mesh), &point_arrays, &cell_arrays).unwrap();
    let arrays = decode(&std::fs::read(&path).unwrap());
    std::fs::remove_file(path).unwrap();
    assert_eq!(doubles(&arrays["Points"]), mesh.nodes.as_flattened());
    let same = doubles(&arrays["displacement"])
        .iter()
        .zip(displacement.as_flattened())
        .all(|(a, b)| a.to_bits() == b.to_bits());
    assert!(same);
    assert_eq!(singles(&arrays["stress"]), stress.as_flattened());
    assert_eq!(longs(&arrays["connectivity"]), [0, 1, 2, 3, 4, 5, 6, 7, 4, 5, 6, 8]);
    assert_eq!(longs(&arrays["offsets"]), [8, 12]);
    assert_eq!(arrays["types"], [HEXAHEDRON, TETRA]);
    let integers = &arrays["a &lt; b &amp; &quot;c&quot;"];
    assert_eq!(integers[..], [(-1i32).to_le_bytes(), 7i32.to_le_bytes()].concat());
}

#[test]
fn arrays_of_several_blocks_do_not_depend_on_the_number_of_threads() {
    // One block exactly, one number less and one more: the header marks only partial last blocks.
    for count in [BLOCK / 8 - 1, BLOCK / 8, BLOCK / 8 + 1, BLOCK / 2] {
        let points = vec![[0.0; 3]; count];
        let values: Vec<f64> = (0..count).map(|i| (i as f64).sin()).collect();
        let bytes = |threads: usize| {
            let path = scratch(&format!("blocks-{threads}.vtu"));
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| write(&path, &Grid::new(&points), &[Array::scalar("v", &values)], &[])).unwrap();
            let bytes = std::fs::read(&path).unwrap();
            std::fs::remove_file(path).unwrap();
            bytes
        };
        let one = bytes(1);
        assert!(one == bytes(3));
        assert_eq!(doubles(&decode(&one)["v"]), values);
    }
}

#[test]
fn an_empty_surface_is_a_valid_file() {
    let path = scratch("empty.vtu");
    write(&path, &Grid::new(&[]), &[Array::scalar("pressure", &[])], &[]).unwrap();
    assert!(decode(&std::fs::read(&path).unwrap())["pressure"].is_empty());
    std::fs::remove_file(path).unwrap();
}

#[test]
fn arrays_that_do_not_fit_are_refused_before_anything_is_written() {
    let points = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let mut grid = Grid::new(&points);
    grid.push(TRIANGLE, &[0, 1, 2]);
    let path = scratch("refused.vtu");
    let error = |grid: &Grid, point: &[Array], cell: &[Array]| write(&path, grid, point, cell).unwrap_err().to_string();
    assert!(error(&grid, &[Array::scalar("pressure", &[1.0])], &[]).contains("\"pressure\" has 1 numbers"));
    assert!(error(&grid, &[], &[Array::vector("normal", &points)]).contains("\"normal\""));
    let mut stray = grid.clone();
    stray.connectivity[2] = 3;
    assert!(error(&stray, &[], &[]).contains("node 3"));
    assert!(!path.exists());
    let nowhere = scratch("no-such-folder").join("a.vtu");
    let error = write(&nowhere, &grid, &[], &[]).unwrap_err().to_string();
    assert!(error.contains("a.vtu") && error.contains("folder"), "{error}");
}
