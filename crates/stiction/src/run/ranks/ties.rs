//! Equations between displacements and couplings: rank 0 makes points of them on the whole mesh, and all nodes that they join go to
//! one rank.

use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

use super::local::Local;
use super::scope;
use super::solve::Everywhere;
use crate::Error;
use crate::contact::{Coefficient, PosedPoints, SurfaceFriction};
use crate::fem::{DofMap, Field, Fix, Solid, dof_map};
use crate::friction::{MOST_EQUATIONS, is_over_many};
use crate::io::case::{Case, CouplingSpec, FixSpec, Spot};
use crate::mesh::Mesh;
use crate::mesh::v3::{V3, mean, norm, sub};
use crate::ranks::{Wire, put, sum, take};
use crate::run::pose::Coupling;
use crate::run::pose::activity::ALWAYS;
use crate::run::pose::couplings::{Column, couplings, prescribed};
use crate::run::pose::loads::end;
use crate::run::pose::place;
use crate::run::pose::planned;
use crate::run::pose::ties::{Redundant, Start, Tie, Tied, TiedPoint, TimedFix, ties_of_equations, ties_of_supports};
use crate::run::solve::CouplingState;

/// Whether a case has some.
pub(super) fn has_ties(case: &Case) -> bool {
    !case.equations.is_empty() || !case.couplings.is_empty()
}

/// What a tie is of, by its number in the case; a coupling with what its value gains by a unit of each motion of the point, a
/// support with its component.
#[derive(Clone, Copy)]
enum Source {
    Equation(usize),
    Coupling(usize, [f64; 6]),
    Support(usize, usize),
}

/// The ties of a case with equations or couplings, those of supports that begin or end with a step among them.
#[derive(Default)]
pub(super) struct Whole {
    tied: Tied,
    sources: Vec<Source>,
    pub couplings: Vec<Coupling>,
    /// Displacements that equations hold.
    pub held: usize,
    /// The nodes that ties join, each list ascending.
    together: Vec<Vec<u32>>,
}

/// What of it a rank has: ties and points all of whose nodes are in its piece, none if the case has none; of couplings the vectors
/// at the nodes here, and of the ties that prescribe their motions those of this rank.
pub(super) struct Here {
    pub tied: Option<Tied>,
    pub couplings: Vec<Coupling>,
}

impl Whole {
    /// # Errors
    /// As of [`couplings`] and [`Tied::new`]; values that are not finite or contradict one another at the end of a planned increment.
    pub(super) fn new(
        case: &Case,
        solid: &Solid,
        dofs: &DofMap,
        (held, timed): (&[Fix], &[TimedFix]),
        points: &PosedPoints,
    ) -> Result<Whole, Error> {
        if !has_ties(case) {
            return Ok(Whole::default());
        }
        let mut list = ties_of_equations(solid.mesh, dofs, &case.equations)?;
        let tied_dofs = list.iter().flat_map(|tie| tie.entries.keys()).collect::<HashSet<_>>().len();
        let mut sources: Vec<Source> = (0..list.len()).map(Source::Equation).collect();
        let (couplings, of_couplings) = couplings(solid, dofs, case, list.len())?;
        for (k, coupling) in couplings.iter().enumerate() {
            let by: HashMap<usize, [f64; 6]> = coupling.prescribed.iter().copied().collect();
            let source = |tie: usize| Source::Coupling(k, by.get(&tie).copied().unwrap_or_default());
            sources.extend(coupling.ties.clone().map(source));
        }
        list.extend(of_couplings);
        list.extend(ties_of_supports(solid.mesh, dofs, timed)?);
        sources.extend(sources_of_supports(case, timed));
        let taken: HashSet<u32> = points.nodes().chain(points.links().into_iter().flatten()).collect();
        let tied = Tied::new(dofs, list, &taken)?;
        let together = together(&tied.list);
        let whole = Whole { tied, sources, couplings, held: tied_dofs, together };
        whole.refuse_values(case, solid.mesh, held)?;
        whole.refuse_closed_chains(case, dofs, points)?;
        Ok(whole)
    }

