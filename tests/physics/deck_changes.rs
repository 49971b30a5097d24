//! Cards of decks that release supports, take contact pairs out, and move nodes with a reference point.
//!
//! CalculiX 2.20 gives the same for each of them, but for the overlap pressure/1e6 of its contact.

use stiction::io::deck::{self, Deck};
use stiction::run::{CouplingState, Outcome, Prepared, coupling_states, pair_totals};
use stiction_fixtures::case_run::{at, is, solved_case, stress};

const PRESS: &str = include_str!("../data/decks/press.inp");
const RIGID: &str = include_str!("../data/decks/rigid.inp");
const RELEASED: &str = include_str!("../data/decks/released.inp");

fn read(text: &str) -> Result<Deck, stiction::Error> {
    deck::parse(text.as_bytes(), "deck.inp", &|name| Err(format!("there is no {name}")))
}

fn solved(text: &str) -> (Outcome, Prepared) {
    let deck = read(text).unwrap_or_else(|e| panic!("{e}"));
    solved_case(&deck.case(&[]).unwrap_or_else(|e| panic!("{e}\n{}", deck.text)))
}

/// `text` with `old`, which it holds once, replaced.
fn with(text: &str, old: &str, new: &str) -> String {
    assert_eq!(text.matches(old).count(), 1, "{old:?}");
    text.replace(old, new)
}

/// `press.inp` with more steps.
fn press(steps: &[&str]) -> String {
    let step = |cards: &&str| format!("*STEP\n*STATIC\n{cards}*END STEP\n");
    PRESS.to_string() + &steps.iter().map(step).collect::<String>()
}

fn normal_forces(run: &(Outcome, Prepared)) -> Vec<f64> {
    run.0.steps.iter().map(|step| step.answer.contact.normal_force).collect()
}

fn are(values: &[f64], wanted: &[f64]) {
    assert_eq!(values.len(), wanted.len(), "{values:?}");
    values.iter().zip(wanted).for_each(|(value, wanted)| is(*value, *wanted, 1e2 * 10.0));
}

/// The values at the ends of the steps of a deck, whose steps may have several increments.
fn at_ends(run: &(Outcome, Prepared), values: &[f64]) -> Vec<f64> {
    let ends =
        (0..values.len()).filter(|&i| run.0.steps.get(i + 1).is_none_or(|next| next.name != run.0.steps[i].name));
    ends.map(|i| values[i]).collect()
}

/// A course over the time of a step ends with it: what it has come to stays. One over all steps goes on, and that of temperatures begins
/// anew with each step.
#[test]
fn what_an_amplitude_has_come_to_stays_in_later_steps() {
    let amplitude = |more: &str| format!("*AMPLITUDE, NAME=A{more}\n0., 0., 0.5, 1., 1., 0.5, 1.5, 1., 2., 0.2\n");
    let loads = [
        ("*DLOAD, AMPLITUDE=A\n2, P2, 10.\n", 10.0),
        ("*CLOAD, AMPLITUDE=A\nNtop, 3, -2.5\n", 10.0),
        ("*DSLOAD, AMPLITUDE=A\nStop, P, 10.\n", 10.0),
        ("*BOUNDARY, AMPLITUDE=A\nNtop, 3, 3, -0.02\n", 10.0),
    ];
    for (load, full) in loads {
        for (total, last) in [("", 0.5), (", TIME=TOTAL TIME", 0.2)] {
            let text = with(&press(&["*BOUNDARY\nNall, 1, 2\n"]), "*DLOAD\n2, P2, 10.\n", load);
            let text = with(&text, "*SURFACE INTERACTION", &(amplitude(total) + "*SURFACE INTERACTION"));
            let run = solved(&text);
            are(&at_ends(&run, &normal_forces(&run)), &[0.5 * full, last * full]);
        }
    }
    // Both ends are held: the column is pressed by modulus * 1e-3 * heating.
    let heat = "*BOUNDARY\nNtop, 1, 3\n*TEMPERATURE, AMPLITUDE=A\nNall, 10.\n";
    let text = with(&press(&["*BOUNDARY\nNtop, 1, 3\n"]), "*DLOAD\n2, P2, 10.\n", heat);
    let text = with(&text, "*SURFACE INTERACTION", &(amplitude("") + "*SURFACE INTERACTION"));
    let run = solved(&with(
        &text,
        "*STEP\n*STATIC\n1., 1.\n",
        "*INITIAL CONDITIONS, TYPE=TEMPERATURE\nNall, 0.\n*STEP\n*STATIC\n0.5, 1.\n",
    ));
    let forces = normal_forces(&run);
    are(&at_ends(&run, &forces), &[5.0, 5.0]);
}

