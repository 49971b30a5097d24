//! What engineers read from an answer, and how far it may be off, from a sequence of meshes.

use serde::{Deserialize, Serialize};

use super::shape::open;
use super::sharp_edges::largest_at_sharp_edge;
use crate::contact::{Friction, Pair, SurfaceFacts};
use crate::fem::full_displacement;
use crate::friction::PointState;
use crate::io::text::number;
use crate::mesh::Mesh;
use crate::mesh::v3::{V3, mean, norm, sub};
use crate::run::pose::Prepared;
use crate::run::pose::frames::frames;
use crate::run::solve::quantities::largest_displacement;
use crate::run::solve::tractions::tractions;
use crate::run::solve::{
    AnswerRecord, LARGEST_PRESSURE, Named, Outcome, Totals, ValueRecord, edges, or_infinite, pair_totals,
};

/// On the safe side of what the sequence says: of 478 bars on bricks, Hertz's contact, a punch, two bodies and a bolted joint 465 hold,
/// half of which are over 9.0 times the error (`bench/error_bars.py`, 2026-11-28). On 390 of them a factor of 2
/// held 376 where 1.75 held 373, and widened that half to 9.4 times (note on error bars, 2026-11-25).
const SAFETY: f64 = 1.75;
/// No bar is smaller than this part of its value: the solver leaves about as much.
const LEAST: f64 = 1e-6;
/// The energy is off by the square of the error in its norm, as a part of it, and so are displacements that loads bring about. Contact that
/// covers all of a surface on coarse meshes may open on finer ones, by up to 0.43 of the square times the area.
const OF_SQUARE: f64 = 0.5;
/// The same of a largest displacement that is prescribed, and may be exceeded on finer meshes: by 0.13 to 0.4 of the square in eight of 60 cases of
/// two blocks, by 1.8 beside the edge of a face that is moved as a whole.
const OF_PRESCRIBED: f64 = 2.0;
/// The same of the energy itself: of shrink fits it is off by 1.03 times the square.
const OF_ENERGY: f64 = 1.5;
/// Of the area that the edge of contact leaves open half is in contact at the least error. Of friction all that is left open counts: of a fit that
/// slides from its ends, with two cells along it, three quarters of it are missing.
const OF_EDGE: f64 = 0.5;
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
/// Ratios of sizes of cells that are halved, and twice halved, rounding left aside.
const HALVED: f64 = 1.99;
const TWICE_HALVED: f64 = 3.98;
/// Contact with more of its area at its edge, where cells have open and closed points, is too narrow for the cells: fewer than four rows of points
/// lie across it, and its peak follows their size without being singular.
const NARROW: f64 = 0.5;
/// Where no pressure in contact is a smaller part of the mean, as in a fit or under a uniform load, finer points would hardly open.
const EVEN: f64 = 0.75;
/// A mesh says something of a peak of another one whose cells there are smaller by this factor; two bisections give 1.59.
const FINER: f64 = 1.2;

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
    /// No bar is smaller: what this mesh cannot tell of the value, whatever other meshes give.
    pub least: f64,
    /// The size of the cells where a peak is, length.
    pub peak: Option<f64>,
    /// Of an area whose pressure falls off, and its mean pressure, how many contact points there are: a mesh with as many says nothing of
    /// them.
    #[serde(default)]
    pub points: Option<usize>,
    /// No bar is a smaller part of the value than this part of the square of the estimate.
    #[serde(default)]
    pub of_square: f64,
    /// Of a peak the largest pressure at a sharp edge and the size of the cells there, if contact reaches one.
    #[serde(default)]
    pub at_edge: Option<(f64, f64)>,
    /// Whether contact is too narrow for these cells to tell of its peak.
    #[serde(default)]
    pub narrow: bool,
    /// No bar is smaller: what the shape of the first mesh leaves open; none is known where that is infinite.
    #[serde(default, deserialize_with = "or_infinite")]
    pub by_shape: f64,
    /// When it is that, where it is not at the end: at the end of an earlier load step.
    #[serde(default)]
    pub t: Option<f64>,
}

