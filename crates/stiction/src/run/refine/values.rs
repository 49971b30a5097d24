//! What engineers read from an answer, and how far it may be off, from a sequence of meshes.

use serde::{Deserialize, Serialize};

use crate::contact::Friction;
use crate::mesh::Mesh;
use crate::mesh::v3::{norm, sub};
use crate::run::pose::Prepared;
use crate::run::solve::{AnswerRecord, Named, Outcome, Totals, ValueRecord};

/// On the safe side of what the sequence says: of 390 bars on bricks, Hertz's contact, a punch and two bodies 373 held with 1.75,
/// half of which were over 8.2 times the error; with 2 they were 376 and 9.4 times (note on the estimate, 2026-11-24).
const SAFETY: f64 = 1.75;
/// No bar is smaller than this part of its value: the solver leaves about as much.
const LEAST: f64 = 1e-6;
/// Meshes before the last that are asked.
const BEFORE: usize = 3;
/// A mesh says something of another one whose estimate is smaller by this factor.
const APART: f64 = 1.05;
/// Meshes before which no figure means much: contact may not be resolved at all.
pub(super) const LEAST_LEVELS: usize = 3;
/// An estimate so small is none: the solution lies in the space of the elements, and values have no error either.
pub(super) const EXACT: f64 = 1e-6;
/// A peak that grows at least as this power of the size of the cells where it is has no limit.
const SINGULAR: f64 = 0.15;
/// How often the cells there must have been halved to say so.
const HALVED: f64 = 2.0;

/// What a value is, for the goals.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(super) enum Sort {
    Force,
    Displacement,
    Pressure,
    Other,
}

/// A number of one mesh.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct Value {
    pub name: String,
    pub sort: Sort,
    pub value: f64,
    /// Where a peak is, and the size of the cells there.
    pub peak: Option<([f64; 3], f64)>,
}

/// All of them, in the same order on each mesh.
pub(super) fn values(prepared: &Prepared, outcome: &Outcome) -> Vec<Value> {
    let answer = AnswerRecord::of(prepared, outcome);
    let plain = |name: String, sort: Sort, value: f64| Value { name, sort, value, peak: None };
    let mut all = Vec::new();
    for pair in &answer.pairs {
        let Totals { normal_force, tangential_force, stick_area, slip_area, max_pressure, max_pressure_at, .. } =
            pair.totals;
        let of = |what: &str| if answer.pairs.len() > 1 { format!("{what} of \"{}\"", pair.name) } else { what.into() };
        let area = stick_area + slip_area;
        all.push(plain(of("normal force"), Sort::Force, normal_force));
        if prepared.problem.contact.friction.iter().any(|law| *law != Friction::None) {
            all.push(plain(of("friction force"), Sort::Force, norm(tangential_force)));
        }
        all.push(plain(of("contact area"), Sort::Other, area));
        all.push(plain(of("mean pressure"), Sort::Other, if area > 0.0 { normal_force / area } else { 0.0 }));
        let peak = max_pressure_at.and_then(|at| Some((at, cell_size(&prepared.mesh, at)?)));
        all.push(Value { peak, ..plain(of("largest pressure"), Sort::Pressure, max_pressure) });
    }
    for bolt in &answer.bolts {
        all.push(plain(format!("force of bolt \"{}\"", bolt.name), Sort::Force, bolt.force));
    }
    all.push(plain("largest displacement".into(), Sort::Displacement, answer.displacement_max));
    all.push(plain("energy".into(), Sort::Other, answer.energy));
    all
}

/// By name, for the record of a level.
pub(super) fn named(values: &[Value]) -> Named {
    Named(values.iter().map(|value| (value.name.clone(), value.value)).collect())
}

/// The size of the smallest cell that has a node at `place`, length.
fn cell_size(mesh: &Mesh, place: [f64; 3]) -> Option<f64> {
    let at_place = |node: &u32| mesh.nodes[*node as usize] == place;
    let cells = mesh.cells.iter().flat_map(|block| (0..block.len()).map(|i| block.cell(i))).enumerate();
    let near = cells.filter(|(_, nodes)| nodes.iter().any(at_place));
    near.map(|(cell, _)| mesh.cell_volume(cell).cbrt()).reduce(f64::min)
}

/// Half the width of the error bar of the last of `values`, one for each mesh, by the estimates `error` of these meshes:
/// values converge at least as fast as the energy norm, and that none does so faster is the cautious assumption.
/// `None` with fewer than three meshes, or without one that says something; zero where the answer is exact.
pub(super) fn bar(values: &[f64], error: &[f64]) -> Option<f64> {
    let last = values.len().checked_sub(1)?;
    if error[last] <= EXACT {
        return Some(0.0);
    }
    if values.len() < LEAST_LEVELS {
        return None;
    }
    let says = |&j: &usize| error[j] > APART * error[last];
    let from = |j: usize| (values[j] - values[last]).abs() * error[last] / (error[j] - error[last]);
    let largest = (last.saturating_sub(BEFORE)..last).filter(says).map(from).reduce(f64::max)?;
    Some((SAFETY * largest).max(LEAST * values[last].abs()))
}

