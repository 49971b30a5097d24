//! The problem of some of the points alone.

use super::{Contact, ContactProblem, Labels, Pair, Supports};
use crate::linalg::Csr;

impl ContactProblem {
    /// The problem of these points alone, ascending.
    pub(crate) fn of_points(&self, points: &[u32]) -> ContactProblem {
        let (contact, labels) = self.contact_of_points(points);
        let supports = self
            .labels
            .supports
            .as_ref()
            .map(|supports| Supports { B: self.rows_of_points(&supports.B, points), ..supports.clone() });
        let labels = Labels { supports, bodies: self.labels.bodies.clone(), ..labels };
        ContactProblem { elastic: self.elastic.clone(), contact, labels }
    }

    /// Contact at these points alone, ascending, and their labels without supports and bodies.
    pub(crate) fn contact_of_points(&self, points: &[u32]) -> (Contact, Labels) {
        let ContactProblem { contact, labels, .. } = self;
        let at = |list: &[f64]| -> Vec<f64> { points.iter().map(|&j| list[j as usize]).collect() };
        let all = self.points();
        let of = Contact {
            B: self.rows_of_points(&contact.B, points),
            gap: at(&contact.gap),
            slip_reference: [at(&contact.slip_reference[..all]), at(&contact.slip_reference[all..])].concat(),
            friction: points.iter().map(|&j| contact.friction[j as usize]).collect(),
            orthotropy: contact.orthotropy.as_ref().map(|ratios| at(ratios)),
            rounding: contact.rounding,
            out: (0..).zip(points).filter(|(_, j)| contact.out.binary_search(j).is_ok()).map(|(k, _)| k).collect(),
        };
        let before = |j: usize| points.partition_point(|&k| (k as usize) < j);
        let pair =
            |pair: &Pair| Pair { name: pair.name.clone(), points: before(pair.points.start)..before(pair.points.end) };
        let labels = Labels {
            area: at(&labels.area),
            unity_sum: at(&labels.unity_sum),
            pairs: labels.pairs.iter().map(pair).collect(),
            supports: None,
            bodies: None,
        };
        (of, labels)
    }

    fn rows_of_points(&self, all: &Csr, points: &[u32]) -> Csr {
        let m = points.len();
        let mut rows = Vec::new();
        for (place, &j) in points.iter().enumerate() {
            for (r, i) in self.rows(j as usize).into_iter().enumerate() {
                let (columns, values) = all.row(i);
                rows.extend(columns.iter().zip(values).map(|(&c, &v)| (r * m + place, c as usize, v)));
            }
        }
        Csr::from_triplets(3 * m, all.cols, &rows)
    }

    /// The multipliers of all points, `3m`, from those of these; zero at the others.
    pub(crate) fn of_all_points(&self, points: &[u32], lambda: &[f64]) -> Vec<f64> {
        let mut all = vec![0.0; 3 * self.points()];
        for (place, &j) in points.iter().enumerate() {
            self.rows(j as usize).into_iter().enumerate().for_each(|(r, i)| all[i] = lambda[r * points.len() + place]);
        }
        all
    }
}
