//! Nodes that move with a reference point, as a rigid body or in the mean.

use std::ops::ControlFlow;

use stiction::certificate::certify;
use stiction::friction::Status;
use stiction::io::case;
use stiction::run::{
    CouplingState, Outcome, Prepared, Settings, body_fields, coupling_states, prepare, report, solve, totals,
};
use stiction_fixtures::case_run::{at, block, is, refused, solved, stress};

const PATHS: [&str; 3] = ["dense", "solves", "multigrid"];

/// A bar of 4 x 1 x 2 along x of quadratic hexahedra without lateral contraction, held at x-min along x, and there against
/// rigid motions alone. E = 1000.
fn bar(rest: &str, path: &str) -> String {
    block([4.0, 1.0, 2.0], [2, 1, 2], "element = \"hex20\"")
        + "[materials.soft]\nyoung = 1000\npoisson = 0\n[[fix]]\non = \"x-min\"\n"
        + rest
        + &format!("[solver]\ntolerance = 1e-11\npath = \"{path}\"\n")
}

fn state(run: &(Outcome, Prepared)) -> CouplingState {
    coupling_states(&run.1, &run.0)[0].clone()
}

fn reactions(run: &(Outcome, Prepared)) -> [f64; 3] {
    body_fields(&run.1, &run.0).reaction.iter().fold([0.0; 3], |sum, r| [0, 1, 2].map(|c| sum[c] + r[c]))
}

fn are(values: [f64; 3], wanted: [f64; 3], scale: f64) {
    values.iter().zip(wanted).for_each(|(value, wanted)| is(*value, wanted, scale));
}

/// Forces of several points of a rigid line or face on a plane have a sum and a moment, and nothing else decides them. A note says so
/// of the nodes that both have, and of no others.
#[test]
fn contact_at_rigid_nodes_is_said_to_be_shared_out_by_nothing() {
    let text = |kind: &str, friction: &str| {
        block([4.0, 2.0, 2.0], [2, 2, 2], "element = \"hex8\"")
            + "[materials.soft]\nyoung = 1000\npoisson = 0\n[[fix]]\non = \"x-min\"\n"
            + &format!("[[coupling]]\non = \"x-max\"\npoint = [4, 1, 1]\nforce = [0, 0, -1]\nkind = \"{kind}\"\n")
            + &format!(
                "[[contact]]\non = \"z-min\"\nagainst = {{ plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }} }}\n{friction}\n"
            )
    };
    let notes = |kind: &str, friction: &str| {
        let case = case::parse(&text(kind, friction), "case.toml", &[]).unwrap();
        let all = prepare(&case).unwrap().facts.notes;
        all.into_iter().filter(|note| note.contains("rigid coupling")).collect::<Vec<_>>()
    };
    let said = notes("rigid", "friction = \"none\"");
    assert!(said.len() == 1 && said[0].contains("3 points") && !said[0].contains("friction there"), "{said:?}");
    let said = notes("rigid", "friction = { coulomb = 0.2 }");
    assert!(said.len() == 1 && said[0].contains("friction there"), "{said:?}");
    assert_eq!(notes("distributing", "friction = \"none\""), [""; 0]);
}

/// A square foot whose bottom a coupling makes rigid is pressed onto a block and twisted. What a quarter turn leaves as it is does not move
/// its middle, and a foot of a thousand times the modulus, held at its top, turns as far. The faces of the foot are the smaller ones, but nothing
/// determines what each of its nodes bears, and so how far friction goes: the block has the points.
#[test]
fn a_rigid_face_leaves_the_contact_points_to_the_elastic_body() {
    let text = |on: &str, z: f64, young: f64| {
        let parts = "[mesh.parts.p]\nblock = { size = [2, 2, 1], cells = [4, 4, 2], element = \"hex8\" }\n[mesh.parts.base]\n\
                     block = { size = [2, 2, 1], cells = [2, 2, 2], element = \"hex8\" }\nmove = [0, 0, -1]\n";
        let materials = format!(
            "[materials.p]\non = \"p\"\nyoung = {young}\npoisson = 0.3\n[materials.base]\non = \"base\"\nyoung = 210e3\n\
             poisson = 0.3\n[[fix]]\non = \"base.z-min\"\n"
        );
        let contact = "[[contact]]\non = \"p.z-min\"\nagainst = \"base.z-max\"\nfriction = { coulomb = 0.3 }\n";
        let coupling = format!(
            "[[coupling]]\non = \"p.{on}\"\npoint = [1, 1, {z}]\nkind = \"rigid\"\nforce = [0, 0, -1000]\nmoment = [0, 0, 230]\n"
        );
        parts.to_string() + &materials + contact + &coupling
    };
    let rigid = state(&solved(&text("z-min", 0.0, 210e3)));
    let stiff = state(&solved(&text("z-max", 1.0, 210e6)));
    let size = rigid.rotation[2];
    assert!(rigid.displacement[..2].iter().all(|u| u.abs() < 1e-7 * size), "{rigid:?}");
    assert!((stiff.rotation[2] - size).abs() < 2e-3 * size, "{} {size}", stiff.rotation[2]);
}

