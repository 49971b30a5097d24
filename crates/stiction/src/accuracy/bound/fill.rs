//! Stress in a tetrahedron from tractions on its faces.
//!
//! The tetrahedron is cut at its centroid into four; the stress is linear in each, with continuous tractions between them
//! (Křížek 1982, "An equilibrium finite element method in three-dimensional elasticity"; Johnson and Mercier 1978 in the
//! plane). Tractions at the corners of the faces and the mean stress determine it uniquely, and if the tractions balance, the
//! mean stress with a constant divergence follows from them. The Piola map `σ = F σ̂ Fᵀ / |det F|` carries both to the
//! reference tetrahedron, where one matrix does all.
//!
//! Traction is taken times the area of its face: `F⁻¹` alone carries it to the reference tetrahedron.

use std::array::from_fn;
use std::sync::LazyLock;

use super::tets::{PLACE, Shape, without};
use crate::fem::Voigt;
use crate::linalg::{SmallLu, vectorised};
#[cfg(test)]
use crate::mesh::v3::norm;
use crate::mesh::v3::{V3, add, cross, dot, mean, scale, sub};

/// Traction times area at the corners of the four faces of a cell, out of it.
pub(super) type Sides = [[V3; 3]; 4];
/// A pair of faces of a cell `(j, k)`, `j <= k`, in the order of their blocks.
pub(super) const BLOCKS: [[usize; 2]; 10] =
    [[0, 0], [0, 1], [0, 2], [0, 3], [1, 1], [1, 2], [1, 3], [2, 2], [2, 3], [3, 3]];
/// The part of an energy matrix that belongs to a pair of faces: component `3 a + c` of corner `a`.
pub(super) type Block = [[f32; 9]; 9];
/// Energy of the stress of tractions, for [`BLOCKS`].
pub(super) type Matrix = [Block; 10];

/// Four parts with four corners each, and the sum of these.
const TENSORS: usize = 20;
/// Pairs `k <= l` of components.
const PAIRS: usize = 21;

/// In the reference tetrahedron: six components at each corner of each part, then of the sum, from the 36 tractions.
static STRESS: LazyLock<Box<[[[f64; 36]; 6]; TENSORS]>> = LazyLock::new(reference_stress);
/// The same by columns.
static COLUMNS: LazyLock<Box<[[f64; 6 * TENSORS]; 36]>> =
    LazyLock::new(|| Box::new(from_fn(|p| from_fn(|at| STRESS[at / 6][at % 6][p]))));
/// Products of components `k <= l`, summed over the parts, as matrices of the tractions.
static PRODUCTS: LazyLock<Vec<[[[f64; 9]; 9]; 10]>> = LazyLock::new(products);

/// The corners of part `j`: the centroid, number 4, in the place of corner `j`.
fn part(j: usize) -> [usize; 4] {
    from_fn(|a| if a == j { 4 } else { a })
}

/// Writes the three rows of `σ n` by the six components of `σ`.
fn rows(n: V3) -> [[f64; 6]; 3] {
    let mut rows = [[0.0; 6]; 3];
    for (a, row) in rows.iter_mut().enumerate() {
        (0..3).for_each(|b| row[PLACE[a][b]] += n[b]);
    }
    rows
}

