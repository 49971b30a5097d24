//! Bodies that nothing but contact holds: the rigid motions that strain nothing, found from the matrices alone.

use std::collections::BTreeMap;

use super::ContactProblem;
use super::among::Among;
use crate::linalg::{Csr, SmallCholesky, SymmetricCsr, axpy, dot, max_abs, norm, symmetric_eigen};

/// A connected piece of the body with rigid motions that strain nothing.
#[derive(Debug, Clone, PartialEq)]
pub struct FloatingBody {
    /// Its place in [`Bodies::list`](super::Bodies::list), where the bodies of the problem are known.
    pub place: Option<usize>,
    /// Its unknowns, ascending; of a problem that ranks share those of this one, which may be none.
    pub unknowns: Vec<u32>,
    /// One to six independent motions over `unknowns`, orthonormal, without a unit.
    pub motions: Vec<Vec<f64>>,
    /// The same motions as combinations of the columns of [`Elastic::near_kernel`](super::Elastic::near_kernel).
    pub coefficients: Vec<[f64; 6]>,
}

/// The null space `R` of the stiffness, `n x k`: `K R = 0`, `R' R = 1`. Its columns are the motions of one body after
/// the other.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RigidMotions {
    /// The bodies that contact alone holds.
    pub bodies: Vec<FloatingBody>,
}

/// A motion of unit length whose energy is below this part of the largest diagonal entry of its body costs none. Far
/// above rounding, which leaves some 1e-15, and far below the energy of a body that a single node holds, one part in
/// as many as it has nodes.
pub(crate) const NO_ENERGY: f64 = 1e-12;

/// What is left of the sum of a jump over the sum of the sizes of its parts, below which it is rounding: weights of couplings have
/// errors of some 1e-13.
const CANCELLED: f64 = 1e-11;

/// What is left of a rigid motion beside the others, over its own length, below which it is their combination.
const DEPENDENT: f64 = 1e-9;

/// The rigid motions that strain nothing. Bodies are the connected components of the graph of `K`; for each the
/// energies `R' K R` of the near-kernel restricted to it tell the motions that are free: six for a body constrained by
/// contact alone, three for one on a symmetry plane. Empty where the problem has no near-kernel.
///
/// # Panics
/// If the problem does not pass [`ContactProblem::validate`].
pub fn rigid_motions(problem: &ContactProblem) -> RigidMotions {
    let Some(near_kernel) = &problem.elastic.near_kernel else { return RigidMotions::default() };
    let mut bodies = Vec::new();
    let mut place = vec![0; problem.elastic.K.rows];
    for unknowns in components(&problem.elastic.K) {
        unknowns.iter().enumerate().for_each(|(at, &i)| place[i as usize] = at as u32);
        let (motions, coefficients) = basis(near_kernel, &unknowns);
        let largest = unknowns.iter().map(|&i| problem.elastic.K.diagonal(i as usize)).fold(0.0, f64::max);
        let (values, vectors) =
            symmetric_eigen(&energies(&problem.elastic.K, &unknowns, &place, &motions, NO_ENERGY * largest));
        let free = values.iter().zip(&vectors).filter(|(v, _)| **v <= NO_ENERGY * largest).map(|(_, v)| v);
        let place = problem.labels.bodies.as_ref().map(|bodies| bodies.of[unknowns[0] as usize] as usize);
        let mut body = FloatingBody { place, unknowns, motions: Vec::new(), coefficients: Vec::new() };
        for weights in free {
            let mut motion = vec![0.0; body.unknowns.len()];
            weights.iter().zip(&motions).for_each(|(&w, m)| axpy(w, m, &mut motion));
            body.motions.push(motion);
            body.coefficients.push(std::array::from_fn(|k| dot(weights, &column(&coefficients, k))));
        }
        if !body.motions.is_empty() {
            bodies.push(body);
        }
    }
    RigidMotions { bodies }
}

impl RigidMotions {
    /// Number of motions `k`.
    pub fn len(&self) -> usize {
        self.bodies.iter().map(|body| body.motions.len()).sum()
    }

    /// Whether every body is constrained.
    pub fn is_empty(&self) -> bool {
        self.bodies.is_empty()
    }

