//! What is kept of an answer and of each load step: plain numbers and words, in `summary.json` and `steps.json` under the
//! names they have here.

use serde::{Deserialize, Deserializer, Serialize};
use serde_json::Value;

use super::named::Named;
use super::quantities::{
    AdriftRecord, FacetedRecord, Micromotion, Smallness, adrift_of, energy, escape_of, faceted, largest_displacement,
    load, micromotions, reaction, unheld,
};
use super::solutions::{SolutionsRecord, UniquenessRecord};
use super::totals::all_totals;
use super::{Balance, BoltState, CouplingState, Outcome, Totals, bolt_states, coupling_states};
use crate::accuracy::Estimate;
use crate::certificate::{BodyBalance, Certificate, PartMeasure};
use crate::contact::equilibrium::in_words;
use crate::contact::sliding::Sliding;
use crate::contact::{Bodies, Overlap, OverlapKind};
use crate::friction::{
    CopiesAtOnce, Counts, Coupling, End, Given, MethodReport, MethodSettings, Minimization, SolverPath, Splitting,
    Status, Sweeps,
};
use crate::mesh::Group;
use crate::run::pose::{ContactFacts, Prepared, Seconds, Span};

/// An answer; lengths, forces and energies in the units of the case.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct AnswerRecord {
    /// How the iteration ended.
    pub status: Status,
    /// Where nothing balances the loads: the motion along which they carry a body away.
    pub escape_mode: Option<String>,
    /// Where nothing was found and friction may have reached its limit.
    pub sliding: Option<SlidingRecord>,
    /// Where surfaces lie in each other.
    #[serde(default)]
    pub overlaps: Vec<OverlapRecord>,
    /// The certificate.
    pub certificate: CertificateRecord,
    /// Over all pairs.
    pub contact: Totals,
    /// Totals of each pair.
    pub pairs: Vec<PairRecord>,
    /// Balance of each body.
    pub bodies: Vec<BodyRecord>,
    /// Force and shortening of each bolt.
    pub bolts: Vec<BoltState>,
    /// Motion of each reference point, and what acts there.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub couplings: Vec<CouplingState>,
    /// The largest displacement of a node.
    #[serde(deserialize_with = "or_nan")]
    pub displacement_max: f64,
    /// Estimated error of the stresses in the mean, relative (energy norm); none where loads carry a body away.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub discretisation_error: Option<f64>,
    /// How small rotations, strains and slips are; none where loads carry a body away.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub smallness: Option<Smallness>,
    /// Bodies that nothing holds: their places say nothing.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unheld: Vec<String>,
    /// Motions that nothing resists: places along them say nothing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub adrift: Option<AdriftRecord>,
    /// A motion that hardly more than the facets of curved surfaces resists.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub held_by_facets: Option<FacetedRecord>,
    /// `1/2 u'Ku - f'u` over all degrees of freedom.
    #[serde(deserialize_with = "or_nan")]
    pub energy: f64,
    /// Force of all supports on the body.
    #[serde(deserialize_with = "or_nans")]
    pub reaction: [f64; 3],
    /// The force the loads add up to.
    #[serde(deserialize_with = "or_nans")]
    pub load: [f64; 3],
    /// Unknown displacements.
    pub dofs: usize,
    /// Multipliers.
    pub dual_dofs: usize,
    /// The name of the method.
    pub method: String,
    /// `None` for Newton's method.
    pub method_details: Option<MethodDetails>,
    /// What it cost.
    pub counts: CountsRecord,
    /// Factor or multigrid.
    pub path: SolverPath,
    /// Why the direct path was taken, where the settings left the choice.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub path_reason: Option<String>,
    /// Wall time by phase, and the total.
    pub seconds: Named,
    /// Processor time by phase, and the total.
    pub cpu_seconds: Named,
    /// Largest memory of the process, bytes.
    pub peak_memory_bytes: Option<u64>,
    /// What can be said about other solutions.
    pub coulomb: Option<UniquenessRecord>,
    /// What other starts have found, if they were asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub solutions: Option<SolutionsRecord>,
}

