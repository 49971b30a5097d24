//! `stiction paper`: the source paper's twelve tables and six figures beside its published numbers.
//!
//! It uses the public functions of the library alone. [`study()`] runs what was asked for, `write` writes the report. `published` has the tables as printed,
//! `choices` what the paper leaves open and how it was filled in, `experiment` the runs behind each table and the bands
//! in which our numbers are expected, `laboratory` runs them.

mod choices;
mod command;
mod compare;
mod experiment;
mod figures;
mod grid;
mod known;
mod laboratory;
mod model;
mod published;
mod report_csv;
mod report_html;
mod report_md;
mod sketches;
mod study;
mod tables;
#[cfg(test)]
mod tests;
mod write;

use std::ops::ControlFlow;
use std::time::Instant;

use stiction::Error;

use choices::Setting;
pub use command::{Arguments, run};
use laboratory::{Benches, Laboratory};
use model::Brick;
use published::published;
use study::{Study, TableReport};

/// How many tables and figures the paper has.
pub const TABLES: usize = 12;
pub const FIGURES: usize = 6;

/// What to run.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Request {
    /// Numbers of tables, 1 to 12.
    pub tables: Vec<usize>,
    /// Numbers of figures, 1 to 6.
    pub figures: Vec<usize>,
    /// Only the fitted setting, and of the tables only the lines that are judged: what can be run after every change.
    pub quick: bool,
}

impl Request {
    /// Checks that the paper has these tables and figures.
    ///
    /// # Errors
    /// If it has not, with what it has.
    pub fn validate(&self) -> Result<(), Error> {
        ascending(&self.tables, TABLES, "table")?;
        ascending(&self.figures, FIGURES, "figure").map(|_| ())
    }
}

/// What is going on; reported to the observer, whose `Break` ends the study.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum StudyEvent<'a> {
    /// A run of table `table` begins.
    Run {
        table: usize,
        run: &'a str,
    },
    /// A run goes on.
    Step,
    TableDone(&'a TableReport),
    Figure(usize),
}

/// Runs tables and figures in ascending order.
///
/// # Errors
/// If a number is not one of the paper's, memory runs out, or the observer asks to stop.
pub fn study(request: &Request, observer: &mut dyn FnMut(StudyEvent) -> ControlFlow<()>) -> Result<Study, Error> {
    let start = Instant::now();
    let tables = ascending(&request.tables, TABLES, "table")?;
    let figures = ascending(&request.figures, FIGURES, "figure")?;
    let tables = run_tables(&tables, request.quick, observer)?;
    let mut solution = None;
    let mut drawn = Vec::new();
    for number in figures {
        if observer(StudyEvent::Figure(number)).is_break() {
            return Err(laboratory::interrupted());
        }
        drawn.extend(figures::figure(number, &mut solution)?);
    }
    Ok(Study { tables, figures: drawn, quick: request.quick, seconds: start.elapsed().as_secs_f64() })
}

fn run_tables(
    numbers: &[usize],
    quick: bool,
    observer: &mut dyn FnMut(StudyEvent) -> ControlFlow<()>,
) -> Result<Vec<TableReport>, Error> {
    let benches = Benches::new(&bricks(numbers, quick))?;
    let mut done = Vec::new();
    let current = std::cell::Cell::new(0);
    let observer = std::cell::RefCell::new(observer);
    let mut observe = |run: &str| match run {
        "" => (observer.borrow_mut())(StudyEvent::Step),
        run => (observer.borrow_mut())(StudyEvent::Run { table: current.get(), run }),
    };
    let mut laboratory = Laboratory::new(&benches, &mut observe);
    for table in numbers.iter().filter_map(|&number| published(number)) {
        current.set(table.number);
        let report = tables::table(&table, quick, &mut laboratory)?;
        if (observer.borrow_mut())(StudyEvent::TableDone(&report)).is_break() {
            return Err(laboratory::interrupted());
        }
        done.push(report);
    }
    Ok(done)
}

/// The bricks that the tables need.
fn bricks(tables: &[usize], quick: bool) -> Vec<Brick> {
    let mut bricks = Vec::new();
    for table in tables.iter().filter_map(|&number| published(number)) {
        for Setting { load, parity, .. } in tables::settings(table.number, quick) {
            for line in experiment::plan(&table).lines {
                let brick = Brick { partition: line.experiment.partition, parity, load };
                if !bricks.contains(&brick) {
                    bricks.push(brick);
                }
            }
        }
    }
    bricks
}

/// The numbers in ascending order, each once.
fn ascending(numbers: &[usize], last: usize, name: &str) -> Result<Vec<usize>, Error> {
    if let Some(wrong) = numbers.iter().find(|&&n| n == 0 || n > last) {
        let what = format!("the paper has no {name} {wrong}");
        return Err(Error::new(format!("--{name} {wrong}"), what, format!("its {name}s are 1 to {last}")));
    }
    let mut numbers = numbers.to_vec();
    numbers.sort_unstable();
    numbers.dedup();
    Ok(numbers)
}