/// Elongation is density g / modulus times length squared / 2, and accelerations along several directions act together.
#[test]
fn gravity_of_another_direction_is_added() {
    let pulled = |steps: &[&str]| {
        let run = solved(&with(
            &press(steps),
            "*DLOAD\n2, P2, 10.\n",
            "*BOUNDARY\nNall, 1, 2\n*DLOAD\nEall, GRAV, 5., 0., 0., -1.\n",
        ));
        pair_totals(&run.1, &run.0)[0].1.normal_force
    };
    let sink = |g: f64| 2.0 * g;
    for (steps, g) in [
        (vec![], 5.0),
        // Of one direction a later step replaces it, of another it is added, and OP=NEW ends all.
        (vec!["*DLOAD\nEall, GRAV, 7., 0., 0., -2.\n"], 7.0),
        (vec!["*DLOAD\nEall, GRAV, 2., 1., 0., 0.\n"], 5.0),
        (vec!["*DLOAD\nEall, GRAV, -2., 0., 0., 1.\n"], 7.0),
        (vec!["*DLOAD\nEall, GRAV, 2., 0., 0., 1.\n", "*DLOAD\nEall, GRAV, 1., 0., 0., 1.\n"], 4.0),
        (vec!["*DLOAD, OP=NEW\nEall, GRAV, 2., 0., 0., -1.\n"], 2.0),
    ] {
        are(&[pulled(&steps)], &[sink(g)]);
    }
}

/// A support that a later step names first leads its nodes there from where they stand; with an amplitude, or in a step whose values hold at
/// once, they have its value from the beginning.
#[test]
fn a_support_of_a_later_step_follows_its_amplitude() {
    let later = |step: &str, card: &str| {
        let text =
            press(&[]) + &format!("*STEP{step}\n*STATIC, DIRECT\n0.25, 1.\n{card}\nNtop, 3, 3, -0.04\n*END STEP\n");
        let text =
            with(&text, "*SURFACE INTERACTION", "*AMPLITUDE, NAME=A\n0., 0., 0.5, 1., 1., 0.5\n*SURFACE INTERACTION");
        normal_forces(&solved(&with(&text, "NBOTTOM, 1, 3\n", "NBOTTOM, 1, 3\nNall, 1, 2\n")))
    };
    // The pressure has brought the top down by 0.02, and 0.04 takes a force of 20.
    are(&later("", "*BOUNDARY"), &[10.0, 12.5, 15.0, 17.5, 20.0]);
    are(&later("", "*BOUNDARY, AMPLITUDE=A"), &[10.0, 10.0, 20.0, 15.0, 10.0]);
    are(&later(", AMPLITUDE=STEP", "*BOUNDARY"), &[10.0, 20.0, 20.0, 20.0, 20.0]);
}

