//! Coefficients of friction from arrays of a mesh file.

use std::path::Path;

use stiction::contact::Friction;
use stiction::io::vtu::{Array, Grid, face_code, write};
use stiction::mesh::{Block, BlockElement, Mesh, block, join, place};
use stiction::run::{Outcome, Prepared};
use stiction_fixtures::case_run::{displacement, refused, solved};

const MU: &str = "{ array = \"mu\" }";

/// Cells that grow along x: `x = 1` lies between the second and the third of four.
fn body() -> Mesh {
    let [size, origin, grading] = [[2.0, 1.0, 1.0], [0.0; 3], [3.0, 1.0, 1.0]];
    block(&Block { size, origin, grading, cells: [4, 2, 2], element: BlockElement::Hex8 }).unwrap()
}

fn file(name: &str, grid: &Grid, points: &[Array], cells: &[Array]) -> String {
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    write(&path, grid, points, cells).unwrap();
    path.display().to_string()
}

/// Pressed on the floor and pushed along it, so that a part slips; `bottom` ends before the other bodies begin.
fn case(file: &str, contacts: &[(&str, &str)]) -> String {
    let contact = |(on, law): &(&str, &str)| {
        format!(
            "[[contact]]\nname = \"{on}\"\non = {{ box = {on} }}\n\
             against = {{ plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }} }}\nfriction = {{ coulomb = {law} }}\n"
        )
    };
    format!(
        "[mesh]\nfile = {file:?}\n[materials.steel]\nyoung = 1e3\npoisson = 0.3\n\
         [[load]]\non = {{ box = [[0, 0, 1], [9, 1, 1]] }}\ntraction = [\"x*x\", 0, -10]\n\
         [[spring]]\non = {{ box = [[0, 0, 0], [9, 0, 1]] }}\nnormal = 20\ntangential = 20\n\
         [solver]\ntolerance = 1e-12\n{}",
        contacts.iter().map(contact).collect::<String>()
    )
}

const BOTTOM: &str = "[[0, 0, 0], [9, 1, 0]]";

fn run(file: &str, law: &str) -> (Outcome, Prepared) {
    solved(&case(file, &[(BOTTOM, law)]))
}

fn apart(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let (a, b) = (a.as_flattened(), b.as_flattened());
    let size = a.iter().fold(0.0, |s: f64, x| s.max(x.abs()));
    a.iter().zip(b).fold(0.0, |s: f64, (x, y)| s.max((x - y).abs())) / size
}

#[test]
fn an_array_of_points_acts_like_the_expression_it_was_made_with() {
    let mesh = body();
    let along: Vec<f64> = mesh.nodes.iter().map(|x| 0.1 + 0.1 * x[0] * x[1]).collect();
    let across: Vec<f64> = mesh.nodes.iter().map(|x| 0.4 - 0.1 * x[0]).collect();
    let arrays = [Array::scalar("mu", &along), Array::scalar("nu", &across)];
    let file = file("mu-points.vtu", &Grid::from_mesh(&mesh), &arrays, &[]);
    let laws = [
        (MU.to_string(), "\"0.1 + 0.1*x*y\""),
        (
            format!("[{MU}, {{ array = \"nu\" }}], direction = [1, 1, 0], limit = 3"),
            "[\"0.1 + 0.1*x*y\", \"0.4 - 0.1*x\"], direction = [1, 1, 0], limit = 3",
        ),
    ];
    for (array, expression) in laws {
        let (a, b) = (run(&file, &array), run(&file, expression));
        assert!(apart(&displacement(&a), &displacement(&b)) < 1e-13);
        assert_eq!(a.1.problem.contact.friction, b.1.problem.contact.friction);
        let states = &a.0.solution.states;
        assert!(states.iter().any(|state| *state != states[0]), "nothing slips, or nothing else");
        let told = a.1.facts.to_string();
        assert!(told.contains("by the array \"mu\" (from 0.1 to 0.3"), "{told}");
    }
}

#[test]
fn between_cells_a_point_has_the_mean_by_area_and_equal_cells_are_a_number() {
    let mesh = body();
    let middle = mesh.nodes.iter().map(|x| x[0]).filter(|x| *x > 0.0).fold([9.0, 9.0], |[first, second], x| {
        if x < first { [x, first] } else { [first, if x > first { second.min(x) } else { second }] }
    });
    let right = |cell: &[u32]| cell.iter().all(|&n| mesh.nodes[n as usize][0] > middle[1] - 1e-9);
    let two: Vec<f64> = mesh.cell_iter().map(|(_, cell)| if right(cell) { 0.5 } else { 0.2 }).collect();
    let same = vec![0.3; two.len()];
    let grid = Grid::from_mesh(&mesh);
    let file = file("mu-cells.vtu", &grid, &[], &[Array::scalar("mu", &two), Array::scalar("same", &same)]);

    let (a, b) = (run(&file, "{ array = \"same\" }"), run(&file, "0.3"));
    assert_eq!(a.1.problem.contact.friction, b.1.problem.contact.friction);
    assert_eq!(displacement(&a), displacement(&b));

    // The widths of the cells left and right of the border.
    let next = mesh.nodes.iter().map(|x| x[0]).filter(|x| *x > middle[1] + 1e-9).fold(9.0, f64::min);
    let (left, width) = (middle[1] - middle[0], next - middle[1]);
    assert!(width > 1.2 * left, "widths that do not differ prove nothing");
    let mean = (0.2 * left + 0.5 * width) / (left + width);
    let found = run(&file, MU).1;
    for (&node, friction) in found.facts.contacts[0].surface.nodes.iter().zip(&found.problem.contact.friction) {
        let x = mesh.nodes[node as usize][0];
        let wanted = if (x - middle[1]).abs() < 1e-9 {
            mean
        } else if x < middle[1] {
            0.2
        } else {
            0.5
        };
        let Friction::Coulomb { coefficient } = friction else { panic!("{friction:?}") };
        assert!((coefficient - wanted).abs() < 1e-15, "{x}: {coefficient} {wanted}");
    }
}

