//! What of a problem one rank measures, and the values it needs of others.

use std::collections::{HashMap, HashSet};

use crate::contact::{ContactProblem, Division};
use crate::ranks::{self, all_to_all, from_bytes, to_bytes};

use super::point::Point;

/// The unknowns, prescribed displacements and contact points that this rank counts; all of them where nothing is divided.
pub(super) struct Share<'a> {
    division: Option<&'a Division>,
    unknown: Vec<bool>,
    support: Vec<bool>,
    point: Vec<bool>,
}

impl<'a> Share<'a> {
    /// Everything, on one rank.
    pub(super) fn whole() -> Self {
        Share { division: None, unknown: Vec::new(), support: Vec::new(), point: Vec::new() }
    }

    /// What is at own nodes.
    pub(super) fn of(problem: &ContactProblem, division: &'a Division) -> Self {
        let labels = problem.elastic.node_of.as_deref().unwrap_or_default();
        Share {
            division: Some(division),
            unknown: labels.iter().map(|&label| division.is_own(label)).collect(),
            support: division.supports.iter().map(|&label| division.is_own(label)).collect(),
            point: division.points.iter().map(|&label| division.is_own(label)).collect(),
        }
    }

    pub(super) fn is_whole(&self) -> bool {
        self.division.is_none()
    }

    fn has(&self, list: &[bool], i: usize) -> bool {
        self.is_whole() || list[i]
    }

    pub(super) fn has_unknown(&self, i: usize) -> bool {
        self.has(&self.unknown, i)
    }

    pub(super) fn has_support(&self, i: usize) -> bool {
        self.has(&self.support, i)
    }

    pub(super) fn has_point(&self, j: usize) -> bool {
        self.has(&self.point, j)
    }

    /// The points that count, of all.
    pub(super) fn points<'p>(&'p self, points: &'p [Point]) -> impl Iterator<Item = &'p Point> {
        points.iter().enumerate().filter(|(j, _)| self.has_point(*j)).map(|(_, point)| point)
    }

    /// The values at unknowns that count, of all.
    pub(super) fn unknowns<'p>(&'p self, values: &'p [f64]) -> impl Iterator<Item = &'p f64> {
        values.iter().enumerate().filter(|(i, _)| self.has_unknown(*i)).map(|(_, value)| value)
    }

    /// Whether all that counts is a number.
    pub(super) fn is_finite(&self, u: &[f64], lambda: &[f64]) -> bool {
        let m = (lambda.len() / 3).max(1);
        let mut forces = lambda.iter().enumerate().filter(|(i, _)| self.has_point(i % m));
        self.unknowns(u).all(|x| x.is_finite()) && forces.all(|(_, x)| x.is_finite())
    }

    /// Adds the numbers of all ranks.
    pub(super) fn sum(&self, values: &mut [f64]) {
        self.division.iter().for_each(|division| ranks::sum(&*division.ranks, values));
    }

    /// The largest of those of all ranks.
    pub(super) fn max(&self, values: &mut [f64]) {
        self.division.iter().for_each(|division| ranks::max(&*division.ranks, values));
    }

    /// The values at all unknowns here, where those that count are known.
    pub(super) fn filled(&self, problem: &ContactProblem, u: Vec<f64>) -> Vec<f64> {
        match self.division {
            Some(division) => fetched(problem, division, &u, &vec![0.0; 3 * problem.points()]).0,
            None => u,
        }
    }

    /// The unknowns of other ranks that rows of points which count here reach.
    pub(super) fn border(&self, problem: &ContactProblem) -> Border<'a> {
        let Some(division) = self.division else { return Border::default() };
        let labels = problem.elastic.node_of.as_deref().unwrap_or_default();
        let names = names_of_unknowns(division, labels);
        let mut reached: Vec<usize> = Vec::new();
        for j in (0..problem.points()).filter(|&j| self.has_point(j)) {
            for i in problem.rows(j) {
                let (columns, _) = problem.contact.B.row(i);
                reached.extend(columns.iter().map(|&c| c as usize).filter(|&c| !self.has_unknown(c)));
            }
        }
        reached.sort_unstable();
        reached.dedup();
        let ranks = &*division.ranks;
        let mut others: Vec<Vec<usize>> = vec![Vec::new(); ranks.size()];
        reached.iter().for_each(|&i| others[division.owner[labels[i] as usize] as usize].push(i));
        let asked = others.iter().map(|list| to_bytes(&list.iter().map(|&i| names[i]).collect::<Vec<Name>>()));
        let wanted: Vec<Vec<Name>> = all_to_all(ranks, asked.collect()).iter().map(|bytes| from_bytes(bytes)).collect();
        let mut place: HashMap<Name, usize> = wanted.iter().flatten().map(|name| (*name, usize::MAX)).collect();
        for (i, name) in names.iter().enumerate().filter(|(i, _)| self.has_unknown(*i)) {
            place.get_mut(name).into_iter().for_each(|place| *place = i);
        }
        let own = wanted.iter().map(|list| list.iter().map(|name| place[name]).collect()).collect();
        Border { division: Some(division), others, own }
    }
}

/// Unknowns of other ranks, which change here, and own ones that change on others; of each rank, in one order on both sides.
#[derive(Default)]
pub(super) struct Border<'a> {
    division: Option<&'a Division>,
    others: Vec<Vec<usize>>,
    own: Vec<Vec<usize>>,
}