/// Whether a peak grows without bound: the cells at its place were halved twice and more, and it rises with a power of their
/// size at every mesh.
pub(super) fn is_unbounded(peaks: &[&Value]) -> bool {
    let known = |value: &&Value| value.peak.map(|(at, size)| (at, size, value.value));
    let Some(all) = peaks.iter().map(known).collect::<Option<Vec<_>>>() else { return false };
    let Some((&(at, size, value), before)) = all.split_last() else { return false };
    // The meshes on which the peak stood at this place already.
    let stood = before.iter().rev().take_while(|(place, coarse, _)| norm(sub(*place, at)) <= 2.0 * coarse);
    let Some(&(_, coarse, first)) = stood.last() else { return false };
    let (halvings, growth) = ((coarse / size).log2(), (value / first).log2());
    halvings >= HALVED && growth >= SINGULAR * halvings
}

/// The values of the last mesh with their bars.
pub(super) fn records(levels: &[Vec<Value>], error: &[f64]) -> Vec<ValueRecord> {
    let Some(last) = levels.last() else { return Vec::new() };
    let record = |(i, value): (usize, &Value)| {
        let of_levels: Vec<&Value> = levels.iter().map(|level| &level[i]).collect();
        if is_unbounded(&of_levels) {
            return ValueRecord { name: value.name.clone(), value: None, bar: None };
        }
        let numbers: Vec<f64> = of_levels.iter().map(|value| value.value).collect();
        ValueRecord { name: value.name.clone(), value: Some(value.value), bar: bar(&numbers, error) }
    };
    last.iter().enumerate().map(record).collect()
}

/// The largest bar of the values of a sort over the largest of these values; `None` where one has no bar yet. Values without a limit
/// are no goal.
pub(super) fn worst_bar(levels: &[Vec<Value>], error: &[f64], sort: Sort) -> Option<f64> {
    let of_sort = levels.last()?.iter().zip(records(levels, error)).filter(|(value, _)| value.sort == sort);
    let bounded: Vec<(f64, Option<f64>)> =
        of_sort.filter_map(|(_, record)| Some((record.value?, record.bar))).collect();
    let scale = bounded.iter().map(|(value, _)| value.abs()).fold(0.0, f64::max);
    let bars = bounded.iter().map(|(_, bar)| *bar).collect::<Option<Vec<f64>>>()?;
    let worst = bars.into_iter().fold(0.0, f64::max);
    Some(if worst == 0.0 { 0.0 } else { worst / scale })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_bar_of_a_value_that_follows_the_error_is_its_error_with_some_to_spare() {
        let error = [0.1, 0.05, 0.02, 0.01];
        let values = error.map(|e| 3.0 + 2.0 * e);
        let found = bar(&values, &error).unwrap_or(0.0);
        assert!((found - SAFETY * 0.02).abs() < 1e-12, "{found}");
        // One that converges faster is closer than its bar, and one that does not change has none to speak of.
        let faster = error.map(|e| 3.0 + 2.0 * e * e);
        assert!(bar(&faster, &error).is_some_and(|bar| bar > 2.0 * 1e-4 && bar < 0.02));
        assert_eq!(bar(&[5.0; 4], &error), Some(5.0 * LEAST));
    }

    #[test]
    fn a_bar_takes_three_meshes_and_errors_that_fall() {
        assert_eq!(bar(&[1.0, 2.0], &[0.2, 0.1]), None);
        assert_eq!(bar(&[1.0, 2.0, 3.0], &[0.1, 0.1, 0.1]), None);
        assert_eq!(bar(&[], &[]), None);
        // The solution lies in the space of the elements: no mesh has more to say.
        assert_eq!(bar(&[4.0], &[1e-12]), Some(0.0));
    }

    fn peak(value: f64, at: [f64; 3], size: f64) -> Value {
        Value { name: "largest pressure".into(), sort: Sort::Pressure, value, peak: Some((at, size)) }
    }

    #[test]
    fn a_peak_that_follows_the_size_of_its_cells_is_without_bound_and_one_that_settles_is_not() {
        let singular: Vec<Value> = [1.0, 0.5, 0.25, 0.125].map(|h: f64| peak(h.powf(-0.5), [1.0; 3], h)).to_vec();
        assert!(is_unbounded(&singular.iter().collect::<Vec<_>>()));
        let smooth: Vec<Value> = [1.0, 0.5, 0.25, 0.125].map(|h: f64| peak(2.0 - h * h, [1.0; 3], h)).to_vec();
        assert!(!is_unbounded(&smooth[1..].iter().collect::<Vec<_>>()));
        // Two meshes are not enough, and neither is a peak that has only just come to this place.
        assert!(!is_unbounded(&singular[2..].iter().collect::<Vec<_>>()));
        let mut wandering = singular.clone();
        wandering[2].peak = Some(([9.0; 3], 0.25));
        assert!(!is_unbounded(&wandering.iter().collect::<Vec<_>>()));
        assert!(!is_unbounded(&[]));
    }
}
