//! Complete decks: every card against closed forms, what a case makes of it, and refusals with their line.
//!
//! The decks in `tests/data/decks` are two cubes of unit edge on top of each other, the lower one held at its bottom.

use stiction::fem::Field;
use stiction::io::case::{LoadKind, NodalSpec};
use stiction::io::deck::{self, Deck};
use stiction::run::{Outcome, Prepared, pair_totals};
use stiction_fixtures::case_run::{at, is, solved_case};

const PRESS: &str = include_str!("../data/decks/press.inp");
const STEPS: &str = include_str!("../data/decks/steps.inp");
const MATERIALS: &str = include_str!("../data/decks/materials.inp");

fn parse(text: &str) -> Result<Deck, stiction::Error> {
    deck::parse(text.as_bytes(), "deck.inp", &|name| Err(format!("there is no {name}")))
}

fn read(text: &str) -> Deck {
    parse(text).unwrap_or_else(|e| panic!("{e}"))
}

fn solved(text: &str) -> (Outcome, Prepared) {
    let deck = read(text);
    solved_case(&deck.case(&[]).unwrap_or_else(|e| panic!("{e}\n{}", deck.text)))
}

/// `text` with `old`, which it holds once, replaced.
fn with(text: &str, old: &str, new: &str) -> String {
    assert_eq!(text.matches(old).count(), 1, "{old:?}");
    text.replace(old, new)
}

/// Loads in the place of the pressure of `press.inp`.
fn loaded(cards: &str) -> String {
    with(PRESS, "*DLOAD\n2, P2, 10.\n", cards)
}

fn normal_force(run: &(Outcome, Prepared)) -> f64 {
    pair_totals(&run.1, &run.0)[0].1.normal_force
}

#[test]
fn a_pressed_column_is_shortened_by_pressure_times_length_over_modulus() {
    // The same pressure on the face of an element, on a surface, and as forces at the nodes of the top.
    let nodes: String = [15, 16, 17, 18].iter().map(|node| format!("{node}, 3, -2.5\n")).collect();
    for cards in [
        "*DLOAD\n2, P2, 10.\n".to_string(),
        "*DLOAD\nEhigh, P2, 4.\nEHIGH, p2, 6.\n".to_string(),
        "*DSLOAD\nstop, P, 10.\n".to_string(),
        "*CLOAD\nntop, 3, -2.5\n".to_string(),
        "*CLOAD\nNtop, 3, -2.\n*CLOAD\nNtop, 3, -.5\n".to_string(),
        format!("*CLOAD\n{nodes}"),
    ] {
        let run = solved(&loaded(&cards));
        is(at(&run, [0.0, 0.0, 2.0])[2], -0.02, 0.02);
        is(normal_force(&run), 10.0, 10.0);
    }
}

#[test]
fn forces_of_many_values_become_arrays_of_the_mesh_and_act_the_same() {
    // A top of 25 nodes, each with a force of its own, on a plate whose displacement tells them apart.
    let (mut text, mut forces) = ("*NODE\n".to_string(), String::new());
    let label = |i: usize, j: usize, k: usize| 1 + i + 5 * j + 25 * k;
    for k in 0..2 {
        for j in 0..5 {
            (0..5).for_each(|i| text += &format!("{}, {i}, {j}, {k}\n", label(i, j, k)));
        }
    }
    text += "*ELEMENT, TYPE=C3D8, ELSET=E\n";
    for (number, (i, j)) in (0..16).map(|n| (n % 4, n / 4)).enumerate() {
        let corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)];
        let nodes = corners.map(|(a, b, c)| label(i + a, j + b, c).to_string());
        text += &format!("{}, {}\n", number + 1, nodes.join(", "));
    }
    for (i, j) in (0..25).map(|n| (n % 5, n / 5)) {
        forces += &format!("{}, 3, -{}.\n{}, 1, {}.\n", label(i, j, 1), i + 5 * j + 1, label(i, j, 1), 2 * i);
    }
    text +=
        "*NSET, NSET=N0, GENERATE\n1, 25\n*MATERIAL, NAME=M\n*ELASTIC\n1E3, .3\n*SOLID SECTION, ELSET=E, MATERIAL=M\n";
    text += &format!("*BOUNDARY\nN0, 1, 3\n*STEP\n*STATIC\n*CLOAD\n{forces}*END STEP\n");
    let deck = read(&text);
    assert!(deck.text.contains("array") && deck.mesh.0.arrays.nodes.len() == 2, "{}", deck.text);
    let (_, prepared) = solved(&text);
    let load = &prepared.problem.labels.supports.as_ref().unwrap().free_load;
    for (n, f) in load.as_chunks::<3>().0.iter().enumerate() {
        assert_eq!(*f, [2.0 * (n % 5) as f64, 0.0, -(n as f64 + 1.0)], "{n}");
    }
    // Twice the time of a second step of the same forces takes nothing from them, and half the way is half of them.
    let twice = text.replace("*END STEP\n", "*END STEP\n*STEP\n*STATIC\n*END STEP\n");
    let case = read(&twice).case(&[]).unwrap();
    let LoadKind::Nodal([_, _, NodalSpec::Array { ramp, .. }]) = &case.loads[0].kind else { panic!() };
    assert_eq!([0.5, 1.0, 1.5, 2.0].map(|t| ramp.at([0.0; 3], t).abs()), [0.5, 1.0, 1.0, 1.0]);
}

