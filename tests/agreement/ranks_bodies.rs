//! Two bodies in contact on several ranks against the same case on one: points and the nodes they touch lie on different ranks.

use super::ranks::{agrees, case_of, certificate_agrees, on_ranks, serial_cycles};
use stiction_fixtures::case_run::solved_case;

/// A block held at one end on another one, with a mesh of its own or the same.
pub(super) fn blocks(element: &str, matching: bool, friction: &str) -> String {
    let below = if matching { "[3, 1, 0.5], cells = [30, 10, 5]" } else { "[3.2, 1.1, 0.5], cells = [23, 7, 4]" };
    format!(
        "[mesh.parts.a]\nblock = {{ size = [3, 1, 1], cells = [30, 10, 10], {element} }}\n\
         [mesh.parts.b]\nblock = {{ size = {below}, {element} }}\nmove = [0, 0, -0.5]\n\
         [materials.steel]\nyoung = 21.19e10\npoisson = 0.277\n\
         [[fix]]\non = \"a.x-min\"\n[[fix]]\non = \"b.z-min\"\n[[load]]\non = \"a.x-max\"\ntraction = [0, 0, 1e6]\n\
         [[load]]\non = \"a.z-max\"\ntraction = [0, 2e5, \"-2/3*1e6*(3 - x)\"]\n\
         [[contact]]\non = \"a.z-min\"\nagainst = \"b.z-max\"\nfriction = {friction}\n"
    )
}

const TET4: &str = "element = \"tet4\", split = \"six\"";
const HEX8: &str = "element = \"hex8\"";

#[test]
fn two_bodies_on_ranks_are_those_on_one() {
    agrees(&blocks(HEX8, false, "{ coulomb = 0.35 }"), &[1, 2, 3, 4, 8]);
    agrees(&blocks(TET4, false, "{ coulomb = 0.35 }"), &[2, 4, 8]);
}

#[test]
fn matching_meshes_and_ties_are_the_same_on_ranks() {
    agrees(&blocks(TET4, true, "{ coulomb = 0.35 }"), &[3, 8]);
    agrees(&blocks(HEX8, true, "{ coulomb = 0.35 }"), &[4]);
    agrees(&blocks(HEX8, false, "\"bonded\""), &[2, 8]);
    agrees(&blocks(TET4, true, "\"bonded\""), &[4]);
}

/// A block that only contact holds, pressed and pushed on another one or on a plane, some of it on a plane of symmetry; or above
/// it, so that the load closes a gap.
pub(super) fn floating(element: &str, against: &str, friction: &str, gap: f64, symmetric: bool) -> String {
    let other = "[mesh.parts.b]\nblock = { size = [2.2, 1.1, 0.5], cells = [13, 7, 4], element = \"hex8\" }\n\
                 move = [0, 0, -0.5]\n[[fix]]\non = \"b.z-min\"\n";
    let symmetry = "[[fix]]\non = \"a.y-min\"\ncondition = \"symmetry\"\n";
    format!(
        "[mesh.parts.a]\nblock = {{ size = [2, 1, 1], cells = [16, 8, 8], {element} }}\nmove = [0, 0, {gap}]\n{}{}\
         [materials.steel]\nyoung = 21.19e10\npoisson = 0.277\n\
         [[load]]\non = \"a.z-max\"\ntraction = [2e5, 0, \"-1e6*(2 - x/2)\"]\n\
         [[contact]]\non = \"a.z-min\"\nagainst = {against}\nfriction = {friction}\n",
        if against.contains("b.z-max") { other } else { "" },
        if symmetric { symmetry } else { "" },
    )
}

pub(super) const PLANE: &str = "{ plane = { point = [0, 0, 0], normal = [0, 0, 1] } }";

#[test]
fn bodies_that_contact_alone_holds_are_the_same_on_ranks() {
    agrees(&floating(HEX8, "\"b.z-max\"", "{ coulomb = 0.4 }", 0.0, false), &[1, 2, 4, 8]);
    agrees(&floating(TET4, PLANE, "{ coulomb = 0.4 }", 0.0, true), &[3]);
    agrees(&floating(TET4, "\"b.z-max\"", "\"bonded\"", 0.0, false), &[4]);
    // Rigid bodies in equilibrium are where this begins.
    agrees(&floating(HEX8, PLANE, "{ coulomb = 0.4 }", 0.01, false), &[2, 4]);
}

