//! Straight facets of curved parts made round.
//!
//! Meshes of linear cells have facets where the part is curved. Surfaces of second degree through the corners around each one, up to
//! sharp edges, tell its normal (Cazals & Pouget, "Estimating differential quantities using polynomial fitting of osculating jets", Comput.
//! Aided Geom. Des. 22 (2005) 121); the middle of each boundary edge is moved to where a parabola lies that is
//! tangent to the planes at both ends (Nagata, "Simple local interpolation of surfaces using normal vectors", Comput.
//! Aided Geom. Des. 22 (2005) 327, without the part that normals across the edge would add). Six nodes express his whole
//! patch.

use rayon::prelude::*;

use super::bisect::Bisection;
use super::facets::{BORDER, corner_normals, normal};
use super::inherit::edge;
use super::quality::quality;
use super::v3::{V3, add, dot, norm, scale, sub, unit};
use super::{CellKind, Mesh};

/// What became of the edges of a boundary.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Rounded {
    /// Edges whose middles were moved.
    pub moved: usize,
    /// Edges that stay straight though the surface is curved there: cells would be folded or become too flat, or the
    /// surfaces on both sides do not say where the edge runs.
    pub straight: usize,
    /// The largest distance by which a middle was moved; length.
    pub most: f64,
}

/// A cell may lose this part of its quality.
const LOST: f64 = 0.7;

/// Less than this part of the distance between its ends is no bulge.
const FLAT: f64 = 1e-9;

/// The square of the sine of the angle between two surfaces that still tell where their edge runs.
const ACROSS: f64 = 0.05;

/// Times that normals at the ends of a smooth part of the surface are made to agree with their neighbours.
const SWEEPS: usize = 20;

/// Fits of a surface to the corners around one; each takes the normal of the one before as its axis.
const FITS: usize = 2;

/// What curvatures count in a fit beside what is fitted: so little that it shows only where the corners do not tell them, as on a strip
/// of one row of facets.
const RIDGE: f64 = 1e-9;

/// A pivot that is a smaller part of its diagonal entry is rounding: the corners lie on a line.
const PIVOT: f64 = 1e-12;

/// Moves the middles of straight boundary edges to the surface that the facets stand for; edges at which the boundary
/// bends by more than `feature_angle`, in degrees, part one smooth surface from another. Cells are quadratic, made of
/// linear ones and not refined yet; on linear cells nothing is done.
pub fn round_facets(at: &mut Bisection, feature_angle: f64) -> Rounded {
    let mut found = Rounded::default();
    if at.mesh.cells.iter().any(|block| block.kind != CellKind::Tet10) {
        return found;
    }
    let mut places = places(&at.mesh, feature_angle);
    found.straight = places.iter().filter(|place| place.1.is_none()).count();
    let mut moved: Vec<(u32, V3)> = places.drain(..).filter_map(|(node, to)| Some((node, to?))).collect();
    moved.sort_unstable_by_key(|moved| moved.0);
    let straight: Vec<V3> = moved.iter().map(|&(node, _)| at.mesh.nodes[node as usize]).collect();
    moved.iter().for_each(|&(node, to)| at.mesh.nodes[node as usize] = to);
    // Where a cell suffers all its edges are straight again, which may in turn leave a neighbour worse than it was.
    loop {
        let mut back = vec![false; moved.len()];
        for (kind, cell) in at.mesh.cell_iter() {
            let own = || cell[4..].iter().filter_map(|node| moved.binary_search_by_key(node, |moved| moved.0).ok());
            let bent = |place: usize| at.mesh.nodes[moved[place].0 as usize] != straight[place];
            if own().any(bent) {
                let now = quality(&at.mesh.nodes, kind, cell);
                let before = quality(&at.mesh.nodes, CellKind::Tet4, cell);
                if now.is_nan() || now < (1.0 - LOST) * before {
                    own().filter(|&place| bent(place)).for_each(|place| back[place] = true);
                }
            }
        }
        if !back.contains(&true) {
            break;
        }
        for place in (0..moved.len()).filter(|&place| back[place]) {
            at.mesh.nodes[moved[place].0 as usize] = straight[place];
            found.straight += 1;
        }
    }
    let way = |(place, &(node, _)): (usize, &(u32, V3))| norm(sub(at.mesh.nodes[node as usize], straight[place]));
    let ways: Vec<f64> = moved.iter().enumerate().map(way).filter(|&way| way > 0.0).collect();
    Rounded { moved: ways.len(), most: ways.into_iter().fold(0.0, f64::max), ..found }
}

