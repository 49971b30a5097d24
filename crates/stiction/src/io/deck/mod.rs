//! Complete decks of CalculiX and Abaqus (`.inp`): from their cards to the case they pose.
//!
//! Formats: CalculiX CrunchiX User's Manual, chapter "Input deck format"; Abaqus Keywords Reference. Mesh and sets come
//! from [`abaqus`](super::abaqus). Every other card is read, or changes nothing here and is named so, or is refused with
//! its line and the remedy: no card and no parameter of a card is skipped in silence.
//!
//! The result is the text of a case file and a mesh with the groups and arrays it names. It is read as any case file is,
//! so that a deck can say nothing that a case file cannot, and errors of later stages are shown at the line of the deck.
//!
//! The way through: `reader` hands each card to `materials`, `contact`, `steps`, `supports` or `loads`; `history` keeps
//! what values do over the steps; `write` and `pairs` write the case, `groups` the groups it names.

mod bolts;
mod contact;
mod cyclic;
mod equations;
mod forces;
mod groups;
mod history;
mod keywords;
mod loads;
mod materials;
mod output;
mod pairs;
mod points;
mod reader;
mod steps;
mod supports;
mod sweep;
mod text;
mod transform;
mod write;

pub use output::{DeckLabels, Print, Printed, Requests};
pub use sweep::DeckLayer;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::abaqus::{Include, Input};
use super::case::{self, Case, MeshSource, Spot};
use crate::Error;
use crate::mesh::{Mesh, MeshNotes};

/// The case of a deck.
#[derive(Debug, Clone)]
pub struct Deck {
    /// Its text as a case file, whose mesh file is called `mesh.vtu`.
    pub text: String,
    /// The mesh with the groups and arrays that the text names, and what was noted while it was read.
    pub mesh: Arc<(Mesh, MeshNotes)>,
    /// Remarks: what the deck regularises and a case does not, and which cards change nothing.
    pub notes: Vec<String>,
    /// The numbers that the deck gives nodes and cells.
    pub labels: DeckLabels,
    /// What it asks to be written.
    pub requests: Requests,
    /// The solids that its plane or axisymmetric elements became; `None` for a deck of solids.
    pub layer: Option<DeckLayer>,
    /// Where tables begin in the text, and their places in the deck.
    marks: Vec<(usize, Spot)>,
}

/// Reads the deck at `path`. Included files lie in its folder or below, or in one of the folders `include` or below.
///
/// # Errors
/// If the file cannot be read, or a card can neither be read nor be left out: with its line and the remedy.
pub fn read(path: &Path, include: &[PathBuf]) -> Result<Deck, Error> {
    let name = path.display().to_string();
    let short = path.file_name().map_or(name.clone(), |name| name.to_string_lossy().into_owned());
    let deck = Input::read(path, include).and_then(|input| deck(input, &short));
    deck.map_err(|e| if e.place == name { e } else { e.at(&name) })
}

/// Reads the deck in `bytes`, called `name` in messages; what it includes is asked of `include`.
///
/// # Errors
/// As [`read()`].
pub fn parse(bytes: &[u8], name: &str, include: Include) -> Result<Deck, Error> {
    Input::parse(bytes, include).and_then(|input| deck(input, name)).map_err(|e| e.at(name))
}

fn deck(input: Input, name: &str) -> Result<Deck, Error> {
    let mut reader = reader::Reader::read(&input)?;
    let write::Written { text, groups, arrays, notes } = write::write(&mut reader, name)?;
    let (requests, labels) = (output::requests(&mut reader), output::labels(&input));
    let layer = sweep::layer(&input);
    drop(reader);
    let mesh = Arc::new(input.build(groups.list, arrays)?);
    let placed = |(at, spot): (usize, Spot)| (at, Spot { place: format!("{name}, {}", spot.place), ..spot });
    let marks = text.marks.into_iter().map(placed).collect();
    Ok(Deck { text: text.text, mesh, notes, labels, requests, layer, marks })
}

impl Deck {
    /// The case, changed by overrides as [`case::read`] takes them. Errors stand at the line of the deck they come from.
    ///
    /// # Errors
    /// As [`case::read`].
    pub fn case(&self, overrides: &[(String, String)]) -> Result<Case, Error> {
        let mut case = case::parse_marked(&self.text, "case of the deck", overrides, &self.marks)?;
        case.mesh.source = MeshSource::Given(self.mesh.clone());
        case.notes.clone_from(&self.notes);
        Ok(case)
    }

    /// All of it that makes the case, but for the mesh, as bytes for [`case_without_mesh`].
    pub(crate) fn without_mesh(&self) -> Vec<u8> {
        let marks: Vec<_> = self.marks.iter().map(|(at, spot)| (at, &spot.place, &spot.excerpt)).collect();
        serde_json::to_vec(&(&self.text, &self.notes, marks)).unwrap_or_default()
    }
}

/// The case of [`Deck::case`] with a mesh of no nodes, from the bytes of [`Deck::without_mesh`].
///
/// # Errors
/// As [`Deck::case`].
pub(crate) fn case_without_mesh(bytes: &[u8], overrides: &[(String, String)]) -> Result<Case, Error> {
    type Parts = (String, Vec<String>, Vec<(usize, String, String)>);
    let (text, notes, marks): Parts = serde_json::from_slice(bytes).unwrap_or_default();
    let marks = marks.into_iter().map(|(at, place, excerpt)| (at, Spot { place, excerpt })).collect();
    let (mesh, labels, requests) = (Arc::default(), DeckLabels::default(), Requests::default());
    Deck { text, mesh, notes, labels, requests, layer: None, marks }.case(overrides)
}