    /// Those combinations of the motions of each body on which none of these rows of unknowns acts. `sum` adds up what ranks that each
    /// have a part of the unknowns find of their parts of the rows.
    pub(crate) fn beside(&self, rows: &[Vec<(u32, f64)>], sum: &dyn Fn(&mut [f64])) -> RigidMotions {
        let rest = |body: &FloatingBody| {
            let count = body.motions.len();
            let mut gram = vec![vec![0.0; count]; count];
            let of_row = |row: &Vec<(u32, f64)>| {
                let place = |(i, value): &(u32, f64)| Some((body.unknowns.binary_search(i).ok()?, *value));
                let of_body: Vec<(usize, f64)> = row.iter().filter_map(place).collect();
                let square: f64 = of_body.iter().map(|(_, value)| value * value).sum();
                let work = |motion: &Vec<f64>| of_body.iter().map(|(i, value)| value * motion[*i]).sum::<f64>();
                std::iter::once(square).chain(body.motions.iter().map(work)).collect::<Vec<f64>>()
            };
            let mut of_rows: Vec<f64> = rows.iter().flat_map(of_row).collect();
            sum(&mut of_rows);
            for of_row in of_rows.chunks(1 + count) {
                let (square, works) = (of_row[0], &of_row[1..]);
                for (a, b) in (0..count).flat_map(|a| (0..count).map(move |b| (a, b))) {
                    gram[a][b] += works[a] * works[b] / square.max(f64::MIN_POSITIVE);
                }
            }
            let combined = |weights: &Vec<f64>| {
                let mut motion = vec![0.0; body.unknowns.len()];
                weights.iter().zip(&body.motions).for_each(|(&w, m)| axpy(w, m, &mut motion));
                (motion, std::array::from_fn(|k| dot(weights, &column(&body.coefficients, k))))
            };
            let (motions, coefficients) = near_kernel_of(&gram, DEPENDENT * DEPENDENT).iter().map(combined).unzip();
            FloatingBody { place: body.place, unknowns: body.unknowns.clone(), motions, coefficients }
        };
        let bodies = self.bodies.iter().map(rest).filter(|body| !body.motions.is_empty()).collect();
        RigidMotions { bodies }
    }

    /// The columns of `R`, each with its body.
    fn columns(&self) -> impl Iterator<Item = (&FloatingBody, &Vec<f64>)> {
        self.bodies.iter().flat_map(|body| body.motions.iter().map(move |motion| (body, motion)))
    }

    /// `R' f`: the work of the force `f` (length `n`) on the motions.
    pub fn work(&self, force: &[f64]) -> Vec<f64> {
        let on = |(body, motion): (&FloatingBody, &Vec<f64>)| {
            body.unknowns.iter().zip(motion).map(|(&i, r)| force[i as usize] * r).sum()
        };
        self.columns().map(on).collect()
    }

    /// The sum of the sizes of the terms that [`work`](Self::work) adds up, over all motions.
    pub fn work_size(&self, force: &[f64]) -> f64 {
        let on = |(body, motion): (&FloatingBody, &Vec<f64>)| -> f64 {
            body.unknowns.iter().zip(motion).map(|(&i, r)| (force[i as usize] * r).abs()).sum()
        };
        self.columns().map(on).sum()
    }

    /// `u += R alpha`.
    pub fn add(&self, alpha: &[f64], u: &mut [f64]) {
        for ((body, motion), &a) in self.columns().zip(alpha) {
            body.unknowns.iter().zip(motion).for_each(|(&i, r)| u[i as usize] += a * r);
        }
    }

    /// The jumps `G = B R` of the motions, `3m x k`: each row has entries for the motions of the bodies that it is between. What cancels but
    /// for rounding is zero: the rows of a coupling between nodes of one body resist none of its motions.
    pub fn jumps(&self, B: &Csr) -> Csr {
        const HELD: (u32, u32) = (u32::MAX, 0);
        // Of each unknown its body, and where it stands there.
        let mut of = vec![HELD; B.cols];
        let mut first = vec![0; self.bodies.len()];
        for (b, body) in self.bodies.iter().enumerate() {
            body.unknowns.iter().enumerate().for_each(|(at, &i)| of[i as usize] = (b as u32, at as u32));
            first[b] = b.checked_sub(1).map_or(0, |before| first[before] + self.bodies[before].motions.len());
        }
        let mut jumps = Csr::zero(0, self.len());
        // Of each motion the sum, and that of the sizes.
        let mut row: BTreeMap<usize, [f64; 2]> = BTreeMap::new();
        for i in 0..B.rows {
            for (j, value) in B.entries_of(i).filter(|(j, _)| of[*j as usize] != HELD) {
                let (b, at) = of[j as usize];
                for (k, motion) in self.bodies[b as usize].motions.iter().enumerate() {
                    let [sum, size] = row.entry(first[b as usize] + k).or_default();
                    let part = value * motion[at as usize];
                    *sum += part;
                    *size += part.abs();
                }
            }
            let remains = row.iter().filter(|(_, [sum, size])| sum.abs() > CANCELLED * size);
            jumps.append_row(remains.map(|(&k, &[sum, _])| (k as u32, sum)));
            row.clear();
        }
        jumps
    }

