//! Balance and continuity inside a cell, and its energies.

use super::vectors::{Tensor, V3, cross, dot, length, minus, ratio, times, traction, unit};
use super::{BoundFields, ENDS, Energies, Worst, damaged};
use crate::Error;

/// The corners of a cell and its centroid, number 4.
pub(super) fn places(fields: &BoundFields, cell: usize) -> [V3; 5] {
    let x = fields.corners[cell].map(|node| fields.nodes[node as usize]);
    let centroid = std::array::from_fn(|c| 0.25 * x.iter().map(|x| x[c]).sum::<f64>());
    [x[0], x[1], x[2], x[3], centroid]
}

/// The numbers of the corners of part `j` among these.
pub(super) fn of_part(j: usize) -> [usize; 4] {
    std::array::from_fn(|a| if a == j { 4 } else { a })
}

/// Six times the volume with its sign, and the gradients of the functions that are one at a corner.
pub(super) fn gradients(x: [V3; 4]) -> (f64, [V3; 4]) {
    let [a, b, c] = [1, 2, 3].map(|i| minus(x[i], x[0]));
    let across = [cross(b, c), cross(c, a), cross(a, b)];
    let six = dot(a, across[0]);
    let [g1, g2, g3] = across.map(|n| n.map(|n| n / six));
    (six, [std::array::from_fn(|c| -g1[c] - g2[c] - g3[c]), g1, g2, g3])
}

/// Balance and continuity inside a cell, and its energies.
pub(super) fn judge_cell(
    fields: &BoundFields,
    factors: &[Factor],
    cell: usize,
    size: f64,
    worst: &mut Worst,
) -> Result<Energies, Error> {
    let x = places(fields, cell);
    let (six, of_cell) = gradients([x[0], x[1], x[2], x[3]]);
    if !(six.abs() > 0.0 && six.is_finite()) {
        return Err(damaged(format!("cell {} has no volume", cell + 1)));
    }
    let (volume, here) = (six.abs() / 6.0, || format!("cell {}", cell + 1));
    for (&[a, b], &middle) in ENDS.iter().zip(fields.middles.get(cell).into_iter().flatten()) {
        let middle = fields.nodes[middle as usize];
        let off: V3 = std::array::from_fn(|c| middle[c] - 0.5 * (x[a][c] + x[b][c]));
        // Edges may bend by 1e-8 of their length.
        worst.see("straight edges", ratio(length(off), 10.0 * length(minus(x[b], x[a]))), here);
    }
    let force = fields.body_force.get(cell).copied().unwrap_or([0.0; 3]);
    let part = |j: usize| &fields.stress[cell][j];
    for j in 0..4 {
        let (_, gradient) = gradients(of_part(j).map(|i| x[i]));
        let mut rest = force;
        for (stress, gradient) in part(j).iter().zip(gradient) {
            let own = traction(stress, gradient);
            (0..3).for_each(|c| rest[c] += own[c]);
        }
        worst.see("balance of the cells", ratio(length(rest) * volume.cbrt(), size), here);
        for l in j + 1..4 {
            let shared: Vec<usize> = (0..5).filter(|&i| i != j && i != l).collect();
            let normal = unit(cross(minus(x[shared[1]], x[shared[0]]), minus(x[shared[2]], x[shared[0]])));
            for i in shared {
                let at = |part: usize| of_part(part).iter().position(|&own| own == i).unwrap_or(0);
                let jump = minus(traction(&part(j)[at(j)], normal), traction(&part(l)[at(l)], normal));
                worst.see("continuity inside the cells", ratio(length(jump), size), here);
            }
        }
    }
    let at_corner = stress_at_corners(fields, &fields.displacement, cell, &of_cell);
    let centre: Tensor = std::array::from_fn(|k| 0.25 * at_corner.iter().map(|s| s[k]).sum::<f64>());
    let found = [at_corner[0], at_corner[1], at_corner[2], at_corner[3], centre];
    let factor = &factors[fields.material[cell] as usize];
    let mut energies = Energies::default();
    for j in 0..4 {
        let own = of_part(j).map(|i| found[i]);
        let of = |combine: &dyn Fn(f64, f64) -> f64| {
            let values = std::array::from_fn(|a| std::array::from_fn(|k| combine(part(j)[a][k], own[a][k])));
            factor.energy(&values, 0.25 * volume)
        };
        energies.add(&Energies {
            apart: of(&|balanced, found| balanced - found),
            found: of(&|_, found| found),
            balanced: of(&|balanced, _| balanced),
            mean: of(&|balanced, found| 0.5 * (balanced + found)),
            work: 0.0,
        });
    }
    energies.work = volume * dot(force, mean_displacement(fields, cell));
    Ok(energies)
}

