//! Bodies beside one another on a third one: feet on a base, a plate over two blocks or over a step. What is right is said by statics, by
//! the case without the part that nothing touches, by one contact of all feet, and by another order of the parts.

use std::collections::BTreeSet;

use stiction::fem::full_displacement;
use stiction::run::{Outcome, Prepared, pair_totals};
use stiction_fixtures::case_run::{displacement, solved};

type Run = (Outcome, Prepared);

fn part(name: &str, [size, at]: [[f64; 3]; 2], cells: [usize; 3], element: &str, young: f64) -> String {
    format!(
        "[mesh.parts.{name}]\nblock = {{ size = {size:?}, origin = {at:?}, cells = {cells:?}, element = \"{element}\" }}\n\
         [materials.{name}]\non = \"{name}\"\nyoung = {young:?}\npoisson = 0.3\n"
    )
}

fn contact(name: &str, on: &str, against: &str) -> String {
    format!("[[contact]]\nname = \"{name}\"\non = {on}\nagainst = {against}\nfriction = {{ coulomb = 0.3 }}\n")
}

/// Every order of three parts.
fn in_any_order([a, b, c]: [&str; 3]) -> [String; 6] {
    [[a, b, c], [a, c, b], [b, a, c], [b, c, a], [c, a, b], [c, b, a]].map(|parts| parts.concat())
}

fn largest(run: &Run) -> f64 {
    displacement(run).iter().flatten().fold(0.0, |most, c| c.abs().max(most))
}

fn normal_force(run: &Run, pair: &str) -> f64 {
    pair_totals(&run.1, &run.0).iter().find(|(name, _)| name == pair).unwrap().1.normal_force
}

/// Where along x the force of contact on a body, straight up, attacks.
fn centre_of_pressure(run: &Run, body: &str) -> f64 {
    let Prepared { problem, model, mesh, .. } = &run.1;
    let force = full_displacement(model, &problem.contact.B.transpose_times(&run.0.solution.lambda));
    let cells = &mesh.group(body).unwrap().cells;
    let nodes: BTreeSet<u32> = cells.iter().flat_map(|&cell| mesh.cell(cell as usize).1).copied().collect();
    let vertical = |node: &u32| force[3 * *node as usize + 2];
    let moment: f64 = nodes.iter().map(|node| vertical(node) * mesh.nodes[*node as usize][0]).sum();
    moment / nodes.iter().map(vertical).sum::<f64>()
}

/// Three feet stand on a base 20 000 times softer, whose cells are half as wide as a foot: beside the edge between two of them each contact
/// carries for the node of the other. Each stands as on a base of fine cells with one contact of all, and above its load.
#[test]
fn feet_on_a_soft_base_of_wide_cells_all_stand_in_any_order() {
    for (element, path) in [("hex8", "auto"), ("hex8", "multigrid"), ("hex20", "multigrid")] {
        let base = part("base", [[30.0, 10.0, 5.0], [0.0; 3]], [8, 3, 3], element, 10.0);
        let feet = [1.0, 10.0, 19.0];
        let foot = |k: usize| part(&format!("f{k}"), [[8.0, 10.0, 4.0], [feet[k], 0.0, 5.0]], [3, 3, 2], "hex8", 2e5);
        let load = |k: usize| {
            format!("[[load]]\non = \"f{k}.z-max\"\nforce = [0, 0, -100]\nabout = [{}, 5, 9]\n", feet[k] + 4.0)
        };
        let rest =
            format!("[[fix]]\non = \"base.z-min\"\n[solver]\npath = \"{path}\"\n{}", [0, 1, 2].map(load).concat());
        let own = |k: usize| contact(&format!("c{k}"), "\"base.z-max\"", &format!("\"f{k}.z-min\""));
        let own = [0, 1, 2].map(own).concat();
        let all = contact("all", "\"base.z-max\"", "[\"f0.z-min\", \"f1.z-min\", \"f2.z-min\"]");
        let [a, b, c] = [0, 1, 2].map(foot);
        let fine = part("base", [[30.0, 10.0, 5.0], [0.0; 3]], [30, 6, 5], "hex8", 10.0);
        let one = largest(&solved(&format!("{fine}{a}{b}{c}{rest}{all}")));
        let first = largest(&solved(&format!("{base}{a}{b}{c}{rest}{own}")));
        assert!((first / one - 1.0).abs() < 0.08, "{element} {path}: {first}, on a fine base {one}");
        for feet_in_order in in_any_order([&a, &b, &c]) {
            let run = solved(&format!("{base}{feet_in_order}{rest}{own}"));
            let found = largest(&run);
            assert!((found / first - 1.0).abs() < 1e-6, "{element} {path}: {found} and {first}");
            for (k, x) in feet.iter().enumerate() {
                assert!((normal_force(&run, &format!("c{k}")) - 100.0).abs() < 1e-4);
                let centre = centre_of_pressure(&run, &format!("f{k}"));
                assert!((centre - x - 4.0).abs() < 1e-4, "{element} {path}: foot {k} at {centre}");
            }
        }
    }
}

