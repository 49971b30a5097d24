use crate::contact::Friction;
use crate::dual::{Dual, Inverse};
use crate::friction::law::{augmented, bound, slope};
use crate::linalg::{SmallLu, axpy, dot, gmres};

/// One unknown of a Newton step.
#[derive(Debug, Clone, Copy)]
enum Unknown {
    /// The multiplier `i`; its equation is that the jump in row `i` vanishes.
    Component { i: usize },
    /// The normal multiplier `i` of a point that slips along `direction`: friction `slope * lambda_n` follows it.
    SlippingNormal { i: usize, tangents: [usize; 2], direction: [f64; 2], slope: f64 },
    /// The turn of the friction at a slipping point, across its direction.
    Turn { tangents: [usize; 2], across: [f64; 2] },
}

/// The linear system of one semismooth Newton step, reduced to what is not known beforehand.
///
/// With `v = Q lambda - h` and `a = lambda - r v` the step `d` of Alart & Curnier's equations obeys at a point:
/// open: `d = -lambda`; in contact: `(Q d)_n = -v_n`; stick: `(Q d)_t = -v_t`; slip along `e = a_t / |a_t|` under the
/// bound `g`: `lambda_t + d_t` has the component `F (lambda_n + d_n)` (or the given bound) along `e`, and across it
/// `q (Q d)_x + (1 - q)/r d_x = -v_x` with `q = g / |a_t|`. Every row is the residual over `r`, so that the accuracy
/// of the inner iteration is that of the residual.
pub(super) struct NewtonSystem {
    unknowns: Vec<Unknown>,
    rhs: Vec<f64>,
    /// The factor of `Q` in each equation; one but for a turn.
    share: Vec<f64>,
    /// What the curvature of the circle adds to the diagonal of a turn, length per force.
    softness: Vec<f64>,
    /// Diagonal of the preconditioner.
    weight: Vec<f64>,
    /// The part of the step that is known, length `3m`.
    known: Vec<f64>,
    /// Slipping points with their tangential rows and direction.
    slips: Vec<(usize, [usize; 2], [f64; 2])>,
}

/// A Newton direction with its image, so that no product is needed along it.
pub(super) struct Step {
    pub d: Vec<f64>,
    /// The change of `v`: `Q d - G d_alpha`.
    pub dv: Vec<f64>,
    /// The change of the rigid motions of bodies that float.
    pub d_alpha: Vec<f64>,
    /// False if bodies float and nothing resists any of their motions.
    pub resisted: bool,
}

/// The rigid motions of floating bodies within a Newton step: further unknowns `alpha`, whose equations are the balance
/// of forces, and their part in the preconditioner
///
/// ```text
/// [ Â   -G_r ] [ y ]   [ x ]        y = Â⁻¹ x + Y a,   Y = Â⁻¹ G_r,   C = G_eᵀ Y
/// [ G_eᵀ  0  ] [ a ] = [ b ]        C a = b - G_eᵀ Â⁻¹ x
/// ```
/// exact in the balance: every direction of the inner iteration keeps it (Farhat & Roux 1991, the coarse problem).
struct Border<'a> {
    jumps: &'a [Vec<f64>],
    /// Columns of `G_e = Eᵀ G` and `Y`.
    work: Vec<Vec<f64>>,
    answer: Vec<Vec<f64>>,
    coarse: SmallLu,
    /// False if nothing resists any motion.
    resisted: bool,
}

/// Resistance given to motions that have none, over the largest: enough to tell them from rounding.
const GUIDE: f64 = 1e-8;

impl Border<'_> {
    /// Completes `y = Â⁻¹ x` to the solution `[y; a]` for the imbalance `b`.
    fn complete(&self, mut y: Vec<f64>, b: &[f64]) -> Vec<f64> {
        let lacking: Vec<f64> = b.iter().zip(&self.work).map(|(b, g)| b - dot(g, &y)).collect();
        let a = self.coarse.solve(&lacking);
        a.iter().zip(&self.answer).for_each(|(&a, column)| axpy(a, column, &mut y));
        y.extend(a);
        y
    }
}

