//! Ranges of files against the whole, and whatever the bytes.

use std::path::PathBuf;

use super::*;
use crate::io::gmsh::written::{PLAIN, Style, written};
use crate::io::vtu_mesh::write_mesh;
use crate::mesh::{Block, BlockElement, Mesh, block};

fn shipped(name: &str) -> PathBuf {
    PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests")).join(name)
}

const RANGES: [&str; 6] = [
    "meshes/cylinders-41-binary.msh",
    "meshes/bar-41-binary.msh",
    "data/brick-vtk-raw.vtu",
    "data/brick-vtk-raw-zlib.vtu",
    "data/curved-tet10-41.msh",
    "data/curved-wedge15-41.msh",
];

fn open(path: &Path) -> Option<MeshRanges> {
    MeshRanges::open(path, 1.0).unwrap_or_else(|error| panic!("{error}"))
}

/// Everything, read in pieces of so many; sets by their groups.
type All = (Vec<u64>, Vec<[f64; 3]>, Vec<(Vec<u64>, Vec<Vec<u32>>)>, Vec<([u64; 4], Vec<u32>)>, Vec<(u64, Vec<u32>)>);

fn all(file: &MeshRanges, pieces: u64) -> Result<All, Error> {
    let [nodes, elements] = file.sizes();
    let ranges = |count: u64| (0..count.max(1)).step_by(pieces as usize).map(move |k| k..count.min(k + pieces));
    let mut found: All = Default::default();
    for range in ranges(nodes) {
        let (numbers, places) = file.nodes(range)?;
        found.0.extend(numbers);
        found.1.extend(places);
    }
    found.2 = vec![Default::default(); CellKind::ALL.len()];
    for range in ranges(elements) {
        let part = file.elements(range)?;
        let set = |k: &u32| part.sets[*k as usize].clone();
        for (block, more) in found.2.iter_mut().zip(&part.cells) {
            block.0.extend(&more.nodes);
            block.1.extend(more.sets.iter().map(set));
        }
        found.3.extend(part.faces.iter().map(|(corners, k)| (*corners, set(k))));
        found.4.extend(part.nodes.iter().map(|(node, k)| (*node, set(k))));
    }
    Ok(found)
}

#[test]
fn pieces_of_a_file_make_up_the_whole() {
    for name in RANGES {
        let Some(file) = open(&shipped(name)) else { panic!("{name} is not read by ranges") };
        let [nodes, elements] = file.sizes();
        let whole = all(&file, nodes.max(elements)).unwrap();
        for pieces in [1, 7, 100] {
            assert!(all(&file, pieces).unwrap() == whole, "{name} by {pieces}");
        }
        assert!(file.nodes(0..nodes + 1).map_or(true, |read| read.0.len() as u64 <= nodes), "{name}");
    }
}

/// The nodes and cells of a mesh without nodes of no cell, in the order of the file.
#[test]
fn ranges_hold_what_the_reader_of_the_whole_finds() {
    for name in RANGES {
        let path = shipped(name);
        let (mesh, _) = match name.ends_with("msh") {
            true => gmsh::read(&path, 1.0).unwrap(),
            false => vtu_read::read(&path, 1.0).unwrap(),
        };
        let file = open(&path).unwrap();
        let (numbers, places, cells, ..) = all(&file, 1000).unwrap();
        let names: Vec<String> = mesh.groups.iter().map(|group| group.name.clone()).collect();
        assert!(file.groups().iter().all(|name| names.contains(name)), "{names:?} {:?}", file.groups());
        let counts: usize = cells.iter().map(|block| block.1.len()).sum();
        assert_eq!(counts, mesh.cell_count(), "{name}");
        if places.len() != mesh.nodes.len() {
            continue;
        }
        assert_eq!(places, mesh.nodes, "{name}");
        let of_file: Vec<u64> = cells.iter().flat_map(|block| block.0.iter().copied()).collect();
        let of_mesh: Vec<u64> = mesh.cell_iter().flat_map(|(_, nodes)| nodes).map(|&v| numbers[v as usize]).collect();
        assert_eq!(of_file, of_mesh, "{name}");
    }
}

