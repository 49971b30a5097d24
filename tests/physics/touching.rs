//! Curved bodies that touch: nothing presses before they overlap.

use stiction::run::{Outcome, Prepared, pair_totals};
use stiction_fixtures::case_run::solved;

const STEEL: &str = "[materials.steel]\nyoung = 210e3\npoisson = 0.3\n";

fn normal_force(run: &(Outcome, Prepared), pair: &str) -> f64 {
    pair_totals(&run.1, &run.0).iter().find(|(name, _)| name == pair).unwrap().1.normal_force
}

/// Half a ring of radius 10 whose lowest place is `clearance` above y = -10, its nodes turned by some degrees; its bore is moved down by
/// `down`, and nothing moves along z.
fn ring(element: &str, turn: f64, down: f64, table: &str, against: &str) -> String {
    format!(
        "{table}[mesh.parts.ring]\nring = {{ radii = [4, 10], height = 4, degrees = 180, cells = [4, 20, 1], element = \"{element}\" }}\n\
         turn = {{ axis = [0, 0, 1], degrees = {} }}\n{STEEL}[[fix]]\non = [\"ring.z-min\", \"ring.z-max\"]\ncomponents = \"z\"\n\
         [[fix]]\non = \"ring.inner\"\ncomponents = \"xy\"\nvalue = [0, {}]\n\
         [[contact]]\nname = \"foot\"\non = \"ring.outer\"\nagainst = {against}\nfriction = {{ coulomb = 0.2 }}\n",
        180.0 + turn,
        -down,
    )
}

/// The table lies this far below the ring: more than arcs of the second order stand out between the nodes of a circle.
const CLEARANCE: f64 = 5e-4;

fn table(element: &str) -> String {
    format!(
        "[mesh.parts.table]\nblock = {{ size = [20, 10, 4], cells = [12, 6, 1], origin = [-10, {}, 0], element = \"{element}\" }}\n\
         [[fix]]\non = \"table.y-min\"\n[[fix]]\non = [\"table.z-min\", \"table.z-max\"]\ncomponents = \"z\"\n",
        -20.0 - CLEARANCE
    )
}

/// The dual functions are negative in places: the weighted gap of a ring over a table may be an overlap of `h²/(12 R)`, a third of a
/// percent of a cell here, where there is none. Statics: bodies that do not touch do not press.
#[test]
fn a_ring_that_nothing_presses_does_not_press_its_table_however_its_nodes_lie() {
    for turn in [0.0, 1.0, 2.5, 4.5, 6.0] {
        for element in ["hex20", "tet10"] {
            let plane = format!("{{ plane = {{ point = [0, {}, 0], normal = [0, 1, 0] }} }}", -10.0 - CLEARANCE);
            let run = solved(&ring(element, turn, 0.0, "", &plane));
            assert_eq!(normal_force(&run, "foot"), 0.0, "{element} turned by {turn} on a plane");
            for (below, slave) in [("hex8", "on"), ("hex20", "on"), ("hex8", "against"), ("tet10", "against")] {
                let against = format!("\"table.y-max\"\nslave = \"{slave}\"");
                let run = solved(&ring(element, turn, 0.0, &table(below), &against));
                let force = normal_force(&run, "foot");
                assert_eq!(force, 0.0, "{element} turned by {turn} on {below}, points on the surface in `{slave}`");
            }
        }
    }
}

/// Pressed until the contact is nearly two cells wide the force is the same wherever the nodes are: a turn of the mesh is none of the body.
#[test]
fn the_force_of_a_ring_does_not_depend_on_where_its_nodes_are() {
    for (element, slave) in [("hex20", "on"), ("tet10", "on"), ("hex20", "against")] {
        let forces = [0.0, 2.5, 4.5, 6.0].map(|turn| {
            let against = format!("\"table.y-max\"\nslave = \"{slave}\"");
            normal_force(&solved(&ring(element, turn, 0.2, &table("hex8"), &against)), "foot")
        });
        let [low, high] = [f64::min, f64::max].map(|of| forces.into_iter().reduce(of).unwrap());
        assert!(high < 1.03 * low, "{element} {slave}: {forces:?}");
    }
}

