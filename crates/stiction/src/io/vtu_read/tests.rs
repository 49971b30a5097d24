use super::*;
use crate::mesh::CellArray;

/// A tetrahedron with a triangle, as text; `from` replaced by `to`.
fn edited(from: &str, to: &str) -> String {
    let text = r#"<?xml version="1.0"?>
<!-- a > comment -->
<VTKFile type="UnstructuredGrid" version="1.0" byte_order="LittleEndian" header_type="UInt64">
<UnstructuredGrid><FieldData><DataArray type="Float64" Name="TIME" NumberOfTuples="1" format="ascii">1</DataArray></FieldData>
<Piece NumberOfPoints="4" NumberOfCells="2">
<Points><DataArray type="Float32" Name="p" NumberOfComponents="3" format="ascii">0 0 0 1 0 0 0 1 0 0 0 1
<InformationKey name="L2"><Value index="0"> 0 </Value></InformationKey></DataArray></Points>
<Cells>
<DataArray type="Int32" Name="connectivity" format="ascii">0 1 2 3 0 1 2</DataArray>
<DataArray type="Int64" Name="offsets" format="ascii">4 7</DataArray>
<DataArray type="UInt8" Name="types" format="ascii">10 5</DataArray>
</Cells>
<PointData><DataArray type="Int32" Name="on &lt;top&gt;" format="ascii">0 1 0 0</DataArray></PointData>
<CellData Scalars="part">
<DataArray type="Int32" Name="part" format="ascii">-7 3</DataArray>
<DataArray type="Float64" Name="stress" format="ascii">5 7</DataArray>
<DataArray type="Float64" Name="v" NumberOfComponents="2" format="ascii">5 7 1 2</DataArray>
</CellData></Piece></UnstructuredGrid></VTKFile>
"#;
    assert!(text.contains(from));
    text.replacen(from, to, 1)
}

fn refused(text: &str, words: &[&str]) {
    let message = parse(text.as_bytes(), "part.vtu", 1.0).map(|_| ()).unwrap_err().to_string();
    for word in words.iter().chain(&["part.vtu"]) {
        assert!(message.contains(word), "\"{word}\" is not in: {message}");
    }
}

#[test]
fn a_grid_of_text_is_read_with_its_groups() {
    let (mesh, notes) = parse(edited("4", "4").as_bytes(), "part.vtu", 3.0).unwrap();
    assert!((mesh.volume() - 4.5).abs() < 1e-15);
    assert_eq!(mesh.group("part--7").unwrap().cells, [0]);
    let [face] = mesh.group("part-3").unwrap().faces[..] else { panic!("one face") };
    assert_eq!(mesh.face_normal(face as usize), [0.0, 0.0, -1.0]);
    assert_eq!(mesh.group("on <top>").unwrap().nodes, [1]);
    assert_eq!((mesh.groups.len(), notes.to_string().as_str()), (3, "not read: array \"v\"\n"));
    let stress = CellArray { name: "stress".into(), values: vec![5.0], faces: vec![(face, 7.0)] };
    assert_eq!((mesh.arrays.cells, mesh.arrays.nodes.len()), (vec![stress], 0));
    assert_eq!(mesh.arrays.others[2], ("v".into(), "it has 2 components".into()));
}

#[test]
fn arrays_of_numbers_and_masks_are_told_from_groups() {
    let names = |text: String| -> Vec<String> {
        let (mesh, _) = parse(text.as_bytes(), "part.vtu", 1.0).unwrap();
        mesh.groups.into_iter().map(|g| g.name).collect()
    };
    assert_eq!(names(edited("-7 3", "1 0")), ["part-0", "part", "on <top>"]);
    assert_eq!(
        names(edited(">0 1 0 0<", ">10 11 12 13<")),
        ["part--7", "part-3"],
        "all different: numbers of the points"
    );
    assert_eq!(names(edited("on &lt;top&gt;", "vtkGhostType")), ["part--7", "part-3"]);
}

