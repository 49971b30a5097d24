//! Complete decks: rank 0 reads them, the others know all but the mesh.

use std::path::{Path, PathBuf};

use crate::Error;
use crate::io::case::Case;
use crate::io::deck::{self, case_without_mesh};
use crate::ranks::{Ranks, agree, broadcast};

/// The case of the deck at `path`, changed by `overrides`, and its text, which is empty but at rank 0; files that it includes are looked for as by [`deck::read()`]. Its mesh is at
/// rank 0 alone, which divides it.
///
/// # Errors
/// As [`deck::read()`] and [`deck::Deck::case`], at every rank.
pub fn case_of_deck(
    path: &Path,
    include: &[PathBuf],
    overrides: &[(String, String)],
    ranks: &dyn Ranks,
) -> Result<(Case, String), Error> {
    let first = ranks.rank() == 0;
    let read = if first { deck::read(path, include).map(Some) } else { Ok(None) };
    let deck = agree(ranks, read)?;
    let words = broadcast(ranks, deck.as_ref().map_or(Vec::new(), deck::Deck::without_mesh));
    let text = deck.as_ref().map_or(String::new(), |deck| deck.text.clone());
    let case = agree(ranks, deck.map_or_else(|| case_without_mesh(&words, overrides), |deck| deck.case(overrides)))?;
    Ok((case, text))
}
