//! Supports along axes of their own.

use stiction_fixtures::case_run::{at, displacement, refused, solved};

const STEEL: &str = "[materials.steel]\nyoung = 210e3\npoisson = 0.3\n";

/// A bar under torsion, u = a z (-y, x, 0), is in equilibrium (A. Love, A Treatise on the Mathematical Theory of Elasticity,
/// art. 216): prescribed on the boundary, quadratic cells have it inside.
#[test]
fn torsion_prescribed_about_an_axis_is_found_exactly() {
    for element in ["hex20", "tet10"] {
        let text = format!(
            "[mesh]\nblock = {{ size = [1, 1, 1], cells = [2, 2, 2], origin = [1, -0.5, 0], element = \"{element}\" }}\n{STEEL}\
             [[fix]]\non = [\"x-min\", \"x-max\", \"y-min\", \"y-max\", \"z-min\", \"z-max\"]\ncomponents = \"zrt\"\n\
             axes = {{ point = [0, 0, -3], axis = [0, 0, 2] }}\nvalue = [0, 0, \"1e-3*z*sqrt(x^2 + y^2)\"]\n"
        );
        let run = solved(&text);
        for (x, u) in run.1.mesh.nodes.iter().zip(displacement(&run)) {
            let exact = [-1e-3 * x[2] * x[1], 1e-3 * x[2] * x[0], 0.0];
            assert!((0..3).all(|c| (u[c] - exact[c]).abs() < 1e-14), "{element}: {u:?} where {exact:?} is exact");
        }
    }
}

/// Displacements prescribed along turned axes, contact with friction included, are those along x, y, z.
#[test]
fn turned_axes_say_the_same_as_those_of_the_mesh() {
    let text = |fix: &str| {
        format!(
            "[mesh]\nblock = {{ size = [2, 1, 1], cells = [4, 2, 2], element = \"hex8\" }}\n{STEEL}\
             [[fix]]\non = \"z-max\"\n{fix}\n[[contact]]\non = \"z-min\"\nfriction = {{ coulomb = 0.3 }}\n\
             against = {{ plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }} }}\n"
        )
    };
    // Along (3, 4, 0)/5 and (-4, 3, 0)/5.
    let one = solved(&text("value = [-1e-3, 2e-3, -4e-3]"));
    let other = solved(&text("axes = [[3, 4, 0], [0, 1, 0]]\nvalue = [1e-3, 2e-3, -4e-3]"));
    for (a, b) in displacement(&one).iter().zip(displacement(&other)) {
        assert!((0..3).all(|c| (a[c] - b[c]).abs() < 1e-10), "{a:?} {b:?}");
    }
    let cylinder = solved(&text(
        "axes = { point = [0.9, 0.4, 7], axis = [0, 0, 1] }\ncomponents = \"zrt\"\n\
         value = [-4e-3, 0, \"1e-3*sqrt((x - 0.9)^2 + (y - 0.4)^2)\"]",
    ));
    let u = at(&cylinder, [2.0, 1.0, 1.0]);
    assert!((u[0] + 0.6e-3).abs() < 1e-15 && (u[1] - 1.1e-3).abs() < 1e-15, "{u:?}");
}

#[test]
fn axes_that_make_no_sense_are_refused() {
    let text = |fix: &str| {
        format!(
            "[mesh]\nblock = {{ size = [2, 2, 1], cells = [2, 2, 2], element = \"hex8\" }}\n{STEEL}[[fix]]\non = \"z-max\"\n{fix}\n"
        )
    };
    let read = |fix: &str| stiction::io::case::parse(&text(fix), "case.toml", &[]).map(|_| ()).unwrap_err().to_string();
    let message = read("axes = [[1, 0, 0], [2, 0, 0]]");
    assert!(message.contains("do not span a plane"), "{message}");
    let message = read("axes = { point = [0, 0, 0], axis = [0, 0, 0] }");
    assert!(message.contains("has no direction"), "{message}");
    let message = read("axes = { point = [0, 0, 0], axis = [0, 0, 1] }\ncomponents = \"xy\"");
    assert!(message.contains("some of r, t, z"), "{message}");
    let message = read("axes = [[1, 0, 0], [0, 1, 0]]\ncondition = \"symmetry\"");
    assert!(message.contains("`axes`"), "{message}");
    let message = refused(&text("axes = { point = [1, 1, 0], axis = [0, 0, 1] }"));
    assert!(message.contains("lies on the axis of the cylinder"), "{message}");
    let message =
        refused(&text("axes = [[1, 1, 0], [0, 1, 0]]\n[[fix]]\non = \"z-max\"\ncomponents = \"x\"\nvalue = 1"));
    assert!(message.contains("prescribed twice"), "{message}");
}