#[test]
fn weight_and_rotation_stretch_a_column_as_in_closed_form() {
    // Weight per volume 2 * 5 along the column, whose lower half carries all of it and half of its own.
    let run = solved(&loaded("*DLOAD\nEall, GRAV, 5., 0., 0., -3.\n"));
    is(at(&run, [0.0, 0.0, 1.0])[2].min(-0.015), -0.015, 0.015);
    is(at(&run, [0.0, 0.0, 2.0])[2], -0.02, 0.02);
    is(normal_force(&run), 10.0, 10.0);
    // Turning about the x axis through the bottom: u = density speed² (L² z / 2 - z³ / 6) / modulus.
    let glued =
        with(&loaded("*DLOAD\nEall, CENTRIF, 4., 0., 0., 0., 1., 0., 0.\n"), "*BOUNDARY\n", "*BOUNDARY\nNall, 2\n");
    let pair = "*CONTACT PAIR, INTERACTION=SI, TYPE=SURFACE TO SURFACE\n";
    let run = solved(&with(&glued, pair, "*TIE, NAME=Glue\n"));
    is(at(&run, [0.0, 0.0, 2.0])[2], 2.0 * 4.0 * (4.0 - 8.0 / 6.0) / 1000.0, 0.02);
}

#[test]
fn a_heated_column_grows_by_expansion_times_the_rise_of_its_temperature() {
    let initial = "*INITIAL CONDITIONS, TYPE=TEMPERATURE\nNall, 20.\n*STEP\n";
    let sides = "*BOUNDARY\nNall, 1, 2\n";
    let heated = |cards: &str| with(&with(&loaded(cards), "*STEP\n", initial), "*BOUNDARY\n", sides);
    is(at(&solved(&heated("*TEMPERATURE\nNall, 50.\n")), [0.0, 0.0, 2.0])[2], 0.06, 0.06);
    // Only the upper cube: an array of the mesh, from the same initial temperature and from different ones.
    let high = "*TEMPERATURE\n11, 50.\n12, 50.\n13, 50.\n14, 50.\nNtop, 50.\n";
    is(at(&solved(&heated(high)), [0.0, 0.0, 2.0])[2], 0.03, 0.03);
    let differs = with(&heated(high), "Nall, 20.\n", "Nall, 20.\nNtop, 30.\n");
    is(at(&solved(&differs), [0.0, 0.0, 2.0])[2], 0.025, 0.025);
}

