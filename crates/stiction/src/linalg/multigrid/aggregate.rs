use rayon::prelude::*;

use super::blocks::Blocks;
use super::dense::square;
use crate::linalg::pattern::ROWS_PER_TASK;

/// No aggregate.
pub(super) const NONE: u32 = u32::MAX;

/// A mark for each stored block, by its row and its place among the values.
pub(super) fn marks<const R: usize>(a: &Blocks<R, R>, mark: impl Fn(usize, usize) -> bool + Sync) -> Vec<bool> {
    let tasks: Vec<usize> = (0..a.rows).step_by(ROWS_PER_TASK).collect();
    let of_task = |&first: &usize| -> Vec<bool> {
        let rows = first..a.rows.min(first + ROWS_PER_TASK);
        rows.flat_map(|i| (a.start[i]..a.start[i + 1]).map(move |place| (i, place))).map(|(i, p)| mark(i, p)).collect()
    };
    let parts: Vec<Vec<bool>> = tasks.par_iter().map(of_task).collect();
    parts.concat()
}

/// `|A_ii|` of all rows (Frobenius norms).
pub(super) fn diagonal_norms<const R: usize>(a: &Blocks<R, R>) -> Vec<f64> {
    (0..a.rows).into_par_iter().map(|i| square(&a.diagonal(i)).sqrt()).collect()
}

/// Blocks that couple two nodes strongly: `|A_ij|² > threshold² |A_ii| |A_jj|`, with the [`diagonal_norms`] `own` of all columns. So is a node
/// that is coupled with a single other one, however soft the spring between them: it follows that one.
pub(super) fn strong<const R: usize>(a: &Blocks<R, R>, own: &[f64], threshold: f64) -> Vec<bool> {
    let follows = |i: usize| i < a.rows && a.row(i).0.len() == 2;
    marks(a, |i, place| {
        let (j, coupling) = (a.column[place] as usize, square(&a.value[place]));
        let is_strong = coupling > threshold.powi(2) * own[i] * own[j];
        j != i && coupling > 0.0 && (is_strong || follows(i) || follows(j))
    })
}

/// The neighbours of this rank that each node shares a kept block with, as compressed rows.
pub(super) fn neighbours<const R: usize>(a: &Blocks<R, R>, kept: &[bool]) -> (Vec<usize>, Vec<u32>) {
    let (mut start, mut neighbour) = (vec![0], Vec::with_capacity(a.column.len()));
    for i in 0..a.rows {
        let places = (a.start[i]..a.start[i + 1]).filter(|&place| kept[place] && (a.column[place] as usize) < a.rows);
        neighbour.extend(places.map(|place| a.column[place]));
        start.push(neighbour.len());
    }
    (start, neighbour)
}

/// Fewest neighbours of a node that is coupled along three axes, on a face of the body. Along stretched cells there are fewer,
/// and those have to be centres: without this bound the small contact zones of the tests take 36 instead of 25 cycles.
const COUPLED_ALL_AROUND: usize = 5;

/// Most nodes of a connected component that is one aggregate. Lines through four layers of flat cells have five nodes: in two aggregates
/// each, they make a coarse matrix of 2.4 times the entries of the finest one, and with the exact coarse solution conjugate gradients take
/// 16 cycles either way.
const COMPONENT: usize = 6;
/// Fewest such components, of the largest size, that a mesh must have room for, on all ranks together: with fewer nodes its lines are
/// about as long as it is wide, and no lines of a plate. 300 random cases of some hundred nodes take 5,500 cycles so, and 6,090 where all lines are aggregates.
const COMPONENTS: usize = 300;

