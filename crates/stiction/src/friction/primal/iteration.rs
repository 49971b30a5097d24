use super::frames::Turned;
use super::sets::{Law, Set, State, set};
use crate::contact::ContactProblem;
use crate::linalg::multigrid::{Blocks, Multigrid};
use rayon::prelude::*;

#[derive(Debug, Clone)]
pub struct PrimalSettings {
    pub tolerance: f64,
    pub max_cycles: usize,
}

pub struct PrimalResult {
    pub u: Vec<f64>,
    pub lambda: Vec<f64>,
    pub cycles: usize,
    pub updates: usize,
    pub resets: usize,
    pub history: Vec<(f64, [usize; 3])>,
    pub converged: bool,
}

/// Share of the diagonal of `K` at a node that turns displacements into forces.
const PARAMETER: f64 = 0.4;
/// The coarse levels follow once this share of the points has changed its set.
const LAG: f64 = 0.003;
const KEPT: usize = 2;

type Vector = Vec<[f64; 3]>;

struct Direction {
    p: Vector,
    kp: Vector,
}

pub fn primal(problem: &ContactProblem, settings: &PrimalSettings, mut watch: impl FnMut(usize, f64, [usize; 3])) -> Option<PrimalResult> {
    let t = std::time::Instant::now();
    let turned = Turned::new(problem)?;
    let (k, f, points) = (&turned.k, &turned.f, &turned.points);
    eprintln!("turned {:.2}", t.elapsed().as_secs_f64());
    let contact: Vec<u32> = points.iter().map(|p| p.node as u32).collect();
    let mut mg = Multigrid::new(k, &turned.kernel, &contact)?;
    eprintln!("setup {:.2}", t.elapsed().as_secs_f64());
    let m = points.len();
    let laws: Vec<Law> = (0..m)
        .map(|j| {
            let d = k.diagonal(points[j].node);
            Law {
                friction: problem.friction[j],
                gap: problem.gap[j],
                reference: [problem.slip_reference[j], problem.slip_reference[m + j]],
                parameter: PARAMETER * (d[0][0] + d[1][1] + d[2][2]) / 3.0,
            }
        })
        .collect();
    let mut u: Vector = vec![[0.0; 3]; f.len()];
    let mut ku: Vector = vec![[0.0; 3]; f.len()];
    let mut kept: Vec<Direction> = Vec::new();
    let mut coarse_sets: Vec<Set> = Vec::new();
    let size = norm(f);
    let (mut cycles, mut updates, mut resets) = (0, 0, 0);
    let mut history: Vec<(f64, [usize; 3])> = Vec::new();
    let mut last_reset = 0;
    let mut converged = false;
    loop {
        let lambda = |j: usize| { let v = points[j].node; std::array::from_fn(|c| f[v][c] - ku[v][c]) };
        let mut sets: Vec<Set> = (0..m).map(|j| set(&laws[j], &points[j], lambda(j), u[points[j].node])).collect();
        if cycles == 0 {
            sets.iter_mut().zip(points).for_each(|(s, p)| s.stick(&p.live));
        }
        let eps = measure(&turned, &laws, &sets, &u, &ku) / size;
        let counts = [State::Open, State::Stick, State::Slip].map(|s| sets.iter().filter(|x| x.state == s).count());
        watch(cycles, eps, counts);
        history.push((eps, counts));
        if eps <= settings.tolerance && cycles > 0 {
            let fresh = k.times(&u);
            let drift = fresh.iter().flatten().zip(ku.iter().flatten()).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
            ku = fresh;
            if drift <= 0.1 * settings.tolerance * size { converged = true; break; }
            continue;
        }
        if cycles >= settings.max_cycles || !eps.is_finite() {
            break;
        }
        // A cycle of sets shows as a residual that stays high: all that bears sticks, and five cycles are done so.
        let mut inner = 1;
        let stagnates = history.len() > 5 && eps > 0.05 && {
            let older = history[..history.len() - 4].iter().map(|h| h.0).fold(f64::INFINITY, f64::min);
            eps > 0.7 * older
        };
        if stagnates && resets < 4 && cycles >= last_reset + 8 {
            sets.iter_mut().zip(points).filter(|(s, _)| s.condition.held[0]).for_each(|(s, p)| s.stick(&p.live));
            kept.clear();
            resets += 1;
            last_reset = cycles;
            inner = 5;
        }
        let changed = sets.iter().zip(&coarse_sets).filter(|(a, b)| a.condition.held != b.condition.held).count();
        let coarse = coarse_sets.len() != m || changed as f64 > LAG * m as f64 || (changed > 0 && m < 300);
        let conditions: Vec<_> = sets.iter().map(|s| s.condition).collect();
        mg.constrain(&conditions, coarse);
        if coarse {
            coarse_sets = sets.clone();
            updates += 1;
        }
        // Held components take their values, kept directions lose them.
        for (s, p) in sets.iter().zip(points) {
            for c in (0..3).filter(|&c| s.condition.held[c]) {
                let change = s.value[c] - u[p.node][c];
                if change != 0.0 {
                    u[p.node][c] = s.value[c];
                    add_column(k, p.node, c, change, &mut ku);
                }
                for d in &mut kept {
                    let change = -d.p[p.node][c];
                    if change != 0.0 {
                        d.p[p.node][c] = 0.0;
                        add_column(k, p.node, c, change, &mut d.kp);
                    }
                }
            }
        }
        for _ in 0..inner {
            let r = residual(&turned, &laws, &sets, &u, &ku);
            let z = mg.cycle(&r);
            let kz = k.times(&z);
            kept.insert(0, Direction { p: z, kp: kz });
            cycles += 1;
            let y = minimiser(&turned, &sets, &kept, &r);
            let mut step = Direction { p: vec![[0.0; 3]; f.len()], kp: vec![[0.0; 3]; f.len()] };
            for (y, d) in y.iter().zip(&kept) {
                axpy(*y, &d.p, &mut step.p);
                axpy(*y, &d.kp, &mut step.kp);
            }
            axpy(1.0, &step.p, &mut u);
            axpy(1.0, &step.kp, &mut ku);
            kept[0] = step;
            kept.truncate(KEPT);
        }
    }
    // Multipliers from the balance at the contact nodes.
    let mut lambda = vec![0.0; 3 * m];
    for j in 0..m {
        let v = points[j].node;
        for c in (0..3).filter(|&c| points[j].live[c]) {
            lambda[c * m + j] = f[v][c] - ku[v][c];
        }
    }
    Some(PrimalResult { u: turned.out_of_frames(&u), lambda, cycles, updates, resets, history, converged })
}