#[test]
fn what_has_to_be_read_as_a_whole_is_told() {
    let whole = [
        "meshes/bar-41-ascii.msh",
        "meshes/bar-22-binary.msh",
        "data/fields-41-binary.msh",
        "data/curved-hex27-41.msh",
        "data/brick-vtk-base64.vtu",
        "data/brick-vtk-inline-zlib.vtu",
        "data/brick-meshio-ascii.vtu",
        "data/tets-gmsh.inp",
    ];
    for name in whole {
        assert!(open(&shipped(name)).is_none(), "{name}");
    }
    assert!(MeshRanges::open(&shipped("data"), 1.0).is_err_and(|error| error.what.contains("regular file")));
    assert!(MeshRanges::open(&shipped(RANGES[0]), 0.0).is_err());
}

/// A VTU file with raw appended data, compressed in blocks of so many bytes if there are any; its cells are in `part-0` to `part-4`.
fn vtu(mesh: &Mesh, block: Option<usize>, big: bool, header: usize) -> Vec<u8> {
    let turned = |mut bytes: Vec<u8>| {
        if big {
            bytes.reverse();
        }
        bytes
    };
    let head = |n: usize| turned((n as u64).to_le_bytes()[..header].to_vec());
    let floats = mesh.nodes.iter().flatten().flat_map(|x| turned(x.to_le_bytes().to_vec())).collect();
    let named =
        mesh.cell_iter().flat_map(|(_, nodes)| nodes).flat_map(|&v| turned(i64::from(v).to_le_bytes().to_vec()));
    let mut end = 0;
    let ends = mesh.cell_iter().flat_map(|(_, nodes)| {
        end += nodes.len() as i32;
        turned(end.to_le_bytes().to_vec())
    });
    let codes = mesh.cell_iter().map(|(kind, _)| if kind == CellKind::Tet4 { 10 } else { 12 }).collect();
    let parts = (0..mesh.cell_count() as i16).flat_map(|k| turned((k / 7 % 5).to_le_bytes().to_vec())).collect();
    let arrays: [(&str, &str, &str, Vec<u8>); 5] = [
        ("CellData", "part", "Int16", parts),
        ("Points", "Points", "Float64", floats),
        ("Cells", "connectivity", "Int64", named.collect()),
        ("Cells", "offsets", "Int32", ends.collect()),
        ("Cells", "types", "UInt8", codes),
    ];
    let (mut tags, mut appended) = (String::new(), Vec::new());
    for (section, name, kind, bytes) in arrays {
        let components = if name == "Points" { 3 } else { 1 };
        tags += &format!(
            "<{section}><DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"appended\" \
             offset=\"{}\"/></{section}>\n",
            appended.len()
        );
        let Some(block) = block else {
            appended.extend(head(bytes.len()));
            appended.extend(bytes);
            continue;
        };
        let packed = |part: &[u8]| {
            let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
            std::io::Write::write_all(&mut encoder, part).unwrap();
            encoder.finish().unwrap()
        };
        let blocks: Vec<Vec<u8>> = bytes.chunks(block).map(packed).collect();
        let heads = [blocks.len(), block, bytes.len() % block].into_iter().chain(blocks.iter().map(Vec::len));
        appended.extend(heads.flat_map(head));
        appended.extend(blocks.concat());
    }
    let order = if big { "BigEndian" } else { "LittleEndian" };
    let compressor = if block.is_some() { " compressor=\"vtkZLibDataCompressor\"" } else { "" };
    let mut file = format!(
        "<VTKFile type=\"UnstructuredGrid\" byte_order=\"{order}\" header_type=\"UInt{}\"{compressor}>\n<UnstructuredGrid>\
         <Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n{tags}</Piece></UnstructuredGrid><AppendedData encoding=\"raw\">_",
        8 * header,
        mesh.nodes.len(),
        mesh.cell_count()
    )
    .into_bytes();
    file.extend(appended);
    file.extend(b"</AppendedData></VTKFile>");
    file
}