#[test]
fn the_certificate_of_ranks_counts_each_point_between_bodies_once() {
    certificate_agrees(&blocks(HEX8, false, "{ coulomb = 0.35 }").replace("[30, 10, 10]", "[12, 4, 4]"));
}

/// The bar of the design: at most two cycles or a quarter more, whatever the ranks.
#[test]
fn two_bodies_take_hardly_more_cycles_on_ranks() {
    let mut above = Vec::new();
    for (element, matching) in [(TET4, false), (HEX8, false), (HEX8, true)] {
        for text in [
            blocks(element, matching, "{ coulomb = 0.35 }"),
            blocks(element, matching, "\"bonded\""),
            floating(element, "\"b.z-max\"", "{ coulomb = 0.4 }", 0.0, matching),
        ] {
            let case = case_of(&text, "1e-8");
            let serial = serial_cycles(&case);
            let found = [1, 2, 3, 4, 8].map(|size| on_ranks(&case, size).1.answer.counts.cycles);
            println!("{serial} {found:?}");
            let most = (serial + 2).max(serial * 5 / 4);
            if found[0] != serial || found.iter().any(|&cycles| cycles > most) {
                above.push(format!("{text}: {found:?} cycles, {serial} without ranks"));
            }
        }
    }
    assert!(above.is_empty(), "{above:#?}");
}

/// A block on a plate on a floor that is named for both, and two stamps on the faces of one plate: nodes that several contacts name.
#[test]
fn nodes_named_twice_belong_to_the_same_contact_on_ranks() {
    let steel = "[materials.steel]\nyoung = 210e3\npoisson = 0.3\n";
    let part = |name: &str, size: [f64; 3], at: [f64; 3], cells: [usize; 3]| {
        format!(
            "[mesh.parts.{name}]\nblock = {{ size = {size:?}, origin = {at:?}, cells = {cells:?}, element = \"hex8\" }}\n"
        )
    };
    let contact = |on: &str, against: &str| {
        format!("[[contact]]\non = {on}\nagainst = {against}\nfriction = {{ coulomb = 0.3 }}\n")
    };
    let [plate, block] = [([30.0, 30.0, 5.0], [0.0; 3], [10, 10, 3]), ([20.0, 20.0, 8.0], [5.0, 5.0, 5.0], [8, 8, 4])];
    let stack = part("a", plate.0, plate.1, plate.2) + &part("b", block.0, block.1, block.2);
    let load = "[[load]]\non = \"b.z-max\"\nforce = [100, 0, -1000]\nabout = [15, 15, 5]\n";
    let floor = contact("[\"a.z-min\", \"b.z-min\"]", PLANE);
    agrees(&format!("{stack}{steel}{load}{floor}{}", contact("\"b.z-min\"", "\"a.z-max\"")), &[1, 2, 3]);
    let stamps = part("a", [40.0, 40.0, 10.0], [0.0; 3], [13, 13, 4])
        + &part("b", [8.0, 20.0, 8.0], [11.75, 10.0, 10.0], [3, 7, 3])
        + &part("c", [8.0, 20.0, 8.0], [20.25, 10.0, 10.0], [3, 7, 3]);
    let load = "[[fix]]\non = \"a.z-min\"\n[[load]]\non = \"b.z-max\"\npressure = 10\n[[load]]\non = \"c.z-max\"\npressure = 8\n";
    for slave in ["", "slave = \"against\"\n"] {
        let contacts = ["b", "c"].map(|stamp| contact(&format!("\"{stamp}.z-min\""), "\"a.z-max\"") + slave).concat();
        agrees(&format!("{stamps}{steel}{load}{contacts}"), &[2, 4]);
    }
}

