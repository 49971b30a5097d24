//! Printing. A reader that has gone away (`stiction ... | head`) is no reason to fail.

use std::io::Write as _;
use std::panic::PanicHookInfo;

use stiction::Error;

/// Prints to standard output.
pub fn out(text: &str) {
    let _ = std::io::stdout().write_all(text.as_bytes());
}

/// Prints to standard error.
pub fn note(text: &str) {
    let _ = std::io::stderr().write_all(text.as_bytes());
}

/// Prints what is wrong, where, and the remedy.
pub fn error(error: &Error) {
    let mut text = "error: ".to_string();
    if !error.place.is_empty() {
        text += &format!("{}: ", error.place);
    }
    text += &format!("{}\n", error.what);
    error.excerpt.lines().for_each(|line| text += &format!("  {line}\n"));
    if !error.remedy.is_empty() {
        text += &format!("remedy: {}\n", error.remedy);
    }
    note(&text);
}

/// Prints what a mistake of ours looks like to a user.
pub fn internal_error(info: &PanicHookInfo) {
    let place = info.location().map_or(String::new(), |l| format!(" ({}, line {})", l.file(), l.line()));
    let message = info.payload_as_str().unwrap_or("no message");
    note(&format!(
        "internal error: {message}{place}\nThis is a mistake of stiction {}, not yours: please report it with the case \
         file that shows it.\n",
        env!("CARGO_PKG_VERSION")
    ));
}
