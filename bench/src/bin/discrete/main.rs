//! Times discrete frictional contact problems from files beside the best times known for Siconos.
//!
//! Usage: `cargo run --release -p stiction-bench --bin discrete -- FOLDER-OR-FILES`. CPU seconds of one thread, the
//! median of several runs, from the problem in memory to the judged answer; reading is not counted.
//!
//! `-- --profile DOCS FOLDER-OR-FILES` solves them and problems made here by each method and writes
//! `DOCS/algebraic-profile.md` and `.png`; `-- --random` counts how many random piles are solved;
//! `-- --forms CELLS...` solves bricks with `W` formed and not.

mod forms;
mod profile;
mod random;

use std::error::Error;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use cpu_time::ProcessTime;
use stiction::discrete::{DiscreteProblem, Form, Method, Settings, Status, prepare};
use stiction::run::algebraic;
use stiction_fixtures::piles::{Normals, pile};

/// Siconos 4.4.0, the best of its solvers, user seconds to 1e-8 by the first measure, one thread, busy machine (a
/// factor of two either way): begin of the name, seconds, solver.
const SICONOS: [(&str, f64, &str); 6] = [
    ("KaplasTower", 0.052, "proximal + Newton"),
    ("Capsules-i125", 0.020, "best"),
    ("Spheres-i099", 0.005, "best"),
    ("Confeti-ex03", 0.001, "best"),
    ("BoxesStack1", 0.0097, "best"),
    ("OneObject-i1028", 0.001, "best"),
];

const RUNS: usize = 9;

fn main() -> Result<(), Box<dyn Error>> {
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global()?;
    let mut arguments = std::env::args().skip(1).peekable();
    match arguments.peek().map(String::as_str) {
        Some("--profile") => {
            let docs = arguments.nth(1).map(PathBuf::from).ok_or("name the folder for the table and the picture")?;
            write_profile(&docs, &files(arguments)?)
        }
        Some("--forms") => forms::compare(arguments.skip(1)),
        Some("--random") => random::count(),
        _ => compare(&files(arguments)?),
    }
}

fn files(arguments: impl Iterator<Item = String>) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let mut files = Vec::new();
    for path in arguments.map(PathBuf::from) {
        if path.is_dir() {
            files.extend(std::fs::read_dir(path)?.map(|e| Ok(e?.path())).collect::<Result<Vec<_>, std::io::Error>>()?);
        } else {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

fn name(file: &Path) -> String {
    file.file_stem().map_or(String::new(), |n| n.to_string_lossy().into_owned())
}

fn write_profile(docs: &Path, files: &[PathBuf]) -> Result<(), Box<dyn Error>> {
    let mut problems = Vec::new();
    for file in files {
        problems.push((name(file), algebraic::read(file)?.problem));
    }
    for (cells, mu, element) in [(4, 0.35, "tet4"), (6, 0.1, "tet4"), (8, 0.35, "tet4"), (6, 0.8, "hex8")] {
        problems.push((format!("brick {cells} {element} {mu}"), forms::brick(cells, mu, element)?));
    }
    for (bodies, contacts, mu, seed) in [(30, 100, 0.3, 1), (30, 100, 0.7, 2), (60, 200, 1.0, 3), (200, 700, 0.5, 4)] {
        let pile = DiscreteProblem::Global(pile(bodies, contacts, mu, Normals::Apart, seed));
        problems.push((format!("pile {bodies} {contacts} {mu}"), pile));
    }
    let times = profile::measure(&problems)?;
    let command = "cargo run --release -p stiction-bench --bin discrete -- --profile docs FOLDER";
    std::fs::write(docs.join("algebraic-profile.md"), profile::table(&times, command))?;
    profile::draw(&times, &docs.join("algebraic-profile.png"))
}

fn compare(files: &[PathBuf]) -> Result<(), Box<dyn Error>> {
    println!("| problem | contacts | Newton steps | seconds | Siconos | ratio | worst residual | status |");
    println!("|---|---|---|---|---|---|---|---|");
    let (mut own, mut theirs) = (0.0, 0.0);
    for file in files {
        let name = name(file);
        let contents = algebraic::read(file)?;
        let mut seconds = Vec::new();
        let mut last = None;
        for _ in 0..RUNS {
            let start = ProcessTime::now();
            let prepared = prepare(&contents.problem, Form::Auto, Method::Auto)?;
            let solution = prepared.solve(&Settings::default(), &mut |_| ControlFlow::Continue(()))?;
            seconds.push(start.elapsed().as_secs_f64());
            last = Some(solution);
        }
        seconds.sort_by(f64::total_cmp);
        let Some(solution) = last else { continue };
        let median = seconds[RUNS / 2];
        let known = SICONOS.iter().find(|(begin, ..)| name.starts_with(begin));
        let (time, ratio) = known.map_or(("-".to_string(), "-".to_string()), |(_, time, solver)| {
            (format!("{time} ({solver})"), format!("{:.2}", median / time))
        });
        if let (Some((_, time, _)), Status::Solved) = (known, solution.status) {
            own += median;
            theirs += time;
        }
        println!(
            "| {name} | {} | {} | {median:.5} | {time} | {ratio} | {:.1e} | {:?} |",
            contents.problem.points(),
            solution.counts.newton_steps,
            solution.measures.worst(),
            solution.status,
        );
    }
    println!("\nwhere both are known: {own:.4} s against {theirs:.4} s");
    Ok(())
}
