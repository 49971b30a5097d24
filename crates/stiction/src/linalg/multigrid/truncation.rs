use super::between_ranks::Reach;
use super::blocks::{Block, Blocks};
use super::coarsen::Coarser;
use super::coarsest::CoarsestFactor;
use super::coulomb_coupling::{CoulombCoupling, coupled_inverse};
use super::dense::{add_product, add_transpose_product, inverse_of_truncated, inverse_on};
use super::packed::{double, single};
use super::smoother::Level;
use super::{Hierarchy, RelativeMatrix};
use crate::ranks::{Halo, Wire};

/// The constraint at a node: constrained components, which keep their value, and a stiffness added to its diagonal block
/// (positive semidefinite, on free components).
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct NodeConstraint {
    /// Components that are constrained.
    pub constrained: [bool; 3],
    /// Stiffness added to the others, force per length.
    pub spring: Block<3, 3>,
    /// Coulomb coupling: this multiple of the row of the first component, which is constrained, is subtracted from the rows
    /// of the second and third. Their force then grows with the constraint force of the first.
    pub coulomb: [f64; 2],
}

impl Wire for NodeConstraint {
    const SIZE: usize = <[u8; 3]>::SIZE + Block::<3, 3>::SIZE + <[f64; 2]>::SIZE;

    fn write(&self, to: &mut Vec<u8>) {
        self.constrained.map(u8::from).write(to);
        self.spring.write(to);
        self.coulomb.write(to);
    }

    fn read(from: &[u8]) -> Self {
        let constrained = <[u8; 3]>::read(from).map(|c| c == 1);
        let (spring, coulomb) = (Block::read(&from[3..]), <[f64; 2]>::read(&from[3 + Block::<3, 3>::SIZE..]));
        NodeConstraint { constrained, spring, coulomb }
    }
}

/// The data of local changes of the hierarchy: the rows of the nodes that may be constrained, and the matrices of all levels
/// without constraints.
///
/// Constrained components are truncated from the finest prolongation (Kornhuber 1997; Graeser & Kornhuber 2009). With `S` the
/// projector on them the coarse matrix `Pᵀ (I - S)(A + spring)(I - S) P` is the one without constraints plus
/// `Pᵀ (S A S + spring) P - G - Gᵀ`, `G = Pᵀ S A P`, which is supported near the constrained nodes.
#[derive(Debug, Clone)]
pub(super) struct Truncation {
    nodes: Vec<u32>,
    /// How these nodes are divided among ranks; ghosts are those that are coupled to own ones.
    pub halo: Halo,
    diagonal: Vec<Block<3, 3>>,
    /// The matrix between these nodes, by their places in `nodes` and then among the ghosts.
    among: Blocks<3, 3>,
    /// Their displacements by those of the first aggregated level.
    pub support: Support<6>,
    /// Coarse nodes whose rows may change, by aggregated level, the coarsest last.
    pub touched: Vec<Reach>,
    /// The touched rows, by aggregated level.
    pub rows: Vec<TouchedRows<6>>,
    /// From each further level to the one before it: the rows that changes meet, in the double precision of the coarse matrices. Of
    /// functions that constraints take away altogether the rounding of single precision would be left, 1e-7 of their stiffness, and
    /// steps along them would be ten million times too long.
    pub further: Vec<Blocks<6, 6>>,
    /// The coarsest matrix without constraints, and with those that it has.
    coarsest: Blocks<6, 6>,
    constrained_coarsest: Blocks<6, 6>,
    /// The constraints that the coarse levels have, those of ghosts too; none where they are to be renewed.
    held: Option<Vec<NodeConstraint>>,
}

/// The rows of a coarse matrix that constraints change, one after the other. They are kept in double precision, because the rounding
/// of a stiff spring in single precision would stay when it is gone.
#[derive(Debug, Clone, Default)]
pub(super) struct TouchedRows<const R: usize> {
    /// Without constraints.
    pub free: Vec<Block<R, R>>,
    /// At present; empty if that is not known.
    now: Vec<Block<R, R>>,
}

