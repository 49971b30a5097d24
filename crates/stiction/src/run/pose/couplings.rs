//! Nodes that move with a reference point: as ties between nodes, and forces at them.
//!
//! A rigid coupling chooses up to six displacements of its nodes from which those motions of the point follow that are not
//! prescribed, the base, and writes every other one as what these motions and the prescribed ones make of it. This leaves
//! stiffness and unknowns as they are, at the cost of a tie for each displacement; unknowns for the point itself would need a
//! place in every room that knows nodes. Force and moment at the point become forces at nodes, which do the same work in
//! every motion that the ties allow.
//!
//! A distributing coupling has no ties but for prescribed motions. Its point moves as the faces do in the mean: that motion is
//! what the tractions `a + b x r` of [`Load::Resultant`] do work on.

use std::collections::BTreeMap;
use std::ops::Range;

use super::activity::{ALWAYS, Period};
use super::ties::{Start, Tie, along_at};
use super::{place, regions};
use crate::Error;
use crate::fem::{DofMap, Field, Load, Solid, external_forces};
use crate::io::case::{Case, CouplingSpec, Spot};
use crate::mesh::Mesh;
use crate::mesh::v3::{V3, cross, dot, mean, norm, scale, sub};

/// Directions that follow from others but for this part of the largest follow from them.
const DEPENDENT: f64 = 1e-9;
/// Of the nodes that are chosen first they follow where this part is left.
const CLEAR: f64 = 1e-3;
/// Entries of a tie below this are rounding.
const NONE: f64 = 1e-14;
/// A point this near the axis of cyclic symmetry, over the radius of the mesh, is on it.
const ON_AXIS: f64 = 1e-6;
/// Motions of the point: along x, y, z, about x, y, z.
pub(crate) const MOTIONS: [&str; 6] = ["along x", "along y", "along z", "about x", "about y", "about z"];

/// Vectors at nodes.
pub(crate) type Column = Vec<(u32, V3)>;

/// A reference point.
#[derive(Debug, Clone)]
pub struct Coupling {
    /// Its name.
    pub name: String,
    /// Length.
    pub point: V3,
    /// For each of its six vectors at nodes: the forces there that a unit force or moment at the point is, and the
    /// factors with which displacements add up to the motion. None where the nodes do not tell it.
    pub columns: [Option<Column>; 6],
    /// Force and moment at the point.
    load: [Field; 6],
    /// The ties, by their numbers among all, that prescribe its motions: what the value of each gains by a unit of each motion.
    pub prescribed: Vec<(usize, [f64; 6])>,
    /// All its ties.
    pub ties: Range<usize>,
    spot: Spot,
}

/// A displacement of a node along x, y or z, and the row that gives it by the motion of the centre.
#[derive(Clone, Copy)]
struct Followed {
    node: u32,
    c: usize,
    row: [f64; 6],
}

/// Some of the displacements, from which the others follow: `row = coordinates · lower · basis`.
struct Base {
    members: Vec<Followed>,
    /// Orthonormal rows.
    basis: Vec<[f64; 6]>,
    /// The members by the basis, a lower triangle.
    lower: Vec<Vec<f64>>,
}

/// The couplings of a case and their ties, the first of which has the number `first` among all.
///
/// # Errors
/// Nodes that do not determine a motion that is prescribed or loaded; faces without a width.
pub(crate) fn couplings(
    solid: &Solid,
    dofs: &DofMap,
    case: &Case,
    first: usize,
) -> Result<(Vec<Coupling>, Vec<Tie>), Error> {
    let (mut list, mut ties) = (Vec::new(), Vec::new());
    for spec in &case.couplings {
        let rigid = if spec.distributing { None } else { Some(Rigid::new(solid, spec)?) };
        let columns = match &rigid {
            None => mean_motion(solid, spec)?,
            Some(rigid) => rigid.columns(),
        };
        let begin = first + ties.len();
        let mut coupling = Coupling::new(spec, columns, begin);
        coupling.refuse_untold(spec)?;
        coupling.refuse_shared(solid.mesh, case, spec)?;
        let motion = Prescribed::new(case, spec);
        match rigid {
            None => coupling.prescribe_mean(dofs, &motion, first, &mut ties),
            Some(rigid) => coupling.prescribe_rigid(&rigid, dofs, &motion, first, &mut ties),
        }
        coupling.ties = begin..first + ties.len();
        list.push(coupling);
    }
    Ok((list, ties))
}

