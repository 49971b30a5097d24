//! Planes of symmetry that are across no axis.

use stiction::SolverPath;
use stiction::mesh::Turn;
use stiction::run::{Outcome, Prepared, totals};
use stiction_fixtures::case_run::{displacement, refused, solved};

/// No axis of the body is near one of space after it.
const TURN: Turn = Turn { point: [0.0; 3], axis: [2.0 / 7.0, 3.0 / 7.0, 6.0 / 7.0], degrees: 30.0 };

const STILL: Turn = Turn { degrees: 0.0, ..TURN };

const STEEL: &str = "[materials.steel]\nyoung = 1e3\npoisson = 0.3\ndensity = 1\nexpansion = 1e-3\n";

fn symmetry(on: &str) -> String {
    format!("[[fix]]\non = {on}\ncondition = \"symmetry\"\n")
}

fn placed(turn: &Turn) -> String {
    format!("turn = {{ axis = {:?}, degrees = {:?} }}\n", turn.axis, turn.degrees)
}

/// A quarter of a block, heated and on springs at one side, pressed on a floor that moves and pushed along it; the foot
/// slides in part. Two planes of symmetry meet at an edge that ends on the floor.
fn pressed(turn: &Turn, element: &str, cells: [usize; 3], path: &str) -> String {
    let v = |v: [f64; 3]| format!("{:?}", turn.apply(v));
    format!(
        "[mesh]\nblock = {{ size = [2, 1, 1], cells = {cells:?}, element = \"{element}\" }}\n{}{STEEL}{}{}\
         [[spring]]\non = \"x-max\"\nnormal = 30\ntangential = 20\n\
         [[load]]\non = \"z-max\"\ntraction = {}\n[[load]]\ngravity = {}\n[[load]]\ntemperature = 5\n\
         [[contact]]\non = \"z-min\"\nagainst = {{ plane = {{ point = [0, 0, 0], normal = {} }}, motion = {} }}\n\
         friction = {{ coulomb = 0.2 }}\n[solver]\ntolerance = 1e-12\npath = \"{path}\"\n",
        placed(turn),
        symmetry("\"x-min\""),
        symmetry("\"y-min\""),
        v([3.0, 1.0, -10.0]),
        v([0.0, 2.0, -1.0]),
        v([0.0, 0.0, 1.0]),
        v([0.0, 0.0, 0.005]),
    )
}

/// Two quarters of cylinders of unlike cells, one on the other, with a bolt through the upper one.
fn stacked(turn: &Turn, friction: &str) -> String {
    let v = |v: [f64; 3]| format!("{:?}", turn.apply(v));
    format!(
        "[mesh]\n{}[mesh.parts.base]\nring = {{ radii = [1, 3], height = 1, degrees = 90, cells = [4, 6, 2], element = \"hex8\" }}\n\
         [mesh.parts.top]\nring = {{ radii = [1, 2.5], height = 1, degrees = 90, cells = [3, 5, 2], element = \"hex20\" }}\nmove = [0, 0, 1]\n\
         {STEEL}{}{}[[fix]]\non = \"base.z-min\"\n[[load]]\non = \"top.z-max\"\ntraction = {}\n\
         [[bolt]]\non = \"top\"\naxis = {}\npoint = {}\nshortening = 1e-3\n\
         [[contact]]\non = \"top.z-min\"\nagainst = \"base.z-max\"\nfriction = {friction}\n[solver]\ntolerance = 1e-11\n[[step]]\nuntil = 1\n",
        placed(turn),
        symmetry("[\"base.start\", \"top.start\"]"),
        symmetry("[\"base.end\", \"top.end\"]"),
        v([1.0, 2.0, -9.0]),
        v([0.0, 0.0, 1.0]),
        v([0.0, 0.0, 1.5]),
    )
}

