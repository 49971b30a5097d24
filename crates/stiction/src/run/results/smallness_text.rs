//! How small rotations, strains and slips are, in words.

use super::accuracy_text::percent;
use crate::contact::SMALL_MOTION;
use crate::io::text::{number, triple};
use crate::run::solve::quantities::{SMALL_ROTATION, SMALL_STRAIN, Smallness};

/// The largest values of an answer.
pub(in crate::run) fn line(of: &Smallness) -> String {
    let slip = match &of.slip_pair {
        // Below this it is rounding.
        Some(_) if of.slip_over_face < 1e-9 => ", no slip".into(),
        Some(_) => format!(", slip {} of a face", percent(of.slip_over_face)),
        None => String::new(),
    };
    format!("rotation at most {} degrees, strain {}{slip}", number(of.rotation), percent(of.strain))
}

/// Where the linear theory is left, a sentence for each measure: in an answer `of` a case, or in the load step where it is worst, each
/// with its time.
pub(in crate::run) fn warnings<'a>(
    of: Option<&'a Smallness>,
    steps: impl ExactSizeIterator<Item = (Option<&'a Smallness>, f64)>,
) -> Vec<String> {
    let all: Vec<(&Smallness, Option<f64>)> = match steps.len() {
        0 => of.into_iter().map(|of| (of, None)).collect(),
        _ => steps.filter_map(|(of, t)| Some((of?, Some(t)))).collect(),
    };
    let worst = |value: fn(&Smallness) -> f64, limit: f64| {
        let worst = all.iter().copied().max_by(|a, b| value(a.0).total_cmp(&value(b.0)));
        worst.filter(|worst| value(worst.0) > limit)
    };
    let at = |t: Option<f64>| t.map_or(String::new(), |t| format!(" at t = {}", number(t)));
    let (mut out, theory) = (Vec::new(), "the linear theory is left");
    if let Some((s, t)) = worst(|s| s.rotation, SMALL_ROTATION) {
        let (angle, place, part) = (number(s.rotation), triple(s.rotation_at), percent(s.rotation_volume));
        let more = format!("more than {SMALL_ROTATION} in {part} of the volume");
        out.push(format!("{theory}: rotation of {angle} degrees at {place}{}, {more}", at(t)));
    }
    if let Some((s, t)) = worst(|s| s.strain, SMALL_STRAIN) {
        let (strain, place, part) = (percent(s.strain), triple(s.strain_at), percent(s.strain_volume));
        let more = format!("more than {} in {part} of the volume", percent(SMALL_STRAIN));
        out.push(format!("{theory}: strain of {strain} at {place}{}, {more}", at(t)));
    }
    if let Some((s, t)) = worst(|s| s.slip_over_face, SMALL_MOTION) {
        let (slip, pair) = (percent(s.slip_over_face), s.slip_pair.as_deref().unwrap_or_default());
        let why = "contact is that of the unmoved bodies";
        out.push(format!("{theory}: contact \"{pair}\" slides by {slip} of a face{}; {why}", at(t)));
    }
    out
}