#[test]
fn friction_holds_below_its_coefficient_times_the_pressure_and_slips_above() {
    // Pressed by 10, then drawn along x by less and by more than 0.3 * 10: below nothing slips, above nothing resists.
    let drawn = |force: f64| {
        let more =
            format!("*END STEP\n*STEP\n*STATIC\n*CLOAD\nNtop, 1, {}\n*BOUNDARY\nNtop, 2, 2\n*END STEP\n", force / 4.0);
        read(&with(PRESS, "*END STEP\n", &more)).case(&[]).unwrap()
    };
    let run = solved_case(&drawn(2.9));
    let pair = &pair_totals(&run.1, &run.0)[0].1;
    is(pair.tangential_force[0].abs(), 2.9, 2.9);
    let case = drawn(3.1);
    let mut prepared = stiction::run::prepare(&case).unwrap();
    let settings = stiction::run::Settings::of(&case.solver);
    let go_on = &mut |_: &stiction::run::Event| std::ops::ControlFlow::Continue(());
    let outcome = stiction::run::solve_steps(&mut prepared, &settings, None, &mut |_, _| Ok(()), go_on).unwrap();
    assert_eq!(outcome.solution.status, stiction::Status::NoEquilibrium);
}

#[test]
fn a_clearance_is_closed_before_anything_is_pressed() {
    let clear = |value: &str| {
        let card = format!("*CLEARANCE, SLAVE=shigh, MASTER=slow, VALUE={value}\n*BOUNDARY\n");
        let drop = with(&with(PRESS, "*BOUNDARY\n", &card), "2, P2, 10.\n", "2, P2, 0.\n");
        with(&drop, "*DLOAD\n", "*BOUNDARY\nNtop, 1, 2\nNtop, 3, 3, -0.02\n*DLOAD\n")
    };
    // The top comes down by 0.02, of which the gap takes its part: force = modulus (0.02 - gap) / 2.
    is(normal_force(&solved(&clear("0.005"))), 7.5, 7.5);
    is(normal_force(&solved(&clear("-0.005"))), 12.5, 12.5);
}

#[test]
fn adjust_closes_gaps_and_overlaps_within_its_length_and_no_others() {
    // The upper cube begins at `z`; the top comes down by 0.02 on a column of 1 and 2 - z.
    let apart = |z: f64, adjust: &str| {
        let mut text = with(PRESS, "TYPE=SURFACE TO SURFACE\n", &format!("TYPE=SURFACE TO SURFACE, ADJUST={adjust}\n"));
        for (node, place) in [(11, "0., 0."), (12, "1., 0."), (13, "1., 1."), (14, "0., 1.")] {
            text = with(&text, &format!("\n{node}, {place}, 1.\n"), &format!("\n{node}, {place}, {z}\n"));
        }
        let text = with(&text, "*DLOAD\n2, P2, 10.\n", "*BOUNDARY\nNall, 1, 2\nNtop, 3, 3, -0.02\n");
        solved(
            &text
                .replace("*STEP\n", "*NSET, NSET=Nslave\n11, 12, 13, 14\n*STEP\n")
                .replace("ADJUST=all", "ADJUST=nslave"),
        )
    };
    let force = |gap: f64, z: f64| 1000.0 * (0.02 - gap) / (3.0 - z);
    for (z, adjust, gap) in [
        (1.004, "0.005", 0.0),
        (1.004, "0.003", 0.004),
        (1.004, "0.", 0.004),
        (1.004, "all", 0.0),
        (0.996, "0.001", 0.0),
        (0.996, "0.", 0.0),
    ] {
        is(normal_force(&apart(z, adjust)), force(gap, z), force(0.0, z));
    }
}

