//! `report.html`: one file for a person, with an interactive view, pictures, tables and the certificate. Everything is
//! inside; nothing is fetched, and nothing of the case can become markup.

mod page;
mod tables;
mod text;
mod thin;
mod view;

#[cfg(feature = "plots")]
pub use page::pictures_smaller;
pub use page::{Page, Picture, html};
pub use thin::thin;
pub use view::{Field, FieldKind, Frame, View};