/// The motions of a point that are prescribed, and when.
struct Prescribed {
    values: [Option<Field>; 6],
    period: Period,
    start: Start,
}

/// A motion of the point that the case prescribes.
pub(crate) fn prescribed(spec: &CouplingSpec, k: usize) -> Option<Field> {
    [&spec.motion, &spec.rotation][k / 3][k % 3].clone()
}

impl Prescribed {
    fn new(case: &Case, spec: &CouplingSpec) -> Self {
        let period = spec.during.period(&case.steps);
        let start = match spec.during.from.filter(|_| period[0].is_finite()) {
            None => Start::AtOnce,
            Some(step) => Start::Until(case.steps[step].until),
        };
        let values = std::array::from_fn(|k| prescribed(spec, k));
        Prescribed { values, period, start }
    }

    /// The value that gains so much by a unit of each motion.
    fn value(&self, by: &[f64; 6]) -> Vec<(f64, Field)> {
        let parts = self.values.iter().zip(by).filter(|(_, by)| **by != 0.0);
        parts.filter_map(|(value, by)| Some((*by, value.clone()?))).collect()
    }
}

impl Coupling {
    /// Without ties, the first of which will have the number `first` among all.
    pub(crate) fn new(spec: &CouplingSpec, columns: [Option<Column>; 6], first: usize) -> Self {
        let load = std::array::from_fn(|k| [&spec.force, &spec.moment][k / 3][k % 3].clone());
        let (name, point, spot) = (spec.name.clone(), spec.point, spec.spot.clone());
        Coupling { name, point, columns, load, prescribed: Vec::new(), ties: first..first, spot }
    }

    /// An error where the nodes do not tell a motion that is prescribed or loaded.
    fn refuse_untold(&self, spec: &CouplingSpec) -> Result<(), Error> {
        let values = spec.motion.iter().chain(&spec.rotation).map(Option::is_some);
        let loads = self.load.iter().map(|load| !matches!(load, Field::Constant(0.0)));
        let untold = |(k, asked): &(usize, bool)| *asked && self.columns[*k].is_none();
        match values.zip(loads).map(|(value, load)| value || load).enumerate().find(untold) {
            None => Ok(()),
            Some((k, _)) => {
                let what = format!("the nodes of this coupling do not tell the motion of its point {}", MOTIONS[k]);
                let remedy = "leave that component out, or couple more nodes or components";
                Err(self.spot.error(what, remedy))
            }
        }
    }

    /// An error where cyclic symmetry has the point in all sectors, but not its motion: on the axis only one along it and about it is
    /// the same in all.
    fn refuse_shared(&self, mesh: &Mesh, case: &Case, spec: &CouplingSpec) -> Result<(), Error> {
        for cyclic in &case.cyclic {
            let from_axis = |x: V3| norm(cross(sub(x, cyclic.point), cyclic.axis));
            let radius = mesh.nodes.iter().map(|&x| from_axis(x)).fold(0.0, f64::max);
            if from_axis(spec.point) > ON_AXIS * radius {
                continue;
            }
            let what = "the point of this coupling is on the axis of cyclic symmetry, where all sectors share it and it moves along \
                        and about the axis alone";
            if spec.distributing {
                let remedy = "make it kind = \"rigid\", or load the faces by a pressure or a traction";
                return Err(self.spot.error(what, remedy));
            }
            let is_across = |k: &usize| cyclic.axis[k % 3].abs() < 1.0 - ON_AXIS;
            let is_free = |k: &usize| {
                let is_zero = matches!(prescribed(spec, *k), Some(Field::Constant(0.0)));
                self.columns[*k].is_some() && !is_zero
            };
            if let Some(k) = (0..6).filter(is_across).find(is_free) {
                let remedy = "prescribe zero for motion and rotation of the two other axes, such as motion = { x = 0, y = 0 } and \
                              rotation = { x = 0, y = 0 }; turn the mesh if the axis is along none of x, y, z";
                return Err(self.spot.error(format!("{what}, but this one may move {}", MOTIONS[k]), remedy));
            }
        }
        Ok(())
    }