#[test]
fn values_follow_steps_amplitudes_and_op_new() {
    let case = read(STEPS).case(&[]).unwrap();
    let steps: Vec<(f64, usize)> = case.steps.iter().map(|step| (step.until, step.increments)).collect();
    // The second step grows from 1 by half: two increments reach 2. The third has one.
    assert_eq!(steps, [(1.0, 2), (3.0, 2), (4.0, 1)]);
    assert_eq!(case.steps[0].name, "press");
    let at = |field: &Field, t: f64| field.at([0.0; 3], t);
    let over = |field: &Field, times: &[f64]| times.iter().map(|&t| at(field, t)).collect::<Vec<f64>>();
    let nodal = |spec: &NodalSpec| match spec {
        NodalSpec::Field(field) => field.clone(),
        NodalSpec::Array { .. } => panic!(),
    };
    let mut seen = 0;
    for load in &case.loads {
        match &load.kind {
            LoadKind::Nodal([x, _, z]) => {
                // -2 and -0.5 of one step add up; the next step leads on from there.
                assert_eq!(over(&nodal(z), &[0.5, 1.0, 2.0, 3.0, 4.0]), [-1.25, -2.5, -4.25, -6.0, -6.0]);
                let end = at(&nodal(x), 3.0);
                assert!(end == 1.0 || end == 1.5, "{end}");
                assert_eq!(over(&nodal(x), &[1.0, 2.0, 4.0]), [0.0, end / 2.0, end]);
                seen += 1;
            }
            LoadKind::Pressure(p) => {
                // What it is at the end of the first step it stays in the second, and OP=NEW of the third ends it.
                let wanted = [4.0, 8.0, 4.0, 4.0, 4.0, 4.0, 0.0];
                assert_eq!(over(p, &[0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0]), wanted);
                seen += 1;
            }
            LoadKind::Gravity([_, _, z]) if at(z, 1.0) != 0.0 => {
                assert_eq!(over(z, &[0.5, 1.0, 3.0, 3.5, 4.0]), [-2.5, -5.0, -5.0, -2.5, 0.0]);
                seen += 1;
            }
            LoadKind::Gravity([_, _, z]) => {
                assert_eq!(over(z, &[2.0, 3.0, 4.0]), [0.0, -1.5, 0.0]);
                seen += 1;
            }
            LoadKind::Rotation { speed, .. } => {
                // AMPLITUDE=STEP: at once.
                assert_eq!(over(speed, &[3.0, 3.1, 4.0]), [0.0, 2.0, 2.0]);
                seen += 1;
            }
            other => panic!("{other:?}"),
        }
    }
    assert_eq!(seen, 6);
    let top = case.fixes.iter().find(|fix| fix.value[0].is_none()).unwrap();
    assert_eq!(over(top.value[1].as_ref().unwrap(), &[1.0, 2.0, 3.0, 4.0]), [0.0, 0.125, 0.25, 0.25]);
    // One value at the end of a step that ends at 1: no load steps, and numbers only.
    let single = read(&with(PRESS, "0.3, 1.E5\n", "0.\n"));
    assert!(!single.text.contains("[[step]]") && single.text.contains("pressure = 10\n"), "{}", single.text);
}

#[test]
fn constants_of_the_stiffness_are_those_of_the_engineer_and_axes_are_read() {
    let case = read(MATERIALS).case(&[]).unwrap();
    let of = |name: &str| &case.materials.iter().find(|m| m.material.name == name).unwrap().material;
    // Lamé's constants 400 and 400: modulus 1000, Poisson's ratio 0.25, shear modulus 400.
    let stiff = of("Stiff").orthotropic.clone().unwrap();
    for k in 0..3 {
        is(stiff.young[k], 1000.0, 1000.0);
        is(stiff.poisson[k], 0.25, 1.0);
        is(stiff.shear[k], 400.0, 400.0);
    }
    let ply = of("Ply").orthotropic.clone().unwrap();
    assert_eq!([ply.young, ply.poisson, ply.shear], [[1000.0, 2000.0, 3000.0], [0.1, 0.2, 0.3], [400.0, 500.0, 600.0]]);
    assert_eq!(of("Ply").reference_temperature, 20.0);
    let run = solved(MATERIALS);
    // Tied bodies are one: at the border the displacements of both agree.
    let low = run.1.mesh.nodes.iter().take(8).filter(|x| x[2] == 1.0).count();
    assert_eq!(low, 4);
}

#[test]
fn names_have_no_case_cards_that_change_nothing_are_named_and_regularisation_is_noted() {
    let deck = read(PRESS);
    let all = deck.notes.join("\n");
    for word in ["*NODE PRINT", "*NODE FILE", "*EL FILE", "*CONTACT FILE", "1000000", "stick slope 100000"] {
        assert!(all.contains(word), "{word}: {all}");
    }
    let large = read(&with(PRESS, "*STEP\n", "*STEP, NLGEOM\n"));
    assert!(large.notes.iter().any(|note| note.starts_with("NLGEOM")), "{:?}", large.notes);
    assert_eq!(deck.case(&[]).unwrap().title, "Two cubes, one pressed onto the other");
    // What a case file allows, a deck allows: overrides, with their own messages.
    let changed = [("contact.0.friction.coulomb".to_string(), "0.7".to_string())];
    assert!(format!("{:?}", deck.case(&changed).unwrap().contacts[0].friction).contains("0.7"));
}

