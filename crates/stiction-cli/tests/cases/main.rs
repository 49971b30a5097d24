//! The shipped cases and recipes: each is solved and held against statics, a closed form or a published number.

#[path = "../common/mod.rs"]
mod common;

mod recipes;
mod several_bodies;
mod shipped;
