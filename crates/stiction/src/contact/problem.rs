use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;
use rustc_hash::FxHashSet;

use super::Friction;
use crate::Error;
use crate::linalg::{Csr, SymmetricCsr};

/// Points of one contact pair, for reports.
#[derive(Debug, Clone, PartialEq)]
pub struct Pair {
    /// Its name in reports.
    pub name: String,
    /// Its points.
    pub points: Range<usize>,
}

/// A body of the mesh, for reports.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Its name in reports.
    pub name: String,
    /// Mean of its nodes, and the largest distance of one from it; length.
    pub centre: [f64; 3],
    /// Largest distance of a node from the centre, length.
    pub radius: f64,
}

/// Which body is where; a body is what hangs together without contact.
#[derive(Debug, Clone, PartialEq)]
pub struct Bodies {
    /// All bodies; numbers below are places in this list.
    pub list: Vec<Body>,
    /// The body of each unknown, `n`.
    pub of: Vec<u32>,
    /// The body of each prescribed displacement, `p`.
    pub of_support: Vec<u32>,
    /// The point about which the rotations of the near-kernel turn, length.
    pub origin: [f64; 3],
}

/// The prescribed part of the body, for reactions and the balance of forces; `p` prescribed displacements.
#[derive(Debug, Clone, PartialEq)]
pub struct Supports {
    /// Rows of the stiffness matrix at the prescribed degrees of freedom, `p x n`.
    pub K: Csr,
    /// Their columns among themselves, `p x p`.
    pub K_own: Csr,
    /// External forces at the prescribed degrees of freedom, newton, length `p`.
    pub load: Vec<f64>,
    /// External forces at the `n` unknowns, without what the prescribed displacements demand.
    pub free_load: Vec<f64>,
    /// Prescribed displacements, length `p`.
    pub displacement: Vec<f64>,
    /// The part of the jump operator at the prescribed degrees of freedom, `3m x p`.
    pub B: Csr,
    /// The six rigid motions at the prescribed degrees of freedom.
    pub rigid: Vec<[f64; 6]>,
    /// What springs to the ground contribute to the stiffness, over the unknowns and then the prescribed displacements,
    /// `n + p` square: their force on the body is `-springs [u; displacement]`.
    pub springs: Option<Csr>,
}

impl Supports {
    /// Forces of the springs on the body at the unknowns and then the prescribed displacements, newton, length `n + p`;
    /// empty without springs.
    pub fn spring_forces(&self, u: &[f64]) -> Vec<f64> {
        let Some(springs) = &self.springs else { return Vec::new() };
        let all: Vec<f64> = u.iter().chain(&self.displacement).copied().collect();
        springs.times(&all).into_iter().map(|force| 0.0 - force).collect()
    }
}

/// Elastic contact with friction as matrices: left of it nobody knows how it will be solved, right of it nobody
/// knows a mesh. `m` contact points, `n` unknown displacements.
///
/// ```text
/// K u = f - Bᵀ lambda,   B = [N; T1; T2],   lambda = [lambda_n; lambda_t1; lambda_t2]
/// N u <= gap,  lambda_n >= 0,  lambda_n (gap - N u) = 0
/// |lambda_t| <= bound,  slip s = T u - slip_reference,  s != 0  =>  lambda_t = bound s / |s|
/// ```
/// Where a point has a tensile strength `t`, `lambda_n + t` stands for `lambda_n` in the second line.
///
/// Where friction differs by direction (`orthotropy`, `a` for short) the disc is an ellipse and the slip is along
/// its normal:
///
/// ```text
/// |(lambda_t1, lambda_t2 / a)| <= bound,  s != 0  =>  lambda_t = bound (s_1, a² s_2) / |(s_1, a s_2)|
/// ```
/// A row of `B` may be empty: a tangential direction in which the point cannot move. Its multiplier is zero.
#[derive(Debug, Clone, PartialEq)]
pub struct ContactProblem {
    /// The bodies: stiffness and load.
    pub elastic: Elastic,
    /// Where and how they touch.
    pub contact: Contact,
    /// What reports and the certificate need; solvers read the ranges of the pairs alone.
    pub labels: Labels,
}