/// A key between two walls on a base of three cells, all of them hard and the base soft: a cell of the base meets two bodies, and most of
/// the nodes that they share carry for one another.
#[test]
fn a_key_between_two_walls_on_a_base_of_three_cells_is_the_same_in_any_order() {
    let base = part("base", [[30.0, 10.0, 5.0], [0.0; 3]], [3, 3, 3], "hex8", 10.0);
    let l = part("l", [[8.0, 10.0, 7.0], [0.0, 0.0, 5.0]], [2, 4, 2], "hex8", 2e5);
    let r = part("r", [[8.0, 10.0, 7.0], [22.0, 0.0, 5.0]], [3, 3, 2], "hex8", 2e5);
    let key = part("key", [[14.0, 10.0, 5.0], [8.0, 0.0, 5.0]], [6, 5, 2], "hex8", 2e5);
    let held = "[[fix]]\non = \"base.z-min\"\n[[fix]]\non = \"l.x-min\"\n[[fix]]\non = \"r.x-max\"\n\
                [[load]]\non = \"key.z-max\"\nforce = [30, 0, -100]\n";
    let contacts = [("l", "z-max", "l.z-min"), ("r", "z-max", "r.z-min"), ("key", "z-max", "key.z-min")]
        .map(|(name, on, against)| contact(name, &format!("\"base.{on}\""), &format!("\"{against}\"")))
        .concat()
        + &contact("l_key", "\"l.x-max\"", "\"key.x-min\"")
        + &contact("r_key", "\"r.x-min\"", "\"key.x-max\"");
    let runs = in_any_order([&l, &r, &key]).map(|parts| solved(&format!("{base}{parts}{held}{contacts}")));
    let wanted = largest(&runs[0]);
    for run in &runs {
        let found = largest(run);
        assert!((found / wanted - 1.0).abs() < 1e-6, "{found} and {wanted}");
        assert!((normal_force(run, "key") - 100.0).abs() < 15.0, "{}", normal_force(run, "key"));
    }
}

/// The plate of these cases reaches from a block to another one beside it, which is lower by `step`; the load acts at `x`, above the first
/// block, whose top ends at 10.
fn over_two_blocks(step: f64, x: f64, cells: usize, element: &str) -> [String; 4] {
    let first = part("first", [[10.0, 10.0, 5.0], [0.0; 3]], [cells, 3, 3], "hex8", 2e5);
    let second = part("second", [[8.0, 10.0, 5.0 - step], [10.0, 0.0, 0.0]], [4, 3, 3], "hex8", 2e5);
    let plate = part("plate", [[14.0, 6.0, 4.0], [2.0, 2.0, 5.0]], [7, 3, 2], element, 2e4);
    let rest = format!(
        "[[fix]]\non = [\"first.z-min\", \"second.z-min\"]\n[[fix]]\non = \"plate.z-max\"\ncomponents = \"y\"\n\
         [[load]]\non = \"plate.z-max\"\nforce = [0, 0, -100]\nabout = [{x}, 5, 9]\n"
    );
    [first, second, plate, rest]
}

/// A plate over a step down stands on the upper block as if the lower one were not there, up to its very edge; whether both are named in one
/// contact or each in its own.
#[test]
fn a_plate_over_a_step_stands_on_the_upper_block_up_to_its_edge() {
    for (element, step) in [("hex8", 0.1), ("hex20", 0.1), ("hex8", 0.05)] {
        for x in [7.5, 9.0, 9.5] {
            let [first, second, plate, rest] = over_two_blocks(step, x, 3, element);
            let upper = contact("upper", "\"plate.z-min\"", "\"first.z-max\"");
            let lower = contact("lower", "\"plate.z-min\"", "\"second.z-max\"");
            let both = contact("both", "\"plate.z-min\"", "[\"first.z-max\", \"second.z-max\"]");
            let alone = largest(&solved(&format!("{first}{second}{plate}{rest}{upper}")));
            // Contacts of their own put their points on the blocks.
            for (contacts, close) in [(both, 1e-6), (upper.clone() + &lower, 0.4), (lower + &upper, 0.4)] {
                let found = largest(&solved(&format!("{first}{second}{plate}{rest}{contacts}")));
                assert!(
                    (found / alone - 1.0).abs() < close,
                    "{element} {step} at {x}: {found} where {alone} is wanted"
                );
            }
        }
    }
}