    /// A tie for each motion of the mean.
    fn prescribe_mean(&mut self, dofs: &DofMap, motion: &Prescribed, first: usize, ties: &mut Vec<Tie>) {
        for (k, column) in self.columns.iter().enumerate().filter(|(k, _)| motion.values[*k].is_some()) {
            let by = unit(k);
            let tie =
                Tie::always(entries(dofs, column.as_deref().unwrap_or_default()), motion.value(&by), self.spot.clone());
            self.prescribed.push((first + ties.len(), by));
            let (period, start) = (motion.period, motion.start);
            ties.push(Tie { period, start, idle: true, is_support: true, ..tie });
        }
    }

    /// A tie for each displacement that follows from the base, with the motions prescribed and, where these end or begin with
    /// a step, without.
    fn prescribe_rigid(
        &mut self,
        rigid: &Rigid,
        dofs: &DofMap,
        motion: &Prescribed,
        first: usize,
        ties: &mut Vec<Tie>,
    ) {
        let held: [bool; 6] = std::array::from_fn(|k| motion.values[k].is_some());
        let [begin, end] = motion.period;
        let mut free = vec![[f64::NEG_INFINITY, begin], [end, f64::INFINITY]];
        free.retain(|[from, until]| from < until);
        if held == [false; 6] {
            free = vec![ALWAYS];
        } else {
            for (followed, column, by) in rigid.following(&held) {
                let tie = Tie::always(entries(dofs, &column), motion.value(&by), self.spot.clone());
                self.prescribed.push((first + ties.len(), by));
                let (period, start, node) = (motion.period, motion.start, Some(followed.node));
                ties.push(Tie { period, start, idle: true, is_support: true, node, ..tie });
            }
        }
        for period in free {
            for (followed, column, _) in rigid.following(&[false; 6]) {
                let tie = Tie::always(entries(dofs, &column), Vec::new(), self.spot.clone());
                ties.push(Tie { period, idle: true, node: Some(followed.node), ..tie });
            }
        }
    }

    /// Force and moment at the point at time `t`.
    ///
    /// # Errors
    /// One that is not finite.
    pub(crate) fn load(&self, t: f64) -> Result<[f64; 6], Error> {
        let mut load = [0.0; 6];
        for (load, field) in load.iter_mut().zip(&self.load) {
            *load = field.finite_at([f64::NAN; 3], t).map_err(|error| place::instead(&self.spot, error))?;
        }
        Ok(load)
    }

    /// Adds the forces at nodes, `3 i + c` along x, y, z, that force and moment at the point are.
    ///
    /// # Errors
    /// As [`Self::load`].
    pub(crate) fn add_forces(&self, t: f64, force: &mut [f64]) -> Result<(), Error> {
        for (load, column) in self.load(t)?.into_iter().zip(&self.columns).filter(|(load, _)| *load != 0.0) {
            for (node, v) in column.iter().flatten() {
                (0..3).for_each(|c| force[3 * *node as usize + c] += load * v[c]);
            }
        }
        Ok(())
    }

    /// The motion of the point for displacements of the nodes; NaN where they do not tell it.
    pub(crate) fn motion(&self, u: impl Fn(u32) -> V3) -> [f64; 6] {
        let of = |column: &Option<Vec<(u32, V3)>>| {
            column.as_ref().map_or(f64::NAN, |column| column.iter().map(|(node, v)| dot(*v, u(*node))).sum())
        };
        std::array::from_fn(|k| of(&self.columns[k]))
    }
}

/// Vectors at nodes by degrees of freedom.
fn entries(dofs: &DofMap, column: &[(u32, V3)]) -> BTreeMap<u32, f64> {
    let mut entries = BTreeMap::new();
    for (node, v) in column {
        along_at(dofs, *node, *v).into_iter().for_each(|(dof, part)| *entries.entry(dof).or_default() += part);
    }
    let largest = entries.values().fold(0.0, |a: f64, v: &f64| a.max(v.abs()));
    entries.retain(|_, v| v.abs() > NONE * largest);
    entries
}

