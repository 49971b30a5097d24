//! The order in which nodes are measured from one another, and nodes that are measured from one another in a cycle.

use std::collections::BTreeMap;

use super::blocks::Block;
use super::dense::add_product;

/// A row of a matrix of blocks: columns and blocks.
pub(super) type Entries = Vec<(u32, Block<3, 3>)>;

/// What is smaller is rounding of an inverse, whose diagonal blocks are about one.
const ROUNDING: f64 = 1e-17;
/// Powers of `C` after which a cycle whose inverse has not come to rest is refused: each loses half at least where contacts carry for nodes of
/// one another.
const MOST_POWERS: usize = 200;

/// Rows that name one another, and the inverse of `I + C` among them.
#[derive(Debug, Clone)]
pub(super) struct Cycle {
    /// The rows, ascending.
    pub rows: Vec<u32>,
    /// The rows of the inverse: columns are places in `rows`.
    pub inverse: Vec<Entries>,
}

/// One row, or a cycle of them.
#[derive(Debug, Clone)]
pub(super) enum Link {
    Row(u32),
    Cycle(Box<Cycle>),
}

/// The rows in an order in which each comes before those it names, those of a cycle together; `None` if a cycle can not be inverted.
/// `place` has the row of each node.
pub(super) fn order(place: &[u32], rows: &[Entries]) -> Option<Vec<Link>> {
    let named = |i: u32| rows[i as usize].iter().map(|(k, _)| place[*k as usize]).filter(|&p| p != u32::MAX);
    let order = sorted(rows.len(), named);
    if order.len() == rows.len() {
        return Some(order.into_iter().map(Link::Row).collect());
    }
    let (group, members) = components(rows.len(), &named);
    let of_group = |g: u32| {
        let members = members[g as usize].iter();
        members.flat_map(|&i| named(i)).map(|p| group[p as usize]).filter(move |&other| other != g)
    };
    let link = |g: u32| match &members[g as usize][..] {
        &[row] if named(row).all(|p| p != row) => Some(Link::Row(row)),
        members => {
            let mut members = members.to_vec();
            members.sort_unstable();
            Some(Link::Cycle(Box::new(Cycle { inverse: inverse(place, rows, &members)?, rows: members })))
        }
    };
    sorted(members.len(), of_group).into_iter().map(link).collect()
}

/// The numbers below `count` in an order in which each comes before those it names; without those of cycles and what they lead to.
fn sorted<I: Iterator<Item = u32>>(count: usize, named: impl Fn(u32) -> I) -> Vec<u32> {
    let mut waits_for = vec![0u32; count];
    (0..count as u32).flat_map(&named).for_each(|p| waits_for[p as usize] += 1);
    let mut order: Vec<u32> = (0..count as u32).filter(|&i| waits_for[i as usize] == 0).collect();
    let mut next = 0;
    while let Some(&i) = order.get(next) {
        next += 1;
        for p in named(i) {
            waits_for[p as usize] -= 1;
            if waits_for[p as usize] == 0 {
                order.push(p);
            }
        }
    }
    order
}

/// The strongly connected component of each number below `count` and the members of each component (Kosaraju & Sharir).
fn components<I: Iterator<Item = u32>>(count: usize, named: &impl Fn(u32) -> I) -> (Vec<u32>, Vec<Vec<u32>>) {
    let mut back: Vec<Vec<u32>> = vec![Vec::new(); count];
    (0..count as u32).for_each(|i| named(i).for_each(|p| back[p as usize].push(i)));
    let (mut finished, mut seen) = (Vec::with_capacity(count), vec![false; count]);
    for first in 0..count as u32 {
        let mut open =
            if std::mem::replace(&mut seen[first as usize], true) { Vec::new() } else { vec![(first, named(first))] };
        while let Some((i, rest)) = open.last_mut() {
            match rest.find(|&p| !std::mem::replace(&mut seen[p as usize], true)) {
                Some(p) => open.push((p, named(p))),
                None => {
                    finished.push(*i);
                    open.pop();
                }
            }
        }
    }
    let (mut group, mut members) = (vec![u32::MAX; count], Vec::new());
    for first in finished.into_iter().rev() {
        if group[first as usize] != u32::MAX {
            continue;
        }
        let (mut open, mut found) = (vec![first], Vec::new());
        group[first as usize] = members.len() as u32;
        while let Some(i) = open.pop() {
            found.push(i);
            for &from in &back[i as usize] {
                if group[from as usize] == u32::MAX {
                    group[from as usize] = members.len() as u32;
                    open.push(from);
                }
            }
        }
        members.push(found);
    }
    (group, members)
}