fn reference_stress() -> Box<[[[f64; 36]; 6]; TENSORS]> {
    let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let centroid = mean(corners.into_iter());
    let place = |node: usize| corners.get(node).copied().unwrap_or(centroid);
    let column = |j: usize, node: usize| 24 * j + 6 * part(j).iter().position(|&n| n == node).unwrap_or(0);
    let (mut left, mut right): (Vec<Vec<f64>>, Vec<[f64; 36]>) = (Vec::new(), Vec::new());
    for j in 0..4 {
        for l in j + 1..4 {
            let shared: Vec<usize> = (0..5).filter(|&node| node != j && node != l).collect();
            let [a, b, c] = [0, 1, 2].map(|i| place(shared[i]));
            let normal = rows(cross(sub(b, a), sub(c, a)));
            for &node in &shared {
                for row in &normal {
                    let mut terms = vec![0.0; 96];
                    (0..6).for_each(|k| terms[column(j, node) + k] += row[k]);
                    (0..6).for_each(|k| terms[column(l, node) + k] -= row[k]);
                    left.push(terms);
                    right.push([0.0; 36]);
                }
            }
        }
    }
    // The mean from the tractions: `∫ t ⊗ (x - centroid)` over the faces, whose volume is a sixth.
    let mut from_tractions = [[0.0; 36]; 6];
    for j in 0..4 {
        let nodes = without(&[0, 1, 2, 3], j).map(|node| node as usize);
        let [a, b, c] = nodes.map(place);
        let area = cross(sub(b, a), sub(c, a));
        let outward = if dot(area, sub(a, corners[j])) > 0.0 { area } else { scale(-1.0, area) };
        // Traction times area of a face of area |area| / 2.
        let normal = rows(scale(0.5, outward));
        let arms = nodes.map(|node| sub(place(node), centroid));
        let total = arms.iter().fold([0.0; 3], |sum, &arm| add(sum, arm));
        for (q, &node) in nodes.iter().enumerate() {
            for (i, row) in normal.iter().enumerate() {
                let mut terms = vec![0.0; 96];
                terms[column(j, node)..][..6].copy_from_slice(row);
                let mut given = [0.0; 36];
                given[9 * j + 3 * q + i] = 1.0;
                left.push(terms);
                right.push(given);
                let arm = scale(0.5, add(arms[q], total));
                // Off the diagonal both orders share a component: half of each.
                for (b, arm) in arm.into_iter().enumerate() {
                    let part = if b == i { 1.0 } else { 0.5 };
                    from_tractions[PLACE[i][b]][9 * j + 3 * q + i] += part * arm;
                }
            }
        }
    }
    for (k, given) in from_tractions.into_iter().enumerate() {
        let mut terms = vec![0.0; 96];
        (0..16).for_each(|node| terms[6 * node + k] = 1.0 / 16.0);
        left.push(terms);
        right.push(given);
    }
    let factor = SmallLu::new(left);
    let mut stress = Box::new([[[0.0; 36]; 6]; TENSORS]);
    for p in 0..36 {
        let solution = factor.solve(&right.iter().map(|row| row[p]).collect::<Vec<f64>>());
        for (at, value) in solution.into_iter().enumerate() {
            let (j, a, k) = (at / 24, at / 6 % 4, at % 6);
            stress[5 * j + a][k][p] = value;
            stress[5 * j + 4][k][p] += value;
        }
    }
    stress
}

/// The pairs `k <= l` in their order.
fn pairs() -> impl Iterator<Item = [usize; 2]> {
    (0..6).flat_map(|k| (k..6).map(move |l| [k, l]))
}

fn products() -> Vec<[[[f64; 9]; 9]; 10]> {
    let of_pair = |[k, l]: [usize; 2]| {
        let mut table = [[[0.0; 9]; 9]; 10];
        for (block, [j, m]) in table.iter_mut().zip(BLOCKS) {
            for (p, row) in block.iter_mut().enumerate() {
                for (q, entry) in row.iter_mut().enumerate() {
                    let (p, q) = (9 * j + p, 9 * m + q);
                    let sum: f64 = STRESS.iter().map(|s| s[k][p] * s[l][q] + s[l][p] * s[k][q]).sum();
                    *entry = if k == l { 0.5 * sum } else { sum };
                }
            }
        }
        table
    };
    let list: Vec<_> = pairs().map(of_pair).collect();
    debug_assert_eq!(list.len(), PAIRS);
    list
}

/// What carries a cell to the reference tetrahedron.
pub(super) struct Map {
    /// Columns of `F`: the edges from the first corner.
    edges: [V3; 3],
    /// Rows of `F⁻¹`.
    inverse: [V3; 3],
    volume: f64,
}

impl Map {
    pub(super) fn new(shape: &Shape) -> Map {
        let edges = [1, 2, 3].map(|i| sub(shape.x[i], shape.x[0]));
        let [_, a, b, c] = shape.gradient;
        Map { edges, inverse: [a, b, c], volume: shape.volume }
    }

