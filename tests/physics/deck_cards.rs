//! Cards of decks that turn directions, tighten bolts and change friction.

use stiction::fem::Axes;
use stiction::io::deck::{self, Deck};
use stiction::run::{Outcome, Prepared, pair_totals};
use stiction_fixtures::case_run::{at, is, solved_case, stress};

const PRESS: &str = include_str!("../data/decks/press.inp");

fn read(text: &str) -> Result<Deck, stiction::Error> {
    deck::parse(text.as_bytes(), "deck.inp", &|name| Err(format!("there is no {name}")))
}

fn solved(text: &str) -> (Outcome, Prepared) {
    let deck = read(text).unwrap_or_else(|e| panic!("{e}"));
    solved_case(&deck.case(&[]).unwrap_or_else(|e| panic!("{e}\n{}", deck.text)))
}

/// `press.inp` with the cards `model` above its step and `steps` at its end.
fn press(model: &str, steps: &str) -> String {
    assert_eq!((PRESS.matches("*STEP\n").count(), PRESS.matches("*END STEP\n").count()), (1, 1));
    PRESS.replacen("*STEP\n", &format!("{model}*STEP\n"), 1).replace("*END STEP\n", &format!("*END STEP\n{steps}"))
}

fn step(cards: &str) -> String {
    format!("*STEP\n*STATIC\n{cards}*END STEP\n")
}

#[test]
fn forces_and_supports_count_along_the_axes_of_a_transform() {
    // Local x is (1, 1, 0)/sqrt(2), local y (-1, 1, 0)/sqrt(2).
    let model = "*TRANSFORM, NSET=Ntop, TYPE=R\n1., 1., 0., 0., 1., 0.\n";
    let run = solved(&press(model, &step("*CLOAD\nNtop, 1, 0.7\n*BOUNDARY\nNtop, 2, 2\n")));
    let half = 4.0 * 0.7 / 2f64.sqrt();
    let [x, y, _] = pair_totals(&run.1, &run.0)[0].1.tangential_force;
    is(x.abs(), half, half);
    is(y.abs(), half, half);
    let u = at(&run, [1.0, 1.0, 2.0]);
    is(u[0], u[1], u[0]);
    let run = solved(&press(model, &step("*BOUNDARY\nNtop, 1, 1, 0.001\nNtop, 2, 2, 0.002\n")));
    let u = at(&run, [0.0, 0.0, 2.0]);
    is(u[0], (0.001 - 0.002) / 2f64.sqrt(), 0.001);
    is(u[1], (0.001 + 0.002) / 2f64.sqrt(), 0.001);
}

#[test]
fn tangential_displacements_about_an_axis_turn_a_face() {
    let model = "*TRANSFORM, NSET=Ntop, TYPE=C\n0.5, 0.5, 0., 0.5, 0.5, 3.\n";
    let (angle, radius) = (1e-4, 0.5f64.sqrt());
    let run = solved(&press(model, &step(&format!("*BOUNDARY\nNtop, 1, 1\nNtop, 2, 2, {}\n", angle * radius))));
    for [x, y] in [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
        let u = at(&run, [x, y, 2.0]);
        is(u[0], -angle * (y - 0.5), angle);
        is(u[1], angle * (x - 0.5), angle);
    }
    // Tangential forces have a moment and no resultant.
    let deck = read(&press(model, &step("*CLOAD\nNtop, 2, 3.\n"))).unwrap();
    let [x, y] = ["x", "y"].map(|axis| {
        deck.mesh.0.arrays.nodes.iter().find(|array| array.name == format!("force 1 {axis}")).unwrap().values.clone()
    });
    let nodes = &deck.mesh.0.nodes;
    let moment = |i: usize| (nodes[i][0] - 0.5) * y[i] - (nodes[i][1] - 0.5) * x[i];
    is((0..nodes.len()).map(moment).sum(), 4.0 * 3.0 * radius, 12.0);
    is(x.iter().sum(), 0.0, 12.0);
    is(y.iter().sum(), 0.0, 12.0);
    assert!(matches!(deck.case(&[]).unwrap().fixes[0].axes, Axes::Global));
    // On the axis nothing is radial.
    let on_axis = press("*TRANSFORM, NSET=Ntop, TYPE=C\n0., 0., 0., 0., 0., 1.\n", &step("*CLOAD\nNtop, 1, 3.\n"));
    let error = read(&on_axis).unwrap_err();
    assert!(error.what.contains("node 15 lies on the axis"), "{error}");
}