impl Set {
    fn stick(&mut self, live: &[bool; 3]) {
        self.state = State::Stick;
        self.condition.held = *live;
        self.condition.spring = [[0.0; 3]; 3];
        self.friction = [0.0; 2];
    }
}

/// The residual on the components that are not held: `f - K u` less friction.
fn residual(turned: &Turned, laws: &[Law], sets: &[Set], u: &Vector, ku: &Vector) -> Vector {
    let mut r: Vector = turned.f.iter().zip(ku).map(|(f, k)| [f[0] - k[0], f[1] - k[1], f[2] - k[2]]).collect();
    for ((p, s), law) in turned.points.iter().zip(sets).zip(laws) {
        let (r, u) = (&mut r[p.node], u[p.node]);
        let slip = [u[1] - law.reference[0], u[2] - law.reference[1]];
        for c in 1..3 {
            let spring = &s.condition.spring[c];
            r[c] -= s.friction[c - 1] + spring[1] * slip[0] + spring[2] * slip[1];
        }
        (0..3).filter(|&c| s.condition.held[c]).for_each(|c| r[c] = 0.0);
    }
    r
}

/// Norm of the law's violation: forces that are not balanced and, as forces, displacements that are not held.
fn measure(turned: &Turned, laws: &[Law], sets: &[Set], u: &Vector, ku: &Vector) -> f64 {
    let mut r: Vector = turned.f.iter().zip(ku).map(|(f, k)| [f[0] - k[0], f[1] - k[1], f[2] - k[2]]).collect();
    for ((p, s), law) in turned.points.iter().zip(sets).zip(laws) {
        let (r, u) = (&mut r[p.node], u[p.node]);
        for c in 0..3 {
            if s.condition.held[c] {
                r[c] = law.parameter * (u[c] - s.value[c]);
            } else if c > 0 {
                r[c] -= s.friction[c - 1];
            }
        }
    }
    norm(&r)
}

