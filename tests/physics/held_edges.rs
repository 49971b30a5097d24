//! Between bodies: supports that hold nodes along the surface while the other body moves below them, and surfaces that lie apart.

use std::ops::ControlFlow;

use stiction::contact::{Reason, Role};
use stiction::friction::{SolverPath, Status};
use stiction::io::case;
use stiction::run::{Outcome, Prepared, Settings, Totals, pair_totals, prepare, solve};

fn run(text: &str) -> (Prepared, Outcome) {
    let case = case::parse(text, "case.toml", &[]).unwrap_or_else(|e| panic!("{e}"));
    let prepared = prepare(&case).unwrap_or_else(|e| panic!("{e}"));
    let outcome = solve(&prepared, &Settings::of(&case.solver), &mut |_| ControlFlow::Continue(())).unwrap();
    assert_eq!(outcome.solution.status, Status::Solved);
    assert!(outcome.solution.certificate.passed);
    (prepared, outcome)
}

fn only_pair(run: &(Prepared, Outcome)) -> Totals {
    pair_totals(&run.0, &run.1).remove(0).1
}

/// A pad of 20 x 20 x 10 that is held along x at its side x = 0, pressed by 1000 on a strip; `strip` says what holds and moves that.
fn pad_on_strip(element: &str, [pad, strip]: [&str; 2], moves: &str, more: &str) -> String {
    format!(
        "[mesh.parts.a]\nblock = {{ size = [20, 20, 10], cells = {pad}, element = \"{element}\", origin = [0, 0, 4] }}\n\
         [mesh.parts.b]\nblock = {{ size = [40, 20, 4], cells = {strip}, element = \"{element}\", origin = [-10, 0, 0] }}\n\
         [materials.s]\nyoung = 210e3\npoisson = 0.3\nexpansion = 1e-5\n\
         {moves}\n\
         [[fix]]\non = \"a.x-min\"\ncomponents = \"x\"\n\
         [[load]]\non = \"a.z-max\"\nforce = [0, 0, -1000]\n\
         [[contact]]\nname = \"c\"\non = \"a.z-min\"\nagainst = \"b.z-max\"\nfriction = {{ coulomb = 0.3 }}\n{more}\n"
    )
}

const PULLED: &str = "[[fix]]\non = \"b.z-min\"\nvalue = [0.5, 0, 0]";
const HEATED: &str = "[[fix]]\non = \"b.x-min\"\n[[fix]]\non = \"b.z-min\"\ncomponents = \"z\"\n\
                      [[load]]\non = \"b\"\ntemperature = 200";

/// A strip drawn away below a pad carries it along with the coefficient times the force, wherever the pad is held, and the support
/// of the pad has that force.
#[test]
fn friction_is_whole_where_a_support_ends_in_the_contact() {
    for (element, cells) in [("hex8", ["[4, 4, 2]", "[9, 5, 1]"]), ("tet10", ["[2, 2, 1]", "[5, 3, 1]"])] {
        for slave in ["slave = \"on\"", "slave = \"against\"", ""] {
            for path in ["dense", "solves", "auto"] {
                let more = format!("{slave}\n[solver]\npath = \"{path}\"");
                let found = run(&pad_on_strip(element, cells, PULLED, &more));
                let totals = only_pair(&found);
                let [x, y, _] = totals.tangential_force;
                assert!((totals.normal_force - 1000.0).abs() < 1e-5, "{element} {more}: {totals:?}");
                // Slips sideways by Poisson are parts of a thousand of the 0.5 of the strip.
                assert!((x - 300.0).abs() < 0.1 && y.abs() < 1.0, "{element} {more}: {totals:?}");
                assert_eq!((totals.stick, totals.open), (0, 0), "{element} {more}");
                let surface = &found.0.facts.contacts[0].surface;
                assert_eq!(surface.held_along_surface > 0, slave == "slave = \"on\"", "{element} {more}");
                let of_pad = found.1.solution.certificate.bodies.iter().find(|body| body.name == "a").unwrap();
                assert!((of_pad.support[0] + x).abs() < 1e-6 * x, "{element} {more}: {of_pad:?}");
            }
        }
    }
}

/// Points are put where no support holds them along the surface, though these faces are larger.
#[test]
fn the_choice_of_the_slave_avoids_nodes_that_are_held_where_the_other_body_moves() {
    let found = run(&pad_on_strip("hex8", ["[6, 6, 2]", "[8, 4, 1]"], PULLED, ""));
    let pair = found.0.facts.contacts[0].surface.pair.clone().unwrap();
    assert_eq!((pair.slave, pair.reason), (Role::Against, Reason::Unheld));
}

/// A strip that is heated slides outwards below the pad, and both surfaces as slaves tell the same of it.
#[test]
fn a_strip_that_is_heated_drags_a_held_pad() {
    let cells = ["[8, 8, 2]", "[9, 5, 1]"];
    let [on, against] = ["on", "against"].map(|slave| {
        only_pair(&run(&pad_on_strip("hex8", cells, HEATED, &format!("slave = \"{slave}\"")))).tangential_force[0]
    });
    assert!((on - against).abs() < 0.01 * against && against > 250.0, "{on} {against}");
}

