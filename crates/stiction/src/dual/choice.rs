use crate::Error;
use crate::contact::ContactProblem;
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
    /// Predicted memory of factor, matrix copy and dense block, bytes.
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
    let graph = NodeGraph::of_symmetric(&problem.elastic.K, problem.elastic.node_of.as_deref());
    let stop = &settings.stop;
    let order = nested_dissection_until(&graph, stop).ok_or_else(Error::interrupted)?;
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
    let chosen = candidates.into_iter().find(|c| c.bytes <= limit).ok_or_else(|| too_large(problem, least, limit))?;
    Ok(Choice { graph, touched, stop: stop.clone(), ..chosen })
}

fn too_large(problem: &ContactProblem, needed: u64, limit: u64) -> Error {
    let gb = |bytes: u64| bytes as f64 / 1e9;
    let what = format!(
        "the Cholesky factor of {} unknowns needs {:.2} GB and {:.2} GB may be used",
        problem.unknowns(),
        gb(needed),
        gb(limit)
    );
    // The factor of a 3D mesh grows like n^(4/3).
    let factor = (limit as f64 / needed as f64).powf(0.75);
    let remedy = format!(
        "coarsen the mesh to about {:.0} unknowns, raise `settings.memory_limit`, or use a machine with more memory",
        problem.unknowns() as f64 * factor
    );
    Error::new("", what, remedy)
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
    // Merged supernodes store about a tenth more than the factor has entries.
    // Both triangles of `K` with the places of its entries are there as well.
    let copy = 2.0 * (2 * problem.elastic.K.value.len() - problem.unknowns()) as f64;
    let numbers = 1.1 * plan.entries() + copy + (plan.trailing as f64).powi(2);
    let empty = NodeGraph { first: vec![0], unknowns: vec![], start: vec![0], neighbours: vec![] };
    Choice {
        form,
        flops: plan.flops(),
        bytes: (8.0 * numbers) as u64,
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