/// The middles of the edges where the boundary is curved, and where they belong; none where that is not known.
fn places(mesh: &Mesh, feature_angle: f64) -> Vec<(u32, Option<V3>)> {
    let corners = |face: &super::Face| [0, 1, 2].map(|i| face.corners()[i]);
    let triangles: Vec<[u32; 3]> = mesh.faces.iter().map(corners).collect();
    // The triangle on the other side of each edge, where there is exactly one.
    let mut sides: Vec<([u32; 2], u32, u32)> = Vec::with_capacity(3 * triangles.len());
    for (t, corners) in (0..).zip(&triangles) {
        sides.extend((0..3).map(|k| (edge(corners[k], corners[(k + 1) % 3]), t, k as u32)));
    }
    sides.sort_unstable();
    let bends = feature_angle.to_radians().cos();
    let normals: Vec<V3> = triangles.iter().map(|&corners| normal(&mesh.nodes, corners)).collect();
    let mut across = vec![[BORDER; 3]; triangles.len()];
    let mut sharp = vec![[true; 3]; triangles.len()];
    for side in sides.chunk_by(|a, b| a.0 == b.0) {
        let [(_, t, i), (_, u, j)] = *side else { continue };
        across[t as usize][i as usize] = u;
        across[u as usize][j as usize] = t;
        let is_sharp = dot(normals[t as usize], normals[u as usize]) < bends;
        sharp[t as usize][i as usize] = is_sharp;
        sharp[u as usize][j as usize] = is_sharp;
    }
    let (corner, mut smooth) = corner_normals(&mesh.nodes, &triangles, &across, &sharp);
    let is_end = ends(&sharp, &corner, smooth.len());
    fit(&mesh.nodes, (&triangles, &normals), &corner, &is_end, &mut smooth);
    agree(mesh, &triangles, &corner, &is_end, &mut smooth);
    let mut places = Vec::new();
    for side in sides.chunk_by(|a, b| a.0 == b.0) {
        let (ends, t, k) = side[0];
        let middle = mesh.faces[t as usize].nodes()[3 + k as usize];
        let [a, b] = ends.map(|node| mesh.nodes[node as usize]);
        let chord = sub(b, a);
        // That of a cell which was curved from the beginning, beside linear ones.
        let bulge = sub(mesh.nodes[middle as usize], add(a, scale(0.5, chord)));
        if norm(bulge) > FLAT * norm(chord) {
            continue;
        }
        let of = |&(_, t, _): &([u32; 2], u32, u32)| {
            let n = ends.map(|end| {
                let k = triangles[t as usize].iter().position(|&node| node == end).unwrap_or(0);
                smooth[corner[t as usize][k] as usize]
            });
            parabola(chord, n)
        };
        let heights: Vec<(V3, f64)> = side.iter().map(of).collect();
        if heights.iter().all(|(_, height)| height.abs() <= FLAT * norm(chord)) {
            continue;
        }
        let to = match heights[..] {
            [(n, height), (m, other)] if sharp[t as usize][k as usize] => {
                // The least way to both surfaces.
                let c = dot(n, m);
                let square = 1.0 - c * c;
                let [x, y] = [height - c * other, other - c * height].map(|s| s / square);
                (square > ACROSS).then(|| add(scale(x, n), scale(y, m)))
            }
            [(n, height), _] => Some(scale(height, n)),
            _ => None,
        };
        places.push((middle, to.map(|to| add(mesh.nodes[middle as usize], to))));
    }
    places
}

/// The mean normal of two planes at the ends of a chord, and the height of the parabola over it in the middle.
fn parabola(chord: V3, [n, m]: [V3; 2]) -> (V3, f64) {
    let sum = add(n, m);
    let length = norm(sum);
    if length == 0.0 {
        return (n, 0.0);
    }
    (scale(1.0 / length, sum), -0.25 * (dot(n, chord) - dot(m, chord)) / length)
}

