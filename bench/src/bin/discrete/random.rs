//! Piles with random normals: how many are solved, and whether the others have a solution.

use std::error::Error;
use std::ops::ControlFlow;

use stiction::discrete::{DiscreteProblem, Settings, Status, condense, solve};
use stiction_fixtures::piles::{Normals, pile};

/// Bodies and contacts; of the last three each body has some sixteen contacts and is wedged.
const SIZES: [(usize, usize); 6] = [(10, 30), (30, 100), (60, 200), (10, 80), (20, 160), (30, 240)];
const FRICTION: [f64; 3] = [0.3, 0.7, 1.0];
const SEEDS: u64 = 6;

pub fn count() -> Result<(), Box<dyn Error>> {
    println!("| bodies | contacts | mu | seed | iterations | Newton steps | worst residual | max r | status |");
    println!("|---|---|---|---|---|---|---|---|---|");
    let mut counts = Vec::new();
    for (bodies, contacts) in SIZES {
        let (mut solved, mut all) = (0, 0);
        for mu in FRICTION {
            for seed in 1..=SEEDS {
                let pile = DiscreteProblem::Global(pile(bodies, contacts, mu, Normals::Random, seed));
                let condensed = condense(&pile)?;
                let found = solve(&condensed.local, &Settings::default(), &mut |_| ControlFlow::Continue(()))?;
                all += 1;
                solved += usize::from(found.status == Status::Solved);
                println!(
                    "| {bodies} | {contacts} | {mu} | {seed} | {} | {} | {:.1e} | {:.1e} | {:?} |",
                    found.counts.iterations,
                    found.counts.newton_steps,
                    found.measures.worst(),
                    found.r.iter().fold(0.0f64, |a, r| a.max(r.abs())),
                    found.status
                );
            }
        }
        counts.push((bodies, contacts, solved, all));
    }
    for (bodies, contacts, solved, all) in counts {
        println!("{bodies} bodies, {contacts} contacts: {solved} of {all} solved");
    }
    Ok(())
}
