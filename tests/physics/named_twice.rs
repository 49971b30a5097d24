//! Nodes that several contacts name: each meets what is nearest to it, and two bodies beside one another on a third share its
//! faces. What is right is said by statics, by symmetry, and by the same case with its contacts in another order.

use std::collections::BTreeSet;
use std::ops::ControlFlow;

use stiction::fem::full_displacement;
use stiction::friction::Status;
use stiction::io::case;
use stiction::run::{Outcome, Prepared, Settings, pair_totals, prepare, solve};
use stiction_fixtures::case_run::{displacement, solved};

type Run = (Outcome, Prepared);

const STEEL: &str = "[materials.steel]\nyoung = 210e3\npoisson = 0.3\n";

#[track_caller]
fn is(value: f64, wanted: f64, scale: f64) {
    assert!((value - wanted).abs() <= 1e-6 * scale, "{value} where {wanted} is wanted");
}

fn normal_force(run: &Run, pair: &str) -> f64 {
    pair_totals(&run.1, &run.0).iter().find(|(name, _)| name == pair).unwrap().1.normal_force
}

fn largest(u: &[[f64; 3]]) -> f64 {
    u.iter().flatten().fold(0.0, |most, c| c.abs().max(most))
}

/// The answers of two runs on one mesh are the same.
#[track_caller]
fn same(a: &Run, b: &Run) {
    let [a, b] = [a, b].map(displacement);
    let apart: Vec<[f64; 3]> = a.iter().zip(&b).map(|(a, b)| [0, 1, 2].map(|c| a[c] - b[c])).collect();
    assert!(largest(&apart) <= 1e-9 * largest(&a), "{:e} of {:e}", largest(&apart), largest(&a));
}

fn part(name: &str, [size, at]: [[f64; 3]; 2], cells: [usize; 3], element: &str) -> String {
    format!(
        "[mesh.parts.{name}]\nblock = {{ size = {size:?}, origin = {at:?}, cells = {cells:?}, element = \"{element}\" }}\n"
    )
}

fn contact(name: &str, on: &str, against: &str) -> String {
    format!("[[contact]]\nname = \"{name}\"\non = {on}\nagainst = {against}\nfriction = {{ coulomb = 0.3 }}\n")
}

fn skin(of: &str) -> String {
    ["x-min", "x-max", "y-min", "y-max", "z-min", "z-max"].map(|side| format!("\"{of}.{side}\"")).join(", ")
}

const FLOOR: &str = "{ plane = { point = [0, 0, 0], normal = [0, 0, 1] } }";

/// A block of 1000 N on a plate on a floor, the floor named for both of them: all of the weight goes through both joints,
/// and nothing sinks by the thickness of the plate.
#[test]
fn a_block_stands_on_the_plate_below_it_although_the_floor_is_named_too() {
    let faces = ["\"a.z-min\", \"b.z-min\"", "\"b.z-min\"", "\"a.z-max\""].map(str::to_string);
    let skins = [format!("{}, {}", skin("a"), skin("b")), skin("b"), skin("a")];
    for (thickness, element, named) in [
        (0.5, "hex8", &faces),
        (5.0, "tet10", &faces),
        (10.0, "hex8", &faces),
        (10.0, "tet10", &faces),
        (5.0, "hex8", &skins),
        (5.0, "tet10", &skins),
    ] {
        let [of_floor, on, against] = named;
        let floor = contact("floor", &format!("[{of_floor}]"), FLOOR);
        let plate = contact("plate", &format!("[{on}]"), &format!("[{against}]"));
        let runs = [[&floor, &plate], [&plate, &floor]].map(|[first, second]| {
            let run = solved(&format!(
                "[solver]\ntolerance = 1e-10\n{}{}{STEEL}[[load]]\non = \"b.z-max\"\nforce = [100, 0, -1000]\n\
                 about = [15, 15, {thickness}]\n{first}{second}",
                part("a", [[30.0, 30.0, thickness], [0.0; 3]], [3, 3, 1], element),
                part("b", [[20.0, 20.0, 5.0], [5.0, 5.0, thickness]], [4, 4, 1], element),
            ));
            ["floor", "plate"].iter().for_each(|pair| is(normal_force(&run, pair), 1000.0, 1000.0));
            assert!(largest(&displacement(&run)) < 1e-3);
            run
        });
        same(&runs[0], &runs[1]);
    }
}

