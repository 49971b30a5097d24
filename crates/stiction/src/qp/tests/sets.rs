use super::super::*;
use super::*;
use crate::linalg::norm;

/// Three fields on a grid of `side^2` points, each with the kernel `1 / sqrt(distance^2 + 1/4)`, which is positive
/// definite (an inverse multiquadric) and falls like that of an elastic half space.
fn half_space(side: usize) -> Dense {
    let m = side * side;
    let entry = |i: usize, j: usize| {
        let (dx, dy) = ((i % side) as f64 - (j % side) as f64, (i / side) as f64 - (j / side) as f64);
        1.0 / (dx * dx + dy * dy + 0.25).sqrt()
    };
    Dense(
        (0..3 * m)
            .map(|i| (0..3 * m).map(|j| if i / m == j / m { entry(i % m, j % m) } else { 0.0 }).collect())
            .collect(),
    )
}

struct Case {
    name: String,
    a: Dense,
    b: Vec<f64>,
    sets: Vec<PointSet>,
}

fn cases() -> Vec<Case> {
    let mut cases = Vec::new();
    for (seed, radius) in [(1, 0.3), (2, 1.0), (3, 3.0)] {
        let mut numbers = Numbers::new(seed);
        let a = Dense::with_spectrum(&spread(120, 1e-3, 1.0), &mut numbers);
        let b = numbers.vector(120);
        let disc = |_| PointSet::HalfLineAndDisc { radius };
        cases.push(Case { name: format!("random, discs {radius}"), a, b, sets: (0..40).map(disc).collect() });
    }
    for radius in [0.02, 0.1, 0.5] {
        let (mut numbers, side) = (Numbers::new(9), 12);
        let m = side * side;
        let b: Vec<f64> = (0..3 * m)
            .map(|k| {
                let x = (k % m % side) as f64 / side as f64;
                if k < m { 2.0 - 3.0 * x } else { 1.5 - 2.0 * x * (k / m) as f64 + 0.2 * numbers.next() }
            })
            .collect();
        let disc = |_| PointSet::HalfLineAndDisc { radius };
        cases.push(Case {
            name: format!("half space, discs {radius}"),
            a: half_space(side),
            b: b.clone(),
            sets: (0..m).map(disc).collect(),
        });
        let ellipse = |j| PointSet::HalfLineAndEllipse { radii: [radius, 0.3 * radius], angle: 0.01 * j as f64 };
        cases.push(Case {
            name: format!("half space, ellipses {radius}"),
            a: half_space(side),
            b,
            sets: (0..m).map(ellipse).collect(),
        });
    }
    cases
}

fn run(case: &Case, settings: &SetSettings, relative: f64) -> SetSolution {
    let mut operator = |x: &[f64]| case.a.times(x);
    let problem = SetProblem { operator: &mut operator, b: &case.b, largest_eigenvalue: None, preconditioner: None };
    let start = vec![0.0; case.b.len()];
    minimize_in_sets(problem, &case.sets, &start, settings, relative * norm(&case.b), 50_000, &mut |_, _| false)
}

#[test]
fn print_sets() {
    for case in cases() {
        let flat = SetSettings { follow_boundaries: false, ..SetSettings::default() };
        let s = run(&case, &flat, 1e-8);
        println!("S {}: flat {:?} {:?} {:.1e}", case.name, s.status, s.counts, s.reduced_gradient);
        for forcing in [0.5, 0.3, 0.1, 0.01] {
            let s = run(&case, &SetSettings { forcing, ..SetSettings::default() }, 1e-8);
            println!("S      curved {forcing} {:?} {:?} {:.1e}", s.status, s.counts, s.reduced_gradient);
        }
        let weight = vec![1.0; case.sets.len()];
        let zero = vec![0.0; case.b.len()];
        let mut steps = 0;
        let (mut x, mut ax, mut products) = (zero.clone(), zero, 0);
        while steps < 20000 {
            let r = accelerated_gradient(|x| case.a.times(x), &case.b, &case.sets, &weight, &x, &ax, 200);
            steps += 200;
            products += r.products;
            x = r.x;
            ax = r.a_times_x;
            let mut y: Vec<f64> = x.iter().zip(ax.iter().zip(&case.b)).map(|(x, (a, b))| x - (a - b) * 0.1).collect();
            project(&case.sets, &mut y);
            let d: Vec<f64> = y.iter().zip(&x).map(|(y, x)| (y - x) / 0.1).collect();
            if norm(&d) <= 1e-8 * norm(&case.b) {
                break;
            }
        }
        println!("S      accelerated {products}");
        let slip = case
            .sets
            .iter()
            .enumerate()
            .filter(|(j, s)| {
                let (r, f) = s.axes();
                let m = case.sets.len();
                let p = set::into_axes(f, [x[m + j], x[2 * m + j]]);
                (p[0] / r[0]).hypot(p[1] / r[1]) > 1.0 - 1e-9
            })
            .count();
        println!(
            "S      boundary {slip} open {} of {}",
            (0..case.sets.len()).filter(|j| x[*j] == 0.0).count(),
            case.sets.len()
        );
    }
}
