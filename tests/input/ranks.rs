//! What ranks cannot do, and what is wrong on one of them, is the same error on all of them.

use std::ops::ControlFlow;

use stiction::Error;
use stiction::io::case::{self, Case};
use stiction::ranks::threads;
use stiction::run::solve_on_ranks;

const BODY: &str = "[mesh]\nblock = { size = [3, 1, 1], cells = [6, 2, 2], element = \"hex8\" }\n\
                    [materials.steel]\nyoung = 2e11\npoisson = 0.3\n[[fix]]\non = \"x-min\"\n";
const STEPS: &str = "[[step]]\nname = \"press\"\nuntil = 1\n[[step]]\nname = \"pull\"\nuntil = 2\n";
const FLOOR: &str = "[[contact]]\non = \"z-min\"\n\
                     against = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }\n";

fn refused(text: &str, size: usize) -> Error {
    let case: Case = case::parse(text, "case.toml", &[]).unwrap_or_else(|e| panic!("{e}\n{text}"));
    let all = threads(size, |ranks| {
        solve_on_ranks(&case, &ranks, &mut |_| ControlFlow::Continue(())).map(|_| ()).unwrap_err()
    });
    assert!(all.iter().all(|error| *error == all[0]) && !all[0].remedy.is_empty(), "{all:?}");
    all[0].clone()
}

#[test]
fn what_ranks_cannot_do_is_refused_by_name_at_its_place() {
    let floor = |more: &str| format!("{BODY}{FLOOR}friction = {{ coulomb = 0.3 }}\n{more}");
    let cases = [
        (floor("[accuracy]\nenergy = \"10%\"\nproven = true\n"), "accuracy.proven"),
        (floor("[accuracy]\nproven = true\n"), "accuracy.proven"),
        (
            floor(&format!("{STEPS}[[fix]]\non = \"x-max\"\nuntil = \"press\"\n[accuracy]\nenergy = \"10%\"\n")),
            "[accuracy] with a support or a coupling that begins or ends",
        ),
        // Their nodes are those of the floor, too.
        (
            floor(
                "[[load]]\non = \"z-max\"\npressure = 1e5\n[[equation]]\nterms = [{ on = \"z-min\", along = \"z\" }]\n",
            ),
            "equation",
        ),
        (
            floor("[solver]\npath = \"dense\"\n[accuracy]\nenergy = \"10%\"\n"),
            "[accuracy] with another path than multigrid",
        ),
        (
            floor("stiffness = { normal = 1e12 }\n[solver]\nstarts = 3\n"),
            "with the search for further solutions (solver.starts), cannot",
        ),
        (
            floor("stiffness = { normal = 1e12 }\n[accuracy]\nenergy = \"10%\"\n"),
            "[accuracy] with an interface that yields",
        ),
    ];
    for (text, what) in cases {
        let error = refused(&text, 3);
        assert!(error.what.contains(what) && error.what.contains("divided among ranks"), "{what}: {error}");
        assert!(error.place.starts_with("case.toml:") && error.remedy.contains("stiction solve"), "{error}");
    }
}

#[test]
fn an_error_of_one_rank_is_the_error_of_all() {
    // Seen by rank 0 alone, which has the mesh.
    let error = refused(&format!("{BODY}{}friction = \"none\"\n", FLOOR.replace("z-min", "floor")), 4);
    assert!(error.what.contains("no group \"floor\""), "{error}");
    // Seen by the rank at the far end alone.
    let load = "[[load]]\non = \"z-max\"\ntraction = [0, 0, \"-sqrt(2.5 - x)\"]\n";
    let error = refused(&format!("{BODY}{FLOOR}friction = \"none\"\n{load}"), 4);
    assert!(error.to_string().contains("sqrt(2.5 - x)"), "{error}");
    // Of the law of a surface.
    let law = "friction = { coulomb = \"2.5 - x\" }\n";
    let error = refused(&format!("{BODY}{FLOOR}{law}"), 4);
    assert!(error.what.contains("coefficient of friction is -0.5"), "{error}");
    // Nobody's own mistake.
    let error = refused(&format!("{BODY}{FLOOR}friction = \"none\"\n"), 100);
    assert!(error.what.contains("63 nodes") && error.remedy.contains("fewer ranks"), "{error}");
    // A body that slides along y without friction: a matter of the points of all ranks.
    let loose = format!("{}{FLOOR}friction = \"none\"\n", BODY.replace("x-min\"", "x-min\"\ncomponents = \"x\""));
    let error = refused(&loose, 2);
    assert!(error.what.contains("no contact resists some rigid motion of body"), "{error}");
}
