//! How far the polygon of 4 N sides that replaces the disc of friction in Haslinger, Kucera & Dostal (2004) leads from
//! the solution on the disc: the paper's brick, partition 1, against Newton's method on the disc itself.
//!
//! ```sh
//! cargo run --release -p stiction --example polygon_error
//! ```
//! What to see: doubling N halves the error of the multipliers (the paper states 1/N) and quarters that of the energy.
//! What to try next: `parity = 1` in the case, another coefficient, the printed loads (`1.0` for `4.0`).

use std::ops::ControlFlow::Continue;

use stiction::dual::{Dual, DualSettings, choose};
use stiction::friction::{Given, Method, MethodSettings, Quadratic, Settings, run_method, solve};
use stiction::{io::case, linalg::dot, linalg::norm, run::prepare};

const BRICK: &str = r#"
mesh = { block = { size = [3, 1, 1], cells = [12, 4, 4], element = "tet4", split = "five", parity = 0 } }
materials = { steel = { young = 21.19e10, poisson = 0.277 } }
fix = [{ on = "x-min" }]
load = [{ on = "x-max", traction = [0, 0, "4.0 * 1e6"] },
        { on = "z-max", traction = [0, 0, "-4.0 * 2/3 * 1e6 * (3 - x)"] }]
contact = [{ on = "z-min", against = { plane = { point = [0, 0, 0], normal = [0, 0, 1] } }, friction = { FRICTION } }]
"#;

fn main() -> Result<(), stiction::Error> {
    let given = Given::AdaptiveUzawa;
    let runs = [
        ("given friction, 5.25e4 N a node", "tresca = 5.25e4, nodal = true", Method::Given(given)),
        ("Coulomb friction, 0.35", "coulomb = 0.35", Method::FixedPoint(given)),
    ];
    for (name, friction, method) in runs {
        let problem = prepare(&case::parse(&BRICK.replace("FRICTION", friction), "brick", &[])?)?.problem;
        let dual = Dual::new(&problem, choose(&problem, &DualSettings::default())?)?;
        let q = Quadratic::new(&problem, &dual);
        let energy = |lambda: &[f64]| 0.5 * dot(lambda, &q.times(lambda)) - dot(&q.h, lambda);
        let newton = Settings { tolerance: 1e-11, ..Settings::default() };
        let disc = solve(&problem, &dual, &newton, &mut |_| Continue(())).lambda;
        println!("{name}\n   N   error of lambda   times N   error of energy   times N^2");
        let mut errors = Vec::new();
        for squares in [2, 4, 8, 16, 32, 64] {
            let settings =
                MethodSettings { squares, tolerance: 1e-9, inner_tolerance: 1e-11, ..MethodSettings::new(method) };
            let lambda = run_method(&q, &problem.contact.friction, &settings, &mut |_| Continue(()))?.lambda;
            let n = squares as f64;
            let difference: Vec<f64> = lambda.iter().zip(&disc).map(|(a, b)| a - b).collect();
            let (error, energy) = (norm(&difference) / norm(&disc), (energy(&lambda) / energy(&disc) - 1.0).abs());
            println!("{squares:>4}   {error:>15.2e}   {:>7.3}   {energy:>15.2e}   {:>9.5}", error * n, energy * n * n);
            errors.push(error);
        }
        // Section 4.1 of the paper: the difference is of the order 1/N.
        assert!(errors[5] * 64.0 < 2.0 * errors[1] * 4.0, "the error does not fall as 1/N: {errors:?}");
    }
    Ok(())
}
