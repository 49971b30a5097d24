//! `stiction new`.

use std::io::{ErrorKind, Write as _};
use std::path::{Path, PathBuf};

use stiction::Error;
use stiction::io::case::{nearest, templates};
use stiction::io::{deck, vtu_mesh};

use crate::output;
use crate::solve::is_deck;

/// Make a folder with a commented case to start from, and the files it needs
#[derive(clap::Args)]
pub struct Arguments {
    /// The folder; it is created, and an existing file in it is left alone
    #[arg(required_unless_present = "list")]
    folder: Option<PathBuf>,
    /// The case to start from, see --list; or a complete deck of CalculiX or Abaqus (.inp), which is written as a case
    #[arg(long, value_name = "NAME|DECK")]
    from: Option<String>,
    /// A folder outside that of a deck from which it may include files; may be given several times
    #[arg(long, value_name = "DIR")]
    include: Vec<PathBuf>,
    /// List the cases to start from
    #[arg(long)]
    list: bool,
}

/// Lists the templates or copies one.
pub fn run(arguments: &Arguments) -> Result<u8, Error> {
    if let Some(folder) = arguments.folder.as_ref().filter(|_| !arguments.list) {
        return match arguments.from.as_deref() {
            Some(deck) if is_deck(Path::new(deck)) => convert(folder, Path::new(deck), &arguments.include),
            name => create(folder, name),
        };
    }
    templates().iter().for_each(|t| output::out(&format!("{:<13} {}\n", t.name, t.description)));
    Ok(0)
}

fn create(folder: &Path, name: Option<&str>) -> Result<u8, Error> {
    let name = name.or(templates().first().map(|t| t.name)).unwrap_or_default();
    let template = templates().iter().find(|t| t.name == name).ok_or_else(|| {
        let names: Vec<&str> = templates().iter().map(|t| t.name).collect();
        let guess = nearest(name, names.iter().copied()).map_or(String::new(), |g| format!("did you mean {g:?}? "));
        let what = format!("there is no case {name:?} to start from");
        Error::new("--from", what, format!("{guess}the choices are {}", names.join(", ")))
    })?;
    let files: Vec<(PathBuf, &str)> = [("case.toml", template.text)]
        .iter()
        .chain(template.files)
        .map(|(name, contents)| (folder.join(name), *contents))
        .collect();
    write(folder, &files)?;
    let place = files[0].0.display();
    output::out(&format!("{place}: {}\nnext: stiction solve {place}\n", template.description));
    Ok(0)
}

/// Writes the case that a deck poses, and its mesh.
fn convert(folder: &Path, path: &Path, include: &[PathBuf]) -> Result<u8, Error> {
    let deck = deck::read(path, include)?;
    deck.case(&[])?;
    let mesh = folder.join("mesh.vtu");
    if mesh.exists() {
        return Err(exists(&mesh));
    }
    let case = folder.join("case.toml");
    write(folder, &[(case.clone(), &deck.text)])?;
    vtu_mesh::write_mesh(&mesh, &deck.mesh.0)?;
    deck.notes.iter().for_each(|note| output::out(&format!("note: {note}\n")));
    output::out(&format!("next: stiction solve {}\n", case.display()));
    Ok(0)
}

fn exists(path: &Path) -> Error {
    Error::new(path.display().to_string(), "this file exists already", "choose another folder")
}

/// Writes files that do not exist yet.
fn write(folder: &Path, files: &[(PathBuf, &str)]) -> Result<(), Error> {
    if let Some((path, _)) = files.iter().find(|(path, _)| path.exists()) {
        return Err(exists(path));
    }
    for (path, contents) in files {
        let failed = |error: std::io::Error| match error.kind() {
            ErrorKind::AlreadyExists => exists(path),
            _ => {
                let what = format!("this file cannot be written ({error})");
                Error::new(path.display().to_string(), what, "choose another folder")
            }
        };
        std::fs::create_dir_all(folder).map_err(failed)?;
        // Never over a file that exists, even one made a moment ago.
        let mut file = std::fs::OpenOptions::new().write(true).create_new(true).open(path).map_err(failed)?;
        file.write_all(contents.as_bytes()).map_err(failed)?;
    }
    Ok(())
}