#[test]
fn voxels_count_their_nodes_along_the_axes() {
    let corners: String = (0..8).map(|i| format!("{} {} {} ", i & 1, i >> 1 & 1, i >> 2)).collect();
    let text = edited("NumberOfPoints=\"4\" NumberOfCells=\"2\"", "NumberOfPoints=\"8\" NumberOfCells=\"1\"");
    let text = text.replace("0 0 0 1 0 0 0 1 0 0 0 1", &corners).replace("0 1 2 3 0 1 2", "0 1 2 3 4 5 6 7");
    let text = text.replace("4 7<", "8<").replace("10 5<", "11<").replace("-7 3", "5").replace(">0 0<", ">0<");
    let (mesh, _) = parse(text.replace(">0 1 0 0<", ">0 0 0 0 0 0 0 1<").as_bytes(), "part.vtu", 1.0).unwrap();
    assert!((mesh.volume() - 1.0).abs() < 1e-14);
    assert_eq!(mesh.faces.len(), 6);
}

/// The first triangle of a wedge turns towards the other or away from it: one volume either way.
#[test]
fn wedges_are_read_whichever_way_their_triangles_turn() {
    let corners = "0 0 0 1 0 0 0 1 0 0 0 1 1 0 1 0 1 1";
    let text = edited("NumberOfPoints=\"4\" NumberOfCells=\"2\"", "NumberOfPoints=\"6\" NumberOfCells=\"1\"");
    let text = text.replace("0 0 0 1 0 0 0 1 0 0 0 1", corners).replace("4 7<", "6<").replace("10 5<", "13<");
    let text = text.replace("-7 3", "5").replace(">0 0<", ">0<").replace(">0 1 0 0<", ">0 0 0 0 0 1<");
    for nodes in ["0 1 2 3 4 5", "3 4 5 0 1 2", "0 2 1 3 5 4"] {
        let text = text.replace("0 1 2 3 0 1 2", nodes);
        let (mesh, _) = parse(text.as_bytes(), "part.vtu", 1.0).unwrap();
        assert!((mesh.volume() - 0.5).abs() < 1e-14, "{nodes}");
        assert_eq!(mesh.faces.iter().map(|face| face.nodes().len()).sum::<usize>(), 2 * 3 + 3 * 4);
    }
}

