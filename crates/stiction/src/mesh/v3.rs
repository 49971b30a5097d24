//! Vectors of three components, for every room that knows a mesh.

pub(crate) type V3 = [f64; 3];

pub(crate) fn add(a: V3, b: V3) -> V3 {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub(crate) fn sub(a: V3, b: V3) -> V3 {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn scale(s: f64, a: V3) -> V3 {
    [s * a[0], s * a[1], s * a[2]]
}

pub(crate) fn dot(a: V3, b: V3) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: V3, b: V3) -> V3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn norm(a: V3) -> f64 {
    dot(a, a).sqrt()
}

/// The mean of some points; zero of none.
pub(crate) fn mean(points: impl Iterator<Item = V3>) -> V3 {
    let (sum, count) = points.fold(([0.0; 3], 0usize), |(sum, count), x| (add(sum, x), count + 1));
    scale(1.0 / count.max(1) as f64, sum)
}

/// `a . (b x c)`.
pub(crate) fn det([a, b, c]: [V3; 3]) -> f64 {
    dot(a, cross(b, c))
}

/// `None` for a vector that has no direction.
pub(crate) fn unit(a: V3) -> Option<V3> {
    let l = norm(a);
    (l > 0.0 && l.is_finite()).then(|| a.map(|c| c / l))
}

/// Two unit vectors across a unit vector and each other.
pub(crate) fn across(n: V3) -> [V3; 2] {
    let least = (0..3).min_by(|&i, &j| n[i].abs().total_cmp(&n[j].abs())).unwrap_or(0);
    let mut e = [0.0; 3];
    e[least] = 1.0;
    let e = sub(e, scale(dot(e, n), n));
    let e = scale(1.0 / norm(e), e);
    [e, cross(n, e)]
}

/// A sum of many places in twice the digits: what is left of it in single numbers does not depend on the order of what is added
/// (Neumaier 1974), so that a mean of nodes is the same however they are divided.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct Sum {
    high: V3,
    low: V3,
}

impl Sum {
    pub(crate) fn add(&mut self, x: V3) {
        for ((high, low), x) in self.high.iter_mut().zip(&mut self.low).zip(x) {
            let sum = *high + x;
            let taken = sum - *high;
            *low += (*high - (sum - taken)) + (x - taken);
            *high = sum;
        }
    }

    pub(crate) fn of(places: impl IntoIterator<Item = V3>) -> Sum {
        let mut sum = Sum::default();
        places.into_iter().for_each(|x| sum.add(x));
        sum
    }

    /// Two numbers a component, whose sums are those of both.
    pub(crate) fn parts(&self) -> [V3; 2] {
        [self.high, self.low]
    }

    pub(crate) fn value(&self) -> V3 {
        add(self.high, self.low)
    }
}