    /// Multigrid measures each node from others, but for those of equations over many: none may be measured from itself in the end.
    fn refuse_closed_chains(&self, case: &Case, dofs: &DofMap, points: &PosedPoints) -> Result<(), Error> {
        let is_free = |dof: u32| dofs.unknown[dof as usize] != u32::MAX;
        let entries = |row: &BTreeMap<u32, f64>| -> Vec<f64> {
            row.iter().filter(|(dof, _)| is_free(**dof)).map(|(_, value)| *value).collect()
        };
        let is_over_many = |point: &&TiedPoint| point.rows.iter().any(|row| is_over_many(&entries(row)));
        let apart = self.tied.points.iter().filter(is_over_many);
        let rows = apart.flat_map(|point| &point.rows).filter(|row| !entries(row).is_empty()).count();
        let stay_out = rows <= MOST_EQUATIONS && !has_strength(case);
        let measured: Vec<&TiedPoint> =
            self.tied.points.iter().filter(|point| !stay_out || !is_over_many(point)).collect();
        let of_ties = measured.iter().filter_map(|point| link(point, &is_free));
        let all: Vec<Vec<u32>> = points.links().into_iter().chain(of_ties).collect();
        let mut left: HashMap<u32, &[u32]> = all.iter().map(|link| (link[0], &link[1..])).collect();
        loop {
            let ends = |others: &&[u32]| !others.iter().any(|v| left.contains_key(v));
            let open: HashSet<u32> = left.iter().filter(|(_, others)| ends(others)).map(|(v, _)| *v).collect();
            if open.is_empty() {
                break;
            }
            left.retain(|v, _| !open.contains(v));
        }
        let closed = measured.into_iter().find(|point| left.contains_key(&point.node));
        let made_of =
            |point: &TiedPoint| point.periods.iter().flat_map(|(_, rows)| rows).flat_map(BTreeMap::keys).max().copied();
        match closed.and_then(made_of) {
            None => Ok(()),
            Some(tie) => {
                let what =
                    "equations or couplings that share nodes so that displacements of each follow from the other";
                Err(scope::refused(&self.tied.list[tie].spot, what))
            }
        }
    }

    /// What is wrong with the values at the end of a planned increment, before anything is solved.
    fn refuse_values(&self, case: &Case, mesh: &Mesh, held: &[Fix]) -> Result<(), Error> {
        let mut times = planned(case);
        if times.is_empty() {
            times.push(end(case));
        }
        for t in times {
            let dofs = dof_map(mesh, held, t).map_err(|error| place::at(&case.mesh.spot, error))?;
            self.tied.values(&dofs, &[], t)?;
            self.couplings.iter().try_for_each(|coupling| coupling.load(t).map(|_| ()))?;
        }
        Ok(())
    }

    /// The node of each point that is measured from others, and then these, by the degrees of freedom that count.
    pub(super) fn links(&self, counts: &dyn Fn(u32) -> bool) -> Vec<Vec<u32>> {
        self.tied.points.iter().filter_map(|point| link(point, counts)).collect()
    }

    /// Nodes that go where another does, with that one: those that ties join where the one in their middle does, those that contact
    /// points are measured from, which `of_contacts` has, as there unless ties join them.
    pub(super) fn leaders(&self, mesh: &Mesh, of_contacts: Vec<[u32; 2]>) -> Vec<[u32; 2]> {
        let at = |v: u32| mesh.nodes[v as usize];
        let mut leader_of: BTreeMap<u32, u32> = BTreeMap::new();
        for list in self.together.iter().filter(|list| list.len() > 1) {
            let centre = mean(list.iter().map(|&v| at(v)));
            let distance = |v: u32| norm(sub(at(v), centre));
            let nearest = list.iter().copied().min_by(|&a, &b| distance(a).total_cmp(&distance(b)));
            let leader = nearest.unwrap_or(list[0]);
            leader_of.extend(list.iter().map(|&v| (v, leader)));
        }
        for [node, leader] in of_contacts {
            let leader = leader_of.get(&leader).copied().unwrap_or(leader);
            leader_of.entry(node).or_insert(leader);
        }
        leader_of.into_iter().filter(|(node, leader)| node != leader).map(|(node, leader)| [node, leader]).collect()
    }