impl<const R: usize> TouchedRows<R> {
    /// The rows `touched` of a matrix without constraints.
    pub(super) fn of(matrix: &Blocks<R, R>, touched: &[u32]) -> Self {
        let free = touched.iter().flat_map(|&i| matrix.row(i as usize).1).copied().collect();
        TouchedRows { free, now: Vec::new() }
    }
}

/// For each column the rows that contain it, with the places of the blocks.
pub(super) type Columns = (Vec<usize>, Vec<(u32, u32)>);

/// The nodes that may be constrained in a coarser space: rows of its prolongation `P` and of `A P`.
#[derive(Debug, Clone, Default)]
pub(super) struct Support<const C: usize> {
    /// Of ghosts too, after the own ones.
    pub p: Blocks<3, C>,
    a_times_p: Blocks<3, C>,
    p_columns: Columns,
    a_times_p_columns: Columns,
}

impl<const C: usize> Support<C> {
    pub(super) fn new(p: Blocks<3, C>, a_times_p: Blocks<3, C>) -> Self {
        let own = a_times_p.rows;
        let (p_columns, a_times_p_columns) = (p.by_columns(own), a_times_p.by_columns(own));
        Support { p, a_times_p, p_columns, a_times_p_columns }
    }

    /// Of a step of coarsening; the nodes of this rank come first.
    pub(super) fn of_step(step: &Coarser<3, C>, nodes: &[u32]) -> Self {
        let all = |k: usize, name: &mut dyn FnMut(u32)| {
            step.prolongation.row(nodes[k] as usize).0.iter().for_each(|&j| name(j));
        };
        let p = Blocks::from_rows(nodes.len(), step.prolongation.cols, all, |k, row| {
            step.prolongation.entries_of(nodes[k] as usize).for_each(|(j, block)| *row.at(j) = *block);
        });
        Support::new(p, step.a_times_p.clone())
    }

    /// In the space that `prolongation` embeds in this one.
    pub(super) fn within(&self, prolongation: &Blocks<C, 6>) -> Support<6> {
        Support::new(product(&self.p, prolongation), product(&self.a_times_p, prolongation))
    }

    /// The columns of the rows of `P` at the nodes of this rank, in any order.
    pub(super) fn own_columns(&self) -> &[u32] {
        // A support that was never filled has no rows.
        &self.p.column[..self.p.start.get(self.a_times_p.rows).copied().unwrap_or(0)]
    }

    /// The nodes of the coarser space whose rows may change by what this rank constrains.
    pub(super) fn touched(&self) -> Vec<u32> {
        let mut touched = [self.a_times_p.column.as_slice(), self.own_columns()].concat();
        touched.sort_unstable();
        touched.dedup();
        touched
    }

    /// Contact nodes in the support of a coarse node, by their places, and their blocks of `P`.
    pub(super) fn p_column(&self, k: u32) -> impl Iterator<Item = (usize, &Block<3, C>)> {
        column(&self.p_columns, &self.p, k)
    }

    /// The same of `A P`.
    pub(super) fn a_times_p_column(&self, k: u32) -> impl Iterator<Item = (usize, &Block<3, C>)> {
        column(&self.a_times_p_columns, &self.a_times_p, k)
    }
}

/// `A B`.
fn product<const C: usize>(a: &Blocks<3, C>, b: &Blocks<C, 6>) -> Blocks<3, 6> {
    let reached = |i: usize, name: &mut dyn FnMut(u32)| {
        a.row(i).0.iter().for_each(|&j| b.row(j as usize).0.iter().for_each(|&k| name(k)));
    };
    Blocks::from_rows(
        a.rows,
        b.cols,
        reached,
        #[inline(always)]
        |i, row| {
            for (j, block) in a.entries_of(i) {
                for (k, value) in b.entries_of(j as usize) {
                    add_product(block, value, row.at(k));
                }
            }
        },
    )
}