/// What a whole pad that is held sideways leaves to the strip: more points than the strip has nodes below them.
#[test]
fn a_pad_held_everywhere_along_the_surface_is_dragged_over() {
    for (pad, strip) in [("[4, 4, 2]", "[9, 5, 1]"), ("[8, 8, 2]", "[6, 3, 1]")] {
        let text = pad_on_strip("hex8", [pad, strip], PULLED, "slave = \"on\"");
        let totals = only_pair(&run(&text.replace("a.x-min", "a")));
        assert!((totals.tangential_force[0] - 300.0).abs() < 0.1, "{pad}: {totals:?}");
    }
}

/// Multigrid wants the node of a point free along the surface and says so; left the choice, the direct path is taken.
#[test]
fn multigrid_names_the_support_that_holds_a_point() {
    let text =
        pad_on_strip("hex8", ["[4, 4, 2]", "[9, 5, 1]"], PULLED, "slave = \"on\"\n[solver]\npath = \"multigrid\"");
    let case = case::parse(&text, "case.toml", &[]).unwrap();
    let error =
        solve(&prepare(&case).unwrap(), &Settings::of(&case.solver), &mut |_| ControlFlow::Continue(())).unwrap_err();
    assert!(error.what.contains("a support holds a node of point") && error.remedy.contains("`slave`"), "{error}");
    let free = run(&text.replace("slave = \"on\"", ""));
    assert_eq!(free.1.solution.path, SolverPath::Multigrid);
    assert!((only_pair(&free).tangential_force[0] - 300.0).abs() < 0.1);
}

/// On planes of symmetry both surfaces are held, and nothing is added to the rows there; the finer surface stays the slave.
#[test]
fn a_plane_of_symmetry_keeps_its_rows() {
    let quarter = |element: &str, cells: [&str; 2]| {
        pad_on_strip(element, cells, "[[fix]]\non = \"b.z-min\"", "")
            .replace("size = [40, 20, 4]", "size = [30, 20, 4]")
            .replace("origin = [-10, 0, 0]", "origin = [0, 0, 0]")
            + "[[fix]]\non = [\"a.y-min\", \"b.y-min\"]\ncomponents = \"y\"\n[[fix]]\non = \"b.x-min\"\ncomponents = \"x\"\n"
    };
    for (element, cells) in [("hex8", ["[6, 6, 2]", "[5, 3, 1]"]), ("tet10", ["[4, 4, 1]", "[4, 3, 1]"])] {
        let found = run(&quarter(element, cells));
        let surface = &found.0.facts.contacts[0].surface;
        let pair = surface.pair.clone().unwrap();
        assert_eq!((pair.slave, pair.reason), (Role::On, Reason::Finer), "{element}");
        assert_eq!(surface.held_along_surface, 0, "{element}");
        assert!(surface.guided > 0, "{element}");
    }
}

/// Where supports alone say what slides over what, there is no unknown for friction to act on.
#[test]
fn friction_between_what_supports_hold_and_what_they_drive_is_refused() {
    let driven =
        "[[fix]]\non = \"b\"\nvalue = [0.5, 0]\ncomponents = \"xy\"\n[[fix]]\non = \"b.z-min\"\ncomponents = \"z\"";
    let text = pad_on_strip("hex8", ["[4, 4, 2]", "[9, 5, 1]"], driven, "slave = \"on\"");
    let error = case::parse(&text, "case.toml", &[]).and_then(|case| prepare(&case).map(|_| ())).unwrap_err();
    assert!(error.what.contains("supports move the other surface over it"), "{error}");
    let free = only_pair(&run(&text.replace("slave = \"on\"", "")));
    assert!((free.tangential_force[0] - 300.0).abs() < 0.1, "{free:?}");
}

/// Shear that acts at two surfaces a distance apart leaves a couple of both, which the report names; where the surfaces touch there
/// is none.
#[test]
fn a_couple_lost_across_a_distance_that_nothing_closes_is_told() {
    let blocks = |apart: f64, law: &str| {
        format!(
            "[mesh.parts.a]\nblock = {{ size = [20, 20, 10], cells = [4, 4, 2], element = \"hex8\" }}\n\
             [mesh.parts.b]\nblock = {{ size = [20, 20, 10], cells = [5, 3, 2], element = \"hex8\", origin = [0, 0, {}] }}\n\
             [materials.s]\nyoung = 210e3\npoisson = 0.3\n[[fix]]\non = \"a.z-min\"\n\
             [[load]]\non = \"b.z-max\"\nforce = [100, 0, -1000]\n\
             [[contact]]\nname = \"c\"\non = \"b.z-min\"\nagainst = \"a.z-max\"\n{law}\n",
            10.0 + apart
        )
    };
    for law in ["friction = \"bonded\"", "friction = { coulomb = 0.5 }\ngap = \"closed\""] {
        for (apart, told) in [(2.0, true), (0.0, false)] {
            let (prepared, outcome) = run(&blocks(apart, law));
            let rows = stiction::run::report(&prepared, &outcome).rows;
            let row = rows.into_iter().find(|row| row.label == "warning" && row.value.contains("couple"));
            assert_eq!(row.is_some(), told, "{law} {apart}");
            assert!(row.is_none_or(|row| row.value.contains("200, 0)") && row.value.contains("\"c\"")), "{law}");
        }
    }
}
