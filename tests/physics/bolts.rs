//! Bolts that close a clearance, and how a bolt and the parts it clamps share a load.

use std::ops::ControlFlow;
use std::path::Path;
use std::sync::Arc;

use stiction::friction::Status;
use stiction::io::case::{self, MeshSource};
use stiction::linalg::Stop;
use stiction::mesh::{Group, MeshNotes, Order, block as make_block, refine, tetrahedra};
use stiction::run::{
    Outcome, Plan, Prepared, Settings, Stage, StepRecord, bolt_states, pair_totals, prepare, report, solve, solve_case,
    solve_steps,
};
use stiction_fixtures::case_run::{CORNER, block, solved, solved_case};

/// The joint of `cases/pretension`, whose bolt and plate float, with some values changed.
fn joint(set: &[(&str, &str)]) -> (Outcome, Prepared) {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../cases/pretension/pretension.toml");
    let set: Vec<(String, String)> = set.iter().map(|(k, v)| (k.to_string(), v.to_string())).collect();
    let case = case::read(path, &set).unwrap_or_else(|e| panic!("{e}"));
    let mut prepared = prepare(&case).unwrap_or_else(|e| panic!("{e}"));
    let go_on = &mut |_: &stiction::run::Event| ControlFlow::Continue(());
    let outcome = solve_steps(&mut prepared, &Settings::of(&case.solver), None, &mut |_, _| Ok(()), go_on);
    (outcome.unwrap_or_else(|e| panic!("{e}")), prepared)
}

/// Force and shortening after each step.
fn course(outcome: &Outcome) -> Vec<[f64; 2]> {
    let bolt = |step: &StepRecord| [step.answer.bolts[0].force, step.answer.bolts[0].shortening];
    outcome.steps.iter().map(bolt).collect()
}

/// Closing a clearance is a rigid displacement of loose parts: all forces are those of the joint without it, and the nut
/// has been turned that much further.
#[test]
fn a_clearance_costs_shortening_and_no_force() {
    let without = course(&joint(&[]).0);
    for path in ["solves", "multigrid"] {
        for (contact, gap) in [("contact.0.gap", 0.5), ("contact.1.gap", 3.0), ("contact.2.gap", 5.0)] {
            let set = [(contact, gap.to_string()), ("solver.path", format!("'{path}'"))];
            let (outcome, _) = joint(&set.each_ref().map(|(k, v)| (*k, v.as_str())));
            assert!(outcome.solution.certificate.passed, "{path} {contact}");
            for (with, without) in course(&outcome).iter().zip(&without) {
                assert!((with[0] / without[0] - 1.0).abs() < 1e-6, "{path} {contact}: {with:?} {without:?}");
                assert!((with[1] - without[1] - gap).abs() < 1e-6 * without[1] + 1e-8 * gap, "{with:?} {without:?}");
            }
        }
    }
}

/// A bolt by force takes at most one and a half solves more by multigrid than by the shortening it ends at.
#[test]
fn a_force_takes_few_cycles_more_than_its_shortening() {
    let multigrid = ("solver.path", "'multigrid'");
    for gap in ["0", "3"] {
        let by_force = joint(&[multigrid, ("contact.1.gap", gap)]).0;
        let [force, shortening] = course(&by_force)[0];
        let bolt = format!("{{ on = 'bolt', axis = [0, 0, 1], shortening = '{shortening:?}*min(t, 1)' }}");
        let by_shortening = joint(&[multigrid, ("contact.1.gap", gap), ("bolt.0", &bolt)]).0;
        assert!((course(&by_shortening)[0][0] / force - 1.0).abs() < 1e-6);
        let [a, b] = [&by_force, &by_shortening].map(|outcome| outcome.steps[0].answer.counts.steps());
        assert!(b > 0 && 2 * a <= 5 * b, "{gap}: {a} cycles by force, {b} by shortening");
    }
}