impl Truncation {
    /// For contact `nodes` of the matrix `a`, whose places are divided by `halo` and whose ghosts are the nodes `ghosts`, with
    /// their support in the first aggregated level, which is divided by `coarse`.
    pub(super) fn new(
        a: &RelativeMatrix,
        nodes: &[u32],
        (halo, ghosts): (Halo, &[u32]),
        support: Support<6>,
        coarse: &Halo,
    ) -> Self {
        let mut place = vec![u32::MAX; a.halo.len()];
        nodes.iter().chain(ghosts).enumerate().for_each(|(k, &v)| place[v as usize] = k as u32);
        let others = |k: usize, name: &mut dyn FnMut(u32)| {
            let own = a.row(nodes[k] as usize).0.iter().map(|&j| place[j as usize]);
            own.filter(|&p| p != u32::MAX).for_each(name);
        };
        let among = Blocks::from_rows(nodes.len(), nodes.len() + ghosts.len(), others, |k, row| {
            for (j, block) in a.entries_of(nodes[k] as usize) {
                if place[j as usize] != u32::MAX {
                    *row.at(place[j as usize]) = *block;
                }
            }
        });
        let diagonal = nodes.iter().map(|&v| a.diagonal(v as usize)).collect();
        let touched = vec![Reach::new(coarse, support.touched())];
        Truncation {
            nodes: nodes.to_vec(),
            halo,
            diagonal,
            among,
            support,
            touched,
            rows: Vec::new(),
            further: Vec::new(),
            coarsest: Blocks::default(),
            constrained_coarsest: Blocks::default(),
            held: None,
        }
    }

    /// Adds a coarse level: its matrix without constraints, and the nodes of the next level, divided by `coarser`, that its
    /// changes reach.
    pub(super) fn add_level(&mut self, matrix: &Blocks<6, 6>, prolongation: &Blocks<6, 6>, coarser: &Halo) {
        let here = &self.touched[self.touched.len() - 1].touched;
        let mut next: Vec<u32> = here.iter().flat_map(|&i| prolongation.row(i as usize).0).copied().collect();
        next.sort_unstable();
        next.dedup();
        let mut is_met = vec![false; prolongation.rows];
        here.iter().flat_map(|&i| matrix.row(i as usize).0).for_each(|&j| is_met[j as usize] = true);
        let met = |i: usize| prolongation.entries_of(i).take(if is_met[i] { usize::MAX } else { 0 });
        let named = |i: usize, name: &mut dyn FnMut(u32)| met(i).for_each(|(k, _)| name(k));
        let further = Blocks::from_rows(prolongation.rows, prolongation.cols, named, |i, row| {
            met(i).for_each(|(k, block)| *row.at(k) = *block);
        });
        self.further.push(further);
        self.rows.push(TouchedRows::of(matrix, here));
        self.touched.push(Reach::new(coarser, next));
    }

    /// The contact node at a place.
    pub(super) fn node(&self, place: u32) -> u32 {
        self.nodes[place as usize]
    }

    /// Sets the coarsest matrix without constraints.
    pub(super) fn set_coarsest(&mut self, coarsest: Blocks<6, 6>) {
        self.coarsest = coarsest;
    }
}

