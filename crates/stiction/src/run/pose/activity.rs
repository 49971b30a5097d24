//! Contact points that take part in some load steps only: supports and contacts that begin or end with a step, and contacts
//! that are bonded at first.
//!
//! A point that is out has no friction and a gap that nothing closes, which every solver and the certificate know already.
//! Its rows of `B` stay, so that one factor or one hierarchy serves all steps.

use crate::contact::Friction;

/// Time after which something takes part, and until which.
pub(crate) type Period = [f64; 2];

/// From beginning to end.
pub(crate) const ALWAYS: Period = [f64::NEG_INFINITY, f64::INFINITY];

/// The gap of what is out over the size of the mesh: displacements are small beside the mesh.
const WIDE: f64 = 1e3;

/// The points that are not always in.
#[derive(Debug, Clone, Default)]
pub struct Activity {
    /// Each with its periods.
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

    /// Whether a point is out at time `t`.
    pub(crate) fn is_out(&self, point: usize, t: f64) -> bool {
        self.out(t).any(|(out, _)| out == point)
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
}
