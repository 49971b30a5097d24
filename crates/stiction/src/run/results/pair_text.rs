//! A pair of surfaces in plain words.

use super::accuracy_text::percent;
use crate::contact::{Counterpart, InitialGap, PairFacts, Reason, Role, SurfaceFriction};
use crate::io::text::number;
use crate::run::pose::ContactFacts;

/// Lengths below this part of a face's size are not worth reading.
const ROUNDING: f64 = 1e-9;

/// Curved faces that lose less than this part of their area are as good as flat.
const FLAT: f64 = 1e-4;

/// What areas of a pair leave out: they count the flat pieces that stand for curved faces.
fn left_out(flat: f64, curved: f64) -> String {
    let part = 1.0 - flat / curved;
    if flat > 0.0 && part > FLAT {
        return format!(" (of flat pieces, {} less than the curved faces)", percent(part));
    }
    String::new()
}

/// What was found: who carries the points, how much of the surfaces meets, how they lie.
pub(crate) fn lines(contact: &ContactFacts, pair: &PairFacts) -> Vec<String> {
    let s = &contact.surface;
    let why = match pair.reason {
        Reason::Asked => "as given",
        Reason::Array => "its friction is an array",
        Reason::Nodes => "each node by itself",
        Reason::Free => "the other surface is prescribed",
        Reason::Unheld => "supports hold the other one where it slides",
        Reason::Unshared => "another contact has nodes of the other one",
        Reason::Finer => "its faces are the smaller ones",
        Reason::Softer => "its body is the softer one",
        Reason::First => "named first",
    };
    let carrier = &contact.names[usize::from(pair.slave == Role::Against)];
    let mut lines = vec![format!("points on {carrier} ({why}), {} faces meet {}", pair.faces[0], pair.faces[1])];
    if s.points == 0 {
        return lines;
    }
    let known = |x: f64| if x.abs() <= ROUNDING * pair.face_size[0] { 0.0 } else { x };
    let gap = match (known(s.gap_min), known(s.gap_max)) {
        (low, high) if known(high - low) == 0.0 => format!("gap {}", number(high)),
        (low, high) => format!("gap from {} to {}", number(low), number(high)),
    };
    let meshed = match &contact.against {
        _ if contact.friction == SurfaceFriction::Bonded => ", tied as it is",
        Counterpart::Surface(master) if master.gap != InitialGap::AsMeshed => ", as asked",
        _ => "",
    };
    lines.push(format!(
        "area {} within reach of the other{}; {gap}{meshed}; touching on {}, overlapping on {}",
        number(pair.covered_area),
        left_out(pair.flat_area, s.area),
        number(pair.touching_area),
        number(s.overlapping_area)
    ));
    lines
}
