//! Performance profiles (Dolan & More 2002): for each method the share of problems solved within a factor of the
//! fastest method's time.

use std::error::Error;
use std::fmt::Write as _;
use std::ops::ControlFlow;
use std::path::Path;

use cpu_time::ProcessTime;
use stiction::discrete::DiscreteProblem;
use stiction::discrete::{Form, Method, Settings, Status, prepare};
use stiction::io::plot::{Align, Drawing};

/// A solve ends after so many CPU seconds.
const LIMIT: f64 = 5.0;
/// Solves shorter than this are repeated, and the shortest time counts.
const SHORT: f64 = 0.05;
const REPEATS: usize = 5;
pub const TOLERANCES: [f64; 2] = [1e-4, 1e-8];

/// CPU seconds by tolerance, problem and method; infinite where the method did not get there.
pub struct Times {
    pub problems: Vec<String>,
    pub seconds: [Vec<[f64; Method::ALL.len()]>; TOLERANCES.len()],
}

/// Solves each problem by each method to each tolerance.
pub fn measure(problems: &[(String, DiscreteProblem)]) -> Result<Times, Box<dyn Error>> {
    let mut times = Times { problems: Vec::new(), seconds: [Vec::new(), Vec::new()] };
    for (name, problem) in problems {
        times.problems.push(name.clone());
        for (tolerance, rows) in TOLERANCES.iter().zip(&mut times.seconds) {
            let mut row = [f64::INFINITY; Method::ALL.len()];
            for (method, best) in Method::ALL.into_iter().zip(&mut row) {
                for _ in 0..REPEATS {
                    let seconds = time(problem, method, *tolerance)?;
                    *best = best.min(seconds);
                    if *best > SHORT {
                        break;
                    }
                }
            }
            eprintln!("{name} to {tolerance:.0e}: {row:.4?}");
            rows.push(row);
        }
    }
    Ok(times)
}

