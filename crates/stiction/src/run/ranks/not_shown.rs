//! In place of what pictures and the report show, where the feature `plots` or `report` is off.

use std::path::Path;

use super::solve::RankedAnswer;
use super::write::ForPeople;
use crate::Error;
use crate::fem::Voigt;
use crate::ranks::Ranks;
use crate::run::results::{Summary, SurfaceFields};

/// Nothing.
pub(super) struct Shown;

impl Shown {
    pub(super) fn gathered(
        _: &RankedAnswer,
        _: &[Voigt],
        _: Option<&[SurfaceFields]>,
        _: ForPeople,
        _: &dyn Ranks,
    ) -> Option<Shown> {
        None
    }

    pub(super) fn draw(&self, _: &RankedAnswer, _: &Path) -> Result<Vec<String>, Error> {
        Ok(Vec::new())
    }

    pub(super) fn write_report(&self, _: &Summary, _: &Path) -> Result<(), Error> {
        Ok(())
    }
}
