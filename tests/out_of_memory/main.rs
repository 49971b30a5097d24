//! Runs that find no memory end with an error. A program of its own, since its allocator fails: an allocation of 1 MB or more
//! that nobody has asked for before would abort it.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use stiction::Error;
use stiction::io::case::{self, Case};
use stiction::run::{
    Event, Origin, Prepared, Settings, Step, begin_steps, check, keep_step, prepare, solve, solve_steps, solve_writing,
    write_report_on, write_with,
};
use stiction_fixtures::failing::{Failing, limited};

#[global_allocator]
static ALLOCATOR: Failing = Failing;

/// Limits tried for each case, evenly from nothing to what the run takes without a limit.
const LIMITS: usize = 6;

/// The solution alone, without what its files take.
fn solution(case: &Case, folder: &Path) -> Result<(), Error> {
    let prepared = prepare(case)?;
    if !case.steps.is_empty() {
        return run(case, folder);
    }
    solve(&prepared, &Settings::of(&case.solver), &mut |_: &Event| ControlFlow::Continue(())).map(drop)
}

/// The whole of a run, as the command does it.
fn run(case: &Case, folder: &Path) -> Result<(), Error> {
    let mut prepared = prepare(case)?;
    let settings = Settings::of(&case.solver);
    let go_on = &mut |_: &Event| ControlFlow::Continue(());
    let (mut outcome, ahead) = if case.steps.is_empty() {
        solve_writing(&prepared, &settings, folder, go_on)?
    } else {
        let (mut files, _) = begin_steps(&prepared, folder, false)?;
        let mut keep = |prepared: &Prepared, step: &Step| keep_step(&mut files, prepared, step);
        (solve_steps(&mut prepared, &settings, None, &mut keep, go_on)?, Default::default())
    };
    write_with(&prepared, &mut outcome, &Origin::default(), folder, ahead)?;
    write_report_on(folder, Some(&prepared.mesh))?;
    assert!(check(folder)?.passed());
    Ok(())
}

/// Whether an error speaks of memory and says what to do.
fn is_of_memory(error: &Error) -> bool {
    error.what.contains("needs ") && error.remedy.contains("memory")
}

type Work = fn(&Case, &Path) -> Result<(), Error>;

#[test]
fn the_shipped_cases_end_with_an_answer_or_an_error_whatever_the_memory() {
    let base = Path::new(env!("CARGO_MANIFEST_DIR")).join("../cases");
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("out-of-memory");
    let mut cases = 0;
    for entry in std::fs::read_dir(&base).unwrap().flatten().filter(|entry| entry.path().is_dir()) {
        let name = entry.file_name().into_string().unwrap();
        let case = case::read(entry.path().join(format!("{name}.toml")), &[]).unwrap();
        let at = |limit: usize, work: Work| {
            let _ = std::fs::remove_dir_all(&folder);
            std::fs::create_dir_all(&folder).unwrap();
            limited(limit, || work(&case, &folder))
        };
        let (ended, without) = at(usize::MAX, run);
        assert_eq!((ended, without.refused), (Ok(()), 0), "{name}");
        let tries = (0..LIMITS).map(|k| (k, solution as Work)).chain([(LIMITS / 2, run as Work)]);
        let mut errors = 0;
        for (k, work) in tries {
            let limit = without.most * k / LIMITS;
            let (ended, within) = at(limit, work);
            if let Err(error) = ended {
                assert!(is_of_memory(&error) && within.refused > 0, "{name} in {limit} bytes: {error}");
                errors += 1;
            }
        }
        // Otherwise the limits would limit nothing.
        assert!(errors > 0, "{name}");
        cases += 1;
    }
    assert!(cases >= 14, "{cases}");
}