/// A load step and its answer.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct StepRecord {
    /// From 1.
    pub step: usize,
    /// What the case calls the step that this increment is of.
    pub name: String,
    /// Time at its end, and how long it is.
    pub t: f64,
    /// Its length in time.
    pub dt: f64,
    /// Solves it took, those of longer increments that failed included.
    pub attempts: usize,
    /// The answer at its end.
    #[serde(flatten)]
    pub answer: AnswerRecord,
    /// Works since the start.
    pub balance: BalanceRecord,
}

/// What a variant without data is called in files.
pub(crate) fn word(variant: impl Serialize) -> String {
    serde_json::to_value(variant).ok().as_ref().and_then(Value::as_str).unwrap_or_default().into()
}

/// The limit load of friction: forces per unit of the displacement of what moves farthest.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SlidingRecord {
    /// The motion, in words.
    pub motion: String,
    /// What the loads pull with.
    pub load: f64,
    /// The most friction takes up of it.
    pub friction: f64,
}

impl SlidingRecord {
    pub(crate) fn of(prepared: &Prepared, Sliding { alpha, load, friction }: &Sliding) -> Self {
        let motion = in_words(&prepared.problem, &prepared.motions, alpha);
        SlidingRecord { motion, load: *load, friction: *friction }
    }
}

/// Surfaces that lie in each other, see [`Overlap`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct OverlapRecord {
    /// What it means.
    pub kind: OverlapName,
    /// The contact it belongs to: the pair, or that of the obstacle.
    pub contact: Option<String>,
    /// The bodies, the one that `place` belongs to first; one where a body meets itself or an obstacle.
    pub bodies: Vec<String>,
    /// Groups of the mesh that hold the faces, as far as there are any.
    pub groups: Vec<String>,
    /// A point of the undeformed body where it is deepest, length.
    pub place: [f64; 3],
    /// Length.
    pub depth: f64,
    /// Part of the way from the load state before at which it is so deep; 1 at its end.
    pub part: f64,
    /// The `search` that would find the surfaces, length.
    pub search: Option<f64>,
}

/// [`OverlapKind`] without its numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum OverlapName {
    /// No contact is named there.
    Unnamed,
    /// The surfaces of a pair meet farther apart than they were looked for.
    BeyondSearch,
    /// A contact is named, and no contact point can be had there.
    OutOfReach,
    /// Contact points are there, and displacements are too large for them.
    InContact,
    /// An obstacle has got into a face between contact points, none of which it touches.
    BetweenPoints,
}

/// A certificate.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CertificateRecord {
    /// [`Certificate::measures`].
    #[serde(flatten)]
    pub measures: Named,
    /// For given friction: a bound of the error in energy.
    pub duality_gap: Option<f64>,
    /// [`Certificate::parts`].
    pub parts: Vec<PartRecord>,
    /// What each of them is held against.
    pub part_tolerance: f64,
    /// The largest measure.
    #[serde(deserialize_with = "or_infinite")]
    pub worst: f64,
    /// What it is held against.
    pub tolerance: f64,
    /// Whether it passes.
    pub passed: bool,
}

/// How far a body or a pair is off by its own forces.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PartRecord {
    /// `body` or `pair`.
    pub part: String,
    /// Its name.
    pub name: String,
    /// [`PartMeasure::residual`](crate::certificate::PartMeasure::residual).
    #[serde(deserialize_with = "or_infinite")]
    pub residual: f64,
}

/// The totals of a pair.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PairRecord {
    /// Its name.
    pub name: String,
    /// Its totals.
    #[serde(flatten)]
    pub totals: Totals,
    /// How far its points have slid since the start; none without points.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub micromotion: Option<Micromotion>,
}

/// The forces on a body and their balance.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct BodyRecord {
    /// Its name.
    pub name: String,
    /// Resultant of the loads, newton.
    #[serde(deserialize_with = "or_nans")]
    pub load: [f64; 3],
    /// Resultant of the supports, newton.
    #[serde(deserialize_with = "or_nans")]
    pub support: [f64; 3],
    /// Resultant of contact, newton.
    #[serde(deserialize_with = "or_nans")]
    pub contact: [f64; 3],
    /// Imbalance of force, relative.
    #[serde(deserialize_with = "or_infinite")]
    pub force_balance: f64,
    /// Imbalance of moment, relative.
    #[serde(deserialize_with = "or_infinite")]
    pub moment_balance: f64,
}

