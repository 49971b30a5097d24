use super::linear::verified;
use super::problem::{Bilateral, DiscreteProblem, Equalities, GlobalProblem, LocalProblem};
use crate::Error;
use crate::linalg::{Csr, Lu, NodeGraph, axpy, nested_dissection, norm, plan};

/// A problem in impulses alone, and the way back to velocities and the impulses of bilateral constraints.
#[derive(Debug)]
pub struct Condensed {
    /// Without bilateral part.
    pub local: LocalProblem,
    bodies: Vec<Body>,
    eliminated: Option<Eliminated>,
}

/// Unknown velocities that `M` couples, and its factor there.
#[derive(Debug)]
struct Body {
    unknowns: Vec<u32>,
    factor: Factor,
}

/// Most masses couple to nothing.
#[derive(Debug)]
enum Factor {
    Mass(f64),
    Coupled(Lu),
}

/// `l = -R⁻¹ (C r + s)`.
#[derive(Debug)]
struct Eliminated {
    factor: Lu,
    C: Csr,
    s: Vec<f64>,
}

/// What belongs to impulses `r` beside them.
#[derive(Debug, Clone, PartialEq)]
pub struct Recovered {
    /// Velocities of the contact points, `dm`.
    pub u: Vec<f64>,
    /// Velocities of the bodies, `n`; empty for a local problem.
    pub v: Vec<f64>,
    /// Impulses of the bilateral constraints, `p`.
    pub l: Vec<f64>,
    /// Residual of the linear equations, relative to the largest of their terms.
    pub equilibrium: f64,
}

/// Condenses a validated problem to its contact points: `W = H' M⁻¹ H` body by body, `q = H' M⁻¹ f + w`; bilateral
/// constraints are eliminated. `M` is used as it is, symmetric or not.
///
/// # Errors
/// If `M` is singular, or the bilateral constraints are not independent.
pub fn condense(problem: &DiscreteProblem) -> Result<Condensed, Error> {
    match problem {
        DiscreteProblem::Local(local) => {
            let mut plain = LocalProblem { bilateral: None, ..local.clone() };
            let eliminated = match &local.bilateral {
                Some(Bilateral { V, R, s }) => Some(eliminate(&mut plain, V, V.transpose(), R, s)?),
                None => None,
            };
            Ok(Condensed { local: plain, bodies: Vec::new(), eliminated })
        }
        DiscreteProblem::Global(global) => condense_bodies(global),
    }
}

fn condense_bodies(problem: &GlobalProblem) -> Result<Condensed, Error> {
    let (n, size) = (problem.f.len(), problem.w.len());
    let empty = Equalities { G: Csr::zero(n, 0), b: Vec::new() };
    let Equalities { G, b } = problem.equalities.as_ref().unwrap_or(&empty);
    // Columns of H, then those of G, then f.
    let p = b.len();
    let mut columns = problem.H.transpose();
    columns.append(&G.transpose());
    let load: Vec<(usize, usize, f64)> = problem.f.iter().enumerate().map(|(j, &v)| (0, j, v)).collect();
    columns.append(&Csr::from_triplets(1, n, &load));
    let directions = columns.transpose();
    let symmetric = symmetric_pattern(&problem.M);
    let (mut bodies, mut products, mut local) = (Vec::new(), Vec::new(), vec![0u32; n]);
    for unknowns in components(&symmetric) {
        unknowns.iter().zip(0..).for_each(|(&i, k)| local[i as usize] = k);
        let body = Body::new(&symmetric, unknowns, &local)?;
        body.products(&directions, size + p, &mut products);
        bodies.push(body);
    }
    let product = Csr::from_triplets(size + p, size + p + 1, &products);
    let part = |rows: std::ops::Range<usize>, cols: std::ops::Range<usize>| {
        let keep = |r: std::ops::Range<usize>| r.map(|i| i as u32).collect::<Vec<u32>>();
        product.select_rows(&keep(rows)).select_columns(&keep(cols))
    };
    let last = size + p;
    let dense = |rows: std::ops::Range<usize>| rows.map(|i| product.entry(i, last)).collect::<Vec<f64>>();
    let mut local = LocalProblem {
        dimension: problem.dimension,
        W: part(0..size, 0..size),
        q: dense(0..size).iter().zip(&problem.w).map(|(q, w)| q + w).collect(),
        mu: problem.mu.clone(),
        bilateral: None,
    };
    let mut eliminated = None;
    if p > 0 {
        let s: Vec<f64> = dense(size..last).iter().zip(b).map(|(s, b)| s + b).collect();
        let [V, C, R] = [part(0..size, size..last), part(size..last, 0..size), part(size..last, size..last)];
        eliminated = Some(eliminate(&mut local, &V, C, &R, &s)?);
    }
    Ok(Condensed { local, bodies, eliminated })
}

