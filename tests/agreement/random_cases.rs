//! Cases drawn at random are certified, or refused with a motion that nothing resists.

use stiction_fixtures::random_case::{leaves, outcome, text};

/// Of 6000 seeds five are not solved, none among these (`cargo run --release -p stiction-bench --bin random_cases`).
const SEEDS: u64 = 400;

#[test]
fn cases_drawn_at_random_are_certified() {
    let (mut certified, mut steps) = (0, 0);
    for seed in 0..SEEDS {
        let text = text(seed);
        match outcome(&text) {
            Ok(taken) => (certified, steps) = (certified + 1, steps + taken),
            Err(reason) => assert!(leaves(&reason), "seed {seed}: {reason}\n{text}"),
        }
    }
    assert!(certified >= 370, "{certified}");
    // The mean counts the hard ones too.
    assert!(steps <= 8 * certified, "{steps} Newton steps of {certified} cases");
}

/// Floating bodies that slide into their seats from far: with whole steps they come out on the other side and back, and these take 706
/// cycles where steps are shortened to what violates least and they take 182.
#[test]
fn floating_bodies_find_their_seats_without_going_to_and_fro() {
    let taken = |seed: u64| outcome(&(text(seed) + "[solver]\npath = \"multigrid\"\n"));
    let cycles =
        [34, 321, 489, 569, 687, 777].map(|seed| taken(seed).unwrap_or_else(|why| panic!("seed {seed}: {why}")));
    assert!(cycles.iter().sum::<usize>() <= 300, "{cycles:?}");
}

/// Given friction between two blades whose compliances lie eight powers of ten apart: Newton's method goes round in circles,
/// as do projected gradients; the problem is convex, and the duality gap of its certificate bounds the error.
#[test]
fn given_friction_between_thin_blades_is_solved() {
    let part = |name: &str, size: [f64; 3], cells: [usize; 3], young: f64, poisson: f64| {
        let mesh =
            format!("[mesh.parts.{name}]\nblock = {{ size = {size:?}, cells = {cells:?}, element = \"hex20\" }}\n");
        (mesh, format!("[materials.{name}]\nyoung = {young}\npoisson = {poisson}\non = \"{name}\"\n"))
    };
    let (upper, stiff) = part("a", [100.0, 10.0, 100.0], [3, 5, 3], 14.6143, 0.45);
    let (lower, soft) = part("b", [150.0, 10.0, 100.0], [2, 2, 4], 0.252291, 0.3);
    let text = upper
        + &lower
        + "move = [0, 0, -100.00006607]\n"
        + &stiff
        + &soft
        + "[[fix]]\non = [\"b.z-min\", \"a.x-min\"]\nvalue = [0, 0, 0]\n\
           [[load]]\non = \"a.z-max\"\npressure = 1.46143e-3\n\
           [[load]]\non = \"a.x-max\"\ntraction = [-4.61859e-4, 5.06332e-4, 6.46723e-5]\n\
           [[contact]]\non = \"a.z-min\"\nagainst = \"b.z-max\"\nfriction = { tresca = 4.74437e-4 }\n";
    let steps = outcome(&text);
    assert!(steps.as_ref().is_ok_and(|&steps| steps < 150), "{steps:?}");
}