/// Where the equations of a Newton step are linearised.
pub(super) struct Linearized<'a> {
    pub friction: &'a [Friction],
    /// A slipping point whose coefficient exceeds this keeps its present bound: its friction does not follow the normal
    /// force within the step.
    pub largest_slope: f64,
    /// False for an empty row of `B`, length `3m`.
    pub live: &'a [bool],
    /// Local stiffness of each row, `3m`.
    pub stiffness: &'a [f64],
    pub lambda: &'a [f64],
    pub v: &'a [f64],
    pub r: &'a [f64],
    /// For a step of the proximal method of multipliers, whose `a` is `centre - r v`. Every equation of an unknown then
    /// has `d / r` on the left (that of a turn in place of its own softness) and `(centre - lambda) / r` added on the right.
    pub centre: Option<&'a [f64]>,
}

impl NewtonSystem {
    /// Linearises the equations at a point.
    pub fn new(at: &Linearized<'_>) -> NewtonSystem {
        let &Linearized { friction, largest_slope, live, stiffness, lambda, v, r, centre } = at;
        let m = r.len();
        let mut system = NewtonSystem {
            unknowns: Vec::new(),
            rhs: Vec::new(),
            share: Vec::new(),
            softness: Vec::new(),
            weight: Vec::new(),
            known: vec![0.0; 3 * m],
            slips: Vec::new(),
        };
        for j in 0..m {
            let rows = [j, m + j, 2 * m + j];
            // Softness that the proximal term gives every unknown, and `v` less what it pulls.
            let soft = if centre.is_some() { 1.0 / r[j] } else { 0.0 };
            let pulled = |i: usize| v[i] - centre.map_or(0.0, |c| (c[i] - lambda[i]) / r[j]);
            if friction[j] == Friction::Bonded {
                rows.into_iter().filter(|&i| live[i]).for_each(|i| system.component(i, -pulled(i), soft, stiffness[i]));
                continue;
            }
            let a = augmented(centre.unwrap_or(lambda), v, r, j);
            let limit = bound(friction[j], a[0]);
            let tangents = [rows[1], rows[2]];
            let length = a[1].hypot(a[2]);
            let in_contact = a[0] > 0.0 && live[j];
            if !in_contact {
                system.known[j] = -lambda[j];
            }
            if limit <= 0.0 {
                tangents.into_iter().for_each(|i| system.known[i] = -lambda[i]);
            } else if length <= limit {
                let live = tangents.into_iter().filter(|&i| live[i]);
                live.for_each(|i| system.component(i, -pulled(i), soft, stiffness[i]));
            } else {
                let e = [a[1] / length, a[2] / length];
                system.slips.push((j, tangents, e));
                let along = lambda[rows[1]] * e[0] + lambda[rows[2]] * e[1];
                let slope = Some(slope(friction[j], a[0])).filter(|&slope| slope <= largest_slope).unwrap_or(0.0);
                let target = if slope > 0.0 { slope * lambda[j] } else { limit };
                tangents.into_iter().zip(e).for_each(|(i, e)| system.known[i] = e * (target - along));
                if slope > 0.0 {
                    let unknown = Unknown::SlippingNormal { i: j, tangents, direction: e, slope };
                    system.push(unknown, -pulled(j), 1.0, soft, stiffness[j]);
                }
                if live[rows[1]] && live[rows[2]] {
                    let across = [-e[1], e[0]];
                    let (share, local) = (limit / length, 0.5 * (stiffness[rows[1]] + stiffness[rows[2]]));
                    let softness = if centre.is_some() { soft } else { (1.0 - share) / r[j] };
                    let rhs = -(pulled(rows[1]) * across[0] + pulled(rows[2]) * across[1]);
                    system.push(Unknown::Turn { tangents, across }, rhs, share, softness, local);
                }
                if slope > 0.0 {
                    continue; // the normal multiplier is among the unknowns already
                }
            }
            if in_contact {
                system.component(j, -pulled(j), soft, stiffness[j]);
            }
        }
        system
    }

    fn component(&mut self, i: usize, rhs: f64, softness: f64, local: f64) {
        self.push(Unknown::Component { i }, rhs, 1.0, softness, local);
    }

    /// `local` is the stiffness by which the preconditioner weighs the softness.
    fn push(&mut self, unknown: Unknown, rhs: f64, share: f64, softness: f64, local: f64) {
        self.unknowns.push(unknown);
        self.rhs.push(rhs);
        self.share.push(share);
        self.softness.push(softness);
        self.weight.push(1.0 / (1.0 + softness / share * local).sqrt());
    }