/// The rows of `(I + C)⁻¹` among these rows of `C`, by powers of `C`, which fade away along the cycle; `None` if they do not.
fn inverse(place: &[u32], rows: &[Entries], members: &[u32]) -> Option<Vec<Entries>> {
    let at = |node: u32| members.binary_search(&place[node as usize]).ok();
    let within = |i: &u32| rows[*i as usize].iter().filter_map(|(k, block)| Some((at(*k)?, *block))).collect();
    let c: Vec<Vec<(usize, Block<3, 3>)>> = members.iter().map(within).collect();
    let unit: Block<3, 3> = std::array::from_fn(|r| std::array::from_fn(|c| f64::from(u8::from(r == c))));
    let row = |i: usize| {
        let mut power = BTreeMap::from([(i, unit)]);
        let mut sum = power.clone();
        for _ in 0..MOST_POWERS {
            let mut next: BTreeMap<usize, Block<3, 3>> = BTreeMap::new();
            for (k, block) in &power {
                let minus = block.map(|r| r.map(|v| -v));
                c[*k].iter().for_each(|(j, c)| add_product(&minus, c, next.entry(*j).or_default()));
            }
            next.retain(|_, block| block.iter().flatten().any(|v| v.abs() > ROUNDING));
            if next.is_empty() {
                return Some(sum.into_iter().map(|(k, block)| (k as u32, block)).collect());
            }
            for (k, block) in &next {
                let own: &mut Block<3, 3> = sum.entry(*k).or_default();
                own.iter_mut().flatten().zip(block.iter().flatten()).for_each(|(sum, v)| *sum += v);
            }
            power = next;
        }
        None
    };
    (0..members.len()).map(row).collect()
}

/// A block times a row.
pub(super) fn product<'a>(a: &'a Block<3, 3>, row: &'a Entries) -> impl Iterator<Item = (u32, Block<3, 3>)> + 'a {
    row.iter().map(move |(j, block)| {
        let mut product = [[0.0; 3]; 3];
        add_product(a, block, &mut product);
        (*j, product)
    })
}

/// The rows of `D` of a cycle: the inverse times the rows of what it names outside, `row` of these, and `I` less the inverse within.
pub(super) fn rows_of_cycle(
    cycle: &Cycle,
    (nodes, place): (&[u32], &[u32]),
    rows: &[Entries],
    row: impl Fn(Entries) -> Entries,
) -> Vec<Entries> {
    let is_within = |k: u32| cycle.rows.binary_search(&place[k as usize]).is_ok();
    let outside = |i: &u32| row(rows[*i as usize].iter().filter(|(k, _)| !is_within(*k)).copied().collect());
    let outside: Vec<Entries> = cycle.rows.iter().map(outside).collect();
    let of = |(t, inverse): (usize, &Entries)| {
        let within = inverse.iter().map(|(h, block)| {
            let own = |r: usize, c: usize| f64::from(u8::from(*h as usize == t && r == c));
            let rest = std::array::from_fn(|r| std::array::from_fn(|c| own(r, c) - block[r][c]));
            (nodes[cycle.rows[*h as usize] as usize], rest)
        });
        summed(within.chain(inverse.iter().flat_map(|(h, block)| product(block, &outside[*h as usize]))).collect())
    };
    cycle.inverse.iter().enumerate().map(of).collect()
}

/// A row with one entry a column.
pub(super) fn summed(mut row: Entries) -> Entries {
    row.sort_by_key(|entry| entry.0);
    row.dedup_by(|next, kept| {
        let same = next.0 == kept.0;
        if same {
            kept.1.iter_mut().flatten().zip(next.1.iter().flatten()).for_each(|(sum, b)| *sum += b);
        }
        same
    });
    row
}
