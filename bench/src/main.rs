//! Times the whole run on the model brick of the source paper, from case file to result folder, phase by phase, and
//! prints each as a ratio to one factorisation and one solve of the same stiffness matrix in the same process. CPU
//! time of the process, system included, since machines are shared; everything runs on one thread.
//!
//! Usage: `cargo run --release -p stiction-bench [cells across ...]`, by default 4 8 16 24.

use std::error::Error;
use std::ops::ControlFlow;

use cpu_time::ProcessTime;
use stiction::SolveEvent;
use stiction::contact::ContactProblem;
use stiction::dual::{Dual, DualSettings, choose};
use stiction::io::case;
use stiction::linalg::Csr;
use stiction::run::{self, Event};

fn main() -> Result<(), Box<dyn Error>> {
    let given: Result<Vec<usize>, _> = std::env::args().skip(1).map(|a| a.parse()).collect();
    let sizes = match given?.as_slice() {
        [] => vec![4, 8, 16, 24],
        list => list.to_vec(),
    };
    rayon::ThreadPoolBuilder::new().num_threads(1).build_global()?;
    println!("model brick, six tetrahedra a cell, Coulomb friction 0.35, tolerance 1e-8, one thread");
    println!("reference: numeric factorisation and one solve of K; columns after it are ratios to it\n");
    println!(
        "| cells | unknowns | points | reference s | run s | solve / ref | run / ref | order | factor | newton | coulomb | assembly | output | steps or cycles | products | path | worst |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    for n in sizes {
        row(n)?;
    }
    Ok(())
}

fn row(n: usize) -> Result<(), Box<dyn Error>> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../cases/brick/brick.toml");
    let cells = ("mesh.block.cells".to_string(), format!("[{}, {n}, {n}]", 3 * n));
    let case = case::read(path, &[cells])?;
    let folder = std::env::temp_dir().join(format!("stiction-bench-{n}"));
    let start = ProcessTime::now();
    let prepared = run::prepare(&case)?;
    // CPU seconds at the borders of the phases.
    let mut marks = Vec::new();
    let mut observe = |event: &Event| {
        if !matches!(event, Event::Solver(SolveEvent::Iteration(_))) {
            marks.push(start.elapsed().as_secs_f64());
        }
        ControlFlow::Continue(())
    };
    let mut outcome = run::solve(&prepared, &run::Settings::of(&case.solver), &mut observe)?;
    marks.push(start.elapsed().as_secs_f64());
    let origin = run::Origin { case_text: std::fs::read_to_string(path)?, ..Default::default() };
    run::write(&prepared, &mut outcome, &origin, &folder)?;
    let whole = start.elapsed().as_secs_f64();
    std::fs::remove_dir_all(&folder)?;
    let reference = reference(&prepared.problem)?;
    let [assembly, ordered, factored, solved, end] = match marks[..] {
        // The set-up of multigrid stands in the place of the factorisation.
        [assembly, set_up, end] => [assembly, assembly, set_up, end, end],
        [a, b, c, d, e] => [a, b, c, d, e],
        _ => return Err("an unknown phase of the run".into()),
    };
    let phases = [
        end - assembly,
        whole,
        ordered - assembly,
        factored - ordered,
        solved - factored,
        end - solved,
        assembly,
        whole - end,
    ];
    let ratios: Vec<String> = phases.iter().map(|seconds| format!("{:.2}", seconds / reference)).collect();
    println!(
        "| {}x{n}x{n} | {} | {} | {reference:.3} | {whole:.2} | {} | {} | {} | {:?} | {:.1e} |",
        3 * n,
        prepared.problem.unknowns(),
        prepared.problem.points(),
        ratios.join(" | "),
        outcome.solution.counts.newton_steps.max(outcome.solution.counts.cycles),
        outcome.solution.counts.products,
        outcome.solution.path,
        outcome.solution.certificate.worst,
    );
    Ok(())
}

/// CPU seconds of one numeric factorisation of `K` in its best order and one solve; the better of two.
fn reference(problem: &ContactProblem) -> Result<f64, Box<dyn Error>> {
    let n = problem.unknowns();
    let given = problem.elastic.clone();
    let mut elastic = ContactProblem::from_matrices(given.K, given.f, Csr::zero(0, n), vec![], vec![]);
    elastic.elastic.node_of = given.node_of;
    let mut best = f64::INFINITY;
    for _ in 0..2 {
        let choice = choose(&elastic, &DualSettings::default())?;
        let start = ProcessTime::now();
        let factor = Dual::new(&elastic, choice)?;
        let u = factor.displacement(&elastic, &[]);
        assert!(u.iter().all(|x| x.is_finite()));
        best = best.min(start.elapsed().as_secs_f64());
    }
    Ok(best)
}