/// Pulled and bent at a point off its axis a slender body without shear follows the theory of beams exactly: quadratic
/// hexahedra hold a constant moment. The force acts along x at (4, 0.3, 1.5), the axis is at (y, z) = (0.5, 1).
#[test]
fn a_rigid_end_is_pulled_and_bent_as_beam_theory_says() {
    let (force, along_y) = (6.0, 2.0);
    let coupling = format!(
        "[[coupling]]\non = \"x-max\"\npoint = [4, 0.3, 1.5]\nforce = [{force}, 0, 0]\nmoment = [0, {along_y}, 0]\n"
    );
    let (e, a, iy, iz, l) = (1000.0, 2.0, 8.0 / 12.0, 2.0 / 12.0, 4.0);
    // Moments about the axis: r x F with r = (0, -0.2, 0.5).
    let (my, mz) = (along_y + 0.5 * force, 0.2 * force);
    let (wy, wz) = (my * l / (e * iy), mz * l / (e * iz));
    for kind in ["rigid", "distributing"] {
        for path in PATHS {
            let run = solved(&bar(&(coupling.clone() + &format!("kind = \"{kind}\"\n")), path));
            let it = state(&run);
            are(it.rotation, [0.0, wy, wz], wz);
            // Of the axis: stretched, and deflected along z by -wy l/2, along y by wz l/2; then to the point by w x r.
            let axis = [force * l / (e * a), wz * l / 2.0, -wy * l / 2.0];
            let turned = [wy * 0.5 - wz * -0.2, 0.0, 0.0];
            are(it.displacement, [0, 1, 2].map(|c| axis[c] + turned[c]), wz);
            are(it.force, [force, 0.0, 0.0], force);
            are(it.moment, [0.0, along_y, 0.0], force);
            // Of the corner of the end, which is flat: u_x = u + wy z - wz y.
            is(at(&run, [4.0, 1.0, 2.0])[0], axis[0] + wy * 1.0 - wz * 0.5, wz);
            are(reactions(&run), [-force, 0.0, 0.0], force);
        }
    }
}

/// The same end with its motion prescribed asks for the same force and moment, which then are reactions.
#[test]
fn a_prescribed_motion_asks_for_the_force_that_would_cause_it() {
    let (force, my, mz) = (6.0, 5.0, 1.2);
    let (wy, wz) = (my * 4.0 / (1000.0 * 8.0 / 12.0), mz * 4.0 / (1000.0 * 2.0 / 12.0));
    let (x, y, z) = (force * 4.0 / 2000.0, wz * 2.0, -wy * 2.0);
    let prescribed = format!(
        "[[coupling]]\non = \"x-max\"\npoint = [4, 0.5, 1]\nmotion = {{ x = {x:?}, y = {y:?}, z = {z:?} }}\n\
         rotation = {{ x = 0, y = \"{wy:?}*t\", z = {wz:?} }}\n"
    );
    for kind in ["rigid", "distributing"] {
        for path in PATHS {
            let run = solved(&bar(&(prescribed.clone() + &format!("kind = \"{kind}\"\n")), path));
            let it = state(&run);
            are(it.displacement, [x, y, z], z);
            are(it.rotation, [0.0, wy, wz], wz);
            are(it.force, [force, 0.0, 0.0], force);
            are(it.moment, [0.0, my, mz], force);
            // Both ends are supports, whose forces add up to nothing.
            are(reactions(&run), [0.0; 3], force);
            for s in stress(&run) {
                is(s[1], 0.0, 10.0);
            }
        }
    }
}

