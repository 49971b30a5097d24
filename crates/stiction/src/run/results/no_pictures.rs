//! In place of pictures, where the feature `plots` is off.

use std::path::Path;

use super::fields::{BodyFields, SurfaceFields};
use crate::Error;
use crate::run::pose::Prepared;
use crate::run::solve::Outcome;

/// Draws nothing.
pub(super) fn write(
    _: &Path,
    _: &Prepared,
    _: &Outcome,
    _: &BodyFields,
    _: &[SurfaceFields],
) -> Result<Vec<String>, Error> {
    Ok(Vec::new())
}
