//! What a run of the paper's experiments leaves, and its count of verdicts.

use super::compare::{Comparison, Verdict};
use stiction::io::plot::Drawing;

/// One of the paper's tables with our numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct TableReport {
    pub number: usize,
    pub caption: String,
    /// Names of our settings and what they mean.
    pub settings: Vec<(&'static str, String)>,
    pub comparisons: Vec<Comparison>,
    pub seconds: f64,
}

/// One of the paper's figures, drawn from our own solution.
#[derive(Debug, Clone, PartialEq)]
pub struct Figure {
    pub number: usize,
    pub title: String,
    pub caption: String,
    pub drawing: Drawing,
}

/// Tables and figures.
#[derive(Debug, Clone, PartialEq)]
pub struct Study {
    pub tables: Vec<TableReport>,
    pub figures: Vec<Figure>,
    pub quick: bool,
    pub seconds: f64,
}

/// How many comparisons ended how.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tally {
    pub within: usize,
    pub outside: usize,
    pub known: usize,
    pub unjudged: usize,
}

impl Tally {
    pub fn of<'a>(comparisons: impl IntoIterator<Item = &'a Comparison>) -> Tally {
        comparisons.into_iter().fold(Tally::default(), |mut tally, c| {
            match c.verdict {
                Verdict::Within => tally.within += 1,
                Verdict::Outside => tally.outside += 1,
                Verdict::Known(_) => tally.known += 1,
                Verdict::Unjudged => tally.unjudged += 1,
            }
            tally
        })
    }

    /// `12 of 14 judged numbers within their bands, 2 outside as documented`.
    pub fn words(&self) -> String {
        let judged = self.within + self.outside + self.known;
        let mut text = format!("{} of {judged} judged numbers within their bands", self.within);
        if self.known > 0 {
            text += &format!(", {} outside as documented", self.known);
        }
        if self.outside > 0 {
            text += &format!(", {} outside", self.outside);
        }
        text
    }
}

impl Study {
    pub fn tally(&self) -> Tally {
        Tally::of(self.tables.iter().flat_map(|t| &t.comparisons))
    }
}