/// Three plates on one another, each named with each: the upper one does not meet the lowest through the one between them.
#[test]
fn three_plates_stand_on_one_another_in_any_order_of_their_contacts() {
    for thickness in [0.3, 4.0] {
        let contacts = [("bc", "b", "c"), ("ab", "b", "a"), ("ac", "a", "c")]
            .map(|(name, on, against)| contact(name, &format!("\"{on}.z-min\""), &format!("\"{against}.z-max\"")));
        let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
        let runs = orders.map(|order| {
            let run = solved(&format!(
                "{}{}{}{STEEL}[[fix]]\non = \"c.z-min\"\n[[load]]\non = \"b.z-max\"\nforce = [100, 0, -1000]\n\
                 about = [15, 15, {thickness}]\n{}",
                part("c", [[40.0, 40.0, 6.0], [-5.0, -5.0, -6.0]], [4, 4, 1], "hex8"),
                part("a", [[30.0, 30.0, thickness], [0.0; 3]], [3, 3, 1], "hex8"),
                part("b", [[20.0, 20.0, 5.0], [5.0, 5.0, thickness]], [4, 4, 1], "hex8"),
                order.map(|k| contacts[k].clone()).concat(),
            ));
            let forces = [("bc", 0.0), ("ab", 1000.0), ("ac", 1000.0)];
            forces.iter().for_each(|(pair, force)| is(normal_force(&run, pair), *force, 1000.0));
            assert!(largest(&displacement(&run)) < 1e-3);
            run
        });
        runs.iter().for_each(|run| same(run, &runs[0]));
    }
}

/// A block just above a floor that touches a wall: the wall is nearer to the nodes of the edge between, but it is not in front of the
/// floor, on which the neighbours of these nodes could not carry for them.
#[test]
fn an_obstacle_keeps_the_nodes_of_an_edge() {
    let run = solved(&format!(
        "{}{}{STEEL}[[fix]]\non = \"w.x-max\"\n[[fix]]\non = \"a.x-min\"\ncomponents = \"x\"\n[[fix]]\non = \"a.y-min\"\n\
         components = \"y\"\n[[load]]\non = \"a.z-max\"\npressure = 10\n{}{}",
        part("a", [[10.0; 3], [0.0, 0.0, 1e-4]], [3, 3, 3], "hex8"),
        part("w", [[2.0, 12.0, 12.0], [10.0, -1.0, -1.0]], [1, 4, 4], "hex8"),
        contact("wall", "\"a.x-max\"", "\"w.x-min\"").replace("{ coulomb = 0.3 }", "\"none\""),
        contact("floor", "\"a.z-min\"", FLOOR).replace("{ coulomb = 0.3 }", "\"none\""),
    ));
    let points = |name: &str| run.1.problem.labels.pairs.iter().find(|pair| pair.name == name).unwrap().points.len();
    assert_eq!((points("wall"), points("floor")), (12, 16));
    assert!(run.1.facts.warnings.is_empty());
    is(normal_force(&run, "floor"), 1000.0, 1000.0);
}

/// Two stamps 0.5 apart on a softer plate, each a contact of its own.
struct Stamps {
    element: &'static str,
    plate: usize,
    cells: [usize; 2],
    width: f64,
    /// Between them.
    middle: f64,
    more: &'static str,
}