/// The elastic bodies as a linear system, `n` unknown displacements.
#[derive(Debug, Clone, PartialEq)]
pub struct Elastic {
    /// Stiffness, `n x n`, symmetric. Positive definite; with a near-kernel, positive
    /// semidefinite with no other null space than rigid motions of its connected components. Problems that differ in loads
    /// or laws share it.
    pub K: Arc<SymmetricCsr>,
    /// Load, newton, length `n`.
    pub f: Vec<f64>,
    /// The node each unknown belongs to (any labels); unknowns of one node are ordered together.
    pub node_of: Option<Vec<u32>>,
    /// Near-kernel of `K`: the six rigid motions from coordinates, one row an unknown.
    pub near_kernel: Option<Vec<[f64; 6]>>,
    /// Of quadratic elements the nodes in the middle of edges, each with the two ends of its edge: labels of `node_of`. An
    /// end without unknowns is prescribed. Multigrid then begins with the functions that are linear on the edges.
    pub middles: Option<Vec<[u32; 3]>>,
}

/// The contact conditions at `m` points.
#[derive(Debug, Clone, PartialEq)]
pub struct Contact {
    /// Jump operator, `3m x n`: normal rows, then first, then second tangential ones. Any sparse matrix.
    pub B: Csr,
    /// Initial gap along the normal, length, `m`; negative where the bodies overlap.
    pub gap: Vec<f64>,
    /// `T u` from which slip is measured (the last load step), length, `2m`.
    pub slip_reference: Vec<f64>,
    /// The law at each point, `m`.
    pub friction: Vec<Friction>,
    /// The orthotropy ratio: friction along the second tangent over that along the first, `m`, in [0, 1], whatever the
    /// law; `None` is one everywhere. Along the first tangent friction is the larger.
    pub orthotropy: Option<Vec<f64>>,
    /// What the rounding of the data leaves open in gaps and slips, length: larger than the rounding of the numbers here
    /// where they are differences of far larger ones.
    pub rounding: f64,
    /// Points that take no part now, ascending: their gaps are wider than anything moves, and none of them can balance a load.
    pub out: Vec<u32>,
}

/// Names, areas and supports, for reports, moving obstacles and the balance of forces.
#[derive(Debug, Clone, PartialEq)]
pub struct Labels {
    /// The area each point stands for, `m`, length squared.
    pub area: Vec<f64>,
    /// What the force of each point is to be multiplied with to add up to the whole force, `m`: one, more where a point
    /// between two bodies carries for a neighbour that was dropped, less in the middle of the edge of a quadratic face;
    /// what a translation of the counterpart does to the gap of the point.
    pub unity_sum: Vec<f64>,
    /// Consecutive ranges that cover all points.
    pub pairs: Vec<Pair>,
    /// The prescribed part of the bodies.
    pub supports: Option<Supports>,
    /// Names and places of the bodies, for messages and for the balance of each.
    pub bodies: Option<Bodies>,
}

impl ContactProblem {
    /// A problem from bare matrices: one pair, unit areas, slip measured from zero.
    pub fn from_matrices(
        K: impl Into<Arc<SymmetricCsr>>,
        f: Vec<f64>,
        B: Csr,
        gap: Vec<f64>,
        friction: Vec<Friction>,
    ) -> Self {
        let m = gap.len();
        ContactProblem {
            elastic: Elastic { K: K.into(), f, node_of: None, near_kernel: None, middles: None },
            contact: Contact {
                B,
                gap,
                slip_reference: vec![0.0; 2 * m],
                friction,
                orthotropy: None,
                rounding: 0.0,
                out: Vec::new(),
            },
            labels: Labels {
                area: vec![1.0; m],
                unity_sum: vec![1.0; m],
                pairs: vec![Pair { name: "contact".into(), points: 0..m }],
                supports: None,
                bodies: None,
            },
        }
    }

    /// Number of contact points `m`.
    pub fn points(&self) -> usize {
        self.contact.gap.len()
    }

    fn springs(&self) -> Option<&Csr> {
        self.labels.supports.as_ref()?.springs.as_ref()
    }

    /// Number of unknown displacements `n`.
    pub fn unknowns(&self) -> usize {
        self.elastic.f.len()
    }

    /// The three multipliers of point `j`: normal, first and second tangential.
    pub fn rows(&self, j: usize) -> [usize; 3] {
        let m = self.points();
        [j, m + j, 2 * m + j]
    }

