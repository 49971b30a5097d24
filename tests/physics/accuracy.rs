//! Refinement until an answer is as accurate as asked, beside known limits.

use std::ops::ControlFlow;

use stiction::Error;
use stiction::io::case::{self, AccuracySpec};
use stiction::linalg::Stop;
use stiction::run::{
    AccuracyRecord, Indicators, Level, LevelRecord, Levels, Outcome, Plan, Prepared, Sequence, Settings, SolvedLevel,
    Stage, ValueRecord, add_bound, prepare, solve, solve_case, solve_to_accuracy,
};
use stiction_fixtures::case_run::CASE;

/// A quarter of a square foot without radius under a block: pressure grows without bound towards its edges.
const PUNCH: &str = r#"
[mesh]
block = { size = [2, 2, 2], cells = [4, 4, 4], element = "hex8" }
[materials.steel]
young = 210e3
poisson = 0.3
[[fix]]
on = "x-min"
components = "x"
[[fix]]
on = "y-min"
components = "y"
[[fix]]
on = "z-max"
components = "z"
value = -1e-3
[[contact]]
on = { box = [[0, 0, 0], [1, 1, 0]] }
against = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }
friction = "none"
"#;

/// A cube of hexahedra pressed on a block that is wider than it.
const CUBE_ON_BLOCK: &str = r#"
[mesh.parts.cube]
block = { size = [1, 1, 1], cells = [2, 2, 2], element = "hex8" }
move = [0.5, 0.5, 1]
[mesh.parts.base]
block = { size = [2, 2, 1], cells = [3, 3, 2], element = "tet4" }
[materials.steel]
young = 210e3
poisson = 0.3
[[fix]]
on = "base.z-min"
[[fix]]
on = "cube.z-max"
components = "xy"
[[load]]
on = "cube.z-max"
traction = [0, 0, -100]
[[contact]]
on = "cube.z-min"
against = "base.z-max"
friction = { coulomb = 0.3 }
"#;

/// The brick of the source paper's kind on a coarse mesh; its limits are known from many uniform and adaptive meshes.
fn brick() -> String {
    CASE.replace("cells = [9, 3, 3]", "cells = [6, 2, 2]").replace("{ coulomb = 0.35 }", "\"none\"")
}

fn refined(text: &str, goals: &str) -> (Prepared, Outcome, AccuracyRecord) {
    let case = case::parse(&format!("{text}\n[accuracy]\n{goals}"), "case.toml", &[]).unwrap();
    let mut told = Vec::new();
    let mut tell = |stage: Stage| {
        if let Stage::Level(level) = stage {
            told.push(level.clone());
        }
        ControlFlow::Continue(())
    };
    let (prepared, outcome, _) = solve_case(&case, &Plan::default(), &Stop::never(), None, &mut tell).unwrap();
    let record = outcome.accuracy.clone().unwrap();
    assert_eq!(told, record.levels);
    (prepared, outcome, record)
}

/// Energy of the continuum of the brick without friction, -72.6928(5), and the norm of its solution: extrapolated from meshes of up
/// to 107,000 quadratic unknowns by another program.
const ENERGY: f64 = -72.6928;
const NORM: f64 = 12.05;

/// The power of the number of unknowns with which `error` falls from one level to another.
fn rate(from: (&LevelRecord, f64), to: (&LevelRecord, f64)) -> f64 {
    (from.1 / to.1).ln() / (to.0.unknowns as f64 / from.0.unknowns as f64).ln()
}