impl Stamps {
    fn text(&self, load: &str, turned: bool) -> String {
        let &Stamps { element, plate, cells: [across, along], width, middle, more } = self;
        let stamp =
            |name: &str, from: f64| part(name, [[width, 20.0, 8.0], [from, 10.0, 10.0]], [across, along, 1], element);
        let mut contacts = ["b", "c"].map(|name| contact(name, &format!("\"{name}.z-min\""), "\"a.z-max\"") + more);
        if turned {
            contacts.reverse();
        }
        format!(
            "{}{}{}[materials.soft]\non = \"a\"\nyoung = 10e3\npoisson = 0.3\n[materials.steel]\non = [\"b\", \"c\"]\n\
             young = 210e3\npoisson = 0.3\n[[fix]]\non = \"a.z-min\"\n{load}{}",
            part("a", [[40.0, 40.0, 10.0], [0.0; 3]], [plate, plate, 2], element),
            stamp("b", middle - 0.25 - width),
            stamp("c", middle + 0.25),
            contacts.concat(),
        )
    }
}

const PRESSED: &str = "[[load]]\non = \"b.z-max\"\npressure = 10\n[[load]]\non = \"c.z-max\"\npressure = 10\n";
const SYMMETRIC: Stamps = Stamps { element: "hex8", plate: 6, cells: [2, 3], width: 8.0, middle: 20.0, more: "" };

/// Where along x the force of contact on a stamp, straight up, attacks.
fn centre_of_pressure(run: &Run, stamp: &str) -> f64 {
    let Prepared { problem, model, mesh, .. } = &run.1;
    let force = full_displacement(model, &problem.contact.B.transpose_times(&run.0.solution.lambda));
    let cells = &mesh.group(stamp).unwrap().cells;
    let nodes: BTreeSet<u32> = cells.iter().flat_map(|&cell| mesh.cell(cell as usize).1).copied().collect();
    let vertical = |node: &u32| force[3 * *node as usize + 2];
    let moment: f64 = nodes.iter().map(|node| vertical(node) * mesh.nodes[*node as usize][0]).sum();
    moment / nodes.iter().map(vertical).sum::<f64>()
}

/// Pressed a tenth to four tenths of its width from its inner edge a stamp stands, and its pressure is centred below the load.
#[test]
fn stamps_beside_one_another_stand_where_statics_says_so() {
    let unlike = Stamps { plate: 8, cells: [1, 2], width: 5.0, middle: 22.0, ..SYMMETRIC };
    // The plate has smaller cells than the stamps, with nodes and with the middle of cells between them.
    let finer = Stamps { plate: 20, cells: [2, 2], width: 7.0, ..SYMMETRIC };
    let between_nodes = Stamps { middle: 21.0, ..finer };
    for stamps in [&SYMMETRIC, &unlike, &finer, &between_nodes] {
        for part in [0.1, 0.25, 0.4] {
            let Stamps { middle, width, .. } = *stamps;
            let places = [middle - 0.25 - part * width, middle + 0.25 + part * width];
            let load = |body: &str, x: f64| {
                format!("[[load]]\non = \"{body}.z-max\"\nforce = [0, 0, -1000]\nabout = [{x}, 20, 18]\n")
            };
            let loads = load("b", places[0]) + &load("c", places[1]);
            let runs = [false, true].map(|turned| solved(&stamps.text(&loads, turned)));
            ["b", "c"].iter().for_each(|pair| is(normal_force(&runs[0], pair), 1000.0, 1000.0));
            is(centre_of_pressure(&runs[0], "b"), places[0], width);
            is(centre_of_pressure(&runs[0], "c"), places[1], width);
            same(&runs[0], &runs[1]);
        }
    }
}

/// By symmetry both carry the same pressure; and where the cells of the plate are larger than a stamp, both have points.
#[test]
fn stamps_beside_one_another_press_alike() {
    for turned in [false, true] {
        let run = solved(&SYMMETRIC.text(PRESSED, turned));
        let pairs = pair_totals(&run.1, &run.0);
        is(pairs[0].1.max_pressure, pairs[1].1.max_pressure, pairs[0].1.max_pressure);
    }
    let coarse = Stamps { element: "tet10", plate: 4, cells: [1, 2], width: 6.0, middle: 22.0, ..SYMMETRIC };
    for stamps in [coarse, Stamps { cells: [1, 2], width: 4.0, middle: 22.0, ..SYMMETRIC }] {
        let runs = [false, true].map(|turned| solved(&stamps.text(PRESSED, turned)));
        let force = 10.0 * 20.0 * stamps.width;
        ["b", "c"].iter().for_each(|pair| is(normal_force(&runs[0], pair), force, force));
        same(&runs[0], &runs[1]);
    }
}

