//! The dual of an elastic problem as a [`System`]: Newton steps by GMRES, rigid motions of floating bodies as a border.

use super::shared_nodes::{SharedNode, shared_nodes};
use crate::contact::ContactProblem;
use crate::dual::{Dual, Inverse};
use crate::friction::law::{Linearisation, V3};
use crate::friction::system::{Iterate, Step, System, by_component, by_point, moved};
use crate::linalg::{Csr, SmallLu, Stop, axpy, dot, gmres, norm};

/// Products one linear system may take.
const INNER_LIMIT: usize = 300;
/// Compliance that the steps of points on a shared node get, times their stiffness, a proximal term about the present iterate (Rockafellar
/// 1976): without it forces that nothing feels, or next to nothing, grow without bound. The residual knows nothing of it, and falls
/// by about this factor a step. Corners of rough planes take 6 to 17 steps.
const SHARED_COMPLIANCE: f64 = 1e-3;
/// Where the points of a shared node contradict one another (one sticks, the other asks it to move by a clearance), only forces that nothing
/// feels can change a state: the compliance is so small then that a step changes them by one over this. A block in a corner with clearances
/// from 5e-12 to 5e-6 of its size, 30 cases: all but one are solved; with 10 and 20 all but 4 and 8, without this all but 20.
const SHARED_FORCE: f64 = 5.0;
/// What such points may be apart, times the stiffness over the forces; 1e-8 leaves 2 of these cases.
const APART: f64 = 3e-8;

/// `v = Q lambda - G alpha - h` with `Gᵀ lambda = Rᵀ f` on the rigid motions of floating bodies.
pub(super) struct DualSystem<'a> {
    pub dual: &'a Dual,
    /// Local stiffness of each row, force per length; zero for an empty row of `B`.
    pub stiffness: Vec<V3>,
    /// Points whose forces are not unique.
    shared: Vec<SharedNode>,
    /// `Rᵀ f`, newton; empty where every body is held.
    pub resultant: Vec<f64>,
    /// Ends linear systems.
    pub stop: &'a Stop,
}

impl<'a> DualSystem<'a> {
    /// With the local stiffness of `problem`; `resultant` is `Rᵀ f`.
    pub(super) fn new(problem: &ContactProblem, dual: &'a Dual, resultant: Vec<f64>, stop: &'a Stop) -> Self {
        let stiffness = by_point(&Dual::local_stiffness(problem));
        DualSystem { dual, stiffness, shared: shared_nodes(problem), resultant, stop }
    }

    /// A multiplier of point `j` without the components that have no row of `B`.
    pub(super) fn masked(&self, j: usize, lambda: V3) -> V3 {
        let has_row = self.has_row(j);
        std::array::from_fn(|i| if has_row[i] { lambda[i] } else { 0.0 })
    }

    /// The laws with the compliance that forces at shared nodes need to be unique; these are the present ones.
    fn regular(&self, forces: &[V3], points: &[Linearisation]) -> Vec<Linearisation> {
        let mut points = points.to_vec();
        for shared in &self.shared {
            let largest = |x: &dyn Fn(usize) -> V3| shared.points.iter().map(|&j| norm(&x(j))).fold(0.0, f64::max);
            let (force, lacking) = (largest(&|j| forces[j]), largest(&|j| points[j].rhs));
            for &j in &shared.points {
                let stiffness = self.stiffness[j].into_iter().fold(f64::MIN_POSITIVE, f64::max);
                let apart = lacking * stiffness;
                let turns = apart > APART * force && SHARED_FORCE * apart < SHARED_COMPLIANCE * force;
                let part = if turns { SHARED_FORCE * apart / force } else { SHARED_COMPLIANCE };
                points[j] = points[j].with_compliance(part / stiffness);
            }
        }
        points
    }

    /// Solves the linearised laws to the relative accuracy `accuracy` by preconditioned GMRES, at most `limit` products.
    /// `imbalance` is what the present forces lack of balance.
    pub(super) fn solve(
        &self,
        forces: &[V3],
        points: &[Linearisation],
        imbalance: &[f64],
        accuracy: f64,
        limit: usize,
    ) -> Step {
        let points = &self.regular(forces, points);
        let equations = Equations::new(self, points);
        let jumps = &self.dual.floating.jumps;
        let border = equations.border(jumps, imbalance);
        // A first step restores the balance; those of the inner iteration keep it.
        let known = by_component(&points.iter().map(|p| p.known).collect::<Vec<_>>());
        let lacking = self.dual.floating.imbalance(imbalance, &known);
        let count = equations.count;
        let first = border.complete(vec![0.0; count], &lacking);
        let (mut d, mut d_alpha) = (known, first[count..].to_vec());
        equations.expand(&first[..count], &mut d);
        let mut dv = equations.image(&border, &d, &d_alpha);
        let mut rhs = equations.left_hand_side(&first[..count], &dv);
        equations.each().zip(&mut rhs).for_each(|((_, k, p), lhs)| *lhs = p.weight[k] * p.rhs[k] - *lhs);
        let mut images = Vec::new();
        let operator = |z: &[f64]| {
            let mut full = vec![0.0; d.len()];
            equations.expand(&z[..count], &mut full);
            let image = equations.image(&border, &full, &z[count..]);
            let lhs = equations.left_hand_side(&z[..count], &image);
            images.push(image);
            lhs
        };
        let balanced = vec![0.0; jumps.cols];
        let precondition = |x: &[f64]| border.complete(equations.precondition(x), &balanced);
        let krylov = gmres(operator, precondition, &rhs, accuracy, limit, self.stop);
        for ((&c, z), image) in krylov.coefficient.iter().zip(&krylov.directions).zip(&images) {
            let scaled: Vec<f64> = z.iter().map(|z| c * z).collect();
            equations.expand(&scaled[..count], &mut d);
            axpy(1.0, &scaled[count..], &mut d_alpha);
            axpy(c, image, &mut dv);
        }
        Step { lambda: by_point(&d), v: by_point(&dv), alpha: d_alpha, resisted: border.resisted }
    }
}

