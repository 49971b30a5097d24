use super::PointSet;
use super::iterate::Iterate;
use crate::linalg::{axpy, dot};

/// Relative distance from its boundary below which a point counts as on it.
const ON_BOUNDARY: f64 = 1e-12;

/// What the pair of a triple may do while its face lasts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Pair {
    /// Inside its set, or unconstrained.
    Free,
    /// Held: by a corner, by a set without extent, or by a boundary along which it is not to move.
    Held,
    /// On a boundary that holds it: it moves along the unit vector `tangent`, and what holds it adds `stiffness`
    /// (the multiplier of the boundary times its curvature) to the second derivative of the objective.
    Along { tangent: [f64; 2], stiffness: f64 },
}

/// The face of a point of a product of sets, with the gradient upon it.
pub(super) struct Arcs {
    /// Whether `x_0` of a triple is free.
    pub normal: Vec<bool>,
    pub pair: Vec<Pair>,
    /// The gradient on the directions of the face.
    pub free: Vec<f64>,
    /// Entries the directions of the face touch.
    pub is_free: Vec<bool>,
    /// Whether some pair moves along a boundary that curves.
    pub curved: bool,
}

impl Arcs {
    /// The face of `x` for the gradient `g`.
    pub(super) fn new(sets: &[PointSet], x: &[f64], g: &[f64]) -> Arcs {
        let m = sets.len();
        let normal = (0..m).map(|j| sets[j] == PointSet::Free || x[j] > 0.0).collect();
        let pair: Vec<Pair> =
            (0..m).map(|j| pair_of(&sets[j], [x[m + j], x[2 * m + j]], [g[m + j], g[2 * m + j]])).collect();
        let curved = pair.iter().any(|p| matches!(p, Pair::Along { stiffness, .. } if *stiffness > 0.0));
        let mut arcs = Arcs { normal, pair, free: g.to_vec(), is_free: vec![true; 3 * m], curved };
        for j in 0..m {
            arcs.is_free[j] = arcs.normal[j];
            arcs.is_free[m + j] = arcs.pair[j] != Pair::Held;
            arcs.is_free[2 * m + j] = arcs.is_free[m + j];
        }
        let mut free = std::mem::take(&mut arcs.free);
        arcs.restrict(&mut free);
        arcs.free = free;
        arcs
    }

    /// Orthogonal projection of `v` onto the directions of the face.
    pub(super) fn restrict(&self, v: &mut [f64]) {
        let m = self.pair.len();
        for j in 0..m {
            if !self.normal[j] {
                v[j] = 0.0;
            }
            match self.pair[j] {
                Pair::Free => {}
                Pair::Held => (v[m + j], v[2 * m + j]) = (0.0, 0.0),
                Pair::Along { tangent: t, .. } => {
                    let along = t[0] * v[m + j] + t[1] * v[2 * m + j];
                    (v[m + j], v[2 * m + j]) = (along * t[0], along * t[1]);
                }
            }
        }
    }

    /// Part of `|v|^2` that lies on the face, one for zero.
    pub(super) fn part_on_face(&self, v: &[f64]) -> f64 {
        let mut on_face = v.to_vec();
        self.restrict(&mut on_face);
        let all = dot(v, v);
        if all > 0.0 { dot(&on_face, &on_face) / all } else { 1.0 }
    }

    /// Adds the stiffness of the boundaries to `ap` and restricts it: the matrix of the face times `p`.
    pub(super) fn bend(&self, p: &[f64], ap: &mut [f64]) {
        let m = self.pair.len();
        for (j, pair) in self.pair.iter().enumerate() {
            if let Pair::Along { stiffness, .. } = pair {
                ap[m + j] += stiffness * p[m + j];
                ap[2 * m + j] += stiffness * p[2 * m + j];
            }
        }
        self.restrict(ap);
    }

    /// Divides by the given power of `1 + a stiffness`.
    fn shorten(&self, v: &mut [f64], a: f64, power: f64) {
        let m = self.pair.len();
        for (j, pair) in self.pair.iter().enumerate() {
            if let Pair::Along { stiffness, .. } = pair {
                let shorter = (1.0 + a * stiffness).powf(-power);
                v[m + j] *= shorter;
                v[2 * m + j] *= shorter;
            }
        }
    }

    /// The largest `t` for which `x - t p` keeps `x_0 >= 0` and the free pairs in their sets.
    pub(super) fn feasible_step(&self, sets: &[PointSet], x: &[f64], p: &[f64]) -> f64 {
        let m = sets.len();
        let mut t = f64::INFINITY;
        for j in 0..m {
            if self.normal[j] && sets[j] != PointSet::Free && p[j] > 0.0 {
                t = t.min(x[j] / p[j]);
            }
            let (x, p) = ([x[m + j], x[2 * m + j]], [p[m + j], p[2 * m + j]]);
            match self.pair[j] {
                Pair::Free => t = t.min(room(&sets[j], x, p)),
                Pair::Held | Pair::Along { .. } => {}
            }
        }
        t
    }
}

