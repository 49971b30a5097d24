//! `stiction completions` and `stiction man`: what shells and `man` read, made from the definition of the command.

use clap::CommandFactory as _;
use clap_complete::Shell;
use stiction::Error;

use crate::output;

/// Print a script by which a shell completes subcommands and options
#[derive(clap::Args)]
pub struct Completions {
    /// The shell
    shell: Shell,
}

/// Print a manual page, of the whole command or of one subcommand
#[derive(clap::Args)]
pub struct Man {
    /// The subcommand
    command: Option<String>,
}

pub fn completions(arguments: &Completions) -> Result<u8, Error> {
    let mut text = Vec::new();
    clap_complete::generate(arguments.shell, &mut crate::Arguments::command(), "stiction", &mut text);
    output::data(&String::from_utf8_lossy(&text));
    Ok(0)
}

pub fn man(arguments: &Man) -> Result<u8, Error> {
    let mut whole = crate::Arguments::command();
    // Subcommands get the names of their pages, `stiction-solve` and so on.
    whole.build();
    let page = match &arguments.command {
        None => whole,
        Some(name) => {
            let names: Vec<String> = whole.get_subcommands().map(|c| c.get_name().to_string()).collect();
            let found = whole.find_subcommand(name).ok_or_else(|| {
                let what = format!("there is no subcommand {name:?}");
                Error::new("stiction man", what, format!("the choices are {}", names.join(", ")))
            })?;
            found.clone()
        }
    };
    let mut text = Vec::new();
    clap_mangen::Man::new(page).render(&mut text).expect("a vector takes what is written");
    output::data(&String::from_utf8_lossy(&text));
    Ok(0)
}