impl Condensed {
    /// Velocities and bilateral impulses for impulses `r` of the problem this was made of.
    pub fn recover(&self, problem: &DiscreteProblem, r: &[f64]) -> Recovered {
        let l = self.eliminated.as_ref().map_or(Vec::new(), |e| e.bilateral(r));
        match problem {
            DiscreteProblem::Local(local) => {
                let mut u = local.W.times(r);
                axpy(1.0, &local.q, &mut u);
                let mut equilibrium = 0.0;
                if let Some(Bilateral { V, R, s }) = &local.bilateral {
                    axpy(1.0, &V.times(&l), &mut u);
                    equilibrium = balance(&[&V.transpose_times(r), &R.times(&l), s]);
                }
                Recovered { u, v: Vec::new(), l, equilibrium }
            }
            DiscreteProblem::Global(global) => {
                let load = forces(global, r, &l);
                let mut v = self.velocity(&load);
                // One refinement: the factor's error is amplified by the condition of M.
                let mut residual = load;
                axpy(-1.0, &global.M.times(&v), &mut residual);
                axpy(1.0, &self.velocity(&residual), &mut v);
                let mut u = global.H.transpose_times(&v);
                axpy(1.0, &global.w, &mut u);
                Recovered { equilibrium: balance_of_bodies(global, r, &v, &l), u, v, l }
            }
        }
    }

    fn velocity(&self, load: &[f64]) -> Vec<f64> {
        let mut v = vec![0.0; load.len()];
        for body in &self.bodies {
            let own: Vec<f64> = body.unknowns.iter().map(|&i| load[i as usize]).collect();
            body.unknowns.iter().zip(body.solve(&own)).for_each(|(&i, x)| v[i as usize] = x);
        }
        v
    }
}

impl Eliminated {
    fn bilateral(&self, r: &[f64]) -> Vec<f64> {
        let mut rhs = self.C.times(r);
        axpy(1.0, &self.s, &mut rhs);
        self.factor.solve(&rhs).iter().map(|x| -x).collect()
    }
}

impl Body {
    /// `local` numbers its unknowns.
    fn new(M: &Csr, unknowns: Vec<u32>, local: &[u32]) -> Result<Self, Error> {
        let singular = || {
            let what = format!("M is singular on the unknowns around {}", unknowns.first().copied().unwrap_or(0));
            Error::new("M", what, "each body needs its mass, or enough support")
        };
        if let [i] = unknowns[..] {
            let mass = M.entry(i as usize, i as usize);
            if mass == 0.0 {
                return Err(singular());
            }
            return Ok(Body { unknowns, factor: Factor::Mass(mass) });
        }
        // A component has all columns of its rows.
        let mut own = M.select_rows(&unknowns);
        own.cols = unknowns.len();
        own.column.iter_mut().for_each(|j| *j = local[*j as usize]);
        let factor = factorise(&own).ok_or_else(singular)?;
        Ok(Body { unknowns, factor: Factor::Coupled(factor) })
    }

    fn solve(&self, b: &[f64]) -> Vec<f64> {
        match &self.factor {
            Factor::Mass(mass) => b.iter().map(|b| b / mass).collect(),
            Factor::Coupled(lu) => lu.solve(b),
        }
    }

    /// Adds this body's part of `D' M⁻¹ D` for the directions `D`, rows up to `wanted`.
    fn products(&self, directions: &Csr, wanted: usize, products: &mut Vec<(usize, usize, f64)>) {
        let mut entries: Vec<(u32, usize, f64)> = Vec::new();
        for (k, &i) in self.unknowns.iter().enumerate() {
            let (columns, values) = directions.row(i as usize);
            entries.extend(columns.iter().zip(values).map(|(&j, &v)| (j, k, v)));
        }
        entries.sort_unstable_by_key(|e| (e.0, e.1));
        let touched: Vec<&[(u32, usize, f64)]> = entries.chunk_by(|a, b| a.0 == b.0).collect();
        for column in &touched {
            let mut b = vec![0.0; self.unknowns.len()];
            column.iter().for_each(|&(_, k, v)| b[k] = v);
            let x = self.solve(&b);
            for row in touched.iter().filter(|row| (row[0].0 as usize) < wanted) {
                let product = row.iter().map(|&(_, k, v)| v * x[k]).sum();
                products.push((row[0].0 as usize, column[0].0 as usize, product));
            }
        }
    }
}