#[test]
fn includes_are_followed_and_a_title_may_stand_above_the_first_keyword() {
    let cut = PRESS.find("*MATERIAL").unwrap();
    let text = format!("> made by hand\n{}*INCLUDE, INPUT=model.inp\n", &PRESS[..cut]);
    let include = |name: &str| if name == "model.inp" { Ok(PRESS[cut..].into()) } else { Err("no".to_string()) };
    let deck = deck::parse(text.as_bytes(), "deck.inp", &include).unwrap();
    is(at(&solved_case(&deck.case(&[]).unwrap()), [0.0, 0.0, 2.0])[2], -0.02, 0.02);
    // An error in the included file names it.
    let broken = |_: &str| Ok(with(&PRESS[cut..], "*DENSITY\n2.", "*DENSITY\nx").into());
    let error = deck::parse(text.as_bytes(), "deck.inp", &broken).unwrap_err();
    assert_eq!(error.place, "deck.inp, model.inp, line 5", "{error}");
}

#[test]
fn temperatures_of_nodes_without_elements_change_nothing_and_are_noted() {
    let heated = loaded("*TEMPERATURE\n99, 50.\n");
    let text = with(&heated, "18, 0., 1., 2.\n", "18, 0., 1., 2.\n99, 9., 9., 9.\n");
    let deck = read(&text);
    assert!(!deck.text.contains("\ntemperature"), "{}", deck.text);
    assert!(
        deck.notes.iter().any(|note| note.contains("*TEMPERATURE names nodes of no solid element")),
        "{:?}",
        deck.notes
    );
}