    /// `|det F|⁻¹ P` with `σ = P σ̂ / |det F|`.
    fn forward(&self) -> [[f64; 6]; 6] {
        let factor = 1.0 / (6.0 * self.volume);
        let f = |a: usize, i: usize| self.edges[i][a];
        let mut p = [[0.0; 6]; 6];
        for a in 0..3 {
            for b in a..3 {
                for i in 0..3 {
                    (0..3).for_each(|j| p[PLACE[a][b]][PLACE[i][j]] += factor * f(a, i) * f(b, j));
                }
            }
        }
        p
    }

    /// Energy matrix of the reference stress: `σ̂ᵀ (compliance of the reference) σ̂ V / 80`.
    fn compliance(&self, compliance: &[Voigt; 6]) -> [[f64; 6]; 6] {
        let p = self.forward();
        let half: [[f64; 6]; 6] = from_fn(|k| from_fn(|l| (0..6).map(|m| compliance[k][m] * p[m][l]).sum()));
        let factor = self.volume / 80.0;
        from_fn(|k| from_fn(|l| factor * (0..6).map(|m| p[m][k] * half[m][l]).sum::<f64>()))
    }

    /// Reference stress of tractions: at the corners of the parts, and their sums.
    fn reference(&self, sides: &Sides) -> [Voigt; TENSORS] {
        let mut given = [0.0; 36];
        for (at, &t) in given.chunks_exact_mut(3).zip(sides.iter().flatten()) {
            (0..3).for_each(|i| at[i] = dot(self.inverse[i], t));
        }
        let mut stress = [[0.0; 6]; TENSORS];
        // Column by column, which vector units can add up in any order of the rows.
        let columns = &**COLUMNS;
        vectorised(
            #[inline(always)]
            || {
                for (column, given) in columns.iter().zip(&given) {
                    for (sum, value) in stress.as_flattened_mut().iter_mut().zip(column) {
                        *sum += value * given;
                    }
                }
            },
        );
        stress
    }

    /// The stress itself: in part `j`, where the centroid takes the place of corner `j`, at its four corners.
    pub(super) fn parts(&self, sides: &Sides) -> [[Voigt; 4]; 4] {
        let (stress, p) = (self.reference(sides), self.forward());
        from_fn(|j| from_fn(|a| from_fn(|k| (0..6).map(|l| p[k][l] * stress[5 * j + a][l]).sum())))
    }

    /// Squared energy norm of the stress of balanced tractions.
    pub(super) fn energy(&self, sides: &Sides, compliance: &[Voigt; 6]) -> f64 {
        let stress = self.reference(sides);
        let of_reference = self.compliance(compliance);
        let form =
            |s: &Voigt| -> f64 { (0..6).map(|k| s[k] * (0..6).map(|l| of_reference[k][l] * s[l]).sum::<f64>()).sum() };
        stress.iter().map(form).sum()
    }

    /// Writes the matrix of that energy in the tractions, times `factor`, into one of zeros; in single precision, for what need not be exact.
    #[inline(always)] // into what is vectorised
    pub(super) fn write_matrix(&self, compliance: &[Voigt; 6], factor: f64, sum: &mut Matrix) {
        let of_reference = self.compliance(compliance);
        // Lengths of the cell out of both parts: what is left is of order one.
        let length = self.volume.cbrt();
        let weights = pairs().map(|[k, l]| (factor * of_reference[k][l] / (length * length)) as f32);
        let flat = sum.as_flattened_mut().as_flattened_mut();
        for (weight, table) in weights.zip(&*SINGLE) {
            for (sum, value) in flat.iter_mut().zip(table) {
                *sum += weight * value;
            }
        }
        let inverse: [[f32; 3]; 3] = self.inverse.map(|row| row.map(|g| (length * g) as f32));
        for block in sum {
            for row in block.iter_mut() {
                for at in row.chunks_exact_mut(3) {
                    let old = [at[0], at[1], at[2]];
                    (0..3).for_each(|c| at[c] = (0..3).map(|i| old[i] * inverse[i][c]).sum());
                }
            }
            for rows in block.chunks_exact_mut(3) {
                for q in 0..9 {
                    let old = [rows[0][q], rows[1][q], rows[2][q]];
                    (0..3).for_each(|c| rows[c][q] = (0..3).map(|i| old[i] * inverse[i][c]).sum());
                }
            }
        }
    }

