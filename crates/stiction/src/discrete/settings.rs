use super::measures::Measures;
use crate::Error;

/// How a discrete problem is solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// Newton's method in proximal steps; where it stalls, another method chooses its next start.
    #[default]
    Auto,
    /// Newton's method in proximal steps alone.
    Newton,
    /// Sweeps over the points, each solved exactly.
    GaussSeidel,
    /// Accelerated projected gradients, the term of De Saxcé by fixed point.
    Gradient,
    /// Alternating directions.
    Admm,
}

impl Method {
    /// All methods.
    pub const ALL: [Method; 5] = [Method::Auto, Method::Newton, Method::GaussSeidel, Method::Gradient, Method::Admm];

    /// The name a user writes.
    pub fn name(self) -> &'static str {
        match self {
            Method::Auto => "auto",
            Method::Newton => "newton",
            Method::GaussSeidel => "gauss-seidel",
            Method::Gradient => "gradient",
            Method::Admm => "admm",
        }
    }

    /// Whether it takes proximal steps with Newton's method inside.
    pub fn is_newton(self) -> bool {
        matches!(self, Method::Auto | Method::Newton)
    }

    /// The method of that name.
    pub fn named(name: &str) -> Option<Method> {
        Method::ALL.into_iter().find(|method| method.name() == name)
    }
}

/// Settings of a solve; the defaults need no tuning.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Each of the [`Measures`] is to be at most this; useful from 1e-3 to about 1e-12.
    pub tolerance: f64,
    /// Proximal steps; the methods without them take up to ten rounds of ten steps for each.
    pub max_iterations: usize,
    /// The method.
    pub method: Method,
    /// Impulses to start from, `dm`; zero if `None`.
    pub start: Option<Vec<f64>>,
}

impl Settings {
    /// The start, or none where the settings give none, for `length` impulses.
    pub(super) fn start(&self, length: usize) -> Result<Option<&[f64]>, Error> {
        let Some(start) = &self.start else { return Ok(None) };
        if start.len() != length {
            let what = format!("`start` has {} numbers where {length} are needed", start.len());
            return Err(Error::new("settings", what, "give the impulses of all points (d m), point by point, or None"));
        }
        if let Some(i) = start.iter().position(|x| !x.is_finite()) {
            return Err(Error::new("settings", format!("`start`[{i}] is {}", start[i]), "give finite numbers"));
        }
        Ok(Some(start))
    }
}

impl Default for Settings {
    fn default() -> Self {
        Settings { tolerance: 1e-8, max_iterations: 1000, method: Method::Auto, start: None }
    }
}

/// How the iteration ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Status {
    /// All measures are at most the tolerance.
    Solved,
    /// The limit of iterations was reached.
    MaxIterations,
    /// The method can go no further: a factor is singular.
    Stalled,
    /// Only a residual that depends on the units exceeds the tolerance, and it is rounding: impulses are so much larger
    /// than velocities that their last digit counts. Other units help.
    Rounding,
    /// The observer asked to stop.
    Interrupted,
}

/// What the observer receives at every proximal step or round.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Progress {
    /// Number of the iteration.
    pub iteration: usize,
    /// The largest of the measures.
    pub residual: f64,
    /// The parameter of the method over the local compliance: proximal, penalty or length of step.
    pub parameter: f64,
    /// Newton steps so far.
    pub newton_steps: usize,
}

/// What the solve cost.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Proximal steps, or rounds of the other methods.
    pub iterations: usize,
    /// Newton steps.
    pub newton_steps: usize,
    /// Sweeps over the points.
    pub sweeps: usize,
    /// Steps of gradients.
    pub gradients: usize,
    /// Steps of alternating directions.
    pub alternations: usize,
}

/// The best impulses found, with their measures.
#[derive(Debug, Clone)]
pub struct Solution {
    /// How the iteration ended.
    pub status: Status,
    /// Impulses, `dm`.
    pub r: Vec<f64>,
    /// Velocities `W r + q`, `dm`.
    pub u: Vec<f64>,
    /// How far the impulses are from a solution.
    pub measures: Measures,
    /// What it cost.
    pub counts: Counts,
    /// The progress at every iteration.
    pub history: Vec<Progress>,
}
