//! Random small problems from bare matrices, built around a solution that obeys the law.

use proptest::prelude::*;
use stiction::certificate::certify;
use stiction::contact::{ContactProblem, Friction};
use stiction::linalg::{Csr, SymmetricCsr};
use stiction_fixtures::*;

/// A small linear congruential generator: one number seeds a whole problem.
struct Noise(u64);

impl Noise {
    /// Uniform in (-1, 1).
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }

    fn vector(&mut self, n: usize) -> Vec<f64> {
        (0..n).map(|_| self.next()).collect()
    }
}

/// `m` points on `3m + extra` unknowns with a known solution `(u, lambda)`; `law` makes the law of a point from a
/// number in (0, 1).
fn problem(m: usize, extra: usize, seed: u64, law: impl Fn(f64) -> Friction) -> (ContactProblem, Vec<f64>, Vec<f64>) {
    let n = 3 * m + extra;
    let mut noise = Noise(seed);
    let a: Vec<Vec<f64>> = (0..n).map(|_| noise.vector(n)).collect();
    let mut entries = Vec::new();
    for i in 0..n {
        for j in 0..n {
            let product: f64 = (0..n).map(|k| a[k][i] * a[k][j]).sum();
            entries.push((i, j, product / n as f64 + if i == j { 0.3 } else { 0.0 }));
        }
    }
    let k = Csr::from_triplets(n, n, &entries);
    // Rows near those of a node in its own frame, so that they are independent.
    let mut rows = Vec::new();
    for i in 0..3 * m {
        let own = 3 * (i % m) + i / m;
        rows.push((i, own, 1.0));
        for j in (0..n).filter(|&j| j != own) {
            rows.push((i, j, 0.1 * noise.next()));
        }
    }
    let b = Csr::from_triplets(3 * m, n, &rows);
    let u = noise.vector(n);
    let mut lambda = vec![0.0; 3 * m];
    let (mut gap, mut reference) = (vec![0.0; m], vec![0.0; 2 * m]);
    let mut friction = Vec::new();
    let jump = b.times(&u);
    for j in 0..m {
        let force = 0.1 + 0.5 * (noise.next() + 1.0);
        let law = law(0.5 * (noise.next() + 1.0));
        friction.push(law);
        let state = (noise.next() + 1.0) * 1.5;
        let (open, slip) = (state < 1.0, state > 2.0);
        let normal = if open { 0.0 } else { force };
        let limit = match law {
            Friction::Coulomb { coefficient } => coefficient * normal,
            Friction::Given { slip_bound } => slip_bound,
            Friction::Limited { coefficient, limit } => (coefficient * normal).min(limit),
            Friction::Cohesive { coefficient, cohesion, .. } if normal > 0.0 => cohesion + coefficient * normal,
            Friction::None | Friction::Cohesive { .. } | Friction::Bonded => 0.0,
        };
        let angle = 4.0 * noise.next();
        let slips = slip || open;
        let share = if slips { 1.0 } else { 0.4 * (noise.next() + 1.0) };
        let length = if slips { 0.1 + noise.next().abs() } else { 0.0 };
        lambda[j] = normal;
        gap[j] = jump[j] + if open { 0.1 + noise.next().abs() } else { 0.0 };
        for (c, direction) in [angle.cos(), angle.sin()].into_iter().enumerate() {
            lambda[(c + 1) * m + j] = share * limit * direction;
            reference[c * m + j] = jump[(c + 1) * m + j] - length * direction;
        }
    }
    let mut f = k.times(&u);
    f.iter_mut().zip(b.transpose_times(&lambda)).for_each(|(f, b)| *f += b);
    let k = SymmetricCsr::from_full(&k, "K").unwrap();
    let mut p = ContactProblem::from_matrices(k, f, b, gap, friction);
    p.contact.slip_reference = reference;
    p.validate().unwrap();
    (p, u, lambda)
}

fn permuted(p: &ContactProblem, order: &[usize]) -> ContactProblem {
    let m = p.points();
    let rows: Vec<u32> = (0..3).flat_map(|k| order.iter().map(move |&j| (k * m + j) as u32)).collect();
    let mut q = p.clone();
    q.contact.B = p.contact.B.select_rows(&rows);
    q.contact.gap = order.iter().map(|&j| p.contact.gap[j]).collect();
    q.contact.friction = order.iter().map(|&j| p.contact.friction[j]).collect();
    q.contact.slip_reference =
        (0..2).flat_map(|k| order.iter().map(move |&j| p.contact.slip_reference[k * m + j])).collect();
    q
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(300) })]

    #[test]
    fn a_point_that_obeys_the_law_is_certified(m in 1usize..12, extra in 0usize..8, seed: u64) {
        for given in [false, true] {
            let law = |x: f64| match given {
                true => Friction::Given { slip_bound: x },
                false => Friction::Coulomb { coefficient: 2.0 * x },
            };
            let (p, u, lambda) = problem(m, extra, seed, law);
            let c = certify(&p, &u, &lambda, 1e-12);
            prop_assert!(c.passed, "{:?}", c.measures());
        }
    }

    #[test]
    fn given_friction_is_solved_and_its_forces_are_unique(m in 1usize..12, extra in 0usize..8, seed: u64) {
        let (p, u, lambda) = problem(m, extra, seed, |x| Friction::Given { slip_bound: x });
        let s = attempt(&p, &settings(1e-10));
        prop_assert!(s.certificate.passed, "{:?} {:?} {:?}", s.status, s.counts, s.certificate.measures());
        prop_assert!(distance(&s.u, &u) < 1e-6 && distance(&s.lambda, &lambda) < 1e-6);
    }

    #[test]
    fn coulomb_friction_is_solved(m in 1usize..12, extra in 0usize..8, seed: u64) {
        let (p, _, _) = problem(m, extra, seed, |x| Friction::Coulomb { coefficient: 0.6 * x });
        let s = attempt(&p, &settings(1e-10));
        prop_assert!(s.certificate.passed, "{:?} {:?} {:?}", s.status, s.counts, s.certificate.measures());
    }

    #[test]
    fn the_order_of_the_points_does_not_matter(m in 2usize..10, seed: u64, turn in 1usize..9) {
        let (p, _, _) = problem(m, 3, seed, |x| Friction::Given { slip_bound: x });
        let order: Vec<usize> = (0..m).map(|j| (m - 1 - j + turn) % m).collect();
        let (a, b) = (attempt(&p, &settings(1e-10)), attempt(&permuted(&p, &order), &settings(1e-10)));
        prop_assert!(a.certificate.passed && b.certificate.passed);
        let expected: Vec<f64> = (0..3).flat_map(|k| order.iter().map(move |&j| (k, j)))
            .map(|(k, j)| a.lambda[k * m + j]).collect();
        prop_assert!(distance(&expected, &b.lambda) < 1e-6);
    }
}