/// All of them, in the same order on each mesh, whose estimated error is `error`; `shapes` are those of the first mesh.
pub(super) fn values(prepared: &Prepared, outcome: &Outcome, error: f64, shapes: &[f64]) -> Vec<Value> {
    let answer = AnswerRecord::of(prepared, outcome);
    let plain = |name: String, sort: Sort, value: f64| Value {
        name,
        sort,
        value,
        least: LEAST * value.abs(),
        peak: None,
        points: None,
        of_square: 0.0,
        at_edge: None,
        narrow: false,
        by_shape: 0.0,
        t: None,
    };
    let mut all = Vec::new();
    let flattened: Vec<f64> = prepared.facts.contacts.iter().map(|contact| flattened(&contact.surface)).collect();
    let pairs = answer.pairs.iter().zip(&prepared.problem.labels.pairs);
    let frames = frames(prepared);
    let tractions = tractions(prepared, outcome, &frames);
    let open = open(prepared, outcome, shapes);
    let pairs = pairs.zip(edges(prepared, outcome)).zip(&flattened).zip(&open);
    for (number, ((((pair, label), edge), flattened), open)) in pairs.enumerate() {
        let Totals { normal_force, tangential_force, stick_area, slip_area, max_pressure, max_pressure_at, .. } =
            pair.totals;
        let of = |what: &str| if answer.pairs.len() > 1 { format!("{what} of \"{}\"", pair.name) } else { what.into() };
        let area = stick_area + slip_area;
        let by_curves = |value: f64| value.abs() * (SAFETY * flattened).max(LEAST);
        let by_shape = open.force * normal_force.abs();
        let normal = plain(of("normal force"), Sort::Force, normal_force);
        let normal = Value { least: by_curves(normal_force), by_shape, ..normal };
        all.push(normal);
        if prepared.problem.contact.friction.iter().any(|law| *law != Friction::None) {
            let friction = plain(of("friction force"), Sort::Force, norm(tangential_force));
            all.push(Value { least: friction.least.max(edge.friction), ..friction });
        }
        let mean = if area > 0.0 { normal_force / area } else { 0.0 };
        let closed = || label.points.clone().filter(|&j| outcome.solution.states[j] != PointState::Open);
        let pressure = |j: usize| tractions.points[j][0];
        let least = closed().min_by(|&a, &b| pressure(a).total_cmp(&pressure(b)));
        let uneven = least.filter(|&j| pressure(j) < EVEN * mean);
        // What hardly presses may be open: stresses are not known better than the estimate.
        let light = closed().filter(|&j| uneven == Some(j) || (0.0..error * max_pressure).contains(&pressure(j)));
        let unsure = (OF_EDGE * edge.area).max(light.map(|j| prepared.problem.labels.area[j]).sum());
        let by_edge = |value: f64| if area > 0.0 { value.abs() * (unsure / area).max(LEAST) } else { 0.0 };
        let points = uneven.map(|_| label.points.len());
        for (what, value) in [("contact area", area), ("mean pressure", mean)] {
            let (least, by_shape) = (by_edge(value).max(by_curves(value)), open.area * value.abs());
            all.push(Value { least, points, of_square: OF_SQUARE, by_shape, ..plain(of(what), Sort::Other, value) });
        }
        let peak = max_pressure_at.and_then(|at| cell_size(&prepared.mesh, at));
        let narrow = edge.area > NARROW * area;
        let by_shape = open.area * max_pressure.abs();
        let sharp = largest_at_sharp_edge(prepared, outcome, (number, label), &frames, &tractions);
        let at_edge = sharp.and_then(|(pressure, at)| Some((pressure, cell_size(&prepared.mesh, at)?)));
        let largest = plain(of(LARGEST_PRESSURE), Sort::Pressure, max_pressure);
        all.push(Value { peak, at_edge, narrow, by_shape, ..largest });
    }
    for bolt in &answer.bolts {
        all.push(plain(format!("force of bolt \"{}\"", bolt.name), Sort::Force, bolt.force));
    }
    let displacement = answer.displacement_max;
    let by_curves = SAFETY * displaced_by_curves(prepared, outcome, &flattened);
    let largest = plain("largest displacement".into(), Sort::Displacement, displacement);
    let by_shape = open.iter().map(|open| open.gap).fold(0.0, f64::max);
    let least = by_curves.max(LEAST * displacement);
    let of_square = if is_prescribed(prepared, outcome) { OF_PRESCRIBED } else { OF_SQUARE };
    all.push(Value { least, of_square, by_shape, ..largest });
    let by_shape = open.iter().map(|open| open.energy).sum::<f64>();
    let energy = plain("energy".into(), Sort::Other, answer.energy);
    all.push(Value { of_square: OF_ENERGY, by_shape, ..energy });
    all
}

