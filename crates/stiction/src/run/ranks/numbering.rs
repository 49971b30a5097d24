//! The numbers of nodes in the whole, from those that a file gives: nodes of no cell are left out, the others keep their order.

use super::homes::{Homes, Plan};
use crate::Error;
use crate::ranks::{Ranks, agree, all_to_all, from_bytes, max, sum, to_bytes};

/// Nothing has this number.
pub(super) const NONE: u64 = u64::MAX;

/// Where nodes are in the file, by the numbers that it gives them: `tags` are those of the nodes that this rank has read, in their
/// order, and `keys` ascend. [`NONE`] for what the file does not hold.
///
/// # Errors
/// If a number is given twice.
fn find(ranks: &dyn Ranks, file: &Homes, tags: &[u64], keys: &[u64]) -> Result<Vec<u64>, Error> {
    let counted = tags.iter().zip(file.first() + 1..).all(|(tag, number)| *tag == number);
    let mut gaps = [f64::from(u8::from(!counted))];
    max(ranks, &mut gaps);
    if gaps[0] == 0.0 {
        let index = |&key: &u64| if (1..=file.count()).contains(&key) { key - 1 } else { NONE };
        return Ok(keys.iter().map(index).collect());
    }
    // Each number is known to the rank that it is drawn for.
    let size = ranks.size();
    let rank = |key: u64| (key.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 32) as usize % size;
    let mut known = vec![Vec::new(); size];
    tags.iter().zip(file.first()..).for_each(|(&tag, index)| known[rank(tag)].push([tag, index]));
    let known = all_to_all(ranks, known.iter().map(|list| to_bytes(list)).collect());
    let mut table: Vec<[u64; 2]> = known.iter().flat_map(|message| from_bytes::<[u64; 2]>(message)).collect();
    table.sort_unstable();
    let twice = table.windows(2).find(|pair| pair[0][0] == pair[1][0]).map(|pair| pair[0][0]);
    let twice = twice.map(|tag| Error::new(format!("node {tag}"), "it is given more than once", DAMAGED));
    agree(ranks, twice.map_or(Ok(()), Err))?;
    let mut asked = vec![Vec::new(); size];
    keys.iter().for_each(|&key| asked[rank(key)].push(key));
    let index = |key: u64| table.binary_search_by_key(&key, |entry| entry[0]).map_or(NONE, |at| table[at][1]);
    let answer = |message: &Vec<u8>| to_bytes(&from_bytes(message).into_iter().map(index).collect::<Vec<u64>>());
    let asked = all_to_all(ranks, asked.iter().map(|list| to_bytes(list)).collect());
    let told = all_to_all(ranks, asked.iter().map(answer).collect());
    let mut told: Vec<_> = told.iter().map(|message| from_bytes::<u64>(message).into_iter()).collect();
    Ok(keys.iter().map(|&key| told[rank(key)].next().unwrap_or(NONE)).collect())
}

const DAMAGED: &str = "the file is damaged or incomplete; write it again";

/// Nodes of the whole.
pub(super) struct Numbering {
    pub homes: Homes,
    /// Which of the nodes that this rank has read belong to a cell: those that it keeps.
    pub used: Vec<bool>,
    /// The number in the whole of each key; [`NONE`] for a node of no cell.
    pub numbers: Vec<u64>,
}

/// Numbers the nodes that cells name; `keys` ascend, with whether a cell names each.
///
/// # Errors
/// If a number is given twice, or a key is none of a node.
pub(super) fn number(ranks: &dyn Ranks, tags: &[u64], keys: &[u64], named: &[bool]) -> Result<Numbering, Error> {
    let file = Homes::new(ranks, tags.len());
    let indices = find(ranks, &file, tags, keys)?;
    let missing =
        keys.iter().zip(&indices).find(|(_, index)| **index == NONE).map(|(key, _)| {
            Error::new("", format!("an element names node {key}, which the file does not hold"), DAMAGED)
        });
    agree(ranks, missing.map_or(Ok(()), Err))?;
    let mut order: Vec<u32> = (0..keys.len() as u32).collect();
    order.sort_unstable_by_key(|&k| indices[k as usize]);
    let sorted: Vec<u64> = order.iter().map(|&k| indices[k as usize]).collect();
    let plan = Plan::new(ranks, &file, &sorted);
    let mut used = vec![false; tags.len()];
    let flags: Vec<u8> = order.iter().map(|&k| u8::from(named[k as usize])).collect();
    plan.tell(ranks, &flags)
        .into_iter()
        .filter(|(_, flag)| *flag > 0)
        .for_each(|(place, _)| used[place as usize] = true);
    let own = used.iter().filter(|used| **used).count();
    let homes = Homes::new(ranks, own);
    let mut unused = [(used.len() - own) as f64];
    sum(ranks, &mut unused);
    if unused[0] == 0.0 {
        return Ok(Numbering { homes, used, numbers: indices });
    }
    let mut next = homes.first();
    let number = |used: &bool| {
        next += u64::from(*used);
        if *used { next - 1 } else { NONE }
    };
    let own: Vec<u64> = used.iter().map(number).collect();
    let mut numbers = vec![NONE; keys.len()];
    order.iter().zip(plan.fetch(ranks, &own)).for_each(|(&k, number)| numbers[k as usize] = number);
    Ok(Numbering { homes, used, numbers })
}