/// By shortening over the same clearance in four increments: the first ones press nothing.
#[test]
fn a_bolt_has_no_force_before_its_clearance_is_closed() {
    let text = |path: &str, pull: &str| {
        let set = [
            ("bolt.0", format!("{{ on = 'bolt', axis = [0, 0, 1], shortening = '{pull}' }}")),
            ("contact.1.gap", "3".into()),
            ("step.0.increments", "4".into()),
            ("solver.path", format!("'{path}'")),
        ];
        joint(&set.each_ref().map(|(k, v)| (*k, v.as_str()))).0
    };
    let tight = course(&joint(&[]).0)[0];
    for path in ["solves", "multigrid"] {
        let outcome = text(path, &format!("{:?}*min(t, 1)", 3.0 + tight[1]));
        let forces: Vec<f64> = course(&outcome).iter().map(|step| step[0]).collect();
        assert!(outcome.solution.certificate.passed && forces.len() == 5, "{path}: {forces:?}");
        assert!(forces[..3].iter().all(|f| f.abs() < 1e-6 * tight[0]), "{path}: {forces:?}");
        assert!((forces[3] / tight[0] - 1.0).abs() < 1e-6, "{path}: {forces:?}");
    }
}

/// A stiff head on a bolt and, on both sides of it, parts that it clamps, springs side by side: E A/L = 1 and 4. A pull on
/// the head is shared as 1 to 4 until the parts are unloaded at 5/4 of the pretension; beyond, the bolt carries it alone
/// (VDI 2230; Shigley, Mechanical Engineering Design, 8-7: F_b = F_i + C P with C = k_b/(k_b + k_m)).
#[test]
fn bolt_and_clamped_parts_share_a_pull_until_they_part() {
    let part = |name: &str, size: [f64; 3], cells: [usize; 3], place: [f64; 3]| {
        let mesh = block(size, cells, "element = \"hex8\"").replacen("[mesh]", &format!("[mesh.parts.{name}]"), 1);
        format!("{mesh}move = {place:?}\n")
    };
    let mesh = part("left", [2.0, 1.0, 10.0], [2, 1, 4], [0.0; 3])
        + &part("bolt", [1.0, 1.0, 10.0], [1, 1, 4], [2.0, 0.0, 0.0])
        + &part("right", [2.0, 1.0, 10.0], [2, 1, 4], [3.0, 0.0, 0.0])
        + &part("head", [5.0, 1.0, 2.0], [5, 1, 1], [0.0, 0.0, 10.0]);
    let glued =
        |part: &str| format!("[[contact]]\non = \"{part}.z-max\"\nagainst = \"head.z-min\"\nfriction = \"bonded\"\n");
    let rest = "[materials.soft]\nyoung = 10e3\npoisson = 0\non = [\"left\", \"bolt\", \"right\"]\n\
        [materials.stiff]\nyoung = 1e9\npoisson = 0\non = \"head\"\n\
        [[fix]]\non = \"bolt.z-min\"\n[[fix]]\non = [\"left.y-min\", \"right.y-min\", \"head.y-min\"]\ncomponents = \"y\"\n\
        [[bolt]]\non = \"bolt\"\naxis = [0, 0, 1]\nforce = \"1000*min(t, 1)\"\nlock = \"tighten\"\n\
        [[load]]\non = \"head.z-max\"\ntraction = [0, 0, \"max(0, t - 1)*50\"]\n\
        [[step]]\nname = \"tighten\"\nuntil = 1\n[[step]]\nuntil = 7\nincrements = 6\n";
    for clearance in [0.0, 2.0] {
        let feet = format!(
            "[[contact]]\non = [\"left.z-min\", \"right.z-min\"]\n\
             against = {{ plane = {{ point = [0, 0, -{clearance}], normal = [0, 0, 1] }} }}\nfriction = \"none\"\n"
        );
        let text = mesh.clone() + rest + &feet + &glued("left") + &glued("bolt") + &glued("right");
        let (outcome, _) = solved(&text);
        for (k, step) in course(&outcome).iter().enumerate() {
            let pull = 250.0 * k as f64;
            let wanted = if pull < 1250.0 { 1000.0 + pull / 5.0 } else { pull };
            assert!((step[0] / wanted - 1.0).abs() < 1e-4, "{clearance}, {k}: {} for {wanted}", step[0]);
        }
    }
}

