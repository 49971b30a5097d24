//! Nodes that move with a reference point: as ties between nodes, and forces at them.
//!
//! A rigid coupling chooses up to six displacements of its nodes from which the motion of the point follows, the base, and
//! writes every other one as what that motion makes of it. This leaves stiffness and unknowns as they are, at the cost of a
//! tie for each displacement; unknowns for the point itself would need a place in every room that knows nodes. Force and
//! moment at the point become forces at the base, which do the same work in every motion the ties allow.
//!
//! A distributing coupling has no ties but for prescribed motions. Its point moves as the faces do in the mean: that motion is
//! what the tractions `a + b x r` of [`Load::Resultant`] do work on.

use std::collections::BTreeMap;

use super::ties::{Start, Tie, along_at};
use super::{place, regions};
use crate::Error;
use crate::fem::{DofMap, Field, Load, Solid, external_forces};
use crate::io::case::{Case, CouplingSpec, Spot};
use crate::mesh::v3::{V3, add, cross, dot, norm, scale, sub};

/// Directions that follow from others but for this part of the largest follow from them.
const DEPENDENT: f64 = 1e-9;
/// Entries of a tie below this are rounding.
const NONE: f64 = 1e-14;
/// Motions of the point: along x, y, z, about x, y, z.
pub(crate) const MOTIONS: [&str; 6] = ["along x", "along y", "along z", "about x", "about y", "about z"];

/// A reference point.
#[derive(Debug, Clone)]
pub struct Coupling {
    /// Its name.
    pub name: String,
    /// Length.
    pub point: V3,
    /// For each of its [`MOTIONS`] vectors at nodes: the forces there that a unit force or moment at the point is, and the
    /// factors with which displacements add up to the motion. None where the nodes do not tell it.
    pub columns: [Option<Vec<(u32, V3)>>; 6],
    /// Force and moment at the point.
    load: [Field; 6],
    /// The ties, among all, that prescribe its motions.
    pub prescribed: [Option<usize>; 6],
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
        let columns = match spec.distributing {
            true => mean_motion(solid, spec)?,
            false => rigid(solid, dofs, spec, &mut ties)?,
        };
        let load: [Field; 6] = std::array::from_fn(|k| [&spec.force, &spec.moment][k / 3][k % 3].clone());
        let mut coupling = Coupling {
            name: spec.name.clone(),
            point: spec.point,
            columns,
            load,
            prescribed: [None; 6],
            spot: spec.spot.clone(),
        };
        coupling.prescribe(dofs, case, spec, first, &mut ties)?;
        list.push(coupling);
    }
    Ok((list, ties))
}

