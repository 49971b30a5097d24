//! Bodies that nothing but the facets of curved surfaces keeps from moving. What is right is said by the circle that the mesh stands for:
//! half a bush without friction turns on half a pin however its nodes lie, and friction up to its limit holds it.

use std::f64::consts::PI;
use std::sync::Arc;

use stiction::io::case::{self, MeshSource};
use stiction::mesh::MeshNotes;
use stiction::run::{prepare, report};
use stiction_fixtures::case_run::solved_case;

/// Half a bush of radius 10 that is pressed onto half a pin and pushed up at its end, so that it would turn. The nodes of both are moved along their circles
/// in waves of up to `uneven` (radians), and off them in waves of `wavy` (length) that both have in common.
fn warnings(friction: &str, side: f64, [uneven, wavy]: [f64; 2], more: &str) -> Vec<String> {
    let ring = |name: &str, radii: [f64; 2], cells: usize| {
        format!(
            "[mesh.parts.{name}]\nring = {{ radii = {radii:?}, height = 4, degrees = 180, cells = [2, {cells}, 1], element = \"hex8\" }}\n"
        )
    };
    let text = [
        ring("pin", [5.0, 10.0], 24),
        ring("bush", [10.001, 14.0], 19),
        format!(
            "[materials.steel]\nyoung = 210e3\npoisson = 0.3\n[[fix]]\non = \"pin.inner\"\n\
             [[fix]]\non = \"bush.z-min\"\ncomponents = \"z\"\n[[load]]\non = \"bush.outer\"\npressure = 10\n\
             [[load]]\non = \"bush.end\"\nforce = [0, {side:?}, 0]\n\
             [[contact]]\non = \"bush.inner\"\nagainst = \"pin.outer\"\nfriction = {friction}\n{more}"
        ),
    ]
    .concat();
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
    warnings.filter(|text| text.contains("nothing but the facets")).collect()
}

#[test]
fn a_round_bush_without_friction_is_named() {
    let found = warnings("\"none\"", 1e-3, [0.1, 0.0], "");
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
        let found = warnings(friction, 1e-3, uneven, more);
        assert!(found.is_empty(), "{friction} {uneven:?} {more}\n{found:?}");
    }
}