    /// Combinations of the motions, of lengths of order one, that move nothing along the rows `constrained` of the `jumps` by
    /// more than the part `unseen` of the largest displacement; `scale` is the size of `B`.
    pub(crate) fn without_jump(&self, jumps: &Csr, constrained: &[usize], scale: f64, unseen: f64) -> Vec<Vec<f64>> {
        self.without_jump_among(jumps, (constrained, &vec![false; self.len()]), scale, unseen, &Among::ALONE)
    }

    /// The same without the motions `held`, the same on all ranks that share the rows.
    pub(crate) fn without_jump_among(
        &self,
        jumps: &Csr,
        (constrained, held): (&[usize], &[bool]),
        scale: f64,
        unseen: f64,
        among: &Among,
    ) -> Vec<Vec<f64>> {
        let largest = self.bodies.iter().flat_map(|b| b.motions.iter().map(|r| max_abs(r)));
        let mut largest: Vec<f64> = largest.chain([scale]).collect();
        (among.max)(&mut largest);
        let scale = largest.pop().unwrap_or_default().max(f64::MIN_POSITIVE);
        // Motions by their largest displacement.
        let unit: Vec<f64> = largest.iter().map(|largest| 1.0 / largest).collect();
        let k = unit.len();
        let mut gram = vec![0.0; k * k];
        for &i in constrained {
            for (a, of_a) in jumps.entries_of(i) {
                for (b, of_b) in jumps.entries_of(i) {
                    let (a, b) = (a as usize, b as usize);
                    gram[a * k + b] += of_a * unit[a] / scale * (of_b * unit[b] / scale);
                }
            }
        }
        (among.sum)(&mut gram);
        let mut gram: Vec<Vec<f64>> = gram.chunks(k.max(1)).map(<[f64]>::to_vec).collect();
        (0..k).filter(|&a| held[a]).for_each(|a| gram[a][a] += 1.0);
        let free = near_kernel_of(&gram, unseen * unseen).into_iter();
        free.map(|vector| vector.iter().zip(&unit).map(|(v, u)| v * u).collect()).collect()
    }

    /// As many unknowns of each body as it has motions, spread so that holding them stops all of them: each time the
    /// unknown that moves most in the motions the ones before leave free (the pivots of a QR factorisation of `R'`).
    /// Springs at these unknowns make `K` definite, and carry nothing where loads are in balance: the inverse is an
    /// exact generalised inverse of `K` (Brzobohaty, Dostal, Kozubek, Kovar & Markopoulos 2011).
    pub fn fixing(&self) -> Vec<u32> {
        self.bodies.iter().flat_map(fixing).collect()
    }
}

/// Orthonormal eigenvectors of a symmetric matrix with eigenvalues up to `least`.
pub(crate) fn near_kernel_of(gram: &[Vec<f64>], least: f64) -> Vec<Vec<f64>> {
    // Mostly there are none, which a factorisation tells in much less time than eigenvalues.
    let less = |(a, row): (usize, &Vec<f64>)| {
        let mut row = row[..=a].to_vec();
        row[a] -= 2.0 * least;
        row
    };
    if SmallCholesky::new(gram.iter().enumerate().map(less).collect()).is_some() {
        return Vec::new();
    }
    let (values, vectors) = symmetric_eigen(gram);
    values.into_iter().zip(vectors).filter(|(value, _)| *value <= least).map(|(_, vector)| vector).collect()
}

fn fixing(body: &FloatingBody) -> Vec<u32> {
    let count = body.motions.len();
    let mut rows: Vec<Vec<f64>> = (0..body.unknowns.len()).map(|i| column(&body.motions, i)).collect();
    let mut fixed = Vec::with_capacity(count);
    for _ in 0..count {
        let lengths = rows.iter().map(|row| dot(row, row)).enumerate();
        // The first of equals, whatever the last digits say.
        let best = lengths.fold((0, 0.0), |best, (i, length)| if length > 1.001 * best.1 { (i, length) } else { best });
        let direction: Vec<f64> = rows[best.0].iter().map(|v| v / best.1.sqrt()).collect();
        rows.iter_mut().for_each(|row| axpy(-dot(row, &direction), &direction, row));
        fixed.push(body.unknowns[best.0]);
    }
    fixed
}