/// Which normals are at the ends of smooth surfaces.
fn ends(sharp: &[[bool; 3]], corner: &[[u32; 3]], count: usize) -> Vec<bool> {
    let mut is_end = vec![false; count];
    for (t, sharp) in sharp.iter().enumerate() {
        for k in (0..3).filter(|&k| sharp[k]) {
            [k, (k + 1) % 3].iter().for_each(|&k| is_end[corner[t][k] as usize] = true);
        }
    }
    is_end
}

/// At the ends of smooth surfaces the facets lie on one side and their mean normal leans to it. Second degree surfaces have
/// normals at the ends of each chord that lean against it by as much: so they are turned there, as nearly as can be.
fn agree(mesh: &Mesh, triangles: &[[u32; 3]], corner: &[[u32; 3]], is_end: &[bool], smooth: &mut [V3]) {
    // The chords from each such end: the place of the normal, of the other normal, the chord.
    let mut chords: Vec<(u32, u32, V3)> = Vec::new();
    for (corners, places) in triangles.iter().zip(corner) {
        for (i, j) in (0..3).flat_map(|i| [(i, (i + 1) % 3), (i, (i + 2) % 3)]) {
            if is_end[places[i] as usize] {
                let [a, b] = [corners[i], corners[j]].map(|node| mesh.nodes[node as usize]);
                let chord = sub(b, a);
                chords.push((places[i], places[j], scale(1.0 / norm(chord), chord)));
            }
        }
    }
    chords.sort_by_key(|chord| (chord.0, chord.1));
    for _ in 0..SWEEPS {
        for of in chords.chunk_by(|a, b| a.0 == b.0) {
            let n = smooth[of[0].0 as usize];
            // Least squares in the plane across the normal.
            let [e, f] = super::v3::across(n);
            let (mut m, mut r) = ([0.0; 3], [0.0; 2]);
            for &(_, other, chord) in of {
                let (x, y) = (dot(e, chord), dot(f, chord));
                let off = -dot(add(n, smooth[other as usize]), chord);
                m = [m[0] + x * x, m[1] + x * y, m[2] + y * y];
                r = [r[0] + x * off, r[1] + y * off];
            }
            let det = m[0] * m[2] - m[1] * m[1];
            if det <= ACROSS * (m[0] + m[2]).powi(2) / 4.0 {
                continue;
            }
            let turned =
                add(n, add(scale((m[2] * r[0] - m[1] * r[1]) / det, e), scale((m[0] * r[1] - m[1] * r[0]) / det, f)));
            smooth[of[0].0 as usize] = scale(1.0 / norm(turned), turned);
        }
    }
}

/// Turns the mean normals of facets, which lean to where there are more or larger ones, to those of surfaces of second degree through the
/// corners around: two rings of them, none beyond a sharp edge. At the ends of smooth surfaces they lie on one side, and tell less than the
/// normals around do.
fn fit(
    points: &[V3],
    (triangles, normals): (&[[u32; 3]], &[V3]),
    corner: &[[u32; 3]],
    is_end: &[bool],
    smooth: &mut [V3],
) {
    let mut around: Vec<Vec<u32>> = vec![Vec::new(); smooth.len()];
    for (t, places) in (0..).zip(corner) {
        places.iter().for_each(|&place| around[place as usize].push(t));
    }
    let fitted = |place: usize| -> V3 {
        let mean = smooth[place];
        if is_end[place] {
            return mean;
        }
        let of_place = |t: u32| corner[t as usize].iter().position(|&other| other as usize == place);
        let Some(own) = around[place].first().and_then(|&t| Some(triangles[t as usize][of_place(t)?])) else {
            return mean;
        };
        let first = around[place].iter().flat_map(|&t| corner[t as usize]);
        let facets: Vec<u32> = first.flat_map(|place| &around[place as usize]).copied().collect();
        let mut near: Vec<u32> = facets.iter().flat_map(|&t| triangles[t as usize]).collect();
        near.sort_unstable();
        near.dedup();
        let at = points[own as usize];
        let ways: Vec<V3> = near.iter().filter(|&&v| v != own).map(|&v| sub(points[v as usize], at)).collect();
        let steepest = facets.iter().map(|&t| dot(mean, normals[t as usize])).fold(1.0, f64::min);
        let axis = (0..FITS).try_fold(mean, |axis, _| normal_of_second_degree(&ways, axis));
        // No farther from the mean than the facets are.
        axis.filter(|&axis| dot(axis, mean) >= steepest).unwrap_or(mean)
    };
    let all: Vec<V3> = (0..smooth.len()).into_par_iter().map(fitted).collect();
    smooth.copy_from_slice(&all);
}

