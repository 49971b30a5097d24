//! Contact points that take part in some load steps only: supports and contacts that begin or end with a step, and contacts
//! that are bonded at first.
//!
//! A point that is out has no friction and a gap that nothing closes, which every solver and the certificate know already; statics
//! leaves it out (`Contact::out`), or a body without another hold would be caught there. Its rows of `B` stay, so that one
//! factor or one hierarchy serves all steps.

use std::collections::BTreeMap;
use std::ops::Range;

pub(crate) use crate::contact::{ALWAYS, Period};
use crate::contact::{Friction, SurfaceFriction};
use crate::io::case::{ContactSpec, StepSpec};

/// The gap of what is out over the size of the mesh: displacements are small beside the mesh.
const WIDE: f64 = 1e3;

/// The points that are not always in.
#[derive(Debug, Clone, Default)]
pub struct Activity {
    /// Each with its periods, ascending.
    points: Vec<(usize, Vec<Period>)>,
    /// The gap of a point that is out, length.
    wide: f64,
    /// Points that are bonded until a time, whatever their law.
    bonded: Vec<(usize, f64)>,
}

/// Whether `t` lies in the period. The time at the end of a step is that of the case to the last digit.
pub(crate) fn within([begin, end]: Period, t: f64) -> bool {
    begin < t && t <= end
}

impl Activity {
    /// For a mesh of this diagonal, length.
    pub(crate) fn new(diagonal: f64) -> Self {
        Activity { points: Vec::new(), wide: WIDE * diagonal, bonded: Vec::new() }
    }

    /// Lets a point take part in these periods.
    pub(crate) fn add(&mut self, point: usize, periods: Vec<Period>) {
        if periods != [ALWAYS] {
            self.points.push((point, periods));
        }
    }

    /// Takes points out, each during a period.
    pub(crate) fn take_out(&mut self, list: Vec<(usize, Period)>) {
        let mut all: BTreeMap<usize, Vec<Period>> = std::mem::take(&mut self.points).into_iter().collect();
        for (point, out) in list {
            let periods = all.entry(point).or_insert_with(|| vec![ALWAYS]);
            *periods = left(periods, out);
        }
        self.points = all.into_iter().collect();
    }

    /// Bonds a point until `end`.
    pub(crate) fn bond(&mut self, point: usize, end: f64) {
        self.bonded.push((point, end));
    }

    /// The points that are bonded at time `t` and not later.
    pub(crate) fn bonded(&self, t: f64) -> impl Iterator<Item = usize> {
        self.bonded.iter().filter(move |(_, end)| t <= *end).map(|(point, _)| *point)
    }

    /// Whether all points are always in, and none is bonded for a time.
    pub(crate) fn is_constant(&self) -> bool {
        self.points.is_empty() && self.bonded.is_empty()
    }

    /// The points that are out at time `t`, with the gap each gets more, length.
    pub(crate) fn out(&self, t: f64) -> impl Iterator<Item = (usize, f64)> {
        let out = move |(_, periods): &&(usize, Vec<Period>)| !periods.iter().any(|&period| within(period, t));
        self.points.iter().filter(out).map(|(point, _)| (*point, self.wide))
    }

    /// The laws at time `t`, of which `changed` has those that change otherwise and `posed` all as they are; nothing where
    /// none changes.
    pub(crate) fn laws(&self, changed: Option<Vec<Friction>>, posed: &[Friction], t: f64) -> Option<Vec<Friction>> {
        if self.is_constant() {
            return changed;
        }
        let mut laws = changed.unwrap_or_else(|| posed.to_vec());
        self.bonded(t).for_each(|point| laws[point] = Friction::Bonded);
        self.out(t).for_each(|(point, _)| laws[point] = Friction::None);
        Some(laws)
    }

    /// Adds to `motion` what points keep of their gaps at time `t`: bonded surfaces the gap they were meshed with, and those of
    /// `put_in` the gap that each had when it began; length.
    pub(crate) fn keep_gaps(
        &self,
        (put_in, stood): (&[(usize, Period)], &[f64]),
        undeformed: &[f64],
        motion: &mut [f64],
        t: f64,
    ) {
        self.bonded(t).for_each(|j| motion[j] -= undeformed[j]);
        let now = put_in.iter().zip(stood).filter(|((_, period), _)| within(*period, t));
        now.for_each(|((j, _), kept)| motion[*j] += kept);
    }
}

/// What is left of periods without one.
fn left(periods: &[Period], [from, until]: Period) -> Vec<Period> {
    let of = |&[begin, end]: &Period| [[begin, end.min(from)], [begin.max(until), end]];
    periods.iter().flat_map(of).filter(|[begin, end]| begin < end).collect()
}

/// Notes the gap, beside what has moved, that each point of `put_in` has at time `t` if it begins then or later.
pub(crate) fn note_gaps(
    (put_in, stood): (&[(usize, Period)], &mut [f64]),
    jump: &[f64],
    motion: &[f64],
    undeformed: &[f64],
    t: f64,
) {
    for (&(j, [begin, _]), kept) in put_in.iter().zip(stood) {
        if t <= begin {
            *kept = jump[j] - motion[j] - undeformed[j].max(0.0);
        }
    }
}

/// When the points of contacts take part in the steps of a case, on a mesh of this diagonal, length; and the bonded ones among them
/// that are put in with a step, with each period. Each contact has its points and those of them, by their places there, that are
/// out for a time.
pub(crate) fn timed_contacts<'c>(
    steps: &[StepSpec],
    diagonal: f64,
    contacts: impl Iterator<Item = (&'c ContactSpec, Range<usize>, &'c [(usize, Period)])>,
) -> (Activity, Vec<(usize, Period)>) {
    let (mut activity, mut put_in) = (Activity::new(diagonal), Vec::new());
    for (contact, points, out) in contacts {
        let mut periods = vec![contact.periods(steps); points.len()];
        for &(place, time) in out {
            periods[place] = left(&periods[place], time);
        }
        if contact.friction == SurfaceFriction::Bonded {
            let later = |(j, periods): (usize, &Vec<Period>)| {
                let later: Vec<Period> = periods.iter().copied().filter(|period| period[0].is_finite()).collect();
                later.into_iter().map(move |period| (j, period))
            };
            put_in.extend(points.clone().zip(&periods).flat_map(later));
        }
        points.clone().zip(periods).for_each(|(j, periods)| activity.add(j, periods));
        if let Some(step) = contact.bonded_until.and_then(|step| steps.get(step)) {
            points.for_each(|j| activity.bond(j, step.until));
        }
    }
    (activity, put_in)
}