fn column<V: AsRef<[f64]>>(rows: &[V], k: usize) -> Vec<f64> {
    rows.iter().map(|row| row.as_ref()[k]).collect()
}

/// The unknowns of each connected component of the graph of `k`, ascending; components by their lowest unknown.
pub fn components(k: &SymmetricCsr) -> Vec<Vec<u32>> {
    // Each unknown points to a lower one of its component, the lowest to itself.
    let mut parent: Vec<u32> = (0..k.rows as u32).collect();
    fn root(parent: &mut [u32], mut i: u32) -> u32 {
        while parent[i as usize] != i {
            let above = parent[parent[i as usize] as usize];
            parent[i as usize] = above;
            i = above;
        }
        i
    }
    for i in 0..k.rows {
        let (columns, values) = k.row(i);
        let mut own = root(&mut parent, i as u32);
        for (&j, _) in columns.iter().zip(values).filter(|(_, v)| **v != 0.0) {
            // Nearly always they hang together already.
            if parent[j as usize] != own {
                let other = root(&mut parent, j);
                let (low, high) = (own.min(other), own.max(other));
                parent[high as usize] = low;
                own = low;
            }
        }
    }
    let (mut number, mut all) = (vec![u32::MAX; k.rows], Vec::<Vec<u32>>::new());
    for i in 0..k.rows as u32 {
        let root = root(&mut parent, i) as usize;
        if root == i as usize {
            number[root] = all.len() as u32;
            all.push(Vec::new());
        }
        all[number[root] as usize].push(i);
    }
    all
}

/// An orthonormal basis of the near-kernel restricted to `unknowns`, and its coefficients in the near-kernel.
fn basis(near_kernel: &[[f64; 6]], unknowns: &[u32]) -> (Vec<Vec<f64>>, Vec<[f64; 6]>) {
    let (mut motions, mut coefficients): (Vec<Vec<f64>>, Vec<[f64; 6]>) = Default::default();
    // Translations come first: what they leave of the rotations is about the body's own centre.
    for k in 0..6 {
        let mut motion: Vec<f64> = unknowns.iter().map(|&i| near_kernel[i as usize][k]).collect();
        let mut coefficient = [0.0; 6];
        coefficient[k] = 1.0;
        let own = norm(&motion);
        // A small remainder has lost digits: it is made orthogonal once more.
        for _ in 0..2 {
            for (m, c) in motions.iter().zip(&coefficients) {
                let along = dot(&motion, m);
                axpy(-along, m, &mut motion);
                axpy(-along, c, &mut coefficient);
            }
        }
        let left = norm(&motion);
        if left > DEPENDENT * own {
            motions.push(motion.iter().map(|v| v / left).collect());
            coefficients.push(coefficient.map(|v| v / left));
        }
    }
    (motions, coefficients)
}

/// `R' K R` on the unknowns of one component, entries below `rounding` taken for zero; `place` is where an unknown
/// stands among those of its component.
#[allow(clippy::needless_range_loop)] // a symmetric matrix is written by its indices
fn energies(k: &SymmetricCsr, unknowns: &[u32], place: &[u32], motions: &[Vec<f64>], rounding: f64) -> Vec<Vec<f64>> {
    let count = motions.len();
    // All motions of an unknown side by side: the matrix is read once.
    let mut moved = vec![[0.0; 6]; unknowns.len()];
    for (b, motion) in motions.iter().enumerate() {
        moved.iter_mut().zip(motion).for_each(|(moved, &v)| moved[b] = v);
    }
    let mut forces = vec![[0.0; 6]; unknowns.len()];
    for (at, &i) in unknowns.iter().enumerate() {
        let (columns, values) = k.row(i as usize);
        for (&j, &v) in columns.iter().zip(values).filter(|(_, v)| **v != 0.0) {
            let other = place[j as usize] as usize;
            (0..6).for_each(|b| forces[at][b] += v * moved[other][b]);
            if other != at {
                (0..6).for_each(|b| forces[other][b] += v * moved[at][b]);
            }
        }
    }
    let mut energies = vec![vec![0.0; count]; count];
    for (own, force) in moved.iter().zip(&forces) {
        for b in 0..count {
            (0..=b).for_each(|a| energies[a][b] += own[a] * force[b]);
        }
    }
    for b in 0..count {
        for a in 0..=b {
            let energy = energies[a][b];
            let energy = if energy.abs() <= rounding { 0.0 } else { energy };
            (energies[a][b], energies[b][a]) = (energy, energy);
        }
    }
    energies
}