/// What is replaced in `press.inp`, by what, the line the message has to name (0 for any), and a word of it.
const REFUSALS: &[(&str, &str, &str, &str)] = &[
    ("1000., 0.\n", "1000., 0.\n*PLASTIC\n5., 0.\n", "*PLASTIC", "plastic material"),
    ("*DENSITY\n", "*HYPERELASTIC, NEO HOOKE\n1., 1.\n*DENSITY\n", "*HYPERELASTIC", "not linear elastic"),
    ("*DENSITY\n2.\n", "*DENSITY, DEPENDENCIES=1\n2.\n", "*DENSITY", "DEPENDENCIES"),
    ("1000., 0.\n", "1000., x\n", "1000., x", "a number"),
    ("1000., 0.\n", "1000.\n", "1000.", "Poisson's ratio"),
    ("MATERIAL=SOFT", "MATERIAL=HARD", "*SOLID SECTION", "no *MATERIAL HARD"),
    ("ELSET=Eall, MATERIAL=SOFT", "ELSET=Enone, MATERIAL=SOFT", "*SOLID SECTION", "Enone"),
    ("*ELASTIC\n", "*ELASTIC, TYPE=ANISO\n", "*ELASTIC", "ANISO"),
    ("PRESSURE-OVERCLOSURE=LINEAR", "PRESSURE-OVERCLOSURE=MAGIC", "*SURFACE BEHAVIOR", "MAGIC"),
    ("*FRICTION\n", "*FRICTION, ROUGH\n", "*FRICTION", "ROUGH"),
    ("0.3, 1.E5\n", "-0.3, 1.E5\n", "*FRICTION", "at least zero"),
    ("INTERACTION=SI,", "INTERACTION=NONE,", "Shigh, Slow", "NONE"),
    ("TYPE=SURFACE TO SURFACE\n", "TYPE=SURFACE TO SURFACE, ADJUST=Ntop\n", "*CONTACT PAIR", "no corner of"),
    ("TYPE=SURFACE TO SURFACE\n", "TYPE=SURFACE TO SURFACE, ADJUST=-1.\n", "*CONTACT PAIR", "no length"),
    ("Shigh, Slow\n", "Shigh, Snone\n", "Shigh, Snone", "no *SURFACE Snone"),
    ("NBOTTOM, 1, 3\n", "Nnone, 1, 3\n", "Nnone, 1, 3", "no node set Nnone"),
    ("NBOTTOM, 1, 3\n", "NBOTTOM, 11, 11, 5.\n", "NBOTTOM, 11, 11, 5.", "temperature"),
    ("NBOTTOM, 1, 3\n", "99, 1, 3\n", "99, 1, 3", "no node 99"),
    ("*BOUNDARY\n", "*BOUNDARY, USER\n", "*BOUNDARY", "subroutine"),
    ("*BOUNDARY\n", "*BOUNDARY, AMPLITUDE=A\n", "*BOUNDARY", "no *AMPLITUDE A"),
    ("*BOUNDARY\n", "*EQUATION\n2\n1, 1, 1.\n*BOUNDARY\n", "*EQUATION", "1 terms are missing"),
    ("*BOUNDARY\n", "*EQUATION\n1\n1, 1, 1., 2, 1, -1.\n*BOUNDARY\n", "1, 1, 1., 2", "more terms than it says"),
    ("*BOUNDARY\n", "*EQUATION\n1\nNtop, 1, 1.\n*BOUNDARY\n", "Ntop, 1, 1.", "stands for 4 nodes"),
    ("*BOUNDARY\n", "*MPC\nPLANE, 1, 2, 3, 4\n*BOUNDARY\n", "*MPC", "*EQUATION"),
    ("*BOUNDARY\n", "*RIGID BODY, NSET=Ntop, REF NODE=1\n*BOUNDARY\n", "*RIGID BODY", "belongs to an element"),
    ("*BOUNDARY\n", "*RIGID BODY, REF NODE=1\n*BOUNDARY\n", "*RIGID BODY", "neither NSET= nor ELSET="),
    ("*BOUNDARY\n", "*RIGID BODY, NSET=Ntop\n*BOUNDARY\n", "*RIGID BODY", "no REF NODE="),
    ("*BOUNDARY\n", "*KINEMATIC\n1, 3\n*BOUNDARY\n", "*KINEMATIC", "under no *COUPLING"),
    ("*BOUNDARY\n", "*COUPLING, REF NODE=1, SURFACE=Stop\n*BOUNDARY\n", "*COUPLING", "not followed by"),
    ("*BOUNDARY\n", "*DISTRIBUTING COUPLING, ELSET=Es\n1, 1.\n*BOUNDARY\n", "*DISTRIBUTING COUPLING", "lists of nodes"),
    (
        "*BOUNDARY\n",
        "*TIE, NAME=T, CYCLIC SYMMETRY\nSlow, Shigh\n*BOUNDARY\n",
        "Slow, Shigh",
        "no *CYCLIC SYMMETRY MODEL belongs to the tie T",
    ),
    (
        "*BOUNDARY\n",
        "*CYCLIC SYMMETRY MODEL, N=4\n0., 0., 0., 0., 0., 1.\n*BOUNDARY\n",
        "*CYCLIC SYMMETRY MODEL",
        "no *TIE, CYCLIC SYMMETRY",
    ),
    (
        "*BOUNDARY\n",
        "*CYCLIC SYMMETRY MODEL, N=1\n0., 0., 0., 0., 0., 1.\n*BOUNDARY\n",
        "*CYCLIC SYMMETRY MODEL",
        "no number of sectors",
    ),
    ("*BOUNDARY\n", "*FOO BAR\n*BOUNDARY\n", "*FOO BAR", "not read"),
    ("*BOUNDARY\n", "*ELEMENT, TYPE=SPRINGA, ELSET=Es\n3, 1, 11\n*BOUNDARY\n", "*ELEMENT, TYPE=SPRINGA", "SPRINGA"),
    ("*STATIC\n", "*DYNAMIC\n", "*DYNAMIC", "dynamics"),
    ("*STATIC\n1., 1.\n", "", "*STEP", "no *STATIC"),
    ("*STEP\n", "*STEP, PERTURBATION\n", "*STEP", "PERTURBATION"),
    ("*END STEP\n", "", "*STEP", "no *END STEP"),
    ("2, P2, 10.\n", "2, P7, 10.\n", "2, P7, 10.", "P7"),
    ("2, P2, 10.\n", "2, P2\n", "2, P2", "pressure is missing"),
    ("2, P2, 10.\n", "9, P2, 10.\n", "9, P2, 10.", "no element 9"),
    ("2, P2, 10.\n", "Eall, GRAV, 5., 0., 0., 0.\n", "Eall, GRAV, 5., 0., 0., 0.", "no direction"),
    ("*DLOAD\n", "*CLOAD\nNtop, 4, 1.\n*DLOAD\n", "Ntop, 4, 1.", "moment"),
    ("*DLOAD\n", "*CFLUX\nNtop, 11, 1.\n*DLOAD\n", "*CFLUX", "heat"),
    ("*STATIC\n1., 1.\n", "*STATIC, DIRECT\n1e-9, 1.\n", "*STATIC, DIRECT", "increments"),
    ("*NODE FILE\nU\n", "*SURFACE BEHAVIOR, DIRECT\n", "*SURFACE BEHAVIOR, DIRECT", "without *CHANGE SURFACE BEHAVIOR"),
    (
        "*NODE FILE\nU\n",
        "*CHANGE SURFACE BEHAVIOR, INTERACTION=SI\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TIED\n",
        "*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=TIED",
        "changes to PRESSURE-OVERCLOSURE=TIED",
    ),
    ("*NODE FILE\nU\n", "*CHANGE SURFACE BEHAVIOR, INTERACTION=SX\n", "*CHANGE SURFACE", "no *SURFACE INTERACTION SX"),
    ("*NODE FILE\nU\n", "*NODE FILE\nU\n*MODEL CHANGE, TYPE=CONTACT PAIR\n", "*MODEL CHANGE", "neither ADD nor REMOVE"),
    ("*NODE FILE\nU\n", "*NODE FILE\nU\n*MODEL CHANGE, TYPE=ELEMENT, REMOVE\n", "*MODEL CHANGE", "TYPE=ELEMENT"),
    (
        "*NODE FILE\nU\n",
        "*NODE FILE\nU\n*MODEL CHANGE, TYPE=CONTACT PAIR, REMOVE\nSlow, Shigh\n",
        "Slow, Shigh",
        "the slave Slow",
    ),
];

