//! What cannot be read is refused with a place, a reason and a remedy.

use super::*;

/// The message must hold all of `words`.
fn refused(text: &str, words: &[&str]) {
    let message = parse(text.as_bytes(), "part.inp", 1.0, &nothing).map(|_| ()).unwrap_err().to_string();
    for word in words.iter().chain(&["part.inp"]) {
        assert!(message.contains(word), "\"{word}\" is not in: {message}");
    }
}

/// The cubes with `from` replaced by `to`.
fn edited(from: &str, to: &str) -> String {
    let text = cubes("*SURFACE, NAME=S\n9, S1\n*NSET, NSET=N, GENERATE\n10, 40, 10\n");
    assert!(text.contains(from));
    text.replacen(from, to, 1)
}

#[test]
fn lines_that_say_nothing_sensible_are_named() {
    refused(&edited("30,1.,1.,0", "30,1.,one,0"), &["line 4", "\"one\"", "where y was expected"]);
    refused(&edited("30,1.,1.,0", "-30,1.,1.,0"), &["line 4", "\"-30\"", "number of a node"]);
    refused(&edited("30,1.,1.,0", "30"), &["line 4", "node 30 has no coordinates"]);
    refused(&edited("30,1.,1.,0", "20,1.,1.,0"), &["node 20", "more than once"]);
    refused(&edited("30,1.,1.,0", "30,1.,1e999,0"), &["node 30", "finite"]);
    refused(&edited(",110,120,70", ",110,120"), &["line 17", "element 9 has 7 nodes instead of 8"]);
    refused(&edited(",110,120,70", ",110,120,70,1"), &["line 16", "element 9 has more than 8 nodes"]);
    refused(&edited("9, 20", "7, 20"), &["element 7", "more than once"]);
    refused(&edited("110,120,70", "110,121,70"), &["element 9", "line 14", "node 121", "does not hold"]);
    refused(&edited("10, 40, 10", "40, 10"), &["line 20", "cannot go from 40 to 10"]);
    refused(&edited("10, 40, 10", "10, 40, 0"), &["line 20", "steps of 0"]);
    refused(&edited("9, S1", "9, S7"), &["line 18", "\"S7\"", "S1 to S6"]);
    refused(&edited("9, S1", "Eal, S1"), &["surface S (line 17)", "\"Eal\"", "no set"]);
}

#[test]
fn what_changes_the_mesh_and_cannot_be_read_is_refused() {
    refused(&edited("C3D8", "C3D27"), &["line 14", "C3D27", "hexahedron with 27 nodes", "C3D15 or C3D20"]);
    refused(&edited("C3D8", "C3D20R"), &["element 7 has", "instead of 20"]);
    refused(&edited("C3D8", "c3d5"), &["line 14", "C3D5", "pyramid", "tetrahedra, wedges and hexahedra"]);
    refused(&edited("TYPE=C3D8, ", ""), &["line 14", "has no TYPE="]);
    refused(&cubes("*NGEN, NSET=A\n1,2\n"), &["line 17", "*NGEN", "all nodes and elements"]);
    refused(&cubes("*SYSTEM\n"), &["line 17", "*SYSTEM"]);
    refused(&edited("*NODE,", "*NODE, SYSTEM=C,"), &["line 1", "system C", "cartesian"]);
    refused(&cubes("*SURFACE, NAME=A, COMBINE=DIFFERENCE\n"), &["line 17", "DIFFERENCE", "list its faces"]);
    refused(&cubes("*INSTANCE, NAME=A, PART=B\n"), &["line 17", "part B", "not stand before"]);
    refused(&cubes("*ELSET, ELSET=A\nB\n*ELSET, ELSET=B\nA\n"), &["holds itself"]);
    refused("*NODE\n1,0,0,0\n*ELEMENT, TYPE=S3\n", &["no volume cells among its 1 nodes", "C3D4"]);
    refused("", &["empty"]);
    refused("$MeshFormat\n", &["not an Abaqus or CalculiX input"]);
}

#[test]
fn includes_that_fail_are_named() {
    refused(&cubes("*INCLUDE, INPUT=a.inp\n"), &["line 17", "\"a.inp\"", "there is none", "beside the input"]);
    let itself = |_: &str| Ok(b"*INCLUDE, INPUT=b.inp\n".to_vec());
    let message = parse(b"*INCLUDE, INPUT=a.inp\n", "part.inp", 1.0, &itself).unwrap_err().to_string();
    assert!(message.contains("part.inp, a.inp, b.inp, line 1") && message.contains("within itself"), "{message}");
    // two includes of two includes of ..: the names differ, and the number ends it
    let count = std::cell::Cell::new(0);
    let many = |_: &str| {
        count.set(count.get() + 1);
        Ok(format!("*INCLUDE, INPUT=a{0}\n*INCLUDE, INPUT=b{0}\n", count.get()).into_bytes())
    };
    let message = parse(b"*INCLUDE, INPUT=a.inp\n", "part.inp", 1.0, &many).unwrap_err().to_string();
    assert!(count.get() <= 1001 && message.contains("16 files deep"), "{message}");
    let message = |text: &[u8], included: &'static [u8]| {
        parse(text, "part.inp", 1.0, &|_| Ok(included.to_vec())).unwrap_err().to_string()
    };
    let said = message(b"*INCLUDE, INPUT=n.inp\n", b"*NODE\n1,0,0,0\n2,x\n");
    assert!(said.contains("part.inp, n.inp, line 3"), "{said}");
    let said = message(b"*NODE, INPUT=n.inp\n", b"1,0,0,0\n2,x\n");
    assert!(said.contains("part.inp, n.inp, line 2"), "{said}");
}
