//! The one place where JSON is made of records and read back into them.

use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::json;

use crate::Error;
use crate::io::folder;

/// The text of a JSON file.
pub(crate) fn text(record: &impl Serialize) -> String {
    format!("{:#}\n", json!(record))
}

/// Reads what [`text`] has written; `thing` is what the file should hold.
///
/// # Errors
/// If the file is missing or holds something else.
pub(crate) fn read<T: DeserializeOwned>(path: &Path, thing: &str, remedy: &str) -> Result<T, Error> {
    let text = folder::read_text(path)?;
    serde_json::from_str(&text)
        .map_err(|error| Error::new(path.display().to_string(), format!("this is not {thing} ({error})"), remedy))
}