    /// `d += E y`: what the unknowns `y` contribute to the step.
    fn expand(&self, y: &[f64], d: &mut [f64]) {
        for (unknown, &y) in self.unknowns.iter().zip(y) {
            match *unknown {
                Unknown::Component { i } => d[i] += y,
                Unknown::SlippingNormal { i, tangents, direction, slope } => {
                    d[i] += y;
                    tangents.into_iter().zip(direction).for_each(|(t, e)| d[t] += slope * e * y);
                }
                Unknown::Turn { tangents, across } => {
                    tangents.into_iter().zip(across).for_each(|(t, x)| d[t] += x * y);
                }
            }
        }
    }

    /// `Eᵀ w`: the work of `w` on what the unknowns contribute to the step.
    fn gather(&self, w: &[f64]) -> Vec<f64> {
        let work = |unknown: &Unknown| match *unknown {
            Unknown::Component { i } => w[i],
            Unknown::SlippingNormal { i, tangents: [t1, t2], direction: [a, b], slope } => {
                w[i] + slope * (a * w[t1] + b * w[t2])
            }
            Unknown::Turn { tangents: [t1, t2], across: [a, b] } => a * w[t1] + b * w[t2],
        };
        self.unknowns.iter().map(work).collect()
    }

    /// `Pᵀ w`: the jump in the rows of the equations.
    fn restrict(&self, w: &[f64]) -> Vec<f64> {
        let row = |unknown: &Unknown| match *unknown {
            Unknown::Component { i } | Unknown::SlippingNormal { i, .. } => w[i],
            Unknown::Turn { tangents, across } => w[tangents[0]] * across[0] + w[tangents[1]] * across[1],
        };
        self.unknowns.iter().map(row).collect()
    }

    /// Among slipping points the lumped inverse takes as few products as the exact one (measured) and costs nothing;
    /// among sticking ones the exact one takes a third of them.
    fn inverse(&self) -> Inverse {
        let slipping = self.slips.len();
        // A slipping point has at most two unknowns, a sticking one three.
        let sticking = self.unknowns.len().saturating_sub(2 * slipping) / 3;
        if slipping > sticking { Inverse::Lumped } else { Inverse::Dirichlet }
    }

    /// An approximate inverse of `share Pᵀ Q P + softness`: `W Pᵀ S P W / share` with `S ~ Q⁻¹` and the diagonal
    /// `W = (1 + softness/share * stiffness)^(-1/2)`, exact for a diagonal `Q` without and with large softness.
    fn precondition(&self, dual: &Dual, x: &[f64]) -> Vec<f64> {
        let mut full = vec![0.0; self.known.len()];
        for (k, unknown) in self.unknowns.iter().enumerate() {
            let y = x[k] * self.weight[k] / self.share[k];
            match *unknown {
                Unknown::Component { i } | Unknown::SlippingNormal { i, .. } => full[i] += y,
                Unknown::Turn { tangents, across } => {
                    tangents.into_iter().zip(across).for_each(|(t, a)| full[t] += a * y);
                }
            }
        }
        let mut result = self.restrict(&dual.approximate_inverse(&full, self.inverse()));
        result.iter_mut().zip(&self.weight).for_each(|(r, w)| *r *= w);
        result
    }

