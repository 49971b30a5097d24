use crate::contact::rigid::RigidMotions;
use crate::contact::{ContactProblem, Friction};
use crate::dual::Dual;
use crate::friction::law::parameters;
use crate::linalg::{Csr, SmallCholesky, axpy, dot, norm};

/// A rigid body on an elastic foundation (Winkler): where the points would be if only they yielded.
pub(in crate::friction) struct Foundation<'a> {
    pub friction: &'a [Friction],
    /// The jumps `G` of the rigid motions, `3m x k`. Each row jumps with the motions of two bodies.
    pub jumps: &'a Csr,
    /// `Rᵀ f`, newton.
    pub resultant: &'a [f64],
    /// `[gap - N u; slip_reference - T u]` where the rigid motions are zero, length, `3m`.
    pub gap: &'a [f64],
    /// Stiffness of each point, force per length, `m`.
    pub stiffness: &'a [f64],
}

/// Equilibrium of rigid bodies on their foundation.
pub(in crate::friction) struct Equilibrium {
    pub alpha: Vec<f64>,
    /// Forces of the foundation, `3m`.
    pub lambda: Vec<f64>,
}

/// The equilibrium of bodies that float, all parts taken to be rigid, when they may also move along `slices` (length `n` each),
/// along which forces `pull` (newton) act: displacements that begin at `u`, and how far each slice goes.
///
/// # Panics
/// If `u` or a slice has another length than the unknowns.
pub fn rigid_equilibrium(
    problem: &ContactProblem,
    motions: &RigidMotions,
    slices: &[Vec<f64>],
    pull: &[f64],
    mut u: Vec<f64>,
) -> (Vec<f64>, Vec<f64>) {
    let isotropic = problem.isotropic();
    let of_slices: Vec<Vec<f64>> = slices.iter().map(|slice| isotropic.contact.B.times(slice)).collect();
    let jumps = &motions.jumps(&isotropic.contact.B).beside(&of_slices);
    let along = slices.iter().zip(pull).map(|(slice, &pull)| along(slice, &problem.elastic.f, pull));
    let resultant = [balanced(motions, &problem.elastic.f), along.map(unless_rounding).collect()].concat();
    let mut gap = isotropic.gap_and_slip(&u);
    let stiffness = parameters(&isotropic, &Dual::local_stiffness(&isotropic));
    let friction = &isotropic.contact.friction[..];
    keep_apart(friction, &mut gap);
    let foundation = Foundation { friction, jumps, resultant: &resultant, gap: &gap, stiffness: &stiffness };
    let alpha = foundation.equilibrium().alpha;
    let (rigid, way) = alpha.split_at(motions.len());
    motions.add(rigid, &mut u);
    slices.iter().zip(way).for_each(|(slice, &way)| axpy(way, slice, &mut u));
    (u, ways(way, &resultant[motions.len()..]))
}

/// How far slices go: backwards only where something pulls that way, since without any force rounding decides.
pub(in crate::friction) fn ways(way: &[f64], resultant: &[f64]) -> Vec<f64> {
    way.iter().zip(resultant).map(|(&way, &along)| if along < 0.0 { way } else { way.max(0.0) }).collect()
}

/// `Rᵀ f` without what rounding leaves of loads in balance: bodies that nothing drives are to stay where they are.
pub(in crate::friction) fn balanced(motions: &RigidMotions, f: &[f64]) -> Vec<f64> {
    without_rounding(motions.work(f), motions.work_size(f))
}

/// The work of the loads `f` and of the force `pull` on a slice, and the sum of the sizes of its terms.
pub(in crate::friction) fn along(slice: &[f64], f: &[f64], pull: f64) -> [f64; 2] {
    let terms = slice.iter().zip(f).map(|(s, f)| s * f);
    terms.fold([pull, pull.abs()], |[sum, size], term| [sum + term, size + term.abs()])
}

/// A sum, or zero where it is what rounding leaves of the sizes of its terms.
pub(in crate::friction) fn unless_rounding([sum, size]: [f64; 2]) -> f64 {
    if sum.abs() <= Threshold::ROUNDING * size { 0.0 } else { sum }
}

/// The same of this work, where the sizes of the terms it adds up from have the sum `size`.
pub(in crate::friction) fn without_rounding(work: Vec<f64>, size: f64) -> Vec<f64> {
    work.into_iter().map(|e| unless_rounding([e, size])).collect()
}

