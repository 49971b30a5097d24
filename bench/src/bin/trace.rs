#[path = "../../../crates/stiction/tests/common/random_case.rs"]
mod random_case;
use std::ops::ControlFlow;
use stiction::io::case;
use stiction::run::{Event, Settings, prepare, solve};
fn main() {
    let seed: u64 = std::env::args().nth(1).unwrap().parse().unwrap();
    let path = std::env::args().nth(2).unwrap_or("multigrid".into());
    let text = random_case::text(seed) + &format!("[solver]\npath = \"{path}\"\n");
    println!("{text}");
    let case = case::parse(&text, "case.toml", &[]).unwrap();
    let prepared = prepare(&case).unwrap();
    println!(
        "points {} unknowns {} motions {}",
        prepared.problem.points(),
        prepared.problem.unknowns(),
        prepared.motions.len()
    );
    let out = solve(&prepared, &Settings::of(&case.solver), &mut |e: &Event| {
        if let Event::Iteration(p) = e {
            println!("{:?} {} {:.3e} o{} st{} sl{}", p.phase, p.iteration, p.residual, p.open, p.stick, p.slip);
        }
        ControlFlow::Continue(())
    })
    .unwrap();
    println!("{:?} {:?} {:?}", out.solution.status, out.solution.certificate, out.solution.counts);
}
