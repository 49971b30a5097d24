//! dual.
