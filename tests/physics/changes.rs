//! Supports and contacts that begin or end with a load step.

use std::ops::ControlFlow;

use stiction::Status;
use stiction::io::case;
use stiction::run::{self, Origin, Outcome, Prepared, Settings, StepRecord, body_fields, prepare, solve_steps};
use stiction_fixtures::case_run::{at, block, displacement, is, refused, solved, stress};
use stiction_fixtures::folder::Folder;

const PATHS: [&str; 3] = ["dense", "solves", "multigrid"];

/// A bar of stiffness E A/L = 1000 x 2/3 along x, of three cells, held at x-min but for its width.
fn bar(rest: &str, path: &str) -> String {
    block([3.0, 1.0, 2.0], [3, 1, 1], "element = \"hex8\"")
        + "[materials.soft]\nyoung = 1000\npoisson = 0\n[[fix]]\non = \"x-min\"\n"
        + rest
        + &format!("[solver]\ntolerance = 1e-11\npath = \"{path}\"\n")
}

fn steps(names: &[&str], increments: usize) -> String {
    let step = |(i, name): (usize, &&str)| {
        format!("[[step]]\nname = \"{name}\"\nuntil = {}\nincrements = {increments}\n", i + 1)
    };
    names.iter().enumerate().map(step).collect()
}

/// The reaction along x of all supports in each step; nothing else acts in the cases that use it.
fn reactions(outcome: &Outcome) -> Vec<f64> {
    outcome.steps.iter().map(|step: &StepRecord| step.answer.reaction[0]).collect()
}

fn reaction_on(run: &(Outcome, Prepared), x: f64) -> [f64; 3] {
    let fields = body_fields(&run.1, &run.0);
    let of = run.1.mesh.nodes.iter().zip(fields.reaction).filter(|(node, _)| node[0] == x);
    of.fold([0.0; 3], |sum, (_, r)| [0, 1, 2].map(|c| sum[c] + r[c]))
}

#[test]
fn a_bar_that_is_let_go_springs_back() {
    let held = "[[fix]]\non = \"x-max\"\nvalue = [\"0.03*min(t, 1)\", 0, 0]\nuntil = \"stretch\"\n";
    for path in PATHS {
        let run = solved(&bar(&(held.to_string() + &steps(&["stretch", "free"], 2)), path));
        assert_eq!(run.0.steps.len(), 4);
        displacement(&run).iter().flatten().for_each(|&u| is(u, 0.0, 0.03));
        is(reaction_on(&run, 3.0)[0], 0.0, 20.0);
        is(reaction_on(&run, 0.0)[0], 0.0, 20.0);
        // What the release takes away is the energy of the stretched bar, half of force times way.
        let last = run.0.steps.last().unwrap().balance;
        is(last.work, 0.0, 0.3);
        is(run.0.steps[1].answer.reaction[0], 0.0, 20.0);
        is(run.0.steps[1].balance.elastic, 0.5 * 20.0 * 0.03, 0.3);
        is(run.0.steps[1].balance.work, 0.5 * 20.0 * 0.03, 0.3);
    }
}

