use super::balance::{Balance, BodyBalance, balances, worst as worst_balance};
use super::duality::duality_gap;
use super::parts::{NodalForces, PartMeasure, bodies, pairs};
use super::point::Point;
use super::scales::{ROUNDING, Scales, measure};
use super::share::{Share, fetched};
use super::stiffness::LocalStiffness;
use crate::contact::{ContactProblem, Division};

/// How far an answer is from solving its problem; see [`certify`] for the definitions.
///
/// Lengths are counted in `L`, the largest of displacements, overlaps and contact forces times the compliance at their
/// points: where all points stick nothing moves but by rounding. What rounding of `K u` and of the jumps explains is not
/// counted, unless bodies have gone so far that it hides their loads: then it is the imbalance.
#[derive(Debug, Clone, PartialEq)]
pub struct Certificate {
    /// `|f - K u - Bᵀ lambda| / max(|f|, |Bᵀ lambda|)`: a body may be loaded by its overlap alone.
    pub equilibrium: f64,
    /// Force and moment of loads, reactions and contact, the worst of all bodies; `None` for a problem without supports.
    pub balance: Option<Balance>,
    /// The same of each body; empty for a problem without supports.
    pub bodies: Vec<BodyBalance>,
    /// `max(N u - gap)+ / L`; at tied points the largest jump.
    pub penetration: f64,
    /// `max(-lambda_n)+ / max|lambda_i|`.
    pub tension: f64,
    /// `max(|lambda_t| - bound)+ / max bound`, where `max bound` counts as a millionth of `max|lambda_i|` at least;
    /// where friction differs by direction `|(lambda_t1, lambda_t2 / a)|` is what is held against the bound, `a` the
    /// friction across the first tangent over that along it.
    pub cone: f64,
    /// `max(bound |s| - lambda_t . s) / (max bound * L)`: zero where friction is parallel to the slip and at its bound, or
    /// along the slip's image where friction differs by direction: `|(s_1, a s_2)|` stands for `|s|` here and below.
    pub slip_direction: f64,
    /// Sum of `lambda_n (gap - N u) + bound |s| - lambda_t . s` over `L` times the sum of `max(|lambda_n|, bound)`.
    /// De Saxcé & Feng 1998.
    pub bipotential_gap: f64,
    /// `|lambda - P(lambda - r w)| / |lambda|`, `P` the projection on the cone of friction (given friction: on the
    /// half-line and disc), `w` the jump in De Saxcé's form, `r` the mean stiffness of the points of a pair, of both bodies in
    /// a row. Where friction differs by direction both are taken in coordinates in which the cone is round: forces
    /// across over `a`, slips times `a`. The multiplier of an empty row of `B` counts as a whole.
    pub natural_residual: f64,
    /// What the rounding of the data leaves open in gaps and slips over `L`: no answer is known better; `None` where the
    /// problem holds no such rounding.
    pub data_rounding: Option<f64>,
    /// For given friction (no Coulomb point): primal energy of a displacement near `u` that does not penetrate less
    /// the dual energy of `lambda`, a bound of `1/2 |u - u*|²_K` for admissible `lambda` in equilibrium; energy.
    pub duality_gap: Option<f64>,
    /// Equilibrium of each body and the natural residual of each pair, over their own forces.
    pub parts: Vec<PartMeasure>,
    /// The largest of the measures of the whole.
    pub worst: f64,
    /// What every measure of the whole is held against.
    pub tolerance: f64,
    /// Whether `worst <= tolerance`, and no body and no pair is farther off by its own forces than [`PART_TOLERANCE`]
    /// or `tolerance`, whichever is larger.
    pub passed: bool,
}

/// The name of the measure that is a matter of the data alone.
const DATA_ROUNDING: &str = "data_rounding";

/// What each body and each pair is held against by its own forces, unless the tolerance of the whole is larger. Looser
/// than that of the whole: a part that carries a thousandth has a thousandth of its digits.
pub const PART_TOLERANCE: f64 = 1e-6;