/// Each of the two cubes gives way by force/1000.
#[test]
fn supports_that_are_not_named_again_are_released() {
    let run = solved(&press(&["*BOUNDARY\nNtop, 3, 3, -0.05\n", "*BOUNDARY, OP=NEW\nNbottom, 1, 3\n"]));
    are(&at_ends(&run, &normal_forces(&run)), &[10.0, 25.0, 10.0]);
    is(at(&run, [0.0, 0.0, 2.0])[2], -0.02, 0.02);
    // Named again, they are not.
    let run =
        solved(&press(&["*BOUNDARY\nNtop, 3, 3, -0.05\n", "*BOUNDARY, OP=NEW\nNbottom, 1, 3\nNtop, 3, 3, -0.04\n"]));
    are(&at_ends(&run, &normal_forces(&run)), &[10.0, 25.0, 20.0]);
    let deck = read(&press(&["*BOUNDARY\nNtop, 3, 3, -0.05\n", "*BOUNDARY, OP=NEW\nNbottom, 1, 3\n"])).unwrap();
    let case = deck.case(&[]).unwrap();
    assert_eq!(case.fixes.len(), 2, "{}", deck.text);
    assert_eq!((case.fixes[1].during.from, case.fixes[1].during.until), (Some(1), Some(1)));
}

#[test]
fn a_support_that_is_fixed_holds_what_the_last_step_has_found() {
    let run = solved(&press(&["*BOUNDARY, FIXED\nNtop, 1, 3\n*DLOAD, OP=NEW\n"]));
    are(&at_ends(&run, &normal_forces(&run)), &[10.0, 10.0]);
    is(at(&run, [1.0, 0.0, 2.0])[2], -0.02, 0.02);
    // Led on from there, and let go.
    let led = "*BOUNDARY\nNtop, 3, 3, -0.03\n";
    let run = solved(&press(&[
        "*BOUNDARY, FIXED\nNtop, 1, 3\n*DLOAD, OP=NEW\n",
        led,
        "*DLOAD\n2, P2, 8.\n*BOUNDARY, OP=NEW\nNbottom, 1, 3\n",
    ]));
    are(&at_ends(&run, &normal_forces(&run)), &[10.0, 10.0, 15.0, 8.0]);
}

#[test]
fn contact_pairs_are_taken_out_and_put_in_again() {
    let pair = "TYPE=CONTACT PAIR";
    let held = with(PRESS, "*DLOAD\n2, P2, 10.\n", "*BOUNDARY\nNtop, 1, 2\nNtop, 3, 3, -0.02\n");
    let step = |what: &str| format!("*STEP\n*STATIC\n*MODEL CHANGE, {pair}, {what}\nShigh, Slow\n*END STEP\n");
    let out = solved(&(held.clone() + &step("REMOVE")));
    are(&at_ends(&out, &normal_forces(&out)), &[10.0, 0.0]);
    stress(&out).iter().flatten().for_each(|&s| is(s, 0.0, 10.0));
    let again = solved(&(held.clone() + &step("REMOVE") + &step("ADD")));
    are(&at_ends(&again, &normal_forces(&again)), &[10.0, 0.0, 10.0]);
    // Out from the beginning.
    let first =
        with(&held, "*STATIC\n1., 1.\n", &format!("*STATIC\n1., 1.\n*MODEL CHANGE, {pair}, REMOVE\nShigh, Slow\n"));
    let late = solved(&(first + &step("ADD")));
    are(&at_ends(&late, &normal_forces(&late)), &[0.0, 10.0]);
}

fn point(run: &(Outcome, Prepared)) -> CouplingState {
    coupling_states(&run.1, &run.0)[0].clone()
}

