//! io.

pub mod case;
pub mod expression;
