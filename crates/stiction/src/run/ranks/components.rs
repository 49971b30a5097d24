//! Bodies of a mesh that no rank has as a whole.

use std::collections::HashMap;

use super::cells::{CellList, Kinds};
use super::homes::{Homes, Plan};
use crate::contact::Body;
use crate::mesh::{Mesh, ascending, bodies};
use crate::ranks::{Ranks, from_bytes, gather, gather_all, max, to_bytes};

/// The body of each node that this rank keeps, numbered by their lowest nodes, and how many there are. `mesh` has cells of all ranks
/// together, whose nodes the `plan` is for.
///
/// Each node is labelled with the lowest number that is known to hang together with it. Cells spread the lowest label among their
/// nodes, what was labelled otherwise takes it over, and labels take those of their own nodes: a few rounds, whatever the length of
/// a body.
pub(super) fn bodies_of_nodes(
    ranks: &dyn Ranks,
    homes: &Homes,
    (plan, mesh): (&Plan, &Mesh),
    own: usize,
) -> (Vec<u32>, usize) {
    let component = bodies(mesh);
    let count = component.iter().max().map_or(0, |&last| last as usize + 1);
    let mut label: Vec<u64> = (homes.first()..).take(own).collect();
    loop {
        let before = label.clone();
        let here = plan.fetch(ranks, &label);
        let mut least = vec![u64::MAX; count];
        here.iter().zip(&component).for_each(|(&label, &c)| least[c as usize] = least[c as usize].min(label));
        let lower = |(v, (&label, &c)): (u32, (&u64, &u32))| {
            let least = least[c as usize];
            (least < label).then_some((v, label, least))
        };
        let lower: Vec<(u32, u64, u64)> = (0..).zip(here.iter().zip(&component)).filter_map(lower).collect();
        let of_nodes: Vec<(u32, u64)> = lower.iter().map(|&(v, _, least)| (v, least)).collect();
        let mut take = |told: Vec<(u32, u64)>| {
            told.into_iter().for_each(|(place, least)| label[place as usize] = label[place as usize].min(least));
        };
        take(plan.tell_some(ranks, &of_nodes));
        let mut hooks: Vec<(u64, u64)> = ascending(lower.iter().map(|&(_, label, least)| (label, least)));
        hooks.dedup_by_key(|(label, _)| *label);
        let (olds, news): (Vec<u64>, Vec<u64>) = hooks.into_iter().unzip();
        take(Plan::new(ranks, homes, &olds).tell(ranks, &news));
        let labels = ascending(label.iter().copied());
        let above = Plan::new(ranks, homes, &labels).fetch(ranks, &label);
        label.iter_mut().for_each(|label| *label = above[labels.partition_point(|other| other < label)]);
        let mut moved = [f64::from(u8::from(label != before))];
        max(ranks, &mut moved);
        if moved[0] == 0.0 {
            break;
        }
    }
    let roots: Vec<u64> = label.iter().copied().zip(homes.first()..).filter(|(l, v)| l == v).map(|(l, _)| l).collect();
    let roots: Vec<u64> =
        gather_all(ranks, to_bytes(&roots)).iter().flat_map(|message| from_bytes::<u64>(message)).collect();
    let body = |label: &u64| roots.partition_point(|root| root < label) as u32;
    (label.iter().map(body).collect(), roots.len())
}

/// The bodies, at rank 0, by the names of the groups of cells they are, otherwise by their numbers. Their places and sizes are left
/// to who has all nodes. The cells are each on one rank; `groups` are the names, `classes` the groups that cells of each class are in.
pub(super) fn named(
    ranks: &dyn Ranks,
    cells: impl Iterator<Item = [u32; 2]>,
    (groups, classes): (&[String], &[Vec<u32>]),
    count: usize,
) -> Vec<Body> {
    let mut counts: HashMap<[u32; 2], u64> = HashMap::new();
    cells.for_each(|key| *counts.entry(key).or_default() += 1);
    let list: Vec<[u64; 3]> = counts.into_iter().map(|([body, class], n)| [body.into(), class.into(), n]).collect();
    let mut of_bodies = vec![0; count];
    let mut of_groups = vec![0; groups.len()];
    // Cells of a body in a group.
    let mut both: HashMap<[u64; 2], u64> = HashMap::new();
    for message in gather(ranks, to_bytes(&list)).unwrap_or_default() {
        for [body, class, n] in from_bytes::<[u64; 3]>(&message) {
            of_bodies[body as usize] += n;
            for &group in &classes[class as usize] {
                of_groups[group as usize] += n;
                *both.entry([body, group.into()]).or_default() += n;
            }
        }
    }
    // The first group that is a body gives it its name.
    let mut names: Vec<Option<u64>> = vec![None; count];
    for ([body, group], n) in both {
        let (b, g) = (body as usize, group as usize);
        if n == of_bodies[b] && n == of_groups[g] {
            names[b] = Some(names[b].map_or(group, |other| other.min(group)));
        }
    }
    let body = |(number, name): (usize, Option<u64>)| Body {
        name: name.map_or_else(|| (number + 1).to_string(), |group| groups[group as usize].clone()),
        centre: [0.0; 3],
        radius: 0.0,
    };
    names.into_iter().enumerate().map(body).collect()
}

/// Body and class of each of some cells; the bodies are those of the nodes at `numbers`, which ascend.
pub(super) fn bodies_of_cells<'a>(
    cells: &'a CellList,
    kinds: &'a Kinds,
    (numbers, of_node): (&'a [u64], &'a [u32]),
) -> impl Iterator<Item = [u32; 2]> + 'a {
    let body = move |node: u64| of_node[numbers.partition_point(|&other| other < node)];
    cells.iter(kinds).map(move |(_, class, nodes)| [body(nodes[0]), class])
}
