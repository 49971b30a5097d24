//! Bodies so slender that the last digit of a contact force bends them by what contact notices.

use std::f64::consts::PI;

use stiction::friction::{PointState, Status};
use stiction_fixtures::case_run::solved;

/// The force that a body feels in contact along a coordinate axis.
fn resultant(run: &(stiction::run::Outcome, stiction::run::Prepared), axis: usize) -> f64 {
    let problem = &run.1.problem;
    let force = problem.contact.B.transpose_times(&run.0.solution.lambda);
    let motions = problem.elastic.near_kernel.as_ref().unwrap();
    -force.iter().zip(motions).map(|(force, motion)| force * motion[axis]).sum::<f64>()
}

/// A belt of the thickness `t` half around a fixed cylinder of radius 100, pulled at one end, held back with `pull` at the other.
fn belt(thickness: f64, element: &str, path: &str) -> f64 {
    let (pull, outer) = (20.0 * 2.0 * thickness, 100.0 + thickness);
    let run = solved(&format!(
        r#"
[mesh]
ring = {{ radii = [100, {outer}], height = 2, degrees = 180, cells = [1, 90, 1], element = "{element}" }}
[materials.steel]
young = 2e5
poisson = 0
[[fix]]
on = "z-min"
components = "z"
[[load]]
on = "start"
traction = [0, "-20", 0]
[[fix]]
on = {{ box = [[{}, -0.01, -1], [{}, 0.01, 3]] }}
components = "y"
value = ["-0.2"]
[[contact]]
on = "inner"
against = {{ cylinder = {{ point = [0, 0, 0], axis = [0, 0, 1], radius = 100 }} }}
friction = {{ coulomb = 0.3 }}
[solver]
path = "{path}"
"#,
        -outer - 0.01,
        0.01 - outer
    ));
    assert_eq!(run.0.solution.status, Status::Solved, "{thickness} {element} {path}");
    assert!(!run.0.solution.states.contains(&PointState::Stick), "{thickness} {element} {path}");
    // From zero forces they take 47 to over 200.
    let steps = run.0.solution.counts.newton_steps;
    assert!(steps <= 20, "{thickness} {element} {path}: {steps} Newton steps");
    (resultant(&run, 1) - pull) / pull
}

/// The tensions at the ends of a belt that slips have the ratio `exp(mu pi)` (Euler 1769, Eytelwein 1808), of a belt with a
/// middle surface `t / 2` outside of the friction that of `mu pi R / (R + t / 2)`. What bending and the free ends add falls
/// with the thickness.
#[test]
fn a_thin_belt_around_a_cylinder_holds_by_the_exponential_of_the_angle() {
    for (thickness, element, path) in [
        (1.0, "hex8", "dense"),
        (1.0, "hex8", "solves"),
        (0.5, "hex8", "solves"),
        (2.0, "hex20", "solves"),
        (1.0, "hex20", "solves"),
    ] {
        let wanted = (0.3 * PI * 100.0 / (100.0 + 0.5 * thickness)).exp();
        let ratio = belt(thickness, element, path);
        let lacks = (wanted - ratio) / wanted;
        assert!((0.0..0.007 * thickness).contains(&lacks), "{thickness} {element} {path}: {ratio} {wanted}");
    }
}

/// Two strips, one heated below the other, loose on two feet: held by contact alone, and 1e6 times as compliant in bending
/// as at a contact point. The feet carry what presses the strips.
#[test]
fn heated_strips_that_lie_loose_on_feet_are_certified() {
    for element in ["hex8", "hex20"] {
        let run = solved(&format!(
            r#"
[mesh.parts.first]
block = {{ size = [10, 10, 5], origin = [0, 0, -5], cells = [4, 4, 2], element = "{element}" }}
[mesh.parts.second]
block = {{ size = [10, 10, 5], origin = [90, 0, -5], cells = [4, 4, 2], element = "{element}" }}
[mesh.parts.below]
block = {{ size = [100, 10, 1], cells = [30, 3, 1], element = "{element}" }}
[mesh.parts.above]
block = {{ size = [100, 10, 1], origin = [0, 0, 1], cells = [23, 3, 1], element = "{element}" }}
[materials.steel]
young = 2e5
poisson = 0.3
expansion = 1.2e-5
[[fix]]
on = "first.z-min"
[[fix]]
on = "second.z-min"
[[load]]
on = "above.z-max"
traction = [0, 0, -0.02]
[[load]]
on = "below"
temperature = 100
[[contact]]
name = "left"
on = "below.z-min"
against = "first.z-max"
friction = {{ coulomb = 0.2 }}
[[contact]]
name = "right"
on = "below.z-min"
against = "second.z-max"
friction = {{ coulomb = 0.2 }}
[[contact]]
name = "between"
on = "above.z-min"
against = "below.z-max"
friction = {{ coulomb = 0.2 }}
"#
        ));
        assert_eq!(run.0.solution.status, Status::Solved, "{element}");
        for body in &run.0.solution.certificate.bodies {
            let wanted = match body.name.as_str() {
                "above" => 20.0,
                "below" => 0.0,
                _ => -10.0,
            };
            assert!((body.contact[2] - wanted).abs() < 1e-7, "{element} {}: {:?}", body.name, body.contact);
        }
    }
}