/// Between two plates with a given shear of friction, pulled at one end and let go. A section of the bar carries its springs k
/// to its neighbours and the friction of the area around it: b at the first and the last under the plates, 2 b in the middle.
/// Pulled far enough all slip: the springs hold b, 3 b, 4 b. Let go the first slips back until its friction, now b the other
/// way, holds the rest of the spring behind it; the others stay.
#[test]
fn a_bar_between_plates_springs_back_as_far_as_friction_lets_it() {
    let (shear, d) = (3.0, 0.5);
    let plate = |on: &str, z: f64, normal: f64| {
        format!(
            "[[contact]]\nname = \"{on}\"\non = {{ box = [[1, 0, {z}], [3, 1, {z}]] }}\nfriction = {{ tresca = {shear} }}\n\
             against = {{ plane = {{ point = [0, 0, {}], normal = [0, 0, {normal}] }} }}\n",
            z + 1e-3 * normal
        )
    };
    for path in PATHS {
        let text = block([3.0, 1.0, 2.0], [3, 1, 1], "element = \"hex8\"")
            + "[materials.soft]\nyoung = 1000\npoisson = 0\n[[fix]]\non = \"y-min\"\ncomponents = \"y\"\n"
            + &format!("[[fix]]\non = \"x-min\"\ncomponents = \"x\"\nvalue = \"-{d}*t\"\nuntil = \"pull\"\n")
            + &plate("z-min", 0.0, 1.0)
            + &plate("z-max", 2.0, -1.0)
            + &steps(&["pull", "free"], 1)
            + &format!("[solver]\ntolerance = 1e-11\npath = \"{path}\"\n");
        let run = solved(&text);
        let (k, b) = (1000.0 * 2.0, shear * 2.0 * 0.5);
        let way = |x: f64| -at(&run, [x, 0.0, 0.0])[0];
        is(way(3.0), d - 8.0 * b / k, d);
        is(way(2.0), d - 7.0 * b / k, d);
        is(way(1.0), d - 6.0 * b / k, d);
        is(way(0.0), d - 6.0 * b / k, d);
        is(reactions(&run.0)[0], -4.0 * b, b);
        is(reactions(&run.0)[1], 0.0, b);
    }
}

#[test]
fn a_support_begins_where_its_nodes_stand() {
    let load = "[[load]]\non = \"x-max\"\ntraction = [\"20*min(t, max(2 - t, 0))\", 0, 0]\n";
    for path in PATHS {
        let begins = |more: &str| {
            let fix = format!("[[fix]]\non = \"x-max\"\ncomponents = \"x\"\nfrom = \"hold\"\n{more}");
            solved(&bar(&(load.to_string() + &fix + &steps(&["load", "hold"], 2)), path))
        };
        // Loaded by 40, then held while the load goes.
        let run = begins("condition = \"as-it-stands\"\n");
        is(at(&run, [3.0, 0.0, 0.0])[0], 0.06, 0.06);
        is(reaction_on(&run, 3.0)[0], 40.0, 40.0);
        // Led from 0.06 to 0.01; half way the load is half gone.
        let run = begins("value = 0.01\n");
        is(at(&run, [3.0, 0.0, 0.0])[0], 0.01, 0.06);
        let reached: Vec<f64> = run.0.steps.iter().map(|step| step.answer.displacement_max).collect();
        is(reached[2], 0.035, 0.06);
        is(reaction_on(&run, 3.0)[0], 2000.0 / 3.0 * 0.01, 40.0);
        is(run.0.steps[2].answer.reaction[0], -20.0, 40.0);
    }
}

/// Nodes that two supports share are held by both, by one and by none, one after the other.
#[test]
fn supports_that_follow_one_another_share_nodes() {
    let fixes = "[[fix]]\non = \"x-max\"\ncomponents = \"xyz\"\nvalue = [0.03, 0, 0]\nuntil = \"both\"\n\
                 [[fix]]\non = \"z-max\"\ncomponents = \"z\"\nfrom = \"both\"\nuntil = \"second\"\n";
    let names = ["first", "both", "second", "none"];
    let run = solved(&bar(&(fixes.to_string() + &steps(&names, 1)), "auto"));
    for (step, reached) in run.0.steps.iter().zip([0.03, 0.03, 0.0, 0.0]) {
        is(step.answer.displacement_max, reached, 0.03);
        is(step.answer.reaction[0], 0.0, 20.0);
    }
    let other = "[[fix]]\non = \"x-max\"\ncomponents = \"x\"\nvalue = 0.02\nuntil = \"first\"\n";
    let error = refused(&bar(&(fixes.to_string() + other + &steps(&names, 1)), "auto"));
    assert!(error.contains("another value"), "{error}");
    let parse = |fix: &str| case::parse(&bar(&(fix.to_string() + &steps(&["a", "b"], 1)), "auto"), "case.toml", &[]);
    for (fix, word) in [
        ("[[fix]]\non = \"x-max\"\nfrom = \"c\"\n", "no step called"),
        ("[[fix]]\non = \"x-max\"\nfrom = \"b\"\nuntil = \"a\"\n", "comes before"),
        ("[[fix]]\non = \"x-max\"\ncondition = \"as-it-stands\"\n", "nothing has moved yet"),
        ("[[fix]]\non = \"x-max\"\ncondition = \"as-it-stands\"\nfrom = \"b\"\nvalue = [0, 0, 1]\n", "where they are"),
    ] {
        let error = parse(fix).map(|_| ()).unwrap_err().to_string();
        assert!(error.contains(word), "{error}");
    }
}