#[test]
fn the_brick_gets_the_accuracy_that_is_asked_for() {
    let (_, outcome, record) = refined(&brick(), "energy = 0.02");
    assert!(record.reached && record.ended.is_none() && record.needed_unknowns.is_none());
    let truth = |level: &LevelRecord| (2.0 * (level.values.get("energy").unwrap() - ENERGY)).sqrt() / NORM;
    for pair in record.levels.windows(2) {
        assert!(truth(&pair[1]) < truth(&pair[0]) && pair[1].unknowns > pair[0].unknowns);
        let effectivity = pair[1].error / truth(&pair[1]);
        assert!((0.85..1.2).contains(&effectivity), "{} unknowns: {effectivity}", pair[1].unknowns);
    }
    let (second, last) = (&record.levels[1], record.levels.last().unwrap());
    let rate = rate((second, truth(second)), (last, truth(last)));
    assert!(rate > 0.48, "{rate}");
    // A true error of 2 % takes 44,000 unknowns on uniform meshes of the same elements.
    let after = record.levels.iter().position(|level| truth(level) < 0.02).unwrap();
    let [coarse, fine] = [&record.levels[after - 1], &record.levels[after]];
    let part = (truth(coarse) / 0.02).ln() / (truth(coarse) / truth(fine)).ln();
    let needed = coarse.unknowns as f64 * (fine.unknowns as f64 / coarse.unknowns as f64).powf(part);
    assert!(needed < 20_000.0, "{needed}");
    // Each level starts from the one before it: never more than twice the cycles of a single solve.
    assert!(record.levels.iter().all(|level| level.iterations <= 25), "{:?}", record.levels);
    // Limits from the same sequences, with their uncertainty.
    for (name, limit, uncertain) in [("normal force", 6.475e5, 5e2), ("largest displacement", 2.226e-4, 5e-8)] {
        let value = record.values.iter().find(|value| value.name == name).unwrap();
        let off = (value.value.unwrap() - limit).abs();
        assert!(off <= value.bar.unwrap() + uncertain, "{name}: {off} of {value:?}");
        assert!(value.bar.unwrap() < 0.02 * limit, "{value:?}");
    }
    assert!(outcome.solution.certificate.passed);
}

#[test]
fn the_estimate_is_near_the_error_with_friction_as_well() {
    // The energy of the continuum comes from the same other program as that without friction.
    const ENERGY: f64 = -72.4886;
    const NORM: f64 = 12.05;
    let text = brick().replace("\"none\"", "{ coulomb = 0.35 }");
    let (_, _, record) = refined(&text, "energy = 0.02");
    for level in &record.levels[1..] {
        let truth = (2.0 * (level.values.get("energy").unwrap() - ENERGY)).sqrt() / NORM;
        assert!(
            (0.85..1.2).contains(&(level.error / truth)),
            "{} unknowns: {} of {truth}",
            level.unknowns,
            level.error
        );
    }
}

#[test]
fn a_peak_without_limit_gets_no_value_and_is_no_goal() {
    let (_, _, record) = refined(PUNCH, "energy = 0.07\nforces = 0.02\npressure = 0.5");
    assert!(record.reached, "{:?}", record.ended);
    let of = |name: &str| record.values.iter().find(|value| value.name == name).unwrap();
    assert_eq!((of("largest pressure").value, of("largest pressure").bar), (None, None));
    // The mean is finite: it is the force over a square of side 1.
    let [mean, force] = ["mean pressure", "normal force"].map(|name| of(name).value.unwrap());
    assert!((mean - force).abs() < 1e-9 * force, "{mean} {force}");
    // The force falls from mesh to mesh: the energy of the answers does, and the support moves the same way.
    let forces: Vec<f64> = record.levels.iter().map(|level| level.values.get("normal force").unwrap()).collect();
    assert!(forces.is_sorted_by(|a, b| a > b), "{forces:?}");
    // Uniform meshes give 1/6 for a singularity of the root of the distance: twice that at least.
    let (first, last) = (&record.levels[1], record.levels.last().unwrap());
    let rate = rate((first, first.error), (last, last.error));
    assert!(rate > 1.0 / 3.0, "{rate}");
}

/// The energy falls to one limit with both kinds of cells; the error in the energy norm is the root of what is above it.
#[test]
fn the_error_under_a_punch_falls_with_the_power_that_the_element_allows() {
    let levels = |cells: &str, goals: &str| refined(&PUNCH.replace("hex8", cells), goals).2.levels;
    let quadratic = levels("tet10", "energy = 0.04");
    let linear = levels("tet4", "energy = 0.11\nelement = \"tet4\"");
    let energy = |level: &LevelRecord| level.values.get("energy").unwrap();
    // The last four meshes of quadratic cells, by the fall of the squared estimate.
    let [a, b] = [quadratic.len() - 4, quadratic.len() - 1].map(|k| &quadratic[k]);
    let [of_a, of_b] = [a, b].map(|level| energy(level) * level.error.powi(2));
    let limit = energy(b) - (energy(a) - energy(b)) / (of_a - of_b) * of_b;
    let rate_of = |levels: &[LevelRecord]| {
        let error = |level: &LevelRecord| (energy(level) - limit).sqrt();
        let (first, last) = (&levels[0], levels.last().unwrap());
        rate((first, error(first)), (last, error(last)))
    };
    let rates = [rate_of(&linear), rate_of(&quadratic)];
    assert!(rates[0] > 0.30 && rates[1] > 0.45, "{rates:?}");
}

