//! Discrete problems: bricks of finite elements in contact, and piles of bodies.

use stiction::contact::ContactProblem;
use stiction::discrete::GlobalProblem;
use stiction::linalg::{Csr, norm};

/// An elastic problem as a global one in units in which impulses and velocities are of like size.
pub fn global_of(problem: &ContactProblem) -> GlobalProblem {
    let mut problem = GlobalProblem::of(problem).expect("a law that discrete problems have");
    let stiffness = problem.M.max_abs();
    problem.M.value.iter_mut().for_each(|k| *k /= stiffness);
    problem.w.iter_mut().for_each(|w| *w *= stiffness);
    problem
}

/// Which bodies of a pile touch, and how.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Normals {
    /// Nearest pairs along the line between their centres: a velocity exists that opens all contacts, so that the
    /// problem has a solution (Klarbring & Pang 1998; Acary, Cadoux, Lemarechal & Malick 2011).
    Apart,
    /// Random pairs along random directions: a solution need not exist.
    Random,
}

/// Bodies at random places, masses apart by a hundred, each contact point at a random place of the body.
pub fn pile(bodies: usize, contacts: usize, mu: f64, normals: Normals, seed: u64) -> GlobalProblem {
    let mut state = 0x9e37_79b9_7f4a_7c15 + seed;
    let mut random = move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    };
    let cross =
        |a: [f64; 3], b: [f64; 3]| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let unit = |a: [f64; 3]| a.map(|x| x / norm(&a));
    let side = (bodies as f64).cbrt();
    let place: Vec<[f64; 3]> = (0..bodies).map(|_| [random(), random(), random() + 1.0].map(|x| side * x)).collect();
    let apart = |i: usize, j: usize| std::array::from_fn(|c| place[i][c] - place[j][c]);
    let mut pairs: Vec<(f64, usize, Option<usize>)> = (0..bodies).map(|i| (place[i][2], i, None)).collect();
    pairs.extend((0..bodies).flat_map(|i| (0..i).map(move |j| (i, j))).map(|(i, j)| (norm(&apart(i, j)), i, Some(j))));
    pairs.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut directions = Vec::new();
    for a in 0..contacts {
        let (_, i, other) = pairs[a / 2];
        let n = match (normals, other) {
            (Normals::Random, _) => unit([random(), random(), random()]),
            (Normals::Apart, None) => [0.0, 0.0, 1.0],
            (Normals::Apart, Some(j)) => unit(apart(i, j)),
        };
        let t = unit(cross(n, if n[0].abs() < 0.7 { [1.0, 0.0, 0.0] } else { [0.0, 1.0, 0.0] }));
        for (body, sign) in [(Some(i), 1.0), (other, -1.0)] {
            let Some(body) = body else { continue };
            let arm = n.map(|x| 0.3 * random() - sign * x);
            for (c, d) in [n, t, cross(n, t)].into_iter().enumerate() {
                for (x, turn) in cross(arm, d).into_iter().enumerate() {
                    directions.push((6 * body + x, 3 * a + c, sign * d[x]));
                    directions.push((6 * body + 3 + x, 3 * a + c, sign * turn));
                }
            }
        }
    }
    let mass: Vec<f64> = (0..bodies).map(|_| 10f64.powf(random())).collect();
    let size = 6 * bodies;
    let inertia = |i: usize| (i, i, mass[i / 6] * if i % 6 < 3 { 1.0 } else { 0.4 });
    GlobalProblem {
        dimension: 3,
        M: Csr::from_triplets(size, size, &(0..size).map(inertia).collect::<Vec<_>>()),
        H: Csr::from_triplets(size, 3 * contacts, &directions),
        f: (0..size).map(|i| mass[i / 6] * (0.3 * random() - f64::from(u8::from(i % 6 == 2)))).collect(),
        w: vec![0.0; 3 * contacts],
        mu: vec![mu; contacts],
        equalities: None,
    }
}

/// A matrix from a formula; zeros are not stored.
pub fn dense(rows: usize, cols: usize, entry: impl Fn(usize, usize) -> f64) -> Csr {
    let all = (0..rows).flat_map(|i| (0..cols).map(move |j| (i, j)));
    let entries: Vec<(usize, usize, f64)> = all.map(|(i, j)| (i, j, entry(i, j))).filter(|e| e.2 != 0.0).collect();
    Csr::from_triplets(rows, cols, &entries)
}

/// Two bodies of mass 2 and 1 on a line, three velocities each, the first on a table.
pub fn two_bodies() -> GlobalProblem {
    GlobalProblem {
        dimension: 3,
        M: dense(6, 6, |i, j| if i == j { if i < 3 { 2.0 } else { 1.0 } } else { 0.0 }),
        H: dense(6, 3, |i, j| f64::from(u8::from(i == j))),
        f: vec![-4.0, 1.0, 0.0, -1.0, 3.0, 0.5],
        w: vec![0.0; 3],
        mu: vec![0.2],
        equalities: None,
    }
}
