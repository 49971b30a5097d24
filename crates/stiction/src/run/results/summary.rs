//! `summary.json`: what a script needs. Numbers are written with all their digits, what is not finite as `null`.

use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::facts_text::problem_rows;
use super::fretting::FrettingRecord;
use super::json;
use super::of_ranks::RanksRecord;
use super::report::report;
use super::rows::Row;
use super::write::Origin;
use crate::Error;
use crate::run::pose::Prepared;
use crate::run::solve::quantities::load;
use crate::run::solve::{AccuracyRecord, AnswerRecord, BalanceRecord, BoundRecord, Outcome, StepRecord};

/// Number of the format: another one where keys have another name or another meaning.
pub const FORMAT: u32 = 2;

/// The contents of `summary.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Summary {
    /// Heading of the case.
    pub title: String,
    /// Names of the units, a label only.
    pub units: Option<String>,
    /// With load steps that of the last one.
    #[serde(flatten)]
    pub answer: AnswerRecord,
    /// Keys and values of the case that were changed.
    pub overrides: Vec<String>,
    /// Versions of program and format.
    pub versions: Versions,
    /// Of a stepped run.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub balance: Option<BalanceRecord>,
    /// One record a load step; empty without load steps.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub steps: Vec<StepRecord>,
    /// What friction has done to the surface of each pair since the start of the load steps.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub fretting: Vec<FrettingRecord>,
    /// Where the mesh was refined: goals, levels and values with their error bars.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<AccuracyRecord>,
    /// A bound of the discretisation error of the answer, where one was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bound: Option<BoundRecord>,
    /// The command that wrote the folder.
    pub command: Option<String>,
    /// The case as the program understood it.
    pub problem: Vec<Row>,
    /// What it printed of the answer.
    pub report: Vec<Row>,
    /// Names of the pictures.
    #[serde(default)]
    pub pictures: Vec<String>,
    /// Of a run on several ranks.
    #[serde(flatten, default, skip_serializing_if = "Option::is_none")]
    pub ranks: Option<RanksRecord>,
}

/// Who wrote a summary.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct Versions {
    /// Version of the program.
    pub stiction: String,
    /// [`FORMAT`].
    pub summary: u32,
}

impl Default for Versions {
    fn default() -> Self {
        Versions { stiction: env!("CARGO_PKG_VERSION").into(), summary: FORMAT }
    }
}

/// The text of `summary.json` but for the names of the pictures, which are known once they are written.
pub fn summary(prepared: &Prepared, outcome: &Outcome, origin: &Origin) -> String {
    json::text(&Summary::of(prepared, outcome, origin))
}

impl Summary {
    pub(crate) fn of(prepared: &Prepared, outcome: &Outcome, origin: &Origin) -> Self {
        let mut answer = AnswerRecord::of(prepared, outcome);
        if !outcome.steps.is_empty() {
            answer.load = load(prepared);
        }
        Summary {
            title: prepared.facts.title.clone(),
            units: prepared.facts.units.clone(),
            answer,
            overrides: origin.overrides(),
            versions: Versions::default(),
            balance: outcome.steps.last().map(|last| last.balance),
            steps: outcome.steps.clone(),
            fretting: Vec::new(),
            accuracy: outcome.accuracy.clone(),
            bound: outcome.bound.as_ref().map(BoundRecord::of),
            command: origin.command.clone(),
            problem: problem_rows(&prepared.facts),
            report: report(prepared, outcome).rows,
            pictures: Vec::new(),
            ranks: None,
        }
    }
}

/// Reads `summary.json`.
///
/// # Errors
/// If the file is missing, no summary, or one of another format.
pub(crate) fn read<T: DeserializeOwned>(path: &Path) -> Result<T, Error> {
    #[derive(Deserialize)]
    struct Head {
        versions: Versions,
    }
    let place = path.display().to_string();
    let again = "the file is damaged or incomplete; solve the case again";
    let head: Head = json::read(path, "a summary", again)?;
    let format = head.versions.summary;
    if format != FORMAT {
        let what = format!("this summary has the format {format}, and this version reads {FORMAT}");
        return Err(Error::new(place, what, "solve the case again, or use the version that wrote it"));
    }
    json::read(path, "a summary", again)
}
