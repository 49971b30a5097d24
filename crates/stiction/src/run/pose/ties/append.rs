use super::eliminate::TiedPoint;
use crate::contact::{ContactProblem, Friction, Pair};
use crate::fem::DofMap;
use crate::linalg::Csr;

/// What their points are called among the pairs.
const TIES: &str = "couplings and equations";

/// Adds the points: tied, without an area, and with forces that are none between bodies.
pub(super) fn append(dofs: &DofMap, points: &[TiedPoint], problem: &mut ContactProblem) {
    let (before, more) = (problem.points(), points.len());
    let m = before + more;
    let (mut free, mut prescribed) = (Vec::new(), Vec::new());
    for (j, point) in points.iter().enumerate() {
        for (k, row) in point.rows.iter().enumerate() {
            for (&dof, &value) in row {
                let unknown = dofs.unknown[dof as usize];
                if unknown != u32::MAX {
                    free.push((k * m + before + j, unknown as usize, value));
                } else if let Ok(p) = dofs.prescribed.binary_search(&dof) {
                    prescribed.push((k * m + before + j, p, value));
                }
            }
        }
    }
    let wider = |old: &Csr, mut entries: Vec<(usize, usize, f64)>| {
        let moved = |i: usize| (i / before.max(1)) * m + i % before.max(1);
        entries.extend(old.entries().map(|(i, j, v)| (moved(i), j, v)));
        Csr::from_triplets(3 * m, old.cols, &entries)
    };
    let ContactProblem { contact, labels, .. } = problem;
    contact.B = wider(&contact.B, free);
    let held = match &mut labels.supports {
        Some(supports) => {
            supports.B = wider(&supports.B, prescribed);
            supports.B.times(&supports.displacement)
        }
        None => vec![0.0; 3 * m],
    };
    // As posed, the sums are zero.
    let at = |k: usize| (0..more).map(|j| 0.0 - held[k * m + before + j]).collect::<Vec<f64>>();
    contact.gap.extend(at(0));
    let second = contact.slip_reference.split_off(before);
    contact.slip_reference.extend(at(1));
    contact.slip_reference.extend(second);
    contact.slip_reference.extend(at(2));
    contact.friction.resize(m, Friction::Bonded);
    if let Some(orthotropy) = &mut contact.orthotropy {
        orthotropy.resize(m, 1.0);
    }
    labels.area.resize(m, 0.0);
    labels.unity_sum.resize(m, 0.0);
    labels.pairs.push(Pair { name: TIES.into(), points: before..m });
}
