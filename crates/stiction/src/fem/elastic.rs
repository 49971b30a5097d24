//! Elasticity that depends on the direction: stiffness as a symmetric 6 x 6 matrix.

use crate::mesh::v3::{V3, cross, dot, norm, scale, sub};

/// A symmetric tensor of stress as xx, yy, zz, xy, yz, xz (the order of VTK); one of strain has `2 e_xy` and so on in
/// its last three places.
pub type Voigt = [f64; 6];
/// Stress from strain in that order; symmetric.
pub type Stiffness = [Voigt; 6];

/// Place of the component `(a, b)`.
pub(super) const PLACE: [[usize; 3]; 3] = [[0, 3, 5], [3, 1, 4], [5, 4, 2]];
/// Components of each place.
const COMPONENTS: [[usize; 2]; 6] = [[0, 0], [1, 1], [2, 2], [0, 1], [1, 2], [0, 2]];

/// The directions of two vectors count as one if the sine of their angle is below this.
const PARALLEL: f64 = 1e-6;

/// Three planes of symmetry at right angles (Lekhnitskii 1963, Theory of Elasticity of an Anisotropic Body, § 3).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Orthotropic {
    /// `E1, E2, E3`, stress, > 0.
    pub young: V3,
    /// `nu12, nu13, nu23`: the contraction along the second axis named under tension along the first.
    pub poisson: V3,
    /// `G12, G13, G23`, stress, > 0.
    pub shear: V3,
    /// The axes 1, 2, 3: orthonormal, right-handed.
    pub axes: [V3; 3],
    /// In the axes of the mesh.
    pub stiffness: Stiffness,
}

impl Orthotropic {
    /// The material with its first axis along `axes[0]` and its second in the plane of both.
    ///
    /// # Errors
    /// What is wrong, as a sentence: the inequality that fails where the energy is not positive, or parallel axes.
    pub fn new(young: V3, poisson: V3, shear: V3, axes: [V3; 2]) -> Result<Self, String> {
        let axes = frame(axes)?;
        let local = local(young, poisson, shear)?;
        Ok(Orthotropic { young, poisson, shear, axes, stiffness: turned(&local, &axes) })
    }
}

/// A right-handed frame with its first axis along the first vector and its second in their plane.
///
/// # Errors
/// If a vector has no length or both have one direction: what is wrong, as a sentence.
pub fn frame([first, second]: [V3; 2]) -> Result<[V3; 3], String> {
    let (one, two) = (norm(first), norm(second));
    let lengths = one > 0.0 && two > 0.0 && one.is_finite() && two.is_finite();
    let e1 = scale(1.0 / one, first);
    let across = sub(scale(1.0 / two, second), scale(dot(second, e1) / two, e1));
    if !lengths || norm(across) < PARALLEL {
        return Err(format!("the axes {first:?} and {second:?} do not span a plane"));
    }
    let e2 = scale(1.0 / norm(across), across);
    Ok([e1, e2, cross(e1, e2)])
}

/// The stiffness in the material's own axes, or the inequality that fails.
fn local(young: V3, poisson: V3, shear: V3) -> Result<Stiffness, String> {
    const PAIRS: [[usize; 2]; 3] = [[0, 1], [0, 2], [1, 2]];
    let positive = |v: f64| v > 0.0 && v.is_finite();
    if let Some(k) = young.iter().position(|&e| !positive(e)) {
        return Err(format!("E{} is {} and not positive", k + 1, young[k]));
    }
    if let Some(k) = shear.iter().position(|&g| !positive(g)) {
        let [a, b] = PAIRS[k];
        return Err(format!("G{}{} is {} and not positive", a + 1, b + 1, shear[k]));
    }
    for ([a, b], nu) in PAIRS.iter().zip(poisson) {
        let limit = (young[*a] / young[*b]).sqrt();
        if nu.is_nan() || nu.abs() >= limit {
            let (i, j) = (a + 1, b + 1);
            return Err(format!(
                "the energy is not positive: |nu{i}{j}| = {} is not below sqrt(E{i}/E{j}) = {limit:.6}",
                nu.abs()
            ));
        }
    }
    // Compliance of the direct strains: -nu_ab / E_a off the diagonal.
    let mut s = [[0.0; 3]; 3];
    (0..3).for_each(|k| s[k][k] = 1.0 / young[k]);
    for ([a, b], nu) in PAIRS.iter().zip(poisson) {
        (s[*a][*b], s[*b][*a]) = (-nu / young[*a], -nu / young[*a]);
    }
    let columns = [cross(s[1], s[2]), cross(s[2], s[0]), cross(s[0], s[1])];
    let determinant = dot(s[0], columns[0]);
    let delta = determinant * young[0] * young[1] * young[2];
    if delta.is_nan() || delta <= 0.0 {
        return Err(format!(
            "the energy is not positive: 1 - nu12 nu21 - nu13 nu31 - nu23 nu32 - 2 nu12 nu23 nu31 = {delta:.6} is not above \
             zero, where nu21 = nu12 E2/E1, nu31 = nu13 E3/E1, nu32 = nu23 E3/E2"
        ));
    }
    let mut c = [[0.0; 6]; 6];
    for a in 0..3 {
        for b in a..3 {
            let value = columns[a][b] / determinant;
            (c[a][b], c[b][a]) = (value, value);
        }
    }
    for ([a, b], g) in PAIRS.iter().zip(shear) {
        let place = PLACE[*a][*b];
        c[place][place] = g;
    }
    Ok(c)
}

/// `C_ijkl = R_ia R_jb R_kc R_ld C_abcd`, symmetric to the bit.
fn turned(local: &Stiffness, axes: &[V3; 3]) -> Stiffness {
    let mut c = [[0.0; 6]; 6];
    for p in 0..6 {
        for q in p..6 {
            let ([i, j], [k, l]) = (COMPONENTS[p], COMPONENTS[q]);
            let mut sum = 0.0;
            for a in 0..3 {
                for b in 0..3 {
                    let left = axes[a][i] * axes[b][j];
                    for (r, own) in local[PLACE[a][b]].iter().enumerate().filter(|(_, own)| **own != 0.0) {
                        let [u, v] = COMPONENTS[r];
                        let mut right = axes[u][k] * axes[v][l];
                        if u != v {
                            right += axes[v][k] * axes[u][l];
                        }
                        sum += left * right * own;
                    }
                }
            }
            (c[p][q], c[q][p]) = (sum, sum);
        }
    }
    c
}

/// Strain with the principal values `own` along `axes`.
pub fn strain_along(axes: &[V3; 3], own: V3) -> Voigt {
    let component = |a: usize, b: usize| (0..3).map(|k| own[k] * axes[k][a] * axes[k][b]).sum::<f64>();
    std::array::from_fn(|p| {
        let [a, b] = COMPONENTS[p];
        if a == b { component(a, a) } else { 2.0 * component(a, b) }
    })
}

/// The 3 x 3 block `sum_cd C_acbd gram_cd` of a stiffness matrix. Pairs `(c, d)` and `(d, c)` are added first, so that the
/// transposed `gram` gives the transposed block to the bit.
pub(super) fn contract(stiffness: &Stiffness, gram: &[V3; 3]) -> [V3; 3] {
    let mut block = [[0.0; 3]; 3];
    for a in 0..3 {
        for b in 0..3 {
            let term = |c: usize, d: usize| stiffness[PLACE[a][c]][PLACE[b][d]] * gram[c][d];
            for c in 0..3 {
                block[a][b] += term(c, c);
                for d in c + 1..3 {
                    block[a][b] += term(c, d) + term(d, c);
                }
            }
        }
    }
    block
}
