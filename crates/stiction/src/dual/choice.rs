use super::memory;
use crate::Error;
use crate::contact::ContactProblem;
use crate::linalg::memory::{ensure, too_large};
use crate::linalg::{NodeGraph, Plan, Stop, last, nested_dissection_until, plan};

/// How products with `Q` are formed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Form {
    /// The cheaper by prediction, within memory.
    #[default]
    Auto,
    /// Contact unknowns are eliminated last and their dense Schur complement is kept.
    Dense,
    /// Every product is a solve with the sparse factor.
    Solves,
}

/// Settings of the direct dual path.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct DualSettings {
    /// How products are formed.
    pub form: Form,
    /// Bytes the factor may take; `None` sets no limit.
    pub memory_limit: Option<u64>,
    /// Ends the ordering, the factorisation, and linear systems with the operator.
    pub stop: Stop,
}

/// A decided elimination order with its predicted cost.
#[derive(Debug)]
pub struct Choice {
    /// [`Form::Dense`] or [`Form::Solves`].
    pub form: Form,
    /// Predicted multiplications and additions of the factorisation.
    pub flops: f64,
    /// Predicted memory of factor, matrix copies, dense block and vectors: the most at a time, bytes.
    pub bytes: u64,
    /// Predicted seconds on one core of 2020 or later; only ratios are meant.
    pub seconds: f64,
    pub(super) graph: NodeGraph,
    pub(super) plan: Plan,
    pub(super) touched: Vec<u32>,
    pub(super) stop: Stop,
}

/// What the prediction of the time of a solve counts with; only ratios of times are meant.
pub(super) struct Threshold;

impl Threshold {
    /// Products a contact solve is expected to need when the two forms are compared.
    pub(super) const EXPECTED_PRODUCTS: f64 = 80.0;
    /// Dense arithmetic of the factorisation and streaming of the factor in a solve, per second on one core.
    pub(super) const FLOPS_PER_SECOND: f64 = 2.5e10;
    pub(super) const BYTES_PER_SECOND: f64 = 8e9;
}

/// Orders the unknowns, predicts time and memory of both forms and takes the cheaper that fits.
///
/// # Errors
/// If the form asked for, or with [`Form::Auto`] either form, needs more than the memory limit: how much is needed,
/// how much there is, and what to do. If it is stopped: [`Error::interrupted`].
pub fn choose(problem: &ContactProblem, settings: &DualSettings) -> Result<Choice, Error> {
    memory::before_the_graph(problem, settings.memory_limit)?;
    let graph = NodeGraph::of_symmetric(&problem.elastic.K, problem.elastic.node_of.as_deref());
    memory::before_the_ordering(problem, &graph, settings.memory_limit)?;
    let stop = &settings.stop;
    let order = nested_dissection_until(&graph, stop)?;
    let touched = touched_unknowns(problem);
    let predicted = |form| stop.check().map(|()| candidate(problem, &graph, &order, &touched, form));
    let mut candidates = match settings.form {
        Form::Dense => vec![predicted(Form::Dense)?],
        Form::Solves => vec![predicted(Form::Solves)?],
        // A block this large never pays: its factor alone exceeds the products it saves.
        Form::Auto if touched.is_empty() || touched.len() > 20_000 => vec![predicted(Form::Solves)?],
        Form::Auto => vec![predicted(Form::Dense)?, predicted(Form::Solves)?],
    };
    candidates.sort_by(|a, b| a.seconds.total_cmp(&b.seconds));
    let limit = settings.memory_limit.unwrap_or(u64::MAX);
    let least = candidates.iter().map(|c| c.bytes).min().unwrap_or(0);
    let what = format!("the Cholesky factor of {} unknowns", problem.unknowns());
    let chosen = candidates.into_iter().find(|c| c.bytes <= limit).ok_or_else(|| {
        let error = too_large(&what, least as f64, limit);
        memory::coarser(problem, error, least as f64, limit)
    })?;
    ensure(&what, chosen.bytes as f64, None)?;
    Ok(Choice { graph, touched, stop: stop.clone(), ..chosen })
}

fn touched_unknowns(problem: &ContactProblem) -> Vec<u32> {
    let mut touched: Vec<u32> = problem.contact.B.column.clone();
    touched.sort_unstable();
    touched.dedup();
    touched
}

fn candidate(problem: &ContactProblem, graph: &NodeGraph, order: &[u32], touched: &[u32], form: Form) -> Choice {
    let mut is_last = vec![false; graph.len()];
    if form == Form::Dense {
        let wanted: Vec<bool> = marks(problem.unknowns(), touched);
        (0..graph.len()).for_each(|v| is_last[v] = graph.unknowns_of(v).iter().any(|&i| wanted[i as usize]));
    }
    let trailing_nodes = is_last.iter().filter(|&&l| l).count();
    let plan = plan(graph, &last(order, &is_last), trailing_nodes);
    let per_product = match form {
        Form::Dense => 8.0 * (plan.trailing as f64).powi(2),
        Form::Solves | Form::Auto => 16.0 * plan.path_entries(touched),
    };
    let empty = NodeGraph { first: vec![0], unknowns: vec![], start: vec![0], neighbours: vec![] };
    Choice {
        form,
        flops: plan.flops(),
        bytes: memory::predicted(problem, graph, &plan, form) as u64,
        seconds: plan.flops() / Threshold::FLOPS_PER_SECOND
            + Threshold::EXPECTED_PRODUCTS * per_product / Threshold::BYTES_PER_SECOND,
        graph: empty,
        plan,
        touched: Vec::new(),
        stop: Stop::never(),
    }
}

fn marks(n: usize, wanted: &[u32]) -> Vec<bool> {
    let mut marks = vec![false; n];
    wanted.iter().for_each(|&i| marks[i as usize] = true);
    marks
}