/// A quarter of a block on a ball of radius 10, from cells 2.5 times as wide as the radius of contact.
fn hertz() -> String {
    let block =
        PUNCH.replace("size = [2, 2, 2]", "size = [1, 1, 1]").replace("{ box = [[0, 0, 0], [1, 1, 0]] }", "\"z-min\"");
    block.replace("plane = { point = [0, 0, 0], normal = [0, 0, 1] }", "sphere = { center = [0, 0, -10], radius = 10 }")
}

/// Hertz's radius and largest pressure for the force found. The radius is that of the second moment of the forces, of which
/// Hertz's pressure has `2/5 a²` for each unit of force.
#[test]
fn hertz_is_met_with_few_unknowns_from_cells_wider_than_the_contact() {
    let (prepared, outcome, record) = refined(&hertz(), "energy = 0.08");
    assert!(prepared.problem.unknowns() < 8000);
    let fine = refined(&hertz(), "energy = 0.02").2;
    let of = |record: &AccuracyRecord, name: &str| record.levels.last().unwrap().values.get(name).unwrap();
    let force = of(&record, "normal force");
    let off = force / of(&fine, "normal force") - 1.0;
    assert!(off.abs() < 0.003, "{off}");
    let radius = (3.0 * 4.0 * force * 10.0 / (4.0 * 210e3 / (1.0 - 0.09))).cbrt();
    let peak = of(&record, "largest pressure") / (3.0 * 4.0 * force / (2.0 * std::f64::consts::PI * radius * radius));
    assert!((peak - 1.0).abs() < 0.01, "{peak}");
    let nodal = prepared.problem.contact.B.transpose_times(&outcome.solution.lambda);
    let along_z = nodal.iter().zip(&prepared.model.dofs.free).filter(|(_, dof)| *dof % 3 == 2);
    let moment = along_z.map(|(f, &dof)| {
        let [x, y, _] = prepared.mesh.nodes[dof as usize / 3];
        -f * (x * x + y * y)
    });
    let found = (2.5 * moment.sum::<f64>() / force).sqrt();
    assert!((found / radius - 1.0).abs() < 0.02, "{found} {radius}");
}

/// A quarter of a steel ring in one of aluminium that is 0.06 too tight, radii 40, 60 and 90, plane stress without friction.
fn shrink_fit(cells: usize, elements: [&str; 2], slave: &str) -> String {
    let part = |name: &str, radii: [f64; 2], element: &str| {
        format!(
            "[mesh.parts.{name}]\nring = {{ radii = {radii:?}, height = 10, degrees = 90, cells = [2, {cells}, 1], \
             element = \"{element}\" }}\n"
        )
    };
    let fix = |groups: &str, components: &str| {
        format!("[[fix]]\non = [\"inner.{groups}\", \"outer.{groups}\"]\ncomponents = \"{components}\"\n")
    };
    [
        part("inner", [40.0, 60.0], elements[0]),
        part("outer", [60.0, 90.0], elements[1]),
        fix("end", "x"),
        fix("start", "y"),
        fix("z-min", "z"),
        format!(
            r#"
[materials.steel]
on = "inner"
young = 210e3
poisson = 0.3
[materials.aluminium]
on = "outer"
young = 70e3
poisson = 0.33
[[contact]]
on = "inner.outer"
against = "outer.inner"
gap = -0.06
friction = "none"
slave = "{slave}"
"#
        ),
    ]
    .concat()
}

/// Lamé 1852.
#[test]
fn what_is_read_of_a_curved_fit_lies_within_its_bars() {
    let [a2, b2, c2] = [1600.0, 3600.0, 8100.0];
    let outside = 60.0 / 70e3 * ((c2 + b2) / (c2 - b2) + 0.33);
    let inside = 60.0 / 210e3 * ((b2 + a2) / (b2 - a2) - 0.3);
    let pressure = 0.06 / (outside + inside);
    let area = std::f64::consts::FRAC_PI_2 * 60.0 * 10.0;
    // At the inner edge of the outer ring, which shortens along the axis as well.
    let along = 0.33 / 70e3 * 2.0 * pressure * b2 / (c2 - b2) * 10.0;
    let expected = [
        ("normal force", pressure * area),
        ("contact area", area),
        ("mean pressure", pressure),
        ("largest displacement", (pressure * outside).hypot(along)),
        ("energy", 0.5 * pressure * 0.06 * area),
    ];
    for (cells, elements, slave, goal) in [
        (6, ["hex8", "hex8"], "against", 0.03),
        (6, ["hex20", "tet10"], "on", 0.03),
        (4, ["tet4", "hex8"], "against", 0.05),
        (9, ["hex8", "tet10"], "on", 0.01),
    ] {
        let (_, _, record) = refined(&shrink_fit(cells, elements, slave), &format!("energy = {goal}"));
        assert!(record.reached);
        for (name, exact) in expected {
            let found = record.values.iter().find(|value| value.name == name).unwrap();
            let (value, bar) = (found.value.unwrap(), found.bar.unwrap());
            let told = format!("{cells} {elements:?} {slave} {goal}: {name} {value} within {bar}, {exact}");
            assert!((value - exact).abs() <= bar && bar < 0.02 * exact, "{told}");
        }
    }
}