/// The mean motion of faces.
fn mean_motion(solid: &Solid, spec: &CouplingSpec) -> Result<[Option<Column>; 6], Error> {
    let faces = regions::faces(solid.mesh, &spec.on, &spec.spot, "the coupling")?;
    let mut columns = [const { None }; 6];
    for (k, column) in columns.iter_mut().enumerate() {
        let [x, y, z, a, b, c] = unit(k).map(Field::Constant);
        let (faces, about) = (faces.clone(), Some(spec.point));
        let load = Load::Resultant { faces, force: [x, y, z], moment: [a, b, c], about };
        let force = external_forces(solid, &[load], 0.0).map_err(|error| place::instead(&spec.spot, error))?;
        let at_nodes = force.as_chunks::<3>().0.iter().enumerate().filter(|(_, f)| **f != [0.0; 3]);
        *column = Some(at_nodes.map(|(node, f)| (node as u32, *f)).collect());
    }
    Ok(columns)
}

/// The nodes of a rigid coupling.
struct Rigid {
    all: Vec<Followed>,
    /// The nodes that the base is made of first.
    triangle: Vec<u32>,
    /// Rotations count as displacements at this distance from the point, so that all six are lengths.
    size: f64,
}

impl Rigid {
    fn new(solid: &Solid, spec: &CouplingSpec) -> Result<Rigid, Error> {
        let mesh = solid.mesh;
        let nodes = regions::nodes(mesh, &spec.on, &spec.spot)?;
        let arm = |node: u32| sub(mesh.nodes[node as usize], spec.point);
        let size = nodes.iter().map(|&node| norm(arm(node))).fold(0.0, f64::max);
        let size = if size > 0.0 { size } else { 1.0 };
        let row = |node: u32, c: usize| {
            let [along, turn] = [axis(c), scale(1.0 / size, cross(arm(node), axis(c)))];
            [along[0], along[1], along[2], turn[0], turn[1], turn[2]]
        };
        let followed = |&node: &u32| (0..3).filter(|&c| spec.components[c]).map(move |c| (node, c)).collect::<Vec<_>>();
        let all = nodes.iter().flat_map(followed).map(|(node, c)| Followed { node, c, row: row(node, c) }).collect();
        Ok(Rigid { all, triangle: triangle(mesh, &nodes), size })
    }

    fn columns(&self) -> [Option<Column>; 6] {
        let base = Base::new(&self.all, &self.triangle);
        std::array::from_fn(|k| {
            let motion = unit(k).map(|v| if k < 3 { v } else { v / self.size });
            let weights = base.spans(&motion).then(|| base.coordinates(&motion))?;
            let column = base.members.iter().zip(weights).filter(|(_, w)| *w != 0.0);
            Some(column.map(|(member, w)| (member.node, scale(w, axis(member.c)))).collect())
        })
    }

    /// The displacements that follow from others where the motions `held` are prescribed, each with the column that is then
    /// prescribed and what its value gains by a unit of each motion.
    fn following(&self, held: &[bool; 6]) -> Vec<(Followed, Column, [f64; 6])> {
        let free = |row: &[f64; 6]| std::array::from_fn(|k| if held[k] { 0.0 } else { row[k] });
        let masked: Vec<Followed> = self.all.iter().map(|it| Followed { row: free(&it.row), ..*it }).collect();
        let base = Base::new(&masked, &self.triangle);
        let place = |it: &Followed| self.all.partition_point(|other| (other.node, other.c) < (it.node, it.c));
        let members: Vec<usize> = base.members.iter().map(place).collect();
        let rest = masked.iter().enumerate().filter(|(i, _)| !members.contains(i));
        rest.map(|(i, it)| {
            let weights = base.coordinates(&it.row);
            let mut column = vec![(it.node, axis(it.c))];
            let mut by = self.all[i].row;
            for (&member, &w) in members.iter().zip(&weights) {
                let Followed { node, c, row } = self.all[member];
                column.push((node, scale(-w, axis(c))));
                by.iter_mut().zip(row).for_each(|(by, v)| *by -= w * v);
            }
            let by = std::array::from_fn(|k| match (held[k], k) {
                (false, _) => 0.0,
                (true, 0..3) => by[k],
                (true, _) => by[k] * self.size,
            });
            (self.all[i], column, by)
        })
        .collect()
    }
}

