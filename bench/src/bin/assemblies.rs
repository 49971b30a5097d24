//! Solves random assemblies of tet4 and hex8 for a judge: `assemblies FOLDER FIRST LAST`. Of each seed the case is written,
//! and of each answer the posed problem and the solution; a line `answer NAME t STATUS` stands for each on standard
//! output, and `end SEED REASON` ends a seed. `bench/campaigns/assemblies/judge.py` reads them.

use std::error::Error;
use std::fs;
use std::path::Path;

use stiction::io::problem::{write_problem, write_solution};
use stiction_fixtures::random_assembly::text;
use stiction_fixtures::random_case::solved;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [folder, first, last] = &arguments[..] else { return Err("give FOLDER FIRST LAST".into()) };
    let folder = Path::new(folder);
    for seed in first.parse::<u64>()?..last.parse()? {
        let text = text(seed, &["tet4", "hex8"]);
        fs::write(folder.join(format!("{seed}.toml")), &text)?;
        let (mut number, mut lines) = (0, Ok(String::new()));
        let reason = solved(&text, &mut |t, prepared, outcome| {
            number += 1;
            let name = format!("{seed}-{number}");
            let file = |kind: &str| folder.join(format!("{name}-{kind}.npz"));
            let solution = &outcome.solution;
            let written = write_problem(&file("problem"), &prepared.problem, solution.certificate.tolerance)
                .and_then(|()| write_solution(&file("solution"), &solution.u, &solution.lambda));
            match (&mut lines, written) {
                (Ok(lines), Ok(())) => *lines += &format!("answer {name} {t} {:?}\n", solution.status),
                (Ok(_), Err(error)) => lines = Err(error),
                (Err(_), _) => {}
            }
        });
        print!("{}", lines?);
        println!("end {seed} {}", reason.err().unwrap_or_else(|| "Solved".into()).replace('\n', " "));
    }
    Ok(())
}