    /// As a message to a rank: `place` is that of a node in its piece, `is_own` whether a node is one of this rank.
    pub(super) fn message(&self, place: &dyn Fn(u32) -> Option<u32>, is_own: &dyn Fn(u32) -> bool) -> Vec<u8> {
        let Tied { list, points, redundant } = &self.tied;
        let mut to = vec![u8::from(!list.is_empty())];
        let is_here =
            |point: &&TiedPoint| point.rows.iter().flat_map(BTreeMap::keys).all(|dof| place(dof / 3).is_some());
        let points: Vec<&TiedPoint> = points.iter().filter(is_here).collect();
        // All nodes of a tie are those of one rank.
        let of_rank = |tie: &Tie| tie.entries.keys().next().is_some_and(|dof| is_own(dof / 3));
        let mut ties: BTreeSet<usize> = (0..list.len()).filter(|&k| of_rank(&list[k])).collect();
        let made_of = points.iter().flat_map(|point| &point.periods).flat_map(|(_, rows)| rows);
        ties.extend(made_of.flat_map(BTreeMap::keys));
        let ties: Vec<usize> = ties.into_iter().collect();
        let number = |k: usize| ties.binary_search(&k).ok().map(|k| k as u64);
        let here = |entries: &BTreeMap<u32, f64>| -> Vec<(u64, f64)> {
            let here =
                entries.iter().filter_map(|(&dof, &v)| Some((3 * u64::from(place(dof / 3)?) + u64::from(dof % 3), v)));
            here.collect()
        };
        put(&[ties.len() as u64], &mut to);
        for &k in &ties {
            put_tie(&list[k], self.sources[k], &mut to);
            put_pairs(here(&list[k].entries), &mut to);
        }
        put(&[points.len() as u64], &mut to);
        for TiedPoint { node, rows, periods } in points {
            put(&[place(*node).unwrap_or_default().into(), rows.len() as u64], &mut to);
            rows.iter().for_each(|row| put_pairs(here(row), &mut to));
            put(&periods.iter().map(|(period, _)| *period).collect::<Vec<_>>(), &mut to);
            for made_of in periods.iter().flat_map(|(_, rows)| rows) {
                put_pairs(made_of.iter().filter_map(|(&k, &v)| Some((number(k)?, v))).collect(), &mut to);
            }
        }
        let own = |redundant: &&Redundant| of_rank(&list[redundant.tie]);
        let redundant: Vec<&Redundant> = redundant.iter().filter(own).collect();
        put(&[redundant.len() as u64], &mut to);
        for Redundant { period, tie, made_of, held } in redundant {
            put(period, &mut to);
            put(&[number(*tie).unwrap_or_default()], &mut to);
            put_pairs(made_of.iter().filter_map(|&(k, v)| Some((number(k)?, v))).collect(), &mut to);
            put_pairs(here(&held.iter().copied().collect()), &mut to);
        }
        for coupling in &self.couplings {
            for column in &coupling.columns {
                put(&[u8::from(column.is_some())], &mut to);
                let column = column.iter().flatten();
                let (nodes, vectors): (Vec<u32>, Vec<V3>) = column.filter_map(|(v, x)| Some((place(*v)?, *x))).unzip();
                put(&nodes, &mut to);
                put(&vectors, &mut to);
            }
            let own = coupling.prescribed.iter().filter(|(tie, _)| of_rank(&list[*tie]));
            let (ties, by): (Vec<u64>, Vec<[f64; 6]>) = own.filter_map(|(k, by)| Some((number(*k)?, *by))).unzip();
            put(&ties, &mut to);
            put(&by, &mut to);
        }
        to
    }
}

