//! What the stopping rule of the source paper's fixed point misses (Haslinger, Kucera & Dostal 2004, eq. 6.3): the brick
//! on partition 2, N = 2, against the fixed point of the same polygon found by another road (MSA1, tolerance 1e-9).
//!
//! ```sh
//! cargo run --release -p stiction --example stopping_rules
//! ```
//! What to see: with the penalty 1e-10 the bounds g stop changing long before the copies of the forces agree. What to
//! try next: another tolerance, or `stiction solve --method cfs1`, whose certificate tells.

use std::ops::ControlFlow::Continue;

use stiction::dual::{Dual, DualSettings, choose};
use stiction::friction::{Given, Method, MethodSettings, Quadratic, Splitting, Start, run_method};
use stiction::{io::case, linalg::norm, run::prepare};

const BRICK: &str = r#"
mesh = { block = { size = [3, 1, 1], cells = [24, 8, 8], element = "tet4", split = "five", parity = 0 } }
materials = { steel = { young = 21.19e10, poisson = 0.277 } }
fix = [{ on = "x-min" }]
load = [{ on = "x-max", traction = [0, 0, "4.0 * 1e6"] },
        { on = "z-max", traction = [0, 0, "-4.0 * 2/3 * 1e6 * (3 - x)"] }]
contact = [{ on = "z-min", against = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }, friction = { coulomb = 0.35 } }]
"#;

fn main() -> Result<(), stiction::Error> {
    let problem = prepare(&case::parse(BRICK, "brick", &[])?)?.problem;
    let dual = Dual::new(&problem, choose(&problem, &DualSettings::default())?)?;
    let q = Quadratic::new(&problem, &dual);
    let run = |settings: &MethodSettings| run_method(&q, &problem.contact.friction, settings, &mut |_| Continue(()));
    let other = MethodSettings::new(Method::FixedPoint(Given::AdaptiveUzawa));
    let exact = run(&MethodSettings { tolerance: 1e-9, inner_tolerance: 1e-11, ..other })?.slip_bound;

    println!("method   rho        Iter   last change of g   copies disagree   error of g");
    let runs = [
        ("CFS1", Method::cfs1(Splitting::No), 0.7e-10),
        ("CFS2", Method::cfs2(), 0.7e-10),
        ("CFS2", Method::cfs2(), 0.7e-8),
    ];
    for (name, method, rho) in runs {
        let start = Start { slip_bound: Some(vec![5.25e4; problem.points()]), ..Start::default() };
        let settings = MethodSettings { inner_tolerance: 1e-7, start, ..MethodSettings::published(method, 2, rho) };
        let found = run(&settings)?;
        let wrong: Vec<f64> = found.slip_bound.iter().zip(&exact).map(|(a, b)| a - b).collect();
        let (error, last) = (norm(&wrong) / norm(&exact), found.history.last().map_or(f64::NAN, |step| step.change));
        let (iterations, apart) = (found.counts.iterations, found.disagreement);
        println!("{name:<8} {rho:<8.1e} {iterations:>6}   {last:>16.1e}   {apart:>15.1e}   {error:>10.1e}");
        // The contraction of the fixed point is 0.12: if g alone were wrong, its error would be about its last change.
        assert!(last <= 1e-6 && (rho > 1e-9 || error > 1e3 * last));
    }
    Ok(())
}