/// The minimiser of the energy over the span of the directions: `(Sᵀ M S) y = Sᵀ r`.
fn minimiser(turned: &Turned, sets: &[Set], directions: &[Direction], r: &Vector) -> Vec<f64> {
    let n = directions.len();
    let mut a = vec![vec![0.0; n]; n];
    let mut b = vec![0.0; n];
    for i in 0..n {
        b[i] = dot(&directions[i].p, r);
        for j in 0..=i {
            let mut sum = dot(&directions[i].p, &directions[j].kp);
            for (p, s) in turned.points.iter().zip(sets) {
                let (x, y) = (directions[i].p[p.node], directions[j].p[p.node]);
                for c in 1..3 {
                    for d in 1..3 {
                        sum += x[c] * s.condition.spring[c][d] * y[d];
                    }
                }
            }
            a[i][j] = sum;
            a[j][i] = sum;
        }
    }
    // Cholesky of the scaled matrix; directions that depend on earlier ones get nothing.
    let scale: Vec<f64> = (0..n).map(|i| if a[i][i] > 0.0 { 1.0 / a[i][i].sqrt() } else { 0.0 }).collect();
    let mut l = vec![vec![0.0; n]; n];
    let mut inv = vec![0.0; n];
    for k in 0..n {
        let pivot = a[k][k] * scale[k] * scale[k] - (0..k).map(|j| l[k][j] * l[k][j]).sum::<f64>();
        if pivot > 1e-12 { inv[k] = 1.0 / pivot.sqrt(); }
        for i in k..n {
            l[i][k] = (a[i][k] * scale[i] * scale[k] - (0..k).map(|j| l[i][j] * l[k][j]).sum::<f64>()) * inv[k];
        }
    }
    let mut y: Vec<f64> = (0..n).map(|i| b[i] * scale[i]).collect();
    for i in 0..n { y[i] = (y[i] - (0..i).map(|j| l[i][j] * y[j]).sum::<f64>()) * inv[i]; }
    for i in (0..n).rev() { y[i] = (y[i] - (i + 1..n).map(|j| l[j][i] * y[j]).sum::<f64>()) * inv[i]; }
    y.iter().zip(&scale).map(|(y, s)| y * s).collect()
}

/// `y += change` times the column of `K` at a component of a node; `K` is symmetric.
fn add_column(k: &Blocks<3, 3>, node: usize, component: usize, change: f64, y: &mut Vector) {
    let (columns, blocks) = k.row(node);
    for (&j, block) in columns.iter().zip(blocks) {
        (0..3).for_each(|c| y[j as usize][c] += change * block[component][c]);
    }
}

fn dot(x: &Vector, y: &Vector) -> f64 {
    let parts: Vec<f64> = x.par_chunks(4096).zip(y.par_chunks(4096))
        .map(|(x, y)| x.iter().flatten().zip(y.iter().flatten()).map(|(a, b)| a * b).sum()).collect();
    parts.iter().sum()
}

fn norm(x: &Vector) -> f64 {
    dot(x, x).sqrt()
}

fn axpy(a: f64, x: &Vector, y: &mut Vector) {
    y.iter_mut().flatten().zip(x.iter().flatten()).for_each(|(y, x)| *y += a * x);
}