#[test]
fn a_coupling_of_one_component_leaves_the_others_free() {
    let coupling = "[[coupling]]\non = \"x-max\"\npoint = [4, 0.5, 1]\nforce = [6, 0, 0]\nmoment = [0, 5, 0]\ncomponents = \"x\"\n";
    for path in PATHS {
        let it = state(&solved(&bar(coupling, path)));
        is(it.displacement[0], 6.0 * 4.0 / 2000.0, 0.01);
        is(it.rotation[1], 5.0 * 4.0 / (1000.0 * 8.0 / 12.0), 0.01);
        is(it.rotation[2], 0.0, 0.01);
        assert!(it.displacement[1].is_nan() && it.displacement[2].is_nan() && it.rotation[0].is_nan(), "{it:?}");
    }
    for (more, word) in [("motion = { y = 0 }\n", "along y"), ("rotation = { x = 0.1 }\n", "about x")] {
        let error = refused(&bar(&(coupling.to_string() + more), "auto"));
        assert!(error.contains(word) && error.contains("do not tell"), "{error}");
    }
    let error = refused(&bar(&coupling.replace("moment = [0, 5, 0]", "moment = [1, 0, 0]"), "auto"));
    assert!(error.contains("about x"), "{error}");
    // A line of nodes does not tell how it turns about itself.
    let line = coupling.replace("\"x-max\"", "{ box = [[4, 0, 2], [4, 1, 2]] }").replace("components = \"x\"\n", "");
    let error = refused(&bar(
        &(line.replace("[0, 5, 0]", "[0, 0, 0]").replace("[6, 0, 0]", "[0, 6, 0]") + "rotation = { y = 0 }\n"),
        "auto",
    ));
    assert!(error.contains("about y"), "{error}");
}

/// Two columns, one three times as stiff: as one rigid body their tops share the force by stiffness, and a moment keeps
/// them level; in the mean each takes half of it.
#[test]
fn a_rigid_body_shares_by_stiffness_and_a_mean_by_area() {
    let part = |name: &str, x: f64| {
        let mesh = block([1.0, 1.0, 1.0], [2, 2, 1], "element = \"hex8\"");
        mesh.replacen("[mesh]", &format!("[mesh.parts.{name}]"), 1) + &format!("move = [{x}, 0, 0]\n")
    };
    let text = |kind: &str, path: &str| {
        part("a", 0.0)
            + &part("b", 2.0)
            + "[materials.soft]\nyoung = 1000\npoisson = 0\non = [\"a.body\"]\n\
               [materials.hard]\nyoung = 3000\npoisson = 0\non = [\"b.body\"]\n\
               [[fix]]\non = [\"a.z-min\", \"b.z-min\"]\n\
               [[coupling]]\nname = \"tops\"\non = [\"a.z-max\", \"b.z-max\"]\npoint = [1.5, 0.5, 1]\nforce = [0, 0, 8]\n"
            + kind
            + &format!("[solver]\ntolerance = 1e-11\npath = \"{path}\"\n")
    };
    for path in PATHS {
        let rigid = solved(&text("rotation = { x = 0, y = 0, z = 0 }\n", path));
        are(state(&rigid).displacement, [0.0, 0.0, 8.0 / 4000.0], 0.002);
        are(state(&rigid).force, [0.0, 0.0, 8.0], 8.0);
        // 2 at x = -1 and 6 at x = 1 from the point.
        are(state(&rigid).moment, [0.0, 2.0 - 6.0, 0.0], 8.0);
        let mean = solved(&text("kind = \"distributing\"\n", path));
        is(at(&mean, [0.0, 0.0, 1.0])[2], 4.0 / 1000.0, 0.004);
        is(at(&mean, [3.0, 1.0, 1.0])[2], 4.0 / 3000.0, 0.004);
        are(state(&mean).displacement, [0.0, 0.0, (4.0 / 1000.0 + 4.0 / 3000.0) / 2.0], 0.004);
        assert_eq!(state(&mean).moment, [0.0; 3]);
    }
}

