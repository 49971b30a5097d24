use super::balance::{Balance, BodyBalance, balances, worst};
use super::duality::duality_gap;
use crate::contact::rigid::components;
use crate::contact::{ContactProblem, Friction};

/// How far an answer is from solving its problem; see [`certify`] for the definitions.
#[derive(Debug, Clone, PartialEq)]
pub struct Certificate {
    /// `|f - K u - Bᵀ lambda| / max(|f|, |Bᵀ lambda|)`: a body may be loaded by its overlap alone.
    pub equilibrium: f64,
    /// Force and moment of loads, reactions and contact, the worst of all bodies; `None` for a problem without supports.
    pub balance: Option<Balance>,
    /// The same of each body; empty for a problem without supports.
    pub bodies: Vec<BodyBalance>,
    /// `max(N u - gap)+ / max|u|`; at tied points the largest jump.
    pub penetration: f64,
    /// `max(-lambda_n)+ / max|lambda_n|`.
    pub tension: f64,
    /// `max(|lambda_t| - bound)+ / max bound`; where friction differs by direction `|(lambda_t1, lambda_t2 / a)|` is
    /// what is held against the bound, `a` the friction across the first tangent over that along it.
    pub cone: f64,
    /// `max(bound |s| - lambda_t . s) / (max bound * max|u|)`: zero where friction is parallel to the slip and at
    /// its bound, or along the slip's image where friction differs by direction: `|(s_1, a s_2)|` stands for `|s|` here
    /// and below. Not over the largest slip, which is nothing but rounding where all points stick.
    pub slip_direction: f64,
    /// Sum of `lambda_n (gap - N u) + bound |s| - lambda_t . s` over the sum of its terms' magnitudes or the elastic
    /// work `u'Ku`, whichever is larger (without friction on a flat obstacle all terms vanish). De Saxcé & Feng 1998.
    pub bipotential_gap: f64,
    /// `|lambda - P(lambda - r w)| / |lambda|`, `P` the projection on the cone of friction (given friction: on the
    /// half-line and disc), `w` the jump in De Saxcé's form, `r` the mean stiffness of the points of a pair, of both bodies in
    /// a row. Where friction differs by direction both are taken in
    /// coordinates in which the cone is round: forces across over `a`, slips times `a`. What rounding of the jump explains is
    /// not counted.
    pub natural_residual: f64,
    /// For given friction (no Coulomb point): primal energy of a displacement near `u` that does not penetrate less
    /// the dual energy of `lambda`, a bound of `1/2 |u - u*|²_K` for admissible `lambda` in equilibrium; energy.
    pub duality_gap: Option<f64>,
    /// The largest of the measures.
    pub worst: f64,
    pub tolerance: f64,
    /// Whether `worst <= tolerance`.
    pub passed: bool,
}

/// Judges `u` (length `n`) and `lambda` (length `3m`) against `tolerance`.
pub fn certify(problem: &ContactProblem, u: &[f64], lambda: &[f64], tolerance: f64) -> Certificate {
    let m = problem.contact.friction.len();
    let elastic = problem.elastic.K.times(u);
    let contact_force = problem.contact.B.transpose_times(lambda);
    let imbalance = (0..u.len()).map(|i| problem.elastic.f[i] - elastic[i] - contact_force[i]);
    let work: f64 = u.iter().zip(&elastic).map(|(u, f)| u * f).sum();
    let jump = problem.contact.B.times(u);
    let points: Vec<Point> = (0..m).map(|j| Point::new(problem, &jump, lambda, j)).collect();
    let largest_u = largest(u).max(problem.labels.supports.as_ref().map_or(0.0, |s| largest(&s.displacement)));
    let largest_bound = points.iter().fold(0.0, |a: f64, p| a.max(p.bound));
    let largest_normal = largest(&lambda[..m]);
    let over_points = |f: &dyn Fn(&Point) -> f64| points.iter().fold(0.0, |a: f64, p| f64::max(a, f(p)));
    let (gap, terms) = bipotential(&points);
    let bodies = balances(problem, u, lambda).unwrap_or_default();
    let mut certificate = Certificate {
        equilibrium: ratio(
            length(imbalance),
            length(problem.elastic.f.iter().copied()).max(length(contact_force.iter().copied())),
        ),
        balance: worst(&bodies),
        bodies,
        penetration: ratio(over_points(&Point::violation), largest_u),
        tension: ratio(over_points(&|p| if p.tied { 0.0 } else { -p.normal }), largest_normal),
        cone: ratio(over_points(&|p| if p.tied { 0.0 } else { p.friction_length() - p.bound }), largest_bound),
        slip_direction: ratio(over_points(&Point::misdirection), largest_bound * largest_u),
        bipotential_gap: ratio(gap, terms.max(work)),
        natural_residual: natural_residual(problem, &points, u, lambda),
        duality_gap: duality_gap(problem, u, lambda),
        worst: 0.0,
        tolerance,
        passed: false,
    };
    certificate.worst = certificate.measures().iter().fold(0.0, |a, (_, v)| if v.is_nan() || *v > a { *v } else { a });
    certificate.passed = certificate.worst <= tolerance && u.iter().chain(lambda).all(|x| x.is_finite());
    certificate
}