/// Those that goals are of, as values at the end of a load step at time `t`.
pub(super) fn at_time(t: f64, values: Vec<Value>) -> impl Iterator<Item = Value> {
    let named = move |value: Value| Value { name: format!("{} at t = {}", value.name, number(t)), t: Some(t), ..value };
    values.into_iter().filter(|value| value.sort != Sort::Other).map(named)
}

/// The part of the area of curved faces that the flat pieces leave out which stand for them. Contact forces along the normals of single
/// nodes add up to less than the integral of the pressure by about as much: the normals differ across the faces at a node, and
/// forces along them cancel.
fn flattened(surface: &SurfaceFacts) -> f64 {
    let flat = surface.pair.as_ref().map_or(0.0, |pair| pair.flat_area);
    if flat > 0.0 { (1.0 - flat / surface.area).max(0.0) } else { 0.0 }
}

/// What curved contact leaves open of displacements, length: that of a pair whose shape does not change is exact, and the part of a change that
/// is along the normals by which the surfaces move against one another is short by what is `flattened`.
fn displaced_by_curves(prepared: &Prepared, outcome: &Outcome, flattened: &[f64]) -> f64 {
    if flattened.iter().all(|&part| part <= LEAST) {
        return 0.0;
    }
    changed_shape(prepared, outcome).iter().zip(flattened).map(|(change, part)| part * change).fold(0.0, f64::max)
}

/// By how much contact changes the shape of each surface with contact points, length: the most that one of them moves away from their mean.
pub(super) fn changed_shape(prepared: &Prepared, outcome: &Outcome) -> Vec<f64> {
    let u = full_displacement(&prepared.model, &outcome.solution.u);
    let u: &[V3] = u.as_chunks().0;
    let frames = frames(prepared);
    let of_pair = |pair: &Pair| {
        let of_points = || frames[pair.points.clone()].iter().map(|frame| u[frame.node as usize]);
        let mean = mean(of_points());
        of_points().map(|u| norm(sub(u, mean))).fold(0.0, f64::max)
    };
    // Behind those of surfaces are ties.
    prepared.problem.labels.pairs.iter().take(prepared.surfaces.len()).map(of_pair).collect()
}

/// Whether the largest displacement is where one is prescribed.
fn is_prescribed(prepared: &Prepared, outcome: &Outcome) -> bool {
    let (_, place) = largest_displacement(prepared, outcome);
    let unknown = &prepared.model.dofs.unknown;
    let mut held =
        prepared.mesh.nodes.iter().zip(unknown.chunks_exact(3)).filter(|(_, own)| own.iter().all(|&i| i == u32::MAX));
    held.any(|(node, _)| *node == place)
}

/// By name, for the record of a level.
pub(super) fn named(values: &[Value]) -> Named {
    Named(values.iter().map(|value| (value.name.clone(), value.value)).collect())
}

/// The bars of the last mesh by name, where they are known.
pub(super) fn bars(levels: &[Vec<Value>], error: &[f64]) -> Named {
    Named(records(levels, error).into_iter().filter_map(|record| Some((record.name, record.bar?))).collect())
}