/// A fit that slides from its ends: friction holds a sleeve of aluminium that is pressed together against the steel around it. With two cells
/// along the axis slip has reached the end nodes alone, and the friction that sticking nodes beside them leave is three quarters of what is missing.
/// Fixed meshes of 4 x 6 x 12, 4 x 6 x 24 and 4 x 4 x 48 hexahedra of second order, finer towards the ends, have 940.0, 951.8 and 954.9.
#[test]
fn friction_where_the_edge_of_slip_is_not_resolved_lies_within_its_bar() {
    let ring = |name: &str, radii: [f64; 2], cells: [usize; 3]| {
        format!(
            "[mesh.parts.{name}]\nring = {{ radii = {radii:?}, height = 10, degrees = 90, cells = {cells:?}, element = \"hex8\" }}\n"
        )
    };
    let rest = r#"
[materials.aluminium]
on = "in"
young = 70e3
poisson = 0.33
[materials.steel]
on = "around"
young = 210e3
poisson = 0.3
[[fix]]
on = ["in.start", "around.start"]
condition = "symmetry"
[[fix]]
on = ["in.end", "around.end"]
condition = "symmetry"
[[fix]]
on = ["in.z-min", "around.z-min"]
condition = "symmetry"
[[contact]]
on = "in.outer"
against = "around.inner"
gap = -0.02
friction = { coulomb = 0.1 }
"#;
    for cells in [[2, 4, 2], [2, 3, 2], [2, 2, 2]] {
        let text = ring("in", [10.0, 20.0], cells) + &ring("around", [20.0, 30.0], cells) + rest;
        let (_, _, record) = refined(&text, "energy = 0.03");
        let friction = record.values.iter().find(|value| value.name == "friction force").unwrap();
        let (value, bar) = (friction.value.unwrap(), friction.bar.unwrap());
        assert!((value - 957.0).abs() <= bar && bar < 0.15 * value, "{cells:?}: {value} within {bar}");
    }
}

/// A quarter of a shaft in a hub that is wider by 0.02, pressed to one side: faces of 30 and 22.5 degrees are off the cylinders by up to a tenth
/// of that. The gap as a length says what is true.
fn loose_fit(gap: &str) -> String {
    let ring = |name: &str, radii: [f64; 2], cells: [usize; 3]| {
        format!(
            "[mesh.parts.{name}]\nring = {{ radii = {radii:?}, height = 4, degrees = 90, cells = {cells:?}, element = \"tet10\", split = \"six\" }}\n"
        )
    };
    let parts = ring("shaft", [5.0, 19.98], [2, 3, 1]) + &ring("hub", [20.0, 30.0], [2, 4, 1]);
    format!(
        "{parts}[materials.steel]\nyoung = 2e5\npoisson = 0.3\n[[fix]]\non = \"hub.end\"\ncondition = \"symmetry\"\n\
         [[fix]]\non = [\"shaft.z-min\", \"hub.z-min\"]\ncondition = \"symmetry\"\n[[fix]]\non = \"hub.outer\"\n\
         [[fix]]\non = [\"shaft.start\", \"hub.start\"]\ncomponents = \"y\"\n[[load]]\non = \"shaft.inner\"\nforce = [8000, 0, 0]\n\
         [[contact]]\non = \"shaft.outer\"\nagainst = \"hub.inner\"\n{gap}friction = \"none\"\n"
    )
}