/// Energies since the start of the first load step, see [`Balance`].
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct BalanceRecord {
    /// Work of loads, supports and obstacles, energy.
    #[serde(deserialize_with = "or_nan")]
    pub work: f64,
    /// Elastic energy.
    #[serde(deserialize_with = "or_nan")]
    pub elastic: f64,
    /// Dissipated by friction, energy.
    #[serde(deserialize_with = "or_nan")]
    pub dissipation: f64,
    /// What the length of the steps costs, energy.
    #[serde(deserialize_with = "or_nan")]
    pub drift: f64,
}

impl BalanceRecord {
    pub(crate) fn of(balance: &Balance) -> Self {
        let Balance { work, elastic, dissipation } = *balance;
        BalanceRecord { work, elastic, dissipation, drift: balance.drift() }
    }

    pub(crate) fn balance(&self) -> Balance {
        let BalanceRecord { work, elastic, dissipation, .. } = *self;
        Balance { work, elastic, dissipation }
    }
}

/// How a method other than Newton's was set and how it ended.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct MethodDetails {
    /// How it ended.
    pub end: End,
    /// The method for given friction inside.
    pub inner: String,
    /// Variant of the fixed point.
    pub variant: Option<u8>,
    /// How normal and tangential multipliers are divided.
    pub splitting: Option<Splitting>,
    /// Squares around a disc.
    pub squares: Option<usize>,
    /// How the squares are tied to one another.
    pub coupling: Option<Coupling>,
    /// Penalty, length per force.
    pub rho: Option<f64>,
    /// Disagreement of the copies of the multipliers.
    pub disagreement: Option<f64>,
    /// What the method was asked to reach.
    pub tolerance: f64,
}

/// What an answer cost; `None` where the method does not count it.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(default)]
pub struct CountsRecord {
    /// Iterations.
    pub iterations: usize,
    /// Stalls answered by gradient steps or resets.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub restarts: Option<usize>,
    /// Outer steps of the fixed point.
    pub fixed_point_steps: usize,
    /// Quadratic programs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub qp_problems: Option<usize>,
    /// Quadratic programs that ended early.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub short_problems: Option<usize>,
    /// Conjugate gradient steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cg_steps: Option<usize>,
    /// Expansion steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expansions: Option<usize>,
    /// Proportioning steps.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub proportionings: Option<usize>,
    /// Products with `Q`, or with `K`.
    pub products: usize,
    /// Multiplications and additions, estimated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub flops: Option<f64>,
    /// Solves with `K`.
    pub solves: usize,
    /// Multigrid cycles.
    pub cycles: usize,
    /// Products for the estimates of uniqueness.
    pub coulomb_products: usize,
}

/// A number that is written as `null` where it is not finite.
pub(super) fn or_nan<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(deserializer)?.unwrap_or(f64::NAN))
}

/// Three of them.
pub(super) fn or_nans<'de, D: Deserializer<'de>>(deserializer: D) -> Result<[f64; 3], D::Error> {
    Ok(<[Option<f64>; 3]>::deserialize(deserializer)?.map(|value| value.unwrap_or(f64::NAN)))
}

/// A measure, which is beyond all bounds where it is not finite.
pub(in crate::run) fn or_infinite<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::deserialize(deserializer)?.unwrap_or(f64::INFINITY))
}