/// The cells that have a node at `place`.
fn cells_at(mesh: &Mesh, place: [f64; 3]) -> impl Iterator<Item = usize> + '_ {
    let at_place = move |node: &u32| mesh.nodes[*node as usize] == place;
    let cells = mesh.cells.iter().flat_map(|block| (0..block.len()).map(|i| block.cell(i))).enumerate();
    cells.filter(move |(_, nodes)| nodes.iter().any(at_place)).map(|(cell, _)| cell)
}

/// The size of the smallest cell that has a node at `place`, length.
fn cell_size(mesh: &Mesh, place: [f64; 3]) -> Option<f64> {
    cells_at(mesh, place).map(|cell| mesh.cell_volume(cell).cbrt()).reduce(f64::min)
}

/// The cells at the largest pressure of each pair, and at the largest at sharp edges.
pub(super) fn cells_at_peaks(prepared: &Prepared, outcome: &Outcome) -> Vec<u32> {
    let frames = frames(prepared);
    let tractions = tractions(prepared, outcome, &frames);
    let pairs = prepared.problem.labels.pairs.iter().enumerate();
    let at_edges = pairs.filter_map(|pair| largest_at_sharp_edge(prepared, outcome, pair, &frames, &tractions));
    let peaks = pair_totals(prepared, outcome).into_iter().filter_map(|(_, totals)| totals.max_pressure_at);
    let places = peaks.chain(at_edges.map(|(_, at)| at));
    places.flat_map(|at| cells_at(&prepared.mesh, at)).map(|cell| cell as u32).collect()
}

/// Half the width of the error bar of the last of `values`, one for each mesh, by the estimates `error` of these meshes:
/// values converge at least as fast as the energy norm, and that none does so faster is the cautious assumption. Meshes that are
/// as coarse where a peak is say nothing of it, and those with the same contact points nothing of what these tell.
/// `None` with fewer than three meshes, without one that says something, and of a peak whose cells have not been halved or that still
/// follows their size; the least where the answer is exact.
pub(super) fn bar(values: &[&Value], error: &[f64]) -> Option<f64> {
    let (last, before) = values.split_last()?;
    let e = error[before.len()];
    if last.by_shape.is_infinite() {
        return None;
    }
    if e <= EXACT {
        return Some(if last.least > LEAST * last.value.abs() { last.least } else { 0.0 }.max(last.by_shape));
    }
    if values.len() < LEAST_LEVELS || !has_settled(values) || last.narrow {
        return None;
    }
    let is_coarser = |value: &Value| {
        let there = match (value.peak, last.peak) {
            (Some(coarse), Some(size)) => coarse > FINER * size,
            (None, Some(_)) => false,
            _ => true,
        };
        there && last.points.is_none_or(|points| value.points.is_some_and(|coarse| coarse < points))
    };
    let by = |(value, &error): (&&Value, &f64)| {
        let says = error > APART * e && is_coarser(value);
        says.then(|| (value.value - last.value).abs() * e / (error - e))
    };
    let largest = before.iter().zip(error).rev().take(BEFORE).filter_map(by).reduce(f64::max)?;
    Some((SAFETY * largest).max(last.least).max(last.of_square * e * e * last.value.abs()).max(last.by_shape))
}

/// A largest pressure, and the size of the cells where it is.
type Peak = Option<(f64, f64)>;

/// Whether a value is none of a peak, or that of one whose cells have been halved and which no longer follows them; cells at a sharp edge
/// that contact reaches have to be halved twice, for what grows without bound begins there and is overtaken by nothing.
fn has_settled(values: &[&Value]) -> bool {
    let Some(last) = values.last() else { return true };
    let is_still = |peaks: &[Peak], sizes: [f64; 2]| sizes.iter().all(|&coarser| rises(peaks, coarser) == Some(false));
    (last.peak.is_none() || is_still(&largest(values), [FINER, HALVED]))
        && (last.at_edge.is_none() || is_still(&at_edges(values), [HALVED, TWICE_HALVED]))
}

fn largest(values: &[&Value]) -> Vec<Peak> {
    values.iter().map(|value| Some((value.value, value.peak?))).collect()
}

fn at_edges(values: &[&Value]) -> Vec<Peak> {
    values.iter().map(|value| value.at_edge).collect()
}