/// Two columns of stiffness E A/L = 1000 on one another.
fn stacked(contact: &str, rest: &str, path: &str) -> String {
    let part = |name: &str, z: f64| {
        let mesh = block([1.0, 1.0, 1.0], [1, 1, 1], "element = \"hex8\"");
        mesh.replacen("[mesh]", &format!("[mesh.parts.{name}]"), 1) + &format!("move = [0, 0, {z}]\n")
    };
    part("low", 0.0)
        + &part("high", 1.0)
        + "[materials.soft]\nyoung = 1000\npoisson = 0\n[[fix]]\non = \"low.z-min\"\n"
        + &format!("[[contact]]\non = \"high.z-min\"\nagainst = \"low.z-max\"\n{contact}")
        + rest
        + &format!("[solver]\ntolerance = 1e-11\npath = \"{path}\"\n")
}

#[test]
fn a_contact_that_is_taken_out_lets_go_and_put_in_again_presses() {
    // The upper column hangs in a spring of 1000 and is pressed by 10: with the lower one below it each carries half.
    let hung = "[[spring]]\non = \"high.z-max\"\nnormal = 1000\ntangential = 1000\n\
                [[load]]\non = \"high.z-max\"\ntraction = [0, 0, -10]\n";
    for path in PATHS {
        let run = |during: &str| {
            solved(&stacked(
                &format!("friction = {{ coulomb = 0.3 }}\n{during}"),
                &(hung.to_string() + &steps(&["in", "out"], 1)),
                path,
            ))
        };
        // k u + (k/2) u = 10, of which contact carries a third.
        let top = |run: &(Outcome, Prepared)| at(run, [0.0, 0.0, 2.0])[2];
        let kept = run("");
        is(top(&kept), -10.0 / 1500.0, 0.01);
        let out = run("until = \"in\"\n");
        is(top(&out), -0.01, 0.01);
        is(out.0.steps[0].answer.contact.normal_force, 10.0 / 3.0, 10.0);
        assert_eq!(out.0.steps[1].answer.contact.normal_force, 0.0);
        // The upper column has gone through the lower one by then: put in, contact brings it back.
        let put_in = run("from = \"out\"\n");
        is(put_in.0.steps[0].answer.contact.normal_force, 0.0, 10.0);
        is(top(&put_in), -10.0 / 1500.0, 0.01);
    }
    let text = stacked(
        "friction = \"none\"\nwithout = [\"in\", \"out\"]\n",
        &(hung.to_string() + &steps(&["in", "out"], 1)),
        "auto",
    );
    assert!(case::parse(&text, "case.toml", &[]).map(|_| ()).unwrap_err().to_string().contains("out in all steps"));
    let between = hung.to_string() + &steps(&["in", "out", "again"], 1);
    for law in ["{ coulomb = 0.3 }", "\"bonded\""] {
        let run = solved(&stacked(&format!("friction = {law}\nwithout = [\"out\"]\n"), &between, "auto"));
        let reached: Vec<f64> = run.0.steps.iter().map(|step| step.answer.displacement_max).collect();
        // A contact that presses finds the surfaces in each other, a tie keeps them so.
        let last = if law.contains("bonded") { 0.01 } else { 10.0 / 1500.0 };
        reached.iter().zip([10.0 / 1500.0, 0.01, last]).for_each(|(&u, wanted)| is(u, wanted, 0.01));
    }
}