    /// Points that slip.
    pub fn slipping(&self) -> impl Iterator<Item = usize> + '_ {
        self.slips.iter().map(|s| s.0)
    }

    /// The same operator with another right-hand side: the answer of the points to a change `dg` of the bounds of the
    /// slipping ones (in the order of [`Self::slipping`]).
    pub fn answer_to(&mut self, dg: &[f64]) {
        self.rhs.fill(0.0);
        self.known.fill(0.0);
        for ((_, tangents, e), dg) in self.slips.iter().zip(dg) {
            tangents.iter().zip(e).for_each(|(&i, e)| self.known[i] = e * dg);
        }
    }

    /// A motion that nothing drives and no point in contact feels stays as it is.
    fn border<'a>(&self, dual: &Dual, jumps: &'a [Vec<f64>], imbalance: &[f64]) -> Border<'a> {
        let answer = |jump: &Vec<f64>| {
            let rows = self.restrict(jump);
            let rows: Vec<f64> = rows.iter().zip(&self.share).map(|(g, share)| share * g).collect();
            self.precondition(dual, &rows)
        };
        let work: Vec<Vec<f64>> = jumps.iter().map(|jump| self.gather(jump)).collect();
        let answer: Vec<Vec<f64>> = jumps.iter().map(answer).collect();
        let mut resistance: Vec<Vec<f64>> = work.iter().map(|g| answer.iter().map(|y| dot(g, y)).collect()).collect();
        let largest = (0..jumps.len()).fold(0.0, |a: f64, k| a.max(resistance[k][k]));
        for (k, g) in work.iter().enumerate() {
            if imbalance[k] == 0.0 && g.iter().all(|&g| g == 0.0) {
                resistance[k][k] = if largest > 0.0 { largest } else { 1.0 };
            }
        }
        let resisted = largest > 0.0 || imbalance.iter().all(|&b| b == 0.0);
        let mut coarse = SmallLu::new(resistance.clone());
        if coarse.singular {
            // A body on too few points to be held, as a ball on one, can be at rest: then the motion is left alone.
            let guided = |(k, mut row): (usize, Vec<f64>)| {
                row[k] += GUIDE * largest;
                row
            };
            coarse = SmallLu::new(resistance.into_iter().enumerate().map(guided).collect());
        }
        Border { jumps, work, answer, coarse, resisted }
    }

    /// The step and what it does to `v`, at one product with `Q`.
    fn image(&self, dual: &Dual, border: &Border, d: &[f64], d_alpha: &[f64]) -> Vec<f64> {
        let moves = d.iter().any(|&x| x != 0.0);
        let mut image = if moves { dual.times(d) } else { vec![0.0; d.len()] };
        border.jumps.iter().zip(d_alpha).for_each(|(jump, &a)| axpy(-a, jump, &mut image));
        image
    }

    /// Solves the step to the relative accuracy `tolerance` by preconditioned GMRES, at most `limit` products.
    ///
    /// `jumps` are those of the rigid motions and `imbalance` what the present forces lack of balance; both are empty
    /// where every body is held.
    pub fn solve(&self, dual: &Dual, jumps: &[Vec<f64>], imbalance: &[f64], tolerance: f64, limit: usize) -> Step {
        let (size, count) = (self.known.len(), self.unknowns.len());
        let border = self.border(dual, jumps, imbalance);
        // A first step restores the balance; those of the inner iteration keep it.
        let lacking: Vec<f64> = imbalance.iter().zip(jumps).map(|(b, g)| b - dot(g, &self.known)).collect();
        let first = border.complete(vec![0.0; count], &lacking);
        let (mut d, mut d_alpha) = (self.known.clone(), first[count..].to_vec());
        self.expand(&first[..count], &mut d);
        let mut dv = self.image(dual, &border, &d, &d_alpha);
        let known = self.restrict(&dv);
        let rhs: Vec<f64> =
            (0..count).map(|k| self.rhs[k] - self.share[k] * known[k] - self.softness[k] * first[k]).collect();
        let mut images = Vec::new();
        let operator = |z: &[f64]| {
            let mut full = vec![0.0; size];
            self.expand(&z[..count], &mut full);
            let image = self.image(dual, &border, &full, &z[count..]);
            let w = self.restrict(&image);
            images.push(image);
            (0..w.len()).map(|k| self.share[k] * w[k] + self.softness[k] * z[k]).collect()
        };
        let balanced = vec![0.0; jumps.len()];
        let precondition = |x: &[f64]| border.complete(self.precondition(dual, x), &balanced);
        let krylov = gmres(operator, precondition, &rhs, tolerance, limit);
        for ((&c, z), image) in krylov.coefficient.iter().zip(&krylov.directions).zip(&images) {
            let scaled: Vec<f64> = z.iter().map(|z| c * z).collect();
            self.expand(&scaled[..count], &mut d);
            axpy(1.0, &scaled[count..], &mut d_alpha);
            axpy(c, image, &mut dv);
        }
        Step { d, dv, d_alpha, resisted: border.resisted }
    }
}