/// The normal at the origin of the surface of second degree over the plane across `axis` that is nearest to these points, near ones more
/// than far ones; `None` where they tell none.
fn normal_of_second_degree(points: &[V3], axis: V3) -> Option<V3> {
    let [e, f] = super::v3::across(axis);
    let size = points.iter().map(|&p| norm(p)).fold(0.0, f64::max);
    let (mut rows, mut right) = ([[0.0; 5]; 5], [0.0; 5]);
    for &p in points {
        let [x, y, z] = [dot(e, p), dot(f, p), dot(axis, p)].map(|c| c / size);
        let r = x * x + y * y;
        if r.is_nan() || r == 0.0 {
            return None;
        }
        let (terms, weight) = ([x, y, x * x, x * y, y * y], 1.0 / (r * r * r * r));
        for i in 0..5 {
            (0..5).for_each(|j| rows[i][j] += weight * terms[i] * terms[j]);
            right[i] += weight * terms[i] * z;
        }
    }
    let ridge = RIDGE * (0..5).map(|i| rows[i][i]).sum::<f64>();
    (2..5).for_each(|i| rows[i][i] += ridge);
    let slopes = solved(rows, right)?;
    unit(sub(axis, add(scale(slopes[0], e), scale(slopes[1], f))))
}

/// The solution of positive definite equations by elimination; `None` where rounding alone makes them so.
fn solved(mut rows: [[f64; 5]; 5], mut right: [f64; 5]) -> Option<[f64; 5]> {
    let least: [f64; 5] = std::array::from_fn(|k| PIVOT * rows[k][k]);
    for k in 0..5 {
        let (pivot, of_pivot) = (rows[k], right[k]);
        if pivot[k].is_nan() || pivot[k] <= least[k] {
            return None;
        }
        for i in k + 1..5 {
            let factor = rows[i][k] / pivot[k];
            (k..5).for_each(|j| rows[i][j] -= factor * pivot[j]);
            right[i] -= factor * of_pivot;
        }
    }
    for k in (0..5).rev() {
        let known: f64 = (k + 1..5).map(|j| rows[k][j] * right[j]).sum();
        right[k] = (right[k] - known) / rows[k][k];
    }
    Some(right)
}

#[cfg(test)]
mod tests {
    use super::super::{BlockElement, Order, Ring, block, quality, refine, ring, tetrahedra};
    use super::*;

    fn bent(around: usize, element: BlockElement) -> Mesh {
        let cells = [1 + around / 4, around, around / 3];
        ring(&Ring { radii: [1.0, 2.0], height: 1.0, degrees: 120.0, cells, grading: [1.0; 3], element }).unwrap()
    }

    /// The largest of `off` over the nodes of a group.
    fn most(mesh: &Mesh, group: &str, off: impl Fn(V3) -> f64) -> f64 {
        let nodes = mesh.group_nodes(mesh.group(group).unwrap());
        nodes.iter().map(|&node| off(mesh.nodes[node as usize]).abs()).fold(0.0, f64::max)
    }

    #[test]
    fn facets_of_a_tube_become_round_up_to_its_ends_and_its_planes_stay() {
        for element in [BlockElement::Tet4Six, BlockElement::Tet4Five { parity: 0 }, BlockElement::Hex8] {
            let mut before = None;
            for around in [6, 12, 24] {
                let mut at = tetrahedra(&bent(around, element), Order::Quadratic).unwrap();
                let [facets, exact] = [at.mesh.volume(), std::f64::consts::PI];
                let rounded = round_facets(&mut at, 30.0);
                assert!(rounded.moved > 0 && rounded.straight == 0, "{rounded:?}");
                let height = 1.0 - (60f64.to_radians() / around as f64).cos();
                assert!((rounded.most / (2.0 * height) - 1.0).abs() < 0.05, "{rounded:?}");
                // The facets lie off the cylinder by their height, of second order; what is left is of fourth.
                let radial = |r: f64| move |[x, y, _]: V3| x.hypot(y) - r;
                let off = most(&at.mesh, "inner", radial(1.0)).max(most(&at.mesh, "outer", radial(2.0)) / 2.0);
                assert!(off < 0.03 * height, "{element:?} {around}: {off} of {height}");
                let volumes = [facets, at.mesh.volume()].map(|volume| (volume / exact - 1.0).abs());
                assert!(volumes[1] < 0.01 * volumes[0], "{element:?} {around}: {volumes:?}");
                if let Some(before) = before.replace(volumes[1]) {
                    assert!(volumes[1] < before / 10.0, "{element:?} {around}: {} {before}", volumes[1]);
                }
                assert!(
                    most(&at.mesh, "start", |[_, y, _]| y) < 1e-15
                        && most(&at.mesh, "z-max", |[_, _, z]| z - 1.0) == 0.0
                );
                // The patches stay when they are refined.
                let refined = refine(&at, &(0..40).collect::<Vec<u32>>(), 2).unwrap().next.mesh;
                assert!((refined.volume() / at.mesh.volume() - 1.0).abs() < 1e-12);
                // Where the angle between facets makes an edge, nothing is round.
                let mut sharp = tetrahedra(&bent(around, element), Order::Quadratic).unwrap();
                assert_eq!(round_facets(&mut sharp, 100.0 / around as f64), Rounded::default());
            }
        }
    }

