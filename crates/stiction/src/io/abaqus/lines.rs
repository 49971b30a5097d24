//! Lines of sets, and the numbers that begin other lines.

use super::deck::{FaceLabel, Kind, Members, Name, Set};
use super::keyword::Fields;
use crate::Error;
use crate::io::number::integer;

/// A number of a node or an element that begins a line.
pub(super) fn label(fields: &mut Fields, what: &str) -> Result<u32, Error> {
    let word = fields.field().unwrap_or(b"");
    label_of(fields, word, what)
}

#[inline]
pub(super) fn label_of(fields: &Fields, word: &[u8], what: &str) -> Result<u32, Error> {
    integer(word).and_then(|n| u32::try_from(n).ok()).ok_or_else(|| fields.not_a(word, what))
}

/// The members that the keyword above began.
fn last(set: &mut Set) -> &mut Members {
    if set.members.is_empty() {
        set.members.push(Members::default());
    }
    let last = set.members.len() - 1;
    &mut set.members[last]
}

/// Lines of labels and names.
pub(super) fn listed(set: &mut Set, mut fields: Fields, kind: Kind) -> Result<(), Error> {
    let members = last(set);
    while fields.more() {
        while let Some(word) = fields.field() {
            match integer(word) {
                Some(_) => members.labels.push(label_of(&fields, word, "a number or the name of a set")?),
                None if word.is_empty() => {}
                None => {
                    members.names.push(Name { name: Fields::text(word), kind, face: FaceLabel::Boundary });
                }
            }
        }
        fields.next_line();
    }
    Ok(())
}

/// Lines `first, last, step`.
pub(super) fn ranges(set: &mut Set, mut fields: Fields) -> Result<(), Error> {
    let members = last(set);
    while fields.more() {
        let first = label(&mut fields, "the first number of a range")?;
        let last = label(&mut fields, "the last number of a range")?;
        let step = match fields.field() {
            None | Some([]) => 1,
            Some(word) => label_of(&fields, word, "the step of a range")?,
        };
        if last < first || step == 0 {
            return Err(fields.fail(format!("a range cannot go from {first} to {last} in steps of {step}")));
        }
        members.ranges.push([first, last, step]);
        fields.next_line();
    }
    Ok(())
}

/// Lines of an element or a set and the face; of nodes; or of surfaces whose union this is.
pub(super) fn surface(set: &mut Set, mut fields: Fields, union: bool) -> Result<(), Error> {
    let members = last(set);
    while fields.more() {
        let what = fields.field().unwrap_or(b"");
        let face = match fields.field() {
            _ if members.nodal || union => FaceLabel::Boundary,
            None | Some([]) => FaceLabel::Boundary,
            Some([b'S' | b's', digit @ b'1'..=b'6']) => FaceLabel::Side(digit - b'1'),
            Some(word) if word.eq_ignore_ascii_case(b"SPOS") || word.eq_ignore_ascii_case(b"SNEG") => {
                FaceLabel::Boundary
            }
            Some(word) => return Err(fields.not_a(word, "a face, S1 to S6,")),
        };
        match integer(what) {
            Some(_) if members.nodal => members.labels.push(label_of(&fields, what, "a node")?),
            Some(_) if !union => members.faces.push((label_of(&fields, what, "an element")?, face)),
            _ if what.is_empty() => return Err(fields.not_a(what, "an element, a node or a set")),
            _ => {
                let kind = match (union, members.nodal) {
                    (true, _) => Kind::Surface,
                    (false, true) => Kind::Nodes,
                    (false, false) => Kind::Elements,
                };
                members.names.push(Name { name: Fields::text(what), kind, face });
            }
        }
        fields.next_line();
    }
    Ok(())
}
