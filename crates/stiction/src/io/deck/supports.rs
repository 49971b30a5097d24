//! `*BOUNDARY`: prescribed displacements.

use super::history::Course;
use super::reader::Reader;
use crate::Error;
use crate::io::abaqus::{Card, Row};

/// No history.
pub(super) const NONE: u32 = u32::MAX;

impl<'a> Reader<'a> {
    pub(super) fn boundary(&mut self, card: &'a Card) -> Result<(), Error> {
        card.only(&["OP", "AMPLITUDE", "TYPE", "FIXED", "TIMEDELAY", "USER"])?;
        if card.has("USER") {
            return Err(card.error("displacements by a subroutine are not read", "give their values"));
        }
        if card.keyword.get("TYPE").is_some_and(|kind| !kind.eq_ignore_ascii_case("DISPLACEMENT")) {
            return Err(card.error("only displacements are prescribed", "take TYPE= out, or give displacements"));
        }
        if self.renews(card)? {
            self.released = true;
        }
        let course = self.course(card)?;
        for row in card.rows() {
            let nodes = self.nodes(&row, 0)?;
            if card.has("FIXED") && self.lock(&nodes) {
                continue;
            }
            // In the first step nothing has moved yet.
            let stays = card.has("FIXED") && self.step_number() > 0;
            let course = if stays { Course::Stays } else { course };
            let (first, last, value) = match row.word(1) {
                Some(word) if row.whole(1).is_none() => (named(&row, word)?, None, 0.0),
                _ => {
                    let first = direction(&row, 1)?;
                    let last = if row.word(2).is_some() { direction(&row, 2)? } else { first };
                    row.ends(4)?;
                    ((first..=last).collect(), Some(last), row.number(3)?.unwrap_or(0.0))
                }
            };
            if first.is_empty() {
                return Err(
                    row.error(format!("no direction from {:?} to {last:?}", row.word(1)), "give the lower first")
                );
            }
            if let Some(other) = first.iter().find(|&&c| c > 6) {
                let what = format!("the direction {other} is a temperature or another quantity");
                return Err(row.error(what, "prescribe directions 1, 2 and 3; give temperatures by *TEMPERATURE"));
            }
            let (points, nodes): (Vec<u32>, Vec<u32>) = nodes.into_iter().partition(|&node| self.is_reference(node));
            self.prescribe_points(&row, &points, &first, value, course)?;
            if nodes.is_empty() {
                continue;
            }
            let rotations = first.iter().filter(|c| (4..=6).contains(*c)).count();
            if rotations > 0 {
                self.notes.add("*BOUNDARY: solids have no rotations, which are left out");
            }
            let step = self.step_number();
            for &node in &nodes {
                for &c in first.iter().filter(|&&c| c <= 3) {
                    let old = self.supports[3 * node as usize + c - 1];
                    let old = (old != NONE).then_some(old);
                    let id = self.histories.change(old, step, value, course, false);
                    self.supports[3 * node as usize + c - 1] = id.unwrap_or(NONE);
                }
            }
        }
        Ok(())
    }

    /// Ends the supports that a step with OP=NEW has not named again.
    pub(super) fn end_supports(&mut self) {
        if !self.released {
            return;
        }
        let step = self.step_number();
        let Self { histories, supports, points, .. } = self;
        let all = supports.iter_mut().chain(points.iter_mut().flat_map(|point| &mut point.motion));
        for id in all.filter(|id| **id != NONE) {
            if histories.last_step(*id) != step {
                *id = histories.change(Some(*id), step, 0.0, Course::Ends, false).unwrap_or(NONE);
            }
        }
    }
}

/// Directions of a name of Abaqus.
fn named(row: &Row, word: &str) -> Result<Vec<usize>, Error> {
    Ok(match word.to_uppercase().as_str() {
        "ENCASTRE" => vec![1, 2, 3, 4, 5, 6],
        "PINNED" => vec![1, 2, 3],
        "XSYMM" => vec![1, 5, 6],
        "YSYMM" => vec![2, 4, 6],
        "ZSYMM" => vec![3, 4, 5],
        "XASYMM" => vec![2, 3, 4],
        "YASYMM" => vec![1, 3, 5],
        "ZASYMM" => vec![1, 2, 6],
        other => return Err(row.error(format!("\"{other}\" is no direction"), "give numbers from 1 to 3")),
    })
}

/// The number of a direction.
pub(super) fn direction(row: &Row, i: usize) -> Result<usize, Error> {
    let number = row.whole(i).and_then(|n| usize::try_from(n).ok()).filter(|n| (1..=30).contains(n));
    number.ok_or_else(|| {
        let word = row.word(i).unwrap_or("").to_string();
        row.error(format!("{word:?} stands where a direction was expected"), "give a number from 1 to 3")
    })
}
