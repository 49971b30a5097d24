//! Files that do not depend on the solution, written while it is being found.

use std::path::Path;
use std::sync::mpsc;
use std::thread;

use super::beside::joined;
use super::write::encoded;
use crate::Error;
use crate::io::replace::Pending;
use crate::io::vtu::EncodedGrid;
use crate::io::{folder, machine, problem};
use crate::linalg::Watch;
use crate::linalg::memory::Room;
use crate::run::pose::memory::output_room;
use crate::run::pose::{Prepared, Span, place, stopwatch};
use crate::run::solve::{Event, Outcome, Settings, solve};
use crate::solve::SolveEvent;

/// What was written beside the solve and has no name yet, and what is still to be; dropped, it leaves nothing behind.
#[derive(Debug)]
pub struct Ahead {
    /// `problem.npz`, if it was begun.
    pub(crate) problem: Option<Result<Pending, Error>>,
    /// The mesh as `result.vtu` has it.
    pub(crate) grid: Option<EncodedGrid>,
    /// Held until the files are written.
    pub(crate) room: Option<Room>,
    /// Whether pictures are drawn.
    pub(crate) pictures: bool,
}

impl Default for Ahead {
    fn default() -> Self {
        Ahead { problem: None, grid: None, room: None, pictures: true }
    }
}

impl Ahead {
    /// Nothing yet of a run with these settings.
    pub fn of(settings: &Settings) -> Self {
        Ahead { pictures: settings.pictures, ..Ahead::default() }
    }
}

/// [`solve()`](crate::run::solve()) for a run whose results go to `into`: the stiffness, most of what there is to write, is
/// written by a thread of its own while the iteration runs. Results are the same to the bit.
///
/// Nothing is written before the first iteration, so that a run that is left before then leaves no trace. The
/// mesh is encoded for `result.vtu` after it.
///
/// # Errors
/// As `solve`. What goes wrong with the file is returned by [`write_with`](super::write_with).
pub fn solve_writing(
    prepared: &Prepared,
    settings: &Settings,
    into: &Path,
    observer: &mut Watch<Event>,
) -> Result<(Outcome, Ahead), Error> {
    let is_new = !into.exists();
    let room = output_room(&prepared.mesh, settings.pictures, &settings.memory);
    let room = room.map_err(|error| place::at(&prepared.mesh_spot, error))?;
    let (iterating, begin) = mpsc::channel();
    // Nothing in here may use the threads of rayon: the caller may be the only one of them, and it waits.
    let write = move || {
        begin.recv().ok()?;
        let tolerance = settings.solver.tolerance;
        let written = folder::create(into)
            .and_then(|()| problem::begin_problem(&into.join("problem.npz"), &prepared.problem, tolerance));
        // If it does not fit together, writing it returns the error.
        let grid = encoded(prepared, false).ok();
        Some((written, grid, machine::thread_cpu_seconds()))
    };
    let (solved, written, waited) = thread::scope(|scope| {
        // Where no thread can be had all is written afterwards.
        let writer = thread::Builder::new().spawn_scoped(scope, write).ok();
        let solved = solve(prepared, settings, &mut |event| {
            if matches!(event, Event::Solver(SolveEvent::Iteration(_))) {
                // The first is the sign; a writer that has ended already does not mind.
                let _ = iterating.send(());
            }
            observer(event)
        });
        drop(iterating);
        let mut lap = stopwatch();
        let written = writer.and_then(joined);
        (solved, written, lap())
    });
    let mut outcome = match solved {
        Ok(outcome) => outcome,
        Err(error) => {
            // The file goes first: only then is the folder empty.
            drop(written);
            if is_new {
                folder::remove_empty(into);
            }
            return Err(error);
        }
    };
    let mut ahead = Ahead { room: Some(room), ..Ahead::of(settings) };
    if let Some((written, grid, cpu)) = written {
        (ahead.problem, ahead.grid) = (Some(written), grid);
        // The clock of the process has counted it with the iteration.
        let beside = Span { wall: 0.0, cpu: cpu - waited.cpu.min(cpu) };
        outcome.seconds.iteration.cpu -= beside.cpu.min(outcome.seconds.iteration.cpu);
        outcome.seconds.output = outcome.seconds.output + beside + waited;
    }
    Ok((outcome, ahead))
}