/// A jump across any section gives the same state: cut through the nodes of a bearing face too, head, plates and nut carry the force of
/// the bolt. Beyond these faces nothing can take a force, which is refused.
#[test]
fn a_bolt_may_be_cut_anywhere_between_its_bearing_faces() {
    let cut_at = |z: f64| format!("{{ on = 'bolt', axis = [0, 0, 1], point = [0, 0, {z}], force = 3000 }}");
    let middle = joint(&[("bolt.0", &cut_at(0.0))]).0;
    for z in [-7.5, -6.9, -4.0, 4.0, 6.9, 7.5] {
        let outcome = joint(&[("bolt.0", &cut_at(z))]).0;
        let (found, expected) = (course(&outcome)[0], course(&middle)[0]);
        assert!((found[1] / expected[1] - 1.0).abs() < 1e-6, "cut at {z}: {found:?} {expected:?}");
        let carried = outcome.steps[0].answer.contact.normal_force / 3.0;
        assert!((carried / 3000.0 - 1.0).abs() < 1e-6, "cut at {z}: {carried}");
    }
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../cases/pretension/pretension.toml");
    for z in [-12.0, 12.0] {
        let case = case::read(&path, &[("bolt.0".into(), cut_at(z))]).unwrap();
        let error = prepare(&case).err().unwrap().to_string();
        assert!(error.contains("nothing can take it on one side of its cut"), "{error}");
    }
}

/// A bolt that would have to push is told before anything is solved, at whatever step it begins to.
#[test]
fn a_bolt_that_is_to_push_is_refused() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../cases/pretension/pretension.toml");
    for (force, told) in [("-2e3", "push with 2.0000e3"), ("'2e4*min(t, 1) - 3e4*max(t - 1, 0)'", "push with")] {
        let bolt = format!("{{ on = 'bolt', axis = [0, 0, 1], name = 'm10', force = {force} }}");
        let case = case::read(&path, &[("bolt.0".into(), bolt)]).unwrap();
        let error = prepare(&case).err().unwrap().to_string();
        assert!(error.contains("bolt \"m10\" is to push with") && error.contains(told), "{error}");
    }
}

/// With nothing under its head, where a load may act, a bolt finds nothing to press: the run says so and what to do.
#[test]
fn a_bolt_with_nothing_between_its_parts_is_told() {
    let text = block([2.0, 2.0, 8.0], [2, 2, 4], "element = \"hex8\"")
        + "[materials.steel]\nyoung = 200e3\npoisson = 0.3\n[[fix]]\non = \"z-min\"\n\
           [[load]]\non = \"z-max\"\nforce = [0, 0, 0]\n\
           [[bolt]]\non = \"body\"\naxis = [0, 0, 1]\nforce = 100\n";
    let case = case::parse(&text, "case.toml", &[]).unwrap();
    let mut prepared = prepare(&case).unwrap();
    let go_on = &mut |_: &stiction::run::Event| ControlFlow::Continue(());
    let outcome = solve_steps(&mut prepared, &Settings::of(&case.solver), None, &mut |_, _| Ok(()), go_on).unwrap();
    assert!(bolt_states(&prepared, &outcome)[0].force.abs() < 1e-6);
    let told = report(&prepared, &outcome).to_string();
    assert_eq!(outcome.solution.status, Status::NoEquilibrium);
    assert!(told.contains("the parts of bolt \"body\"") && told.contains("they come together"), "{told}");
    assert!(told.contains("tighten it by `shortening` first"), "{told}");
}

/// A column under a ceiling, cut by a bolt: the ceiling bears what the load has more than the bolt, 10 - F, if that is positive. More force
/// draws the parts together without end; without a ceiling less lets them part.
#[test]
fn what_a_bolt_cannot_hold_has_no_equilibrium() {
    let run = |load: f64, force: f64, has_ceiling: bool, path: &str| {
        let ceiling = "[[contact]]\non = \"z-max\"\nfriction = \"none\"\n\
                       against = { plane = { point = [0, 0, 3], normal = [0, 0, -1] } }\n";
        let text = block([1.0, 1.0, 3.0], [2, 2, 6], "element = \"hex8\"")
            + &format!(
                "[materials.steel]\nyoung = 200e3\npoisson = 0.3\n[[fix]]\non = \"z-min\"\n\
                 [[load]]\non = \"z-max\"\ntraction = [0, 0, {load}]\n\
                 [[bolt]]\non = \"body\"\naxis = [0, 0, 1]\npoint = [0.5, 0.5, 1.6]\nforce = {force}\n{}\
                 [solver]\npath = \"{path}\"\n",
                if has_ceiling { ceiling } else { "" }
            );
        let case = case::parse(&text, "case.toml", &[]).unwrap();
        let go_on = &mut |_: Stage| ControlFlow::Continue(());
        let (prepared, outcome, _) = solve_case(&case, &Plan::default(), &Stop::never(), None, go_on).unwrap();
        let pressed: f64 = outcome.solution.lambda[..prepared.problem.points()].iter().sum();
        let told = report(&prepared, &outcome).to_string();
        (outcome.solution.status, [pressed, bolt_states(&prepared, &outcome)[0].force], told)
    };
    for path in ["auto", "multigrid"] {
        for force in [4.0, 0.0] {
            let (status, [pressed, bolt], told) = run(10.0, force, true, path);
            assert_eq!(status, Status::Solved, "{told}");
            assert!((pressed - 10.0 + force).abs() < 1e-5 && (bolt - force).abs() < 1e-5, "{path}: {pressed} {bolt}");
        }
        for (load, force, has_ceiling, how) in [
            (10.0, 20.0, true, "they come together"),
            (-10.0, 0.0, true, "they come together"),
            (10.0, 4.0, false, "they part"),
        ] {
            let (status, _, told) = run(load, force, has_ceiling, path);
            assert!(status == Status::NoEquilibrium && told.contains(how), "{path} {load} {force}: {told}");
        }
    }
}