    /// The law's quantities `[gap - N u; slip_reference - T u]`, length `3m`: the gap and minus the slip.
    pub fn gap_and_slip(&self, u: &[f64]) -> Vec<f64> {
        let m = self.points();
        let jump = self.contact.B.times(u);
        let offset = self.contact.gap.iter().chain(&self.contact.slip_reference);
        jump.iter().zip(offset).take(3 * m).map(|(j, o)| o - j).collect()
    }

    /// Checks every length, index and value once; the solvers trust a problem that passed.
    ///
    /// # Errors
    /// The first thing that is wrong, by the name of its field.
    pub fn validate(&self) -> Result<(), Error> {
        self.check_lengths()?;
        self.check_elastic()?;
        self.contact.check()?;
        self.check_labels()?;
        self.check_held_points()
    }

    fn check_lengths(&self) -> Result<(), Error> {
        let (m, n) = (self.points(), self.unknowns());
        let Contact { B, slip_reference, friction, orthotropy, .. } = &self.contact;
        let Labels { area, unity_sum, supports, bodies, .. } = &self.labels;
        let p = supports.as_ref().map_or(0, |s| s.load.len());
        let supports = supports.as_ref();
        let of_supports = |length: &dyn Fn(&Supports) -> usize, wanted: usize| supports.map_or(wanted, length);
        let springs = self.springs();
        let lengths = [
            ("rows of elastic.K", self.elastic.K.rows, n),
            ("elastic.node_of", self.elastic.node_of.as_ref().map_or(n, Vec::len), n),
            ("elastic.near_kernel", self.elastic.near_kernel.as_ref().map_or(n, Vec::len), n),
            ("rows of contact.B", B.rows, 3 * m),
            ("columns of contact.B", B.cols, n),
            ("contact.slip_reference", slip_reference.len(), 2 * m),
            ("contact.friction", friction.len(), m),
            ("contact.orthotropy", orthotropy.as_ref().map_or(m, Vec::len), m),
            ("labels.area", area.len(), m),
            ("labels.unity_sum", unity_sum.len(), m),
            ("labels.bodies.of", bodies.as_ref().map_or(n, |b| b.of.len()), n),
            ("labels.bodies.of_support", bodies.as_ref().map_or(p, |b| b.of_support.len()), p),
            ("rows of labels.supports.K", of_supports(&|s| s.K.rows, p), p),
            ("columns of labels.supports.K", of_supports(&|s| s.K.cols, n), n),
            ("rows of labels.supports.K_own", of_supports(&|s| s.K_own.rows, p), p),
            ("columns of labels.supports.K_own", of_supports(&|s| s.K_own.cols, p), p),
            ("rows of labels.supports.B", of_supports(&|s| s.B.rows, 3 * m), 3 * m),
            ("columns of labels.supports.B", of_supports(&|s| s.B.cols, p), p),
            ("labels.supports.free_load", of_supports(&|s| s.free_load.len(), n), n),
            ("labels.supports.displacement", of_supports(&|s| s.displacement.len(), p), p),
            ("labels.supports.rigid", of_supports(&|s| s.rigid.len(), p), p),
            ("rows of labels.supports.springs", springs.map_or(n + p, |s| s.rows), n + p),
            ("columns of labels.supports.springs", springs.map_or(n + p, |s| s.cols), n + p),
        ];
        match lengths.into_iter().find(|(_, found, wanted)| found != wanted) {
            Some((name, found, wanted)) => {
                let remedy = "give K (n x n), f (n), B (3m x n), gap (m), slip_reference (2m), friction (m), area (m)";
                Err(wrong(format!("{name}: {found} where {wanted} are needed"), remedy))
            }
            None => Ok(()),
        }
    }

    fn check_elastic(&self) -> Result<(), Error> {
        let Elastic { K, f, node_of, near_kernel, middles } = &self.elastic;
        K.validate("elastic.K")?;
        if let Some(i) = (0..K.rows).into_par_iter().with_min_len(4096).find_first(|&i| K.diagonal(i) <= 0.0) {
            let what = format!("elastic.K has the diagonal entry {} at unknown {i}", K.diagonal(i));
            return Err(wrong(what, "give a stiffness: every unknown needs one"));
        }
        finite("elastic.f", f)?;
        let motions = near_kernel.iter().flatten();
        if let Some(i) = motions.clone().position(|row| row.iter().any(|x| !x.is_finite())) {
            return Err(wrong(format!("elastic.near_kernel[{i}] is not finite"), "give finite numbers"));
        }
        if let Some(middles) = middles {
            check_middles(middles, node_of.is_some())?;
        }
        match node_of.as_deref().and_then(scattered_node) {
            Some(node) => {
                let what = format!("elastic.node_of: the unknowns of node {node} do not follow one another");
                Err(wrong(what, "order the unknowns node by node"))
            }
            None => Ok(()),
        }
    }

