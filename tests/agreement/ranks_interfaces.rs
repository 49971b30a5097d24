//! Interfaces that yield, and nodes that make up no face, on several ranks against the same case on one.

use super::ranks::{agrees, agrees_case, case_of, on_ranks};
use super::ranks_bodies::{blocks, floating};
use super::ranks_files::{folder, passes, solved};
use stiction::io::case::{self, Case};

const HEX8: &str = "element = \"hex8\"";
const TET4: &str = "element = \"tet4\", split = \"six\"";
const YIELDS: &str = "stiffness = { normal = 3e11, tangential = 1e11 }\n";

fn yielding(text: &str) -> String {
    format!("{text}{YIELDS}")
}

#[test]
fn interfaces_that_yield_are_the_same_on_ranks() {
    agrees(&yielding(&blocks(HEX8, false, "{ coulomb = 0.35 }")), &[1, 2, 3, 4]);
    agrees(&yielding(&blocks(TET4, true, "{ coulomb = 0.35 }")), &[4]);
    agrees(&yielding(&blocks(HEX8, false, "\"bonded\"")), &[3]);
    let plane = "{ plane = { point = [0, 0, 0], normal = [0, 0, 1] } }";
    agrees(&yielding(&floating(TET4, plane, "{ coulomb = 0.4 }", 0.0, true)), &[2, 4]);
    agrees(&yielding(&floating("element = \"tet10\", split = \"six\"", plane, "{ coulomb = 0.4 }", 0.0, true)), &[3]);
}

/// Springs so stiff that nodes of the mesh are measured from those in front of them.
#[test]
fn stiff_interfaces_are_the_same_on_ranks() {
    let stiff = |text: String| format!("{text}stiffness = {{ normal = 3e14 }}\n");
    agrees(&stiff(blocks(HEX8, false, "{ coulomb = 0.35 }")), &[1, 2, 3, 4]);
    agrees(&stiff(blocks("element = \"tet10\", split = \"six\"", true, "{ coulomb = 0.35 }")), &[3]);
    let plane = "{ plane = { point = [0, 0, 0], normal = [0, 0, 1] } }";
    agrees(&stiff(floating(TET4, plane, "{ coulomb = 0.4 }", 0.0, true)), &[4]);
    let case = case_of(&stiff(blocks(HEX8, false, "{ coulomb = 0.35 }")), "1e-10");
    let [alone, others @ ..] = [1, 2, 4].map(|size| on_ranks(&case, size).1.answer.counts.cycles);
    let hard = on_ranks(&case_of(&blocks(HEX8, false, "{ coulomb = 0.35 }"), "1e-10"), 1).1.answer.counts.cycles;
    assert!(2 * alone <= 3 * hard && others.iter().all(|&cycles| 2 * cycles <= 3 * hard), "{hard} {alone} {others:?}");
}

#[test]
fn interfaces_that_yield_take_the_cycles_of_one_rank() {
    for element in [TET4, HEX8] {
        let case = case_of(&yielding(&blocks(element, false, "{ coulomb = 0.35 }")), "1e-10");
        let [alone, others @ ..] = [1, 2, 3, 4].map(|size| on_ranks(&case, size).1.answer.counts.cycles);
        let most = (alone + 2).max((1.15 * alone as f64) as usize);
        assert!(others.iter().all(|&cycles| cycles <= most), "{element}: {others:?}, one rank {alone}");
    }
}

#[test]
fn interfaces_that_yield_go_through_load_steps_on_ranks() {
    let text = blocks(HEX8, false, "{ coulomb = 0.35 }").replace("[0, 0, 1e6]", "[0, \"2e5*t\", \"1e6*t\"]");
    let steps = "[[step]]\nuntil = 1\nincrements = 3\n";
    let text = format!("{text}{YIELDS}{steps}");
    agrees(&text, &[2, 3]);
    let (case, folder) = (case_of(&text, "1e-10"), folder("yields"));
    let first = solved(&case, 2, &folder, false);
    passes(&folder);
    let again = solved(&case, 3, &folder, true);
    passes(&folder);
    assert!((again.answer.contact.normal_force / first.answer.contact.normal_force - 1.0).abs() < 1e-9);
}