    /// The size of that matrix, to choose `factor` by.
    pub(super) fn size(&self, compliance: &[Voigt; 6]) -> f64 {
        let length = self.volume.cbrt();
        let of_reference = self.compliance(compliance);
        (0..6).map(|k| of_reference[k][k]).sum::<f64>() / (length * length)
    }
}

/// [`PRODUCTS`] in single precision, one after the other.
static SINGLE: LazyLock<Vec<Vec<f32>>> = LazyLock::new(|| {
    let single = |table: &[[[f64; 9]; 9]; 10]| table.iter().flatten().flatten().map(|&v| v as f32).collect();
    PRODUCTS.iter().map(single).collect()
});

/// Mean stress of a cell from the tractions on its faces, `(1/V) ∫ t ⊗ (x - centroid)`, whatever constant force acts in it.
pub(super) fn mean_stress(shape: &Shape, sides: &Sides) -> Voigt {
    let centroid = mean(shape.x.into_iter());
    let mut stress = [0.0; 6];
    for (j, side) in sides.iter().enumerate() {
        let nodes = without(&[0, 1, 2, 3], j);
        let arms = nodes.map(|node| sub(shape.x[node as usize], centroid));
        let total = arms.iter().fold([0.0; 3], |sum, &arm| add(sum, arm));
        for (t, arm) in side.iter().zip(arms) {
            let arm = scale(1.0 / (12.0 * shape.volume), add(arm, total));
            for a in 0..3 {
                stress[PLACE[a][a]] += t[a] * arm[a];
                (a + 1..3).for_each(|b| stress[PLACE[a][b]] += 0.5 * (t[a] * arm[b] + t[b] * arm[a]));
            }
        }
    }
    stress
}

/// The compliance of a material: strain, with `2 e_xy` and so on, from stress.
pub(super) fn compliance(law: &crate::fem::elements::Law) -> [Voigt; 6] {
    let unit = |k: usize| -> Voigt { from_fn(|i| f64::from(u8::from(i == k))) };
    // Columns of the stiffness are its rows.
    let factor = SmallLu::new((0..6).map(|k| law.stress(&unit(k)).to_vec()).collect());
    from_fn(|k| {
        let row = factor.solve(&unit(k));
        from_fn(|i| row[i])
    })
}