/// What has moved before is superposed: the tie changes nothing until the load does, and from then on it is one body.
#[test]
fn a_tie_that_is_put_in_keeps_what_it_finds() {
    let hung = |[x, z]: [&str; 2]| {
        format!(
            "[[spring]]\non = \"high.z-max\"\nnormal = 1000\ntangential = 1000\n\
             [[load]]\non = \"high.z-max\"\ntraction = [\"5*{x}\", 0, \"-10*{z}\"]\n"
        )
    };
    let (up_and_down, back) = ("(2 - t)*min(t, 1)", "(-1)");
    for path in PATHS {
        let one_body = solved(&stacked("friction = \"bonded\"\n", &hung([back; 2]), path));
        let put_in = "friction = \"bonded\"\nfrom = \"tied\"\n";
        let run = solved(&stacked(put_in, &(hung([up_and_down; 2]) + &steps(&["press", "tied"], 2)), path));
        for x in [[0.0, 0.0, 2.0], [1.0, 1.0, 2.0], [1.0, 0.0, 2.0]] {
            let change = at(&one_body, x);
            [0.005, 0.0, -0.01]
                .iter()
                .zip(change)
                .zip(at(&run, x))
                .for_each(|((was, change), now)| is(now, was + change, 0.01));
        }
        // Along z alone: the spring draws the two columns in a row by a third of what they were apart from it.
        let run = solved(&stacked(put_in, &(hung(["0*t", up_and_down]) + &steps(&["press", "tied"], 1)), path));
        is(at(&run, [0.0, 0.0, 2.0])[2], -0.01 / 3.0, 0.01);
        stress(&run).iter().for_each(|s| is(s[2], 10.0 / 3.0, 10.0));
    }
}

