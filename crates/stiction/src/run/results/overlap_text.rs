//! Surfaces that lie in each other, in plain words.

use crate::io::text::{number, triple};
use crate::run::pose::Prepared;
use crate::run::solve::{Outcome, OverlapName, OverlapRecord, Whereabouts};

/// One sentence each.
pub(in crate::run) struct Sentences {
    /// Those that make the answer none.
    pub refused: Vec<String>,
    /// Those a person should know of.
    pub warnings: Vec<String>,
}

/// What is to be said of the overlaps of an answer and, where they have gone again, of the steps before it.
pub(super) fn sentences(prepared: &Prepared, outcome: &Outcome) -> Sentences {
    let last = outcome.overlaps.iter().map(|overlap| OverlapRecord::of(Whereabouts::of(prepared), overlap)).collect();
    let steps = outcome.steps.iter().map(|step| (step.step, step.t, &step.answer.overlaps[..]));
    of_records(last, steps)
}

/// The same of the records of an answer and of its load steps, each with its number from 1 and its time.
pub(in crate::run) fn of_records<'a>(
    last: Vec<OverlapRecord>,
    steps: impl DoubleEndedIterator<Item = (usize, f64, &'a [OverlapRecord])>,
) -> Sentences {
    let mut all: Vec<(String, OverlapRecord)> = last.into_iter().map(|overlap| (String::new(), overlap)).collect();
    for (number_of_step, t, overlaps) in steps.rev() {
        for overlap in overlaps {
            if !all.iter().any(|(_, known)| same(known, overlap)) {
                all.push((format!("in step {number_of_step} (t = {}): ", number(t)), overlap.clone()));
            }
        }
    }
    let (refused, warnings): (Vec<_>, Vec<_>) = all.into_iter().partition(|(_, overlap)| is_refused(overlap));
    let said = |list: Vec<(String, OverlapRecord)>| list.iter().map(|(when, o)| when.clone() + &sentence(o)).collect();
    Sentences { refused: said(refused), warnings: said(warnings) }
}

/// Whether both are the same surfaces in the same trouble.
fn same(a: &OverlapRecord, b: &OverlapRecord) -> bool {
    (a.kind, &a.contact, &a.bodies) == (b.kind, &b.contact, &b.bodies)
}

/// Whether contact is named there and none is.
pub(crate) fn is_refused(overlap: &OverlapRecord) -> bool {
    matches!(overlap.kind, OverlapName::BeyondSearch | OverlapName::OutOfReach)
}

const TOO_LARGE: &str = "displacements are too large there for contact of the unmoved bodies";

/// What lies how deep in what, where, and the remedy.
pub(crate) fn sentence(overlap: &OverlapRecord) -> String {
    let OverlapRecord { kind, contact, bodies, groups, place, depth, part, search } = overlap;
    let (depth, place) = (number(*depth), triple(*place));
    let named = |i: usize| bodies.get(i).map_or("the body".into(), |body| format!("body \"{body}\""));
    let contact = contact.as_ref().map(|name| format!("contact \"{name}\""));
    let way = if *part < 1.0 { format!(" on the way, at {} of it,", number(*part)) } else { String::new() };
    let of_groups = match &groups[..] {
        [a, b] if a != b => format!(" (\"{a}\" and \"{b}\")"),
        [a, ..] => format!(" (\"{a}\")"),
        [] => String::new(),
    };
    match (kind, contact) {
        (OverlapName::Unnamed, Some(contact)) => format!(
            "{} lies{way} {depth} deep in the obstacle of {contact} at {place}, where `on` does not name its surface: add \
             the faces there to `on`, or give them a contact of their own",
            named(0)
        ),
        (OverlapName::Unnamed, None) => {
            let other = if bodies.len() > 1 { named(1) } else { "itself".into() };
            format!(
                "{} lies{way} {depth} deep in {other} at {place}, where no contact is named: name the two \
                 surfaces{of_groups} in [[contact]]",
                named(0)
            )
        }
        (OverlapName::BeyondSearch, contact) => format!(
            "{}: the surfaces pass through each other by {depth} at {place}, farther apart than they were looked for: set \
             search = {} or more",
            contact.unwrap_or_default(),
            search.map_or(String::new(), number)
        ),
        (OverlapName::OutOfReach, contact) => format!(
            "{}: its surface lies {depth} deep in its counterpart at {place} without a contact point: before the load \
             nothing lies opposite there, or all nodes are held, tied or used by another contact; mesh the bodies nearer \
             to where they meet, or enlarge the surfaces",
            contact.unwrap_or_default()
        ),
        (OverlapName::InContact, contact) => format!(
            "{}: its surface lies {depth} deep in its counterpart at {place} although contact points keep them apart: \
             {TOO_LARGE}; mesh the bodies nearer to where they meet",
            contact.unwrap_or_default()
        ),
        (OverlapName::BetweenPoints, contact) => format!(
            "{}: the obstacle has got {depth} deep into a face at {place} between its nodes, none of which it touches, so that no \
             force acts there: make the faces smaller than what touches them, or ask for an accuracy (--accuracy 5%)",
            contact.unwrap_or_default()
        ),
    }
}
