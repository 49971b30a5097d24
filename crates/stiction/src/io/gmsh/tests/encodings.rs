//! One tetrahedron in every binary encoding the format allows, and oddities of text.

use super::*;

struct Writer {
    bytes: Vec<u8>,
    big: bool,
    size: usize,
}

impl Writer {
    fn text(&mut self, text: &str) {
        self.bytes.extend_from_slice(text.as_bytes());
    }

    fn little(&mut self, bytes: &[u8]) {
        let mut bytes = bytes.to_vec();
        if self.big {
            bytes.reverse();
        }
        self.bytes.extend(bytes);
    }

    fn ints(&mut self, values: &[i32]) {
        values.iter().for_each(|v| self.little(&v.to_le_bytes()));
    }

    fn sizes(&mut self, values: &[u64]) {
        let size = self.size;
        values.iter().for_each(|v| self.little(&v.to_le_bytes()[..size]));
    }

    fn floats(&mut self, values: &[f64]) {
        values.iter().for_each(|v| self.little(&v.to_le_bytes()));
    }
}

const CORNERS: [f64; 12] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];

fn tet41(big: bool, size: usize) -> Vec<u8> {
    let mut w = Writer { bytes: Vec::new(), big, size };
    w.text(&format!("$MeshFormat\n4.1 1 {size}\n"));
    w.ints(&[1]);
    w.text("\n$EndMeshFormat\n$Comments\na $ sign\n$EndComments\n$Entities\n");
    w.sizes(&[0, 0, 1, 1]);
    for (tag, physical) in [(5, -6), (7, 8)] {
        w.ints(&[tag]);
        w.floats(&[0.0; 6]);
        w.sizes(&[1]);
        w.ints(&[physical]);
        w.sizes(&[0]);
    }
    w.text("\n$EndEntities\n$Elements\n"); // before the nodes: odd, but allowed
    w.sizes(&[2, 2, 1, 2]);
    w.ints(&[2, 5, 2]);
    w.sizes(&[1, 1, 10, 20, 3_000_000]);
    w.ints(&[3, 7, 4]);
    w.sizes(&[1, 2, 10, 20, 3_000_000, 40]);
    w.text("\n$EndElements\n$Nodes\n");
    w.sizes(&[1, 4, 10, 3_000_000]);
    w.ints(&[3, 7, 0]);
    w.sizes(&[4, 10, 20, 3_000_000, 40]);
    w.floats(&CORNERS);
    w.text("\n$EndNodes\n");
    w.bytes
}

#[test]
fn both_byte_orders_and_both_sizes_of_integers_are_read() {
    for (big, size) in [(false, 4), (false, 8), (true, 4), (true, 8)] {
        let (mesh, notes) = parse(&tet41(big, size), "tet.msh", 6.0).unwrap();
        assert_eq!(mesh.volume(), 36.0);
        assert_eq!(mesh.group("8").unwrap().cells, [0]);
        assert_eq!(mesh.group("6").unwrap().faces.len(), 1);
        assert_eq!(notes.0, []);
    }
}

#[test]
fn big_endian_msh_2_is_read() {
    let mut w = Writer { bytes: Vec::new(), big: true, size: 8 };
    w.text("$MeshFormat\n2.2 1 8\n");
    w.ints(&[1]);
    w.text("\n$EndMeshFormat\n$Nodes\n4\n");
    for (i, x) in CORNERS.chunks(3).enumerate() {
        w.ints(&[i as i32]);
        w.floats(x);
    }
    w.text("\n$EndNodes\n$Elements\n1\n");
    w.ints(&[4, 1, 2, 77, 3, 1, 0, 1, 2, 3]);
    w.text("\n$EndElements\n");
    assert_eq!(parse(&w.bytes, "tet.msh", 1.0).unwrap().0.group("3").unwrap().cells, [0]);
}

#[test]
fn faces_given_inside_out_still_have_outward_normals() {
    for order in ["2 3 9", "9 3 2", "3 2 9"] {
        let text = tet22(2, &format!("1 2 2 5 1 {order}\n2 4 2 6 1 1 2 3 9\n"));
        let (mesh, _) = parse(text.as_bytes(), "t.msh", 1.0).unwrap();
        let [face] = mesh.group("5").unwrap().faces[..] else { panic!("one face") };
        // the slanted face of the corner of the unit cube
        assert!(mesh.face_normal(face as usize).iter().all(|n| (n - 1.0 / 3f64.sqrt()).abs() < 1e-15));
    }
}

#[test]
fn windows_line_ends_and_names_with_spaces_are_read() {
    let names = "$PhysicalNames\n2\n3 6 \"the \"big\" part\"\n2 6 \"the \"big\" part\"\n$EndPhysicalNames\n";
    let text = tet22(2, "1 2 2 6 1 1 2 3\n2 4 3 6 1 0 1 2 3 9\n").replace("$Nodes", &format!("{names}$Nodes"));
    let (mesh, notes) = parse(text.replace('\n', "\r\n").as_bytes(), "t.msh", 1.0).unwrap();
    let group = mesh.group("the \"big\" part").unwrap();
    assert_eq!((group.cells.len(), group.faces.len()), (1, 1));
    assert_eq!(notes.0, [MeshNote::SharedName { group: "the \"big\" part".into() }]);
}

#[test]
fn elements_and_nodes_of_no_use_are_noted() {
    let text = tet22(2, "1 2 0 1 2 3\n2 4 0 1 2 3 9\n").replace("4\n1 0 0 0", "5\n77 1 1 1\n1 0 0 0");
    let (mesh, notes) = parse(text.as_bytes(), "t.msh", 1.0).unwrap();
    assert_eq!((mesh.nodes.len(), mesh.groups.len()), (4, 0));
    let said = notes.to_string();
    assert_eq!(said, "1 surface element in no group, not used\n1 node dropped: no cell uses 77\n");
}