/// Heat pulls at the cut of a bolt and moves its parts, and is no load that would part them: the column, all of it heated, stands free under a
/// ceiling that is farther away than it grows, 0.003, until a load of 10 lifts its loose part against it; that bears 10 - F.
#[test]
fn heat_is_no_load_on_the_parts_of_a_bolt() {
    for (load, force, pressed) in [(10.0, 4.0, 6.0), (10.0, 0.0, 10.0), (0.0, 0.0, 0.0)] {
        for path in ["auto", "multigrid"] {
            let text = block([1.0, 1.0, 3.0], [2, 2, 6], "element = \"hex8\"")
                + &format!(
                    "[materials.steel]\nyoung = 200e3\npoisson = 0.3\nexpansion = 1e-5\n\
                     [[fix]]\non = \"z-min\"\ncomponents = \"z\"\n[[fix]]\non = \"x-min\"\ncomponents = \"x\"\n\
                     [[fix]]\non = \"y-min\"\ncomponents = \"y\"\n[[load]]\ntemperature = 100\n\
                     [[load]]\non = \"z-max\"\ntraction = [0, 0, {load}]\n\
                     [[bolt]]\non = \"body\"\naxis = [0, 0, 1]\npoint = [0.5, 0.5, 1.6]\nforce = {force}\n\
                     [[contact]]\non = \"z-max\"\nfriction = \"none\"\n\
                     against = {{ plane = {{ point = [0, 0, 3.01], normal = [0, 0, -1] }} }}\n[solver]\npath = \"{path}\"\n"
                );
            let case = case::parse(&text, "case.toml", &[]).unwrap();
            let go_on = &mut |_: Stage| ControlFlow::Continue(());
            let (prepared, outcome, _) = solve_case(&case, &Plan::default(), &Stop::never(), None, go_on).unwrap();
            let told = report(&prepared, &outcome).to_string();
            let ceiling: f64 = outcome.solution.lambda[..prepared.problem.points()].iter().sum();
            let bolt = &bolt_states(&prepared, &outcome)[0];
            assert_eq!(outcome.solution.status, Status::Solved, "{path} {load} {force}: {told}");
            assert!((ceiling - pressed).abs() < 1e-5 && (bolt.force - force).abs() < 1e-5, "{path}: {ceiling} {told}");
            // The loose part goes as far as the gap is wider than all have grown, and back by what is pressed.
            let way = if load > 0.0 { 0.01 - 0.003 } else { 0.0 };
            assert!((bolt.shortening + way).abs() < 2e-4, "{path} {load} {force}: {}", bolt.shortening);
        }
    }
}

