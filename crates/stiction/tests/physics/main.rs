//! What mechanics says: closed forms, statics, published numbers, orders of convergence.

mod accuracy;
mod bolts;
mod certificate;
mod closed_forms;
mod corners;
mod deck_cards;
mod decks;
mod discretisation;
mod equations;
mod error_bound;
mod exact_answers;
mod floating;
mod fretting;
mod friction_laws;
mod geometry;
mod loads;
mod materials;
mod mortar;
mod parts;
mod passing;
mod published;
mod quadratic;
mod smallness;
mod steps;
mod supports;
mod surfaces;
