//! `report.html`: one file for a person, with an interactive view, pictures, tables and the certificate. Everything is
//! inside; nothing is fetched, and nothing of the case can become markup.

mod page;
mod tables;
mod text;
mod thin;
mod view;

pub(super) use page::{Picture, html};
pub(super) use thin::thin;
pub(super) use view::{Field, Frame, View};