/// `W -= V R⁻¹ C`, `q -= V R⁻¹ s`.
fn eliminate(local: &mut LocalProblem, V: &Csr, C: Csr, R: &Csr, s: &[f64]) -> Result<Eliminated, Error> {
    let dependent = || {
        let what = "the bilateral constraints are not independent (R is singular)";
        Error::new("R", what, "leave out those that follow from others")
    };
    let factor = factorise(&symmetric_pattern(R)).ok_or_else(dependent)?;
    let by_column = C.transpose();
    let mut entries: Vec<(usize, usize, f64)> = local.W.entries().collect();
    for j in 0..by_column.rows {
        let (rows, values) = by_column.row(j);
        if rows.is_empty() {
            continue;
        }
        let mut b = vec![0.0; s.len()];
        rows.iter().zip(values).for_each(|(&i, v)| b[i as usize] = *v);
        let change = V.times(&factor.solve(&b));
        entries.extend(change.iter().enumerate().filter(|(_, x)| **x != 0.0).map(|(i, x)| (i, j, -x)));
    }
    local.W = Csr::from_triplets(local.W.rows, local.W.cols, &entries);
    axpy(-1.0, &V.times(&factor.solve(s)), &mut local.q);
    Ok(Eliminated { factor, C, s: s.to_vec() })
}

/// A factor of a matrix with a symmetric pattern; `None` if it is singular to working precision.
fn factorise(a: &Csr) -> Option<Lu> {
    let graph = NodeGraph::new(a, None);
    verified(Lu::new(a, &plan(&graph, &nested_dissection(&graph), 0))?, a)
}

/// The same matrix with zeros stored where only the transpose has an entry.
pub(super) fn symmetric_pattern(a: &Csr) -> Csr {
    let both = a.entries().flat_map(|(i, j, v)| [(i, j, v), (j, i, 0.0)]);
    let entries: Vec<(usize, usize, f64)> = (0..a.rows).map(|i| (i, i, 0.0)).chain(both).collect();
    Csr::from_triplets(a.rows, a.cols, &entries)
}

/// Unknowns that a matrix of symmetric pattern couples, each list ascending.
pub(super) fn components(a: &Csr) -> Vec<Vec<u32>> {
    let mut seen = vec![false; a.rows];
    let mut all = Vec::new();
    for i in 0..a.rows {
        if seen[i] {
            continue;
        }
        seen[i] = true;
        let mut part = vec![i as u32];
        let mut next = 0;
        while next < part.len() {
            for &j in a.row(part[next] as usize).0 {
                if !std::mem::replace(&mut seen[j as usize], true) {
                    part.push(j);
                }
            }
            next += 1;
        }
        part.sort_unstable();
        all.push(part);
    }
    all
}

/// `H r + f + G l`.
fn forces(problem: &GlobalProblem, r: &[f64], l: &[f64]) -> Vec<f64> {
    let mut forces = problem.H.times(r);
    axpy(1.0, &problem.f, &mut forces);
    problem.equalities.iter().for_each(|e| axpy(1.0, &e.G.times(l), &mut forces));
    forces
}

/// The larger residual of `M v = H r + f + G l` and of the constraints, each over its terms.
pub(super) fn balance_of_bodies(problem: &GlobalProblem, r: &[f64], v: &[f64], l: &[f64]) -> f64 {
    let inertia: Vec<f64> = problem.M.times(v).iter().map(|x| -x).collect();
    balance(&[&inertia, &forces(problem, r, l)]).max(balance_of_constraints(problem, v))
}

/// `|G' v + b|` over its terms; zero without constraints.
fn balance_of_constraints(problem: &GlobalProblem, v: &[f64]) -> f64 {
    let Some(Equalities { G, b }) = &problem.equalities else { return 0.0 };
    let mut residual = G.transpose_times(v);
    axpy(1.0, b, &mut residual);
    // Where b vanishes, the sum's own terms are the scale.
    let mut magnitudes = G.clone();
    magnitudes.value.iter_mut().for_each(|g| *g = g.abs());
    let speeds: Vec<f64> = v.iter().map(|v| v.abs()).collect();
    let scale = norm(&magnitudes.transpose_times(&speeds)).max(norm(b));
    if scale > 0.0 { norm(&residual) / scale } else { 0.0 }
}

/// Residual of all bilateral constraints of a problem at a state, over their terms.
pub(super) fn imbalance(problem: &DiscreteProblem, r: &[f64], at: &Recovered) -> f64 {
    match problem {
        DiscreteProblem::Local(LocalProblem { bilateral: Some(Bilateral { V, R, s }), .. }) => {
            balance(&[&V.transpose_times(r), &R.times(&at.l), s])
        }
        DiscreteProblem::Local(_) => 0.0,
        DiscreteProblem::Global(global) => balance_of_constraints(global, &at.v),
    }
}

/// `|sum of the terms| / max |term|`.
fn balance(terms: &[&[f64]]) -> f64 {
    let mut sum = vec![0.0; terms.first().map_or(0, |t| t.len())];
    terms.iter().for_each(|t| axpy(1.0, t, &mut sum));
    let largest = terms.iter().map(|t| norm(t)).fold(0.0, f64::max);
    if largest > 0.0 { norm(&sum) / largest } else { 0.0 }
}
