//! Places of errors: what went wrong in a later stage is shown where the case file asked for it.

use crate::Error;
use crate::io::case::Spot;

/// The same mistake, shown at `spot`; what `error` itself names as its place is kept behind it.
pub(crate) fn at(spot: &Spot, error: Error) -> Error {
    let excerpt = if error.excerpt.is_empty() { spot.excerpt.clone() } else { error.excerpt.clone() };
    Error { excerpt, ..error.at(&spot.place) }
}

/// The same mistake at `spot`, which replaces a place that only counts entries.
pub(crate) fn instead(spot: &Spot, error: Error) -> Error {
    Error { place: spot.place.clone(), excerpt: spot.excerpt.clone(), ..error }
}
