use super::blocks::Blocks;
use super::dense::square;

/// No aggregate.
pub const NONE: u32 = u32::MAX;

/// For each stored block whether it couples two nodes strongly: `|A_ij|² > threshold² |A_ii| |A_jj|` (Frobenius
/// norms).
pub fn strong<const R: usize>(a: &Blocks<R, R>, threshold: f64) -> Vec<bool> {
    let own: Vec<f64> = (0..a.rows).map(|i| square(&a.diagonal(i)).sqrt()).collect();
    let mut strong = Vec::with_capacity(a.column.len());
    for i in 0..a.rows {
        let (columns, blocks) = a.row(i);
        strong.extend(columns.iter().zip(blocks).map(|(&j, block)| {
            let coupling = square(block);
            j as usize != i && coupling > 0.0 && coupling > threshold.powi(2) * own[i] * own[j as usize]
        }));
    }
    strong
}

/// The neighbours each node shares a kept block with, as compressed rows.
pub fn neighbours<const R: usize>(a: &Blocks<R, R>, kept: &[bool]) -> (Vec<usize>, Vec<u32>) {
    let (mut start, mut neighbour) = (vec![0], Vec::with_capacity(a.column.len()));
    for i in 0..a.rows {
        let places = (a.start[i]..a.start[i + 1]).filter(|&place| kept[place]);
        neighbour.extend(places.map(|place| a.column[place]));
        start.push(neighbour.len());
    }
    (start, neighbour)
}

/// Aggregates of strongly coupled nodes (Vanek, Mandel & Brezina 1996): whole neighbourhoods first, then what is
/// left joins a neighbouring aggregate, then the rest among itself. Returns the aggregate of each node and their
/// number; a node without strong neighbours makes one of its own.
pub fn aggregates(start: &[usize], neighbour: &[u32]) -> (Vec<u32>, usize) {
    let n = start.len() - 1;
    let neighbours = |i: usize| &neighbour[start[i]..start[i + 1]];
    let mut of = vec![NONE; n];
    let mut count = 0;
    for i in 0..n {
        let free = of[i] == NONE && neighbours(i).iter().all(|&j| of[j as usize] == NONE);
        if free && !neighbours(i).is_empty() {
            of[i] = count;
            neighbours(i).iter().for_each(|&j| of[j as usize] = count);
            count += 1;
        }
    }
    let first = of.clone();
    for i in 0..n {
        if of[i] == NONE
            && let Some(&j) = neighbours(i).iter().find(|&&j| first[j as usize] != NONE)
        {
            of[i] = first[j as usize];
        }
    }
    for i in 0..n {
        if of[i] == NONE {
            of[i] = count;
            for &j in neighbours(i) {
                if of[j as usize] == NONE {
                    of[j as usize] = count;
                }
            }
            count += 1;
        }
    }
    (of, count as usize)
}