/// Finer meshes keep the shape of the first one: without a share for it the bar of the energy is a fifth of its error. With the gap as a length
/// nothing is open.
#[test]
fn what_faces_are_off_curved_surfaces_of_contact_is_in_the_bars() {
    let of = |gap: &str| refined(&loose_fit(gap), "energy = 0.06").2;
    let (meshed, exact) = (of(""), of("gap = 0.02\n"));
    assert!(meshed.reached && exact.reached && exact.warnings.is_empty());
    let mut off = 0.0f64;
    for (found, truth) in meshed.values.iter().zip(&exact.values) {
        assert_eq!(found.name, truth.name);
        // The largest pressure may be none, at the ends of contact.
        let (Some(value), Some(true_value), Some(bar)) = (found.value, truth.value, found.bar) else { continue };
        let error = (value - true_value).abs();
        assert!(error <= bar + truth.bar.unwrap_or(0.0), "{found:?} {truth:?}");
        off = off.max(error / truth.bar.unwrap_or(f64::INFINITY));
    }
    assert!(off > 3.0, "{off}");
    // A goal that the shape forbids ends the refinement with a word.
    let (_, _, missed) = refined(&loose_fit(""), "displacement = 1e-4");
    let why = missed.ended.unwrap();
    assert!(
        !missed.reached
            && missed.needed_unknowns.is_none()
            && why.contains("shape of the first mesh")
            && missed.levels.len() <= 4,
        "{why}"
    );
}

#[test]
fn two_bodies_are_both_refined_and_keep_their_roles() {
    let (prepared, outcome, record) = refined(CUBE_ON_BLOCK, "energy = 0.06");
    assert!(record.reached);
    for (name, before) in [("cube.body", 8 * 6), ("base.body", 3 * 3 * 2 * 6)] {
        let cells = prepared.mesh.groups.iter().find(|group| group.name == name).unwrap().cells.len();
        assert!(cells > before, "{name}: {cells}");
    }
    // The load of 100 on a unit square goes through the contact whatever the mesh.
    for level in &record.levels {
        let force = level.values.get("normal force").unwrap();
        assert!((force - 100.0).abs() < 1e-5, "{force}");
    }
    let faces = |i: usize| prepared.mesh.faces[prepared.surfaces[0].faces[i] as usize].corners()[0];
    assert!(prepared.mesh.nodes[faces(0) as usize][2] == 1.0);
    assert!(outcome.solution.certificate.passed);
}

/// A block that is lifted off again at the end needs no other meshes than one that is not: no cell of it is strained then.
#[test]
fn a_body_that_is_lifted_off_at_the_end_needs_no_finer_mesh() {
    let text = |lift: &str| {
        format!(
            "[mesh]\nblock = {{ size = [10, 10, 5], cells = [3, 3, 2], element = \"tet10\" }}\n\
             [materials.soft]\nyoung = 1000\npoisson = 0.3\n\
             [[fix]]\non = \"z-max\"\nvalue = [\"0.1*min(max(t - 1, 0), 1)\", 0, \"-0.05*min(t, 1) + 0.06*max(t - 2, 0)\"]\n\
             [[contact]]\non = \"z-min\"\nagainst = {{ plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }} }}\n\
             friction = {{ coulomb = 0.3 }}\n\
             [[step]]\nname = \"press\"\nuntil = 1\n[[step]]\nname = \"drag\"\nuntil = 2\nincrements = 2\n{lift}"
        )
    };
    let goals = "energy = 0.2\nmax_unknowns = 30000";
    let (_, _, stays) = refined(&text(""), goals);
    let (_, outcome, lifted) = refined(&text("[[step]]\nname = \"lift\"\nuntil = 3\n"), goals);
    assert!(outcome.steps.last().unwrap().answer.contact.normal_force == 0.0 && lifted.reached, "{lifted:?}");
    assert_eq!(stays.levels.len(), lifted.levels.len());
    for (stays, lifted) in stays.levels.iter().zip(&lifted.levels) {
        assert_eq!(stays.unknowns, lifted.unknowns);
        assert!((lifted.error / stays.error - 1.0).abs() < 1e-6, "{lifted:?} {stays:?}");
    }
    // Goals of values are of what was read before as well, which is what it was.
    let goals = "forces = 0.2\ndisplacement = 0.5\nmax_unknowns = 30000";
    let (_, _, stays) = refined(&text(""), goals);
    let (_, _, lifted) = refined(&text("[[step]]\nname = \"lift\"\nuntil = 3\n"), goals);
    assert!(stays.reached && lifted.reached && stays.levels.len() == lifted.levels.len());
    for (stays, lifted) in stays.goals.iter().zip(&lifted.goals) {
        let (stays, lifted) = (stays.reached.unwrap(), lifted.reached.unwrap());
        assert!(stays > 0.0 && (lifted / stays - 1.0).abs() < 1e-3, "{stays} {lifted}");
    }
    for value in stays.values.iter().filter(|value| value.t.is_some() || value.name.contains("force")) {
        let before = |other: &&ValueRecord| value.t.map_or(2.0, |t| t) == other.t.unwrap_or(3.0);
        let name = value.name.split(" at t = ").next().unwrap();
        let kept = lifted.values.iter().filter(before).find(|other| other.name.starts_with(name)).unwrap();
        assert!((kept.value.unwrap() / value.value.unwrap() - 1.0).abs() < 1e-6, "{kept:?} {value:?}");
    }
}