impl Border<'_> {
    /// Adds to own values what other ranks have added to theirs since all had `before`, and takes the sums for those of others.
    pub(super) fn add(&self, before: &[f64], values: &mut [f64]) {
        let Some(division) = self.division else { return };
        let ranks = &*division.ranks;
        let sent = |list: &Vec<usize>| to_bytes(&list.iter().map(|&i| values[i] - before[i]).collect::<Vec<f64>>());
        let added = all_to_all(ranks, self.others.iter().map(sent).collect());
        for (list, bytes) in self.own.iter().zip(&added) {
            let more = from_bytes::<f64>(bytes);
            list.iter().zip(more).for_each(|(&i, more)| values.get_mut(i).into_iter().for_each(|value| *value += more));
        }
        let known = |list: &Vec<usize>| {
            to_bytes(&list.iter().map(|&i| values.get(i).copied().unwrap_or(f64::NAN)).collect::<Vec<f64>>())
        };
        let answers = all_to_all(ranks, self.own.iter().map(known).collect());
        for (list, bytes) in self.others.iter().zip(&answers) {
            list.iter().zip(from_bytes::<f64>(bytes)).for_each(|(&i, value)| values[i] = value);
        }
    }
}

/// Displacements and multipliers with the values of other ranks in their places, asked of the owner of each node by its global
/// number. What the owner does not know is not a number, and no certificate passes with it.
pub(crate) fn fetched(
    problem: &ContactProblem,
    division: &Division,
    u: &[f64],
    lambda: &[f64],
) -> (Vec<f64>, Vec<f64>) {
    let ranks = &*division.ranks;
    let labels = problem.elastic.node_of.as_deref().unwrap_or_default();
    let global = |label: u32| division.global[label as usize];
    // The unknowns of a node, and its points, are named by their order at the node: it is the same on every rank.
    let unknowns = names_of_unknowns(division, labels);
    let nodes = &division.points;
    let mut points: Vec<Name> = Vec::with_capacity(nodes.len());
    for (number, pair) in problem.labels.pairs.iter().enumerate() {
        let mut of_point = Names::of(division.global.len());
        let named =
            nodes[pair.points.clone()].iter().map(|&label| of_point.next(1 + number as u64, label, global(label)));
        points.extend(named);
    }
    let own = |label: u32| division.is_own(label);
    let m = problem.points();
    // What is asked of each rank, with where it goes.
    let mut asked: Vec<Vec<(Name, usize)>> = vec![Vec::new(); ranks.size()];
    for (i, &label) in labels.iter().enumerate().filter(|(_, label)| !own(**label)) {
        asked[division.owner[label as usize] as usize].push((unknowns[i], i));
    }
    for (j, &label) in nodes.iter().enumerate().filter(|(_, label)| !own(**label)) {
        asked[division.owner[label as usize] as usize].push((points[j], u.len() + j));
    }
    let names = |list: &Vec<(Name, usize)>| to_bytes(&list.iter().map(|(name, _)| *name).collect::<Vec<Name>>());
    let questions = all_to_all(ranks, asked.iter().map(names).collect());
    let wanted: HashSet<Name> = questions.iter().flat_map(|bytes| from_bytes::<Name>(bytes)).collect();
    let mut known: HashMap<Name, [f64; 3]> = HashMap::with_capacity(wanted.len());
    for (i, name) in unknowns.iter().enumerate().filter(|&(i, name)| own(labels[i]) && wanted.contains(name)) {
        known.insert(*name, [u[i], 0.0, 0.0]);
    }
    for (j, name) in points.iter().enumerate().filter(|&(j, name)| own(nodes[j]) && wanted.contains(name)) {
        known.insert(*name, [0, 1, 2].map(|r| lambda[r * m + j]));
    }
    let answer = |bytes: &Vec<u8>| -> Vec<u8> {
        let values =
            from_bytes::<Name>(bytes).into_iter().map(|name| known.get(&name).copied().unwrap_or([f64::NAN; 3]));
        to_bytes(&values.collect::<Vec<_>>())
    };
    let answers = all_to_all(ranks, questions.iter().map(answer).collect());
    let (mut u, mut lambda) = (u.to_vec(), lambda.to_vec());
    for (list, bytes) in asked.iter().zip(&answers) {
        for (&(_, place), values) in list.iter().zip(from_bytes::<[f64; 3]>(bytes)) {
            match place.checked_sub(u.len()) {
                None => u[place] = values[0],
                Some(j) => (0..3).for_each(|r| lambda[r * m + j] = values[r]),
            }
        }
    }
    (u, lambda)
}

/// Zero for an unknown and one more than the number of its pair for a point, the number of its node among those of all ranks,
/// and which of the node's own it is.
type Name = [u64; 3];

fn names_of_unknowns(division: &Division, labels: &[u32]) -> Vec<Name> {
    let mut names = Names::of(division.global.len());
    labels.iter().map(|&label| names.next(0, label, division.global[label as usize])).collect()
}

/// Counts what has been named at each node here.
struct Names(Vec<u8>);

impl Names {
    fn of(nodes: usize) -> Names {
        Names(vec![0; nodes])
    }

    fn next(&mut self, kind: u64, label: u32, node: u64) -> Name {
        let count = &mut self.0[label as usize];
        *count += 1;
        [kind, node, u64::from(*count - 1)]
    }
}