/// A rigid punch on a floor, pressed off its middle and drawn: both paths agree, and the floor carries what acts at the point.
#[test]
fn a_punch_that_is_led_at_a_point_rubs_on_a_floor() {
    let text = |path: &str| {
        block([2.0, 1.0, 1.0], [4, 3, 3], "element = \"hex8\"")
            + "[materials.steel]\nyoung = 210e3\npoisson = 0.3\n\
               [[coupling]]\non = \"z-max\"\npoint = [1.2, 0.5, 3]\nforce = [\"20*max(t - 1, 0)\", 0, \"-200*min(t, 1)\"]\n\
               rotation = { z = 0 }\nmotion = { y = 0 }\n\
               [[contact]]\non = \"z-min\"\nfriction = { coulomb = 0.2 }\n\
               against = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }\n\
               [[step]]\nuntil = 1\n[[step]]\nuntil = 2\n"
            + &format!("[solver]\ntolerance = 1e-11\npath = \"{path}\"\n")
    };
    let [direct, multigrid] = ["dense", "multigrid"].map(|path| solved(&text(path)));
    for run in [&direct, &multigrid] {
        let last = &run.0.steps[1].answer;
        is(last.contact.normal_force, 200.0, 1e2 * 200.0);
        is(last.contact.tangential_force[0], -20.0, 1e2 * 20.0);
        let it = &last.couplings[0];
        assert!((it.force[0] - 20.0).abs() < 1e-6 && it.force[1].abs() < 1e-5, "{it:?}");
        // A rigid top: its corners move as the point says.
        for x in [[0.0, 0.0, 1.0], [2.0, 1.0, 1.0], [1.0, 1.0, 1.0]] {
            let r = [x[0] - 1.2, x[1] - 0.5, x[2] - 3.0];
            let w = it.rotation;
            let turned = [w[1] * r[2] - w[2] * r[1], w[2] * r[0] - w[0] * r[2], w[0] * r[1] - w[1] * r[0]];
            let u = at(run, x);
            (0..3).for_each(|c| assert!((u[c] - it.displacement[c] - turned[c]).abs() < 1e-10, "{x:?} {c}"));
        }
    }
    for (a, b) in direct.0.solution.u.iter().zip(&multigrid.0.solution.u) {
        assert!((a - b).abs() < 1e-8, "{a} {b}");
    }
    let lambda: Vec<f64> = direct.0.solution.lambda.iter().map(|force| force * (1.0 + 1e-6)).collect();
    assert!(!certify(&direct.1.problem, &direct.0.solution.u, &lambda, 1e-8).passed);
}

/// Blocks on a floor, tipped by the mean of their top, bent by the means of both ends, and drawn at an end by the sum of its displacements:
/// the factor is the second road. Where the equations eliminate nodes it takes multigrid 72 cycles or more, or it is not for the problem.
#[test]
fn faces_are_moved_in_the_mean_in_few_cycles_and_as_by_the_factor() {
    let coupling = |on: &str, point: [f64; 3], motion: [f64; 3], rotation: [f64; 3]| {
        let [[x, y, z], [a, b, c]] = [motion, rotation];
        format!("[[coupling]]\nname = \"{on}\"\non = \"{on}\"\npoint = {point:?}\nkind = \"distributing\"\n")
            + &format!("motion = {{ x = {x}, y = {y}, z = {z} }}\nrotation = {{ x = {a}, y = {b}, z = {c} }}\n")
    };
    let tipped = coupling("z-max", [1.5, 0.5, 1.2], [0.0, 0.0, 2e-4], [0.0, 2e-3, 0.0]);
    let bent = coupling("x-max", [3.0, 0.5, 0.5], [0.0, 0.0, -1e-3], [0.0, 2e-3, 0.0])
        + &coupling("x-min", [0.0, 0.5, 0.5], [0.0, 0.0, -1e-3], [2e-3, -2e-3, 0.0]);
    let drawn = "[[fix]]\non = \"x-min\"\n[[load]]\non = \"z-max\"\npressure = 5\n\
                 [[equation]]\nterms = [{ on = \"x-max\", along = \"x\", factor = 1 }]\nvalue = 0.1\n";
    // Cycles measured: 16 to 26.
    let most = 32;
    for (element, cells) in [("tet10", [12, 4, 4]), ("hex20", [8, 3, 3]), ("hex8", [20, 7, 7]), ("tet4", [20, 7, 7])] {
        for equations in [&tipped, &bent, drawn] {
            let run = |path: &str| {
                let text = block([3.0, 1.0, 1.0], cells, &format!("element = \"{element}\""))
                    + "[materials.steel]\nyoung = 210e3\npoisson = 0.3\n"
                    + equations
                    + "[[contact]]\non = \"z-min\"\nagainst = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }\n"
                    + &format!("friction = {{ coulomb = 0.3 }}\n[solver]\ntolerance = 1e-10\npath = \"{path}\"\n");
                solved(&text)
            };
            let [direct, multigrid] = ["solves", "multigrid"].map(run);
            let cycles = multigrid.0.solution.counts.cycles;
            assert!(cycles > 0 && cycles <= most, "{element}: {cycles} cycles");
            let force = |run: &(Outcome, Prepared)| totals(&run.1, &run.0).normal_force;
            let [a, b] = [force(&direct), force(&multigrid)];
            assert!(a > 1.0 && (a - b).abs() <= 1e-7 * a, "{element}: {a} {b}");
            let states = [&direct, &multigrid].map(|run| coupling_states(&run.1, &run.0));
            for (by_factor, by_cycles) in states[0].iter().zip(&states[1]) {
                // Forces of equations are their multipliers.
                are(by_cycles.force, by_factor.force, 1e3 * a);
                are(by_cycles.moment, by_factor.moment, 1e3 * a);
                are(by_cycles.displacement, by_factor.displacement, 1e-3);
            }
        }
    }
}

