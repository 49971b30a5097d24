//! Bodies that nothing but the facets of curved surfaces keeps from moving. What is right is said by the circle that the mesh stands for:
//! half a bush without friction turns on half a pin however its nodes lie, and friction up to its limit holds it.

use std::f64::consts::PI;
use std::sync::Arc;

use stiction::io::case::{self, MeshSource};
use stiction::mesh::MeshNotes;
use stiction::run::{prepare, report};
use stiction_fixtures::case_run::solved_case;
use stiction_fixtures::folder::Folder;

/// Half a bush of radius 10 that is pressed onto half a pin and pushed up at its end, so that it would turn. The nodes of both are moved along their circles
/// in waves of up to `uneven` (radians), and off them in waves of `wavy` (length) that both have in common. The bush is `drawn` along its axis.
fn warnings(friction: &str, drawn: f64, [uneven, wavy]: [f64; 2], more: &str) -> Vec<String> {
    let pin = ring("pin", [5.0, 10.0], 24) + "[[fix]]\non = \"pin.inner\"\n";
    let contact = format!("against = \"pin.outer\"\nfriction = {friction}\n");
    warnings_of(&pin, &contact, drawn, [uneven, wavy], more)
}

fn ring(name: &str, radii: [f64; 2], cells: usize) -> String {
    format!(
        "[mesh.parts.{name}]\nring = {{ radii = {radii:?}, height = 4, degrees = 180, cells = [2, {cells}, 1], element = \"hex8\" }}\n"
    )
}

fn warnings_of(pin: &str, contact: &str, drawn: f64, [uneven, wavy]: [f64; 2], more: &str) -> Vec<String> {
    let text = ring("bush", [10.001, 14.0], 19)
        + pin
        + "[materials.steel]\nyoung = 210e3\npoisson = 0.3\n[[load]]\non = \"bush.outer\"\npressure = 10\n"
        + "[[load]]\non = \"bush.end\"\nforce = [0, 0.001, 0]\n"
        + &format!("[[fix]]\non = \"bush.z-min\"\ncomponents = \"z\"\nvalue = [{drawn:?}]\n")
        + "[[contact]]\non = \"bush.inner\"\n"
        + contact
        + more;
    let mut case = case::parse(&text, "case.toml", &[]).unwrap();
    let mut mesh = prepare(&case).unwrap().mesh;
    let of_bush = mesh.cell_nodes(&mesh.group("bush").unwrap().cells);
    for (node, x) in mesh.nodes.iter_mut().enumerate() {
        let is_bush = of_bush.binary_search(&(node as u32)).is_ok();
        let (angle, radius) = (x[1].atan2(x[0]), x[0].hypot(x[1]));
        let (waves, phase): (f64, f64) = if is_bush { (9.0, 1.0) } else { (7.0, 0.3) };
        let (begin, end) = (phase.sin(), (waves * PI + phase).sin());
        let along = angle / PI;
        // The ends stay where they are.
        let moved = (waves * angle + phase).sin() - begin * (1.0 - along) - end * along;
        let (angle, radius) = (angle + 0.5 * uneven * moved, radius + wavy * (6.0 * angle).cos());
        (x[0], x[1]) = (radius * angle.cos(), radius * angle.sin());
    }
    case.mesh.source = MeshSource::Given(Arc::new((mesh, MeshNotes::default())));
    let (outcome, prepared) = solved_case(&case);
    let rows = report(&prepared, &outcome).rows;
    let warnings = rows.into_iter().filter(|row| row.label == "warning").map(|row| row.value);
    warnings.filter(|text| text.contains("than the facets")).collect()
}

#[test]
fn a_round_bush_without_friction_is_named() {
    let found = warnings("\"none\"", 0.0, [0.1, 0.0], "");
    assert_eq!(found.len(), 1);
    assert!(found[0].contains("body \"bush\"") && found[0].contains("rotation"), "{found:?}");
}

#[test]
fn what_friction_supports_or_a_shape_hold_is_not() {
    let held = "[[fix]]\non = \"bush.start\"\ncomponents = \"y\"\n";
    let wavy = 0.3;
    for (friction, uneven, more) in [
        ("{ coulomb = 0.3 }", [0.1, 0.0], ""),
        ("\"none\"", [0.1, 0.0], held),
        // Both surfaces have six waves, as steep as 18 %: their shape holds the bush.
        ("\"none\"", [0.1, wavy], ""),
    ] {
        let found = warnings(friction, 0.0, uneven, more);
        assert!(found.is_empty(), "{friction} {uneven:?} {more}\n{found:?}");
    }
}

/// Friction that is at its limit along the axis resists what turns the slip: all points slip, and the bush turns as far as that says.
#[test]
fn a_bush_that_is_drawn_along_its_axis_is_not() {
    assert!(warnings("{ coulomb = 0.2 }", 0.1, [0.1, 0.0], "").is_empty());
    assert_eq!(warnings("\"none\"", 0.1, [0.1, 0.0], "").len(), 1);
}

/// A shaft of triangles that stands for a round one, and one whose six waves hold the bush.
#[test]
fn a_shaft_of_triangles_is_named_as_far_as_its_shape_is_round() {
    for (facets, wavy, named) in [(24, 0.0, 1), (40, 0.0, 1), (120, 0.3, 0)] {
        let at = |k: usize, z: f64| {
            let angle = 2.0 * PI * (k % facets) as f64 / facets as f64;
            let radius = 10.0 + wavy * (6.0 * angle).cos();
            format!("vertex {:?} {:?} {z:?}\n", radius * angle.cos(), radius * angle.sin())
        };
        let (low, high) = (-1.0, 5.0);
        let triangle =
            |corners: [String; 3]| format!("facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n", corners.concat());
        let panel = |k: usize| {
            triangle([at(k, low), at(k + 1, low), at(k + 1, high)])
                + &triangle([at(k, low), at(k + 1, high), at(k, high)])
        };
        let folder = Folder::new(&format!("shaft-{facets}"));
        let text: String = (0..facets).map(panel).collect();
        folder.write("shaft.stl", format!("solid shaft\n{text}endsolid shaft\n"));
        let contact =
            format!("against = {{ surface = {:?} }}\nfriction = \"none\"\n", folder.at("shaft.stl").display());
        let found = warnings_of("", &contact, 0.0, [0.1, wavy], "");
        assert_eq!(found.len(), named, "{facets} {found:?}");
    }
}