/// Narrows all gaps (the first `m` numbers of `3m`) by the length it returns: what nothing presses then lies beside its
/// neighbours and not on them, where rounding would be its only force. What is bonded stays where it is: it would pull a body that
/// nothing loads after it.
pub(in crate::friction) fn keep_apart(friction: &[Friction], gap: &mut [f64]) -> f64 {
    let margin = Threshold::BESIDE * gap.iter().fold(0.0, |a: f64, v| a.max(v.abs()));
    let opens = friction.iter().map(|law| *law != Friction::Bonded);
    gap.iter_mut().zip(opens).filter(|(_, opens)| *opens).for_each(|(v, _)| *v -= margin);
    margin
}

/// Thresholds of a start, which need not be sharp: Newton's method corrects what they leave. Held against the floating bodies
/// among the random cases.
struct Threshold;

impl Threshold {
    /// How far a body is put beside others at the start, over the widest gap.
    const BESIDE: f64 = 1e-9;
    /// Of a sum of loads over the sum of their sizes.
    const ROUNDING: f64 = 1e-13;
    /// Steps of the fixed point on the bounds of friction; the first has none. A start needs no more.
    const ROUNDS: usize = 5;
    /// Steps of one energy; those that slip converge slowly, and need not arrive.
    const STEPS: usize = 30;
    /// The fixed point ends where no bound changes by more than this part of the largest.
    const BOUNDS: f64 = 1e-3;
    /// A search for the length of a step ends where the slope has fallen to this part of the first.
    const SLOPE: f64 = 1e-9;
    const DOUBLINGS: usize = 200;
    const SECANTS: usize = 60;
    /// Tangential stiffness that is left to every point with friction: it keeps a body that slides from leaving.
    const GUIDE: f64 = 1e-6;
}

