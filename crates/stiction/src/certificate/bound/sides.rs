//! Continuity across faces, boundary values and contact.

use std::collections::HashMap;

use super::super::scales::ROUNDING;
use super::cells::places;
use super::vectors::{V3, basis, cross, dot, length, minus, numbers, ratio, traction, unit};
use super::{BoundFields, BoundSide, ENDS, FlatObstacle, Touch, Worst, damaged};
use crate::Error;

/// Points and weights that integrate polynomials of fifth degree over a triangle of area one (Radon 1948).
pub(super) const RADON: [([f64; 3], f64); 7] = {
    const A: f64 = 0.101_286_507_323_456_34;
    const B: f64 = 0.470_142_064_105_115_1;
    const OF_A: f64 = 0.125_939_180_544_827_15;
    const OF_B: f64 = 0.132_394_152_788_506_2;
    [
        ([1.0 / 3.0; 3], 0.225),
        ([A, A, 1.0 - 2.0 * A], OF_A),
        ([A, 1.0 - 2.0 * A, A], OF_A),
        ([1.0 - 2.0 * A, A, A], OF_A),
        ([B, B, 1.0 - 2.0 * B], OF_B),
        ([B, 1.0 - 2.0 * B, B], OF_B),
        ([1.0 - 2.0 * B, B, B], OF_B),
    ]
};

/// `∫ p g`, `∫ (s |w| - q·w)` and `∫ s |w|` for openings `g`, slips `w`, pressures `p`, shears `q` and their limits `s`.
#[derive(Default)]
pub(super) struct Contact {
    pub(super) normal: f64,
    pub(super) slip: f64,
    pub(super) limits: f64,
}

/// A boundary face as its cell sees it: area, and of each corner, ascending, its number and the traction on it.
pub(super) struct Outside {
    pub(super) area: f64,
    cell: usize,
    at: [(u32, V3); 3],
}

/// Continuity across the faces; what is left are boundary faces, by their nodes in ascending order.
pub(super) fn judge_faces(
    fields: &BoundFields,
    size: f64,
    worst: &mut Worst,
) -> Result<HashMap<[u32; 3], Outside>, Error> {
    let mut open: HashMap<[u32; 3], Outside> = HashMap::new();
    let mut met: HashMap<[u32; 3], usize> = HashMap::new();
    for (cell, corners) in fields.corners.iter().enumerate() {
        let x = places(fields, cell);
        for j in 0..4 {
            let mut others = [0, 1, 2, 3].into_iter().filter(|&a| a != j);
            let mut own = [(); 3].map(|()| others.next().unwrap_or(0));
            own.sort_unstable_by_key(|&a| corners[a]);
            let across = cross(minus(x[own[1]], x[own[0]]), minus(x[own[2]], x[own[0]]));
            let outward = if dot(across, minus(x[own[0]], x[j])) < 0.0 { across.map(|n| -n) } else { across };
            let normal = unit(outward);
            // In part j corner a stands in its own place.
            let at = own.map(|a| (corners[a], traction(&fields.stress[cell][j][a], normal)));
            let key = own.map(|a| corners[a]);
            let Some(other) = open.remove(&key) else {
                if met.insert(key, cell).is_some() {
                    return Err(damaged(format!("more than two cells have the face {}", numbers(key))));
                }
                open.insert(key, Outside { area: 0.5 * length(outward), cell, at });
                continue;
            };
            for ((_, t), (_, other)) in at.iter().zip(&other.at) {
                let sum: V3 = std::array::from_fn(|c| t[c] + other[c]);
                let place = || format!("the face between cells {} and {}", met[&key] + 1, cell + 1);
                worst.see("continuity across faces", ratio(length(sum), size), place);
            }
        }
    }
    Ok(open)
}

/// Boundary values of a face and its part of the contact terms; the work of its load.
pub(super) fn judge_side(
    fields: &BoundFields,
    side: &BoundSide,
    own: &Outside,
    size: f64,
    most: f64,
    worst: &mut Worst,
    contact: &mut Contact,
) -> f64 {
    let here = || format!("the boundary face with the nodes {}", numbers(side.corners));
    let nodes = side_nodes(fields, side, own);
    let u = |of: &[f64], node: u32| -> V3 { std::array::from_fn(|c| of[3 * node as usize + c]) };
    let held = basis(&side.held);
    for &node in nodes.iter().flatten() {
        let moved = minus(u(&fields.displacement, node), u(&fields.found, node));
        let off = held.iter().map(|&d| dot(d, moved).abs()).fold(0.0, f64::max);
        worst.see("prescribed displacements", ratio(off, most), here);
    }
    let touches = || side.touches.iter().map(|touch| (touch, &fields.obstacles[touch.obstacle as usize]));
    for (a, &node) in side.corners.iter().enumerate() {
        let found = own.at.iter().find(|(other, _)| *other == node).map_or([f64::NAN; 3], |at| at.1);
        let mut rest = minus(found, side.load[a]);
        for (touch, obstacle) in touches() {
            (0..3).for_each(|c| rest[c] += touch.pressure[a] * obstacle.normal[c] + touch.shear[a][c]);
        }
        for d in &held {
            let along = dot(*d, rest);
            (0..3).for_each(|c| rest[c] -= along * d[c]);
        }
        worst.see("tractions given on the boundary", ratio(length(rest), size), here);
    }
    for (touch, obstacle) in touches() {
        judge_touch(fields, touch, obstacle, &nodes, own.area, [size, most], worst, contact, &here);
    }
    let value = |w: V3| -> f64 {
        let load: V3 = std::array::from_fn(|c| (0..3).map(|a| w[a] * side.load[a][c]).sum());
        let moved = quadratic(w, &nodes.map(|node| node.map_or([f64::NAN; 3], |node| u(&fields.displacement, node))));
        dot(load, moved)
    };
    if side.load == [[0.0; 3]; 3] { 0.0 } else { own.area * integral(value) }
}

