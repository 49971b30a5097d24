//! Spans of time between all beginnings and ends of surfaces. In each of them a node that several name belongs to one.

use rustc_hash::FxHashMap;

use super::points::Point;
use super::{ALWAYS, ContactSurface, Period, SurfaceFacts};

/// Stretches of time in which the same surfaces hold, and these, ascending.
pub(super) struct Span {
    pub times: Vec<Period>,
    pub surfaces: Vec<usize>,
}

/// All sets of surfaces that hold together.
pub(super) fn spans(surfaces: &[ContactSurface]) -> Vec<Span> {
    let mut ends: Vec<f64> = surfaces.iter().flat_map(|surface| surface.periods.iter().copied()).flatten().collect();
    ends.extend(ALWAYS);
    ends.sort_by(f64::total_cmp);
    ends.dedup();
    let mut spans: Vec<Span> = Vec::new();
    for time in ends.windows(2).map(|pair| [pair[0], pair[1]]) {
        let holds =
            |surface: &ContactSurface| surface.periods.iter().any(|[from, to]| *from <= time[0] && time[1] <= *to);
        let holding: Vec<usize> = (0..surfaces.len()).filter(|&number| holds(&surfaces[number])).collect();
        match spans.iter_mut().find(|span| span.surfaces == holding) {
            Some(span) => span.times.push(time),
            None => spans.push(Span { times: vec![time], surfaces: holding }),
        }
    }
    spans
}

/// The points that a surface has at some times.
pub(super) struct Version {
    pub points: Vec<Point>,
    pub facts: SurfaceFacts,
    pub times: Vec<Period>,
}

/// All points of a surface, one after the other by their nodes, each once.
///
/// A point whose neighbour is lost for a time stands for that one's area then: it is another point, on the same node, with other
/// weights, so that a uniform pressure is carried as one at any time. Both go by the displacements at the end of the last increment, which is
/// all that slip knows of the past.
pub(super) fn united(versions: Vec<Version>) -> Option<(Vec<Point>, SurfaceFacts)> {
    let lost_most = |a: &SurfaceFacts, b: &SurfaceFacts| a.near[1].cmp(&b.near[1]);
    let lost = versions.iter().map(|version| &version.facts).max_by(|a, b| lost_most(a, b))?;
    let (taken, behind, near) = (lost.taken, lost.behind, lost.near);
    let largest = versions.iter().map(|version| &version.facts).max_by_key(|facts| facts.points)?;
    let mut facts = SurfaceFacts { taken, behind, near, ..largest.clone() };
    if versions.len() == 1 {
        return versions.into_iter().next().map(|version| (version.points, facts));
    }
    let all_times: Vec<Period> = versions.iter().flat_map(|version| version.times.iter().copied()).collect();
    let mut found: Vec<(Point, Vec<Period>)> = Vec::new();
    let mut at_node: FxHashMap<u32, Vec<usize>> = FxHashMap::default();
    for Version { points, times, .. } in versions {
        for point in points {
            let here = at_node.entry(point.node).or_default();
            match here.iter().find(|&&j| found[j].0 == point) {
                Some(&j) => found[j].1.extend(&times),
                None => {
                    here.push(found.len());
                    found.push((point, times.clone()));
                }
            }
        }
    }
    found.sort_by_key(|(point, _)| point.node);
    facts.points = found.len();
    facts.nodes = found.iter().map(|(point, _)| point.node).collect();
    let out = |(j, (_, times)): (usize, &(Point, Vec<Period>))| {
        let without: Vec<Period> = all_times.iter().copied().filter(|time| !times.contains(time)).collect();
        without.into_iter().map(move |time| (j, time))
    };
    facts.out = found.iter().enumerate().flat_map(out).collect();
    Some((found.into_iter().map(|(point, _)| point).collect(), facts))
}
