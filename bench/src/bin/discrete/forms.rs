//! Bricks of finite elements as global problems: `W` formed, and velocities kept as unknowns.

use std::error::Error;
use std::ops::ControlFlow;

use cpu_time::ProcessTime;
use stiction::discrete::DiscreteProblem;
use stiction::discrete::{Form, Method, Settings, prepare};
use stiction::io::case;
use stiction::linalg::norm;
use stiction::run;
use stiction_fixtures::case_run::CASE;
use stiction_fixtures::piles::global_of;

const MU: f64 = 0.35;
/// `W` of more points is not formed here: 9 entries a pair of points.
const MOST_CONDENSED: usize = 1500;

/// The brick of the source paper under a load that lifts one end and turns it, `cells` across.
pub fn brick(cells: usize, mu: f64, element: &str) -> Result<DiscreteProblem, Box<dyn Error>> {
    let text = CASE
        .replace("[9, 3, 3]", &format!("[{}, {cells}, {cells}]", 3 * cells))
        .replace("hex8", element)
        .replace("[0, 0, 1e6]", "[0, 0, \"1e6*(z - 0.5) + 2e5\"]")
        .replace("0.35", &format!("{mu:?}"));
    let prepared = run::prepare(&case::parse(&text, "brick", &[])?)?;
    Ok(DiscreteProblem::Global(global_of(&prepared.problem)))
}

pub fn compare(cells: impl Iterator<Item = String>) -> Result<(), Box<dyn Error>> {
    println!("| unknowns | points | form | preparation s | iteration s | Newton steps | equilibrium | worst | apart |");
    println!("|---|---|---|---|---|---|---|---|---|");
    for cells in cells {
        let problem = brick(cells.parse()?, MU, "hex8")?;
        let DiscreteProblem::Global(global) = &problem else { continue };
        let mut first: Option<Vec<f64>> = None;
        for form in [Form::Condensed, Form::Sparse, Form::Auto] {
            if form == Form::Condensed && problem.points() > MOST_CONDENSED {
                continue;
            }
            let start = ProcessTime::now();
            let prepared = prepare(&problem, form, Method::Auto)?;
            let preparation = start.elapsed().as_secs_f64();
            let found = prepared.solve(&Settings::default(), &mut |_| ControlFlow::Continue(()))?;
            let iteration = start.elapsed().as_secs_f64() - preparation;
            let recovered = prepared.recover(&found.r);
            let apart = first.as_ref().map_or(0.0, |first| {
                let change: Vec<f64> = found.r.iter().zip(first).map(|(a, b)| a - b).collect();
                norm(&change) / norm(first)
            });
            let taken = if prepared.condensed().is_some() { "condensed" } else { "sparse" };
            let name = if form == Form::Auto { format!("auto: {taken}") } else { taken.to_string() };
            println!(
                "| {} | {} | {name} | {preparation:.3} | {iteration:.3} | {} | {:.1e} | {:.1e} | {apart:.1e} |",
                global.f.len(),
                problem.points(),
                found.counts.newton_steps,
                recovered.equilibrium,
                prepared.measures(&found.r, &recovered.u).worst()
            );
            first.get_or_insert(found.r);
        }
    }
    Ok(())
}