impl Certificate {
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
        list
    }
}

/// One contact point: forces and kinematics, with slip as in the law (`lambda_t` points along it).
struct Point {
    tied: bool,
    /// The coefficient where friction follows the normal force.
    coulomb: Option<f64>,
    /// `lambda_n`.
    normal: f64,
    friction: [f64; 2],
    /// `gap` and `N u`.
    gap: f64,
    approach: f64,
    slip: [f64; 2],
    /// Along the first tangent.
    bound: f64,
    /// Friction across the first tangent over that along it.
    across: f64,
}

impl Point {
    fn new(problem: &ContactProblem, jump: &[f64], lambda: &[f64], j: usize) -> Point {
        let m = problem.contact.friction.len();
        let normal = lambda[j];
        let (coulomb, bound) = match problem.contact.friction[j] {
            Friction::None | Friction::Bonded => (None, 0.0),
            Friction::Given { slip_bound } => (None, slip_bound),
            Friction::Coulomb { coefficient } => (Some(coefficient), coefficient * normal.max(0.0)),
            // Beyond its limit friction does not follow the normal force: the bound is as good as given.
            Friction::Limited { coefficient, limit } if coefficient * normal > limit => (None, limit),
            Friction::Limited { coefficient, .. } => (Some(coefficient), coefficient * normal.max(0.0)),
        };
        Point {
            tied: problem.contact.friction[j] == Friction::Bonded,
            coulomb,
            normal,
            friction: [lambda[m + j], lambda[2 * m + j]],
            gap: problem.contact.gap[j],
            approach: jump[j],
            slip: [
                jump[m + j] - problem.contact.slip_reference[j],
                jump[2 * m + j] - problem.contact.slip_reference[m + j],
            ],
            bound,
            across: problem.contact.orthotropy.as_ref().map_or(1.0, |across| across[j]),
        }
    }

    fn opening(&self) -> f64 {
        self.gap - self.approach
    }

    /// The slip in coordinates in which the ellipse of friction is a disc; of a tied point the slip itself.
    fn round_slip(&self) -> [f64; 2] {
        if self.tied { self.slip } else { [self.slip[0], self.across * self.slip[1]] }
    }

    /// The force there; infinite where there may be none.
    fn round_friction(&self) -> [f64; 2] {
        let across = if self.friction[1] == 0.0 { 0.0 } else { self.friction[1] / self.across };
        [self.friction[0], across]
    }

    /// Dissipation over bound.
    fn slip_length(&self) -> f64 {
        let [along, across] = self.round_slip();
        along.hypot(across)
    }

    /// What is held against the bound.
    fn friction_length(&self) -> f64 {
        let [along, across] = self.round_friction();
        along.hypot(across)
    }

    fn friction_work(&self) -> f64 {
        self.friction[0] * self.slip[0] + self.friction[1] * self.slip[1]
    }

    /// Penetration, or the whole jump of a tied point; length.
    fn violation(&self) -> f64 {
        if self.tied { self.opening().abs().max(self.slip_length()) } else { -self.opening() }
    }

    fn misdirection(&self) -> f64 {
        if self.tied { 0.0 } else { self.bound * self.slip_length() - self.friction_work() }
    }
}

/// The gap of the bipotential and the sum of the magnitudes of its terms; work.
fn bipotential(points: &[Point]) -> (f64, f64) {
    let (mut sum, mut terms) = (0.0, 0.0);
    for p in points.iter().filter(|p| !p.tied) {
        sum += p.normal * p.opening() + p.misdirection();
        let dissipated = p.bound * p.slip_length();
        terms += (p.normal * p.gap).abs() + (p.normal * p.approach).abs() + dissipated + p.friction_work().abs();
    }
    (sum.abs(), terms)
}

fn natural_residual(problem: &ContactProblem, points: &[Point], u: &[f64], lambda: &[f64]) -> f64 {
    // A point of no pair would go unjudged: not a number is never passed.
    let mut r_of = vec![f64::NAN; points.len()];
    problem.labels.pairs.iter().zip(pair_stiffness(problem)).for_each(|(pair, r)| r_of[pair.points.clone()].fill(r));
    let (mut square, mut rounding) = (0.0, 0.0);
    for (j, (p, r)) in points.iter().zip(r_of).enumerate() {
        rounding += (r * f64::EPSILON * jump_size(problem, u, j)).powi(2);
        let (friction, slip) = (p.round_friction(), p.round_slip());
        let w = [p.opening() + p.coulomb.map_or(0.0, |c| c * p.slip_length()), -slip[0], -slip[1]];
        if p.tied {
            square += (r * p.opening()).powi(2) + (r * p.slip_length()).powi(2);
            continue;
        }
        let y = [p.normal - r * w[0], friction[0] - r * w[1], friction[1] - r * w[2]];
        let projected = match p.coulomb {
            Some(coefficient) => onto_cone(coefficient, y),
            None => {
                let shrink = p.bound / y[1].hypot(y[2]).max(p.bound).max(f64::MIN_POSITIVE);
                [y[0].max(0.0), y[1] * shrink, y[2] * shrink]
            }
        };
        square += (p.normal - projected[0]).powi(2);
        square += (friction[0] - projected[1]).powi(2) + (friction[1] - projected[2]).powi(2);
    }
    // Where points but graze, forces may be smaller than what rounding of the jump makes of them.
    ratio(square.sqrt() - 10.0 * rounding.sqrt(), length(lambda.iter().copied()))
}

