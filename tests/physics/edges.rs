//! Surfaces with sharp edges, named whole, and counterparts that end under them: contact is that of the faces that look at
//! one another.

use std::ops::ControlFlow;

use stiction::friction::Status;
use stiction::io::case;
use stiction::run::{Event, Settings, prepare, solve};
use stiction_fixtures::case_run::{displacement, solved};
use stiction_fixtures::folder::Folder;

/// To the tolerance of the solver.
#[track_caller]
fn is(value: f64, wanted: f64, scale: f64) {
    assert!((value - wanted).abs() <= 1e-7 * scale, "{value} where {wanted} is wanted");
}

/// All faces of a part of the mesh.
fn skin(part: &str) -> String {
    let side = |side: &str| format!("\"{part}.{side}\"");
    ["x-min", "x-max", "y-min", "y-max", "z-min", "z-max"].map(side).join(", ")
}

fn status(text: &str) -> Status {
    let case = case::parse(text, "case.toml", &[]).unwrap_or_else(|e| panic!("{e}"));
    let prepared = prepare(&case).unwrap_or_else(|e| panic!("{e}"));
    let go_on = &mut |_: &Event| ControlFlow::Continue(());
    solve(&prepared, &Settings::of(&case.solver), go_on).unwrap_or_else(|e| panic!("{e}")).solution.status
}

/// A block on one of the same size, free to grow sideways: the stress is uniform, the faces that touch stay plane, and
/// their 400 mm2 carry the pressure 10 straight down.
#[test]
fn blocks_whose_whole_skins_are_named_press_with_the_faces_that_touch() {
    for (element, friction) in
        [("hex8", "\"none\""), ("hex8", "{ coulomb = 0.3 }"), ("tet10", "\"none\""), ("tet4", "\"bonded\"")]
    {
        let (on, against) = (skin("b"), skin("a"));
        let run = solved(&format!(
            r#"
[mesh.parts.a]
block = {{ size = [20, 20, 10], cells = [4, 4, 2], element = "{element}" }}
[mesh.parts.b]
block = {{ size = [20, 20, 10], origin = [0, 0, 10], cells = [5, 3, 2], element = "{element}" }}
[materials.steel]
young = 210e3
poisson = 0.3
[[fix]]
on = "a.z-min"
components = "z"
[[fix]]
on = {{ point = [0, 0, 0] }}
components = "xy"
[[fix]]
on = {{ point = [20, 0, 0] }}
components = "y"
[[fix]]
on = {{ point = [0, 0, 20] }}
components = "xy"
[[fix]]
on = {{ point = [20, 0, 20] }}
components = "y"
[[load]]
on = "b.z-max"
pressure = 10
[[contact]]
on = [{on}]
against = [{against}]
friction = {friction}
"#
        ));
        for (u, x) in displacement(&run).iter().zip(&run.1.mesh.nodes) {
            is(u[2], -10.0 / 210e3 * x[2], 10.0 / 210e3 * 20.0);
            is(u[0], 0.3 * 10.0 / 210e3 * x[0], 10.0 / 210e3 * 20.0);
        }
        let bodies = &run.0.solution.certificate.bodies;
        let pressed = bodies.iter().find(|body| body.name == "b").unwrap().contact;
        (0..3).for_each(|c| is(pressed[c], [0.0, 0.0, 4000.0][c], 4000.0));
    }
}

/// On a plate the sides of the block hold nothing: friction ends at `mu N`, given friction at `tau A`.
#[test]
fn the_sides_of_a_block_add_no_friction() {
    let (bottom, sides) = ("\"b.z-min\"", "\"b.z-min\", \"b.x-min\", \"b.x-max\", \"b.y-min\", \"b.y-max\"");
    let case = |on: &str, against: &str, law: &str, push: f64| {
        format!(
            r#"
[mesh.parts.a]
block = {{ size = [40, 40, 10], origin = [-10, -10, -10], cells = [5, 5, 1], element = "hex8" }}
[mesh.parts.b]
block = {{ size = [20, 20, 10], cells = [3, 4, 2], element = "hex8" }}
[materials.steel]
young = 210e3
poisson = 0.3
[[fix]]
on = "a.z-min"
[[load]]
on = "b.z-max"
force = [{push}, 0, -1000]
[[contact]]
on = [{on}]
against = {against}
friction = {law}
"#
        )
    };
    let plane = "{ plane = { point = [0, 0, 0], normal = [0, 0, 1] } }";
    for on in [bottom, sides] {
        for against in ["\"a.z-max\"", plane] {
            // Pushed above the joint the block would lose its rear edge long after it has slipped.
            for (law, limit) in [("{ coulomb = 0.3 }", 300.0), ("{ tresca = 0.5 }", 200.0)] {
                for (push, wanted) in [(0.99 * limit, Status::Solved), (1.01 * limit, Status::NoEquilibrium)] {
                    assert_eq!(status(&case(on, against, law, push)), wanted, "{on} {against} {law} {push}");
                }
            }
        }
    }
}

