//! Numbers at nodes and elements.

use super::*;

fn fields(suffix: &str) -> Vec<u8> {
    let folder = PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../tests/data"));
    std::fs::read(folder.join(format!("fields-{suffix}.msh"))).unwrap()
}

/// Formulas of place by which `make_fields.py` let Gmsh write them.
#[test]
fn data_that_gmsh_wrote_are_where_they_belong() {
    for suffix in SUFFIXES {
        let (mesh, notes) = parse(&fields(suffix), "fields.msh", 1.0).unwrap();
        let centre = |nodes: &[u32]| {
            [0, 1, 2].map(|c| nodes.iter().map(|&n| mesh.nodes[n as usize][c]).sum::<f64>() / nodes.len() as f64)
        };
        let [mu] = &mesh.arrays.nodes[..] else { panic!("{suffix}") };
        assert_eq!(mu.name, "mu");
        for (x, value) in mesh.nodes.iter().zip(&mu.values) {
            assert!((value - (0.1 + 0.05 * x[0] + 0.02 * x[1])).abs() < 1e-15, "{suffix} {x:?} {value}");
        }
        let [layer] = &mesh.arrays.cells[..] else { panic!("{suffix}") };
        for ((_, nodes), value) in mesh.cell_iter().zip(&layer.values) {
            assert!((value - (0.5 + 0.1 * centre(nodes)[0])).abs() < 1e-14, "{suffix} {value}");
        }
        let bottom = &mesh.group("bottom").unwrap().faces;
        for (number, face) in mesh.faces.iter().enumerate() {
            let [x, value] = [centre(face.nodes())[0], layer.of_face(number as u32, face.cell)];
            let of_cell = layer.values[face.cell as usize];
            let wanted = if bottom.contains(&(number as u32)) { 7.0 + x } else { of_cell };
            assert!((value - wanted).abs() < 1e-14, "{suffix} {value} {wanted}");
        }
        assert_eq!(mesh.arrays.others, [("v".to_string(), "it has 3 components".to_string())]);
        let told = notes.to_string();
        assert!(told.contains("values of array \"layer\" at places that the file does not hold"), "{told}");
    }
}

#[test]
fn data_that_are_damaged_are_refused_with_their_line() {
    let data = "$NodeData\n1\n\"T\"\n1\n0.5\n3\n0\n1\n2\n1 5\n9 7e1\n$EndNodeData\n";
    let tet = tet22(1, "1 4 2 7 3 1 2 3 9\n");
    let (mesh, _) = parse((tet.clone() + data).as_bytes(), "a.msh", 1.0).unwrap();
    assert_eq!((mesh.arrays.nodes[0].values[0], mesh.arrays.nodes[0].values[3]), (5.0, 70.0));
    assert!(mesh.arrays.nodes[0].values[1].is_nan());
    // in front of the nodes
    let (head, rest) = tet.split_at(tet.find("$Nodes").unwrap());
    assert_eq!(
        parse(format!("{head}{data}{rest}").as_bytes(), "a.msh", 1.0).unwrap().0.arrays.nodes[0].values[3],
        70.0
    );
    let refused = |from: &str, to: &str, words: [&str; 2]| {
        assert!(data.contains(from));
        let message =
            parse((tet.clone() + &data.replacen(from, to, 1)).as_bytes(), "a.msh", 1.0).unwrap_err().to_string();
        words.iter().for_each(|word| assert!(message.contains(word), "\"{word}\" is not in: {message}"));
    };
    refused("1\n2\n1 5", "1\n200\n1 5", ["200 values are announced", "line 23"]);
    refused("0\n1\n2\n", "0\n0\n2\n", ["2 values of 0 components", "line 19"]);
    refused("9 7e1", "9 x", ["\"x\" stands where a value was expected", "line 25"]);
    refused("9 7e1\n", "", ["\"$EndNodeData\" stands where", "line 25"]);
    let twice = tet22(2, "1 4 2 7 3 1 2 3 9\n1 15 2 0 0 1\n") + &data.replace("Node", "Element");
    let message = parse(twice.as_bytes(), "a.msh", 1.0).unwrap_err().to_string();
    assert!(message.contains("element 1") && message.contains("given more than once"), "{message}");
    let corners = data.replace("NodeData", "ElementNodeData");
    let (mesh, notes) = parse((tet + &corners).as_bytes(), "a.msh", 1.0).unwrap();
    assert!(mesh.arrays.others[0].1.contains("each node of each element") && notes.to_string().contains("\"T\""));
}