#[test]
fn what_cannot_be_read_is_refused_with_its_line_and_a_remedy() {
    for (old, new, line, word) in REFUSALS {
        let text = with(PRESS, old, new);
        let deck = parse(&text).and_then(|deck| deck.case(&[]).map(|_| ()));
        let error = deck.expect_err(new);
        let number = 1 + text.lines().position(|l| l.starts_with(line)).unwrap_or_else(|| panic!("{line}"));
        assert_eq!(error.place, format!("deck.inp, line {number}"), "{error}");
        assert!(error.to_string().contains(word), "{word:?}: {error}");
        assert!(!error.remedy.is_empty() && error.excerpt.contains(&line[..line.len().min(8)]), "{error}");
    }
    // A mesh alone poses nothing, and an error of a later stage stands at the line of the deck as well.
    let error = parse(&PRESS[..PRESS.find("*MATERIAL").unwrap()]).unwrap_err();
    assert!(error.what.contains("no *STEP") && error.place == "deck.inp", "{error}");
    let flat = with(PRESS, "NBOTTOM, 1, 3\n", "NBOTTOM, 1, 3\nNall, 1, 3\n");
    let error = stiction::run::prepare(&read(&flat).case(&[]).unwrap()).unwrap_err();
    assert!(error.place.starts_with("deck.inp, line"), "{error}");
    let weightless = with(&loaded("*DLOAD\nEall, GRAV, 5., 0., 0., -1.\n"), "*DENSITY\n2.\n", "");
    let error = read(&weightless).case(&[]).unwrap_err();
    assert!(error.place.starts_with("deck.inp, line") && error.excerpt.contains("GRAV"), "{error}");
}