/// A plate lies on part of a block, another part of the same counterpart is far above: the pressure 10 on the plate, which
/// is free to grow, goes straight down where its edge runs through faces of the block.
#[test]
fn where_the_counterpart_ends_what_lies_behind_makes_no_overlap() {
    for (from, behind) in [(2.3, 14.0), (2.3, 11.02), (7.7, 14.0), (9.0, 14.0), (11.0, 11.02)] {
        let long = 20.0 - from;
        let run = solved(&format!(
            r#"
[mesh.parts.a]
block = {{ size = [20, 20, 10], cells = [4, 4, 2], element = "hex8" }}
[mesh.parts.p]
block = {{ size = [{long}, 20, 1], origin = [{from}, 0, 10], cells = [5, 5, 1], element = "hex8" }}
[mesh.parts.q]
block = {{ size = [20, 20, 1], origin = [0, 0, {behind}], cells = [5, 5, 1], element = "hex8" }}
[materials.steel]
young = 210e3
poisson = 0.3
[[fix]]
on = "a.z-min"
[[fix]]
on = "q.z-max"
[[fix]]
on = "p.x-max"
components = "xy"
[[load]]
on = "p.z-max"
pressure = 10
[[contact]]
on = "a.z-max"
against = ["p.z-min", "q.z-min"]
friction = "none"
slave = "on"
"#
        ));
        let contact = |name: &str| {
            let bodies = &run.0.solution.certificate.bodies;
            bodies.iter().find(|body| body.name == name).unwrap().contact[2]
        };
        is(contact("p"), 10.0 * long * 20.0, 1e4);
        is(contact("q"), 0.0, 1e4);
        let gap = &run.1.problem.contact.gap;
        assert!(gap.iter().all(|gap| gap.abs() < 1e-12 || *gap > 0.9 * (behind - 10.0)), "{gap:?}");
        // The block alone, under the same pressure on its whole top, yields less than this.
        assert!(displacement(&run).iter().all(|u| u[2] > -3.0 * 10.0 / 210e3 * 11.0));
    }
}

/// The twelve triangles of a box as text; their normals are those of the corners.
fn stl([low, high]: [[f64; 3]; 2]) -> String {
    let corner = |bits: usize| [0, 1, 2].map(|c| if bits >> c & 1 == 1 { high[c] } else { low[c] });
    let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let mut text = String::from("solid box\n");
    for [a, b, c, d] in sides {
        for triangle in [[a, b, c], [a, c, d]] {
            text += "facet normal 0 0 0\nouter loop\n";
            for [x, y, z] in triangle.map(corner) {
                text += &format!("vertex {x} {y} {z}\n");
            }
            text += "endloop\nendfacet\n";
        }
    }
    text + "endsolid box\n"
}

/// A block on a box of triangles as large as it, larger and smaller: nodes at the edges of the box are pushed straight up, and
/// what hangs over slides past them.
#[test]
fn the_edges_of_a_box_of_triangles_push_as_its_faces_do() {
    let folder = Folder::new("edges");
    for over in [-2.0, -0.1, -1e-4, 0.0, 1e-3, 1.0] {
        let box_of = [[-over, -over, -10.0], [20.0 + over, 20.0 + over, 0.0]];
        folder.write("box.stl", stl(box_of));
        let case = |push: f64, law: &str| {
            format!(
                r#"
[mesh]
block = {{ size = [20, 20, 10], cells = [4, 4, 2], element = "hex8" }}
[materials.steel]
young = 210e3
poisson = 0.3
[[load]]
on = "z-max"
force = [{push}, 0, -1000]
[[contact]]
on = "z-min"
against = {{ surface = "{}" }}
friction = {law}
"#,
                folder.at("box.stl").display()
            )
        };
        let run = solved(&case(200.0, "{ coulomb = 0.3 }"));
        let felt = run.0.solution.certificate.bodies[0].contact;
        (0..3).for_each(|c| is(felt[c], [-200.0, 0.0, 1000.0][c], 1e3));
        assert_eq!(status(&case(310.0, "{ coulomb = 0.3 }")), Status::NoEquilibrium, "{over}");
    }
}

/// A flat body above a roof whose flanks fall by 20 degrees: both look at it face to face, and the ridge is what it meets.
#[test]
fn a_ridge_below_a_flat_face_is_met() {
    let fall = 10.0 * 20f64.to_radians().tan();
    let folder = Folder::new("ridge");
    let [a, b, c, d, e, f] = [
        [-10.0, -10.0, -fall],
        [-10.0, 30.0, -fall],
        [0.0, -10.0, 0.0],
        [0.0, 30.0, 0.0],
        [10.0, -10.0, -fall],
        [10.0, 30.0, -fall],
    ];
    let mut text = String::from("solid roof\n");
    for triangle in [[a, c, d], [a, d, b], [c, e, f], [c, f, d]] {
        text += "facet normal 0 0 0\nouter loop\n";
        triangle.iter().for_each(|[x, y, z]| text += &format!("vertex {x} {y} {z}\n"));
        text += "endloop\nendfacet\n";
    }
    folder.write("roof.stl", text + "endsolid roof\n");
    for gap in [0.01, 0.5] {
        // The middle line of nodes stands above the ridge, and comes down by 1e-3 more than the gap.
        let run = solved(&format!(
            r#"
[mesh]
block = {{ size = [10, 20, 10], origin = [-5, 0, {gap}], cells = [4, 4, 2], element = "hex8" }}
[materials.rubber]
young = 1
poisson = 0.3
[[fix]]
on = "z-max"
value = [0, 0, "-{gap} - 1e-3"]
[[contact]]
on = "z-min"
against = {{ surface = "{}" }}
friction = "none"
"#,
            folder.at("roof.stl").display()
        ));
        let felt = run.0.solution.certificate.bodies[0].contact;
        assert!(felt[2] > 1e-3 && felt[0].abs() < 1e-7 * felt[2], "{gap}: {felt:?}");
    }
}