/// Pressed, pushed one way and half way back: where points stick depends on what they have slid before. Total forces and
/// prescribed displacements are functions of time.
fn to_and_fro(against_body: bool) -> String {
    let mesh = "[mesh.parts.a]\nblock = { size = [2, 1, 1], cells = [16, 8, 8], element = \"hex8\" }\n\
                [mesh.parts.b]\nblock = { size = [2.2, 1.1, 0.5], cells = [13, 7, 4], element = \"tet4\" }\n\
                move = [0, 0, -0.5]\n[[fix]]\non = \"b.z-min\"\nvalue = [0, \"1e-6*t\", 0]\n";
    let alone = "[mesh.parts.a]\nblock = { size = [2, 1, 1], cells = [16, 8, 8], element = \"hex8\" }\n";
    format!(
        "{}[materials.steel]\nyoung = 21.19e10\npoisson = 0.277\n\
         [[fix]]\non = \"a.z-max\"\nvalue = [\"1e-5*min(max(t - 1, 0), 3 - t)\", 0, \"-1e-5*min(t, 1)\"]\n\
         [[load]]\non = \"a.x-max\"\nforce = [0, \"1e5*t\", 0]\n\
         [[contact]]\non = \"a.z-min\"\nagainst = {}\nfriction = {{ coulomb = 0.15 }}\n\
         [[step]]\nname = \"press\"\nuntil = 1\n[[step]]\nname = \"push\"\nuntil = 2.5\nincrements = 3\n",
        if against_body { mesh } else { alone },
        if against_body { "\"b.z-max\"" } else { PLANE },
    )
}

#[test]
fn load_steps_remember_slip_on_ranks() {
    for (against_body, sizes) in [(true, &[1, 3, 4][..]), (false, &[2])] {
        let text = to_and_fro(against_body);
        agrees(&text, sizes);
        let case = case_of(&text, "1e-10");
        let (_, summary) = on_ranks(&case, sizes[0]);
        let (outcome, _) = solved_case(&case);
        let expected: Vec<(f64, f64)> = outcome.steps.iter().map(|s| (s.t, s.answer.contact.normal_force)).collect();
        assert!(expected.len() == 4 && summary.steps.len() == 4, "{expected:?}");
        for (step, (t, force)) in summary.steps.iter().zip(expected) {
            assert!(
                step.t == t && (step.answer.contact.normal_force - force).abs() <= 1e-9 * force,
                "{step:?} {force}"
            );
        }
        assert!(summary.steps[2].answer.contact.slip > 0 && summary.answer.contact.stick > 0, "{summary:?}");
        // Without its history the last state is another one.
        let at_once = text.replace("until = 1\n[[step]]\nname = \"push\"\n", "").replace("increments = 3", "");
        let other = on_ranks(&case_of(&at_once, "1e-10"), 2).1.answer.contact.tangential_force[0];
        let own = summary.answer.contact.tangential_force[0];
        assert!((other - own).abs() > 1e-3 * own.abs(), "{own} {other}");
    }
}

/// Two blocks side by side on a third. One is coarser than the surface below, whose nodes carry the points; the other is finer, and
/// its points are measured from such nodes.
#[test]
fn points_on_nodes_from_which_others_are_measured_are_the_same_on_ranks() {
    let block = |name: &str, x: f64, z: f64, size: [f64; 3], cells: [usize; 3]| {
        format!(
            "[mesh.parts.{name}]\nblock = {{ size = {size:?}, cells = {cells:?}, element = \"hex8\" }}\nmove = [{x}, 0, {z}]\n"
        )
    };
    let contact = |name: &str| {
        format!(
            "[[fix]]\non = \"{name}.z-max\"\nvalue = [0, 0, -1e-5]\n[[contact]]\nname = \"{name}\"\non = \"{name}.z-min\"\n\
             against = \"b.z-max\"\nfriction = {{ coulomb = 0.3 }}\n"
        )
    };
    let text = format!(
        "{}{}{}[materials.steel]\nyoung = 2e11\npoisson = 0.3\n[[fix]]\non = \"b.z-min\"\n{}{}",
        block("a", 0.0, 0.0, [1.0, 1.0, 1.0], [3, 3, 3]),
        block("b", 0.0, -1.0, [2.0, 1.0, 1.0], [12, 6, 6]),
        block("c", 1.0, 0.0, [1.0, 1.0, 1.0], [9, 9, 9]),
        contact("a"),
        contact("c"),
    );
    agrees(&text, &[2, 3, 5]);
}