/// Where the case puts the points of both contacts on the plate, its nodes are divided among them in whatever order they are
/// named. What one loses is said before the solve, with the remedy, and one contact of both stamps needs none.
#[test]
fn contacts_that_lose_nodes_say_so() {
    let asked = Stamps { more: "slave = \"against\"\n", ..SYMMETRIC };
    let runs = [false, true].map(|turned| solved(&asked.text(PRESSED, turned)));
    same(&runs[0], &runs[1]);
    for run in &runs {
        let warnings = &run.1.facts.warnings;
        assert!(warnings.len() == 1 && warnings[0].contains("in one contact"), "{warnings:?}");
    }
    let coarse = Stamps { cells: [1, 2], width: 4.0, middle: 22.0, ..asked };
    // Cells as wide as three stamps: each contact carries for nodes of the other one.
    let runs = [false, true].map(|turned| solved(&coarse.text(PRESSED, turned)));
    same(&runs[0], &runs[1]);
    ["b", "c"].iter().for_each(|pair| is(normal_force(&runs[0], pair), 800.0, 800.0));
    let both = contact("both", "\"a.z-max\"", "[\"b.z-min\", \"c.z-min\"]");
    let text = SYMMETRIC.text(PRESSED, false);
    let one = solved(&format!("{}{both}", text.split("[[contact]]").next().unwrap()));
    assert!(one.1.facts.warnings.is_empty(), "{:?}", one.1.facts.warnings);
    assert!(solved(&text).1.facts.warnings.is_empty());
}

/// Two thin plates on one another: the top of the upper one and the bottom of the lower one look away from each other, and do not
/// overlap by the thickness of both. Whole skins are what the faces that touch are; pulled off, nothing holds the plate.
#[test]
fn whole_skins_of_thin_plates_are_their_faces_that_touch() {
    let text = |[on, against]: [&str; 2], friction: &str, pressure: f64, element: &str| {
        format!(
            "{}{}{STEEL}[[fix]]\non = \"a.z-min\"\n[[load]]\non = \"b.z-max\"\npressure = {pressure}\n\
             [[contact]]\nname = \"joint\"\non = [{on}]\nagainst = [{against}]\nfriction = {friction}\n",
            part("a", [[30.0, 30.0, 2.0], [0.0; 3]], [4, 4, 2], element),
            part("b", [[20.0, 20.0, 2.0], [5.0, 5.0, 2.0]], [3, 3, 2], element),
        )
    };
    let (of_a, of_b) = (skin("a"), skin("b"));
    let (faces, skins) = (["\"b.z-min\"", "\"a.z-max\""], [of_b.as_str(), of_a.as_str()]);
    for element in ["hex8", "tet10"] {
        for friction in ["\"bonded\"", "{ coulomb = 0.3 }"] {
            let [by_faces, by_skins] = [faces, skins].map(|named| solved(&text(named, friction, 10.0, element)));
            is(normal_force(&by_skins, "joint"), 4000.0, 4000.0);
            same(&by_faces, &by_skins);
        }
        let pulled = case::parse(&text(skins, "{ coulomb = 0.3 }", -0.1, element), "case.toml", &[]).unwrap();
        let prepared = prepare(&pulled).unwrap();
        let outcome = solve(&prepared, &Settings::of(&pulled.solver), &mut |_| ControlFlow::Continue(())).unwrap();
        assert_eq!(outcome.solution.status, Status::NoEquilibrium);
    }
}

/// Every order of three parts.
fn in_any_order([a, b, c]: [&str; 3]) -> [String; 6] {
    [[a, b, c], [a, c, b], [b, a, c], [b, c, a], [c, a, b], [c, b, a]].map(|parts| parts.concat())
}