/// Displacements of the second run are those of the first, turned; and so are the forces, which are written in the axes of space.
fn agree(straight: &(Outcome, Prepared), turned: &(Outcome, Prepared), turn: &Turn) {
    let (u, v) = (displacement(straight), displacement(turned));
    let size = u.iter().flatten().fold(0.0, |size: f64, x| size.max(x.abs()));
    for (u, v) in u.iter().zip(&v) {
        let u = turn.apply(*u);
        (0..3).for_each(|c| assert!((u[c] - v[c]).abs() < 1e-9 * size, "{u:?} {v:?}"));
    }
    assert!(!turned.1.model.dofs.rotated.is_empty() && straight.1.model.dofs.rotated.is_empty());
    let m = straight.1.problem.points();
    let [a, b] = [straight, turned].map(|run| &run.0.solution.lambda);
    let size = a.iter().fold(0.0, |size: f64, x| size.max(x.abs()));
    (0..m).for_each(|j| assert!((a[j] - b[j]).abs() < 1e-9 * size, "{} {}", a[j], b[j]));
    let [a, b] = [straight, turned].map(|run| totals(&run.1, &run.0).tangential_force);
    let a = turn.apply(a);
    (0..3).for_each(|c| assert!((a[c] - b[c]).abs() < 1e-9 * size * m as f64, "{a:?} {b:?}"));
}

#[test]
fn a_turned_body_feels_the_same_forces_on_both_paths() {
    for (element, cells, path) in
        [("hex8", [4, 3, 2], "dense"), ("tet10", [2, 1, 1], "dense"), ("hex8", [10, 8, 6], "multigrid")]
    {
        let runs = [STILL, TURN].map(|turn| solved(&pressed(&turn, element, cells, path)));
        agree(&runs[0], &runs[1], &TURN);
        let states = &runs[1].0.solution.states;
        assert!(states.iter().any(|state| *state != states[0]), "nothing slips, or nothing else");
        assert_eq!(
            runs[1].1.facts.contacts[0].surface.guided,
            cells[0] + cells[1] + if element == "hex8" { 1 } else { 4 }
        );
        if path == "multigrid" {
            let cycles = runs.each_ref().map(|run| {
                assert_eq!(run.0.solution.path, SolverPath::Multigrid);
                run.0.solution.counts.products as f64
            });
            assert!((cycles[0] - cycles[1]).abs() <= 0.15 * cycles[0], "{cycles:?}");
        }
    }
}

#[test]
fn turned_bodies_in_contact_with_a_bolt_feel_the_same_forces() {
    for friction in ["{ coulomb = 0.15 }", "\"bonded\""] {
        let runs = [STILL, TURN].map(|turn| solved(&stacked(&turn, friction)));
        agree(&runs[0], &runs[1], &TURN);
    }
}

/// A piece of a tube under pressure inside, between planes of symmetry; plane strain.
fn tube(degrees: f64, around: usize, element: &str) -> String {
    format!(
        "[mesh]\nring = {{ radii = [1, 2], height = 0.2, degrees = {degrees:?}, cells = [8, {around}, 1], element = \"{element}\" }}\n\
         {STEEL}{}{}{}{}[[load]]\non = \"inner\"\npressure = 10\n[[contact]]\non = \"outer\"\n\
         against = {{ cylinder = {{ point = [0, 0, 0], axis = [0, 0, 1], radius = 5, side = \"inside\" }} }}\nfriction = \"none\"\n",
        symmetry("\"start\""),
        symmetry("\"end\""),
        symmetry("\"z-min\""),
        symmetry("\"z-max\""),
    )
}

/// Lame: `u = (1 + nu) p a^2 / (E (b^2 - a^2)) ((1 - 2 nu) r + b^2 / r)`.
#[test]
fn a_sector_of_a_tube_widens_as_lame_says() {
    for (degrees, around) in [(25.0, 2), (60.0, 5), (135.0, 11)] {
        let run = solved(&tube(degrees, around, "hex20"));
        for (x, u) in run.1.mesh.nodes.iter().zip(displacement(&run)) {
            let r = x[0].hypot(x[1]);
            let exact = 1.3 * 10.0 / (1e3 * 3.0) * (0.4 * r + 4.0 / r);
            let (radial, around) = ((u[0] * x[0] + u[1] * x[1]) / r, (u[1] * x[0] - u[0] * x[1]) / r);
            assert!((radial / exact - 1.0).abs() < 2e-4, "{degrees}: {radial} {exact}");
            assert!(around.abs() < 2e-4 * exact);
        }
    }
}