    /// A part of a ball about the origin with its pole at the corner of two planes through the axis, nodes of the ball moved along it by
    /// chance: how far the middles of edges are off it, over the height of the facets.
    fn off_a_ball(cells: usize) -> f64 {
        let patch = super::super::Block {
            size: [0.6, 0.6, 1.0],
            cells: [cells, cells, 4],
            origin: [0.0; 3],
            grading: [1.0; 3],
            element: BlockElement::Tet4Six,
        };
        let mut mesh = block(&patch).unwrap();
        let step = 0.35 * 0.6 / cells as f64;
        for (number, x) in mesh.nodes.iter_mut().enumerate() {
            let along = |c: usize| {
                let chance = ((2 * number + c) as f64 * 12.9898).sin() * 43758.5453;
                if x[c] == 0.0 || x[c] > 0.599 { x[c] } else { x[c] + step * chance.fract() }
            };
            let way = [along(0), along(1), 1.0];
            *x = scale((1.0 + x[2]) / norm(way), way);
        }
        let mut at = tetrahedra(&mesh, Order::Quadratic).unwrap();
        let rounded = round_facets(&mut at, 30.0);
        assert!(rounded.moved > 0 && rounded.straight == 0, "{rounded:?}");
        let [outer, inner] = [("z-max", 2.0), ("z-min", 1.0)].map(|(group, r)| most(&at.mesh, group, |x| norm(x) - r));
        outer.max(inner) / rounded.most
    }

    #[test]
    fn facets_of_a_ball_become_round_to_the_planes_of_symmetry_at_its_pole() {
        let off = [4, 8, 16].map(off_a_ball);
        assert!(off[0] < 0.01 && off[2] < off[0] / 2.0, "{off:?}");
    }

    #[test]
    fn edges_stay_straight_where_cells_would_suffer() {
        // A thin layer in a sharply bent ring: its inner faces would bulge through the outer.
        let thin = Ring {
            radii: [1.0, 1.02],
            height: 1.0,
            degrees: 90.0,
            cells: [4, 3, 1],
            grading: [1.0; 3],
            element: BlockElement::Tet4Six,
        };
        let mut at = tetrahedra(&ring(&thin).unwrap(), Order::Quadratic).unwrap();
        let least = |mesh: &Mesh| {
            let each = mesh.cell_iter().map(|(kind, cell)| quality(&mesh.nodes, kind, cell));
            each.fold(f64::INFINITY, f64::min)
        };
        let before = least(&at.mesh);
        let rounded = round_facets(&mut at, 40.0);
        assert!(rounded.straight > 0, "{rounded:?}");
        assert!(least(&at.mesh) >= (1.0 - LOST) * before);
        let element = BlockElement::Hex8;
        let plane = super::super::Block { size: [1.0; 3], cells: [2; 3], origin: [0.0; 3], grading: [2.0; 3], element };
        let mut at = tetrahedra(&block(&plane).unwrap(), Order::Quadratic).unwrap();
        assert_eq!(round_facets(&mut at, 30.0), Rounded::default());
        let mut linear = tetrahedra(&ring(&thin).unwrap(), Order::Linear).unwrap();
        assert_eq!(round_facets(&mut linear, 40.0), Rounded::default());
    }
}