/// Whether the last of these peaks has risen with a power of the size of the cells since the last mesh on which they were `coarser`
/// times as large; `None` without such a mesh. It may be elsewhere on each mesh, as along the rim of a punch.
fn rises(peaks: &[Peak], coarser: f64) -> Option<bool> {
    let (&last, before) = peaks.split_last()?;
    let (value, size) = last?;
    let since = |peak: &Peak| peak.filter(|(_, coarse)| *coarse >= coarser * size);
    let (first, coarse) = before.iter().rev().find_map(since)?;
    Some((value / first).log2() >= SINGULAR * (coarse / size).log2())
}

/// Whether a peak grows without bound: it, or the largest pressure at sharp edges, rises with a power of the size of its cells, over the last
/// halving and over two.
pub(super) fn is_unbounded(peaks: &[&Value]) -> bool {
    // Peaks of contact that was too narrow for the cells say nothing.
    let from = peaks.iter().rposition(|peak| peak.narrow).map_or(0, |last| last + 1);
    let grows = |peaks: Vec<Peak>| [HALVED, TWICE_HALVED].iter().all(|&coarser| rises(&peaks, coarser) == Some(true));
    grows(largest(&peaks[from..])) || grows(at_edges(&peaks[from..]))
}

/// The values of the last mesh with their bars.
pub(super) fn records(levels: &[Vec<Value>], error: &[f64]) -> Vec<ValueRecord> {
    let Some(last) = levels.last() else { return Vec::new() };
    let record = |(i, value): (usize, &Value)| {
        // A mesh on which there is no such value, as of a contact that is not there, says nothing of those after it.
        let of_levels = levels.iter().map(|level| level.get(i).filter(|other| other.name == value.name));
        let Some(of_levels) = of_levels.collect::<Option<Vec<&Value>>>() else {
            return ValueRecord { name: value.name.clone(), value: Some(value.value), bar: None, t: value.t };
        };
        if is_unbounded(&of_levels) {
            return ValueRecord { name: value.name.clone(), value: None, bar: None, t: value.t };
        }
        ValueRecord { name: value.name.clone(), value: Some(value.value), bar: bar(&of_levels, error), t: value.t }
    };
    last.iter().enumerate().map(record).collect()
}

/// The largest bar of the values of a sort over the largest of these values, at the ends of all load steps; `None` where one has no bar
/// yet. Values without a limit are no goal.
pub(super) fn worst_bar(levels: &[Vec<Value>], error: &[f64], sort: Sort) -> Option<f64> {
    let of_sort = levels.last()?.iter().zip(records(levels, error)).filter(|(value, _)| value.sort == sort);
    let bounded: Vec<(f64, Option<f64>)> =
        of_sort.filter_map(|(_, record)| Some((record.value?, record.bar))).collect();
    let scale = bounded.iter().map(|(value, _)| value.abs()).fold(0.0, f64::max);
    let bars = bounded.iter().map(|(_, bar)| *bar).collect::<Option<Vec<f64>>>()?;
    let worst = bars.into_iter().fold(0.0, f64::max);
    Some(if worst == 0.0 { 0.0 } else { worst / scale })
}