impl AnswerRecord {
    /// The record of an answer; its loads are those of the whole case.
    pub(crate) fn of(prepared: &Prepared, outcome: &Outcome) -> Self {
        let (solution, problem) = (&outcome.solution, &prepared.problem);
        let pair = |((name, totals), micromotion)| PairRecord { name, totals, micromotion };
        let sliding = outcome.sliding.as_ref().map(|sliding| SlidingRecord::of(prepared, sliding));
        let report = outcome.method.as_ref();
        let (contact, pairs) = all_totals(prepared, outcome);
        AnswerRecord {
            status: solution.status,
            escape_mode: escape_of(prepared, solution.status).map(|escape| escape.motion),
            sliding,
            overlaps: outcome.overlaps.iter().map(|it| OverlapRecord::of(Whereabouts::of(prepared), it)).collect(),
            certificate: CertificateRecord::of(&solution.certificate),
            contact,
            pairs: pairs.into_iter().zip(micromotions(prepared, outcome)).map(pair).collect(),
            bodies: solution.certificate.bodies.iter().map(BodyRecord::of).collect(),
            bolts: bolt_states(prepared, outcome),
            couplings: coupling_states(prepared, outcome),
            displacement_max: largest_displacement(prepared, outcome).0,
            discretisation_error: outcome.estimate.as_ref().map(Estimate::relative),
            smallness: outcome.smallness.clone(),
            unheld: unheld(prepared, solution),
            adrift: adrift_of(prepared, solution),
            held_by_facets: faceted(prepared, solution),
            energy: outcome.energy.unwrap_or_else(|| energy(prepared, &outcome.solution.u)),
            reaction: reaction(prepared, outcome).into_iter().fold([0.0; 3], crate::mesh::v3::add),
            load: prepared.facts.resultant(),
            dofs: problem.unknowns(),
            dual_dofs: 3 * problem.points(),
            method: outcome.method_name.clone(),
            method_details: report.and_then(|report| MethodDetails::of(&outcome.settings, report)),
            counts: CountsRecord::of(outcome),
            path: outcome.solution.path,
            path_reason: outcome.path_reason.clone(),
            seconds: seconds(&outcome.seconds, |span| span.wall),
            cpu_seconds: seconds(&outcome.seconds, |span| span.cpu),
            peak_memory_bytes: outcome.peak_memory,
            coulomb: outcome.coulomb.as_ref().map(UniquenessRecord::of),
            solutions: outcome.solutions.as_ref().map(|found| SolutionsRecord::of(prepared, found)),
        }
    }
}

impl StepRecord {
    /// The record of step number `step`, which the case calls `name` and which took from `begin` to `t`.
    pub(super) fn of(
        prepared: &Prepared,
        outcome: &Outcome,
        (step, name): (usize, &str),
        [begin, t]: [f64; 2],
        attempts: usize,
        balance: &Balance,
    ) -> Self {
        let answer = AnswerRecord { load: load(prepared), ..AnswerRecord::of(prepared, outcome) };
        StepRecord { step, name: name.into(), t, dt: t - begin, attempts, answer, balance: BalanceRecord::of(balance) }
    }
}

impl CertificateRecord {
    /// As the certificate says.
    pub(crate) fn of(certificate: &Certificate) -> Self {
        let measures = certificate.measures().into_iter().map(|(name, value)| (name.to_string(), value)).collect();
        let Certificate { duality_gap, worst, tolerance, passed, .. } = *certificate;
        let part = |part: &PartMeasure| PartRecord {
            part: part.part.name().into(),
            name: part.name.clone(),
            residual: part.residual,
        };
        let parts = certificate.parts.iter().map(part).collect();
        let part_tolerance = certificate.part_tolerance();
        CertificateRecord { measures: Named(measures), duality_gap, parts, part_tolerance, worst, tolerance, passed }
    }
}

/// What has names where surfaces lie in each other.
#[derive(Clone, Copy)]
pub(crate) struct Whereabouts<'a> {
    /// Of the mesh.
    pub groups: &'a [Group],
    pub bodies: Option<&'a Bodies>,
    pub contacts: &'a [ContactFacts],
}

impl<'a> Whereabouts<'a> {
    pub(crate) fn of(prepared: &'a Prepared) -> Self {
        let Prepared { mesh, facts, problem, .. } = prepared;
        Whereabouts { groups: &mesh.groups, bodies: problem.labels.bodies.as_ref(), contacts: &facts.contacts }
    }
}

impl OverlapRecord {
    /// The overlap with names for numbers.
    pub(crate) fn of(at: Whereabouts, overlap: &Overlap) -> Self {
        let body = |body: &u32| match at.bodies {
            Some(bodies) => bodies.list[*body as usize].name.clone(),
            None => (body + 1).to_string(),
        };
        let mut bodies: Vec<String> = overlap.bodies.iter().map(body).collect();
        bodies.dedup();
        // The smallest group that holds the face tells most.
        let group = |face: &u32| {
            let holding = at.groups.iter().filter(|group| group.faces.binary_search(face).is_ok());
            holding.min_by_key(|group| group.faces.len()).map(|group| group.name.clone())
        };
        let (kind, search) = match overlap.kind {
            OverlapKind::Unnamed => (OverlapName::Unnamed, None),
            OverlapKind::BeyondSearch { search } => (OverlapName::BeyondSearch, Some(search)),
            OverlapKind::OutOfReach => (OverlapName::OutOfReach, None),
            OverlapKind::InContact => (OverlapName::InContact, None),
            OverlapKind::BetweenPoints => (OverlapName::BetweenPoints, None),
        };
        OverlapRecord {
            kind,
            contact: overlap.surface.map(|i| at.contacts[i].surface.name.clone()),
            bodies,
            groups: overlap.faces.iter().flatten().filter_map(group).collect(),
            place: overlap.place,
            depth: overlap.depth,
            part: overlap.part,
            search,
        }
    }
}