/// A block on a plane.
fn on_plane(rest: &str) -> String {
    block([3.0, 1.0, 1.0], [9, 5, 5], "element = \"hex8\"")
        + "[materials.soft]\nyoung = 1e5\npoisson = 0.3\n\
           [[contact]]\non = \"z-min\"\nagainst = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }\n\
           friction = { coulomb = 0.3 }\n"
        + rest
}

/// An equation that begins with the second step is one over many nodes before too.
#[test]
fn a_mean_that_is_prescribed_later_is_as_by_the_factor() {
    let rest = "[[load]]\non = \"z-max\"\nforce = [0, 0, \"-400*min(t,1)\"]\n\
                [[coupling]]\nname = \"top\"\non = \"z-max\"\npoint = [1.5, 0.5, 1]\nkind = \"distributing\"\nrotation = { x = 0 }\n\
                [[coupling]]\nname = \"end\"\non = \"x-max\"\npoint = [3, 0.5, 0.5]\nkind = \"distributing\"\n\
                motion = { y = \"1e-4*max(t-1,0)\" }\nfrom = \"b\"\n[[step]]\nname = \"a\"\nuntil = 1\n[[step]]\nname = \"b\"\nuntil = 2\n";
    let run = |path: &str| solved(&(on_plane(rest) + &format!("[solver]\ntolerance = 1e-10\npath = \"{path}\"\n")));
    let [direct, multigrid] = ["solves", "multigrid"].map(run);
    for (a, b) in direct.0.steps.iter().zip(&multigrid.0.steps) {
        is(b.answer.contact.normal_force, a.answer.contact.normal_force, 1e3 * 400.0);
        for (a, b) in a.answer.couplings.iter().zip(&b.answer.couplings) {
            are(b.force, a.force, 1e3 * 400.0);
            are(b.moment, a.moment, 1e3 * 400.0);
        }
        // Cycles measured: 16 and 15.
        assert!(b.answer.counts.cycles > 0 && b.answer.counts.cycles <= 25, "{:?}", b.answer.counts);
    }
}

/// Lifted by the mean of its top a block hangs on one equation, which leaves five motions; pressed again its points hold it. Held by the mean
/// over an edge of its foot it turns about that edge.
#[test]
fn motions_that_nothing_resists_are_named() {
    let mean = |rest: &str| format!("[[coupling]]\non = \"z-max\"\nkind = \"distributing\"\n{rest}");
    let lifted = mean("name = \"lift\"\npoint = [1.5, 0.5, 1]\nmotion = { z = \"1e-3*t\" }\nuntil = \"lift\"\n")
        + &mean(
            "name = \"press\"\npoint = [1.5, 0.5, 1]\nmotion = { x = \"1e-3*(t-1)\", z = \"-1e-3*(t-1)\" }\nfrom = \"press\"\n",
        )
        + "[[step]]\nname = \"lift\"\nuntil = 1\n[[step]]\nname = \"press\"\nuntil = 2\n";
    let run = solved(&on_plane(&lifted));
    let found: Vec<_> = run.0.steps.iter().map(|step| step.answer.adrift.as_ref().map(|it| it.motions)).collect();
    assert_eq!(found, [Some(5), None]);
    let warnings = |run: &(Outcome, Prepared)| {
        let rows = report(&run.1, &run.0).rows.into_iter().filter(|row| row.label == "warning").map(|row| row.value);
        rows.filter(|text| text.contains("nothing resists")).collect::<Vec<_>>()
    };
    let said = warnings(&run);
    assert!(said.len() == 1 && said[0].contains("5 independent motions at t = 1"), "{said:?}");
    let over_the_edge = solved(&on_plane(&mean("point = [0, 0.5, 1]\nmotion = { z = -1e-3 }\n")));
    let said = warnings(&over_the_edge);
    assert!(said.len() == 1 && said[0].contains("rotation"), "{said:?}");
    let inside = solved(&on_plane(&mean("point = [1, 0.5, 1]\nmotion = { z = -1e-3 }\n")));
    assert!(warnings(&inside).is_empty());
}