    /// A point no unknown of which moves along its normal keeps its gap: where that is an overlap, nothing closes it.
    fn check_held_points(&self) -> Result<(), Error> {
        let Contact { B, gap, slip_reference, friction, .. } = &self.contact;
        let stays = |j: usize| friction[j] != Friction::Bonded && B.row(j).1.iter().all(|&entry| entry == 0.0);
        let Some(j) = (0..gap.len()).filter(|&j| gap[j] < 0.0 && stays(j)).min_by(|&a, &b| gap[a].total_cmp(&gap[b]))
        else {
            return Ok(());
        };
        let (K, f) = (&self.elastic.K, &self.elastic.f);
        let prescribed = self.labels.supports.iter().flat_map(|supports| &supports.displacement);
        let lengths = gap.iter().chain(slip_reference).chain(prescribed).copied();
        let length = lengths.chain(f.iter().enumerate().map(|(i, f)| f / K.diagonal(i)));
        if -gap[j] <= self.contact.rounding.max(HELD * length.fold(0.0, |most: f64, l| most.max(l.abs()))) {
            return Ok(());
        }
        let what = format!("contact.gap[{j}]: contact point {j} is held and overlaps by {}", Error::number(-gap[j]));
        let remedy =
            "no displacement parts it: give it a gap of at least 0, leave it out of the contact, or free its unknowns";
        Err(wrong(what, remedy))
    }

    fn check_labels(&self) -> Result<(), Error> {
        let m = self.points();
        let Labels { area, unity_sum, pairs, supports, bodies } = &self.labels;
        let next = pairs.iter().try_fold(0, |end, pair| (pair.points.start == end).then_some(pair.points.end));
        if next != Some(m) {
            let what = format!("labels.pairs: their ranges do not cover the {m} points one after the other");
            return Err(wrong(what, "give consecutive ranges from 0 to m"));
        }
        finite("labels.area", area)?;
        finite("labels.unity_sum", unity_sum)?;
        if let Some(supports) = supports {
            supports.K.validate("labels.supports.K")?;
            supports.K_own.validate("labels.supports.K_own")?;
            supports.B.validate("labels.supports.B")?;
            supports.springs.as_ref().map_or(Ok(()), |springs| springs.validate("labels.supports.springs"))?;
            finite("labels.supports.load", &supports.load)?;
            finite("labels.supports.free_load", &supports.free_load)?;
            finite("labels.supports.displacement", &supports.displacement)?;
            finite("labels.supports.rigid", supports.rigid.as_flattened())?;
        }
        if let Some(bodies) = bodies {
            let places: Vec<f64> = bodies.list.iter().flat_map(|b| b.centre.into_iter().chain([b.radius])).collect();
            finite("centres and radii of labels.bodies", &places)?;
            finite("labels.bodies.origin", &bodies.origin)?;
            let known = bodies.list.len() as u32;
            if let Some(number) = bodies.of.iter().chain(&bodies.of_support).find(|&&number| number >= known) {
                let what = format!("labels.bodies: there is no body {number} among {known}");
                return Err(wrong(what, "number the bodies from zero"));
            }
        }
        Ok(())
    }
}