#[test]
fn a_run_with_changes_is_checked_and_goes_on_where_it_stopped() {
    let load = "[[load]]\non = \"x-max\"\ntraction = [\"20*min(t, max(2 - t, 0))\", 0, 0]\n\
                [[fix]]\non = \"x-max\"\ncomponents = \"x\"\nfrom = \"hold\"\nuntil = \"hold\"\ncondition = \"as-it-stands\"\n\
                [[fix]]\non = \"x-max\"\ncomponents = \"x\"\nfrom = \"lead\"\nvalue = 0.01\n";
    let text = bar(&(load.to_string() + &steps(&["load", "hold", "lead"], 2)), "auto");
    let case = case::parse(&text, "case.toml", &[]).unwrap();
    let settings = Settings::of(&case.solver);
    let folder = Folder::new("changes");
    let whole = solved(&text);
    for stop_after in 1..6 {
        let mut prepared = prepare(&case).unwrap();
        let (mut files, _) = run::begin_steps(&prepared, &folder.path, false).unwrap();
        let mut keep = |prepared: &Prepared, step: &run::Step| run::keep_step(&mut files, prepared, step);
        let mut count = 0;
        let mut stop = |event: &run::Event| {
            count += usize::from(matches!(event, run::Event::Step { .. }));
            if count > stop_after { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        solve_steps(&mut prepared, &settings, None, &mut keep, &mut stop).unwrap();
        let mut prepared = prepare(&case).unwrap();
        let (mut files, restart) = run::begin_steps(&prepared, &folder.path, true).unwrap();
        assert_eq!(restart.as_ref().unwrap().records.len(), stop_after);
        let mut keep = |prepared: &Prepared, step: &run::Step| run::keep_step(&mut files, prepared, step);
        let go_on = &mut |_: &run::Event| ControlFlow::Continue(());
        let outcome = solve_steps(&mut prepared, &settings, restart, &mut keep, go_on).unwrap();
        for (a, b) in outcome.solution.u.iter().zip(&whole.0.solution.u) {
            is(*a, *b, 0.06);
        }
        let mut outcome = outcome;
        run::write(&prepared, &mut outcome, &Origin::default(), &folder.path).unwrap();
        let checked = run::check(&folder.path).unwrap();
        assert_eq!(checked.steps.len(), 6);
        for step in &checked.steps {
            assert!(step.certificate.passed && step.differences.is_empty(), "{:?}", step.differences);
        }
    }
}

/// Two unit cubes of stiffness 1000 each on top of each other, pulled and pushed at the upper one's top: 500 together. Apart
/// they carry nothing, and a gap they were meshed with has to be closed first.
#[test]
fn surfaces_that_are_bonded_at_first_come_apart_afterwards() {
    let text = |gap: f64, path: &str| {
        let part = |name: &str, z: f64| {
            let mesh = block([1.0, 1.0, 1.0], [2, 2, 2], "element = \"hex8\"");
            mesh.replacen("[mesh]", &format!("[mesh.parts.{name}]"), 1) + &format!("move = [0, 0, {z}]\n")
        };
        part("low", 0.0)
            + &part("high", 1.0 + gap)
            + "[materials.soft]\nyoung = 1000\npoisson = 0\n[[fix]]\non = \"low.z-min\"\n\
               [[fix]]\non = \"high.z-max\"\nvalue = [0, 0, \"0.02*(min(t, 1) - min(max(t - 1, 0), 1) - 2*max(t - 2, 0))\"]\n\
               [[contact]]\nname = \"joint\"\non = \"high.z-min\"\nagainst = \"low.z-max\"\nfriction = { coulomb = 0.3 }\n\
               bonded_until = \"pull\"\n"
            + &steps(&["pull", "back", "push"], 1)
            + &format!("[solver]\ntolerance = 1e-11\npath = \"{path}\"\n")
    };
    for (gap, path) in [0.0, 0.01].into_iter().flat_map(|gap| PATHS.map(|path| (gap, path))) {
        let run = solved(&text(gap, path));
        let forces: Vec<f64> = run.0.steps.iter().map(|step| step.answer.contact.normal_force).collect();
        let wanted = [-10.0, 0.0, 500.0 * (0.04 - gap)];
        assert_eq!(forces.len(), 3, "{forces:?}");
        forces.iter().zip(wanted).for_each(|(force, wanted)| is(*force, wanted, 1e2 * 20.0));
    }
}

#[test]
fn what_is_bonded_for_a_time_has_a_law_afterwards() {
    let text = |keys: &str| {
        block([1.0, 1.0, 1.0], [1, 1, 1], "element = \"hex8\"")
            + "[materials.soft]\nyoung = 1000\npoisson = 0\n[[fix]]\non = \"z-max\"\n[[contact]]\non = \"z-min\"\n\
               against = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }\n"
            + keys
            + &steps(&["one", "two", "three"], 1)
    };
    for (keys, word) in [
        ("friction = \"bonded\"\nbonded_until = \"one\"\n", "bonds the surfaces in all steps"),
        ("friction = \"none\"\nbonded_until = \"three\"\n", "bonded in all steps"),
        ("friction = \"none\"\nbonded_until = \"tow\"\n", "did you mean \"two\"?"),
        ("friction = \"none\"\nfrom = \"two\"\nbonded_until = \"two\"\n", "begins with a later step"),
        ("friction = \"none\"\nstiffness = { normal = 1e3 }\nbonded_until = \"two\"\n", "lets the interface yield"),
    ] {
        let error = case::parse(&text(keys), "case.toml", &[]).unwrap_err();
        assert!(error.to_string().contains(word) && !error.remedy.is_empty(), "{error}");
    }
}

/// The end of a case that may not be solved.
fn ended(text: &str) -> Outcome {
    let case = case::parse(text, "case.toml", &[]).unwrap();
    let mut prepared = prepare(&case).unwrap();
    let settings = Settings::of(&case.solver);
    solve_steps(&mut prepared, &settings, None, &mut |_, _| Ok(()), &mut |_| ControlFlow::Continue(())).unwrap()
}

/// A block of weight 1000 on a floor with friction 0.3; in the second step it is pushed by `push` of the time in it.
fn pushed(during: &str, fixes: &str, push: &str, path: &str) -> String {
    block([10.0, 10.0, 5.0], [3, 3, 2], "element = \"hex8\"")
        + "[materials.s]\nyoung = 1e5\npoisson = 0.3\n[[load]]\non = \"z-max\"\npressure = 10\n"
        + &format!("[[load]]\non = \"z-max\"\nforce = [\"{push}*max(t - 1, 0)\", 0, 0]\n")
        + "[[contact]]\non = \"z-min\"\nfriction = { coulomb = 0.3 }\n"
        + &format!("against = {{ plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }} }}\n{during}{fixes}")
        + &steps(&["a", "b"], 4)
        + &format!("[solver]\npath = \"{path}\"\n")
}

/// What is let go holds nothing: friction of 300 ends at t = 1.15 whatever held the block before, and where a contact is out
/// nothing carries the weight. Points that are out have a gap of a thousand meshes, in which such a body was caught.
#[test]
fn a_body_that_nothing_holds_any_more_has_no_equilibrium() {
    for path in PATHS {
        for held in ["[[fix]]\non = \"z-max\"\ncomponents = \"xy\"\nuntil = \"a\"\n", ""] {
            for push in ["2000", "1e5"] {
                let end = ended(&pushed("", held, push, path));
                assert_eq!(end.solution.status, Status::NoEquilibrium, "{path} {held}");
                let (last, most) = (end.steps.last().unwrap().t, 1.0 + 300.0 / push.parse::<f64>().unwrap());
                assert!(last >= most - 1e-9 && last <= most + 0.01, "{path} {held}: {last} where {most} is wanted");
            }
            // The same is held by less than it can carry.
            let held = ended(&pushed("", held, "290", path));
            assert_eq!((held.solution.status, held.steps.len()), (Status::Solved, 8), "{path}");
        }
        let outer = "[[fix]]\non = \"x-min\"\ncomponents = \"xy\"\n";
        let gone = ended(&pushed("until = \"a\"\n", outer, "0", path));
        assert_eq!(gone.solution.status, Status::NoEquilibrium, "{path}");
        assert!((1.0..1.01).contains(&gone.steps.last().unwrap().t), "{path}");
        let not_yet = ended(&pushed("from = \"b\"\n", outer, "0", path));
        assert_eq!(not_yet.solution.status, Status::NoEquilibrium, "{path}");
    }
}

/// A face held until a step ends has an edge in the contact surface, where contact and support say the same along the normal:
/// as long as it is held the answer is that of a face that always is.
#[test]
fn a_support_by_time_may_hold_nodes_of_a_contact() {
    for push in ["0", "-3000"] {
        for path in ["dense", "solves"] {
            let held = "[[fix]]\non = \"x-min\"\n";
            let always = ended(&pushed("", held, push, path));
            let until = ended(&pushed("", &format!("{held}until = \"a\"\n"), "0", path));
            assert_eq!((always.solution.status, until.solution.status), (Status::Solved, Status::Solved), "{path}");
            for (a, b) in always.steps.iter().zip(&until.steps).take(4) {
                is(a.answer.displacement_max, b.answer.displacement_max, 1e3 * a.answer.displacement_max);
                (0..3).for_each(|c| is(a.answer.reaction[c], b.answer.reaction[c], 1e6));
            }
            // Let go, the floor carries all of it.
            is(until.steps[7].answer.contact.normal_force, 1000.0, 1e4);
        }
    }
}

/// A heated block between planes of symmetry, held from below in a step: it expands freely, and no support and no contact carries
/// anything but what rounding leaves of the forces of heat.
#[test]
fn supports_that_carry_nothing_while_a_body_expands_are_no_reason_to_fail() {
    for path in ["dense", "solves"] {
        let end = ended(
            &(block([4.0, 3.0, 2.0], [4, 3, 2], "element = \"hex8\"")
                + "[materials.s]\nyoung = 2e5\npoisson = 0.3\nexpansion = 1.2e-5\n\
                   [[fix]]\non = \"x-min\"\ncondition = \"symmetry\"\n[[fix]]\non = \"y-min\"\ncondition = \"symmetry\"\n\
                   [[fix]]\non = \"z-min\"\ncomponents = \"z\"\nuntil = \"b\"\n[[load]]\ntemperature = \"200*t\"\n\
                   [[contact]]\non = \"x-max\"\nfriction = { coulomb = 0.2 }\n\
                   against = { plane = { point = [4.1, 0, 0], normal = [-1, 0, 0] } }\n"
                + &steps(&["a", "b"], 2)
                + &format!("[solver]\npath = \"{path}\"\n")),
        );
        assert_eq!(
            (end.solution.status, end.steps.len()),
            (Status::Solved, 4),
            "{path}: {:?}",
            end.solution.certificate
        );
        let stretch = 1.2e-5 * 400.0;
        is(end.steps[3].answer.displacement_max, stretch * 29f64.sqrt(), stretch);
        assert_eq!(end.steps[3].answer.contact.normal_force, 0.0);
    }
}

/// A body that a support moves onto another one presses on it, whichever carries the points: what the support says of its nodes is not
/// what contact says of the other body.
#[test]
fn a_body_moved_by_a_support_for_a_time_presses_on_another() {
    for (fine, coarse) in [(3, 2), (2, 3)] {
        let part = |name: &str, n: usize, z: f64| {
            format!(
                "[mesh.parts.{name}]\nblock = {{ size = [1, 1, 1], cells = [{n}, {n}, 1], origin = [0, 0, {z}], element = \"hex8\" }}\n"
            )
        };
        let end = ended(
            &(part("low", coarse, 0.0)
                + &part("high", fine, 1.0)
                + "[materials.soft]\nyoung = 1000\npoisson = 0\n[[fix]]\non = \"low.z-min\"\n\
                   [[fix]]\non = \"high\"\nvalue = [0, 0, \"-0.01*min(t, 1)\"]\nuntil = \"b\"\n\
                   [[contact]]\non = \"high.z-min\"\nagainst = \"low.z-max\"\nfriction = \"none\"\n"
                + &steps(&["a", "b"], 1)),
        );
        assert_eq!((end.solution.status, end.steps.len()), (Status::Solved, 2));
        for step in &end.steps {
            is(step.answer.contact.normal_force, 10.0, 1e3);
        }
    }
}

/// A bar is moved 0.1 into where a plane begins to hold in the second step, which pushes it out at once: it stores `E A d² / 2 L` = 50,
/// half of the force times the overlap is the work of the plane, and nothing is dissipated.
#[test]
fn what_overlaps_when_a_contact_begins_to_hold_is_pushed_out_by_work() {
    for increments in [1, 4] {
        let run = solved(&format!(
            "[mesh]\nblock = {{ size = [10, 10, 10], cells = [2, 2, 2], element = \"hex8\" }}\n\
             [materials.m]\nyoung = 1000\npoisson = 0\n[[fix]]\non = \"z-max\"\nvalue = [0, 0, \"-0.1*min(t, 1)\"]\n\
             [[contact]]\nname = \"plane\"\non = \"z-min\"\nfrom = \"on\"\nfriction = \"none\"\n\
             against = {{ plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }} }}\n\
             [[step]]\nname = \"move\"\nuntil = 1\n[[step]]\nname = \"on\"\nuntil = 2\nincrements = {increments}\n"
        ));
        let last = run.0.steps.last().unwrap().balance;
        is(last.elastic, 50.0, 1.0);
        is(last.work, 50.0, 1.0);
        is(last.drift, 0.0, 50.0);
    }
}
