//! How small rotations, strains and slips are: the theory takes them as small, and how far an answer leaves that shows here.
//!
//! Rotation and strain are those of the displacement gradient `h` at the middle of each cell. The rotation is that of the polar
//! decomposition of `1 + h`, as the angle `atan2(|curl u|, 2 + div u)`: exact for rigid rotations and for plane strain,
//! otherwise right to a part of the angle of the size of the strain. A floating body that turns as a whole counts. The strain is
//! the principal value of `(h + h')/2` of largest size, thermal strain included. At sharp edges both grow without bound as the mesh
//! is refined, so the volume in which a limit is exceeded stands beside the largest values.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::micromotion::slides;
use crate::contact::{ContactSurface, Counterpart, Obstacle, SMALL_MOTION, face_size};
use crate::fem::{Cut, Solid, full_displacement, middle_gradient, strain_of};
use crate::friction::PointState;
use crate::mesh::Mesh;
use crate::mesh::geometry::cell_volume;
use crate::mesh::v3::{V3, add, norm, scale, sub};
use crate::run::pose::Prepared;
use crate::run::solve::Outcome;
use crate::run::solve::record::or_nan;

/// Rotations beyond this are not small, degrees: displacements are then wrong by about half the square of the angle, 0.4 % of
/// the distance from the axis.
pub const SMALL_ROTATION: f64 = 5.0;
/// Strains beyond this are not small.
pub const SMALL_STRAIN: f64 = 0.05;

/// The largest rotation, strain and slip of an answer.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct Smallness {
    /// The largest rotation of a cell, degrees.
    #[serde(deserialize_with = "or_nan")]
    pub rotation: f64,
    /// Centre of that cell before loading, length.
    pub rotation_at: [f64; 3],
    /// Part of the volume in which the rotation exceeds [`SMALL_ROTATION`].
    pub rotation_volume: f64,
    /// The principal strain of largest size of a cell.
    #[serde(deserialize_with = "or_nan")]
    pub strain: f64,
    /// Centre of that cell before loading, length.
    pub strain_at: [f64; 3],
    /// Part of the volume in which the strain exceeds [`SMALL_STRAIN`].
    pub strain_volume: f64,
    /// The farthest slide of a touching point since the start; length.
    pub slip: f64,
    /// The farthest slide over the size of a face, the root of the mean area of the faces of the finer surface. Slides along planes are left
    /// out: there the law is the same everywhere.
    pub slip_over_face: f64,
    /// The pair of that slide.
    pub slip_pair: Option<String>,
    /// Whether all of them are small.
    pub small: bool,
}

/// Cells of which the largest values are found together.
const CHUNK: usize = 4096;

/// The largest value of some cells, where it is, and the volume in which the limit is exceeded.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Extreme {
    pub value: f64,
    /// Centre of the cell before loading, length.
    pub at: V3,
    /// Length cubed.
    pub volume: f64,
}

impl Extreme {
    /// That of both, the first of equal ones.
    pub(crate) fn and(self, other: Extreme) -> Extreme {
        let larger = if other.value > self.value { other } else { self };
        Extreme { volume: self.volume + other.volume, ..larger }
    }
}

/// A body, or the part of one that is looked at.
pub(crate) struct Displaced<'a> {
    pub solid: Solid<'a>,
    /// Displacement of each node, length.
    pub u: &'a [V3],
    /// The cuts of bolts with their shortenings, length.
    pub cuts: Vec<(&'a Cut, f64)>,
    /// Whether a cell counts.
    pub counts: &'a (dyn Fn(usize) -> bool + Sync),
}

/// The largest values of some cells.
#[derive(Clone, Copy, Default)]
struct Largest {
    /// Value, cell, volume beyond the limit.
    rotation: (f64, usize, f64),
    strain: (f64, usize, f64),
}

/// Measures an answer.
pub(crate) fn smallness(prepared: &Prepared, outcome: &Outcome) -> Smallness {
    let Prepared { mesh, materials, material_of_cell, model, loading, surfaces, problem, .. } = prepared;
    let u = full_displacement(model, &outcome.solution.u);
    let cuts = loading.bolts.iter().zip(&loading.initial.shortening);
    let displaced = Displaced {
        solid: Solid { mesh, materials, material_of_cell },
        u: u.as_chunks().0,
        cuts: cuts.map(|(bolt, &shortening)| (&bolt.cut, shortening)).collect(),
        counts: &|_| true,
    };
    let slides = slides(prepared, outcome);
    let slid = |points: std::ops::Range<usize>| {
        let touching = points.filter(|&j| outcome.solution.states[j] != PointState::Open);
        touching.map(|j| slides[j]).fold(0.0, f64::max)
    };
    let slips: Vec<f64> = problem.labels.pairs.iter().take(surfaces.len()).map(|it| slid(it.points.clone())).collect();
    of_extremes(extremes(&displaced), prepared.facts.mesh.volume, (mesh, surfaces), &slips)
}