/// A bar held at both ends and cut in its middle has the force E A s / L: by faces between cells, on the mesh as it is made
/// and where it has been refined at random.
#[test]
fn a_cut_between_cells_is_the_same_on_refined_cells() {
    for (element, order) in [("hex8", Order::Linear), ("hex8", Order::Quadratic), ("tet10", Order::Quadratic)] {
        let text = block([2.0, 2.0, 8.0], [2, 2, 4], &format!("element = \"{element}\""))
            + CORNER
            + "[materials.steel]\nyoung = 200e3\npoisson = 0.3\n[[fix]]\non = \"z-max\"\ncomponents = \"z\"\n\
               [[bolt]]\non = \"cut\"\nshortening = 0.01\n";
        let mut case = case::parse(&text, "case.toml", &[]).unwrap();
        let MeshSource::Block(description) = &case.mesh.source else { panic!("a block") };
        let mut mesh = make_block(description).unwrap();
        let in_cut = |&node: &u32| (mesh.nodes[node as usize][2] - 4.0).abs() < 1e-9;
        let mut group = Group { name: "cut".into(), ..Group::default() };
        for (kind, cell) in mesh.cell_iter() {
            for local in kind.faces() {
                let nodes: Vec<u32> = local.iter().map(|&i| cell[i]).filter(in_cut).collect();
                // Each face once: seen from above, from the cell under it.
                let below = cell.iter().all(|&node| mesh.nodes[node as usize][2] < 4.0 + 1e-9);
                if nodes.len() == local.len() && below {
                    let corners = kind.linear().faces()[0].len();
                    group.interior_faces.push([0, 1, 2, 3].map(|i| if i < corners { nodes[i] } else { u32::MAX }));
                    group.nodes.extend(&nodes[corners..]);
                }
            }
        }
        group.nodes.sort_unstable();
        group.nodes.dedup();
        mesh.groups.push(group);
        let mut at = tetrahedra(&mesh, order).unwrap();
        for level in 0..3u32 {
            case.mesh.source = MeshSource::Given(Arc::new((at.mesh.clone(), MeshNotes::default())));
            let prepared = prepare(&case).unwrap_or_else(|e| panic!("{e}"));
            let go_on = &mut |_: &stiction::run::Event| ControlFlow::Continue(());
            let outcome = solve(&prepared, &Settings::of(&case.solver), go_on).unwrap();
            let force = bolt_states(&prepared, &outcome)[0].force;
            assert!((force / 1000.0 - 1.0).abs() < 1e-7, "{element} {order:?} {level}: {force}");
            let some: Vec<u32> = (0..at.mesh.cell_count() as u32).filter(|cell| (cell * 7 + level) % 5 == 0).collect();
            at = refine(&at, &some, 2).unwrap().next;
        }
    }
}

/// A lap joint in metres whose second bolt has no force yet: nothing moves its shank, head and nut sideways. The
/// rounding of where the iteration has left them is no force.
#[test]
fn a_bolt_without_force_stays_where_it_is() {
    let case_in = |mm: f64| {
        let block = |name: &str, size: [f64; 3], origin: [f64; 3], cells: [usize; 3]| {
            let [size, origin] = [size, origin].map(|x| x.map(|c| c * mm));
            format!(
                "[mesh.parts.{name}]\nblock = {{ size = {size:?}, origin = {origin:?}, cells = {cells:?}, element = \"tet10\" }}\n"
            )
        };
        let contact = |on: &str, against: &str, law: &str| {
            format!("[[contact]]\non = \"{on}\"\nagainst = \"{against}\"\n{law}\n")
        };
        let friction = "friction = { coulomb = 0.3 }";
        let mut parts = block("lower", [60.0, 20.0, 10.0], [-30.0, -10.0, 0.0], [12, 4, 2]);
        parts += &block("upper", [60.0, 20.0, 10.0], [-30.0, -10.0, 10.0], [10, 4, 2]);
        let mut rest = contact("upper.z-min", "lower.z-max", &format!("{friction}\ngap = {:e}", -0.01 * mm));
        for (n, x, force) in [(1, -18.0, "1e4*min(1, t)"), (2, 18.0, "8e3*max(0, t - 1)")] {
            parts += &block(&format!("shank{n}"), [4.0, 4.0, 20.0], [x - 2.0, -2.0, 0.0], [2, 2, 6]);
            parts += &block(&format!("head{n}"), [8.0, 8.0, 4.0], [x - 4.0, -4.0, 20.0], [4, 4, 2]);
            parts += &block(&format!("nut{n}"), [8.0, 8.0, 4.0], [x - 4.0, -4.0, -4.0], [4, 4, 2]);
            rest += &contact(&format!("head{n}.z-min"), "upper.z-max", friction);
            rest += &contact(&format!("nut{n}.z-max"), "lower.z-min", friction);
            rest += &contact(&format!("shank{n}.z-max"), &format!("head{n}.z-min"), "friction = \"bonded\"");
            rest += &contact(&format!("shank{n}.z-min"), &format!("nut{n}.z-max"), "friction = \"bonded\"");
            rest += &format!("[[bolt]]\non = \"shank{n}\"\naxis = [0, 0, 1]\nforce = \"{force}\"\n");
        }
        let steel =
            format!("[materials.s]\nyoung = {:e}\npoisson = 0.3\n[[fix]]\non = \"lower.x-min\"\n", 2.1e5 / (mm * mm));
        case::parse(&format!("{parts}{steel}{rest}[[step]]\nuntil = 1\n[solver]\npath = \"multigrid\"\n"), "joint", &[])
            .unwrap()
    };
    let mm = 1e-3;
    let (outcome, prepared) = solved_case(&case_in(mm));
    let second = (0..prepared.mesh.nodes.len())
        .filter(|&i| prepared.mesh.nodes[i][0] > 0.0 && prepared.mesh.nodes[i][2] > 20.5 * mm);
    let sideways = second.map(|i| outcome.solution.u[3 * i].hypot(outcome.solution.u[3 * i + 1])).fold(0.0, f64::max);
    let largest = outcome.solution.u.iter().fold(0.0f64, |m, u| m.max(u.abs()));
    assert!(largest > 0.01 * mm && sideways < 1e-6 * largest, "{sideways:e} of {largest:e}");
}