/// Stress of displacements at the corners of a cell.
pub(super) fn stress_at_corners(
    fields: &BoundFields,
    displacement: &[f64],
    cell: usize,
    gradient: &[V3; 4],
) -> [Tensor; 4] {
    let u = |node: u32| -> V3 { std::array::from_fn(|c| displacement[3 * node as usize + c]) };
    let corners = fields.corners[cell];
    let middles = fields.middles.get(cell);
    let slopes: Vec<(V3, [V3; 4])> = corners
        .iter()
        .chain(middles.into_iter().flatten())
        .enumerate()
        .map(|(k, &node)| (u(node), at_corners(k, middles.is_some(), gradient)))
        .collect();
    let stiffness = &fields.stiffness[fields.material[cell] as usize];
    let free = fields.initial.get(cell).copied().unwrap_or([0.0; 6]);
    std::array::from_fn(|corner| {
        // Displacements less that of the corner itself: a translation has no strain, whatever its digits.
        let own = u(corners[corner]);
        let mut slope = [[0.0; 3]; 3];
        for (u, gradients) in &slopes {
            let g = gradients[corner];
            (0..3).for_each(|i| (0..3).for_each(|j| slope[i][j] += (u[i] - own[i]) * g[j]));
        }
        let e = |i: usize, j: usize| slope[i][j] + slope[j][i];
        let strain = [slope[0][0], slope[1][1], slope[2][2], e(0, 1), e(1, 2), e(0, 2)];
        times(stiffness, std::array::from_fn(|k| strain[k] - free[k]))
    })
}

/// Gradients at the corners of the function of node `k`: corners, then middles.
pub(super) fn at_corners(k: usize, is_quadratic: bool, gradient: &[V3; 4]) -> [V3; 4] {
    let scaled = |g: V3, factor: f64| g.map(|g| factor * g);
    std::array::from_fn(|corner| match (is_quadratic, k.checked_sub(4)) {
        (false, _) => gradient[k],
        // Of `l (2 l - 1)`.
        (true, None) => scaled(gradient[k], if k == corner { 3.0 } else { -1.0 }),
        // Of `4 l l'`.
        (true, Some(edge)) => match ENDS[edge] {
            [a, b] if a == corner => scaled(gradient[b], 4.0),
            [a, b] if b == corner => scaled(gradient[a], 4.0),
            _ => [0.0; 3],
        },
    })
}

pub(super) fn mean_displacement(fields: &BoundFields, cell: usize) -> V3 {
    let u = |node: u32, c: usize| fields.displacement[3 * node as usize + c];
    std::array::from_fn(|c| {
        let corners: f64 = fields.corners[cell].iter().map(|&node| u(node, c)).sum();
        match fields.middles.get(cell) {
            None => 0.25 * corners,
            Some(middles) => 0.2 * middles.iter().map(|&node| u(node, c)).sum::<f64>() - 0.05 * corners,
        }
    })
}

/// The Cholesky factor of a stiffness.
pub(super) struct Factor([[f64; 6]; 6]);

impl Factor {
    /// `∫ σ C⁻¹ σ` of a stress that is linear between the corners of a tetrahedron.
    fn energy(&self, at: &[Tensor; 4], volume: f64) -> f64 {
        let total = std::array::from_fn(|k| at.iter().map(|s| s[k]).sum());
        volume / 20.0 * (at.iter().map(|s| self.square(s)).sum::<f64>() + self.square(&total))
    }

    fn square(&self, s: &Tensor) -> f64 {
        let mut y = [0.0; 6];
        for i in 0..6 {
            let known: f64 = (0..i).map(|k| self.0[i][k] * y[k]).sum();
            y[i] = (s[i] - known) / self.0[i][i];
        }
        y.iter().map(|y| y * y).sum()
    }
}

pub(super) fn factorised(stiffness: &[[f64; 6]; 6], material: usize) -> Result<Factor, Error> {
    let mut l = [[0.0; 6]; 6];
    for i in 0..6 {
        for j in 0..=i {
            let rest = stiffness[i][j] - (0..j).map(|k| l[i][k] * l[j][k]).sum::<f64>();
            l[i][j] = if i == j { rest.sqrt() } else { rest / l[j][j] };
        }
    }
    if l.as_flattened().iter().all(|value| value.is_finite()) && (0..6).all(|i| l[i][i] > 0.0) {
        return Ok(Factor(l));
    }
    Err(damaged(format!("the stiffness of material {} is not positive definite", material + 1)))
}
