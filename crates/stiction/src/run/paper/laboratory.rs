//! Runs experiments, each once.

use std::collections::HashMap;
use std::ops::ControlFlow;

use super::choices::{ALG1_RHO, INNER, ITERATION_LIMIT, OUTER, Setting};
use super::experiment::{Experiment, Family, Method};
use super::model::{Brick, Law, brick};
use crate::Error;
use crate::contact::{ContactProblem, Friction};
use crate::dual::{Dual, DualSettings, choose};
use crate::friction::{self, Coupling, Given, MethodEnd, MethodSettings, Quadratic, Splitting, Start, Sweeps};
use crate::linalg::norm;

/// Inner tolerance of reference solutions and of changes between numbers of squares.
const SHARP: f64 = 1e-12;
/// Step 2 executions of ALG1 at most; the paper's longest run has 2333.
const ALG1_LIMIT: usize = 4000;

/// What one run gave.
#[derive(Debug, Clone, PartialEq)]
pub struct Measured {
    /// Executions of Step 2.
    pub iterations: usize,
    pub qp_problems: usize,
    pub cg_steps: usize,
    pub flops: f64,
    /// Mean of the copies, newton, 3m.
    pub lambda: Vec<f64>,
    /// Bounds, newton, m.
    pub slip_bound: Vec<f64>,
    pub end: MethodEnd,
}

/// A posed brick whose dual energy has been formed.
struct Bench {
    brick: Brick,
    problem: ContactProblem,
    quadratic: Quadratic<'static>,
}
