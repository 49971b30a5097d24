//! Less energy from the same equilibrium.
//!
//! The energy of `τ - σ` is minimised over all changes of tractions that leave every cell balanced (`modes.rs`), by conjugate
//! gradients, preconditioned by the blocks of faces and edges. Any number of steps gives a valid bound, so that
//! matrices are in single precision; the tractions stay balanced to double precision.
//!
//! On closed faces the contact tractions change with the others, as far as the law of contact lets them ([`Bearing`]).

use std::collections::HashSet;

use rayon::prelude::*;

use super::contact::Bearing;
use super::equilibrate::{Given, OnFace};
use super::fill::{Map, Matrix, Sides};
use super::modes::System;
use super::tets::{CELLS_PER_TASK, Shape, Tets};
use crate::fem::Voigt;
use crate::linalg::vectorised;
use crate::mesh::v3::V3;

/// Part of the first residual at which steps end.
const SMALL: f64 = 1e-9;
/// Steps end where one gains less than this part of the energy: what is left to gain is some ten times as much, and half of that in
/// the bound. A brick of 31,104 quadratic cells takes 34, of which the last 14 take 1.2 % off the bound.
const GAIN: f64 = 1e-3;

/// Reduces `energy`, the squared distance of the stress of the tractions, by at most so many steps; `apart` answers the
/// difference of a cell's tractions from those of the stress. On `bearings` tractions stay within the law.
#[allow(clippy::too_many_arguments)] // Two fields, their cells, and what may change.
pub(super) fn sharpen(
    tets: &Tets,
    given: &Given,
    mut bearings: Vec<Bearing>,
    shapes: &[Shape],
    compliances: &[[Voigt; 6]],
    apart: &(dyn Fn(usize, &[OnFace]) -> Sides + Sync),
    tractions: &mut [OnFace],
    mut energy: f64,
    steps: usize,
) {
    let of_cell = |cell: usize| &compliances[tets.solid.material_of_cell[cell] as usize];
    let cells = tets.corners.len();
    let size = (0..cells)
        .into_par_iter()
        .with_min_len(CELLS_PER_TASK)
        .map(|cell| Map::new(&shapes[cell]).size(of_cell(cell)))
        .reduce(|| 0.0, f64::max);
    let mut matrices: Vec<Matrix> = vec![[[[0.0; 9]; 9]; 10]; cells];
    matrices.par_chunks_mut(CELLS_PER_TASK).enumerate().for_each(|(task, chunk)| {
        vectorised(
            #[inline(always)]
            || {
                for (cell, matrix) in (CELLS_PER_TASK * task..).zip(chunk.iter_mut()) {
                    Map::new(&shapes[cell]).write_matrix(of_cell(cell), 1.0 / size, matrix);
                }
            },
        );
    });
    let mut system = System::new(tets, given, &bearings, matrices);
    let start: Vec<Sides> =
        (0..cells).into_par_iter().with_min_len(CELLS_PER_TASK).map(|cell| apart(cell, tractions)).collect();
    let scale_of = start.par_iter().flatten().flatten().flatten().map(|v| v.abs()).reduce(|| 0.0, f64::max);
    if !(scale_of > 0.0 && scale_of.is_finite()) {
        return;
    }
    let single = |sides: &Sides| std::array::from_fn(|j| flat(&sides[j]).map(|v| (v / scale_of) as f32));
    let mut residual = system.gather(|cell| single(&start[cell]));
    drop(start);
    residual.par_iter_mut().for_each(|r| r.iter_mut().for_each(|v| *v = -*v));
    let mut direction: Vec<[f64; 9]> = Vec::new();
    let (mut before, mut first) = (None, 0.0);
    for _ in 0..steps {
        let corrected = system.precondition(&residual);
        let product = inner(&corrected, &residual);
        if let Some(before) = before {
            let factor: f64 = product / before;
            direction.par_iter_mut().zip(&corrected).for_each(|(d, z)| {
                (0..9).for_each(|k| d[k] = z[k] + factor * d[k]);
            });
        } else {
            direction = corrected;
        }
        first = f64::max(first, product);
        if product.is_nan() || product <= SMALL * SMALL * first {
            break;
        }
        let image = system.times(&direction);
        let curvature = inner(&direction, &image);
        if curvature.is_nan() || curvature <= 0.0 {
            break;
        }
        let whole = product / curvature;
        let reach = |bearing: &Bearing| {
            let face = bearing.face as usize;
            bearing.reach(&tractions[face], &direction[face].map(|d| scale_of * d))
        };
        let reaches: Vec<f64> = bearings.iter().map(reach).collect();
        let length = reaches.iter().copied().fold(whole, f64::min);
        residual.par_iter_mut().zip(&image).for_each(|(r, y)| (0..9).for_each(|k| r[k] -= length * y[k]));
        tractions.par_iter_mut().zip(&direction).for_each(|(t, d)| {
            (0..9).for_each(|k| t[k / 3][k % 3] += length * scale_of * d[k]);
        });
        if length < whole {
            // What is at its limit stays there, and the method begins anew.
            let ends = |(bearing, &reach): (&Bearing, &f64)| (reach < whole).then_some(bearing.face);
            let ended: HashSet<u32> = bearings.iter().zip(&reaches).filter_map(ends).collect();
            system.leave_out(&ended);
            bearings.retain(|bearing| !ended.contains(&bearing.face));
            before = None;
        } else {
            before = Some(product);
            let gain = size * scale_of * scale_of * whole * product;
            energy -= gain;
            if gain < GAIN * energy {
                break;
            }
        }
    }
}

fn flat(side: &[V3; 3]) -> [f64; 9] {
    std::array::from_fn(|k| side[k / 3][k % 3])
}

/// A scalar product in a fixed order.
fn inner(a: &[[f64; 9]], b: &[[f64; 9]]) -> f64 {
    const CHUNK: usize = 4096;
    let chunk = |(a, b): (&[[f64; 9]], &[[f64; 9]])| -> f64 {
        a.iter().zip(b).map(|(a, b)| (0..9).map(|k| a[k] * b[k]).sum::<f64>()).sum()
    };
    let parts: Vec<f64> = a.par_chunks(CHUNK).zip(b.par_chunks(CHUNK)).map(chunk).collect();
    parts.iter().sum()
}