/// The ghosts of a matrix among its contact `nodes`, and how these are divided among ranks, by their places.
pub(crate) fn contact_ghosts(a: &RelativeMatrix, nodes: &[u32]) -> (Halo, Vec<u32>) {
    /// The number of a node that is none.
    const NONE: u64 = u64::MAX;
    if a.halo.is_alone() {
        return (Halo::alone(nodes.len()), Vec::new());
    }
    let first = Halo::divided(a.halo.ranks(), nodes.len(), Vec::new()).first();
    let mut number = vec![NONE; a.halo.own()];
    nodes.iter().zip(first..).for_each(|(&v, k)| number[v as usize] = k);
    a.halo.update(&mut number);
    let ghosts = (a.halo.own()..a.halo.len()).map(|v| (number[v], v as u32)).filter(|(k, _)| *k != NONE);
    let mut ghosts: Vec<(u64, u32)> = ghosts.collect();
    ghosts.sort_unstable();
    let halo = Halo::divided(a.halo.ranks(), nodes.len(), ghosts.iter().map(|(k, _)| *k).collect());
    (halo, ghosts.into_iter().map(|(_, v)| v).collect())
}

/// The rows with a block in column `k`, and the blocks.
fn column<'a, const C: usize>(
    columns: &'a Columns,
    of: &'a Blocks<3, C>,
    k: u32,
) -> impl Iterator<Item = (usize, &'a Block<3, C>)> {
    let (start, entry) = columns;
    let own = &entry[start[k as usize]..start[k as usize + 1]];
    own.iter().map(|&(i, place)| (i as usize, &of.value[place as usize]))
}

/// What constraints do to the coarse levels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum CoarseLevels {
    Stay,
    /// No rank has Coulomb coupling.
    Change,
    /// Some rank has.
    ChangeCoupled,
}

impl CoarseLevels {
    /// Whether they change on some rank, and whether some rank has Coulomb coupling; the same on all ranks.
    pub(crate) fn of(changes: bool, coupled: bool) -> Self {
        match (changes, coupled) {
            (false, _) => CoarseLevels::Stay,
            (true, false) => CoarseLevels::Change,
            (true, true) => CoarseLevels::ChangeCoupled,
        }
    }
}

impl Hierarchy {
    /// Constrains the contact nodes, one constraint each in their order; further nodes are free. The finest level changes at once, the coarse levels
    /// as `coarse` says, the same on all ranks. Nodes that others are measured from are swept `alone` as well, or these sweeps rest.
    pub(crate) fn constrain(&mut self, constraints: &[NodeConstraint], coarse: CoarseLevels, alone: bool) {
        let changes = coarse != CoarseLevels::Stay;
        let Truncation { nodes, diagonal, .. } = &self.truncation;
        for ((constraint, &v), block) in constraints.iter().zip(nodes).zip(diagonal) {
            let mut diagonal = *block;
            diagonal.iter_mut().flatten().zip(constraint.spring.iter().flatten()).for_each(|(d, s)| *d += s);
            let symmetric = inverse_on(&diagonal, &constraint.constrained.map(|h| !h));
            self.fine.inverse[v as usize] = single(&coupled_inverse(&symmetric, &diagonal, constraint.coulomb));
        }
        self.stiff.constrain(constraints);
        self.coulomb.clear();
        let rows = constraints.iter().zip(nodes).filter(|(c, _)| c.coulomb != [0.0; 2]);
        self.coulomb.extend(rows.map(|(c, &v)| (v, c.coulomb.map(|f| f as f32))));
        self.constrained.clear();
        let some = constraints.iter().enumerate().filter(|(_, c)| c.constrained != [false; 3]);
        self.constrained.extend(some.map(|(place, c)| (place as u32, c.constrained)));
        if alone {
            self.absolute.constrain(constraints, &nodes[..constraints.len()], &self.fine.matrix, changes);
        } else {
            self.absolute.forget();
        }
        if changes {
            let mut constraints = constraints.to_vec();
            constraints.resize(nodes.len(), NodeConstraint::default());
            let constraints = self.truncation.halo.extended(&constraints).into_owned();
            self.update_coarse(constraints, coarse == CoarseLevels::ChangeCoupled);
        }
    }

    /// The next constraints of the coarse levels are added to none: what the changes so far have left of rounding is lost.
    pub(crate) fn forget_coarse_constraints(&mut self) {
        self.truncation.held = None;
        self.absolute.forget();
    }

