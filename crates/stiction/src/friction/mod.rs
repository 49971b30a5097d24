//! friction.