impl Here {
    /// Takes it out of a message of [`Whole::message`].
    pub(super) fn take(case: &Case, from: &mut &[u8]) -> Here {
        let (has, rest) = from.split_at(1);
        *from = rest;
        let one = |from: &mut &[u8]| take::<u64>(from)[0];
        let count = one(from);
        let list = (0..count).map(|_| take_tie(case, from)).collect();
        let count = one(from);
        let point = |from: &mut &[u8]| {
            let [node, rows] = <[u64; 2]>::try_from(take::<u64>(from)).unwrap_or_default();
            let of = |from: &mut &[u8]| take_pairs(from).map(|(dof, v)| (dof as u32, v)).collect();
            let rows: Vec<BTreeMap<u32, f64>> = (0..rows).map(|_| of(from)).collect();
            let times: Vec<[f64; 2]> = take(from);
            let mut made_of = || take_pairs(from).map(|(k, v)| (k as usize, v)).collect();
            let period = |period| (period, rows.iter().map(|_| made_of()).collect());
            let periods = times.into_iter().map(period).collect();
            TiedPoint { node: node as u32, rows, periods }
        };
        let points = (0..count).map(|_| point(from)).collect();
        let count = one(from);
        let one_redundant = |from: &mut &[u8]| {
            let period = <[f64; 2]>::try_from(take::<f64>(from)).unwrap_or(ALWAYS);
            let tie = one(from) as usize;
            let made_of = take_pairs(from).map(|(k, v)| (k as usize, v)).collect();
            let held = take_pairs(from).map(|(dof, v)| (dof as u32, v)).collect();
            Redundant { period, tie, made_of, held }
        };
        let redundant = (0..count).map(|_| one_redundant(from)).collect();
        let tied = Some(Tied { list, points, redundant }).filter(|_| has == [1]);
        let coupling = |spec: &CouplingSpec| {
            let column = |_: usize| -> Option<Column> {
                let told = take::<u8>(from) == [1];
                let (nodes, vectors): (Vec<u32>, Vec<V3>) = (take(from), take(from));
                told.then(|| nodes.into_iter().zip(vectors).collect())
            };
            let mut coupling = Coupling::new(spec, std::array::from_fn(column), 0);
            let (ties, by): (Vec<u64>, Vec<[f64; 6]>) = (take(from), take(from));
            coupling.prescribed = ties.into_iter().map(|k| k as usize).zip(by).collect();
            coupling
        };
        Here { tied, couplings: case.couplings.iter().map(coupling).collect() }
    }
}

/// The state of each reference point in an answer at time `t`, the same at every rank.
pub(super) fn coupling_states(local: &Local, here: &Everywhere, t: f64) -> Vec<CouplingState> {
    let Local { couplings, timed, division, .. } = local;
    let of_ties = timed.forces(&here.lambda, t);
    let own = |v: u32| if division.is_own(v) { here.u[v as usize] } else { [0.0; 3] };
    let part = |coupling: &Coupling| -> [[f64; 6]; 2] {
        let mut reaction = [0.0; 6];
        for (tie, by) in &coupling.prescribed {
            reaction.iter_mut().zip(by).for_each(|(sum, by)| *sum += of_ties[*tie] * by);
        }
        [coupling.motion(own), reaction]
    };
    let mut parts: Vec<[[f64; 6]; 2]> = couplings.iter().map(part).collect();
    sum(&*division.ranks, parts.as_flattened_mut().as_flattened_mut());
    couplings
        .iter()
        .zip(parts)
        .map(|(coupling, [motion, reaction])| CouplingState::new(coupling, motion, reaction, t))
        .collect()
}

/// The node of a point that is measured from others, and then these.
fn link(point: &TiedPoint, counts: &dyn Fn(u32) -> bool) -> Option<Vec<u32>> {
    let dofs = point.rows.iter().flat_map(BTreeMap::keys).filter(|dof| counts(**dof));
    let reached: BTreeSet<u32> = dofs.map(|dof| dof / 3).filter(|&v| v != point.node).collect();
    (!reached.is_empty()).then(|| std::iter::once(point.node).chain(reached).collect())
}

/// Whether a contact may have a tensile strength somewhere.
fn has_strength(case: &Case) -> bool {
    case.contacts.iter().any(|contact| match &contact.friction {
        SurfaceFriction::Law(law) => {
            law.cohesion.as_ref().is_some_and(|it| it.tension != Coefficient::Field(Field::Constant(0.0)))
        }
        _ => false,
    })
}