impl BodyRecord {
    pub(crate) fn of(body: &BodyBalance) -> Self {
        let BodyBalance { load, support, contact, .. } = *body;
        let (force_balance, moment_balance) = (body.balance.force, body.balance.moment);
        BodyRecord { name: body.name.clone(), load, support, contact, force_balance, moment_balance }
    }
}

impl MethodDetails {
    pub(crate) fn of(settings: &MethodSettings, report: &MethodReport) -> Option<Self> {
        let given = settings.method.given()?;
        let (splitting, variant) = match given {
            Given::Uzawa(how) => {
                let variant = if how.sweeps == Sweeps::One { 2 } else { 1 };
                (Some(how.splitting), (how.copies == CopiesAtOnce::One).then_some(variant))
            }
            Given::AdaptiveUzawa | Given::Discs => (None, None),
        };
        let inner = match given {
            Given::Uzawa(Minimization { copies: CopiesAtOnce::One, .. }) => "alg1",
            Given::Uzawa(Minimization { copies: CopiesAtOnce::All, .. }) => "alg2",
            Given::AdaptiveUzawa => "smalbe",
            Given::Discs => "discs",
        };
        let by_squares = given != Given::Discs;
        Some(MethodDetails {
            end: report.end,
            inner: inner.into(),
            variant,
            splitting,
            squares: by_squares.then_some(settings.squares),
            coupling: by_squares.then_some(settings.coupling),
            rho: by_squares.then_some(report.penalty),
            disagreement: by_squares.then_some(report.disagreement),
            tolerance: settings.tolerance,
        })
    }
}

impl CountsRecord {
    fn of(outcome: &Outcome) -> Self {
        let of_newton = CountsRecord::of_newton(&outcome.solution.counts);
        let coulomb_products = outcome.coulomb.map_or(0, |facts| facts.products);
        match &outcome.method {
            Some(MethodReport { counts: c, .. }) => CountsRecord {
                iterations: c.iterations,
                fixed_point_steps: c.fixed_point_steps,
                qp_problems: Some(c.qp_problems),
                short_problems: Some(c.short_problems),
                cg_steps: Some(c.cg_steps),
                expansions: Some(c.expansions),
                proportionings: Some(c.proportionings),
                products: c.products,
                flops: Some(c.flops),
                restarts: None,
                coulomb_products,
                ..of_newton
            },
            None => CountsRecord { coulomb_products, ..of_newton },
        }
    }

    /// What a solve by the default method cost.
    pub(crate) fn of_newton(counts: &Counts) -> Self {
        CountsRecord {
            iterations: counts.newton_steps,
            restarts: Some(counts.restarts),
            fixed_point_steps: counts.fixed_point_steps,
            products: counts.products,
            solves: counts.solves,
            cycles: counts.cycles,
            ..Self::default()
        }
    }

    /// What a solve by the default method cost; nothing of other methods.
    pub(crate) fn counts(&self) -> Counts {
        let Some(restarts) = self.restarts else { return Counts::default() };
        Counts {
            newton_steps: self.iterations,
            restarts,
            fixed_point_steps: self.fixed_point_steps,
            products: self.products,
            solves: self.solves,
            cycles: self.cycles,
        }
    }

    /// Iterations of the method, or cycles of multigrid.
    pub fn steps(&self) -> usize {
        self.iterations.max(self.cycles)
    }
}

/// Times by phase, and the total.
pub(crate) fn seconds(seconds: &Seconds, of: fn(&Span) -> f64) -> Named {
    let all = seconds.phases().into_iter().chain([("total", seconds.total())]);
    Named(all.map(|(name, span)| (name.to_string(), of(&span))).collect())
}