    /// Takes all constraints from the coarse levels.
    pub(super) fn renew_coarse_levels(&mut self) {
        let Truncation { rows, held, constrained_coarsest, coarsest, .. } = &mut self.truncation;
        *held = None;
        rows.iter_mut().for_each(|rows| rows.now.clear());
        constrained_coarsest.clone_from(coarsest);
        self.linear.iter_mut().for_each(|linear| linear.rows.now.clear());
    }

    /// Adds what changes since the constraints were the last ones; these are those of ghosts too.
    fn update_coarse(&mut self, constraints: Vec<NodeConstraint>, coupled: bool) {
        let old = self.truncation.held.take().unwrap_or_else(|| {
            self.renew_coarse_levels();
            vec![NodeConstraint::default(); constraints.len()]
        });
        let (truncation, both) = (&self.truncation, [&old[..], &constraints]);
        if let Some(linear) = &mut self.linear {
            let reach = &linear.reach;
            let change = truncation.change(&linear.support, &reach.reach, both, linear.level.halo.len());
            change_rows(&mut linear.level, &reach.touched, &mut linear.rows, &reach.rows(change));
            linear.level.damp();
            linear.stiff.set_rows(&reach.touched, &linear.level.matrix, &linear.rows.now);
        }
        let reach = &truncation.touched[0];
        let change = truncation.change(&truncation.support, &reach.reach, both, self.first_coarse());
        let change = reach.rows(change);
        self.change_coarse(0, change);
        if coupled {
            self.couple_coarse_levels(&constraints);
        }
        self.truncation.held = Some(constraints);
    }

    /// The matrix of a coarse level without constraints.
    pub(super) fn without_constraints(&self, level: usize) -> Blocks<6, 6> {
        let Some(Level { matrix, .. }) = self.coarse.get(level) else { return self.truncation.coarsest.clone() };
        let mut value: Vec<Block<6, 6>> = matrix.value.iter().map(double).collect();
        let mut free = self.truncation.rows[level].free.iter();
        for &i in &self.truncation.touched[level].touched {
            let own = matrix.start[i as usize]..matrix.start[i as usize + 1];
            value[own].iter_mut().zip(&mut free).for_each(|(value, free)| *value = *free);
        }
        let (start, column) = (matrix.start.clone(), matrix.column.clone());
        Blocks { rows: matrix.rows, cols: self.halos[level].len(), start, column, value }
    }

    /// Adds `change`, rows for the touched nodes of level `from`, and its Galerkin products on the coarser levels to the matrices of
    /// the coarse levels. Removes the Coulomb coupling.
    pub(super) fn change_coarse(&mut self, from: usize, mut change: Blocks<6, 6>) {
        self.coulomb_coupling = CoulombCoupling::default();
        let truncation = &mut self.truncation;
        for (k, level) in self.coarse.iter_mut().enumerate().skip(from) {
            let (here, next) = (&truncation.touched[k], &truncation.touched[k + 1]);
            change_rows(level, &here.touched, &mut truncation.rows[k], &change);
            level.damp();
            change = next.rows(coarser_change(&change, &here.touched, &truncation.further[k], &next.reach));
        }
        let coarsest = &mut truncation.constrained_coarsest;
        for (t, &i) in truncation.touched[self.coarse.len()].touched.iter().enumerate() {
            for (j, block) in change.entries_of(t) {
                if let Some(place) = coarsest.place(i as usize, j as usize) {
                    let target = coarsest.value[place].iter_mut().flatten();
                    target.zip(block.iter().flatten()).for_each(|(a, d)| *a += d);
                }
            }
        }
        self.coarsest = CoarsestFactor::new(coarsest);
    }
}