/// Rings pressed over one another: the sector is a third of the quarter, whose planes are across axes.
#[test]
fn a_sector_of_a_press_fit_has_the_pressure_of_the_quarter() {
    let text = |degrees: f64, cells: [usize; 2]| {
        format!(
            "[mesh.parts.hub]\nring = {{ radii = [2, 3], height = 1, degrees = {degrees:?}, cells = [3, {}, 2], element = \"hex8\" }}\n\
             [mesh.parts.shaft]\nring = {{ radii = [1, 2], height = 1, degrees = {degrees:?}, cells = [3, {}, 2], element = \"hex8\" }}\n\
             {STEEL}{}{}{}[[load]]\non = \"hub.z-max\"\ntraction = [0, 0, 0.2]\n\
             [[contact]]\non = \"shaft.outer\"\nagainst = \"hub.inner\"\ngap = -0.01\nfriction = {{ coulomb = 0.3 }}\n[solver]\ntolerance = 1e-11\n",
            cells[0],
            cells[1],
            symmetry("[\"hub.start\", \"shaft.start\"]"),
            symmetry("[\"hub.end\", \"shaft.end\"]"),
            symmetry("\"shaft.z-min\""),
        )
    };
    let (quarter, sector) = (solved(&text(90.0, [9, 12])), solved(&text(30.0, [3, 4])));
    let [whole, third] = [&quarter, &sector].map(|run| totals(&run.1, &run.0).normal_force);
    assert!((whole / 3.0 / third - 1.0).abs() < 1e-9, "{whole} {third}");
    let nodes = || quarter.1.mesh.nodes.iter().zip(displacement(&quarter));
    let largest = nodes().flat_map(|(_, u)| u).fold(0.0, |a: f64, b| a.max(b.abs()));
    for (x, u) in sector.1.mesh.nodes.iter().zip(displacement(&sector)) {
        let near = |y: &[f64; 3]| (0..3).map(|c| (x[c] - y[c]).powi(2)).sum::<f64>();
        // Where the bodies meet two nodes are at one place: the nearer displacement is that of the same body.
        let apart = |v: [f64; 3]| (0..3).map(|c| (u[c] - v[c]).abs()).fold(0.0, f64::max);
        let same = nodes().filter(|(y, _)| near(y) < 1e-18).map(|(_, v)| apart(v)).fold(f64::INFINITY, f64::min);
        assert!(same < 1e-9 * largest, "{x:?} {same}");
    }
}

#[test]
fn what_is_no_plane_of_symmetry_is_told_with_its_face() {
    let edited = |from: &str, to: &str| {
        let text = tube(60.0, 4, "hex8");
        assert!(text.contains(from));
        refused(&text.replacen(from, to, 1))
    };
    // Four faces of fifteen degrees: the outer ones lean by 22.5.
    let curved = edited("on = \"end\"", "on = \"inner\"");
    assert!(
        curved.contains("inner is not flat: its face at (") && curved.contains("leans by 22.5 degrees"),
        "{curved}"
    );
    let twice = edited(
        "[[load]]",
        "[[fix]]\non = \"end\"\ncomponents = \"x\"\nvalue = 0.1\n[[fix]]\non = \"end\"\ncomponents = \"y\"\n[[load]]",
    );
    assert!(twice.contains("is prescribed twice: ") && twice.contains("fix 2, node"), "{twice}");
    // Between two planes a sector cannot move; along one it slides towards the point where the other would be.
    let text = tube(60.0, 4, "hex8").replacen(&symmetry("\"start\""), "", 1);
    let free = refused(text.split("[[contact]]").next().unwrap());
    assert!(free.contains("is free in translation along (0.5, 0.866025, 0)"), "{free}");
}
