//! Progress of a solve, on standard error.

use std::io::IsTerminal as _;
use std::time::Duration;

use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressStyle};
use stiction::SolveEvent;
use stiction::run::{Event, phase_name};

use crate::output;

/// How progress is shown.
#[derive(Debug, Clone, Copy, ValueEnum)]
pub enum Mode {
    /// One moving line on a terminal, plain lines elsewhere
    Auto,
    /// One line an iteration
    Plain,
    None,
}

/// Shows what a solve is doing.
pub enum Progress {
    Line(ProgressBar),
    Plain,
    None,
}

impl Progress {
    pub fn new(mode: Mode) -> Self {
        match mode {
            Mode::Auto if std::io::stderr().is_terminal() => {
                let bar = ProgressBar::new_spinner();
                if let Ok(style) = ProgressStyle::with_template("  {spinner} {msg} ({elapsed})") {
                    bar.set_style(style);
                }
                bar.enable_steady_tick(Duration::from_millis(120));
                Progress::Line(bar)
            }
            Mode::Auto | Mode::Plain => Progress::Plain,
            Mode::None => Progress::None,
        }
    }

    pub fn say(&self, text: String) {
        match self {
            Progress::Line(bar) => bar.set_message(text),
            Progress::Plain => output::note(&format!("  {text}\n")),
            Progress::None => {}
        }
    }

    pub fn show(&self, event: &Event) {
        match event {
            Event::Finished(_) | Event::Halved { .. } => self.line(&words(event)),
            _ => self.say(words(event)),
        }
    }

    /// A line that stays.
    pub fn line(&self, text: &str) {
        match self {
            Progress::Line(bar) => bar.println(format!("  {text}")),
            Progress::Plain => output::note(&format!("  {text}\n")),
            Progress::None => {}
        }
    }

    /// Takes the moving line away.
    pub fn finish(&self) {
        if let Progress::Line(bar) = self {
            bar.finish_and_clear();
        }
    }
}

/// Six digits at most.
fn short(t: f64) -> f64 {
    format!("{t:.5e}").parse().unwrap_or(t)
}

fn words(event: &Event) -> String {
    match event {
        Event::Solver(SolveEvent::SettingUp { unknowns }) => format!("setting up multigrid for {unknowns} unknowns"),
        Event::Solver(SolveEvent::Ordering) => "ordering the unknowns".into(),
        Event::Solver(SolveEvent::Factorising { unknowns, bytes }) => {
            format!("factorising {unknowns} unknowns, {:.2} GB", *bytes as f64 / 1e9)
        }
        Event::Solver(SolveEvent::Solving) => "solving".into(),
        Event::Solver(SolveEvent::Iteration(p)) => {
            format!(
                "{} {:>3}  residual {:.2e}  products {:>5}  open {} stick {} slip {}",
                phase_name(p.phase),
                p.iteration,
                p.residual,
                p.products,
                p.open,
                p.stick,
                p.slip
            )
        }
        Event::Step { number, t, .. } => format!("step {number} to t = {}", short(*t)),
        Event::Halved { t, dt } => format!("not solved: trying a step of {} from t = {}", short(*dt), short(*t)),
        Event::Finished(s) => format!(
            "step {:>3}  t = {:<8}  iterations {:>3}  normal {:.4e}  friction {:.4e}  open {} stick {} slip {}  \
             dissipated {:.4e}",
            s.number,
            short(s.t),
            s.iterations,
            s.normal_force,
            s.tangential_force,
            s.open,
            s.stick,
            s.slip,
            s.dissipation
        ),
        Event::OtherStarts => "looking for further solutions".into(),
        Event::Coulomb => "estimating contraction and uniqueness".into(),
    }
}