/// A column of three unit cubes, held at both ends, with a cut between the first and the second.
fn bolt(steps: &str) -> String {
    let mut text = "*NODE, NSET=Nall\n".to_string();
    for k in 0..4 {
        for (i, [x, y]) in [[0, 0], [1, 0], [1, 1], [0, 1]].iter().enumerate() {
            text += &format!("{}, {x}, {y}, {k}\n", 4 * k + i + 1);
        }
    }
    text += "99, 0.5, 0.5, 1.\n*ELEMENT, TYPE=C3D8, ELSET=E\n";
    for e in 0..3 {
        let nodes: Vec<String> = (4 * e + 1..4 * e + 9).map(|n| n.to_string()).collect();
        text += &format!("{}, {}\n", e + 1, nodes.join(", "));
    }
    text += "*NSET, NSET=Nends\n1, 2, 3, 4\n*NSET, NSET=Ntop\n13, 14, 15, 16\n*SURFACE, NAME=Cut\n1, S2\n\
             *MATERIAL, NAME=M\n*ELASTIC\n1000., 0.\n*SOLID SECTION, ELSET=E, MATERIAL=M\n\
             *PRE-TENSION SECTION, SURFACE=Cut, NODE=99\n0., 0., 1.\n*BOUNDARY\nNends, 1, 3\nNtop, 1, 3\n";
    text + steps
}

#[test]
fn a_pretension_section_is_tightened_by_its_node_and_locked() {
    let tension = |steps: &str| stress(&solved(&bolt(steps))).iter().map(|s| s[2]).collect::<Vec<f64>>();
    let all = |stresses: Vec<f64>, wanted: f64| stresses.iter().for_each(|&s| is(s, wanted, 1e3 * wanted));
    all(tension(&step("*CLOAD\n99, 1, 10.\n")), 10.0);
    // Drawn together by a hundredth of its length.
    all(tension(&step("*BOUNDARY\n99, 1, 1, 0.03\n")), 10.0);
    // Locked, and its end pulled away by a thousandth of its length.
    let locked = "*CLOAD, OP=NEW\n*BOUNDARY, FIXED\n99, 1, 1\n*BOUNDARY\nNtop, 3, 3, 0.003\n";
    all(tension(&(step("*CLOAD\n99, 1, 10.\n") + &step(locked))), 11.0);
    // A vector into the elements of the surface turns the signs.
    // The nodes of the cut move with the elements that are not those of the surface (CalculiX 2.20 prints -0.02, -0.01 and 0.02).
    let cut = |surface: &str, vector: &str| {
        let text = bolt(&step("*BOUNDARY\n99, 1, 1, 0.03\n"));
        let text = text.replace("1, S2\n", surface).replace("0., 0., 1.\n*B", &format!("{vector}\n*B"));
        at(&solved(&text), [0.0, 0.0, 1.0])[2]
    };
    is(cut("1, S2\n", "0., 0., 1."), -0.02, 1.0);
    is(cut("2, S1\n", "0., 0., 1."), -0.01, 1.0);
    is(cut("1, S2\n", "0., 0., -1."), 0.02, 1.0);
    let turned = |steps: &str| stress(&solved(&bolt(steps).replace("0., 0., 1.\n*B", "0., 0., -1.\n*B")));
    all(turned(&step("*CLOAD\n99, 1, -10.\n")).iter().map(|s| s[2]).collect(), 10.0);
    all(turned(&step("*BOUNDARY\n99, 1, 1, -0.03\n")).iter().map(|s| s[2]).collect(), 10.0);
    all(turned(&step("*BOUNDARY\n99, 1, 1, 0.03\n")).iter().map(|s| s[2]).collect(), -10.0);
    for (steps, word) in [
        (step(""), "nothing tightens this bolt: node 99"),
        (step("*CLOAD\n99, 1, 10.\n") + &step("*BOUNDARY\n99, 1, 1, 0.1\n"), "a force and a displacement"),
        (step("*CLOAD\n99, 2, 10.\n"), "node 99 belongs to no solid element"),
    ] {
        let error = read(&bolt(&steps)).unwrap_err();
        assert!(error.what.contains(word) && error.place.starts_with("deck.inp, line"), "{error}");
    }
    let shared = bolt(&step("")).replace("NODE=99", "NODE=5");
    assert!(read(&shared).unwrap_err().what.contains("belongs to an element"));
}