/// Judges `u` (length `n`) and `lambda` (length `3m`) against `tolerance`. Finite data and answers have finite measures,
/// a zero load and its zero answer have none but zeros.
pub fn certify(problem: &ContactProblem, u: &[f64], lambda: &[f64], tolerance: f64) -> Certificate {
    certify_share(problem, &Share::whole(), u, lambda, tolerance)
}

/// The certificate of a problem that is divided among ranks, the same at each of them: `u` and `lambda` hold the values of own
/// nodes, those of others are fetched from their owners. Every sum and every largest value is one over all ranks, each
/// counting what is its own; no rank sees the whole.
pub fn certify_divided(
    problem: &ContactProblem,
    division: &Division,
    u: &[f64],
    lambda: &[f64],
    tolerance: f64,
) -> Certificate {
    let (u, lambda) = fetched(problem, division, u, lambda);
    certify_share(problem, &Share::of(problem, division), &u, &lambda, tolerance)
}

fn certify_share(problem: &ContactProblem, share: &Share, u: &[f64], lambda: &[f64], tolerance: f64) -> Certificate {
    let elastic = problem.elastic.K.times(u);
    let contact_force = problem.contact.B.transpose_times(lambda);
    let jump = problem.contact.B.times(u);
    let stiffness = LocalStiffness::new(problem, share);
    let points: Vec<Point> =
        (0..problem.points()).map(|j| Point::new(problem, &stiffness, u, &jump, lambda, j)).collect();
    let scales = Scales::new(problem, share, &stiffness, &points, u, lambda, &contact_force);
    // The sizes of the terms that `elastic` adds up, and of those that forces of points with a tensile strength are differences of.
    let mut internal = problem.elastic.K.magnitude_times(u);
    add_strengths(problem, &mut internal);
    let imbalance: Vec<f64> = (0..u.len()).map(|i| problem.elastic.f[i] - elastic[i] - contact_force[i]).collect();
    let forces =
        NodalForces { imbalance: &imbalance, contact: &contact_force, internal: &internal, whole: scales.load };
    let over_points = |error: &dyn Fn(&Point) -> f64, rounding: &dyn Fn(&Point) -> f64, scale: f64| {
        share.points(&points).fold(0.0, |worst: f64, p| worst.max(measure(error(p), rounding(p), scale)))
    };
    let mut worst = [
        over_points(&Point::violation, &|_| 0.0, scales.length),
        over_points(&Point::tension, &|p| p.rounding, scales.force),
        over_points(&Point::excess, &|p| p.rounding, scales.friction),
        over_points(&Point::misdirection, &Point::misdirection_rounding, scales.friction * scales.length),
        f64::from(u8::from(!share.is_finite(u, lambda))),
    ];
    share.max(&mut worst);
    let [penetration, tension, cone, slip_direction, no_numbers] = worst;
    let bipotential = share.points(&points).map(Point::bipotential).fold((0.0, 0.0), |a, b| (a.0 + b.0, a.1 + b.1));
    let square = |values: &mut dyn Iterator<Item = f64>| values.map(|v| v * v).sum::<f64>();
    let mut sums = [
        bipotential.0,
        bipotential.1,
        share.points(&points).map(Point::residual_squared).sum::<f64>(),
        square(&mut share.points(&points).map(|p| p.rounding)),
        square(&mut share.unknowns(&imbalance).copied()),
        square(&mut share.unknowns(&internal).copied()),
        square(&mut share.unknowns(&at_contact(problem, &internal)).copied()),
    ];
    share.sum(&mut sums);
    let [gap, gap_rounding, residual, rounding, unbalanced, inside, at_contact] = sums;
    // Displacements are no better known than forces inside the bodies add up: contact that carries less than that carries nothing.
    let rounding = rounding.sqrt() + ROUNDING * at_contact.sqrt();
    let allowed = ROUNDING * inside.sqrt();
    let unbalanced = if scales.is_beyond_sight(problem, allowed) { 2.0 * allowed } else { unbalanced.sqrt() };
    let balances = balances(problem, share, u, lambda, &internal).unwrap_or_default();
    let mut certificate = Certificate {
        equilibrium: measure(unbalanced, allowed, scales.load),
        balance: worst_balance(&balances),
        bodies: balances,
        penetration,
        tension,
        cone,
        slip_direction,
        bipotential_gap: measure(gap.abs(), gap_rounding, scales.work),
        natural_residual: measure(residual.sqrt(), rounding, scales.contact),
        data_rounding: (problem.contact.rounding > 0.0).then(|| measure(problem.contact.rounding, 0.0, scales.length)),
        duality_gap: duality_gap(problem, share, u, lambda, scales.length),
        parts: [bodies(problem, share, &forces), pairs(problem, share, &stiffness.body, &points, lambda, &forces)]
            .concat(),
        worst: 0.0,
        tolerance,
        passed: false,
    };
    certificate.worst = certificate.measures().iter().fold(0.0, |a: f64, (_, v)| a.max(*v));
    certificate.passed = certificate.missed() <= 1.0 && no_numbers == 0.0;
    certificate
}