/// A unit vector.
fn axis(c: usize) -> V3 {
    [0, 1, 2].map(|k| f64::from(u8::from(k == c)))
}

/// A unit of a motion.
fn unit(k: usize) -> [f64; 6] {
    std::array::from_fn(|i| f64::from(u8::from(i == k)))
}

/// Nodes far from one another and from a line.
fn triangle(mesh: &Mesh, nodes: &[u32]) -> Vec<u32> {
    let at = |node: u32| mesh.nodes[node as usize];
    let centre = mean(nodes.iter().map(|&node| at(node)));
    // The first of equals, so that rounding does not decide.
    let farthest = |distance: &dyn Fn(u32) -> f64| {
        let larger = |best: Option<(u32, f64)>, node: u32| {
            let size = distance(node);
            if best.is_none_or(|best| size > best.1 * (1.0 + DEPENDENT)) { Some((node, size)) } else { best }
        };
        nodes.iter().copied().fold(None, larger).map(|best| best.0)
    };
    let Some(a) = farthest(&|node| norm(sub(at(node), centre))) else { return Vec::new() };
    let b = farthest(&|node| norm(sub(at(node), at(a)))).unwrap_or(a);
    let c = farthest(&|node| norm(cross(sub(at(node), at(a)), sub(at(b), at(a))))).unwrap_or(a);
    vec![a, b, c]
}

impl Base {
    /// Up to six of `all`, from which all follow: those of the nodes `first` that follow least, node by node, then any others.
    ///
    /// All three of the first node, two of the second and one of the third leave no two nodes that each need the other: the
    /// chain that multigrid asks of points that are relative to one another.
    fn new(all: &[Followed], first: &[u32]) -> Base {
        let mut left: Vec<[f64; 6]> = all.iter().map(|it| it.row).collect();
        let mut base = Base { members: Vec::new(), basis: Vec::new(), lower: Vec::new() };
        let largest = left.iter().map(|row| square(row).sqrt()).fold(0.0, f64::max);
        for node in first {
            while base.add(all, &mut left, |it| it.node == *node, CLEAR * largest) {}
        }
        while base.add(all, &mut left, |_| true, DEPENDENT * largest) {}
        let of = |member: &Followed| base.basis.iter().map(|q| product(&member.row, q)).collect();
        base.lower = base.members.iter().map(of).collect();
        base
    }

    /// Adds the one of which the members leave most, if that is more than `least`. `left` is what they leave of each.
    fn add(&mut self, all: &[Followed], left: &mut [[f64; 6]], of: impl Fn(&Followed) -> bool, least: f64) -> bool {
        let sizes = all.iter().zip(&*left).map(|(it, row)| if of(it) { square(row).sqrt() } else { 0.0 });
        // The first of equals, so that rounding does not decide.
        let larger = |best: (usize, f64), (i, size): (usize, f64)| {
            if size > best.1 * (1.0 + DEPENDENT) { (i, size) } else { best }
        };
        let (best, size) = sizes.enumerate().fold((0, 0.0), larger);
        if size <= least || self.members.len() == 6 {
            return false;
        }
        let direction = left[best].map(|v| v / size);
        self.basis.push(direction);
        self.members.push(all[best]);
        for row in left {
            let part = product(row, &direction);
            row.iter_mut().zip(direction).for_each(|(v, d)| *v -= part * d);
        }
        true
    }

    /// The factors with which the members add up to `row`.
    fn coordinates(&self, row: &[f64; 6]) -> Vec<f64> {
        let mut x: Vec<f64> = self.basis.iter().map(|q| product(row, q)).collect();
        for j in (0..x.len()).rev() {
            x[j] /= self.lower[j][j];
            let known = x[j];
            (0..j).for_each(|i| x[i] -= known * self.lower[j][i]);
        }
        x
    }

    /// Whether the members add up to `row` at all.
    fn spans(&self, row: &[f64; 6]) -> bool {
        let inside: f64 = self.basis.iter().map(|q| product(row, q).powi(2)).sum();
        (square(row) - inside).max(0.0).sqrt() <= 1e-6 * square(row).sqrt()
    }
}

fn product(a: &[f64; 6], b: &[f64; 6]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

fn square(a: &[f64; 6]) -> f64 {
    product(a, a)
}