/// Adds `change` to the rows `touched` of the matrix of a level, which are `rows`, and sets the inverses of their diagonal blocks.
fn change_rows<const R: usize, const W: usize>(
    level: &mut Level<R, W>,
    touched: &[u32],
    rows: &mut TouchedRows<R>,
    change: &Blocks<R, R>,
) {
    let TouchedRows { free, now } = rows;
    let renewed = now.is_empty();
    if renewed {
        now.clone_from(free);
    }
    let mut end = 0;
    for (t, &i) in touched.iter().enumerate() {
        let i = i as usize;
        let start = level.matrix.start[i];
        let own = level.matrix.row(i).0;
        let range = end..end + own.len();
        end = range.end;
        let (columns, blocks) = change.row(t);
        if columns.is_empty() && !renewed {
            continue;
        }
        let (before, now) = (&free[range.clone()], &mut now[range]);
        let mut place = 0;
        for (j, block) in columns.iter().zip(blocks) {
            // Columns ascend in both, and the change lies within the pattern.
            place += own[place..].partition_point(|column| column < j);
            if own.get(place) == Some(j) {
                now[place].iter_mut().flatten().zip(block.iter().flatten()).for_each(|(a, d)| *a += d);
            }
        }
        if let Ok(place) = own.binary_search(&(i as u32)) {
            level.inverse[i] = single(&inverse_of_truncated(&now[place], &before[place], level.largest));
        }
        let values = &mut level.matrix.value[start..start + now.len()];
        values.iter_mut().zip(now).for_each(|(value, now)| *value = single(now));
    }
}

impl Truncation {
    /// The change of the matrix of a coarser space of `cols` nodes where the constraints of this rank and its ghosts change from
    /// `old` to `new`: a row for each of its touched nodes, empty where none of them reaches.
    pub(super) fn change<const C: usize>(
        &self,
        support: &Support<C>,
        touched: &[u32],
        [old, new]: [&[NodeConstraint]; 2],
        cols: usize,
    ) -> Blocks<C, C> {
        let constrains = |of: &[NodeConstraint], i: usize, r: usize| of[i].constrained[r];
        let changes: Vec<bool> = old.iter().zip(new).map(|(old, new)| old.constrained != new.constrained).collect();
        // The change of S: one where a component is constrained, minus one where it is released.
        let sign = |of: bool, before: bool| f64::from(u8::from(of)) - f64::from(u8::from(before));
        let signs =
            |i: usize| -> [f64; 3] { std::array::from_fn(|r| sign(constrains(new, i, r), constrains(old, i, r))) };
        // The change of S A S, if there is one.
        let part = |i: usize, k: usize, a: &Block<3, 3>| -> Option<Block<3, 3>> {
            let both = |of, r, c| constrains(of, i, r) && constrains(of, k, c);
            let factor = |r: usize, c: usize| sign(both(new, r, c), both(old, r, c));
            let is_changed = (changes[i] || changes[k]) && (0..9).any(|rc| factor(rc / 3, rc % 3) != 0.0);
            is_changed.then(|| std::array::from_fn(|r| std::array::from_fn(|c| factor(r, c) * a[r][c])))
        };
        // Row i of the change of (S A S + spring) P - S A P.
        let reached = |i: usize, name: &mut dyn FnMut(u32)| {
            let mut named = |of: &Blocks<3, C>, k: usize| of.row(k).0.iter().for_each(|&j| name(j));
            if old[i].spring != new[i].spring {
                named(&support.p, i);
            }
            if changes[i] {
                named(&support.a_times_p, i);
            }
            // With relative coordinates the pattern of the rows of `A P` does not contain all of these.
            let others = self.among.entries_of(i).filter(|(k, a)| part(i, *k as usize, a).is_some());
            others.for_each(|(k, _)| named(&support.p, k as usize));
        };
        let inner: Blocks<3, C> = Blocks::from_rows(
            self.nodes.len(),
            cols,
            reached,
            #[inline(always)]
            |i, row| {
                if old[i].spring != new[i].spring {
                    let [old, new] = [old[i].spring, new[i].spring];
                    let spring = std::array::from_fn(|r| std::array::from_fn(|c| new[r][c] - old[r][c]));
                    for (j, p) in support.p.entries_of(i) {
                        add_product(&spring, p, row.at(j));
                    }
                }
                for (k, a) in self.among.entries_of(i) {
                    let Some(part) = part(i, k as usize, a) else { continue };
                    for (j, p) in support.p.entries_of(k as usize) {
                        add_product(&part, p, row.at(j));
                    }
                }
                if !changes[i] {
                    return;
                }
                let signs = signs(i);
                for (j, block) in support.a_times_p.entries_of(i) {
                    let target = row.at(j);
                    for r in 0..3 {
                        (0..C).for_each(|c| target[r][c] -= signs[r] * block[r][c]);
                    }
                }
            },
        );
        let reached = |t: usize, name: &mut dyn FnMut(u32)| {
            let k = touched[t];
            let mut near = |i: usize, of: &Blocks<3, C>| of.row(i).0.iter().for_each(|&j| name(j));
            support.p_column(k).for_each(|(i, _)| near(i, &inner));
            support.a_times_p_column(k).filter(|&(i, _)| changes[i]).for_each(|(i, _)| near(i, &support.p));
        };
        Blocks::from_rows(
            touched.len(),
            cols,
            reached,
            #[inline(always)]
            |t, row| {
                let k = touched[t];
                for (i, p) in support.p_column(k) {
                    for (j, block) in inner.entries_of(i) {
                        add_transpose_product(p, block, row.at(j));
                    }
                }
                for (i, part) in support.a_times_p_column(k).filter(|&(i, _)| changes[i]) {
                    let (signs, mut part) = (signs(i), *part);
                    (0..3).for_each(|r| part[r] = part[r].map(|v| -signs[r] * v));
                    for (j, p) in support.p.entries_of(i) {
                        add_transpose_product(&part, p, row.at(j));
                    }
                }
            },
        )
    }
}

