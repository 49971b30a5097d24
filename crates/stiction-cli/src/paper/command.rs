//! `stiction paper`.

use std::ops::ControlFlow;
use std::path::PathBuf;

use stiction::Error;
use stiction::run::writable;

use super::study::Tally;
use super::write::write_study;
use super::{FIGURES, Request, StudyEvent, TABLES, study};
use crate::progress::{Mode, Progress};
use crate::{code, hold, interrupt, output};

/// Run the experiments of the source paper and set our numbers beside the published ones
///
/// The paper: J. Haslinger, R. Kučera, Z. Dostál, J. Comput. Appl. Math. 164-165 (2004) 387-408. Without --table and
/// --figure everything is run. Exit code 1 if a number lies outside its band without a documented reason.
#[derive(clap::Args)]
pub struct Arguments {
    /// A table to run, 1 to 12; may be repeated
    #[arg(long, value_name = "N")]
    table: Vec<usize>,
    /// A figure to draw, 1 to 6; may be repeated
    #[arg(long, value_name = "N")]
    figure: Vec<usize>,
    /// Only what is judged by a band, in the fitted setting: seconds instead of minutes
    #[arg(long)]
    quick: bool,
    /// Folder of the report
    #[arg(short, long, value_name = "DIR", default_value = "paper")]
    output: PathBuf,
    /// How progress is shown, on standard error
    #[arg(long, value_enum, default_value = "auto")]
    progress: Mode,
}

/// Runs, writes, sums up.
pub fn run(arguments: &Arguments) -> Result<u8, Error> {
    interrupt::watch()?;
    let everything = arguments.table.is_empty() && arguments.figure.is_empty();
    let request = Request {
        tables: if everything { (1..=TABLES).collect() } else { arguments.table.clone() },
        figures: if everything { (1..=FIGURES).collect() } else { arguments.figure.clone() },
        quick: arguments.quick,
    };
    request.validate()?;
    hold::folder(&arguments.output)?;
    writable(&arguments.output)?;
    let progress = Progress::new(arguments.progress);
    let done = study(&request, &mut |event| {
        match event {
            StudyEvent::Run { table, run } => progress.say(format!("table {table:>2}: {run}")),
            StudyEvent::TableDone(table) => {
                let tally = Tally::of(&table.comparisons);
                progress.line(&format!("table {:>2}: {} ({:.1} s)", table.number, tally.words(), table.seconds));
            }
            StudyEvent::Figure(number) => progress.say(format!("figure {number}")),
            StudyEvent::Step => {}
        }
        ControlFlow::Continue(())
    });
    progress.finish();
    let done = done?;
    let files = write_study(&done, &arguments.output)?;
    let tally = done.tally();
    output::out(&format!("{}\n", tally.words()));
    output::out(&format!("  files        {} in {}\n", files.join(", "), arguments.output.display()));
    output::out(&format!("  read         {}\n", arguments.output.join("report.html").display()));
    Ok(if tally.outside > 0 { code::SHORT } else { 0 })
}