impl System for DualSystem<'_> {
    fn has_row(&self, j: usize) -> [bool; 3] {
        self.stiffness[j].map(|k| k > 0.0)
    }

    fn imbalance(&self, lambda: &[V3]) -> Vec<f64> {
        if self.resultant.is_empty() {
            return Vec::new();
        }
        self.dual.floating.imbalance(&self.resultant, &by_component(lambda))
    }

    fn step(&self, at: &Iterate, points: &[Linearisation], accuracy: f64) -> Option<Step> {
        Some(self.solve(&at.lambda, points, &self.imbalance(&at.lambda), accuracy, INNER_LIMIT))
    }

    fn advance(&self, at: &Iterate, t: f64, step: &Step) -> Iterate {
        let alpha = at.alpha.iter().zip(&step.alpha).map(|(x, d)| x + t * d).collect();
        Iterate { lambda: moved(&at.lambda, t, &step.lambda), v: moved(&at.v, t, &step.v), alpha }
    }
}

/// The linear system of one Newton step, reduced to the unknowns `y` of the [linearised laws](Linearisation), whose
/// equations stand in the scale of the residual over `r`: the accuracy of the inner iteration is that of the residual.
/// Full vectors are stored as those of [`Dual`].
struct Equations<'a> {
    dual: &'a Dual,
    points: &'a [Linearisation],
    count: usize,
    /// Diagonal of the preconditioner.
    scale: Vec<f64>,
    inverse: Inverse,
    /// At shared nodes the numbers of their unknowns and the factor of their own equations, the preconditioner there.
    shared: Vec<(Vec<usize>, SmallLu)>,
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
    jumps: &'a Csr,
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

impl<'a> Equations<'a> {
    fn new(system: &DualSystem<'a>, points: &'a [Linearisation]) -> Self {
        let slipping = points.iter().filter(|p| p.slip.is_some()).count();
        let mut equations = Equations {
            dual: system.dual,
            points,
            count: points.iter().map(|p| p.unknowns).sum(),
            scale: Vec::new(),
            inverse: Inverse::Dirichlet,
            shared: Vec::new(),
        };
        // A slipping point has at most two unknowns, a sticking one three. Among slipping points the lumped inverse takes as
        // few products as the exact one and costs nothing; among sticking ones the exact one takes a third of them.
        if slipping > equations.count.saturating_sub(2 * slipping) / 3 {
            equations.inverse = Inverse::Lumped;
        }
        let local = |j: usize, row: &V3| -> f64 { row.iter().zip(system.stiffness[j]).map(|(x, k)| x * x * k).sum() };
        let scale =
            |(j, k, p): (usize, usize, &Linearisation)| 1.0 / (1.0 + p.compliance[k] * local(j, &p.rows[k])).sqrt();
        equations.scale = equations.each().map(scale).collect();
        if !system.shared.is_empty() {
            let first: Vec<usize> =
                points.iter().scan(0, |sum, p| Some(std::mem::replace(sum, *sum + p.unknowns))).collect();
            equations.shared = system.shared.iter().map(|shared| equations.at_shared_node(shared, &first)).collect();
        }
        equations
    }

    /// The equations of a shared node as if all other nodes were held. The unknowns of point `j` begin at `first[j]`.
    fn at_shared_node(&self, shared: &SharedNode, first: &[usize]) -> (Vec<usize>, SmallLu) {
        let each: Vec<(usize, usize, usize)> = (shared.points.iter().enumerate())
            .flat_map(|(place, &j)| (0..self.points[j].unknowns).map(move |k| (place, j, k)))
            .collect();
        let entry = |&(place, j, k): &(usize, usize, usize), &(other, i, l): &(usize, usize, usize)| {
            let (p, column) = (&self.points[j], &self.points[i].columns[l]);
            let moved =
                |r: usize| -> f64 { (0..3).map(|s| shared.compliance[3 * place + r][3 * other + s] * column[s]).sum() };
            let own = if (j, k) == (i, l) { p.compliance[k] } else { 0.0 };
            p.weight[k] * ((0..3).map(|r| p.rows[k][r] * moved(r)).sum::<f64>() + own)
        };
        let matrix = each.iter().map(|row| each.iter().map(|column| entry(row, column)).collect()).collect();
        (each.iter().map(|&(_, j, k)| first[j] + k).collect(), SmallLu::new(matrix))
    }