/// `rigid.inp` presses by 10 at a node above the top; other cards in the place of its `*RIGID BODY`.
#[test]
fn bodies_and_surfaces_move_with_a_reference_node() {
    let card = "*RIGID BODY, NSET=Ntop, REF NODE=91, ROT NODE=92\n";
    for (cards, way) in [
        (card, 0.02),
        // The upper cube is rigid as a whole.
        ("*RIGID BODY, ELSET=Ehigh, REF NODE=91, ROT NODE=92\n", 0.01),
        ("*COUPLING, CONSTRAINT NAME=C, REF NODE=91, SURFACE=Stop\n*KINEMATIC\n1, 3\n", 0.02),
        ("*COUPLING, CONSTRAINT NAME=C, REF NODE=91, SURFACE=Stop\n*DISTRIBUTING\n1, 6\n", 0.02),
    ] {
        let text = with(RIGID, card, cards);
        let text = if cards.contains("ROT NODE") { text } else { with(&text, "92, 1, 3\n", "91, 4, 6\n") };
        let run = solved(&text);
        let it = point(&run);
        is(it.displacement[2], -way, 1e2 * way);
        is(it.force[2], -10.0, 1e2 * 10.0);
        is(pair_totals(&run.1, &run.0)[0].1.normal_force, 10.0, 1e2 * 10.0);
        it.rotation.iter().for_each(|&turn| is(turn, 0.0, 1e2 * way));
    }
}

/// A moment about x at the reference node tilts the top, by the beam theory of a column of two cubes: w = M L/(E I).
#[test]
fn moments_and_rotations_are_those_of_the_node_of_rotations() {
    let (moment, stiffness) = (0.5, 1000.0 / 12.0 / 2.0);
    // Tied, so that tension does not open it.
    let tied = with(
        &with(RIGID, "PRESSURE-OVERCLOSURE=LINEAR\n1.E6\n", "PRESSURE-OVERCLOSURE=TIED\n1.E6\n"),
        "*FRICTION\n0.3, 1.E5\n",
        "",
    );
    let free = with(&tied, "92, 1, 3\n", "92, 2, 3\n");
    let turned = |text: &str| point(&solved(text)).rotation[0];
    let by_moment = with(&free, "91, 3, -10.\n", &format!("92, 1, {moment}\n"));
    let w = turned(&by_moment);
    // One linear hexahedron a cube is stiffer in bending: it turns by less, and a prescribed turn asks for the moment.
    assert!(w > 0.0 && w < moment / stiffness, "{w}");
    // CalculiX 2.20, whose tie gives way by a thousandth.
    assert!((w / 8.890619e-4 - 1.0).abs() < 2e-3, "{w}");
    let prescribed =
        with(&with(&tied, "92, 1, 3\n", &format!("92, 2, 3\n92, 1, 1, {w}\n")), "*CLOAD\n91, 3, -10.\n", "");
    let it = point(&solved(&prescribed));
    is(it.moment[0], moment, moment);
    is(it.rotation[0], w, w);
    // In the directions 4 to 6 of the reference node where there is no other.
    let one = with(&by_moment, ", ROT NODE=92", "");
    let one =
        with(&with(&one, "92, 2, 3\n", "91, 5, 6\n"), &format!("92, 1, {moment}\n"), &format!("91, 4, {moment}\n"));
    is(turned(&one), w, w);
    let error = read(&with(RIGID, "92, 1, 3\n", "92, 1, 4\n")).map(|_| ());
    assert!(error.is_ok(), "directions beyond those of a node of rotations are none of a solid");
    let error = read(&with(RIGID, "91, 3, -10.\n", "92, 4, 1.\n")).unwrap_err();
    assert!(error.what.contains("ROT NODE") && error.place.starts_with("deck.inp, line"), "{error}");
}

#[test]
fn the_deck_of_all_changes_ends_where_it_began() {
    let run = solved(RELEASED);
    are(&at_ends(&run, &normal_forces(&run)), &[10.0, 15.0, 0.0, 20.0, 10.0]);
    is(at(&run, [0.0, 1.0, 2.0])[2], -0.02, 0.02);
    assert!(
        read(&with(RELEASED, "91, 3, 3, -0.04\n", "91, 3, 3, -0.04\n*BOUNDARY, FIXED\n91, 1, 1\n"))
            .unwrap_err()
            .what
            .contains("FIXED")
    );
}