#[test]
fn cells_of_two_bodies_act_like_two_surfaces() {
    let mut other = body();
    place(&mut other, None, [3.0, 0.0, 0.0]);
    let mesh = join(vec![("a".into(), body()), ("b".into(), other)]);
    let count = mesh.cell_count();
    let mu: Vec<f64> = (0..count).map(|cell| if cell < count / 2 { 0.15 } else { 0.4 }).collect();
    let file = file("mu-bodies.vtu", &Grid::from_mesh(&mesh), &[], &[Array::scalar("mu", &mu)]);
    let one = run(&file, MU);
    let two = [("[[0, 0, 0], [2.5, 1, 0]]", "0.15"), ("[[2.5, 0, 0], [9, 1, 0]]", "0.4")];
    let two = solved(&case(&file, &two));
    assert!(apart(&displacement(&one), &displacement(&two)) < 1e-10);
    assert!(apart(&displacement(&one), &displacement(&run(&file, "0.15"))) > 1e-3);
}

#[test]
fn surface_elements_have_their_own_coefficient() {
    let mesh = body();
    let mut grid = Grid::from_mesh(&mesh);
    let mut mu = vec![f64::NAN; mesh.cell_count()];
    for &face in &mesh.group("z-min").unwrap().faces {
        let nodes = mesh.faces[face as usize].nodes();
        // starting elsewhere and turning the other way
        let turned: Vec<u32> = nodes.iter().rev().copied().collect();
        grid.push(face_code(nodes.len()), &turned);
        mu.push(0.3);
    }
    let file = file("mu-faces.vtu", &grid, &[], &[Array::scalar("mu", &mu)]);
    assert_eq!(run(&file, MU).1.problem.contact.friction, run(&file, "0.3").1.problem.contact.friction);
}

#[test]
fn the_surface_with_the_array_carries_the_points() {
    let text = |extra: &str| {
        let mesh = body();
        let mu = vec![0.3; mesh.cell_count()];
        let file = file("mu-pair.vtu", &Grid::from_mesh(&mesh), &[], &[Array::scalar("mu", &mu)]);
        format!(
            "[mesh.parts.base]\nblock = {{ size = [2, 1, 1], cells = [8, 4, 4], origin = [0, 0, -1], element = \"hex8\" }}\n\
             [mesh.parts.top]\nfile = {file:?}\n[materials.steel]\nyoung = 1e3\npoisson = 0.3\n\
             [[fix]]\non = \"base.z-min\"\n[[load]]\non = {{ box = [[0, 0, 1], [2, 1, 1]] }}\ntraction = [2, 0, -10]\n\
             [[contact]]\non = {{ box = [[0, 0, 0], [2, 1, 0]] }}\nname = \"joint\"\nagainst = \"base.z-max\"\n\
             friction = {{ coulomb = {{ array = \"top.mu\" }} }}\n{extra}"
        )
    };
    // `base` is the finer one; a box would take the faces of both bodies at z = 0.
    let text =
        |extra: &str| text(extra).replace("origin = [0, 0, -1]", "origin = [0, 0, -1.001]") + "gap = \"closed\"\n";
    let told = solved(&text("")).1.facts.to_string();
    assert!(told.contains("points on box") && told.contains("its friction is an array"), "{told}");
    let message = refused(&text("slave = \"against\"\n"));
    assert!(message.contains("\"top.mu\" has no value on the face"), "{message}");
}

#[test]
fn arrays_that_are_no_coefficients_are_refused_with_their_place() {
    let mesh = body();
    let at = |value: f64| -> Vec<f64> { mesh.nodes.iter().map(|x| if x[2] == 0.0 { value } else { 0.1 }).collect() };
    let (nan, negative) = (at(f64::NAN), at(-0.2));
    let infinite = vec![f64::INFINITY; mesh.cell_count()];
    let vectors = vec![[0.1; 3]; mesh.nodes.len()];
    let whole = vec![3; mesh.cell_count()];
    let points = [Array::scalar("nan", &nan), Array::scalar("negative", &negative), Array::vector("vectors", &vectors)];
    let cells = [Array::scalar("infinite", &infinite), Array::integer("whole", &whole)];
    let file_with = file("mu-mistakes.vtu", &Grid::from_mesh(&mesh), &points, &cells);
    let message = |name: &str| refused(&case(&file_with, &[(BOTTOM, &format!("{{ array = {name:?} }}"))]));
    for (name, words) in [
        ("nan", "\"nan\" has no value at node 1 at [0.0, 0.0, 0.0] of the contact surface"),
        ("negative", "\"negative\" is -0.2 at node 1"),
        ("infinite", "\"infinite\" is inf on the face with the nodes 1, "),
        ("vectors", "it has 3 components"),
        ("whole", "its whole numbers make groups"),
        ("Negative", "did you mean \"negative\"?"),
        ("mu", "its point arrays are \"nan\", \"negative\", its cell arrays \"infinite\""),
    ] {
        let told = message(name);
        assert!(told.contains(words), "{words:?} is not in\n{told}");
    }
    let bare = file("mu-bare.vtu", &Grid::from_mesh(&mesh), &[], &[]);
    let told = refused(&case(&bare, &[(BOTTOM, MU)]));
    assert!(told.contains("has no array \"mu\"") && told.contains(".vtu file with an array"), "{told}");
}