impl Foundation<'_> {
    /// The rigid motions in equilibrium, by the fixed point on the bounds of friction.
    pub(crate) fn equilibrium(&self) -> Equilibrium {
        let m = self.friction.len();
        let given = |law: &Friction| match *law {
            Friction::Given { slip_bound } => slip_bound,
            _ => 0.0,
        };
        let mut bounds: Vec<f64> = self.friction.iter().map(given).collect();
        let (mut alpha, mut v) = (vec![0.0; self.jumps.cols], self.gap.to_vec());
        let mut lambda = vec![0.0; 3 * m];
        for _ in 0..Threshold::ROUNDS {
            self.least_energy(&bounds, &mut alpha, &mut v);
            let springs = self.springs(&v, &bounds);
            lambda = v.iter().zip(springs).map(|(v, s)| -s * v).collect();
            let found: Vec<f64> = (0..m).map(|j| self.friction[j].bound(lambda[j])).collect();
            // What is bonded has no bound.
            let finite = || found.iter().zip(&bounds).filter(|(new, _)| new.is_finite());
            let change = finite().fold(0.0, |a: f64, (new, old)| a.max((new - old).abs()));
            let largest = finite().fold(0.0, |a: f64, (new, _)| a.max(*new));
            bounds = found;
            if change <= Threshold::BOUNDS * largest {
                break;
            }
        }
        Equilibrium { alpha, lambda }
    }

    /// Newton's method with exact line search on the convex energy `1/2 sum of r |overlap|² + H(T u) - Rᵀf . alpha`, `H`
    /// quadratic until friction is at its bound and linear beyond (Huber); its curvature is taken by secants.
    fn least_energy(&self, bounds: &[f64], alpha: &mut [f64], v: &mut [f64]) {
        for _ in 0..Threshold::STEPS {
            let springs = self.springs(v, bounds);
            let force: Vec<f64> = v.iter().zip(&springs).map(|(v, s)| -s * v).collect();
            let held = self.jumps.transpose_times(&force);
            let lacking: Vec<f64> = self.resultant.iter().zip(held).map(|(e, held)| e - held).collect();
            if norm(&lacking) <= 1e-6 * norm(self.resultant) {
                break;
            }
            let Some(curvature) = SmallCholesky::new(self.curvature(&springs)) else { break };
            let d = curvature.solve(&lacking);
            let dv: Vec<f64> = self.jumps.times(&d).into_iter().map(|jump| -jump).collect();
            let t = self.least_along(v, &dv, dot(&d, self.resultant), bounds);
            if t == 0.0 {
                break;
            }
            axpy(t, &d, alpha);
            axpy(t, &dv, v);
        }
    }

    /// Stiffness of each row at the gap `v`: the force over the displacement.
    fn springs(&self, v: &[f64], bounds: &[f64]) -> Vec<f64> {
        let m = self.friction.len();
        let mut springs = vec![0.0; 3 * m];
        for j in 0..m {
            let [normal, tangential] = self.springs_at(j, [v[j], v[m + j], v[2 * m + j]], bounds[j]);
            springs[j] = normal;
            (springs[m + j], springs[2 * m + j]) = (tangential, tangential);
        }
        springs
    }

    /// Normal and tangential stiffness of point `j` at its gap.
    #[inline]
    fn springs_at(&self, j: usize, v: [f64; 3], bound: f64) -> [f64; 2] {
        let r = self.stiffness[j];
        let closed = if v[0] < 0.0 { r } else { 0.0 };
        match self.friction[j] {
            Friction::Bonded => [r, r],
            Friction::None => [closed, 0.0],
            Friction::Given { .. }
            | Friction::Coulomb { .. }
            | Friction::Limited { .. }
            | Friction::Cohesive { .. } => {
                let sliding = r * (v[1] * v[1] + v[2] * v[2]).sqrt();
                let ratio = if sliding > bound { bound / sliding } else { 1.0 };
                [closed, r * ratio.max(Threshold::GUIDE)]
            }
        }
    }

    /// Rows of the lower triangle.
    fn curvature(&self, springs: &[f64]) -> Vec<Vec<f64>> {
        let mut h: Vec<Vec<f64>> = (1..=self.jumps.cols).map(|k| vec![0.0; k]).collect();
        for (i, &spring) in springs.iter().enumerate().filter(|(_, spring)| **spring != 0.0) {
            for (k, a) in self.jumps.entries_of(i) {
                let row = &mut h[k as usize];
                let left = self.jumps.entries_of(i).take_while(|(other, _)| *other <= k);
                left.for_each(|(other, b)| row[other as usize] += spring * a * b);
            }
        }
        // A motion that nothing resists yet goes far; the line search ends it where something does.
        let all = dot(&self.jumps.value, &self.jumps.value);
        let largest = self.stiffness.iter().fold(0.0, |a: f64, s| a.max(*s));
        (0..h.len()).for_each(|k| h[k][k] += 1e-9 * all * largest / self.friction.len() as f64);
        h
    }

    /// The length at which the slope of the energy vanishes along a descent direction whose load does `work`; zero where rounding has left
    /// a direction that is none, as of bonded bodies that nothing loads.
    fn least_along(&self, v: &[f64], dv: &[f64], work: f64, bounds: &[f64]) -> f64 {
        let m = self.friction.len();
        let slope = |t: f64| {
            let mut slope = -work;
            for j in 0..m {
                let d = [dv[j], dv[m + j], dv[2 * m + j]];
                let v = [v[j] + t * d[0], v[m + j] + t * d[1], v[2 * m + j] + t * d[2]];
                let [normal, tangential] = self.springs_at(j, v, bounds[j]);
                slope += normal * v[0] * d[0] + tangential * (v[1] * d[1] + v[2] * d[2]);
            }
            slope
        };
        let (mut low, mut at_low) = (0.0, slope(0.0));
        if at_low >= 0.0 {
            return 0.0;
        }
        let enough = Threshold::SLOPE * at_low.abs();
        // Where bodies without loads have left one another the slope is zero from there on: they stay where it vanishes first.
        let is_least = |slope: f64| slope != 0.0 && slope.abs() <= enough;
        let (mut high, mut at_high) = (1.0, slope(1.0));
        for _ in 0..Threshold::DOUBLINGS {
            if at_high >= 0.0 {
                break;
            }
            (low, at_low) = (high, at_high);
            high *= 2.0;
            at_high = slope(high);
        }
        if is_least(at_high) {
            return high;
        }
        // Secants, and the middle after one that has not halved what is left.
        let mut halve = false;
        for _ in 0..Threshold::SECANTS {
            let width = high - low;
            let secant = (low * at_high - high * at_low) / (at_high - at_low);
            let middle = if halve || at_high == 0.0 { low + 0.5 * width } else { secant };
            let now = slope(middle);
            if is_least(now) {
                return middle;
            }
            *(if now < 0.0 { &mut low } else { &mut high }) = middle;
            *(if now < 0.0 { &mut at_low } else { &mut at_high }) = now;
            halve = high - low > 0.5 * width;
        }
        low
    }
}
