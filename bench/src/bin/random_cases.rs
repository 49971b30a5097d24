//! How many of the cases drawn at random are certified: `random_cases [assemblies] [FIRST LAST [PATH]]`, seeds, 0 to 6000
//! if absent, by the path that the solver chooses itself if none is named. Assemblies have two or three bodies. With
//! `ranks N` in place of the path on so many ranks, which are threads.

use stiction_fixtures::random_assembly;
use stiction_fixtures::random_case::{leaves, outcome, outcome_on_ranks, ranks_refuse, text};

fn main() {
    let mut arguments: Vec<String> = std::env::args().skip(1).collect();
    let assemblies = arguments.first().is_some_and(|first| first == "assemblies");
    arguments.drain(..usize::from(assemblies));
    let numbers: Vec<u64> = arguments.iter().map_while(|a| a.parse().ok()).collect();
    let (first, last) = if let [first, last] = numbers[..] { (first, last) } else { (0, 6000) };
    let after = arguments.iter().skip_while(|a| *a != "ranks").nth(1);
    let ranks: Option<usize> = after.and_then(|size| size.parse().ok());
    let path = arguments
        .get(2)
        .filter(|_| ranks.is_none())
        .map_or(String::new(), |path| format!("[solver]\npath = \"{path}\"\n"));
    let text = |seed| if assemblies { random_assembly::text(seed, &random_assembly::ELEMENTS) } else { text(seed) };
    let (mut steps, mut left, mut unsolved, mut refused, mut by_first) = (Vec::new(), 0, 0, 0, 0);
    for seed in first..last {
        let text = text(seed) + &path;
        let found = match ranks {
            None => outcome(&text),
            Some(size) => outcome_on_ranks(&text, size).map(|(taken, alone)| {
                by_first += usize::from(alone);
                taken
            }),
        };
        match found {
            Ok(taken) => steps.push(taken),
            Err(reason) if leaves(&reason) => left += 1,
            Err(reason) if is_refused(&reason, ranks.is_some()) => {
                refused += 1;
                println!("seed {seed}: {reason}");
            }
            Err(reason) => {
                unsolved += 1;
                println!("seed {seed}: {reason}\n{text}");
            }
        }
    }
    if ranks.is_some() {
        println!("{by_first} of the certified ones by rank 0 alone");
    }
    steps.sort_unstable();
    let share = |part: f64| steps.get((part * steps.len() as f64) as usize).copied().unwrap_or(0);
    println!("{} certified, {left} leave, {refused} not for this path, {unsolved} not solved", steps.len());
    println!(
        "Newton steps or cycles: {} in all; half of the cases take {}, 95 % at most {}, 99 % {}",
        steps.iter().sum::<usize>(),
        share(0.5),
        share(0.95),
        share(0.99)
    );
}

/// Whether the path, or the ranks, are not for the case.
fn is_refused(reason: &str, ranks: bool) -> bool {
    ranks && ranks_refuse(reason) || reason.contains("multigrid") || reason.contains("aggregation")
}