/// The largest `t` for which `x - t p` is in the set, for `x` inside a set with a positive radius.
fn room(set: &PointSet, x: [f64; 2], p: [f64; 2]) -> f64 {
    let radius = set.radius();
    let (mut xx, mut xp, mut pp) = (-1.0, 0.0, 0.0);
    for k in 0..2 {
        let (x, p) = (x[k] / radius, p[k] / radius);
        (xx, xp, pp) = (xx + x * x, xp + x * p, pp + p * p);
    }
    if pp == 0.0 {
        return f64::INFINITY;
    }
    // The positive root of |x - t p|^2 = 1, without cancellation.
    let root = (xp * xp - pp * xx.min(0.0)).sqrt();
    if xp > 0.0 { (xp + root) / pp } else { -xx.min(0.0) / (root - xp) }
}

fn pair_of(set: &PointSet, x: [f64; 2], g: [f64; 2]) -> Pair {
    let radius = set.radius();
    if radius == 0.0 {
        return Pair::Held;
    }
    let length = x[0].hypot(x[1]);
    if length / radius < 1.0 - ON_BOUNDARY {
        return Pair::Free;
    }
    let normal = [x[0] / length, x[1] / length];
    let pressing = -(g[0] * normal[0] + g[1] * normal[1]);
    if pressing <= 0.0 {
        return Pair::Held;
    }
    Pair::Along { tangent: [-normal[1], normal[0]], stiffness: pressing / radius }
}

/// The free gradient `r`, preconditioned on the face if that gives a direction of ascent: `S M S r` with the caller's
/// `M` (or the identity) and `S^2 = 1 / (1 + a stiffness)`, the factor by which a projected gradient step of length
/// `a` shortens along a curved boundary.
pub(super) fn preconditioned(arcs: &Arcs, r: &[f64], a: f64, apply: Option<&super::Preconditioner>) -> Vec<f64> {
    let mut z = r.to_vec();
    if let Some(apply) = apply {
        arcs.shorten(&mut z, a, 0.5);
        z = apply(&z, &arcs.is_free);
        if z.len() == r.len() {
            arcs.restrict(&mut z);
            arcs.shorten(&mut z, a, 0.5);
            let ascent = dot(&z, r);
            if ascent > 0.0 && ascent.is_finite() {
                return z;
            }
        }
        z = r.to_vec();
    }
    arcs.shorten(&mut z, a, 1.0);
    z
}

/// How conjugate gradients on a face ended.
pub(super) struct FaceSteps {
    /// The way from `x`, to be projected.
    pub way: Vec<f64>,
    /// The part of it that keeps the free entries in their sets, if the way does not.
    pub feasible: Option<Vec<f64>>,
    pub steps: usize,
}

/// Conjugate gradients for the quadratic model on the face, `min g's + 1/2 s'(A + stiffness)s` over its directions,
/// until the model's gradient is at most `precision` or a free entry leaves its set.
pub(super) fn face_steps(
    it: &mut Iterate,
    sets: &[PointSet],
    arcs: &Arcs,
    a: f64,
    precision: f64,
    apply: Option<&super::Preconditioner>,
) -> super::iterate::Step<FaceSteps> {
    let mut way = vec![0.0; it.x.len()];
    let mut r = arcs.free.clone();
    // The caller's inverse has a scale of its own, against which the boundaries are stiff or not.
    let scale = apply.map_or(f64::NAN, |apply| dot(&apply(&r, &arcs.is_free), &r) / dot(&r, &r));
    let a = if scale > 0.0 && scale.is_finite() { scale } else { a };
    let mut z = preconditioned(arcs, &r, a, apply);
    let mut p = z.clone();
    let mut rz = dot(&r, &z);
    let mut steps = 0;
    let mut feasible = None;
    while dot(&r, &r).sqrt() > precision && steps < r.len() {
        let mut ap = it.times(&p)?;
        arcs.bend(&p, &mut ap);
        let cg = rz / super::mprgp::curvature(it, &p, &ap)?;
        let here: Vec<f64> = it.x.iter().zip(&way).map(|(x, s)| x + s).collect();
        let room = arcs.feasible_step(sets, &here, &p);
        steps += 1;
        it.count(8);
        if cg > room {
            let mut short = way.clone();
            axpy(-room, &p, &mut short);
            feasible = Some(short);
            axpy(-cg, &p, &mut way);
            break;
        }
        axpy(-cg, &p, &mut way);
        axpy(-cg, &ap, &mut r);
        z = preconditioned(arcs, &r, a, apply);
        let next = dot(&r, &z);
        p.iter_mut().zip(&z).for_each(|(p, z)| *p = z + next / rz * *p);
        rz = next;
    }
    std::ops::ControlFlow::Continue(FaceSteps { way, feasible, steps })
}