#[test]
fn ranges_of_compressed_blocks_are_those_of_the_whole() {
    for (k, element) in [BlockElement::Hex8, BlockElement::Tet4Six].into_iter().enumerate() {
        let mesh = cube(element, [5, 4, 3]);
        for (block, big, header) in
            [(None, true, 8), (Some(1 << 15), false, 4), (Some(240), true, 4), (Some(8), false, 8)]
        {
            let path = temporary(&format!("blocks-{k}-{block:?}.vtu"));
            std::fs::write(&path, vtu(&mesh, block, big, header)).unwrap();
            let (read, _) = vtu_read::read(&path, 1.0).unwrap();
            let file = open(&path).unwrap();
            assert_eq!((file.groups().len(), read.groups.len()), (5, 5));
            let whole = all(&file, 1000).unwrap();
            assert!(whole.1 == read.nodes && whole.1 == mesh.nodes);
            for (set, group) in read.groups.iter().enumerate() {
                let sets = whole.2.iter().flat_map(|block| &block.1).zip(0..);
                let own: Vec<u32> = sets.filter(|(own, _)| **own == [set as u32]).map(|(_, cell)| cell).collect();
                assert_eq!(own, group.cells);
            }
            assert!([1, 11, 50].iter().all(|&pieces| all(&file, pieces).unwrap() == whole), "{block:?}");
            std::fs::remove_file(&path).unwrap();
        }
        // A number that goes on in the next block.
        let path = temporary(&format!("odd-{k}.vtu"));
        std::fs::write(&path, vtu(&mesh, Some(30), false, 4)).unwrap();
        assert!(vtu_read::read(&path, 1.0).is_ok() && MeshRanges::open(&path, 1.0).is_err());
        std::fs::remove_file(&path).unwrap();
    }
}

fn cube(element: BlockElement, cells: [usize; 3]) -> Mesh {
    block(&Block { size: [1.0; 3], cells, origin: [0.0; 3], grading: [1.0; 3], element }).unwrap()
}

/// Deterministic noise (Marsaglia's xorshift).
struct Noise(u64);

impl Noise {
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 % n as u64) as usize
    }
}

/// Small files of all kinds, by their ending.
fn small() -> Vec<(&'static str, Vec<u8>)> {
    let of = |element| cube(element, [3, 2, 2]);
    let mesh: Mesh = of(BlockElement::Wedge6);
    let shuffled = Style { big: true, size: 4, tag: |i| (i ^ 5) + 1, unused: 4, block: 5 };
    let path = temporary("small.vtu");
    write_mesh(&path, &mesh).unwrap();
    let plain = std::fs::read(&path).unwrap();
    std::fs::remove_file(&path).unwrap();
    let zlib = vtu(&of(BlockElement::Hex8), Some(64), false, 4);
    vec![
        ("msh", written(&mesh, PLAIN)),
        ("msh", written(&of(BlockElement::Tet10Six), shuffled)),
        ("vtu", plain),
        ("vtu", zlib),
    ]
}

fn temporary(name: &str) -> PathBuf {
    std::env::temp_dir().join(format!("stiction-io-ranges-{}-{name}", std::process::id()))
}

/// Whether all of a file with these bytes is read by ranges.
fn attempt(bytes: &[u8], path: &Path) -> Result<bool, Error> {
    std::fs::write(path, bytes).unwrap();
    let Some(file) = MeshRanges::open(path, 1.0)? else { return Ok(false) };
    // A compressed file may promise more than it has.
    all(&file, 1000 * bytes.len() as u64).map(|_| true)
}

#[test]
fn files_cut_short_are_no_files_and_flipped_bytes_do_not_panic() {
    let mut noise = Noise(0x9e37_79b9_7f4a_7c15);
    for (k, (ending, bytes)) in small().into_iter().enumerate() {
        let path = temporary(&format!("noise-{k}.{ending}"));
        assert_eq!(attempt(&bytes, &path), Ok(true));
        let whole = bytes.trim_ascii_end().len();
        for i in 0..150 {
            let cut = attempt(&bytes[..i * whole / 150], &path);
            // Of a VTU file nothing is looked for behind its arrays.
            assert!(ending == "vtu" || cut != Ok(true), "{k} cut at {i}");
        }
        for _ in 0..1500 {
            let mut changed = bytes.clone();
            for _ in 0..1 + noise.below(3) {
                let at = noise.below(changed.len());
                changed[at] = match noise.below(4) {
                    0 => noise.below(256) as u8,
                    1 => changed[at] ^ 1 << noise.below(8),
                    2 => b"0123456789-.e $\n<>/\""[noise.below(20)],
                    _ => 0xff,
                };
            }
            drop(attempt(&changed, &path));
        }
        std::fs::remove_file(&path).unwrap();
    }
}
