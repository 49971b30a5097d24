//! Interfaces that yield, from gaskets to springs far stiffer than the bodies: multigrid takes the cycles of hard contact.

use std::ops::ControlFlow;

use stiction::friction::SolverPath;
use stiction::io::case;
use stiction::linalg::Stop;
use stiction::run::{Plan, solve_case};

/// A floating block on a held one, or on a plane, pressed and drawn along the surface.
struct Job {
    element: &'static str,
    matching: bool,
    on_plane: bool,
    law: &'static str,
    /// Whether supports hold components of the block at two edges of the surface.
    held: bool,
    /// The stiffness along the surface over that along the normal.
    tangential: f64,
}

/// The cycles, and the largest displacement.
fn solved(job: &Job, stiffness: Option<f64>, path: SolverPath) -> (usize, f64) {
    let Job { element, matching, on_plane, law, held: has_edges, tangential } = job;
    let quadratic = ["tet10", "hex20"].contains(element);
    let [high, low] = if quadratic { ["6, 6, 3", "5, 5, 2"] } else { ["12, 12, 5", "10, 10, 4"] };
    let low = if *matching { high } else { low };
    let part = |name: &str, cells: &str, z: f64| {
        format!(
            "[mesh.parts.{name}]\nblock = {{ size = [40, 40, 14], cells = [{cells}], element = \"{element}\" }}\n\
             move = [0, 0, {z}]\n"
        )
    };
    let held = part("low", low, 0.0) + "[[fix]]\non = \"low.z-min\"\n";
    let against = match on_plane {
        true => "{ plane = { point = [0, 0, 14], normal = [0, 0, 1] } }",
        false => "\"low.z-max\"",
    };
    let yields = stiffness
        .map_or(String::new(), |k| format!("stiffness = {{ normal = {k:e}, tangential = {:e} }}\n", tangential * k));
    let text = [
        if *on_plane { String::new() } else { held },
        part("high", high, 14.0),
        format!(
            "[materials.steel]\nyoung = 210e3\npoisson = 0.3\n[[load]]\non = \"high.z-max\"\ntraction = [1, 0, -5]\n\
             [[contact]]\non = \"high.z-min\"\nagainst = {against}\nfriction = {law}\nslave = \"on\"\n"
        ),
        yields,
        match has_edges {
            true => {
                "[[fix]]\non = \"high.x-min\"\ncomponents = \"x\"\n[[fix]]\non = \"high.y-min\"\ncomponents = \"y\"\n"
                    .to_string()
            }
            false => String::new(),
        },
        "[solver]\ntolerance = 1e-9\n".to_string(),
    ]
    .concat();
    let text = if *on_plane { text.replace("slave = \"on\"\n", "") } else { text };
    let mut case = case::parse(&text, "case.toml", &[]).unwrap();
    case.solver.path = path;
    let (_, outcome, _) =
        solve_case(&case, &Plan::default(), &Stop::never(), None, &mut |_| ControlFlow::Continue(())).unwrap();
    let solution = &outcome.solution;
    assert!(solution.certificate.passed && solution.path == path, "{element} {stiffness:?} {:?}", solution.status);
    (solution.counts.cycles, solution.u.iter().fold(0.0, |m: f64, u| m.max(u.abs())))
}

const COULOMB: &str = "{ coulomb = 0.3 }";

/// Springs of 100 N/mm^3 make the block sink by 0.05, those of 1e9 by 5e-9 mm.
#[test]
fn cycles_are_those_of_hard_contact_however_stiff_the_interface_is() {
    for (element, matching, on_plane, law, tangential) in [
        ("tet4", false, false, COULOMB, 1.0),
        ("hex8", false, false, COULOMB, 1.0),
        ("hex8", true, false, COULOMB, 1.0),
        ("hex8", false, true, COULOMB, 0.01),
        ("tet10", false, false, COULOMB, 1.0),
        ("tet10", true, true, COULOMB, 1.0),
        ("hex20", false, false, COULOMB, 1.0),
        ("wedge6", true, true, "\"bonded\"", 1.0),
        ("tet10", false, false, "\"bonded\"", 1.0),
        ("tet10", false, false, "\"none\"", 0.01),
        ("wedge6", false, false, "\"none\"", 0.01),
    ] {
        let job = Job { element, matching, on_plane, law, held: law == "\"none\"", tangential };
        let (hard, _) = solved(&job, None, SolverPath::Multigrid);
        for stiffness in [1e2, 1e4, 1e5, 1e6, 1e7, 1e9] {
            let (cycles, _) = solved(&job, Some(stiffness), SolverPath::Multigrid);
            assert!(2 * cycles <= 3 * hard, "{element} {matching} {law} {stiffness:e}: {cycles}, hard {hard}");
        }
    }
}

#[test]
fn stiff_and_soft_interfaces_have_the_solution_of_the_direct_path() {
    for (element, matching, stiffness) in
        [("hex8", true, 1e3), ("hex8", false, 1e7), ("tet10", false, 1e6), ("tet4", true, 1e8)]
    {
        let job = Job { element, matching, on_plane: false, law: COULOMB, held: false, tangential: 1.0 };
        let [multigrid, direct] =
            [SolverPath::Multigrid, SolverPath::Solves].map(|path| solved(&job, Some(stiffness), path).1);
        assert!((multigrid / direct - 1.0).abs() < 1e-7, "{element} {stiffness:e}: {multigrid} {direct}");
        // Hard contact is what ever stiffer springs tend to: they are compressed by the pressure over the stiffness.
        let hard = solved(&job, None, SolverPath::Multigrid).1;
        let more = multigrid - hard;
        assert!(0.0 < more && more < 4.0 * 5.0 / stiffness, "{element} {stiffness:e}: {more}");
    }
}