/// The nodes of ties that share one, those of which a support holds all among them.
fn together(ties: &[Tie]) -> Vec<Vec<u32>> {
    let mut parent: HashMap<u32, u32> = HashMap::new();
    fn root(parent: &mut HashMap<u32, u32>, mut v: u32) -> u32 {
        while let Some(&above) = parent.get(&v).filter(|above| **above != v) {
            let next = parent.get(&above).copied().unwrap_or(above);
            parent.insert(v, next);
            v = next;
        }
        v
    }
    let mut nodes: BTreeSet<u32> = BTreeSet::new();
    for tie in ties {
        let mut of_tie = tie.entries.keys().map(|dof| dof / 3);
        let Some(first) = of_tie.next() else { continue };
        nodes.insert(first);
        for v in of_tie {
            nodes.insert(v);
            let (a, b) = (root(&mut parent, first), root(&mut parent, v));
            parent.insert(a.max(b), a.min(b));
        }
    }
    let mut lists: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
    nodes.into_iter().for_each(|v| lists.entry(root(&mut parent, v)).or_default().push(v));
    lists.into_values().collect()
}

/// In the order of [`ties_of_supports`].
fn sources_of_supports(case: &Case, timed: &[TimedFix]) -> Vec<Source> {
    let numbers = (0..case.fixes.len()).filter(|&k| case.fixes[k].during.period(&case.steps) != ALWAYS);
    let of_support = |(k, support): (usize, &TimedFix)| {
        let components: Vec<usize> = (0..3).filter(|&c| support.fix.value[c].is_some()).collect();
        let at_node = move |_: &u32| components.clone().into_iter().map(move |c| Source::Support(k, c));
        support.fix.nodes.iter().flat_map(at_node).collect::<Vec<Source>>()
    };
    numbers.zip(timed).flat_map(of_support).collect()
}

/// All of a tie but its entries.
fn put_tie(tie: &Tie, source: Source, to: &mut Vec<u8>) {
    let (names, by) = match source {
        Source::Equation(k) => ([0, k, 0], [0.0; 6]),
        Source::Coupling(k, by) => ([1, k, 0], by),
        Source::Support(k, c) => ([2, k, c], [0.0; 6]),
    };
    let (start, until) = match tie.start {
        Start::AtOnce => (0, 0.0),
        Start::Stays => (1, 0.0),
        Start::Until(until) => (2, until),
    };
    let [kind, number, component] = names.map(|name| name as u64);
    put(&[kind, number, component, start, u64::from(tie.is_support)], to);
    by.write(to);
    [tie.period[0], tie.period[1], tie.at[0], tie.at[1], tie.at[2], until].write(to);
}

/// With its entries.
fn take_tie(case: &Case, from: &mut &[u8]) -> Tie {
    let [kind, number, component, start, is_support] = <[u64; 5]>::try_from(take::<u64>(from)).unwrap_or_default();
    let (numbers, rest) = from.split_at(12 * f64::SIZE);
    *from = rest;
    let [by, [begin, end, x, y, z, until]] = <[[f64; 6]; 2]>::read(numbers);
    let (number, component) = (number as usize, component as usize);
    let (value, spot): (Vec<(f64, Field)>, &Spot) = match kind {
        0 => (vec![(1.0, case.equations[number].value.clone())], &case.equations[number].spot),
        1 => {
            let spec = &case.couplings[number];
            let parts = (0..6).filter(|&k| by[k] != 0.0);
            (parts.filter_map(|k| Some((by[k], prescribed(spec, k)?))).collect(), &spec.spot)
        }
        _ => {
            let FixSpec { value, spot, .. } = &case.fixes[number];
            (vec![(1.0, value[component].clone().unwrap_or(Field::Constant(0.0)))], spot)
        }
    };
    let start = match start {
        0 => Start::AtOnce,
        1 => Start::Stays,
        _ => Start::Until(until),
    };
    let entries = take_pairs(from).map(|(dof, v)| (dof as u32, v)).collect();
    let (at, period, is_support) = ([x, y, z], [begin, end], is_support == 1);
    Tie { at, period, start, is_support, ..Tie::always(entries, value, spot.clone()) }
}

fn put_pairs(list: Vec<(u64, f64)>, to: &mut Vec<u8>) {
    let (numbers, values): (Vec<u64>, Vec<f64>) = list.into_iter().unzip();
    put(&numbers, to);
    put(&values, to);
}

fn take_pairs(from: &mut &[u8]) -> impl Iterator<Item = (u64, f64)> + use<> {
    let numbers: Vec<u64> = take(from);
    numbers.into_iter().zip(take::<f64>(from))
}
