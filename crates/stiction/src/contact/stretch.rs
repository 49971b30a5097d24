//! Statics of weak friction: resultants that friction alone can take up, on a scale of their own.
//!
//! Friction of 1e-8 under a weight of one holds 1e-8, and a projection on the admissible forces ends there: what is out of balance is a
//! rounding of the weight. A linear map of the space of resultants changes no answer to whether there are forces in balance. The
//! motions of a body along all of its contact, in which no point moves along its normal, are stretched until friction there is as large
//! as the normal forces.

use super::Friction;
use super::equilibrium::Bearing;
use super::rigid::RigidMotions;
use crate::linalg::{Csr, dot, norm, symmetric_eigen};

/// Friction this part of the normal forces is told from none without help.
const STRONG: f64 = 1e-4;
/// Friction below this part of the loads is as small as what rounding leaves of them.
const LEAST: f64 = 1e-11;
/// Loads along the contact below this part of the sizes that make them up are rounding.
const ROUNDING: f64 = 1e-13;
/// Motions in which normals move by less than the root of this are along the contact.
const ALONG: f64 = 1e-14;

/// `1 + (factor - 1) P` for some bodies, with the projection `P` on motions along the contact.
pub(super) struct Stretch {
    count: usize,
    /// The factor less one, and an orthonormal motion.
    along: Vec<(f64, Vec<f64>)>,
}

impl Stretch {
    /// Of bodies whose friction is weak and on which a load acts along the contact; `None` where there are none.
    pub(super) fn of_weak_friction(
        bearing: &Bearing,
        motions: &RigidMotions,
        (load, terms): (&[f64], f64),
    ) -> Option<Stretch> {
        let (size, noise) = (norm(load), ROUNDING * terms);
        let mut stretch = Stretch { count: load.len(), along: Vec::new() };
        let mut first = 0;
        for body in &motions.bodies {
            let (begin, own) = (first, body.motions.len());
            first += own;
            let of = |row: usize| -> Vec<f64> {
                let mut jump = vec![0.0; own];
                let here = bearing.jumps.entries_of(row).filter(|(k, _)| (begin..begin + own).contains(&(*k as usize)));
                here.for_each(|(k, value)| jump[k as usize - begin] = value);
                jump
            };
            let (mut gram, mut grip) = (vec![vec![0.0; own]; own], 0.0f64);
            for (j, rows) in bearing.points() {
                let rows = rows.map(of);
                if rows.iter().all(|row| row.iter().all(|&x| x == 0.0)) {
                    continue;
                }
                let law = &bearing.friction[j];
                grip = grip.max(if *law == Friction::Bonded { f64::INFINITY } else { law.bound(size) / size });
                let normal = &rows[0];
                (0..own).for_each(|a| (0..own).for_each(|b| gram[a][b] += normal[a] * normal[b]));
            }
            if !(LEAST..STRONG).contains(&grip) {
                continue;
            }
            let (values, vectors) = symmetric_eigen(&gram);
            let largest = values.iter().fold(0.0, |most: f64, &value| most.max(value));
            let along = values.iter().zip(vectors).filter(|(value, _)| **value <= ALONG * largest).map(|(_, v)| v);
            let along: Vec<Vec<f64>> = along.collect();
            let pushed = along.iter().map(|v| dot(v, &load[begin..begin + own]).powi(2)).sum::<f64>().sqrt();
            if pushed <= noise {
                continue;
            }
            for v in along {
                let mut whole = vec![0.0; load.len()];
                whole[begin..begin + own].copy_from_slice(&v);
                stretch.along.push((1.0 / grip - 1.0, whole));
            }
        }
        (!stretch.along.is_empty()).then_some(stretch)
    }

    /// Of a resultant, or of a motion: the map is symmetric.
    pub(super) fn times(&self, x: &[f64]) -> Vec<f64> {
        let mut y = x.to_vec();
        for (more, v) in &self.along {
            let part = more * dot(v, x);
            y.iter_mut().zip(v).for_each(|(y, v)| *y += part * v);
        }
        y
    }

    /// Of the resultant of each row.
    pub(super) fn rows(&self, jumps: &Csr) -> Csr {
        let mut entries = Vec::new();
        for i in 0..jumps.rows {
            let mut row = vec![0.0; self.count];
            jumps.entries_of(i).for_each(|(k, value)| row[k as usize] = value);
            if row.iter().any(|&x| x != 0.0) {
                let filled = self.times(&row).into_iter().enumerate().filter(|(_, value)| *value != 0.0);
                entries.extend(filled.map(|(k, value)| (i, k, value)));
            }
        }
        Csr::from_triplets(jumps.rows, self.count, &entries)
    }
}
