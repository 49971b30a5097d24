//! The load steps of a result folder, judged anew.

use super::check::{Stored, compare};
use crate::Error;
use crate::certificate::{Certificate, certify};
use crate::contact::ContactProblem;
use crate::io::step::StepFile;
use crate::linalg::max_abs;
use crate::run::pose::load_state::{Initial, LoadState, slid_over};
use crate::run::solve::StepRecord;
use crate::run::solve::balance::{Balance, BodyState, Counted, balance};

/// What the files of one step amount to.
#[derive(Debug, Clone, PartialEq)]
pub struct CheckedStep {
    /// From 1.
    pub number: usize,
    /// Time at its end.
    pub t: f64,
    /// The certificate made anew.
    pub certificate: Certificate,
    /// Where the summary or another step says something else: name, what it says, what was recomputed.
    pub differences: Vec<(String, f64, f64)>,
}

/// Lengths of two steps that should be one agree to this part of the largest displacement, forces to this part of the
/// largest.
const SAME: f64 = 1e-9;
/// Energies agree to this part of the largest.
const SAME_ENERGY: f64 = 1e-6;

/// Judges every step that the summary lists, whose files `read` reads by their numbers from 1. `problem` is that of the last one and
/// becomes that of each in turn.
///
/// Besides the certificate of each step: its slip is measured from where the step before it ended, its gaps differ
/// from the others by what has moved, its loads and its energies are what the summary and the others say.
///
/// # Errors
/// If a file is missing, damaged, or does not fit the others.
pub(crate) fn check_steps(
    records: &[StepRecord],
    read: &dyn Fn(usize) -> Result<StepFile, Error>,
    problem: &mut ContactProblem,
    tolerance: f64,
) -> Result<Vec<CheckedStep>, Error> {
    let (n, m) = (problem.unknowns(), problem.points());
    let p = problem.labels.supports.as_ref().map_or(0, |s| s.load.len());
    let vectors = |problem: &ContactProblem| {
        let contact = &problem.contact;
        (problem.elastic.f.clone(), contact.gap.clone(), contact.slip_reference.clone(), contact.friction.clone())
    };
    let as_it_was = vectors(problem);
    let nothing = LoadState::start(n, p, m);
    let mut body = BodyState { loads: nothing, u: vec![0.0; n], lambda: vec![0.0; 3 * m], balance: Balance::default() };
    let mut slid = vec![0.0; 2 * m];
    let mut strength: Option<Vec<f64>> = None;
    let mut first: Option<Vec<f64>> = None;
    let mut checked = Vec::new();
    for (number, record) in (1..).zip(records) {
        let file = read(number)?;
        file.put_into(problem);
        problem.validate().map_err(|e| e.at(&format!("step {number}")))?;
        let certificate = certify(problem, &file.u, &file.lambda, tolerance);
        let normal_force = file.lambda.iter().zip(&problem.labels.unity_sum).map(|(force, share)| share * force).sum();
        let mut differences = compare(&Stored::of(&record.answer), &certificate, normal_force)
            .map_err(|e| e.at(&format!("step {number}")))?;
        let mut differ = |name: &str, old: f64, new: f64, allowed: f64| {
            // Written so that NaN differs.
            let same = (old - new).abs() <= allowed;
            if !same {
                differences.push((name.to_string(), old, new));
            }
        };
        let loads = loads_of(&file);
        let size = max_abs(&file.u).max(max_abs(&loads.displacement)).max(max_abs(&loads.motion));
        let held = problem.labels.supports.as_ref().map_or(vec![0.0; 3 * m], |s| s.B.times(&loads.displacement));
        // Gap and slip reference without what has moved or slid since the start: the same in every step, but for the gaps
        // of points that are out.
        let place = |i: usize| if i < m { file.gap[i] } else { file.slip_reference[i - m] - slid[i - m] };
        let mut rest: Vec<f64> = (0..3 * m).map(|i| place(i) + held[i] - loads.motion[i]).collect();
        let first = first.get_or_insert_with(|| {
            let mut first = rest.clone();
            file.out.iter().for_each(|&j| first[j] = f64::NAN);
            first
        });
        file.out.iter().for_each(|&j| rest[j] = first[j]);
        first.iter_mut().zip(&rest).filter(|(first, _)| first.is_nan()).for_each(|(first, rest)| *first = *rest);
        let apart = |range: std::ops::Range<usize>| range.map(|i| (rest[i] - first[i]).abs()).fold(0.0, f64::max);
        differ("gap", 0.0, apart(0..m), SAME * size.max(max_abs(&first[..m])));
        differ("slip_reference", 0.0, apart(m..3 * m), SAME * size.max(max_abs(&slid)));
        if let Some(before) = &strength {
            // What a point has lost stays lost, and nothing is lost in parts.
            let gained = |(new, old): (&f64, &f64)| if *new == 0.0 { 0.0 } else { (new - old).abs() };
            differ("strength", 0.0, file.strength.iter().zip(before).map(gained).fold(0.0, f64::max), 0.0);
        }
        strength = Some(file.strength.clone());
        let demanded =
            problem.labels.supports.as_ref().map_or(vec![0.0; n], |s| s.K.transpose_times(&loads.displacement));
        let off = (0..n).map(|i| (loads.load[i] - demanded[i] - file.f[i]).abs()).fold(0.0, f64::max);
        differ("load", 0.0, off, SAME * max_abs(&loads.load).max(max_abs(&demanded)));

        let new = balance(problem, &body, &loads, &file.u, &file.lambda, &Counted::ALL);
        let scale = new.work.abs().max(new.elastic).max(new.dissipation.abs());
        let stored = &record.balance;
        differ("work", stored.work, new.work, SAME_ENERGY * scale);
        differ("elastic", stored.elastic, new.elastic, SAME_ENERGY * scale);
        differ("dissipation", stored.dissipation, new.dissipation, SAME_ENERGY * scale);
        differ("t", record.t, file.t, 0.0);
        if number == records.len() {
            let same = vectors(problem) == as_it_was;
            differ("problem.npz is that of the last step", 1.0, f64::from(u8::from(same)), 0.0);
        }
        slid = slid_over(problem, &loads, first, &file.u);
        body = BodyState { loads, u: file.u.clone(), lambda: file.lambda.clone(), balance: new };
        checked.push(CheckedStep { number, t: file.t, certificate, differences });
    }
    Ok(checked)
}

fn loads_of(file: &StepFile) -> LoadState {
    LoadState {
        t: file.t,
        load: file.support_free_load.clone(),
        support_load: file.support_load.clone(),
        displacement: file.support_displacement.clone(),
        motion: file.motion.clone(),
        initial: Initial {
            load: file.initial_load.iter().take(file.u.len()).copied().collect(),
            support_load: file.initial_load.iter().skip(file.u.len()).copied().collect(),
            energy: file.initial_energy,
            shortening: file.shortening.clone(),
            ..Initial::default()
        },
        // `put_into` has set them.
        friction: None,
        out: file.out.iter().map(|&point| (point, 0.0)).collect(),
        // The files hold what is left without it.
        travel: [0.0; 3],
    }
}