/// Adds the tensile strengths of the points, newton, at the unknowns that their normal rows reach.
fn add_strengths(problem: &ContactProblem, sizes: &mut [f64]) {
    for (j, law) in problem.contact.friction.iter().enumerate().filter(|(_, law)| law.tension() != 0.0) {
        problem.contact.B.entries_of(j).for_each(|(i, entry)| sizes[i as usize] += (entry * law.tension()).abs());
    }
}

/// The forces at the unknowns that contact touches, and zeros.
fn at_contact(problem: &ContactProblem, forces: &[f64]) -> Vec<f64> {
    let mut found = vec![0.0; forces.len()];
    problem.contact.B.column.iter().for_each(|&i| found[i as usize] = forces[i as usize]);
    found
}

impl Certificate {
    /// What each body and each pair is held against.
    pub fn part_tolerance(&self) -> f64 {
        PART_TOLERANCE.max(self.tolerance)
    }

    /// The body or the pair that is farthest off by its own forces.
    pub fn worst_part(&self) -> Option<&PartMeasure> {
        self.parts.iter().max_by(|a, b| a.residual.total_cmp(&b.residual))
    }

    /// Whether no solver can do better: nothing but the rounding of the data exceeds its bound.
    pub fn is_as_good_as_the_data(&self) -> bool {
        let holds = |(name, value): (&str, f64)| name == DATA_ROUNDING || value <= self.tolerance;
        let parts = self.worst_part().is_none_or(|part| part.residual <= self.part_tolerance());
        self.passed || self.measures().into_iter().all(holds) && parts
    }

    /// How many times too large the worst of all measures is, those of bodies and pairs included; at most 1 if the
    /// certificate passes.
    pub fn missed(&self) -> f64 {
        let part = self.worst_part().map_or(0.0, |part| part.residual / self.part_tolerance());
        part.max(self.worst / self.tolerance)
    }

    /// The measures by name, in the order of reports.
    pub fn measures(&self) -> Vec<(&'static str, f64)> {
        let mut list = vec![
            ("equilibrium", self.equilibrium),
            ("penetration", self.penetration),
            ("tension", self.tension),
            ("cone", self.cone),
            ("slip_direction", self.slip_direction),
            ("bipotential_gap", self.bipotential_gap),
            ("natural_residual", self.natural_residual),
        ];
        if let Some(balance) = self.balance {
            list.insert(1, ("force_balance", balance.force));
            list.insert(2, ("moment_balance", balance.moment));
        }
        list.extend(self.data_rounding.map(|rounding| (DATA_ROUNDING, rounding)));
        list
    }
}