/// Blocks that touch at their sides below the plate are held there, and the edge of the first one still carries a plate that is loaded beside
/// it: also while the contact with the second one has not begun.
#[test]
fn blocks_that_touch_at_their_sides_carry_a_plate_up_to_the_edge() {
    for cells in [3, 5, 8] {
        for x in [8.5, 9.5] {
            let [first, second, plate, rest] = over_two_blocks(0.0, x, cells, "hex8");
            let side = contact("side", "\"first.x-max\"", "\"second.x-min\"");
            let a = contact("a", "\"first.z-max\"", "\"plate.z-min\"");
            let b = contact("b", "\"second.z-max\"", "\"plate.z-min\"");
            let steps = "[[step]]\nname = \"one\"\nuntil = 1\n[[step]]\nname = \"two\"\nuntil = 2\n";
            let later = format!("{steps}{side}{a}{b}from = \"two\"\n");
            let without = largest(&solved(&format!("{first}{second}{plate}{rest}{a}{b}")));
            let with = largest(&solved(&format!("{first}{second}{plate}{rest}{side}{a}{b}")));
            assert!((with / without - 1.0).abs() < 0.05, "{cells} at {x}: {with} and {without} without the sides");
            solved(&format!("{first}{second}{plate}{rest}{later}"));
        }
    }
}

/// Nothing loads anything in the first steps, and equations alone hold the block: it rests, and later it is pressed as one that was free
/// from the start.
#[test]
fn a_body_that_ties_alone_hold_rests_while_nothing_loads_it() {
    let base = part("base", [[10.0, 10.0, 4.0], [0.0; 3]], [3, 3, 2], "hex8", 2e5);
    let block = part("block", [[6.0, 6.0, 4.0], [2.0, 2.0, 4.0]], [3, 3, 2], "hex8", 2e5);
    let steps =
        "[[step]]\nname = \"one\"\nuntil = 1\nincrements = 2\n[[step]]\nname = \"two\"\nuntil = 2\nincrements = 2\n";
    let load = "[[load]]\non = \"block.z-max\"\nforce = [0, 0, \"-100*max(0, t - 1)\"]\n[[fix]]\non = \"base.z-min\"\n";
    // The rigid coupling stays where its motion ends.
    let coupling = "[[coupling]]\nname = \"k\"\non = \"block.z-max\"\npoint = [5, 5, 8]\nkind = \"rigid\"\n";
    let moved = "until = \"one\"\nmotion = { x = 0, y = 0, z = 0 }\nrotation = { x = 0, y = 0, z = 0 }\n";
    let held = "[[fix]]\non = \"block.z-max\"\nuntil = \"one\"\n";
    let pair = contact("c", "\"block.z-min\"", "\"base.z-max\"");
    for path in ["auto", "multigrid"] {
        for (tie, left) in [(held.to_string(), ""), (format!("{coupling}{moved}"), coupling)] {
            let rest = format!("{base}{block}{load}{steps}");
            let wanted = solved(&format!("{rest}{left}{pair}")).0.steps[3].answer.displacement_max;
            let run = solved(&format!("{rest}{tie}{pair}from = \"two\"\n[solver]\npath = \"{path}\"\n"));
            let [first, last] = [0, 3].map(|step| run.0.steps[step].answer.displacement_max);
            assert!(first <= 1e-12 * wanted, "{first} {path}");
            assert!((last / wanted - 1.0).abs() < 1e-6, "{last} {path} where {wanted} is wanted");
        }
    }
}

/// A glued block is pulled and pressed by turns: where its loads pass zero what is left of them, and of the forces in the glue, is the
/// rounding of its strength.
#[test]
fn loads_that_pass_zero_leave_a_glued_block_at_rest() {
    let base = part("base", [[10.0, 10.0, 4.0], [0.0; 3]], [3, 3, 2], "hex8", 2e5);
    let block = part("block", [[6.0, 6.0, 4.0], [2.0, 2.0, 4.0]], [3, 3, 2], "hex8", 2e5);
    let rest = "[[fix]]\non = \"base.z-min\"\n[[load]]\non = \"block.z-max\"\nforce = [0, 0, \"20*sin(pi*t)\"]\n\
                [[step]]\nuntil = 2\nincrements = 4\n[[contact]]\non = \"block.z-min\"\nagainst = \"base.z-max\"\n\
                friction = { coulomb = 0.6, cohesion = 50, tension = 50 }\n";
    let run = solved(&format!("{base}{block}{rest}"));
    let at = |t: f64| run.0.steps.iter().find(|step| step.t == t).unwrap().answer.displacement_max;
    let [pulled, rests, pressed] = [0.5, 1.0, 1.5].map(at);
    assert!((pulled / pressed - 1.0).abs() < 1e-6 && rests < 1e-9 * pulled, "{pulled} {rests} {pressed}");
}