/// What the jump of point `j` adds up from: magnitudes of the gap and of all entries; length.
fn jump_size(problem: &ContactProblem, u: &[f64], j: usize) -> f64 {
    let of_row = |i: usize| {
        let (columns, values) = problem.contact.B.row(i);
        columns.iter().zip(values).map(|(&k, b)| (b * u[k as usize]).abs()).sum::<f64>()
    };
    problem.contact.gap[j].abs() + problem.rows(j).into_iter().map(of_row).sum::<f64>()
}

/// Euclidean projection on `|y_t| <= F y_n`.
fn onto_cone(coefficient: f64, y: [f64; 3]) -> [f64; 3] {
    let tangential = y[1].hypot(y[2]);
    if tangential <= coefficient * y[0] {
        return y;
    }
    if coefficient * tangential <= -y[0] {
        return [0.0; 3];
    }
    let normal = (y[0] + coefficient * tangential) / (1.0 + coefficient * coefficient);
    let shrink = coefficient * normal / tangential;
    [normal, y[1] * shrink, y[2] * shrink]
}

/// For each pair the mean over its rows `b` of `B` of the force that closes the jump by a unit length: turns a
/// displacement into a force.
///
/// On one body the force is `b K bᵀ / |b|⁴`, as if all else were held. Between bodies the same force stretches both and
/// compliances add: with the sum of the stiffnesses a soft body on a stiff one was judged by forces that a displacement of
/// its own size would cause in the stiff one, beyond what rounding leaves of the solution. And what one pair touches does
/// not measure another.
fn pair_stiffness(problem: &ContactProblem) -> Vec<f64> {
    let body = match &problem.labels.bodies {
        Some(bodies) => bodies.of.clone(),
        None => {
            let mut body = vec![0; problem.elastic.K.rows];
            for (number, unknowns) in components(&problem.elastic.K).iter().enumerate() {
                unknowns.iter().for_each(|&i| body[i as usize] = number as u32);
            }
            body
        }
    };
    let m = problem.contact.friction.len();
    let mean = |points: std::ops::Range<usize>| {
        let rows = (0..3).flat_map(|k| points.clone().map(move |j| k * m + j));
        let forces: Vec<f64> = rows.filter_map(|i| stiffness(problem, &body, i)).collect();
        if forces.is_empty() { 0.0 } else { forces.iter().sum::<f64>() / forces.len() as f64 }
    };
    problem.labels.pairs.iter().map(|pair| mean(pair.points.clone())).collect()
}

/// The force along row `i` of `B` that closes its jump by a unit length; `None` for an empty row.
fn stiffness(problem: &ContactProblem, body: &[u32], i: usize) -> Option<f64> {
    let (columns, values) = problem.contact.B.row(i);
    let entries = || columns.iter().zip(values).filter(|(_, b)| **b != 0.0).map(|(&j, &b)| (j as usize, b));
    let mut touched: Vec<u32> = entries().map(|(j, _)| body[j]).collect();
    touched.sort_unstable();
    touched.dedup();
    let compliance = |own: u32| {
        let part = || entries().filter(|(j, _)| body[*j] == own);
        let square: f64 = part().map(|(_, b)| b * b).sum();
        let energy: f64 = part()
            .flat_map(|p| part().map(move |q| (p, q)))
            .map(|((j, a), (k, b))| a * b * problem.elastic.K.entry(j, k))
            .sum();
        (square * square, energy)
    };
    match touched[..] {
        [] => None,
        [one] => {
            let (square, energy) = compliance(one);
            Some(energy / square)
        }
        _ => {
            Some(1.0 / touched.iter().map(|&own| compliance(own)).map(|(square, energy)| square / energy).sum::<f64>())
        }
    }
}

fn length(x: impl Iterator<Item = f64>) -> f64 {
    x.map(|v| v * v).sum::<f64>().sqrt()
}

fn largest(x: &[f64]) -> f64 {
    x.iter().fold(0.0, |a: f64, v| a.max(v.abs()))
}

/// `value+ / scale`, zero if there is nothing to measure and infinite if there is but no scale for it.
pub(super) fn ratio(value: f64, scale: f64) -> f64 {
    if value.is_nan() || scale.is_nan() {
        f64::INFINITY
    } else if value <= 0.0 {
        0.0
    } else {
        value / scale
    }
}