/// `Pᵀ D P` for a change `D` with the rows `rows`: a row for each of the coarser nodes `touched`.
pub(super) fn coarser_change(change: &Blocks<6, 6>, rows: &[u32], p: &Blocks<6, 6>, touched: &[u32]) -> Blocks<6, 6> {
    let cols = touched.iter().chain(&p.column).map(|&j| j as usize + 1).max().unwrap_or(0);
    let reached = |t: usize, name: &mut dyn FnMut(u32)| {
        change.row(t).0.iter().for_each(|&j| p.row(j as usize).0.iter().for_each(|&k| name(k)));
    };
    let right: Blocks<6, 6> = Blocks::from_rows(
        rows.len(),
        cols,
        reached,
        #[inline(always)]
        |t, row| {
            for (j, d) in change.entries_of(t) {
                for (k, value) in p.entries_of(j as usize) {
                    add_product(d, value, row.at(k));
                }
            }
        },
    );
    let mut by_column: Vec<Vec<(u32, Block<6, 6>)>> = vec![Vec::new(); cols];
    for (t, &i) in rows.iter().enumerate().filter(|(t, _)| !change.row(*t).0.is_empty()) {
        p.entries_of(i as usize).for_each(|(k, value)| by_column[k as usize].push((t as u32, *value)));
    }
    let reached = |k: usize, name: &mut dyn FnMut(u32)| {
        let above = by_column[touched[k] as usize].iter();
        above.for_each(|(t, _)| right.row(*t as usize).0.iter().for_each(|&j| name(j)));
    };
    Blocks::from_rows(
        touched.len(),
        cols,
        reached,
        #[inline(always)]
        |k, row| {
            for (t, value) in &by_column[touched[k] as usize] {
                for (j, b) in right.entries_of(*t as usize) {
                    add_transpose_product(value, b, row.at(j));
                }
            }
        },
    )
}