fn time(problem: &DiscreteProblem, method: Method, tolerance: f64) -> Result<f64, Box<dyn Error>> {
    let settings = Settings { tolerance, method, max_iterations: usize::MAX, ..Settings::default() };
    let start = ProcessTime::now();
    let solution = prepare(problem, Form::Auto, method)?.solve(&settings, &mut |_| {
        if start.elapsed().as_secs_f64() > LIMIT { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    })?;
    let seconds = start.elapsed().as_secs_f64();
    Ok(if solution.status == Status::Solved { seconds } else { f64::INFINITY })
}

/// How often `method` is within `factor` of the fastest, among the problems that some method solves.
fn share(rows: &[[f64; Method::ALL.len()]], method: usize, factor: f64) -> f64 {
    let solved: Vec<(f64, f64)> = rows
        .iter()
        .map(|row| (row[method], row.iter().copied().fold(f64::INFINITY, f64::min)))
        .filter(|(_, best)| best.is_finite())
        .collect();
    solved.iter().filter(|(own, best)| *own <= factor * best).count() as f64 / solved.len().max(1) as f64
}

/// The table and what it means, as Markdown.
pub fn table(times: &Times, command: &str) -> String {
    let mut text = format!(
        "# Methods for problems given as matrices\n\n\
         Written by\n\n```sh\n{command}\n```\n\n\
         CPU seconds of one thread from the problem in memory (condensing included) to the judged answer: all three \
         residuals at most the tolerance. A dash: not within {LIMIT} s. Seconds belong to one machine, their ratios \
         travel better. `stiction algebraic --method NAME` chooses a method; `auto` is the default. `brick` are \
         finite-element problems (cells across, coefficient of friction), `pile` rigid bodies (bodies, contacts, \
         coefficient).\n\n\
         ![Performance profiles](algebraic-profile.png)\n\n\
         Share of problems solved within a factor of the fastest method's time (Dolan & More 2002).\n"
    );
    for (tolerance, rows) in TOLERANCES.iter().zip(&times.seconds) {
        let _ = write!(text, "\n## To {tolerance:.0e}\n\n| problem |");
        Method::ALL.iter().for_each(|m| text += &format!(" {} |", m.name()));
        text += "\n|---|";
        Method::ALL.iter().for_each(|_| text += "---|");
        for (name, row) in times.problems.iter().zip(rows) {
            let _ = write!(text, "\n| {name} |");
            for seconds in row {
                text += &if seconds.is_finite() { format!(" {seconds:.2e} |") } else { " - |".to_string() };
            }
        }
        for (what, factor) in [("fastest", 1.0), ("within 10 times", 10.0), ("solved", f64::MAX)] {
            let _ = write!(text, "\n| **{what}** |");
            (0..Method::ALL.len()).for_each(|m| text += &format!(" {:.0} % |", 100.0 * share(rows, m, factor)));
        }
        text.push('\n');
    }
    text
}

const INK: [u8; 3] = [40, 40, 40];
const GRID: [u8; 3] = [225, 225, 225];
const COLORS: [[u8; 3]; 5] = [[0, 92, 158], [120, 180, 220], [192, 57, 43], [39, 140, 80], [220, 140, 20]];
/// The largest factor shown, as a power of two.
const TWOS: usize = 14;

/// Draws one panel a tolerance.
pub fn draw(times: &Times, path: &Path) -> Result<(), Box<dyn Error>> {
    let (width, height) = (1500, 720);
    let mut drawing = Drawing::new(width, height);
    drawing.text(
        "Share of problems solved within a factor of the fastest method",
        [60.0, 34.0],
        28.0,
        INK,
        Align::Left,
    );
    for (k, (tolerance, rows)) in TOLERANCES.iter().zip(&times.seconds).enumerate() {
        let left = 100.0 + 710.0 * k as f64;
        let (right, top, bottom) = (left + 640.0, 140.0, 600.0);
        let x = |factor: f64| left + (right - left) * factor.log2() / TWOS as f64;
        let y = |share: f64| bottom - (bottom - top) * share;
        drawing.text(&format!("to {tolerance:.0e}"), [0.5 * (left + right), 112.0], 24.0, INK, Align::Center);
        for tenth in (0..=10).step_by(2) {
            let at = y(f64::from(tenth) / 10.0);
            drawing.line(vec![[left, at], [right, at]], 1.0, GRID);
            drawing.text(&format!("{} %", 10 * tenth), [left - 10.0, at], 19.0, INK, Align::Right);
        }
        for two in (0..=TWOS).step_by(2) {
            let at = x(f64::from(1u32 << two));
            drawing.line(vec![[at, top], [at, bottom]], 1.0, GRID);
            drawing.text(&format!("{}", 1u32 << two), [at, bottom + 22.0], 19.0, INK, Align::Center);
        }
        let frame = vec![[left, top], [right, top], [right, bottom], [left, bottom], [left, top]];
        drawing.line(frame, 1.5, INK);
        drawing.text("factor of the fastest time", [0.5 * (left + right), bottom + 52.0], 21.0, INK, Align::Center);
        for (method, color) in COLORS.into_iter().enumerate() {
            let mut points = vec![[left, y(share(rows, method, 1.0))]];
            let mut last = points[0][1];
            for step in 1..=50 * TWOS {
                let factor = 2f64.powf(step as f64 / 50.0);
                let at = y(share(rows, method, factor));
                if at != last {
                    points.extend([[x(factor), last], [x(factor), at]]);
                    last = at;
                }
            }
            points.push([right, last]);
            drawing.line(points, 3.0, color);
        }
    }
    for (k, (method, color)) in Method::ALL.into_iter().zip(COLORS).enumerate() {
        let at = 100.0 + 230.0 * k as f64;
        drawing.line(vec![[at, 690.0], [at + 50.0, 690.0]], 4.0, color);
        drawing.text(method.name(), [at + 62.0, 690.0], 22.0, INK, Align::Left);
    }
    Ok(drawing.write_png(path)?)
}