impl Contact {
    fn check(&self) -> Result<(), Error> {
        self.B.validate("contact.B")?;
        finite("contact.gap", &self.gap)?;
        finite("contact.slip_reference", &self.slip_reference)?;
        if !(self.rounding >= 0.0 && self.rounding.is_finite()) {
            return Err(wrong(format!("contact.rounding is {}", self.rounding), "give a length, zero if unsure"));
        }
        for (j, law) in self.friction.iter().enumerate() {
            let values = match *law {
                Friction::Given { slip_bound } => vec![("slip bound", slip_bound)],
                Friction::Coulomb { coefficient } => vec![("friction coefficient", coefficient)],
                Friction::Limited { coefficient, limit } => {
                    vec![("friction coefficient", coefficient), ("limit of friction", limit)]
                }
                Friction::Cohesive { coefficient, cohesion, tension } => {
                    vec![("friction coefficient", coefficient), ("cohesion", cohesion), ("tensile strength", tension)]
                }
                Friction::None | Friction::Bonded => continue,
            };
            if let Some((name, value)) = values.iter().find(|(_, value)| !(value.is_finite() && *value >= 0.0)) {
                let what = format!("contact.friction[{j}]: the {name} of point {j} is {value}");
                return Err(wrong(what, "friction is a finite number, at least zero"));
            }
            if let Friction::Cohesive { coefficient, cohesion, tension } = *law
                && coefficient * tension > cohesion * (1.0 + APEX)
            {
                let what = format!(
                    "contact.friction[{j}]: the tensile strength {tension} of point {j} is beyond the apex of its cone"
                );
                return Err(wrong(what, "give a tensile strength of at most cohesion / coefficient"));
            }
        }
        for (j, ratio) in self.orthotropy.iter().flatten().enumerate() {
            if !(0.0..=1.0).contains(ratio) {
                let what = format!("contact.orthotropy[{j}] is {ratio}");
                let remedy = "give a number from 0 to 1: friction across the first tangent over that along it, where it is \
                              the larger";
                return Err(wrong(what, remedy));
            }
        }
        Ok(())
    }
}

/// An overlap of a held point below this part of the largest length of the data may be rounding, and the certificate judges it.
const HELD: f64 = 1e-8;

/// A tensile strength beyond the apex by less than this part is at the apex but for rounding.
const APEX: f64 = 1e-12;

fn wrong(what: String, remedy: &str) -> Error {
    Error::new("contact problem", what, remedy)
}

fn finite(name: &str, list: &[f64]) -> Result<(), Error> {
    match list.par_iter().with_min_len(1 << 16).position_first(|x| !x.is_finite()) {
        Some(i) => Err(wrong(format!("{name}[{i}] is {}", list[i]), "give finite numbers")),
        None => Ok(()),
    }
}

fn check_middles(middles: &[[u32; 3]], has_nodes: bool) -> Result<(), Error> {
    if !has_nodes {
        let remedy = "give `elastic.node_of`, or no `elastic.middles`";
        return Err(wrong("elastic.middles names nodes, and `elastic.node_of` is missing".into(), remedy));
    }
    let mut seen = FxHashSet::default();
    if let Some([node, ..]) = middles.iter().find(|[node, ..]| !seen.insert(*node)) {
        let what = format!("elastic.middles: node {node} is in the middle of two edges");
        return Err(wrong(what, "name each middle once, with the ends of its edge"));
    }
    match middles.iter().find(|[_, a, b]| seen.contains(a) || seen.contains(b)) {
        Some([node, ..]) => {
            let what = format!("elastic.middles: an end of the edge of node {node} is itself in the middle of one");
            Err(wrong(what, "the ends of an edge are corners"))
        }
        None => Ok(()),
    }
}

/// A node whose unknowns do not follow one another. Ascending labels, the usual case, need no list of what was seen.
fn scattered_node(node_of: &[u32]) -> Option<u32> {
    if node_of.is_sorted() {
        return None;
    }
    let mut seen = FxHashSet::default();
    node_of.chunk_by(|a, b| a == b).map(|run| run[0]).find(|&node| !seen.insert(node))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_unknown_without_stiffness_is_named() {
        let with = |entries: &[(usize, usize, f64)]| {
            let k = SymmetricCsr::from_full(&Csr::from_triplets(3, 3, entries), "K").unwrap();
            ContactProblem::from_matrices(k, vec![0.0; 3], Csr::zero(0, 3), Vec::new(), Vec::new()).validate()
        };
        assert!(with(&[(0, 0, 2.0), (1, 1, 2.0), (2, 2, 2.0), (0, 2, -1.0), (2, 0, -1.0)]).is_ok());
        for (entries, found) in [(&[(0, 0, 2.0), (2, 2, 2.0)][..], 0), (&[(0, 0, 2.0), (1, 1, -2.0), (2, 2, 2.0)], -2)]
        {
            let what = with(entries).unwrap_err().what;
            assert!(what.contains(&format!("diagonal entry {found} at unknown 1")), "{what}");
        }
    }
}
