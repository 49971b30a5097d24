//! Solves cases on their meshes and on the same meshes with nodes and cells in another order, and compares nodal contact
//! forces and displacements.
//!
//! Usage: `renumbered [--seed S] [--tolerance T] [--bound B] CASE...`: the cases are solved to T (1e-12 if absent) and the
//! answers may differ by B (1e-9) of the largest. The exit code is 1 if one differs by more.

use std::error::Error;
use std::path::PathBuf;
use std::process::ExitCode;

use stiction_fixtures::renumbered::compare;

fn main() -> Result<ExitCode, Box<dyn Error>> {
    let (mut seed, mut tolerance, mut bound, mut cases) = (1, 1e-12, 1e-9, Vec::new());
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let mut value = || arguments.next().ok_or(format!("{argument} needs a value"));
        match argument.as_str() {
            "--seed" => seed = value()?.parse()?,
            "--tolerance" => tolerance = value()?.parse()?,
            "--bound" => bound = value()?.parse()?,
            _ => cases.push(PathBuf::from(argument)),
        }
    }
    let mut differ = 0;
    for case in &cases {
        let told = match compare(case, tolerance, seed) {
            Ok(found) => {
                let same = found.forces <= bound && found.displacements <= bound;
                differ += usize::from(!same);
                let verdict = if same { "" } else { ": DIFFERS" };
                format!(
                    "{} steps, contact forces {:.1e}, displacements {:.1e}{verdict}",
                    found.steps, found.forces, found.displacements
                )
            }
            Err(error) => {
                differ += 1;
                format!("NOT COMPARED: {error}")
            }
        };
        println!("{} renumbered: {told}", case.display());
    }
    println!("{} cases renumbered, {differ} differ", cases.len());
    Ok(if differ == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
