//! What contact across a distance that nothing closes does to the balance of moments.

use crate::contact::{ContactProblem, ContactSurface, Counterpart, InitialGap, Pair, Supports, SurfaceFriction};
use crate::mesh::v3::{V3, add, norm, sub};
use crate::run::pose::Prepared;

/// Couples below this part of what the forces of their pair have about its centre are not worth a word: so much do forces have that
/// act at either side of a play, or across flat faces that stand for curved ones.
const SMALL: f64 = 0.01;

/// Forces below this part of what elements exert at a support before it cancels are what is left of the iteration: a body that is
/// turned without load has no others.
const NONE: f64 = 1e-8;

/// A pair whose forces on the two bodies cancel while their moments do not: its surfaces lie apart, as tied or with a gap that the
/// case calls closed, and shear acts at either.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Couple {
    pub pair: String,
    /// What is left of the moments, newton times length.
    pub moment: V3,
    /// Its size over the sum of the sizes of the moments that the forces at the points have about the centre of the pair.
    pub part: f64,
}

/// The contact forces of a problem, or of the part of one that a rank counts.
pub(crate) struct Forces<'a> {
    pub problem: &'a ContactProblem,
    /// Displacements of the unknowns, length, and contact forces, newton.
    pub u: &'a [f64],
    pub lambda: &'a [f64],
    /// Where point `j` is, length.
    pub place: &'a dyn Fn(usize) -> V3,
    /// Whether a point, and a prescribed displacement, counts here.
    pub counts: [&'a dyn Fn(usize) -> bool; 2],
    /// Sums and maxima over all ranks.
    pub sum: &'a dyn Fn(&mut [f64]),
    pub max: &'a dyn Fn(&mut [f64]),
}

/// Pairs that leave a couple which counts; `u` are the displacements of the unknowns, `lambda` the contact forces.
pub(crate) fn couples(prepared: &Prepared, u: &[f64], lambda: &[f64]) -> Vec<Couple> {
    let nodes: Vec<u32> = prepared.facts.contacts.iter().flat_map(|it| it.surface.nodes.iter().copied()).collect();
    let all = |_| true;
    let forces = Forces {
        problem: &prepared.problem,
        u,
        lambda,
        place: &|j| prepared.mesh.nodes[nodes[j] as usize],
        counts: [&all, &all],
        sum: &|_| {},
        max: &|_| {},
    };
    let lie_apart: Vec<bool> = prepared.surfaces.iter().map(may_lie_apart).collect();
    forces.couples(&lie_apart)
}

/// Whether the surfaces of a contact may lie apart while they carry force.
pub(crate) fn may_lie_apart(surface: &ContactSurface) -> bool {
    let Counterpart::Surface(master) = &surface.against else { return false };
    surface.friction == SurfaceFriction::Bonded || master.gap != InitialGap::AsMeshed
}

impl Forces<'_> {
    /// Pairs that leave a couple which counts, of those that [`may_lie_apart`].
    pub(crate) fn couples(&self, lie_apart: &[bool]) -> Vec<Couple> {
        let problem = self.problem;
        let supports = problem.labels.supports.as_ref();
        let at_supports = |supports: &Supports| {
            let of_row = |p: usize| supports.K.entries_of(p).map(|(i, k)| (k * self.u[i as usize]).abs()).sum::<f64>();
            (0..supports.K.rows).filter(|&p| (self.counts[1])(p)).map(of_row).fold(0.0, f64::max)
        };
        let mut most = [supports.map_or(-1.0, at_supports)];
        (self.max)(&mut most);
        // Where nothing is held nothing tells what is left of the iteration.
        if most[0] < 0.0 {
            return Vec::new();
        }
        let pairs = problem.labels.pairs.iter().zip(lie_apart).filter(|(_, apart)| **apart);
        pairs.filter_map(|(pair, _)| self.couple(pair, NONE * most[0])).collect()
    }

    fn couple(&self, pair: &Pair, least: f64) -> Option<Couple> {
        let points = || pair.points.clone().filter(|&j| (self.counts[0])(j));
        let [x, y, z] = points().map(self.place).fold([0.0; 3], add);
        let mut sums = [x, y, z, points().count() as f64];
        (self.sum)(&mut sums);
        let centre = [0, 1, 2].map(|c| sums[c] / sums[3].max(1.0));
        let size = |j: usize| norm(self.problem.rows(j).map(|i| self.lambda[i]));
        let [x, y, z] = points().map(|j| self.moment(j)).fold([0.0; 3], add);
        let mut sums = [x, y, z, points().map(|j| size(j) * norm(sub((self.place)(j), centre))).sum()];
        (self.sum)(&mut sums);
        let mut largest = [points().map(size).fold(0.0, f64::max)];
        (self.max)(&mut largest);
        let moment = [sums[0], sums[1], sums[2]];
        let part = norm(moment) / sums[3];
        (part > SMALL && largest[0] > least).then(|| Couple { pair: pair.name.clone(), moment, part })
    }

    /// That of the forces of a point on both bodies.
    fn moment(&self, j: usize) -> V3 {
        let labels = &self.problem.labels;
        let (mut moment, motions) = ([0.0; 3], self.problem.elastic.near_kernel.as_deref().unwrap_or_default());
        let mut add_motion = |motion: &[f64; 6], force: f64| (0..3).for_each(|c| moment[c] += motion[3 + c] * force);
        for i in self.problem.rows(j) {
            let (columns, values) = self.problem.contact.B.row(i);
            let free = columns.iter().zip(values).filter_map(|(&k, b)| Some((motions.get(k as usize)?, *b)));
            free.for_each(|(motion, b)| add_motion(motion, b * self.lambda[i]));
            if let Some(supports) = &labels.supports {
                let (columns, values) = supports.B.row(i);
                let held = columns.iter().zip(values);
                held.for_each(|(&k, b)| add_motion(&supports.rigid[k as usize], b * self.lambda[i]));
            }
        }
        moment
    }
}
