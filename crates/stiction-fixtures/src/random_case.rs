//! Cases drawn at random, as a user might write them: one or two bodies of any element, thin, soft or stiff, held by supports
//! or by contact alone. For the test and for the benchmark that draws more of them.

use std::ops::ControlFlow;

use stiction::friction::Status;
use stiction::io::case::{self, Case};
use stiction::ranks::threads;
use stiction::run::{Event, Outcome, Prepared, Settings, prepare, solve, solve_on_ranks, solve_steps, widened};

/// A small linear congruential generator: one number seeds a whole case.
pub(crate) struct Draw(u64);

impl Draw {
    pub(crate) fn seeded(seed: u64) -> Self {
        let mut draw = Draw(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(1));
        (0..4).for_each(|_| _ = draw.unit());
        draw
    }

    pub(crate) fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(crate) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    pub(crate) fn one<T: Copy>(&mut self, of: &[T]) -> T {
        of[((self.unit() * of.len() as f64) as usize).min(of.len() - 1)]
    }

    pub(crate) fn cells(&mut self, most: usize) -> [usize; 3] {
        [0; 3].map(|_| 2 + (self.unit() * (most - 1) as f64) as usize)
    }
}

/// The law, and the share of the pressure that it can hold along x.
fn law(d: &mut Draw, young: f64) -> (String, f64) {
    let coefficient = d.one(&[0.05, 0.3, 0.3, 0.7, 1.0, 2.0, 5.0]);
    match d.unit() {
        x if x < 0.15 => ("\"none\"".into(), 0.0),
        x if x < 0.25 => ("\"bonded\"".into(), 1.0),
        x if x < 0.45 => (format!("{{ tresca = {:e} }}", young * 1e-4 * d.unit()), 0.0),
        x if x < 0.8 => (format!("{{ coulomb = {coefficient} }}"), coefficient),
        _ => {
            let across = coefficient * d.one(&[0.1, 0.5, 2.0]);
            let law = format!("{{ coulomb = [{coefficient}, {across}], direction = [1, 0.3, 0] }}");
            (law, f64::min(coefficient, across))
        }
    }
}

/// The case of a seed: lengths in mm.
pub fn text(seed: u64) -> String {
    let d = &mut Draw::seeded(seed);
    let element = d.one(&["tet4", "hex8", "tet10", "hex20", "tet4", "hex8"]);
    let quadratic = element == "tet10" || element == "hex20";
    let size = [0; 3].map(|_| d.one(&[10.0, 30.0, 100.0]));
    let cells = d.cells(if quadratic { 4 } else { 7 });
    let (young, poisson) = (10f64.powf(d.between(0.0, 6.0)), d.one(&[0.0, 0.2, 0.3, 0.45]));
    let travel = size.into_iter().fold(f64::INFINITY, f64::min) * 10f64.powf(d.between(-5.0, -2.0));
    let (friction, holds) = law(d, young);
    let block = |size: [f64; 3], cells: [usize; 3], element: &str| {
        format!("block = {{ size = {size:?}, cells = {cells:?}, element = \"{element}\" }}\n")
    };
    let two = d.unit() < 0.5;
    let (mut case, against);
    if two {
        let below = [size[0] * d.one(&[1.0, 1.5]), size[1] * d.one(&[1.0, 1.3]), size[2] * d.one(&[0.5, 1.0])];
        let other = if quadratic { element } else { d.one(&["tet4", "hex8"]) };
        case = format!("[mesh.parts.a]\n{}[mesh.parts.b]\n", block(size, cells, element));
        case += &block(below, d.cells(if quadratic { 3 } else { 6 }), other);
        case += &format!("move = [0, 0, {}]\n", -below[2] - d.one(&[0.0, 0.1 * travel]));
        case += &format!("[materials.m]\nyoung = {young}\npoisson = {poisson}\non = \"a\"\n");
        let young = young * 10f64.powf(d.between(-2.0, 2.0));
        case += &format!("[materials.k]\nyoung = {young}\npoisson = 0.3\non = \"b\"\n");
        case += "[[fix]]\non = \"b.z-min\"\nvalue = [0, 0, 0]\n";
        against = "\"b.z-max\"".to_owned();
    } else {
        case = format!("[mesh]\n{}", block(size, cells, element));
        case += &format!("[materials.m]\nyoung = {young}\npoisson = {poisson}\n");
        let radius = d.one(&[5.0, 50.0]) * size.into_iter().fold(0.0, f64::max);
        let (x, y) = (0.5 * size[0], 0.5 * size[1]);
        against = match d.one(&[0, 1, 2]) {
            0 => "{ plane = { point = [0, 0, 0], normal = [0, 0, 1] } }".to_owned(),
            1 => "{ plane = { point = [0, 0, 0], normal = [0.05, 0.02, 1] } }".to_owned(),
            _ => format!("{{ sphere = {{ center = [{x}, {y}, {}], radius = {radius} }} }}", -radius),
        };
    }
    let body = if two { "a." } else { "" };
    let pressure = 1e-4 * young;
    match d.unit() {
        x if x < 0.35 => {
            let value = [d.between(-1.0, 1.0) * travel, d.between(-1.0, 1.0) * travel, -d.between(0.1, 1.0) * travel];
            case += &format!("[[fix]]\non = \"{body}z-max\"\nvalue = {value:?}\n");
        }
        x if x < 0.6 => {
            let traction = [0; 3].map(|_| 0.5 * pressure * d.between(-1.0, 1.0));
            case += &format!("[[fix]]\non = \"{body}x-min\"\nvalue = [0, 0, 0]\n");
            case += &format!("[[load]]\non = \"{body}z-max\"\npressure = {pressure}\n");
            case += &format!("[[load]]\non = \"{body}x-max\"\ntraction = {traction:?}\n");
        }
        _ => {
            // Neither slides nor tips on a level plane.
            let along = pressure * f64::min(holds * d.between(0.0, 0.5), 0.3 * size[0] / size[2]);
            case += &format!("[[load]]\non = \"{body}z-max\"\npressure = {pressure}\n");
            case += &format!("[[load]]\non = \"{body}z-max\"\ntraction = [{along}, 0, 0]\n");
        }
    }
    case + &format!("[[contact]]\non = \"{body}z-min\"\nagainst = {against}\nfriction = {friction}\n")
}

