use super::{PointSet, project};
use crate::linalg::dot;

/// Result of [`accelerated_gradient`].
#[derive(Debug, Clone)]
pub struct Accelerated {
    pub x: Vec<f64>,
    /// `A x`.
    pub a_times_x: Vec<f64>,
    /// Products with `A`.
    pub products: usize,
}

/// Accelerated projected gradients (Beck & Teboulle 2009) with restart on a step against the momentum (O'Donoghue &
/// Candès 2015), in the metric of `weight`: one positive number a triple, an approximation of the inverse of the
/// diagonal of `A`.
///
/// Runs `steps` steps from `x` (with `a_times_x = A x`). The step length starts from the largest eigenvalue of the
/// weighted operator as estimated by a few power steps and is halved whenever the quadratic model is violated, so
/// that the objective falls at each restart whatever the estimate.
pub fn accelerated_gradient(
    mut operator: impl FnMut(&[f64]) -> Vec<f64>,
    b: &[f64],
    sets: &[PointSet],
    weight: &[f64],
    x: &[f64],
    a_times_x: &[f64],
    steps: usize,
) -> Accelerated {
    let m = sets.len();
    let weigh = |v: &[f64]| -> Vec<f64> { v.iter().enumerate().map(|(i, v)| v * weight[i % m.max(1)]).collect() };
    let mut products = 0;
    let mut count = |v: &[f64], products: &mut usize| {
        *products += 1;
        operator(v)
    };
    let mut step = 1.0 / largest_weighted(&weigh, b, |v| count(v, &mut products));
    let (mut x, mut ax) = (x.to_vec(), a_times_x.to_vec());
    let (mut y, mut ay, mut t) = (x.clone(), ax.clone(), 1.0f64);
    for _ in 0..steps {
        let gradient: Vec<f64> = ay.iter().zip(b).map(|(a, b)| a - b).collect();
        let (next, a_next) = loop {
            let mut next: Vec<f64> = y.iter().zip(weigh(&gradient)).map(|(y, g)| y - step * g).collect();
            project(sets, &mut next);
            let a_next = count(&next, &mut products);
            let d: Vec<f64> = next.iter().zip(&y).map(|(n, y)| n - y).collect();
            let curvature: f64 = d.iter().zip(a_next.iter().zip(&ay)).map(|(d, (a, b))| d * (a - b)).sum();
            let metric: f64 = d.iter().enumerate().map(|(i, d)| d * d / weight[i % m.max(1)]).sum();
            if curvature * step <= metric * (1.0 + 1e-9) || step < 1e-12 {
                break (next, a_next);
            }
            step *= 0.5;
        };
        let against = y.iter().zip(next.iter().zip(&x)).map(|(y, (n, x))| (y - n) * (n - x)).sum::<f64>() > 0.0;
        let t_next = if against { 1.0 } else { 0.5 * (1.0 + (1.0 + 4.0 * t * t).sqrt()) };
        let momentum = if against { 0.0 } else { (t - 1.0) / t_next };
        y = next.iter().zip(&x).map(|(n, x)| n + momentum * (n - x)).collect();
        ay = a_next.iter().zip(&ax).map(|(n, x)| n + momentum * (n - x)).collect();
        (x, ax, t) = (next, a_next, t_next);
    }
    Accelerated { x, a_times_x: ax, products }
}

fn largest_weighted(
    weigh: &impl Fn(&[f64]) -> Vec<f64>,
    start: &[f64],
    mut operator: impl FnMut(&[f64]) -> Vec<f64>,
) -> f64 {
    let mut v: Vec<f64> = start.iter().enumerate().map(|(i, s)| s.signum() * (1.5 + (i as f64).sin())).collect();
    let mut value: f64 = 1.0;
    for _ in 0..6 {
        let length = dot(&v, &v).sqrt();
        v.iter_mut().for_each(|x| *x /= length);
        v = weigh(&operator(&v));
        value = dot(&v, &v).sqrt();
    }
    if value.is_finite() && value > 0.0 { value } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::norm;

    #[test]
    fn a_small_problem_reaches_its_optimality_conditions() {
        // Two triples, A = tridiagonal 4, -1 in the stored order.
        let a = |x: &[f64]| -> Vec<f64> {
            (0..6).map(|i| 4.0 * x[i] - if i > 0 { x[i - 1] } else { 0.0 } - x.get(i + 1).unwrap_or(&0.0)).collect()
        };
        let b = [3.0, -2.0, 9.0, 1.0, -9.0, 0.5];
        let sets = [PointSet::HalfLineAndDisc { radius: 1.0 }, PointSet::HalfLineAndDisc { radius: 5.0 }];
        let result = accelerated_gradient(a, &b, &sets, &[0.25, 0.25], &[0.0; 6], &[0.0; 6], 200);
        let gradient: Vec<f64> = a(&result.x).iter().zip(b).map(|(a, b)| a - b).collect();
        let mut moved: Vec<f64> = result.x.iter().zip(&gradient).map(|(x, g)| x - 0.1 * g).collect();
        project(&sets, &mut moved);
        let residual: Vec<f64> = moved.iter().zip(&result.x).map(|(p, x)| p - x).collect();
        assert!(norm(&residual) < 1e-9, "{residual:?}");
        assert!(result.x[1] == 0.0 && (result.x[2].hypot(result.x[4]) - 1.0).abs() < 1e-9);
    }
}