/// The corners of a side and the middles of the edges across from them; none in linear cells.
pub(super) fn side_nodes(fields: &BoundFields, side: &BoundSide, own: &Outside) -> [Option<u32>; 6] {
    let corners = fields.corners[own.cell];
    let place = |node: u32| corners.iter().position(|&corner| corner == node);
    let middle = |a: usize| {
        let ends = [side.corners[(a + 1) % 3], side.corners[(a + 2) % 3]].map(place);
        let edge = ENDS.iter().position(|&[p, q]| ends == [Some(p), Some(q)] || ends == [Some(q), Some(p)])?;
        fields.middles.get(own.cell).map(|middles| middles[edge])
    };
    let [a, b, c] = side.corners;
    [Some(a), Some(b), Some(c), middle(0), middle(1), middle(2)]
}

#[allow(clippy::too_many_arguments)] // One face, with all that it is held against.
fn judge_touch(
    fields: &BoundFields,
    touch: &Touch,
    obstacle: &FlatObstacle,
    nodes: &[Option<u32>; 6],
    area: f64,
    [size, most]: [f64; 2],
    worst: &mut Worst,
    contact: &mut Contact,
    here: &dyn Fn() -> String,
) {
    let normal = obstacle.normal;
    worst.see("normals of obstacles", (length(normal) - 1.0).abs(), here);
    let of_corner = |a: usize| match touch.law[a] {
        [coefficient, largest] if coefficient.is_finite() => largest.min(coefficient * touch.pressure[a]),
        [_, largest] => largest,
    };
    let limits = [0, 1, 2].map(of_corner);
    for ((limit, shear), pressure) in limits.into_iter().zip(touch.shear).zip(touch.pressure) {
        worst.see("pressure without tension", ratio(-pressure, size).max(0.0), here);
        worst.see("shears within the limit of friction", ratio(length(shear) - limit, size).max(0.0), here);
        worst.see("shears along the surface", ratio(dot(shear, normal).abs(), size), here);
    }
    for (k, &node) in nodes.iter().enumerate() {
        let Some(node) = node else { continue };
        let (x, i) = (fields.nodes[node as usize], 3 * node as usize);
        let u: V3 = std::array::from_fn(|c| fields.displacement[i + c]);
        // Coordinates round openings; that much they may differ.
        let rounding = 100.0 * ROUNDING * (length(x) + obstacle.offset.abs());
        let opening = obstacle.offset - dot(normal, x) - dot(normal, u);
        let off = ((opening - touch.opening[k]).abs() - rounding).max(0.0);
        worst.see("openings", ratio(off, most), here);
        if limits != [0.0; 3] {
            let slip = minus(u, touch.reference[k]);
            let along = dot(slip, normal);
            let slip: V3 = std::array::from_fn(|c| slip[c] - along * normal[c] - touch.slip[k][c]);
            worst.see("slips", ratio((length(slip) - rounding).max(0.0), most), here);
        }
    }
    // Of a polynomial that is no less than zero no coefficient need be, but coefficients that are not make one.
    let is_linear = nodes[3].is_none();
    let opening = coefficients(touch.opening.map(|opening| [opening, 0.0, 0.0]), is_linear);
    let slip = coefficients(touch.slip, is_linear);
    let inside = opening.iter().fold(0.0, |m: f64, g| m.max(-g[0]));
    worst.see("nodes out of the obstacle", ratio(inside, most), here);
    // The length of a sum is no more than the sum of lengths.
    let lengths = match is_linear {
        true => coefficients(touch.slip.map(|slip| [length(slip), 0.0, 0.0]), true),
        false => slip.map(|slip| [length(slip), 0.0, 0.0]),
    };
    let linear = |w: V3, of: [f64; 3]| (0..3).map(|a| w[a] * of[a]).sum::<f64>();
    let shear = |w: V3| -> V3 { std::array::from_fn(|c| (0..3).map(|a| w[a] * touch.shear[a][c]).sum()) };
    let limited = |w: V3| linear(w, limits) * bernstein(w, &lengths)[0];
    contact.normal += area * integral(|w| linear(w, touch.pressure) * bernstein(w, &opening)[0]);
    contact.slip += area * integral(|w| limited(w) - dot(shear(w), bernstein(w, &slip)));
    contact.limits += area * integral(limited);
}

/// Bernstein coefficients of a quadratic from its values at corners and middles.
fn coefficients(values: [V3; 6], is_linear: bool) -> [V3; 6] {
    std::array::from_fn(|k| match k.checked_sub(3) {
        None => values[k],
        Some(a) => std::array::from_fn(|c| {
            let ends = 0.5 * (values[(a + 1) % 3][c] + values[(a + 2) % 3][c]);
            if is_linear { ends } else { 2.0 * values[k][c] - ends }
        }),
    })
}

fn bernstein(w: V3, of: &[V3; 6]) -> V3 {
    let weight = |k: usize| if k < 3 { w[k] * w[k] } else { 2.0 * w[(k - 2) % 3] * w[(k - 1) % 3] };
    std::array::from_fn(|c| (0..6).map(|k| weight(k) * of[k][c]).sum())
}

/// A displacement between its values at corners and middles; linear where these are no numbers.
fn quadratic(w: V3, values: &[V3; 6]) -> V3 {
    bernstein(w, &coefficients(*values, values[3][0].is_nan()))
}

/// Over a triangle of area one.
fn integral(of: impl Fn(V3) -> f64) -> f64 {
    RADON.iter().map(|&(w, weight)| weight * of(w)).sum()
}
