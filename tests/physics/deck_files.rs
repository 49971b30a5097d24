//! The decks in `tests/data/decks`, each against its closed form: columns of unit cubes with a modulus of 1000, shortened
//! by the pressure times their length over it.

use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::path::PathBuf;

use stiction::io::{case, deck};
use stiction::linalg::Stop;
use stiction::run::{Outcome, Plan, Prepared, Stage, pair_totals, solve_case};
use stiction_fixtures::case_run::{at, is, solved_case};

const READER: &str = include_str!("../../crates/stiction/src/io/deck/reader.rs");

/// A file, the normal force of each contact, and displacements: of the node at a place, along an axis.
type Wanted = (&'static str, &'static [f64], &'static [([f64; 3], usize, f64)]);

/// Plane strain: `p (1 - poisson²) / young`, and `poisson (1 + poisson)` of `p / young` across.
const WANTED: &[Wanted] = &[
    ("tetrahedra", &[10.0], &[([1.0, 0.0, 2.0], 2, -0.02), ([1.0, 0.0, 1.0], 2, -0.01)]),
    ("hexahedra", &[10.0], &[([1.0, 0.0, 2.0], 2, -0.02), ([0.5, 0.0, 1.0], 2, -0.01)]),
    ("prisms", &[10.0], &[([1.0, 0.0, 2.0], 2, -0.02), ([1.0, 0.0, 1.0], 2, -0.01)]),
    // Weight 10 per volume, and 5 on the top.
    ("weight", &[15.0], &[([1.0, 1.0, 2.0], 2, -0.03), ([1.0, 1.0, 1.0], 2, -0.02)]),
    ("heated", &[10.0], &[([1.0, 1.0, 1.0], 2, 0.0)]),
    ("tied", &[-10.0], &[]),
    ("laws", &[10.0; 3], &[([1.0, 1.0, 2.0], 2, -0.02), ([5.0, 1.0, 2.0], 2, -0.02)]),
    ("changed-law", &[20.0], &[([1.0, 1.0, 2.0], 2, -0.04)]),
    // Pulled by 10 while it is tied, apart, then pressed.
    ("freed", &[10.0], &[([1.0, 1.0, 2.0], 2, -0.02), ([1.0, 1.0, 1.0], 2, -0.01)]),
    ("changed-friction", &[10.0], &[]),
    ("adjusted", &[10.0], &[([1.0, 1.0, 2.004], 2, -0.02)]),
    // The second column stays open.
    ("adjusted-set", &[1.0], &[([0.0, 0.0, 1.004], 2, -0.001), ([2.0, 0.0, 1.004], 2, -0.002)]),
    ("clearance", &[10.0], &[([0.0, 0.0, 1.004], 2, -0.02)]),
    // The lower cube is held; two corners carry the force of four.
    ("nodes", &[10.0], &[([0.0, 1.0, 2.0], 2, -0.01), ([0.0, 1.0, 1.0], 2, 0.0)]),
    // The upper one is stretched, the one in its place compressed.
    ("lining", &[-10.0], &[([1.0, 1.0, 0.0], 2, 0.01)]),
    ("turned", &[10.0], &[]),
    // Poisson's ratio 0.25: 10/1000/4 per length across.
    ("sector", &[10.0], &[([1.0, 0.0, 2.0], 2, -0.02), ([1.0, 1.0, 2.0], 0, 0.0025), ([0.0, 1.0, 2.0], 1, 0.0025)]),
    ("equations", &[10.0], &[([1.0, 0.0, 2.0], 2, -0.02), ([0.0, 1.0, 2.0], 2, -0.02)]),
    // Tightened by 10, then drawn by a thousandth of its length; the nodes of the cut go with the upper elements.
    ("bolt", &[], &[([0.0, 0.0, 1.0], 2, -0.019)]),
    ("spread", &[10.0], &[([1.0, 0.0, 2.0], 2, -0.02)]),
    ("held", &[10.0], &[([1.0, 0.0, 2.0], 2, -0.02)]),
    // The upper cube has a modulus of 500 along its first axis, which is z.
    ("sections-first", &[10.0], &[([1.0, 0.0, 2.0], 2, -0.03), ([1.0, 0.0, 1.0], 2, -0.01)]),
    ("printed", &[10.0], &[([1.0, 0.0, 2.0], 2, -0.02)]),
    ("plane-strain", &[20.0], &[([1.0, 2.0, 0.0], 1, -0.01875), ([1.0, 2.0, 0.0], 0, 0.003125)]),
    // A layer of 1/20 of the edge.
    ("plane-stress", &[0.5], &[([1.0, 2.0, 0.0], 1, -0.02), ([1.0, 2.0, 0.0], 0, 0.0025)]),
    ("parts", &[10.0], &[([1.0, 0.0, 2.0], 2, -0.02)]),
    ("kinds-of-pairs", &[10.0; 3], &[([1.0, 0.0, 2.0], 2, -0.02), ([5.0, 1.0, 2.0], 2, -0.02)]),
    ("included", &[10.0], &[([1.0, 0.0, 2.0], 2, -0.02)]),
];

fn folder() -> PathBuf {
    [env!("CARGO_MANIFEST_DIR"), "data", "decks"].iter().collect()
}

fn solved(name: &str) -> (Outcome, Prepared) {
    let deck = deck::read(&folder().join(format!("{name}.inp")), &[]).unwrap_or_else(|e| panic!("{e}"));
    solved_case(&deck.case(&[]).unwrap_or_else(|e| panic!("{e}\n{}", deck.text)))
}

#[test]
fn the_decks_end_where_their_closed_forms_say() {
    for &(name, forces, places) in WANTED {
        let run = solved(name);
        let totals = pair_totals(&run.1, &run.0);
        assert_eq!(totals.len(), forces.len(), "{name}");
        for (total, &force) in totals.iter().zip(forces) {
            assert!((total.1.normal_force - force).abs() < 1e-7 * force.abs(), "{name}: {}", total.1.normal_force);
        }
        for &(place, axis, value) in places {
            let u = at(&run, place)[axis];
            assert!((u - value).abs() < 1e-9, "{name} {place:?}: {u} for {value}");
        }
    }
}

/// What sets of the deck hold that share nodes is held between these on finer meshes: confined, two cubes have the modulus
/// `young (1 - poisson) / (1 + poisson) / (1 - 2 poisson)`, 1200, on all of them.
#[test]
fn supports_of_sets_that_share_nodes_hold_on_finer_meshes() {
    let press = std::fs::read_to_string(folder().join("press.inp")).unwrap();
    let confined = press
        .replace("1000., 0.\n", "1000., 0.25\n")
        .replace("NBOTTOM, 1, 3\n", "NBOTTOM, 3\nNall, 1\nNall, 2\nNtop, 3, 3, -0.02\n")
        .replace("*DLOAD\n2, P2, 10.\n", "");
    let sides =
        "*NSET, NSET=Nx\n1, 4, 5, 8, 11, 14, 15, 18\n*NSET, NSET=Ny\n1, 2, 5, 6, 11, 12, 15, 16\n*SURFACE, NAME=Slow";
    let guided = confined.replace("Nall, 1\nNall, 2", "Nx, 1\nNy, 2").replace("*SURFACE, NAME=Slow", sides);
    // Free to grow across, by poisson times 0.02 / 2.
    for (text, modulus, across) in [(&confined, 1200.0, 0.0), (&guided, 1000.0, 0.0025)] {
        let deck = deck::parse(text.as_bytes(), "deck.inp", &|name| Err(format!("there is no {name}"))).unwrap();
        let case = deck.case(&[("accuracy.energy".into(), "0.01".into())]).unwrap();
        let go_on = &mut |_: Stage| ControlFlow::Continue(());
        let (prepared, outcome, _) = solve_case(&case, &Plan::default(), &Stop::never(), None, go_on).unwrap();
        assert!(prepared.mesh.nodes.len() > 16 && outcome.accuracy.as_ref().is_some_and(|of| of.reached));
        let run = (outcome, prepared);
        is(pair_totals(&run.1, &run.0)[0].1.normal_force, modulus * 0.01, 1e2 * 12.0);
        for (place, u) in [([1.0, 1.0, 2.0], [across, across, -0.02]), ([1.0, 1.0, 0.5], [across, across, -0.005])] {
            (0..3).for_each(|c| is(at(&run, place)[c], u[c], 1.0));
        }
    }
}

/// Nodes of which each has a value of its own hold nothing between them: a note says so, and none of two supports on one layer of cells.
#[test]
fn supports_of_single_nodes_are_told_where_the_mesh_is_refined() {
    let press = std::fs::read_to_string(folder().join("press.inp")).unwrap();
    let top = |values: [&str; 4]| {
        let rows: String =
            [15, 16, 17, 18].iter().zip(values).map(|(node, value)| format!("{node}, 3, 3, {value}\n")).collect();
        let text =
            press.replace("NBOTTOM, 1, 3\n", &format!("NBOTTOM, 1, 3\n{rows}")).replace("*DLOAD\n2, P2, 10.\n", "");
        let deck = deck::parse(text.as_bytes(), "deck.inp", &|name| Err(format!("there is no {name}"))).unwrap();
        let case = deck.case(&[("accuracy.energy".into(), "0.5".into())]).unwrap();
        let mut told = false;
        let mut tell = |stage: Stage| {
            if let Stage::Posed(facts, _) = stage {
                told |= facts
                    .notes
                    .iter()
                    .any(|note| note.contains("at 1 face the corners are held by different supports"));
            }
            ControlFlow::Continue(())
        };
        solve_case(&case, &Plan::default(), &Stop::never(), None, &mut tell).unwrap();
        told
    };
    assert!(top(["-0.01", "-0.011", "-0.012", "-0.013"]));
    assert!(!top(["-0.01"; 4]) && !top(["-0.01", "-0.01", "-0.012", "-0.012"]));
}

#[test]
fn nodes_meet_a_surface_by_themselves_on_both_paths() {
    let deck = deck::read(&folder().join("nodes.inp"), &[]).unwrap_or_else(|e| panic!("{e}"));
    for path in ["\"dense\"", "\"multigrid\""] {
        let run = solved_case(&deck.case(&[("solver.path".into(), path.into())]).unwrap());
        assert_eq!(run.1.facts.contacts[0].surface.nodes.len(), 2, "{path}");
        // Ten on two corners that stand on two corners of the other cube.
        let forces = &run.0.solution.lambda[..2];
        assert!(forces.iter().all(|force| (force - 5.0).abs() < 1e-7), "{path}: {forces:?}");
    }
}

#[test]
fn shear_forces_of_the_decks_balance_what_draws() {
    let [half, four] = [4.0 * 0.7 / 2f64.sqrt(), 4.0 * 1.225];
    for (name, wanted) in [("turned", [half, half]), ("changed-friction", [four, 0.0]), ("tied", [1.0, 0.0])] {
        let run = solved(name);
        let friction = pair_totals(&run.1, &run.0)[0].1.tangential_force;
        (0..2).for_each(|c| is(friction[c], -wanted[c], four));
    }
}

#[test]
fn every_card_that_is_read_stands_in_a_deck() {
    let plain = |text: &str| text.to_uppercase().replace([' ', '-', '*'], "");
    let mut files = 0;
    let mut cards = BTreeSet::new();
    for entry in std::fs::read_dir(folder()).unwrap() {
        let text = std::fs::read_to_string(entry.unwrap().path()).unwrap();
        let heads = text.lines().filter(|line| line.starts_with('*') && !line.starts_with("**"));
        cards.extend(heads.map(|line| plain(line.split(',').next().unwrap_or(""))));
        files += 1;
    }
    assert!(files >= 30, "{files}");
    let (_, arms) = READER.split_once("match name {").unwrap();
    let (arms, _) = arms.split_once("_ if HARMLESS").unwrap();
    let mut known: Vec<String> = arms.split('"').skip(1).step_by(2).map(plain).collect();
    known.retain(|word| word != "READ" && word.chars().all(char::is_alphabetic));
    assert!(known.len() > 30, "{known:?}");
    let meshes = ["NODE", "ELEMENT", "NSET", "ELSET", "SURFACE", "PART", "INSTANCE", "ASSEMBLY", "INCLUDE"];
    let missing: Vec<&str> = known.iter().map(String::as_str).chain(meshes).filter(|c| !cards.contains(*c)).collect();
    assert!(missing.is_empty(), "no deck of tests/data/decks has {missing:?}");
}

/// A row of four cubes on the ground, refined; whether a note says that nothing holds between the sets of nodes `sets`, on one face.
fn told_of_sets(name: &str, sets: [&dyn Fn([usize; 3]) -> bool; 2]) -> bool {
    let number = |[i, j, k]: [usize; 3]| 1 + i + 5 * (j + 2 * k);
    let nodes: Vec<[usize; 3]> = (0..20).map(|v| [v % 5, v / 5 % 2, v / 10]).collect();
    let mut mesh = "*NODE\n".to_string();
    nodes.iter().for_each(|&[i, j, k]| mesh += &format!("{}, {i}, {j}, {k}\n", number([i, j, k])));
    mesh += "*ELEMENT, TYPE=C3D8, ELSET=Eall\n";
    for i in 0..4 {
        let corners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]];
        let list = corners.map(|[x, y, z]| number([i + x, y, z]).to_string()).join(", ");
        mesh += &format!("{}, {list}\n", i + 1);
    }
    for (name, is_in) in ["A", "B"].iter().zip(sets) {
        let list: Vec<String> = nodes.iter().filter(|v| is_in(**v)).map(|v| number(*v).to_string()).collect();
        mesh += &format!("*NSET, NSET={name}\n{}\n", list.join(",\n"));
    }
    let folder = std::env::temp_dir().join(format!("stiction-sets-{}-{name}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    std::fs::write(folder.join("row.inp"), mesh).unwrap();
    let text = "[mesh]\nfile = \"row.inp\"\n[materials.steel]\nyoung = 1000\npoisson = 0.3\ndensity = 1\n\
                [[fix]]\non = \"A\"\n[[fix]]\non = \"B\"\n[[load]]\ngravity = [0, 0, -1]\n[accuracy]\nenergy = 0.5\n";
    let path = folder.join("case.toml");
    std::fs::write(&path, text).unwrap();
    let case = case::read(&path, &[]).unwrap_or_else(|e| panic!("{e}"));
    let mut told = false;
    let mut tell = |stage: Stage| {
        if let Stage::Posed(facts, _) = stage {
            told |=
                facts.notes.iter().any(|note| note.contains("at 1 face the corners are held by different supports"));
        }
        ControlFlow::Continue(())
    };
    solve_case(&case, &Plan::default(), &Stop::never(), None, &mut tell).unwrap();
    std::fs::remove_dir_all(folder).unwrap();
    told
}

/// Two sets of nodes of one surface that share no node hold nothing between them; where they share some they do, and sets of two surfaces
/// of a layer of cells are not meant to.
#[test]
fn disjoint_sets_of_one_surface_are_told_where_the_mesh_is_refined() {
    assert!(told_of_sets("apart", [&|[i, _, k]| k == 0 && i < 2, &|[i, _, k]| k == 0 && i > 1]));
    assert!(!told_of_sets("joined", [&|[i, _, k]| k == 0 && i < 3, &|[i, _, k]| k == 0 && i > 1]));
    assert!(!told_of_sets("two", [&|[_, _, k]| k == 0, &|[_, _, k]| k == 1]));
}
