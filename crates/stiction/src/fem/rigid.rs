use std::fmt;

use super::DofMap;
use super::field::{point, short};
use crate::mesh::Mesh;
use crate::mesh::v3::{V3, add, cross, dot, mean, norm, scale, sub};

/// A rigid motion counts as free if the prescribed components see less than this part of it, with lengths measured
/// in body sizes. It lies well above the rounding of coordinates in mesh files and below one element's width.
const UNSEEN: f64 = 1e-6;

/// Parts of a motion below this are left out of the description.
const READABLE: f64 = 1e-4;

/// A motion that turns a body by less than this part of what it moves it by is described as a translation: an axis a hundred
/// radii away says less than the direction.
const TURNING: f64 = 1e-2;

/// What rounding leaves of a zero, with lengths measured in body sizes.
const ROUNDING: f64 = 1e-12;

/// The unit vector along `v` with components nobody would read set to zero.
fn direction_of(v: V3) -> V3 {
    let v = v.map(|c| if c.abs() < READABLE * norm(v) { 0.0 } else { c });
    v.map(|c| c / norm(v))
}

const AXES: [V3; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// A rigid motion; directions have length one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Motion {
    /// All points move alike.
    Translation {
        /// Unit direction of the translation or of the axis.
        along: V3,
    },
    /// A rotation about the axis `along` through the point `through`, its point nearest to the mean of the body's
    /// nodes. It moves by `advance` (length per radian) along the axis; zero for a pure rotation.
    Rotation {
        /// Unit direction of the translation or of the axis.
        along: V3,
        /// A point of the axis, length.
        through: V3,
        /// Translation along the axis per radian, length.
        advance: f64,
    },
}

impl Motion {
    /// How the middle `centre` of the body moves in `u(x) = t + omega x (x - origin)`; `None` where hardly any of the motion is
    /// that.
    pub fn of_middle(t: V3, omega: V3, origin: V3, centre: V3, radius: f64) -> Option<Motion> {
        let t = add(t, cross(omega, sub(centre, origin)));
        (norm(t) > TURNING * norm(omega) * radius).then(|| Motion::Translation { along: direction_of(t) })
    }

    /// The motion `u(x) = t + omega x (x - origin)` of a body of the given centre and radius, to its direction. What
    /// turns the body by less than a hundredth of its displacement is a translation: the motion is for a person to read.
    pub fn of(t: V3, omega: V3, origin: V3, centre: V3, radius: f64) -> Motion {
        let t = add(t, cross(omega, sub(centre, origin)));
        let (turn, shift) = (norm(omega), norm(t));
        if turn * radius <= TURNING * shift {
            return Motion::Translation { along: direction_of(t) };
        }
        let along = scale(1.0 / turn, omega);
        let snap = |length: f64| if length.abs() < READABLE * radius { 0.0 } else { length };
        let advance = snap(dot(along, t) / turn);
        let through = add(centre, scale(1.0 / turn, cross(along, t))).map(snap);
        Motion::Rotation { along: direction_of(omega), through, advance }
    }
}

impl fmt::Display for Motion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Motion::Translation { along } => write!(f, "translation along {}", direction(along)),
            Motion::Rotation { along, through, advance } => {
                write!(f, "rotation about the axis along {} through {}", direction(along), point(through))?;
                if advance != 0.0 {
                    write!(f, ", combined with a translation along it of {} per radian", short(advance))?;
                }
                Ok(())
            }
        }
    }
}

/// `x`, `y`, `z`, or the components of any other direction.
fn direction(v: V3) -> String {
    match AXES.iter().position(|axis| *axis == v) {
        Some(axis) => ["x", "y", "z"][axis].into(),
        None => point(v),
    }
}

/// The rigid motions of a body that the prescribed displacements do not resist.
#[derive(Debug, Clone, PartialEq)]
pub struct Unconstrained {
    /// Number of the body.
    pub body: u32,
    /// One to six independent motions: translations first, along the coordinate axes where possible.
    pub motions: Vec<Motion>,
}

/// For each connected body the rigid motions that the prescribed displacements leave free; bodies that are constrained do
/// not appear. `body_of_node` numbers the bodies from zero, one entry per node.
///
/// # Panics
/// If `dofs` or `body_of_node` do not belong to the mesh.
pub fn unconstrained_motions(mesh: &Mesh, dofs: &DofMap, body_of_node: &[u32]) -> Vec<Unconstrained> {
    assert_eq!(body_of_node.len(), mesh.nodes.len());
    let bodies = body_of_node.iter().max().map_or(0, |&last| last as usize + 1);
    let mut nodes_of_body = vec![Vec::new(); bodies];
    body_of_node.iter().enumerate().for_each(|(node, &body)| nodes_of_body[body as usize].push(node));
    let mut unconstrained = Vec::new();
    for (body, nodes) in nodes_of_body.iter().enumerate() {
        let centre = mean(nodes.iter().map(|&i| mesh.nodes[i]));
        let size = nodes.iter().map(|&i| norm(sub(mesh.nodes[i], centre))).fold(0.0, f64::max);
        let prescribed = nodes.iter().flat_map(|&i| (3 * i..3 * i + 3).filter(|&dof| dofs.unknown[dof] == u32::MAX));
        let seen = prescribed.map(|dof| {
            let arm = scale(1.0 / size, sub(mesh.nodes[dof / 3], centre));
            let axis = dofs.direction(dof as u32);
            join(axis, cross(arm, axis)) // u_c = t·e_c + ω·(r x e_c)
        });
        let motions = free_motions(&Subspace::spanned(seen.collect()).complement(), centre, size);
        if !nodes.is_empty() && !motions.is_empty() {
            unconstrained.push(Unconstrained { body: body as u32, motions });
        }
    }
    unconstrained
}