/// A shank with a head on one side, of which two nodes that make up no face press on an anvil: they carry the whole force.
#[test]
fn nodes_that_make_up_no_face_take_the_force_of_a_bolt() {
    let mut text = "*NODE, NSET=Nall\n".to_string();
    let at = |x: usize, y: usize, z: usize| 1 + x + 3 * y + 6 * z;
    for (z, y, x) in (0..4).flat_map(|z| (0..2).flat_map(move |y| (0..3).map(move |x| (z, y, x)))) {
        text += &format!("{}, {x}, {y}, {z}\n{}, {x}, {y}, {z}\n", at(x, y, z), 100 + at(x, y, z));
    }
    text += "99, 0.5, 0.5, 1.\n";
    let mut number = 0;
    for (set, shift, cubes) in [("E", 0, &[[0, 0], [0, 1], [0, 2], [1, 2]][..]), ("Anvil", 100, &[[1, 1]])] {
        text += &format!("*ELEMENT, TYPE=C3D8, ELSET={set}\n");
        for &[x, z] in cubes {
            let corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)];
            let nodes = corners.map(|(a, b, c)| (shift + at(x + a, b, z + c)).to_string());
            number += 1;
            text += &format!("{number}, {}\n", nodes.join(", "));
        }
    }
    let (a, b) = (at(1, 0, 2), at(2, 1, 2));
    text += &format!(
        "*NSET, NSET=Nend\n1, 2, 4, 5\n*NSET, NSET=Nanvil\n{}, {}, {}, {}\n*NSET, NSET=Nhead\n{a}, {b}\n*SURFACE, NAME=Cut\n1, S2\n\
         *SURFACE, NAME=Top\n5, S2\n*SURFACE, NAME=Head, TYPE=NODE\nNhead,\n*MATERIAL, NAME=M\n*ELASTIC\n1000., 0.3\n\
         *SOLID SECTION, ELSET=E, MATERIAL=M\n*SOLID SECTION, ELSET=Anvil, MATERIAL=M\n*SURFACE INTERACTION, NAME=Si\n\
         *CONTACT PAIR, INTERACTION=Si, TYPE=NODE TO SURFACE\nHead, Top\n*PRE-TENSION SECTION, SURFACE=Cut, NODE=99\n\
         *BOUNDARY\nNend, 1, 3\nNanvil, 1, 3\n{}",
        100 + at(1, 0, 1),
        100 + at(2, 0, 1),
        100 + at(1, 1, 1),
        100 + at(2, 1, 1),
        step("*CLOAD\n99, 1, 10.\n")
    );
    let run = solved(&text);
    is(pair_totals(&run.1, &run.0)[0].1.normal_force, 10.0, 10.0);
}

#[test]
fn friction_changes_at_the_beginning_of_a_step() {
    // Pressed by 10 and drawn by 4.9, which a coefficient of 0.3 would not hold.
    let change = "*CHANGE FRICTION, INTERACTION=SI\n*FRICTION\n0.5, 1.E5\n";
    let draw = "*CLOAD\nNtop, 1, 1.225\n*BOUNDARY\nNtop, 2, 2\n";
    let run = solved(&press("", &(step("") + &step(&format!("{change}{draw}")))));
    is(pair_totals(&run.1, &run.0)[0].1.tangential_force[0].abs(), 4.9, 4.9);
    let laws = &run.1.problem.contact.friction[..run.1.facts.points];
    assert!(laws.iter().all(|law| law.coefficient() == Some(0.5)), "{laws:?}");
    for (cards, word) in [
        ("*FRICTION\n0.5\n", "without *CHANGE FRICTION"),
        ("*CHANGE FRICTION, INTERACTION=NONE\n", "no *SURFACE INTERACTION NONE"),
        ("*CHANGE FRICTION, INTERACTION=SI\n*FRICTION, TAUMAX=3.\n0.5\n", "TAUMAX"),
    ] {
        let error = read(&press("", &step(cards))).unwrap_err();
        assert!(error.what.contains(word), "{error}");
    }
}