    /// Every unknown: its point, its number there and the law of the point.
    fn each(&self) -> impl Iterator<Item = (usize, usize, &'a Linearisation)> + use<'a> {
        self.points.iter().enumerate().flat_map(|(j, p)| (0..p.unknowns).map(move |k| (j, k, p)))
    }

    fn add(&self, j: usize, y: f64, direction: &V3, full: &mut [f64]) {
        let m = self.points.len();
        (0..3).for_each(|i| full[i * m + j] += y * direction[i]);
    }

    fn component(&self, j: usize, direction: &V3, full: &[f64]) -> f64 {
        let m = self.points.len();
        (0..3).map(|i| direction[i] * full[i * m + j]).sum()
    }

    /// `d += E y`: what the unknowns `y` contribute to the step.
    fn expand(&self, y: &[f64], d: &mut [f64]) {
        self.each().zip(y).for_each(|((j, k, p), &y)| self.add(j, y, &p.columns[k], d));
    }

    /// `Eᵀ w`: the work of `w` on what the unknowns contribute to the step.
    fn gather(&self, w: &[f64]) -> Vec<f64> {
        self.each().map(|(j, k, p)| self.component(j, &p.columns[k], w)).collect()
    }

    /// `Pᵀ w`: the jump in the rows of the equations.
    fn restrict(&self, w: &[f64]) -> Vec<f64> {
        self.each().map(|(j, k, p)| self.component(j, &p.rows[k], w)).collect()
    }

    /// The left-hand sides for the unknowns `y` at the change `dv`.
    fn left_hand_side(&self, y: &[f64], dv: &[f64]) -> Vec<f64> {
        let weighed = |((_, k, p), (w, y)): ((usize, usize, &Linearisation), (f64, &f64))| {
            p.weight[k] * (w + p.compliance[k] * y)
        };
        self.each().zip(self.restrict(dv).into_iter().zip(y)).map(weighed).collect()
    }

    /// An approximate inverse of `weight (Pᵀ Q P + compliance)`: `W Pᵀ S P W / weight` with `S ~ Q⁻¹` and the diagonal
    /// `W = (1 + compliance * stiffness)^(-1/2)`, exact for a diagonal `Q` without and with large compliance.
    fn precondition(&self, x: &[f64]) -> Vec<f64> {
        let mut full = vec![0.0; 3 * self.points.len()];
        for ((j, k, p), (x, scale)) in self.each().zip(x.iter().zip(&self.scale)) {
            self.add(j, x * scale / p.weight[k], &p.rows[k], &mut full);
        }
        let mut result = self.restrict(&self.dual.approximate_inverse(&full, self.inverse));
        result.iter_mut().zip(&self.scale).for_each(|(r, w)| *r *= w);
        for (unknowns, lu) in &self.shared {
            let own: Vec<f64> = unknowns.iter().map(|&i| x[i]).collect();
            unknowns.iter().zip(lu.solve(&own)).for_each(|(&i, y)| result[i] = y);
        }
        result
    }

    /// A motion that nothing drives and no point in contact feels stays as it is.
    fn border(&self, jumps: &'a Csr, imbalance: &[f64]) -> Border<'a> {
        let answer = |jump: &Vec<f64>| {
            let rows = self.each().zip(self.restrict(jump)).map(|((_, k, p), g)| p.weight[k] * g);
            self.precondition(&rows.collect::<Vec<f64>>())
        };
        let columns: Vec<Vec<f64>> = (0..jumps.cols).map(|k| jumps.column_of(k)).collect();
        let work: Vec<Vec<f64>> = columns.iter().map(|jump| self.gather(jump)).collect();
        let answer: Vec<Vec<f64>> = columns.iter().map(answer).collect();
        let mut resistance: Vec<Vec<f64>> = work.iter().map(|g| answer.iter().map(|y| dot(g, y)).collect()).collect();
        let largest = (0..jumps.cols).fold(0.0, |a: f64, k| a.max(resistance[k][k]));
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

    /// What the step does to `v`, at one product with `Q`.
    fn image(&self, border: &Border, d: &[f64], d_alpha: &[f64]) -> Vec<f64> {
        let moves = d.iter().any(|&x| x != 0.0);
        let mut image = if moves { self.dual.times(d) } else { vec![0.0; d.len()] };
        if !d_alpha.is_empty() {
            axpy(-1.0, &border.jumps.times(d_alpha), &mut image);
        }
        image
    }
}
