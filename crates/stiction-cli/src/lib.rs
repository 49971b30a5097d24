//! The command `stiction` as a function: the program calls it, and so does the package of Python.
//!
//! Exit codes: 0 solved and certified; 1 ended short of its tolerance, or a check that failed; 2 the input cannot be
//! used or the output not be written; 70 an error of the program itself; 130 interrupted.

mod algebraic;
mod ccx;
mod check;
mod frd;
mod hold;
mod interrupt;
mod memory;
mod mesh;
mod new;
mod output;
#[cfg(feature = "plots")]
mod paper;
mod progress;
mod report;
mod schema;
mod shell;
mod solve;
mod threads;

use std::ffi::OsString;
use std::sync::OnceLock;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Parser, Subcommand};

/// Certified elastic contact with friction in 3D
#[derive(Parser)]
#[command(name = "stiction", bin_name = "stiction", version, long_version = BUILD, arg_required_else_help = true, max_term_width = 100)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

/// What `--version` prints; `-V` prints the version alone.
const BUILD: &str = env!("STICTION_BUILD");

#[derive(Subcommand)]
enum Command {
    Solve(solve::Arguments),
    Check(check::Arguments),
    Algebraic(algebraic::Arguments),
    #[command(subcommand)]
    Mesh(mesh::Command),
    New(new::Arguments),
    #[cfg(feature = "plots")]
    Paper(paper::Arguments),
    /// Not in this program, which was built without the feature "plots"
    #[cfg(not(feature = "plots"))]
    Paper(Unread),
    Ccx(ccx::Arguments),
    Report(report::Arguments),
    Schema(schema::Arguments),
    Completions(shell::Completions),
    Man(shell::Man),
}

/// Arguments of a command that is not built in.
#[cfg(not(feature = "plots"))]
#[derive(clap::Args)]
struct Unread {
    #[arg(hide = true, trailing_var_arg = true, allow_hyphen_values = true)]
    _any: Vec<String>,
}

/// Says that `what` needs a feature that is off.
#[cfg(not(all(feature = "fclib", feature = "plots", feature = "report")))]
fn not_built(what: &str, feature: &str) -> stiction::Error {
    let remedy = format!("build it with --features {feature}");
    stiction::Error::new("", format!("{what} is not built into this program"), remedy)
}

/// Exit codes beside 0.
mod code {
    pub const SHORT: u8 = 1;
    pub const INPUT: u8 = 2;
    pub const INTERNAL: u8 = 70;
    pub const INTERRUPTED: u8 = 130;
}

/// What was typed, the name of the program first.
static TYPED: OnceLock<Vec<OsString>> = OnceLock::new();

/// Does what the arguments say (that of the program's name first) and returns the exit code. For a process that does nothing else:
/// it takes over signals, panics and the settings of the allocator.
pub fn run_command(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let arguments = TYPED.get_or_init(|| arguments.into_iter().collect());
    memory::keep_freed();
    memory::end_without_memory();
    std::panic::set_hook(Box::new(|info| {
        let code = if memory::is_lack_of_memory(info) {
            output::note(memory::ENDED);
            code::INPUT
        } else {
            output::internal_error(info);
            code::INTERNAL
        };
        hold::release();
        std::process::exit(code.into());
    }));
    let as_ccx = ccx::is_meant(arguments.first().map(OsString::as_os_str));
    let code = match Arguments::try_parse_from(arguments) {
        _ if as_ccx => ccx::called(arguments.iter().skip(1).map(|word| word.to_string_lossy().into_owned()).collect()),
        Ok(arguments) => run(arguments.command),
        Err(mut other) => {
            hint(&mut other);
            match other.use_stderr() {
                // It quotes arguments, among which control characters may be.
                true => output::note(&other.render().to_string()),
                // Help that was asked for, in the words of this program.
                false => output::keep(other.print()),
            }
            other.exit_code().try_into().unwrap_or(code::INPUT)
        }
    };
    hold::release();
    match output::lost() {
        Some(error) => {
            output::error(&error);
            if code <= code::SHORT { code::INPUT } else { code }
        }
        None => code,
    }
}

/// What people take for options of `solve` and is a value of the case, with an example.
const IN_THE_CASE: [(&str, &str); 7] = [
    ("--mu", "contact.0.friction.coulomb=0.3"),
    ("--friction", "contact.0.friction.coulomb=0.3"),
    ("--coulomb", "contact.0.friction.coulomb=0.3"),
    ("--tolerance", "solver.tolerance=1e-6"),
    ("--mesh", "mesh.file=part.msh"),
    ("--young", "materials.NAME.young=210e3"),
    ("--load", "load.0.force=[0, 0, -5000]"),
];

/// An option that is none and stands in the case is not a value of another, as the parser supposes.
fn hint(error: &mut clap::Error) {
    let Some(ContextValue::String(option)) = error.get(ContextKind::InvalidArg) else { return };
    let known = |(name, _): &&(&str, &str)| option.split('=').next() == Some(*name);
    if let (ErrorKind::UnknownArgument, Some((_, example))) = (error.kind(), IN_THE_CASE.iter().find(known)) {
        let tip = format!("values of the case are changed with --set KEY=VALUE: --set {example}");
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
    }
}

fn run(command: Command) -> u8 {
    let started = match &command {
        // Say how many.
        Command::Solve(_) | Command::Ccx(_) => Ok(()),
        _ => threads::start(None),
    };
    let result = started.and_then(|()| match command {
        Command::Solve(arguments) => solve::run(&arguments),
        Command::Check(arguments) => check::run(&arguments),
        Command::Algebraic(arguments) => algebraic::run(&arguments),
        Command::Mesh(command) => mesh::run(&command),
        Command::New(arguments) => new::run(&arguments),
        #[cfg(feature = "plots")]
        Command::Paper(arguments) => paper::run(&arguments),
        #[cfg(not(feature = "plots"))]
        Command::Paper(_) => Err(not_built("the study of the paper", "plots")),
        Command::Ccx(arguments) => Ok(ccx::run(&arguments)),
        Command::Report(arguments) => report::run(&arguments),
        Command::Schema(arguments) => schema::run(&arguments),
        Command::Completions(arguments) => shell::completions(&arguments),
        Command::Man(arguments) => shell::man(&arguments),
    });
    result.unwrap_or_else(|error| {
        output::error(&error);
        code::INPUT
    })
}