#[test]
fn what_cannot_be_read_is_refused() {
    refused("", &["empty"]);
    refused("# vtk DataFile Version 3.0\n", &["legacy", "ParaView"]);
    refused("solid\n", &["not a VTU file"]);
    refused(&edited("UnstructuredGrid", "PolyData"), &["line 3", "\"PolyData\"", "ParaView"]);
    refused(&edited("header_type=\"UInt64\"", "compressor=\"vtkLZMADataCompressor\""), &["line 3", "vtkLZMA", "zlib"]);
    refused(&edited("NumberOfPoints=\"4\"", "NumberOfPoints=\"5\""), &["array \"p\" (line 6)", "12 numbers where 15"]);
    refused(&edited("NumberOfPoints=\"4\"", "NumberOfPoints=\"4000000000\""), &["array \"p\"", "12 numbers"]);
    refused(&edited("NumberOfPoints=\"4\"", "NumberOfPoints=\"-4\""), &["line 5", "\"-4\""]);
    refused(&edited("0 1 2 3 0 1 2<", "0 1 2 9 0 1 2<"), &["cell 0", "node 9 of 4"]);
    refused(&edited("4 7<", "4 3<"), &["connectivity", "7 numbers where 3"]);
    refused(&edited("4 7<", "9 7<"), &["cell 0", "end at 9"]);
    refused(&edited("0 1 2 3 0 1 2<", "0 1 2 x 0 1 2<"), &["array \"connectivity\" (line 9)", "\"x\""]);
    refused(&edited("10 5<", "24 5<"), &["1 x quadratic cell with an unusual number of nodes", "4 or 10"]);
    refused(&edited("10 5<", "29 5<"), &["1 x hexahedron of higher order", "8 or 20"]);
    refused(&edited("10 5<", "14 5<"), &["1 x pyramid", "tetrahedra, wedges and hexahedra"]);
    refused(&edited("10 5<", "10 10<"), &["unusual number of nodes"]);
    refused(&edited("0 1 2 3 0 1 2<", "0 1 3 2 0 1 2<"), &["inside out", "mirrored"]);
    refused(&edited("Name=\"types\"", "Name=\"type\""), &["no array \"types\""]);
    refused(
        &edited("</Piece>", "</Piece><Piece NumberOfPoints=\"1\" NumberOfCells=\"1\"></Piece>"),
        &["several pieces"],
    );
    refused(&edited("type=\"Float32\"", "type=\"Float16\""), &["line 6", "\"Float16\""]);
    refused(&edited("format=\"ascii\">0 0 0 1", "format=\"appended\" offset=\"5\">0 0 0 1"), &["end too early"]);
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

#[test]
fn cut_and_changed_grids_do_not_panic() {
    let mut files = vec![edited("4", "4").into_bytes()];
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data");
    for suffix in ["raw", "raw-zlib", "base64-zlib", "inline-zlib"] {
        files.push(std::fs::read(format!("{folder}/brick-vtk-{suffix}.vtu")).unwrap());
    }
    files.push(std::fs::read(format!("{folder}/curved-hex20-meshio.vtu")).unwrap());
    let mut noise = Noise(0x2545_f491_4f6c_dd1d);
    for bytes in files {
        assert!(parse(&bytes, "a.vtu", 1.0).is_ok());
        for end in 0..bytes.len() {
            drop(parse(&bytes[..end], "a.vtu", 1.0));
        }
        for _ in 0..1500 {
            let mut changed = bytes.clone();
            for _ in 0..1 + noise.below(3) {
                let at = noise.below(changed.len());
                changed[at] = match noise.below(4) {
                    0 => noise.below(256) as u8,
                    1 => changed[at] ^ 1 << noise.below(8),
                    2 => b"0123456789-.e<>\"/= \n"[noise.below(20)],
                    _ => 0xff,
                };
            }
            drop(parse(&changed, "a.vtu", 1.0));
        }
    }
}

/// A file much longer than its description: what is asked for comes back though the rest is never read.
#[test]
fn single_arrays_of_a_large_result_come_back_in_any_order() {
    use super::fields::{Over, read_fields};
    use crate::io::vtu::{Array, Grid, VERTEX, write};
    let digits = |seed: f64| move |i: usize| (seed * i as f64).sin();
    let points: Vec<[f64; 3]> = (0..20_000).map(digits(1.1)).map(|x| [x, 2.0 * x, 3.0 * x]).collect();
    let first: Vec<f64> = (0..points.len()).map(digits(1.3)).collect();
    let unasked: Vec<[f64; 3]> = (0..points.len()).map(digits(1.7)).map(|x| [x; 3]).collect();
    let last: Vec<f64> = (0..points.len()).map(digits(1.9)).collect();
    let path = std::env::temp_dir().join(format!("stiction-fields-{}.vtu", std::process::id()));
    let on_points = [Array::scalar("first", &first), Array::vector("unasked", &unasked)];
    let mut grid = Grid::new(&points);
    (0..points.len() as u32).for_each(|point| grid.push(VERTEX, &[point]));
    write(&path, &grid, &on_points, &[Array::scalar("last", &last)]).unwrap();
    let read = read_fields(&path, &[(Over::Cells, "last"), (Over::Cells, "first"), (Over::Points, "first")]).unwrap();
    std::fs::remove_file(&path).unwrap();
    assert_eq!((read.points, read.cells), (points.len(), points.len()));
    assert!(read.arrays == [Some(last), None, Some(first)]);
}

/// Numbers of every width, in both byte orders and in compressed blocks that cut them in two: the mesh of the text.
#[test]
fn numbers_are_read_in_every_width_and_byte_order() {
    let (expected, _) = parse(edited("4", "4").as_bytes(), "part.vtu", 1.0).unwrap();
    let bytes = |values: &[i64], size: usize, big: bool| -> Vec<u8> {
        let number =
            |v: &i64| if big { v.to_be_bytes()[8 - size..].to_vec() } else { v.to_le_bytes()[..size].to_vec() };
        values.iter().flat_map(number).collect()
    };
    let head = |n: usize, big: bool| bytes(&[n as i64], 8, big);
    // Blocks of five bytes end within most numbers.
    let blocks = |data: &[u8], block: usize, big: bool| -> Vec<u8> {
        let packed = |part: &[u8]| {
            let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
            std::io::Write::write_all(&mut encoder, part).unwrap();
            encoder.finish().unwrap()
        };
        let parts: Vec<Vec<u8>> = data.chunks(block).map(packed).collect();
        let sizes = parts.iter().map(Vec::len);
        let heads = [parts.len(), block, data.len() % block].into_iter().chain(sizes).flat_map(|n| head(n, big));
        heads.chain(parts.iter().flatten().copied()).collect()
    };
    let stored = |data: &[u8], block: Option<usize>, big: bool| match block {
        Some(block) => blocks(data, block, big),
        None => [&head(data.len(), big), data].concat(),
    };
    let signed = [(1, "Int8"), (2, "Int16"), (4, "Int32"), (8, "Int64")];
    let unsigned = [(1, "UInt8"), (2, "UInt16"), (4, "UInt32"), (8, "UInt64")];
    for (size, name) in signed.into_iter().chain(unsigned) {
        for (big, block) in [(false, None), (true, None), (false, Some(5)), (true, Some(5)), (true, Some(16))] {
            let mut text = edited("4", "4");
            let mut appended: Vec<u8> = Vec::new();
            for (kind, array, words) in [
                ("Int32", "connectivity", "0 1 2 3 0 1 2"),
                ("Int64", "offsets", "4 7"),
                ("Int32", "on &lt;top&gt;", "0 1 0 0"),
                ("Int32", "part", "-7 3"),
            ] {
                if name.starts_with('U') && words.contains('-') {
                    continue;
                }
                let values: Vec<i64> = words.split(' ').map(|word| word.parse().unwrap()).collect();
                let data = bytes(&values, size, big);
                let from = format!("type=\"{kind}\" Name=\"{array}\" format=\"ascii\">{words}<");
                assert!(text.contains(&from));
                let to =
                    format!("type=\"{name}\" Name=\"{array}\" format=\"appended\" offset=\"{}\"><", appended.len());
                text = text.replacen(&from, &to, 1);
                appended.extend(stored(&data, block, big));
            }
            let float = if size < 8 { "Float32" } else { "Float64" };
            let data: Vec<u8> = [5.0f64, 7.0]
                .iter()
                .flat_map(|x| {
                    let mut all = if size < 8 { (*x as f32).to_be_bytes().to_vec() } else { x.to_be_bytes().to_vec() };
                    if !big {
                        all.reverse();
                    }
                    all
                })
                .collect();
            let to = format!("type=\"{float}\" Name=\"stress\" format=\"appended\" offset=\"{}\"><", appended.len());
            let from = "type=\"Float64\" Name=\"stress\" format=\"ascii\">5 7<";
            assert!(text.contains(from));
            text = text.replacen(from, &to, 1);
            appended.extend(stored(&data, block, big));
            if big {
                text = text.replace("LittleEndian", "BigEndian");
            }
            if block.is_some() {
                text = text.replace("header_type", "compressor=\"vtkZLibDataCompressor\" header_type");
            }
            let (grid, end) = text.split_once("</VTKFile>").unwrap();
            let file = [
                grid.as_bytes(),
                b"<AppendedData encoding=\"raw\">_",
                &appended,
                b"</AppendedData></VTKFile>",
                end.as_bytes(),
            ];
            let (mesh, _) = parse(&file.concat(), "part.vtu", 1.0).unwrap();
            assert_eq!(mesh, expected, "{name} {big} {block:?}");
        }
    }
}