/// Two blocks without contraction under a pressure have it everywhere in the contact: also where it shortens them by less than rounding leaves
/// between their coordinates, far from the origin or turned.
#[test]
fn surfaces_that_touch_up_to_rounding_touch() {
    let [far, turned] = ["move = [5e5, 4e6, 100]\n", ""];
    for (element, on, place, pressure) in [
        ("hex8", "upper.z-min", far, 10.0),
        ("tet10", "lower.z-max", far, 10.0),
        ("hex20", "upper.z-min", turned, 1e-9),
        ("tet4", "plane", turned, 1e-9),
    ] {
        let part = |name: &str, cells: u32, z: i32| {
            format!(
                "[mesh.parts.{name}]\nblock = {{ size = [1, 1, 1], cells = [{cells}, {cells}, 2], origin = [0, 0, {z}], element = \"{element}\" }}\n\
                 turn = {{ axis = [0.6, 0.64, 0.48], degrees = 33 }}\n{place}"
            )
        };
        // The unit vector along z, turned.
        let (sin, cos) = 33f64.to_radians().sin_cos();
        let normal = [
            0.48 * 0.6 * (1.0 - cos) + 0.64 * sin,
            0.48 * 0.64 * (1.0 - cos) - 0.6 * sin,
            cos + 0.48 * 0.48 * (1.0 - cos),
        ];
        let (parts, below, contact) = match on {
            "plane" => {
                let plane = format!("{{ plane = {{ point = [0, 0, 0], normal = {normal:?} }} }}");
                (part("upper", 4, 0), String::new(), format!("on = \"upper.z-min\"\nagainst = {plane}\n"))
            }
            _ => {
                let other = if on == "upper.z-min" { "lower.z-max" } else { "upper.z-min" };
                let contact = format!("on = \"{on}\"\nagainst = \"{other}\"\nslave = \"on\"\n");
                (part("upper", 4, 0) + &part("lower", 3, -1), "[[fix]]\non = \"lower.z-min\"\n".to_string(), contact)
            }
        };
        let text = format!(
            "{parts}[materials.m]\nyoung = 210e9\npoisson = 0\n{below}\
             [[load]]\non = \"upper.z-max\"\npressure = {pressure}\n[[contact]]\n{contact}friction = {{ coulomb = 0.3 }}\n"
        );
        let run = solved(&text);
        let pair = &pair_totals(&run.1, &run.0)[0].1;
        assert!(
            (pair.max_pressure / pressure - 1.0).abs() < 1e-6,
            "{element} {on}: {} for {pressure}",
            pair.max_pressure
        );
        assert!(
            (pair.normal_force / pressure - 1.0).abs() < 1e-6,
            "{element} {on}: {} for {pressure}",
            pair.normal_force
        );
        assert_eq!(run.1.facts.contacts[0].surface.gap_max, 0.0, "{element} {on}");
    }
}

/// An edge lies 0.3 below a slab that is lowered by less: whatever the distances beside the edge, of which the dual functions, negative in
/// places, make a mean, no node is nearer to it than the edge is, and nothing presses.
#[test]
fn an_edge_below_a_slab_presses_where_they_meet_and_not_before() {
    for (element, cells, x) in [
        ("hex8", "[10, 5, 1]", -10.5),
        ("hex8", "[20, 10, 2]", -10.25),
        ("tet4", "[10, 5, 1]", -10.5),
        ("hex20", "[10, 5, 1]", -9.3),
        ("hex20", "[20, 10, 2]", -9.3),
        ("tet10", "[20, 10, 2]", -10.5),
    ] {
        let run = |down: f64| {
            solved(&format!(
                "[mesh.parts.slab]\nblock = {{ size = [20, 10, 4], cells = {cells}, element = \"{element}\" }}\nmove = [{x}, 0, 0.3]\n\
                 [mesh.parts.ridge]\nblock = {{ size = [8, 10, 8], cells = [8, 5, 4], element = \"hex8\", origin = [-8, 0, -8] }}\n\
                 turn = {{ axis = [0, 1, 0], degrees = -20, point = [0, 0, 0] }}\n{STEEL}\
                 [[fix]]\non = \"ridge.x-min\"\n[[fix]]\non = \"slab.z-max\"\nvalue = [0, 0, {}]\n\
                 [[contact]]\nname = \"edge\"\non = \"slab.z-min\"\nagainst = [\"ridge.z-max\", \"ridge.x-max\"]\nslave = \"on\"\n\
                 friction = {{ coulomb = 0.2 }}\n",
                -down
            ))
        };
        let apart = run(0.2);
        let at = format!("{element}, {cells}, {x}");
        let gap = apart.1.facts.contacts[0].surface.gap_min;
        assert!(gap >= 0.3 - 1e-12, "{at}: {gap}");
        assert_eq!(normal_force(&apart, "edge"), 0.0, "{at}");
        assert!(normal_force(&run(1.0), "edge") > 1e3, "{at}");
    }
}