/// Aggregates of strongly coupled nodes (Vanek, Mandel & Brezina 1996): whole neighbourhoods first, then remaining nodes
/// join a neighbouring aggregate, then those still left form aggregates of their own. What hangs together in a few nodes only, such as a
/// line through a plate of flat cells, is one aggregate if there are enough nodes in `total`, those of other ranks included. Returns the
/// aggregate of each node and their number; a node without strong neighbours is an aggregate.
///
/// Nodes coupled along all axes whose neighbours all have more than twice as many neighbours come last among the centres of
/// neighbourhoods. Where cubes are cut into five tetrahedra each, half of the nodes have 6 neighbours and the others 18: around
/// the former aggregates would be half as large.
pub(super) fn aggregates(start: &[usize], neighbour: &[u32], total: usize) -> (Vec<u32>, usize) {
    let n = start.len() - 1;
    let neighbours = |i: usize| &neighbour[start[i]..start[i + 1]];
    let mut of = vec![NONE; n];
    let mut count = 0;
    let few = |i: usize| {
        let own = neighbours(i).len();
        own >= COUPLED_ALL_AROUND && neighbours(i).iter().all(|&j| neighbours(j as usize).len() > 2 * own)
    };
    for i in 0..n {
        if of[i] == NONE
            && let Some(line) = line_through(i, total, &neighbours)
        {
            line.iter().for_each(|&j| of[j as usize] = count);
            count += 1;
        }
    }
    for late in [false, true] {
        for i in 0..n {
            let free = of[i] == NONE && neighbours(i).iter().all(|&j| of[j as usize] == NONE);
            if free && !neighbours(i).is_empty() && (late || !few(i)) {
                of[i] = count;
                neighbours(i).iter().for_each(|&j| of[j as usize] = count);
                count += 1;
            }
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

/// Whether each node is in a short line, such as one through a plate of flat cells, which is an aggregate of its own.
pub(super) fn in_lines(start: &[usize], neighbour: &[u32], total: usize) -> Vec<bool> {
    let neighbours = |i: usize| &neighbour[start[i]..start[i + 1]];
    (0..start.len() - 1).into_par_iter().map(|i| line_through(i, total, &neighbours).is_some()).collect()
}

/// All nodes that a node is connected with, of `total`, if they are few and more than itself.
fn line_through<'n>(i: usize, total: usize, neighbours: &impl Fn(usize) -> &'n [u32]) -> Option<Vec<u32>> {
    if total < COMPONENTS * COMPONENT {
        return None;
    }
    let mut found = vec![i as u32];
    let mut next = 0;
    while let Some(&j) = found.get(next) {
        next += 1;
        for &k in neighbours(j as usize) {
            if !found.contains(&k) {
                found.push(k);
            }
        }
        if found.len() > COMPONENT {
            return None;
        }
    }
    (found.len() > 1).then_some(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_lines_of_a_plate_are_one_aggregate_each_and_others_are_cut() {
        let sizes = |lines: &[usize]| -> Vec<usize> {
            let (mut start, mut neighbour) = (vec![0], Vec::new());
            for &length in lines {
                let first = start.len() as u32 - 1;
                for i in 0..length as u32 {
                    neighbour.extend(i.checked_sub(1).map(|j| first + j));
                    neighbour.extend(Some(first + i + 1).filter(|_| i + 1 < length as u32));
                    start.push(neighbour.len());
                }
            }
            let (of, count) = aggregates(&start, &neighbour, start.len() - 1);
            let mut sizes = vec![0; count];
            of.iter().for_each(|&g| sizes[g as usize] += 1);
            sizes
        };
        let lines = COMPONENTS * COMPONENT / 5;
        assert_eq!(sizes(&vec![5; lines]), vec![5; lines]);
        for others in [sizes(&vec![11; lines]), sizes(&vec![5; lines / 2])] {
            assert!(others.iter().all(|size| (2..=4).contains(size)), "{others:?}");
        }
        assert_eq!(sizes(&[1, 1]), [1, 1]);
    }

    /// Cubes cut into five tetrahedra each, mirrored from one to the next: half of the nodes have edges along the axes only,
    /// the others along the diagonals of faces as well.
    #[test]
    fn aggregates_of_cut_cubes_are_around_the_nodes_with_many_neighbours() {
        let n = 20usize;
        let at = |x: [i64; 3]| (x[0] as usize * n + x[1] as usize) * n + x[2] as usize;
        let (mut start, mut neighbour) = (vec![0], Vec::new());
        for v in 0..n * n * n {
            let x = [v / (n * n), v / n % n, v % n].map(|c| c as i64);
            let even = x.iter().sum::<i64>() % 2 == 0;
            for q in 0..27i64 {
                let step = [q / 9 - 1, q / 3 % 3 - 1, q % 3 - 1];
                let length = step.iter().map(|s| s * s).sum::<i64>();
                let y: [i64; 3] = std::array::from_fn(|c| x[c] + step[c]);
                let inside = y.iter().all(|c| (0..n as i64).contains(c));
                if inside && (length == 1 || length == 2 && even) {
                    neighbour.push(at(y) as u32);
                }
            }
            start.push(neighbour.len());
        }
        let (of, count) = aggregates(&start, &neighbour, start.len() - 1);
        assert!(of.iter().all(|&g| (g as usize) < count));
        // A neighbourhood has 19 nodes. Around every node in turn there would be one to 14.
        let mean = of.len() as f64 / count as f64;
        assert!((19.0..30.0).contains(&mean), "{mean}");
    }
}