/// A block on another one, in a mesh file whose groups of the upper surface are of nodes alone.
fn of_nodes(name: &str) -> Case {
    let (cells, size) = ([6usize, 5, 4], [3.0, 2.5, 2.0]);
    let mut text = String::from("*NODE, NSET=ALL\n");
    let (mut elements, mut sets) = (String::new(), [const { Vec::new() }; 3]);
    let mut first = 1;
    for (part, below) in [(0usize, true), (1, false)] {
        let cells = if below { cells } else { [4, 4, 3] };
        let step = [0, 1, 2].map(|c| size[c] / cells[c] as f64);
        let number = |[i, j, k]: [usize; 3]| first + i + (cells[0] + 1) * (j + (cells[1] + 1) * k);
        for k in 0..=cells[2] {
            for j in 0..=cells[1] {
                for i in 0..=cells[0] {
                    let z = if below { k as f64 * step[2] - size[2] } else { k as f64 * step[2] };
                    let n = number([i, j, k]);
                    text += &format!("{n}, {}, {}, {z}\n", i as f64 * step[0], j as f64 * step[1]);
                    if below && k == 0 {
                        sets[0].push(n);
                    }
                    if !below && k == 0 {
                        sets[1].push(n);
                    }
                    if !below && k == cells[2] {
                        sets[2].push(n);
                    }
                }
            }
        }
        elements += &format!("*ELEMENT, TYPE=C3D8, ELSET=PART{part}\n");
        for k in 0..cells[2] {
            for j in 0..cells[1] {
                for i in 0..cells[0] {
                    let corners = [[0, 0], [1, 0], [1, 1], [0, 1]];
                    let nodes =
                        [k, k + 1].map(|k| corners.map(|[a, b]| number([i + a, j + b, k]).to_string()).join(", "));
                    let e = 1000 * (part + 1) + i + cells[0] * (j + cells[1] * k);
                    elements += &format!("{e}, {}, {}\n", nodes[0], nodes[1]);
                }
            }
        }
        if below {
            elements += "*SURFACE, NAME=TOP, TYPE=ELEMENT\n";
            for j in 0..cells[1] {
                for i in 0..cells[0] {
                    elements += &format!("{}, S2\n", 1000 + i + cells[0] * (j + cells[1] * (cells[2] - 1)));
                }
            }
        }
        first += (cells[0] + 1) * (cells[1] + 1) * (cells[2] + 1);
    }
    text += &elements;
    for (set, nodes) in ["FLOOR", "SOLE", "HEAD"].iter().zip(sets) {
        text += &format!("*NSET, NSET={set}\n");
        nodes.iter().for_each(|n: &usize| text += &format!("{n},\n"));
    }
    let path = std::env::temp_dir().join(format!("stiction-nodes-{}-{name}.inp", std::process::id()));
    std::fs::write(&path, text).unwrap();
    let case = format!(
        "[mesh]\nfile = {path:?}\n[materials.m]\nyoung = 1000\npoisson = 0.3\n[[fix]]\non = \"FLOOR\"\n\
         [[fix]]\non = \"HEAD\"\nvalue = [0.01, 0, \"-0.05 - 0.01*x\"]\n\
         [[contact]]\non = \"SOLE\"\nagainst = \"TOP\"\nfriction = {{ coulomb = 0.3 }}\n"
    );
    let set = |key: &str, value: &str| (format!("solver.{key}"), value.to_string());
    case::parse(&case, "case.toml", &[set("tolerance", "1e-10"), set("path", "\"multigrid\"")]).unwrap()
}

#[test]
fn nodes_that_make_up_no_face_meet_the_same_on_ranks() {
    agrees_case(&of_nodes("meet"), &[1, 2, 3, 4]);
}

/// Points of one contact hang on nodes that carry points of another one.
#[test]
fn chains_of_points_of_several_contacts_are_the_same_on_ranks() {
    let text = |element: &str| {
        let part = |name: &str, size: &str, at: &str, cells: &str| {
            format!(
                "[mesh.parts.{name}]\nblock = {{ size = {size}, origin = {at}, cells = {cells}, element = \"{element}\" }}\n"
            )
        };
        let parts = [
            part("a", "[6, 4, 3]", "[0, 0, 0]", "[6, 4, 4]"),
            part("b", "[6, 4, 3]", "[0, 0, 3]", "[6, 4, 4]"),
            part("s", "[2, 4, 6]", "[6, 0, 0]", "[2, 6, 8]"),
        ];
        let contact = |on: &str, against: &str| {
            format!("[[contact]]\non = {on}\nagainst = {against}\nfriction = {{ coulomb = 0.3 }}\nslave = \"on\"\n")
        };
        parts.concat()
            + "[materials.m]\nyoung = 1000\npoisson = 0.3\n[[fix]]\non = [\"a.z-min\", \"s.x-max\"]\n\
               [[load]]\non = \"b.z-max\"\nforce = [3, 0, -10]\nabout = [5, 2, 6]\n"
            + &contact("\"b.z-min\"", "\"a.z-max\"")
            + &contact("[\"a.x-max\", \"b.x-max\"]", "\"s.x-min\"")
    };
    agrees(&text("hex8"), &[1, 2, 3, 4, 6]);
    agrees(&text("tet10"), &[2, 4]);
}

/// Two feet on a base of wide cells, each with a contact of its own: points hang on one another in cycles.
#[test]
fn cycles_of_points_of_two_contacts_are_the_same_on_ranks() {
    let text = |element: &str| {
        let part = |name: &str, size: &str, at: &str, cells: &str, young: &str| {
            format!(
                "[mesh.parts.{name}]\nblock = {{ size = {size}, origin = {at}, cells = {cells}, element = \"{element}\" }}\n\
                 [materials.{name}]\non = \"{name}\"\nyoung = {young}\npoisson = 0.3\n"
            )
        };
        let foot = |name: &str, x: f64| {
            part(name, "[8, 10, 4]", &format!("[{x}, 0, 5]"), "[3, 3, 2]", "2e5")
                + &format!("[[load]]\non = \"{name}.z-max\"\nforce = [2, 0, -100]\n")
                + &format!(
                    "[[contact]]\nname = \"on {name}\"\non = \"base.z-max\"\nagainst = \"{name}.z-min\"\nfriction = {{ coulomb = 0.3 }}\n"
                )
        };
        part("base", "[30, 10, 5]", "[0, 0, 0]", "[8, 3, 3]", "10")
            + "[[fix]]\non = \"base.z-min\"\n"
            + &foot("a", 1.0)
            + &foot("b", 10.0)
    };
    agrees(&text("hex8"), &[1, 2, 3, 4, 6]);
    agrees(&text("tet10"), &[2, 4]);
}