/// Largest difference of the length of two vectors' sum from balance; for tests and the judge.
#[cfg(test)]
pub(super) fn imbalance(shape: &Shape, sides: &Sides, body_force: V3) -> [f64; 2] {
    let centroid = mean(shape.x.into_iter());
    let (mut force, mut moment, mut size) = (scale(shape.volume, body_force), [0.0; 3], 0.0);
    for (j, side) in sides.iter().enumerate() {
        let arms = without(&[0, 1, 2, 3], j).map(|node| sub(shape.x[node as usize], centroid));
        let total = arms.iter().fold([0.0; 3], |sum, &arm| add(sum, arm));
        for (t, arm) in side.iter().zip(arms) {
            force = add(force, scale(1.0 / 3.0, *t));
            moment = add(moment, scale(1.0 / 12.0, cross(add(arm, total), *t)));
            size += norm(*t) / 3.0;
        }
    }
    let length = shape.volume.cbrt();
    [norm(force) / size, norm(moment) / (size * length)]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shape(x: [V3; 4]) -> Shape {
        let [a, b, c] = [1, 2, 3].map(|i| sub(x[i], x[0]));
        let normals = [cross(b, c), cross(c, a), cross(a, b)];
        let det = dot(a, normals[0]);
        let [g1, g2, g3] = normals.map(|n| scale(1.0 / det, n));
        let g0 = scale(-1.0, add(add(g1, g2), g3));
        Shape { x, gradient: [g0, g1, g2, g3], volume: det.abs() / 6.0, positive: det > 0.0 }
    }

    const CELLS: [[V3; 4]; 2] = [
        [[0.1, 0.2, -0.1], [1.3, 0.1, 0.2], [0.4, 1.1, 0.0], [0.2, 0.3, 0.9]],
        [[0.1, 0.2, -0.1], [0.4, 1.1, 0.0], [1.3, 0.1, 0.2], [0.2, 0.3, 0.9]],
    ];

    /// Outward normals times area.
    fn areas(shape: &Shape) -> [V3; 4] {
        shape.gradient.map(|g| scale(-3.0 * shape.volume, g))
    }

    /// `σ n` at the corners of the faces for a stress with these values at the corners.
    fn sides(shape: &Shape, stress: &[Voigt; 4]) -> Sides {
        let area = areas(shape);
        from_fn(|j| {
            without(&[0, 1, 2, 3], j).map(|node| {
                let s = &stress[node as usize];
                from_fn(|a| (0..3).map(|b| s[PLACE[a][b]] * area[j][b]).sum())
            })
        })
    }

    /// Stress that is linear in the whole cell is one of the fills, and its energy is the integral over the cell.
    #[test]
    fn linear_stress_without_divergence_is_kept() {
        let steel = crate::fem::Material { young: 2.0, poisson: 0.3, ..test_material() };
        let law = crate::fem::elements::Law::new(&steel);
        let compliance = compliance(&law);
        // xx = y, yy = x - 2 z, zz = 3, xy = z, yz = 0.5, xz = y: each row has no divergence.
        let at = |[x, y, z]: V3| -> Voigt { [y, x - 2.0 * z, 3.0, z, 0.5, y] };
        for x in CELLS {
            let shape = shape(x);
            let stress = x.map(at);
            let sides = sides(&shape, &stress);
            let map = Map::new(&shape);
            let form = |s: &Voigt, t: &Voigt| -> f64 {
                let tr = (s[0] + s[1] + s[2]) * (t[0] + t[1] + t[2]);
                let full: f64 =
                    (0..3).map(|k| s[k] * t[k]).sum::<f64>() + 2.0 * (3..6).map(|k| s[k] * t[k]).sum::<f64>();
                1.3 / 2.0 * full - 0.3 / 2.0 * tr
            };
            let total: Voigt = from_fn(|k| stress.iter().map(|s| s[k]).sum());
            let exact = shape.volume / 20.0 * (stress.iter().map(|s| form(s, s)).sum::<f64>() + form(&total, &total));
            let found = map.energy(&sides, &compliance);
            assert!((found - exact).abs() < 1e-12 * exact, "{found} {exact}");
            let mean = mean_stress(&shape, &sides);
            (0..6).for_each(|k| assert!((mean[k] - 0.25 * total[k]).abs() < 1e-13, "{mean:?}"));
            // At the middle of the cell, which all parts share, every part has the mean.
            let p = map.forward();
            let reference = map.reference(&sides);
            for j in 0..4 {
                for k in 0..6 {
                    let value: f64 = (0..6).map(|l| p[k][l] * reference[5 * j + j][l]).sum();
                    assert!((value - 0.25 * total[k]).abs() < 1e-12, "{j} {k}");
                }
            }
        }
    }

    /// Tractions that balance, and belong to no linear stress, are filled without divergence and without jumps inside.
    #[test]
    fn balanced_tractions_are_filled_in_equilibrium() {
        for x in CELLS {
            let shape = shape(x);
            let mut sides: Sides = from_fn(|j| from_fn(|a| from_fn(|c| ((7 * j + 3 * a + c) as f64).sin())));
            balance(&shape, &mut sides);
            assert!(imbalance(&shape, &sides, [0.0; 3]).iter().all(|&part| part < 1e-14));
            let map = Map::new(&shape);
            let (p, reference) = (map.forward(), map.reference(&sides));
            let stress = reference.map(|s| -> Voigt { from_fn(|k| (0..6).map(|l| p[k][l] * s[l]).sum()) });
            let centroid = mean(x.into_iter());
            let place = |node: usize| if node == 4 { centroid } else { x[node] };
            for j in 0..4 {
                let corners = part(j).map(place);
                let inner = self::shape(corners);
                let divergence: V3 = from_fn(|a| {
                    (0..4)
                        .map(|i| (0..3).map(|b| stress[5 * j + i][PLACE[a][b]] * inner.gradient[i][b]).sum::<f64>())
                        .sum()
                });
                assert!(norm(divergence) < 1e-12, "{divergence:?}");
                for l in j + 1..4 {
                    let shared: Vec<usize> = (0..5).filter(|&node| node != j && node != l).collect();
                    let normal =
                        cross(sub(place(shared[1]), place(shared[0])), sub(place(shared[2]), place(shared[0])));
                    for &node in &shared {
                        let of = |j: usize| {
                            let s = stress[5 * j + part(j).iter().position(|&n| n == node).unwrap()];
                            super::super::tets::traction(&s, normal)
                        };
                        assert!(norm(sub(of(j), of(l))) < 1e-12);
                    }
                }
                let area = areas(&shape)[j];
                for (t, node) in sides[j].iter().zip(without(&[0, 1, 2, 3], j)) {
                    let s = stress[5 * j + node as usize];
                    assert!(norm(sub(super::super::tets::traction(&s, area), *t)) < 1e-12);
                }
            }
        }
    }

    /// The matrix in single precision is that of the energy.
    #[test]
    fn the_matrix_is_that_of_the_energy() {
        let steel = crate::fem::Material { young: 2e11, poisson: 0.3, ..test_material() };
        let compliance = compliance(&crate::fem::elements::Law::new(&steel));
        for x in CELLS {
            let shape = shape(x.map(|x| scale(1e-3, x)));
            let mut sides: Sides = from_fn(|j| from_fn(|a| from_fn(|c| ((5 * j + 2 * a + c) as f64).cos())));
            balance(&shape, &mut sides);
            let map = Map::new(&shape);
            let factor = 1.0 / map.size(&compliance);
            let mut matrix = [[[0.0; 9]; 9]; 10];
            map.write_matrix(&compliance, factor, &mut matrix);
            let flat: Vec<f64> = sides.iter().flatten().flatten().copied().collect();
            let mut energy = 0.0;
            for (block, [j, k]) in matrix.iter().zip(BLOCKS) {
                for p in 0..9 {
                    for q in 0..9 {
                        let both = if j == k { 1.0 } else { 2.0 };
                        energy += both * f64::from(block[p][q]) * flat[9 * j + p] * flat[9 * k + q];
                    }
                }
            }
            let exact = factor * map.energy(&sides, &compliance);
            assert!((energy - exact).abs() < 1e-4 * exact, "{energy} {exact}");
        }
    }

    fn test_material() -> crate::fem::Material {
        crate::fem::Material {
            name: "steel".into(),
            young: 1.0,
            poisson: 0.0,
            density: 0.0,
            formulation: crate::fem::Formulation::Auto,
            orthotropic: None,
            expansion: None,
            reference_temperature: 0.0,
        }
    }

    /// Adds the least tractions that make force and moment vanish.
    fn balance(shape: &Shape, sides: &mut Sides) {
        let centroid = mean(shape.x.into_iter());
        let resultant = |sides: &Sides| -> [f64; 6] {
            let mut sum = [0.0; 6];
            for (j, side) in sides.iter().enumerate() {
                let arms = without(&[0, 1, 2, 3], j).map(|node| sub(shape.x[node as usize], centroid));
                let total = arms.iter().fold([0.0; 3], |sum, &arm| add(sum, arm));
                for (t, arm) in side.iter().zip(arms) {
                    let m = cross(add(arm, total), *t);
                    (0..3).for_each(|c| (sum[c], sum[3 + c]) = (sum[c] + t[c] / 3.0, sum[3 + c] + m[c] / 12.0));
                }
            }
            sum
        };
        let unit = |p: usize| -> Sides {
            let mut unit = [[[0.0; 3]; 3]; 4];
            unit[p / 9][p / 3 % 3][p % 3] = 1.0;
            unit
        };
        let of: Vec<[f64; 6]> = (0..36).map(|p| resultant(&unit(p))).collect();
        let gram = (0..6).map(|a| (0..6).map(|b| of.iter().map(|r| r[a] * r[b]).sum()).collect()).collect();
        let factor = SmallLu::new(gram).solve(&resultant(sides));
        for (p, of) in of.iter().enumerate() {
            sides[p / 9][p / 3 % 3][p % 3] -= (0..6).map(|a| of[a] * factor[a]).sum::<f64>();
        }
    }
}