#[test]
fn what_cannot_be_reached_ends_early_and_says_what_it_takes() {
    let (prepared, outcome, record) = refined(&brick(), "energy = 0.002\nmax_unknowns = 9000");
    assert!(!record.reached);
    assert!(prepared.problem.unknowns() <= 9000 && outcome.solution.certificate.passed);
    assert!(record.ended.unwrap().contains("`max_unknowns`") || record.needed_unknowns.unwrap() > 9000.0);
    // The brick needs 1.2 million for 0.2 % by the rate N^-1/2 from 2 % at 17,000.
    let needed = record.needed_unknowns.unwrap();
    assert!((2e5..1e7).contains(&needed), "{needed}");
}

#[test]
fn with_a_proof_the_bound_decides_when_it_is_enough() {
    let (_, outcome, record) = refined(&brick(), "energy = 0.06\nproven = true");
    assert!(record.reached);
    let bound = outcome.bound.unwrap().unwrap();
    let (last, before) = record.levels.split_last().unwrap();
    assert_eq!(last.bound, Some(bound.mean_relative()));
    assert!(bound.mean_relative() <= 0.06 && before.iter().all(|level| level.bound.is_none_or(|bound| bound > 0.06)));
    // Energy of the continuum from other meshes, as above: it lies in the interval, and the error is below its bound.
    assert!(bound.energy[0] <= ENERGY && ENERGY <= bound.energy[1], "{:?}", bound.energy);
    assert!((2.0 * (last.values.get("energy").unwrap() - ENERGY)).sqrt() <= bound.error);
}

/// Solves each level and makes its bound three times what it is.
struct Doubtful(Vec<Sequence>);

impl Levels for Doubtful {
    fn solve(&mut self, level: &Level) -> Result<SolvedLevel, Error> {
        let prepared = prepare(&level.case)?;
        let settings = Settings::of(&level.case.solver);
        let mut outcome = solve(&prepared, &settings, &mut |_| ControlFlow::Continue(()))?;
        add_bound(&prepared, &mut outcome, &Stop::never());
        if let Some(Ok(bound)) = &mut outcome.bound {
            bound.mean_error *= 3.0;
        }
        let mut indicators = Indicators::default();
        indicators.add(&prepared, &outcome, 1.0);
        Ok(SolvedLevel { prepared, outcome, indicators })
    }

    fn finished(&mut self, sequence: &Sequence) -> Result<(), Error> {
        self.0.push(sequence.clone());
        Ok(())
    }
}

#[test]
fn an_estimate_below_the_goal_is_not_enough_where_the_bound_is_above_it() {
    let case =
        case::parse(&format!("{}\n[accuracy]\nenergy = 0.13\nproven = true", brick()), "case.toml", &[]).unwrap();
    let mut work = Doubtful(Vec::new());
    let (_, outcome) = solve_to_accuracy(&case, case.accuracy.as_ref().unwrap(), None, &mut work).unwrap();
    // The first mesh has 12 %, and the third less than 6 %.
    let errors: Vec<f64> = work.0.iter().map(|sequence| sequence.levels.last().unwrap().error).collect();
    assert!(errors.len() > 3 && errors[0] < 0.13, "{errors:?}");
    let record = outcome.accuracy.unwrap();
    let bounds: Vec<f64> = record.levels.iter().map(|level| level.bound.unwrap()).collect();
    assert!(record.reached && bounds.iter().position(|&bound| bound <= 0.13) == Some(bounds.len() - 1), "{bounds:?}");

    // Where no proof is asked for any more, the bound that was stored does not count.
    let estimated = AccuracySpec { proven: false, ..case.accuracy.unwrap() };
    let third = work.0[2].clone();
    let (_, outcome) = solve_to_accuracy(&case, &estimated, Some(third), &mut work).unwrap();
    let record = outcome.accuracy.unwrap();
    assert!(record.reached && record.levels.len() == 3 && record.levels[2].bound > Some(0.13), "{record:?}");
}
