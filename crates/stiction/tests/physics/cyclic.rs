//! Cyclic symmetry: one sector against the whole it stands for.

use stiction::run::{Outcome, Prepared, totals};
use stiction_fixtures::case_run::{at, is, refused, solved};

/// A square plate on a floor, pressed and twisted at its rim, held at the middle of its top: nothing in it is symmetric about
/// a plane. The whole, or the quarter between the planes x = 0 and y = 0.
fn plate(whole: bool, element: &str, path: &str) -> String {
    let (size, cells, origin) = if whole { ("[2, 2, 0.5]", "[8, 8, 2]", -1) } else { ("[1, 1, 0.5]", "[4, 4, 2]", 0) };
    let rim = if whole { "[\"x-min\", \"x-max\", \"y-min\", \"y-max\"]" } else { "[\"x-max\", \"y-max\"]" };
    format!(
        "[mesh]\nblock = {{ size = {size}, cells = {cells}, origin = [{origin}, {origin}, 0], element = \"{element}\" }}\n\
         [materials.steel]\nyoung = 1000\npoisson = 0.3\n\
         [[fix]]\non = {{ box = [[-0.25, -0.25, 0.5], [0.25, 0.25, 0.5]] }}\n\
         [[load]]\non = \"z-max\"\npressure = \"10*(x^2 + y^2)\"\n\
         [[load]]\non = {rim}\ntraction = [\"-y\", \"x\", 0]\n\
         [[contact]]\non = \"z-min\"\nfriction = {{ coulomb = 0.3 }}\n\
         against = {{ plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }} }}\n\
         [solver]\ntolerance = 1e-11\npath = \"{path}\"\n"
    )
}

const CUTS: &str = "[[cyclic]]\non = \"x-min\"\nagainst = \"y-min\"\nsectors = 4\naxis = [0, 0, 3]\n";

fn turned([x, y, z]: [f64; 3], quarters: usize) -> [f64; 3] {
    (0..quarters).fold([x, y, z], |[x, y, z], _| [-y, x, z])
}

/// The answer of each place of the whole is that of the sector, turned.
fn same(whole: &(Outcome, Prepared), sector: &(Outcome, Prepared), tolerance: f64) {
    let largest = sector.0.solution.u.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
    for &x in &sector.1.mesh.nodes {
        let u = at(sector, x);
        for quarters in 0..4 {
            let (wanted, found) = (turned(u, quarters), at(whole, turned(x, quarters)));
            for c in 0..3 {
                assert!((wanted[c] - found[c]).abs() <= tolerance * largest, "{x:?}: {found:?} for {wanted:?}");
            }
        }
    }
    let [whole, sector] = [whole, sector].map(|run| totals(&run.1, &run.0));
    is(4.0 * sector.normal_force, whole.normal_force, 1e9 * tolerance * whole.normal_force);
    assert!(sector.slip > 0 && sector.stick > 0, "{sector:?}");
}

#[test]
fn a_sector_moves_as_its_part_of_the_whole() {
    for element in ["hex8", "hex20"] {
        let whole = solved(&plate(true, element, "auto"));
        for path in ["dense", "solves", "auto"] {
            same(&whole, &solved(&(plate(false, element, path) + CUTS)), 1e-8);
        }
    }
}

/// The other way round the cut that follows is behind the one it follows.
#[test]
fn either_cut_may_follow_the_other() {
    let whole = solved(&plate(true, "hex8", "auto"));
    let other = CUTS.replace("x-min", "middle").replace("y-min", "x-min").replace("middle", "y-min");
    same(&whole, &solved(&(plate(false, "hex8", "auto") + &other)), 1e-8);
}

/// A plate on a plate, pressed and twisted: contact points and what they touch lie on the cuts, and each body has nodes in the
/// same places there.
#[test]
fn contact_between_bodies_may_meet_the_cuts() {
    let two = |whole: bool| {
        let (size, cells, low) = if whole { ("[2, 2, 0.5]", "[8, 8, 1]", -1) } else { ("[1, 1, 0.5]", "[4, 4, 1]", 0) };
        let part = |name: &str, z: f64| {
            format!(
                "[mesh.parts.{name}]\nblock = {{ size = {size}, cells = {cells}, origin = [{low}, {low}, {z}], element = \"hex8\" }}\n"
            )
        };
        part("low", 0.0)
            + &part("high", 0.5)
            + "[materials.steel]\nyoung = 1000\npoisson = 0.3\n[[fix]]\non = \"low.z-min\"\n\
               [[load]]\non = \"high.z-max\"\ntraction = [\"-2.7*y\", \"2.7*x\", \"-10*(x^2 + y^2)\"]\n\
               [[contact]]\nname = \"seat\"\non = \"high.z-min\"\nagainst = \"low.z-max\"\nfriction = { coulomb = 0.4 }\n\
               [solver]\ntolerance = 1e-11\n"
    };
    let cuts = CUTS.replace("\"x-min\"", "[\"low.x-min\", \"high.x-min\"]");
    let cuts = cuts.replace("\"y-min\"", "[\"low.y-min\", \"high.y-min\"]");
    same(&solved(&two(true)), &solved(&(two(false) + &cuts)), 1e-8);
}

#[test]
fn cuts_that_do_not_match_are_refused() {
    let with = |old: &str, new: &str| refused(&(plate(false, "hex8", "auto") + &CUTS.replace(old, new)));
    assert!(with("sectors = 4", "sectors = 5").contains("away from the nearest node of y-min turned by 360/5 degrees"));
    assert!(with("axis = [0, 0, 3]", "axis = [0, 1, 3]").contains("away from the nearest node"));
    assert!(with("against = \"y-min\"", "against = \"z-max\"").contains("the cuts do not match: x-min has"));
    assert!(with("against = \"y-min\"", "against = \"x-min\"").contains("away from the nearest node"));
}
