//! A pair of surfaces in plain words.

use super::facts::ContactFacts;
use super::report::number;
use crate::contact::{Counterpart, InitialGap, PairFacts, Reason, Role, SurfaceFriction};

/// Lengths below this part of a face's size are not worth reading.
const ROUNDING: f64 = 1e-9;

/// What was found: who carries the points, how much of the surfaces meets, how they lie.
pub(super) fn lines(contact: &ContactFacts, pair: &PairFacts) -> Vec<String> {
    let s = &contact.surface;
    let why = match pair.reason {
        Reason::Asked => "as asked",
        Reason::Array => "its friction is an array",
        Reason::Free => "the other surface is prescribed",
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
        "area {} within reach of the other; {gap}{meshed}; touching on {}, overlapping on {}",
        number(pair.covered_area),
        number(pair.touching_area),
        number(s.overlapping_area)
    ));
    lines
}

/// What a person should know about a pair, one sentence each.
pub(super) fn notes(contact: &ContactFacts, pair: &PairFacts) -> Vec<String> {
    let s = &contact.surface;
    let mut notes = Vec::new();
    if s.points == 0 {
        notes.push(nothing(contact, pair));
    }
    let mut note = |count: usize, why: &str| {
        if count > 0 {
            notes.push(format!("{count} nodes {why}: their neighbours carry the pressure there"));
        }
    };
    note(s.clamped, "are fixed");
    note(s.held_along_normal, "are held along the normal");
    note(pair.shared, "belong to both surfaces");
    note(pair.taken, "are used by another contact");
    note(pair.barely_covered, "hardly look at the other surface");
    if s.dropped_area > 0.0 {
        notes.push(format!(
            "the area {} carries no contact force: its nodes are all held or used",
            number(s.dropped_area)
        ));
    }
    if s.guided > 0 && contact.friction != SurfaceFriction::None {
        notes.push(format!("{} points are guided: friction acts in their free directions only", s.guided));
    }
    let deep = -s.gap_min;
    let size = pair.face_size[0].min(pair.face_size[1]);
    if s.points > 0 && deep > size {
        let what = "the surfaces overlap by";
        notes.push(format!("{what} {}, more than a face ({}); check positions and units", number(deep), number(size)));
    } else if s.overlapping > 0 && as_meshed(contact) {
        let what = format!("the meshes overlap by up to {}, which presses the bodies apart", number(deep));
        notes.push(format!("{what}; gap = \"closed\" would ignore it"));
    }
    if pair.averted && s.points > 0 && pair.uncovered > s.points {
        notes.push("parts of the surfaces look the same way instead of at one another".into());
    }
    notes
}

fn as_meshed(contact: &ContactFacts) -> bool {
    let gap = match &contact.against {
        Counterpart::Surface(master) => master.gap,
        Counterpart::Obstacle(_) => InitialGap::Uniform(0.0),
    };
    gap == InitialGap::AsMeshed && contact.friction != SurfaceFriction::Bonded
}

/// Why there is no contact point at all.
fn nothing(contact: &ContactFacts, pair: &PairFacts) -> String {
    let [on, against] = &contact.names;
    if pair.covered_area > 0.0 {
        return format!("no node of {on} and {against} can carry contact: all are held or used by other contacts");
    }
    if pair.averted {
        return format!("{on} and {against} look the same way and cannot touch; name the sides that face one another");
    }
    let away = pair.nearest.map_or(String::new(), |d| format!(", the nearest points are {} apart", number(d)));
    let reach = number(pair.search);
    format!("{on} and {against} nowhere face one another within {reach}{away}; check positions, or set `search`")
}
