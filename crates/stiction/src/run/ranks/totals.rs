//! Forces, counts and areas of contact over all ranks.

use super::local::Local;
use super::solve::axes;
use super::tractions::{RankTractions, shear};
use crate::friction::{Multigrid, PointState, Solution};
use crate::mesh::v3::{add, norm, scale};
use crate::ranks::{Wire, gather_all, max, sum, to_bytes};
use crate::run::solve::Totals;
use crate::run::solve::tractions::Traction;

/// Sums over the points of this rank, of one surface or of all.
fn of_rank(
    local: &Local,
    own: &[u32],
    solution: &Solution,
    tractions: &[Traction],
    surface: Option<usize>,
) -> (Totals, [f64; 4]) {
    let (labels, m) = (&local.problem.labels, own.len());
    let range = match surface {
        Some(k) => labels.pairs[k].points.clone(),
        None => 0..local.timed.contact_points(),
    };
    let of_contacts = own.iter().enumerate().filter(|(_, j)| range.contains(&(**j as usize)));
    let mut t = Totals { points: of_contacts.clone().count(), ..Totals::default() };
    let mut most = [0.0, f64::NAN, f64::NAN, f64::NAN];
    for (place, &j) in of_contacts {
        let (area, share) = (labels.area[j as usize], labels.unity_sum[j as usize]);
        let (count, sum) = match solution.states[place] {
            PointState::Open => (&mut t.open, &mut t.open_area),
            PointState::Stick => (&mut t.stick, &mut t.stick_area),
            PointState::Slip => (&mut t.slip, &mut t.slip_area),
        };
        *count += 1;
        *sum += area * share;
        let [normal, first, second] = [0, 1, 2].map(|r| solution.lambda[r * m + place]);
        t.normal_force += share * normal;
        let (node, [_, t1, t2]) = axes(local, j as usize);
        let along = add(scale(first, t1), scale(second, t2));
        let sign = local.signs[local.pair_of(j as usize)];
        (0..3).for_each(|c| t.tangential_force[c] -= sign * share * along[c]);
        t.max_lambda_n = t.max_lambda_n.max(normal);
        t.max_lambda_t = t.max_lambda_t.max(first.hypot(second));
        let traction = tractions[j as usize];
        t.max_shear = t.max_shear.max(norm(shear(traction)));
        if traction[0] > most[0] {
            let [x, y, z] = local.piece.mesh.nodes[node as usize];
            most = [traction[0], x, y, z];
        }
    }
    (t, most)
}

/// The totals of all ranks, over all surfaces and of each with its name.
pub(super) fn totals(
    local: &Local,
    multigrid: &Multigrid,
    solution: &Solution,
    tractions: &RankTractions,
) -> (Totals, Vec<(String, Totals)>) {
    let of = |surface| of_ranks(local, multigrid, solution, tractions, surface);
    let pairs = local.problem.labels.pairs.iter().take(local.signs.len()).enumerate();
    (of(None), pairs.map(|(k, pair)| (pair.name.clone(), of(Some(k)))).collect())
}

fn of_ranks(
    local: &Local,
    multigrid: &Multigrid,
    solution: &Solution,
    tractions: &RankTractions,
    surface: Option<usize>,
) -> Totals {
    let ranks = &*local.division.ranks;
    let (t, most) = of_rank(local, multigrid.own_points(), solution, &tractions.points, surface);
    let other = &tractions.max_other_pressure;
    let max_other_pressure = match surface {
        Some(k) => other.get(k).copied().unwrap_or(0.0),
        None => other.iter().fold(0.0, |most: f64, pressure| most.max(*pressure)),
    };
    let [x, y, z] = t.tangential_force;
    let counts = [t.points, t.open, t.stick, t.slip].map(|count| count as f64);
    let mut sums = [counts.as_slice(), &[t.open_area, t.stick_area, t.slip_area, t.normal_force, x, y, z]].concat();
    sum(ranks, &mut sums);
    let mut largest = [t.max_lambda_n, t.max_lambda_t, t.max_shear];
    max(ranks, &mut largest);
    let all = gather_all(ranks, to_bytes(&most));
    let places = all.iter().map(|bytes| Wire::read(bytes));
    let first: [f64; 4] = places.fold([0.0; 4], |best, next: [f64; 4]| if next[0] > best[0] { next } else { best });
    let [pressure, at @ ..] = first;
    Totals {
        points: sums[0] as usize,
        open: sums[1] as usize,
        stick: sums[2] as usize,
        slip: sums[3] as usize,
        open_area: sums[4],
        stick_area: sums[5],
        slip_area: sums[6],
        normal_force: sums[7],
        tangential_force: [sums[8], sums[9], sums[10]],
        max_lambda_n: largest[0],
        max_lambda_t: largest[1],
        max_pressure: pressure,
        max_pressure_at: (pressure > 0.0).then_some(at),
        max_shear: largest[2],
        max_other_pressure,
    }
}
