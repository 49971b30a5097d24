//! `stiction algebraic`.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use stiction::Error;
use stiction::discrete::{Form, Method, Settings, Status};
#[cfg(feature = "fclib")]
use stiction::run;
use stiction::run::algebraic;

use crate::{code, interrupt, output};

/// Solve discrete frictional contact problems given as matrices; many at once give a table
#[derive(clap::Args)]
pub struct Arguments {
    /// The problems: files of FCLib (.hdf5), NumPy files (.npz with W, q, mu or M, H, f, w, mu or K, B, f, gap, mu) or
    /// folders of the same as Matrix Market files
    #[arg(required = true)]
    files: Vec<PathBuf>,
    /// Folder for the solutions, NAME.solution.hdf5 and NAME.summary.json; without it nothing is written
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// What each measure of the answer is to be at most
    #[arg(long, default_value = "1e-8", value_parser = tolerance)]
    tolerance: f64,
    /// How: auto (Newton's method, the others choose its starts), newton, gauss-seidel, gradient or admm
    #[arg(long, default_value = "auto", value_parser = method)]
    method: Method,
    /// Whether velocities of bodies are eliminated: condensed, sparse (they stay), or auto (the cheaper by prediction);
    /// gauss-seidel always condenses
    #[arg(long, default_value = "auto", value_parser = form)]
    form: Form,
    /// Print a JSON object a problem to standard output, everything else to standard error
    #[arg(long)]
    json: bool,
}

fn tolerance(text: &str) -> Result<f64, String> {
    let value: f64 = text.parse().map_err(|_| "write a number, as in 1e-8")?;
    if value > 0.0 && value < 1.0 { Ok(value) } else { Err("it lies between 0 and 1".into()) }
}

fn method(text: &str) -> Result<Method, String> {
    Method::named(text).ok_or_else(|| format!("write one of {}", Method::ALL.map(Method::name).join(", ")))
}

fn form(text: &str) -> Result<Form, String> {
    match text {
        "auto" => Ok(Form::Auto),
        "condensed" => Ok(Form::Condensed),
        "sparse" => Ok(Form::Sparse),
        _ => Err("write one of auto, condensed, sparse".into()),
    }
}

/// Solves, judges, reports.
pub fn run(arguments: &Arguments) -> Result<u8, Error> {
    interrupt::watch()?;
    let say = if arguments.json { output::note } else { output::out };
    if let Some(folder) = &arguments.output {
        #[cfg(not(feature = "fclib"))]
        return Err(crate::not_built("writing solutions as files of FCLib", "fclib").at(&folder.display().to_string()));
        #[cfg(feature = "fclib")]
        run::writable(folder)?;
    }
    let many = arguments.files.len() > 1;
    if many {
        say(&algebraic::table_head());
    }
    let mut worst = 0;
    for path in &arguments.files {
        // One file that cannot be used does not keep the others from being solved.
        let ended = solve(path, arguments, many, say);
        let ended = match ended {
            Err(error) if many => {
                output::error(&error);
                code::INPUT
            }
            other => other?,
        };
        worst = worst.max(ended);
        if ended == code::INTERRUPTED {
            break;
        }
    }
    Ok(worst)
}

fn solve(path: &Path, arguments: &Arguments, many: bool, say: fn(&str)) -> Result<u8, Error> {
    let contents = algebraic::read(path)?;
    let name = path.file_stem().map_or("problem".into(), |stem| stem.to_string_lossy().into_owned());
    let settings = Settings { tolerance: arguments.tolerance, method: arguments.method, ..Settings::default() };
    let answer = algebraic::answer_with_rank(&contents, &settings, arguments.form, &mut |_| {
        interrupt::heard();
        if interrupt::asked() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    });
    let answer = answer.map_err(|error| error.at(&path.display().to_string()))?;
    if many {
        say(&algebraic::table_row(&name, &contents, &answer));
    } else {
        say(&algebraic::report(&name, &contents, &answer));
    }
    #[cfg(feature = "fclib")]
    if let Some(folder) = &arguments.output {
        let files = algebraic::write(&name, &contents, &answer, folder)?;
        if !many {
            say(&format!("  files        {} in {}\n", files.join(", "), folder.display()));
        }
    }
    if arguments.json {
        output::data(&format!("{}\n", algebraic::summary(&name, &contents, &answer)));
    }
    Ok(match (answer.passed(), answer.solution.status) {
        (true, _) => 0,
        (false, Status::Interrupted) => code::INTERRUPTED,
        (false, _) => code::SHORT,
    })
}
