//! Printing. A reader that has gone away (`stiction ... | head`) is no reason to fail; standard output that cannot be
//! written, as on a full disk, ends the program with an error, after its work is done.

use std::io::{self, ErrorKind, Write as _};
use std::panic::PanicHookInfo;
use std::sync::OnceLock;

use stiction::Error;
use stiction::io::text::plain;

/// Prints to standard output; names in the text command no terminal.
pub fn out(text: &str) {
    data(&plain(text));
}

/// Prints to standard output what another program reads.
pub fn data(text: &str) {
    let mut stdout = io::stdout();
    keep(stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()));
}

/// The first error of standard output.
static LOST: OnceLock<io::Error> = OnceLock::new();

/// Keeps how printing to standard output ended.
pub fn keep(printed: io::Result<()>) {
    if let Err(error) = printed
        && error.kind() != ErrorKind::BrokenPipe
    {
        let _ = LOST.set(error); // unless there is one already
    }
}

/// What is wrong if not all could be printed to standard output.
pub fn lost() -> Option<Error> {
    keep(io::stdout().flush());
    LOST.get().map(|error| {
        let remedy = "make room on the disk or send the output elsewhere; files of results that were written are whole";
        Error::new("standard output", format!("not all could be written to it ({error})"), remedy)
    })
}

/// Prints to standard error; names in the text command no terminal.
pub fn note(text: &str) {
    let _ = io::stderr().write_all(plain(text).as_bytes());
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

/// What a panic says, where it says it in words.
pub fn panic_message<'a>(info: &'a PanicHookInfo) -> Option<&'a str> {
    let payload = info.payload();
    payload.downcast_ref::<&str>().copied().or_else(|| payload.downcast_ref::<String>().map(String::as_str))
}

/// Prints what a mistake of ours looks like to a user.
pub fn internal_error(info: &PanicHookInfo) {
    let place = info.location().map_or(String::new(), |l| format!(" ({}, line {})", l.file(), l.line()));
    let message = panic_message(info).unwrap_or("no message");
    note(&format!(
        "internal error: {message}{place}\nThis is a mistake of stiction {}, not yours: please report it with the case \
         file that shows it.\n",
        env!("CARGO_PKG_VERSION")
    ));
}