impl Coupling {
    fn prescribe(
        &mut self,
        dofs: &DofMap,
        case: &Case,
        spec: &CouplingSpec,
        first: usize,
        ties: &mut Vec<Tie>,
    ) -> Result<(), Error> {
        let period = spec.during.period(&case.steps);
        let start = match spec.during.from.filter(|_| period[0].is_finite()) {
            None => Start::AtOnce,
            Some(step) => Start::Until(case.steps[step].until),
        };
        let values = spec.motion.iter().chain(&spec.rotation);
        for (k, value) in values.enumerate() {
            let loaded = !matches!(self.load[k], Field::Constant(0.0));
            match (&self.columns[k], value) {
                (Some(column), Some(value)) => {
                    let tie = Tie::always(entries(dofs, column), value.clone(), self.spot.clone());
                    self.prescribed[k] = Some(first + ties.len());
                    ties.push(Tie { period, start, idle: true, is_support: true, ..tie });
                }
                (None, value) if loaded || value.is_some() => {
                    let what = format!("the nodes of this coupling do not tell the motion of its point {}", MOTIONS[k]);
                    let remedy = "leave that component out, or couple more nodes or components";
                    return Err(self.spot.error(what, remedy));
                }
                _ => {}
            }
        }
        Ok(())
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
fn mean_motion(solid: &Solid, spec: &CouplingSpec) -> Result<[Option<Vec<(u32, V3)>>; 6], Error> {
    let faces = regions::faces(solid.mesh, &spec.on, &spec.spot, "the coupling")?;
    let mut columns = [const { None }; 6];
    for (k, column) in columns.iter_mut().enumerate() {
        let unit = |part: usize| [0, 1, 2].map(|c| Field::Constant(f64::from(u8::from(k == 3 * part + c))));
        let (faces, about) = (faces.clone(), Some(spec.point));
        let load = Load::Resultant { faces, force: unit(0), moment: unit(1), about };
        let force = external_forces(solid, &[load], 0.0).map_err(|error| place::instead(&spec.spot, error))?;
        let at_nodes = force.as_chunks::<3>().0.iter().enumerate().filter(|(_, f)| **f != [0.0; 3]);
        *column = Some(at_nodes.map(|(node, f)| (node as u32, *f)).collect());
    }
    Ok(columns)
}

/// The columns of a rigid coupling; adds a tie for each displacement that follows.
fn rigid(
    solid: &Solid,
    dofs: &DofMap,
    spec: &CouplingSpec,
    ties: &mut Vec<Tie>,
) -> Result<[Option<Vec<(u32, V3)>>; 6], Error> {
    let mesh = solid.mesh;
    let nodes = regions::nodes(mesh, &spec.on, &spec.spot)?;
    let at = |node: u32| mesh.nodes[node as usize];
    let centre = scale(1.0 / nodes.len().max(1) as f64, nodes.iter().fold([0.0; 3], |sum, &node| add(sum, at(node))));
    let size = nodes.iter().map(|&node| norm(sub(at(node), centre))).fold(0.0, f64::max);
    let size = if size > 0.0 { size } else { 1.0 };
    // Rotations count at the farthest node, so that all six are lengths.
    let row = |along: V3, x: V3| {
        let turn = scale(1.0 / size, cross(sub(x, centre), along));
        [along[0], along[1], along[2], turn[0], turn[1], turn[2]]
    };
    let unit = |c: usize| [0, 1, 2].map(|k| f64::from(u8::from(k == c)));
    let along = |node: &u32| {
        let followed = |&c: &usize| Followed { node: *node, c, row: row(unit(c), at(*node)) };
        (0..3).filter(|&c| spec.components[c]).map(|c| followed(&c)).collect::<Vec<_>>()
    };
    let all: Vec<Followed> = nodes.iter().flat_map(along).collect();
    let base = Base::new(&all);
    let is_base = |it: &Followed| base.members.iter().any(|member| (member.node, member.c) == (it.node, it.c));
    for it in all.iter().filter(|it| !is_base(it)) {
        let mut column = vec![(it.node, unit(it.c))];
        let weights = base.coordinates(&it.row);
        column.extend(base.members.iter().zip(weights).map(|(member, w)| (member.node, scale(-w, unit(member.c)))));
        let tie = Tie::always(entries(dofs, &column), Field::Constant(0.0), spec.spot.clone());
        ties.push(Tie { idle: true, node: Some(it.node), ..tie });
    }
    let columns = std::array::from_fn(|k| {
        let motion = match k {
            0..3 => row(unit(k), spec.point),
            _ => std::array::from_fn(|i| if i == k { 1.0 / size } else { 0.0 }),
        };
        let weights = base.spans(&motion).then(|| base.coordinates(&motion))?;
        let column = base.members.iter().zip(weights).filter(|(_, w)| *w != 0.0);
        Some(column.map(|(member, w)| (member.node, scale(w, unit(member.c)))).collect())
    });
    Ok(columns)
}

impl Base {
    /// Up to six of `all` that are as far from following from one another as any: each is the one of which the ones before
    /// leave most (Gram and Schmidt with pivoting).
    fn new(all: &[Followed]) -> Base {
        let mut left: Vec<[f64; 6]> = all.iter().map(|it| it.row).collect();
        let mut base = Base { members: Vec::new(), basis: Vec::new(), lower: Vec::new() };
        let mut largest = 0.0;
        while base.members.len() < 6 {
            let sizes = left.iter().map(|row| square(row).sqrt());
            // The first of equals, so that rounding does not decide.
            let best = sizes
                .enumerate()
                .fold((0, 0.0), |best, (i, size)| if size > best.1 * (1.0 + DEPENDENT) { (i, size) } else { best });
            largest = best.1.max(largest);
            if best.1 <= DEPENDENT * largest || best.1 == 0.0 {
                break;
            }
            let direction = left[best.0].map(|v| v / best.1);
            base.basis.push(direction);
            base.members.push(all[best.0]);
            for row in &mut left {
                let part = product(row, &direction);
                row.iter_mut().zip(direction).for_each(|(v, d)| *v -= part * d);
            }
        }
        base.lower =
            base.members.iter().map(|member| base.basis.iter().map(|q| product(&member.row, q)).collect()).collect();
        base
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