#[test]
fn couplings_that_say_too_little_or_too_much_are_refused() {
    let parse = |rest: &str| {
        let text = bar(&format!("[[coupling]]\non = \"x-max\"\npoint = [4, 0, 0]\n{rest}"), "auto");
        case::parse(&text, "case.toml", &[]).map(|_| ()).unwrap_err().to_string()
    };
    for (rest, word) in [
        ("components = \"xw\"\n", "no component"),
        ("kind = \"distributing\"\ncomponents = \"x\"\n", "all components"),
        ("from = \"a\"\n", "of which there is none"),
        ("motion = { x = \"x\" }\n", "x"),
        ("[[coupling]]\non = \"x-max\"\npoint = [4, 0, 0]\n", "two couplings"),
        ("[accuracy]\nenergy = 0.1\n", "error is not estimated"),
    ] {
        let error = parse(rest);
        assert!(error.contains(word) && error.contains("case.toml"), "{error}");
    }
}

/// A loose block on a plane, taken along by its top: a rigid coupling moves with the block and holds nothing. By statics of friction the
/// block stays while the force along the plane is below `mu` times what presses, and pressure acts within the foot.
#[test]
fn a_rigid_coupling_holds_no_loose_block() {
    let (mu, down, half) = (0.3, 1000.0, 10.0);
    let run = |force: [f64; 3], point: [f64; 3], path: &str| {
        let text = block([2.0 * half, 2.0 * half, 10.0], [3, 3, 2], "element = \"hex8\"")
            + "[materials.steel]\nyoung = 210e3\npoisson = 0.3\n"
            + "[[contact]]\non = \"z-min\"\nagainst = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }\n"
            + &format!("friction = {{ coulomb = {mu} }}\n")
            + &format!("[[coupling]]\non = \"z-max\"\npoint = {point:?}\nkind = \"rigid\"\nforce = {force:?}\n")
            + &format!("[solver]\npath = \"{path}\"\n");
        let case = case::parse(&text, "case.toml", &[]).unwrap_or_else(|e| panic!("{e}"));
        let prepared = prepare(&case).unwrap_or_else(|e| panic!("{e}"));
        let settings = Settings::of(&case.solver);
        let outcome = solve(&prepared, &settings, &mut |_| ControlFlow::Continue(()));
        (outcome.unwrap_or_else(|e| panic!("{e}")), prepared)
    };
    let (top, beside, foot) = ([half, half, 10.0], [half + 1.01 * half, half, 10.0], [half, half, 0.0]);
    for path in PATHS {
        for (force, point) in [
            ([0.0, 0.0, 10.0], top),
            ([1.01 * mu * down, 0.0, -down], foot),
            ([0.0, 0.0, -down], beside),
            // Friction holds, but the block tips over its edge.
            ([0.29 * down, 0.0, -down], [half, half, 10.0 / 0.28]),
        ] {
            let (outcome, _) = run(force, point, path);
            assert_eq!(outcome.solution.status, Status::NoEquilibrium, "{path} {force:?} at {point:?}");
        }
        for (force, point) in [([0.99 * mu * down, 0.0, -down], foot), ([0.0, 0.0, -down], [1.8 * half, half, 10.0])] {
            let (outcome, prepared) = run(force, point, path);
            assert_eq!(outcome.solution.status, Status::Solved, "{path} {force:?} at {point:?}");
            let contact = totals(&prepared, &outcome);
            is(contact.normal_force, down, 10.0 * down);
            is(contact.tangential_force[0], -force[0], 10.0 * down);
        }
    }
}