/// A cover on a pad, drawn down by a bolt at each end: the tighter one tips it, which slackens the other, and the pad opens at its end.
/// The body is symmetrical, so exchanged forces take exchanged shortenings, whatever the search did on its way; and the pad bears both.
#[test]
fn bolts_of_unequal_forces_are_found_whichever_is_the_tighter_one() {
    for element in ["hex20", "tet10"] {
        let bolts = |path: &str, [first, second]: [f64; 2]| {
            let part = |name: &str, size: &str, cells: &str, by: &str| {
                format!(
                    "[mesh.parts.{name}]\nblock = {{ size = {size}, cells = {cells}, element = \"{element}\" }}\nmove = {by}\n"
                )
            };
            let parts = [
                part("base", "[80, 20, 10]", "[8, 2, 1]", "[0, 0, 0]"),
                part("pad", "[40, 20, 20]", "[4, 2, 2]", "[20, 0, 10]"),
                part("cover", "[80, 20, 8]", "[8, 2, 1]", "[0, 0, 30]"),
                part("b1", "[8, 8, 20]", "[1, 1, 3]", "[4, 6, 10]"),
                part("b2", "[8, 8, 20]", "[1, 1, 3]", "[68, 6, 10]"),
            ];
            let text = format!(
                "{}[materials.steel]\nyoung = 210e3\npoisson = 0.3\n[[fix]]\non = \"base.z-min\"\n\
                 [[contact]]\non = [\"b1.z-min\", \"b2.z-min\"]\nagainst = \"base.z-max\"\nfriction = \"bonded\"\n\
                 [[contact]]\non = [\"b1.z-max\", \"b2.z-max\"]\nagainst = \"cover.z-min\"\nfriction = \"bonded\"\n\
                 [[contact]]\nname = \"pad\"\non = \"pad.z-min\"\nagainst = \"base.z-max\"\nfriction = {{ coulomb = 0.1 }}\n\
                 [[contact]]\non = \"pad.z-max\"\nagainst = \"cover.z-min\"\nfriction = {{ coulomb = 0.1 }}\n\
                 [[bolt]]\nname = \"one\"\non = \"b1\"\naxis = [0, 0, 1]\nforce = {first}\n\
                 [[bolt]]\nname = \"two\"\non = \"b2\"\naxis = [0, 0, 1]\nforce = {second}\n[solver]\npath = \"{path}\"\n",
                parts.concat()
            );
            let (outcome, prepared) = solved(&text);
            let pad = pair_totals(&prepared, &outcome).into_iter().find(|(name, _)| name == "pad").unwrap().1;
            assert!((pad.normal_force / (first + second) - 1.0).abs() < 1e-6, "{element} {path}: {pad:?}");
            let states = bolt_states(&prepared, &outcome);
            for (state, wanted) in states.iter().zip([first, second]) {
                assert!((state.force - wanted).abs() < 1e-6 * 5000.0, "{element} {path}: {states:?}");
            }
            [states[0].shortening, states[1].shortening]
        };
        let [tight, slack] = bolts("auto", [5000.0, 50.0]);
        for path in ["auto", "solves", "multigrid"] {
            let [a, b] = bolts(path, [50.0, 5000.0]);
            // Tetrahedra are not their own mirror images.
            let bound = if element == "tet10" { 0.02 } else { 1e-5 };
            let at = format!("{element} {path}: {a} {b} for {slack} {tight}");
            assert!((a / slack - 1.0).abs() < bound && (b / tight - 1.0).abs() < bound, "{at}");
        }
    }
}