/// What the largest rotation (degrees) and strain come to in a body of this `volume`, and the farthest slides of touching points of
/// each surface, length.
pub(crate) fn of_extremes(
    [rotation, strain]: [Extreme; 2],
    volume: f64,
    (mesh, surfaces): (&Mesh, &[ContactSurface]),
    slips: &[f64],
) -> Smallness {
    let part = |of: Extreme| (of.volume / volume).min(1.0);
    let mut of = Smallness {
        rotation: rotation.value,
        rotation_at: rotation.at,
        rotation_volume: part(rotation),
        strain: strain.value,
        strain_at: strain.at,
        strain_volume: part(strain),
        ..Smallness::default()
    };
    slide(mesh, surfaces, slips, &mut of);
    // What is not finite is not small.
    of.small = of.rotation <= SMALL_ROTATION && of.strain <= SMALL_STRAIN && of.slip_over_face <= SMALL_MOTION;
    of
}

/// The largest rotation (degrees) and strain of the cells that count.
pub(crate) fn extremes(of: &Displaced) -> [Extreme; 2] {
    let (mesh, cells) = (of.solid.mesh, of.solid.cells());
    let of_chunk = |(number, chunk): (usize, &[u32])| {
        let mut largest = Largest::default();
        let numbers = number * CHUNK..number * CHUNK + chunk.len();
        for cell in numbers.filter(|&cell| (of.counts)(cell)) {
            let (kind, nodes) = cells.get(cell);
            // A cell beyond the cut of a bolt is not strained by the jump.
            let displacement = |node: u32| {
                let jumps = of.cuts.iter().filter(|(cut, _)| {
                    cut.nodes.binary_search(&node).is_ok() && cut.cells.binary_search(&(cell as u32)).is_ok()
                });
                jumps.fold(of.u[node as usize], |u, (cut, shortening)| sub(u, scale(*shortening, cut.axis)))
            };
            if let Some(h) = middle_gradient(mesh, kind, nodes, displacement) {
                largest.add(cell, &h, || cell_volume(&mesh.nodes, kind, nodes));
            }
        }
        largest
    };
    let chunks: Vec<Largest> = of.solid.material_of_cell.par_chunks(CHUNK).enumerate().map(of_chunk).collect();
    let all = chunks.iter().fold(Largest::default(), Largest::and);
    let centre = |cell: usize| {
        let nodes = if of.solid.material_of_cell.is_empty() { &[][..] } else { cells.get(cell).1 };
        let part = 1.0 / nodes.len().max(1) as f64;
        nodes.iter().fold([0.0; 3], |sum, &node| add(sum, scale(part, mesh.nodes[node as usize])))
    };
    [all.rotation, all.strain].map(|(value, cell, volume)| Extreme { value, at: centre(cell), volume })
}

impl Largest {
    fn add(&mut self, cell: usize, h: &[V3; 3], volume: impl Fn() -> f64) {
        // Few cells come near the largest value so far: for the others a bound that costs a tenth tells that.
        let with = |known: &mut (f64, usize, f64), limit: f64, bound: f64, value: &dyn Fn() -> f64| {
            if bound <= known.0.min(limit) {
                return;
            }
            let value = value();
            if value > known.0 {
                (known.0, known.1) = (value, cell);
            }
            if value > limit {
                known.2 += volume();
            }
        };
        with(&mut self.rotation, SMALL_ROTATION, rotation_bound(h).to_degrees(), &|| rotation(h).to_degrees());
        with(&mut self.strain, SMALL_STRAIN, strain_bound(h), &|| largest_principal(h));
    }

    fn and(self, other: &Largest) -> Largest {
        let larger = |a: (f64, usize, f64), b: (f64, usize, f64)| {
            let (value, cell) = if b.0 > a.0 { (b.0, b.1) } else { (a.0, a.1) };
            (value, cell, a.2 + b.2)
        };
        Largest { rotation: larger(self.rotation, other.rotation), strain: larger(self.strain, other.strain) }
    }
}

/// A bound of [`rotation`]: an angle is at most its tangent. The margin is for rounding.
fn rotation_bound(h: &[V3; 3]) -> f64 {
    let [x, y, z] = curl(h);
    let stretch = 2.0 + h[0][0] + h[1][1] + h[2][2];
    let bound = (1.0 + 1e-12) * (x * x + y * y + z * z).sqrt() / stretch;
    if bound >= 0.0 { bound } else { f64::INFINITY }
}