/// A block stands near the edge of another one, half a millimetre before a wall that neither of them comes near: the wall changes
/// nothing, whatever nodes its contact names.
#[test]
fn a_contact_that_never_touches_takes_no_edge_from_another() {
    let blocks = "[materials.m]\nyoung = 1000\npoisson = 0.3\n[[fix]]\non = \"a.z-min\"\n\
                  [[load]]\non = \"b.z-max\"\nforce = [0, 0, -10]\nabout = [5, 2, 6]\n";
    let joint = contact("joint", "\"b.z-min\"", "\"a.z-max\"");
    let wall =
        contact("wall", "[\"a.x-max\", \"b.x-max\"]", "\"s.x-min\"") + "slave = \"on\"\n[[fix]]\non = \"s.x-max\"\n";
    for (element, path) in [("hex8", "auto"), ("tet10", "auto"), ("hex20", "auto"), ("hex8", "multigrid")] {
        let [a, b] =
            [("a", 0.0), ("b", 3.0)].map(|(name, z)| part(name, [[6.0, 4.0, 3.0], [0.0, 0.0, z]], [3, 2, 2], element));
        let s = part("s", [[2.0, 4.0, 6.0], [6.5, 0.0, 0.0]], [1, 3, 4], element);
        let path = format!("[solver]\npath = \"{path}\"\n");
        let alone = solved(&format!("{a}{b}{blocks}{joint}{path}"));
        let wanted = largest(&displacement(&alone));
        for parts in in_any_order([&a, &b, &s]) {
            let run = solved(&format!("{parts}{blocks}{joint}{wall}{path}"));
            let found = largest(&displacement(&run));
            assert!((found / wanted - 1.0).abs() < 1e-6, "{element} {path}: {found} where {wanted} is wanted");
            is(normal_force(&run, "joint"), 10.0, 10.0);
            is(normal_force(&run, "wall"), 0.0, 10.0);
        }
    }
}

/// A plate lies over the joint of a hard and a soft block that touch, its load above the hard one, whose edge carries it: the soft one,
/// 40 000 times softer, carries next to nothing.
#[test]
fn blocks_that_touch_below_a_plate_keep_an_edge_in_any_order() {
    let hard = part("hard", [[10.0, 10.0, 5.0], [0.0; 3]], [2, 3, 3], "hex8");
    let soft = part("soft", [[8.0, 10.0, 5.0], [10.0, 0.0, 0.0]], [4, 3, 3], "hex8");
    let plate = part("plate", [[14.0, 6.0, 4.0], [2.0, 2.0, 5.0]], [7, 3, 2], "hex8");
    let materials: String = [("hard", 2e5), ("soft", 5.0), ("plate", 2e6)]
        .map(|(name, young)| format!("[materials.{name}]\non = \"{name}\"\nyoung = {young}\npoisson = 0.3\n"))
        .concat();
    let held = "[[fix]]\non = [\"hard.z-min\", \"soft.z-min\"]\n[[fix]]\non = \"plate.z-max\"\ncomponents = \"y\"\n\
                [[load]]\non = \"plate.z-max\"\nforce = [0, 0, -100]\nabout = [9, 5, 9]\n";
    let below = contact("below", "\"plate.z-min\"", "[\"hard.z-max\", \"soft.z-max\"]");
    let side = contact("side", "\"hard.x-max\"", "\"soft.x-min\"");
    let wanted = largest(&displacement(&solved(&format!("{hard}{soft}{plate}{materials}{held}{below}"))));
    for parts in in_any_order([&hard, &soft, &plate]) {
        let run = solved(&format!("{parts}{materials}{held}{below}{side}"));
        let found = largest(&displacement(&run));
        assert!((found / wanted - 1.0).abs() < 1e-3, "{found} where {wanted} is wanted");
        is(normal_force(&run, "below"), 100.0, 100.0);
        assert!(normal_force(&run, "side") < 0.02, "{}", normal_force(&run, "side"));
    }
}