/// The Newton steps or cycles it took to be certified, or why it is not.
///
/// # Errors
/// Why it is not certified.
pub fn outcome(text: &str) -> Result<usize, String> {
    solved(text, &mut |_, _, _| ())
}

/// The cycles it took on so many ranks, which are threads, to be certified, and whether rank 0 alone has found it; or why it is
/// not.
///
/// # Errors
/// Why it is not certified.
///
/// # Panics
/// If the case cannot be read.
pub fn outcome_on_ranks(text: &str, size: usize) -> Result<(usize, bool), String> {
    let case = case::parse(text, "case.toml", &[]).unwrap_or_else(|e| panic!("{e}\n{text}"));
    let answers = threads(size, |ranks| {
        let answer = solve_on_ranks(&case, &ranks, &mut |_| ControlFlow::Continue(()));
        answer.map(|answer| answer.summary).map_err(|e| e.to_string())
    });
    let summary = answers.into_iter().next().ok_or("no ranks")??;
    match summary.answer.status {
        Status::Solved => Ok((summary.answer.counts.steps(), summary.found_by_first())),
        status => Err(format!("{status:?}, worst {:.1e}", summary.answer.certificate.worst)),
    }
}

/// Whether a case that is not certified is one that ranks refuse.
pub fn ranks_refuse(reason: &str) -> bool {
    ["divided among ranks", "use fewer ranks", "aggregation", "no contact resists"]
        .iter()
        .any(|part| reason.contains(part))
}

/// As [`outcome`], with what `each` makes of each answer: the time of its load step (1 without load steps), its problem and
/// itself. A case whose surfaces come from beyond `search` begins again with its first step, as by the command.
///
/// # Errors
/// Why it is not certified.
pub fn solved(text: &str, each: &mut dyn FnMut(f64, &Prepared, &Outcome)) -> Result<usize, String> {
    solved_case(case::parse(text, "case.toml", &[]).unwrap_or_else(|e| panic!("{e}\n{text}")), each)
}

/// The same of a case that was read.
///
/// # Errors
/// Why it is not certified.
pub fn solved_case(mut case: Case, each: &mut dyn FnMut(f64, &Prepared, &Outcome)) -> Result<usize, String> {
    loop {
        let mut prepared = prepare(&case).map_err(|e| e.to_string())?;
        let settings = Settings::of(&case.solver);
        let go_on = &mut |_: &Event| ControlFlow::Continue(());
        let outcome = if case.steps.is_empty() {
            let outcome = solve(&prepared, &settings, go_on);
            outcome.inspect(|outcome| each(1.0, &prepared, outcome))
        } else {
            let mut keep = |prepared: &Prepared, step: &stiction::run::Step| {
                each(step.file.t, prepared, step.outcome);
                Ok(())
            };
            solve_steps(&mut prepared, &settings, None, &mut keep, go_on)
        };
        let outcome = outcome.map_err(|e| e.to_string())?;
        if let Some(wider) = widened(&case, &prepared, &outcome) {
            case = wider;
            continue;
        }
        let Outcome { solution, steps, .. } = &outcome;
        if solution.status == Status::Solved {
            assert!(solution.certificate.passed, "{case:?}");
            let of_steps = steps.iter().map(|step| step.answer.counts.steps()).sum();
            return Ok(if steps.is_empty() { solution.counts.newton_steps + solution.counts.cycles } else { of_steps });
        }
        let certificate = &solution.certificate;
        let mut worst = certificate.measures();
        worst.extend(certificate.worst_part().map(|part| ("by its own forces", part.residual)));
        worst.retain(|(_, value)| *value > certificate.tolerance);
        worst.sort_by(|a, b| b.1.total_cmp(&a.1));
        let worst: Vec<String> = worst.iter().map(|(name, value)| format!("{name} {value:.1e}")).collect();
        let pulled = if outcome.sliding.is_some() { ", pulled beyond friction" } else { "" };
        let step = if steps.is_empty() { String::new() } else { format!(" in step {}", steps.len()) };
        return Err(format!("{:?}{step}{pulled}: {}", solution.status, worst.join(", ")));
    }
}

/// A motion that nothing resists, or for which no equilibrium exists.
pub fn leaves(reason: &str) -> bool {
    reason.contains("resists a motion") || reason.starts_with("NoEquilibrium")
}