/// Names a basis of the space of free motions `(t, ω size)` about `centre`.
fn free_motions(free: &Subspace<6>, centre: V3, size: f64) -> Vec<Motion> {
    // Translations in the space are what is left of it once every rotation is excluded, and the other way round
    // what remains beside them moves by a rotation.
    let rotates = AXES.map(|axis| free.project(join([0.0; 3], axis)));
    let rotating = Subspace::spanned(rotates.to_vec());
    let translating = rotating.complement_in(free);
    let translations = Subspace::spanned(translating.basis.iter().map(|m| parts(*m).0).collect());
    let rotations = Subspace::spanned(rotating.basis.iter().map(|m| parts(*m).1).collect());

    let mut motions: Vec<Motion> =
        translations.readable_basis().into_iter().map(|along| Motion::Translation { along }).collect();
    for along in rotations.readable_basis() {
        let t = rotating.translation_with(along);
        // The velocity of the centre, t = advance * along - along x arm, gives the arm to the axis.
        let snap = |length: f64| if length.abs() < ROUNDING * size { 0.0 } else { length };
        let through = add(centre, scale(size, cross(along, t))).map(snap);
        motions.push(Motion::Rotation { along, through, advance: snap(size * dot(along, t)) });
    }
    motions
}

/// A subspace of `R^D` by an orthonormal basis.
struct Subspace<const D: usize> {
    basis: Vec<[f64; D]>,
}

impl<const D: usize> Subspace<D> {
    /// What the vectors span: Gram-Schmidt that always takes the longest remainder and stops where none exceeds
    /// [`UNSEEN`]. Unlike the Gram matrix of the vectors, it does not depend on how many there are.
    fn spanned(mut vectors: Vec<[f64; D]>) -> Self {
        let mut space = Subspace { basis: Vec::new() };
        while space.basis.len() < D {
            let longest = vectors.iter().max_by(|a, b| inner(a, a).total_cmp(&inner(b, b)));
            let Some(&v) = longest.filter(|v| inner(v, v) > UNSEEN * UNSEEN) else { break };
            // A short remainder has lost digits: it is made orthogonal once more.
            let q = unit(&space.remainder(unit(&v)));
            vectors.iter_mut().for_each(|v| *v = without(*v, &q));
            space.basis.push(q);
        }
        space
    }

    /// `v` less its part in the space.
    fn remainder(&self, v: [f64; D]) -> [f64; D] {
        self.basis.iter().fold(v, without)
    }

    /// The part of `v` in the space.
    fn project(&self, v: [f64; D]) -> [f64; D] {
        let rest = self.remainder(v);
        std::array::from_fn(|k| v[k] - rest[k])
    }

    /// All that is orthogonal to the space.
    fn complement(&self) -> Self {
        let unit_vectors = (0..D).map(|k| std::array::from_fn(|l| (k == l) as u8 as f64));
        let basis = Self::spanned(unit_vectors.map(|e| self.remainder(e)).collect()).basis;
        debug_assert_eq!(basis.len() + self.basis.len(), D);
        Subspace { basis }
    }

    /// All of `whole` that is orthogonal to the space, which lies in `whole`.
    fn complement_in(&self, whole: &Self) -> Self {
        Self::spanned(whole.basis.iter().map(|&v| self.remainder(v)).collect())
    }
}

impl Subspace<3> {
    /// A basis of unit vectors with as many coordinate axes as lie in the space.
    fn readable_basis(&self) -> Vec<V3> {
        let inside = |axis: &V3| norm(self.remainder(*axis)) < UNSEEN;
        let mut basis: Vec<V3> = AXES.into_iter().filter(inside).collect();
        let named = Subspace { basis: basis.clone() };
        basis.extend(named.complement_in(self).basis.iter().map(|v| {
            // Of the two senses the one whose largest component is positive.
            let largest = v.iter().copied().max_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap_or(1.0);
            v.map(|c| if c.abs() < ROUNDING { 0.0 } else { c * largest.signum() })
        }));
        basis
    }
}

impl Subspace<6> {
    /// The translation `t` for which `(t, ω)` lies in the space, where the space holds no pure translation.
    fn translation_with(&self, omega: V3) -> V3 {
        // The rotational parts of the basis are independent but not orthonormal: the basis is transformed until
        // they are, and the combination is then read off by inner products.
        let mut pairs: Vec<(V3, V3)> = Vec::new();
        for &motion in &self.basis {
            let (mut t, mut w) = parts(motion);
            for &(t_done, w_done) in &pairs {
                let along = dot(w, w_done);
                (t, w) = (sub(t, scale(along, t_done)), sub(w, scale(along, w_done)));
            }
            let length = norm(w);
            pairs.push((scale(1.0 / length, t), scale(1.0 / length, w)));
        }
        pairs.iter().fold([0.0; 3], |t, (t_done, w_done)| add(t, scale(dot(omega, *w_done), *t_done)))
    }
}

fn join(t: V3, omega: V3) -> [f64; 6] {
    [t[0], t[1], t[2], omega[0], omega[1], omega[2]]
}

fn parts(m: [f64; 6]) -> (V3, V3) {
    ([m[0], m[1], m[2]], [m[3], m[4], m[5]])
}

fn inner<const D: usize>(a: &[f64; D], b: &[f64; D]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn unit<const D: usize>(v: &[f64; D]) -> [f64; D] {
    let length = inner(v, v).sqrt();
    v.map(|c| c / length)
}

fn without<const D: usize>(v: [f64; D], q: &[f64; D]) -> [f64; D] {
    let along = inner(&v, q);
    std::array::from_fn(|k| v[k] - along * q[k])
}