/// A bound of [`largest_principal`]: the root of the sum of the squares of all principal values.
fn strain_bound(h: &[V3; 3]) -> f64 {
    let [xx, yy, zz, xy, yz, xz] = strain_of(h);
    let squares = xx * xx + yy * yy + zz * zz + 0.5 * (xy * xy + yz * yz + xz * xz);
    if squares >= 0.0 { (1.0 + 1e-12) * squares.sqrt() } else { f64::INFINITY }
}

fn curl(h: &[V3; 3]) -> V3 {
    [h[2][1] - h[1][2], h[0][2] - h[2][0], h[1][0] - h[0][1]]
}

/// Angle of the rotation in `1 + h`, from 0 to pi.
fn rotation(h: &[V3; 3]) -> f64 {
    norm(curl(h)).atan2(2.0 + h[0][0] + h[1][1] + h[2][2])
}

/// Size of the largest principal value of the symmetric part: the roots of the characteristic polynomial by trigonometric
/// functions (Smith 1961).
fn largest_principal(h: &[V3; 3]) -> f64 {
    let [xx, yy, zz, xy, yz, xz] = strain_of(h);
    let (xy, yz, xz) = (0.5 * xy, 0.5 * yz, 0.5 * xz);
    let mean = (xx + yy + zz) / 3.0;
    let (a, b, c) = (xx - mean, yy - mean, zz - mean);
    let size = ((a * a + b * b + c * c + 2.0 * (xy * xy + yz * yz + xz * xz)) / 6.0).sqrt();
    if size == 0.0 {
        return mean.abs();
    }
    let determinant = a * (b * c - yz * yz) - xy * (xy * c - yz * xz) + xz * (xy * yz - b * xz);
    let angle = (0.5 * determinant / size.powi(3)).clamp(-1.0, 1.0).acos() / 3.0;
    let third = 2.0 * std::f64::consts::FRAC_PI_3;
    let (highest, lowest) = (mean + 2.0 * size * angle.cos(), mean + 2.0 * size * (angle + third).cos());
    highest.abs().max(lowest.abs())
}

/// The farthest slides of touching points, of each surface.
fn slide(mesh: &Mesh, surfaces: &[ContactSurface], slips: &[f64], of: &mut Smallness) {
    for (surface, &slip) in surfaces.iter().zip(slips) {
        of.slip = of.slip.max(slip);
        let size = face_size(mesh, &surface.faces);
        let size = match &surface.against {
            Counterpart::Obstacle(Obstacle::Plane { .. }) => continue,
            Counterpart::Obstacle(_) => size,
            Counterpart::Surface(master) => size.min(face_size(mesh, &master.faces)),
        };
        if slip / size > of.slip_over_face {
            (of.slip_over_face, of.slip_pair) = (slip / size, Some(surface.name.clone()));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn principal_values_of_a_rotated_diagonal_are_those_of_the_diagonal() {
        let (c, s) = (0.6, 0.8);
        // Rotated about z by atan2(4, 3), then about x by the same.
        let about_z = [[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]];
        let about_x = [[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]];
        let times = |a: [V3; 3], b: [V3; 3]| {
            [0, 1, 2].map(|i| [0, 1, 2].map(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum::<f64>()))
        };
        let r = times(about_x, about_z);
        let transposed = [0, 1, 2].map(|i| [0, 1, 2].map(|j| r[j][i]));
        for values in [[0.02, -0.05, 0.01], [0.03, 0.03, 0.03], [1e-9, 0.0, 0.0], [-2.0, 1.0, 1.0], [0.0; 3]] {
            let diagonal = [[values[0], 0.0, 0.0], [0.0, values[1], 0.0], [0.0, 0.0, values[2]]];
            let mut h = times(times(r, diagonal), transposed);
            // A rotation beside it is no strain.
            (h[0][1], h[1][0]) = (h[0][1] + 0.3, h[1][0] - 0.3);
            let wanted = values.iter().fold(0.0f64, |a, b| a.max(b.abs()));
            assert!((largest_principal(&h) - wanted).abs() <= 1e-14 * wanted.max(0.3), "{values:?}");
            // The others can make the bound at most the root of three times the value.
            let above = strain_bound(&h) / wanted;
            assert!(wanted == 0.0 || (1.0 - 1e-14..1.7321).contains(&above), "{values:?}: {above}");
            let (angle, bound) = (rotation(&h), rotation_bound(&h));
            assert!(angle <= bound && (angle > 1.5 || bound < 1.0001 * angle.tan()), "{values:?}: {angle} {bound}");
        }
    }
}