/// What no finer mesh makes the worst bar of a sort smaller than, as [`worst_bar`] has it: the shape of the first one leaves it open.
pub(super) fn least_bar(levels: &[Vec<Value>], sort: Sort) -> f64 {
    let of_sort = || levels.last().into_iter().flatten().filter(|value| value.sort == sort);
    let scale = of_sort().map(|value| value.value.abs()).fold(0.0, f64::max);
    let least = of_sort().map(|value| value.by_shape).fold(0.0, f64::max);
    if least == 0.0 { 0.0 } else { least / scale }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(value: f64) -> Value {
        let (name, least) = ("force".into(), LEAST * value.abs());
        Value {
            name,
            sort: Sort::Force,
            value,
            least,
            peak: None,
            points: None,
            of_square: 0.0,
            at_edge: None,
            narrow: false,
            by_shape: 0.0,
            t: None,
        }
    }

    fn peak(value: f64, size: f64) -> Value {
        Value { name: "largest pressure".into(), sort: Sort::Pressure, peak: Some(size), ..plain(value) }
    }

    fn bar_of<const N: usize>(values: [Value; N], error: &[f64]) -> Option<f64> {
        bar(&values.iter().collect::<Vec<_>>(), error)
    }

    #[test]
    fn what_the_shape_leaves_open_is_in_every_bar_and_survives_a_file() {
        let error = [0.1, 0.05, 0.02, 0.01];
        let open = |by_shape: f64| error.map(|e| Value { by_shape, ..plain(3.0 + 2.0 * e) });
        assert_eq!(bar_of(open(0.5), &error), Some(0.5));
        assert_eq!(bar_of(open(f64::INFINITY), &error), None);
        // Also where the solution lies in the space of the elements.
        assert_eq!(bar_of(open(0.5), &[0.0; 4]), Some(0.5));
        assert_eq!(least_bar(&open(0.5).map(|value| vec![value]), Sort::Force), 0.5 / 3.02);
        for value in [open(0.5), open(f64::INFINITY)].concat() {
            let read: Value = serde_json::from_str(&serde_json::to_string(&value).unwrap()).unwrap();
            assert_eq!(read, value);
        }
    }

    #[test]
    fn the_bar_of_a_value_that_follows_the_error_is_its_error_with_some_to_spare() {
        let error = [0.1, 0.05, 0.02, 0.01];
        let found = bar_of(error.map(|e| plain(3.0 + 2.0 * e)), &error).unwrap_or(0.0);
        assert!((found - SAFETY * 0.02).abs() < 1e-12, "{found}");
        // One that converges faster is closer than its bar, and one that does not change has none to speak of.
        let faster = bar_of(error.map(|e| plain(3.0 + 2.0 * e * e)), &error);
        assert!(faster.is_some_and(|bar| bar > 2.0 * 1e-4 && bar < 0.02));
        assert_eq!(bar_of([5.0; 4].map(plain), &error), Some(5.0 * LEAST));
        // But for a displacement, which is known as well as the energy.
        let displacement = |value: f64| Value { sort: Sort::Displacement, of_square: OF_SQUARE, ..plain(value) };
        assert_eq!(bar_of([5.0; 4].map(displacement), &error), Some(OF_SQUARE * 1e-4 * 5.0));
    }

    /// A body that is pressed and lifted off: no force is left at the end, and that of the step before is as far off as it was then.
    #[test]
    fn the_worst_bar_is_that_of_any_step() {
        let error = [0.1, 0.05, 0.02, 0.01];
        let level = |e: f64| {
            let pressed = at_time(1.0, vec![plain(3.0 + 2.0 * e)]);
            [plain(0.0)].into_iter().chain(pressed).collect::<Vec<Value>>()
        };
        let levels = error.map(level);
        let worst = worst_bar(&levels, &error, Sort::Force).unwrap_or(0.0);
        assert!((worst - SAFETY * 0.02 / 3.02).abs() < 1e-12, "{worst}");
        assert_eq!(worst_bar(&levels.map(|level| level[..1].to_vec()), &error, Sort::Force), Some(0.0));
    }

    #[test]
    fn a_bar_takes_three_meshes_and_errors_that_fall() {
        assert_eq!(bar_of([1.0, 2.0].map(plain), &[0.2, 0.1]), None);
        assert_eq!(bar_of([1.0, 2.0, 3.0].map(plain), &[0.1, 0.1, 0.1]), None);
        assert_eq!(bar(&[], &[]), None);
        // The solution lies in the space of the elements: no mesh has more to say.
        assert_eq!(bar_of([4.0].map(plain), &[1e-12]), Some(0.0));
    }

    /// The error falls in the bodies while contact keeps its points: an area that does not change is not known the better.
    #[test]
    fn the_bar_of_an_area_is_not_smaller_than_its_edge_is_wide() {
        let area = |(edge, points): (f64, usize)| Value { least: edge, points: Some(points), ..plain(430.0) };
        let error = [0.2, 0.1, 0.08];
        assert_eq!(bar_of([(40.0, 45), (40.0, 45), (30.0, 60)].map(area), &error), Some(30.0));
        // Meshes with the same points say nothing of one another.
        assert_eq!(bar_of([(40.0, 45), (40.0, 45), (40.0, 45)].map(area), &error), None);
    }

    #[test]
    fn a_peak_has_a_bar_once_its_cells_are_halved_and_it_no_longer_follows_them() {
        let of = |peaks: [(f64, f64); 3]| bar_of(peaks.map(|(p, h)| peak(p, h)), &[0.2, 0.1, 0.05]);
        assert!(of([(34.0, 3.0), (34.5, 3.0), (35.0, 1.5)]).is_some());
        assert_eq!(of([(34.0, 3.0), (34.5, 3.0), (35.0, 3.0)]), None);
        assert_eq!(of([(34.0, 3.0), (34.5, 3.0), (35.0, 2.0)]), None);
        assert_eq!(of([(34.0, 6.0), (38.0, 4.0), (48.0, 2.0)]), None);
    }

    /// A punch whose middle carries most at first: what is at its rim grows without bound and will overtake it.
    #[test]
    fn a_peak_has_no_bar_before_the_pressure_at_a_sharp_edge_is_known() {
        let error = [0.3, 0.2, 0.1, 0.05];
        let flat = |edges: [Option<(f64, f64)>; 4]| -> Vec<Value> {
            let sizes = [4.0, 3.0, 2.0, 1.0].into_iter();
            sizes.zip(edges).map(|(size, at_edge)| Value { at_edge, ..peak(10.0, size) }).collect()
        };
        let of = |edges| {
            let values = flat(edges);
            let values: Vec<&Value> = values.iter().collect();
            (bar(&values, &error).is_some(), is_unbounded(&values))
        };
        let sizes = [8.0, 4.0, 2.0, 1.0];
        assert_eq!(of([None; 4]), (true, false));
        assert_eq!(of(sizes.map(|_| Some((5.0, 8.0)))), (false, false), "its cells stay as they are");
        assert_eq!(of(sizes.map(|h| Some((5.0, h)))), (true, false), "it is halved and stays");
        assert_eq!(
            of(sizes.map(|h: f64| Some((5.0 * h.powf(-0.25), h)))),
            (false, true),
            "it grows, and is smaller yet"
        );
        assert_eq!(of([None, None, Some((5.0, 2.0)), Some((5.0, 1.0))]), (false, false), "contact has just got there");
    }

    #[test]
    fn a_peak_that_follows_the_size_of_its_cells_is_without_bound_and_one_that_settles_is_not() {
        let unbounded = |peaks: &[Value]| is_unbounded(&peaks.iter().collect::<Vec<_>>());
        let singular: Vec<Value> = [1.0, 0.5, 0.25, 0.125].map(|h: f64| peak(h.powf(-0.5), h)).to_vec();
        assert!(unbounded(&singular));
        let smooth: Vec<Value> = [1.0, 0.5, 0.25, 0.125].map(|h: f64| peak(2.0 - h * h, h)).to_vec();
        assert!(!unbounded(&smooth[1..]));
        // Neither is one that has grown while contact was not resolved.
        let resolved: Vec<Value> = [1.0, 0.5, 0.25, 0.125].map(|h: f64| peak(1.0 / h.max(0.25), h)).to_vec();
        assert!(!unbounded(&resolved));
        // Nor one that grows with the cells because contact is narrower than they are.
        let narrow: Vec<Value> = singular.iter().map(|peak| Value { narrow: true, ..peak.clone() }).collect();
        assert!(!unbounded(&narrow) && bar(&narrow.iter().collect::<Vec<_>>(), &[0.3, 0.2, 0.1, 0.05]).is_none());
        // Two meshes are not enough, and cells have to shrink.
        assert!(!unbounded(&singular[2..]));
        assert!(!unbounded(&[1.0, 2.0, 4.0, 8.0].map(|value| peak(value, 1.0))));
        assert!(!unbounded(&[]));
    }
}
