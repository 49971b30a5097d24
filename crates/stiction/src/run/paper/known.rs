//! Deviations that the study has looked into, with what is known of them.

use super::compare::Quantity;
use super::experiment::Line;

/// Why a number lies outside its band, if that was looked into.
pub fn known(_table: usize, _line: &Line, _quantity: Quantity) -> Option<&'static str> {
    None
}
