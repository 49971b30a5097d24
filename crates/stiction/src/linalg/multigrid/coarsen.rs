use std::ops::Range;

use rayon::prelude::*;

use super::aggregate::{aggregates, diagonal_norms, marks, neighbours, strong};
use super::blocks::{Block, Blocks, Row};
use super::dense::{add_product, add_transpose_product, inverse, inverse_beside, largest_diagonal, square};
use super::distance::{near, places};
use super::divided_product::{Product, aggregates_of_ghosts, divided_galerkin};
use super::middles::Middles;
use super::stiff_groups::merge;
use crate::Error;
use crate::linalg::in_huge_pages;
use crate::linalg::memory::ensure;
use crate::linalg::pattern::{Pattern, tasks};
use crate::ranks::{Halo, agree};

/// The near-kernel at one node: a row of six values for each of its components.
pub(crate) type Kernel<const R: usize> = [[f64; 6]; R];

/// A coarser level of nodes with `C` unknowns: its matrix, its near-kernel and the prolongation from it.
#[derive(Debug, Clone)]
pub(super) struct Coarser<const R: usize, const C: usize = 6> {
    pub prolongation: Blocks<R, C>,
    /// The requested rows of `A P`, for local changes of the coarse matrix.
    pub a_times_p: Blocks<R, C>,
    pub matrix: Blocks<C, C>,
    pub kernel: Vec<Kernel<C>>,
    /// How the nodes of the coarser level are divided among ranks. The prolongation has rows for the ghosts of the finer one
    /// too, as far as they are in the rows of this rank.
    pub halo: Halo,
}

/// Smoothed aggregation (Vanek, Mandel & Brezina 1996): six unknowns an aggregate, which represent the near-kernel
/// there exactly; the prolongation smoothed by one damped block Jacobi step. Aggregates and the reach of the
/// prolongation follow couplings that are strong and near. `None` if that does not make the matrix coarser. Rows of `A P`
/// are kept for the nodes `wanted`. Each of the stiff `groups` is in one aggregate, and the prolongation is not smoothed
/// there. Of nodes that are middles of edges `ends` has the ends ([`super::NO_NODE`] for others; none where no node is). An error where there
/// is no memory for it.
pub(super) fn coarsen<const R: usize>(
    a: &Blocks<R, R>,
    halo: &Halo,
    kernel: &[Kernel<R>],
    threshold: f64,
    groups: &[Vec<u32>],
    ends: Option<&[[u32; 2]]>,
    wanted: &[u32],
) -> Result<Option<Coarser<R>>, Error> {
    let all_kernels = halo.extended(kernel);
    let norms = diagonal_norms(a);
    let norms = halo.extended(&norms);
    let place = places(a, halo, &norms, &all_kernels);
    let strong = strong(a, &norms, threshold);
    let middles = Middles::new(a, halo, &place, &strong, ends);
    let kept = near(a, halo, &place, &middles.between_others(a, &strong));
    let (start, neighbour) = neighbours(a, &kept);
    let (mut of, count) = aggregates(&start, &neighbour, halo.total());
    let count = merge(&middles.after_ends(&of), &mut of, count);
    let count = merge(groups, &mut of, count);
    let kept = middles.reach(a, &place, &strong, kept);
    // Six unknowns an aggregate, R a node: thin layers of flat cells have little more than two nodes an aggregate.
    let mut sizes = [count as f64, a.rows as f64];
    halo.sum(&mut sizes);
    if 6 * sizes[0] as usize > R * sizes[1] as usize * 9 / 10 {
        return Ok(None);
    }
    // What the prediction for usual cells does not contain: flat ones have far more aggregates.
    let unknowns = 6.0 * count as f64 / (R * a.rows).max(1) as f64;
    let entries = (R * R * size_of::<f64>()) as f64 * a.value.len() as f64;
    let bytes = unknowns * (Threshold::COPIES * entries + Threshold::BYTES_PER_ROW * a.rows as f64);
    let room = ensure(&format!("a coarse level of {count} nodes"), bytes, None);
    if halo.is_alone() { room } else { agree(&**halo.ranks(), room) }?;
    let (mut tentative, coarse_kernel) = tentative(&of, count, kernel);
    let largest = largest_diagonal(|i| a.diagonal(i), halo);
    let mut inverses: Vec<Block<R, R>> =
        (0..a.rows).into_par_iter().map(|i| inverse_beside(&a.diagonal(i), largest)).collect();
    groups.iter().flatten().for_each(|&v| inverses[v as usize] = [[0.0; R]; R]);
    let (of, coarse) = aggregates_of_ghosts(halo, of, count);
    halo.update(&mut tentative);
    let all_coarse = coarse.extended(&coarse_kernel);
    // Aggregates in which a node has no kept neighbour are out of its reach: they would fill the coarse matrix across
    // weak couplings.
    let out = marks(a, |i, place| {
        let reach = |g: u32| (a.start[i]..a.start[i + 1]).any(|p| kept[p] && of[a.column[p] as usize] == g);
        let g = of[a.column[place] as usize];
        !kept[place] && g != of[i] && !reach(g)
    });
    let omega = 4.0 / (3.0 * largest_eigenvalue(a, halo, &out, &inverses));
    let smoother = Smoother { inverses: &inverses, omega, of: &of, place: &place, tentative: &tentative, out: &out };
    let prolongation = smoothed(a, &smoother, &all_kernels, &all_coarse);
    let product = product_of(a, halo, prolongation, coarse, wanted);
    Ok(product.map(|(prolongation, matrix, a_times_p, halo)| Coarser {
        prolongation,
        a_times_p,
        matrix,
        kernel: coarse_kernel,
        halo,
    }))
}

/// A coarse level with the displacements of the fine one, for a matrix that is not to be made coarser by the ranks that have it:
/// each node is an aggregate of its own, with idle unknowns that fill it up to six.
pub(super) fn copied<const R: usize>(
    a: &Blocks<R, R>,
    halo: &Halo,
    kernel: &[Kernel<R>],
    wanted: &[u32],
) -> Option<Coarser<R>> {
    let of: Vec<u32> = (0..a.rows as u32).collect();
    let (tentative, kernel) = tentative(&of, a.rows, kernel);
    let (of, coarse) = aggregates_of_ghosts(halo, of, a.rows);
    let named = |i: usize, name: &mut dyn FnMut(u32)| name(of[i]);
    let prolongation = Blocks::from_rows(a.rows, coarse.len(), named, |i, row| *row.at(of[i]) = tentative[i]);
    let (prolongation, matrix, a_times_p, halo) = product_of(a, halo, prolongation, coarse, wanted)?;
    Some(Coarser { prolongation, a_times_p, matrix, kernel, halo })
}

/// The coarse matrix of a prolongation, and what belongs to it.
pub(super) fn product_of<const R: usize, const C: usize>(
    a: &Blocks<R, R>,
    halo: &Halo,
    prolongation: Blocks<R, C>,
    coarse: Halo,
    wanted: &[u32],
) -> Option<Product<R, C>> {
    match halo.is_alone() {
        true => galerkin(a, &prolongation, wanted).map(|(matrix, kept)| (prolongation, matrix, kept, coarse)),
        false => divided_galerkin(a, halo, prolongation, coarse, wanted),
    }
}

/// Thresholds of the coarsening; the trials are in docs/notes/2026-11-23-multigrid-trials.md.
struct Threshold;

impl Threshold {
    /// Most entries of a coarse matrix over those of the finer one. Flat cells, which coarsen along lines of three nodes only,
    /// reach 2.6.
    const MOST_FILL: usize = 4;
    /// Memory of a step of the set-up where each unknown became one of the coarse level: so many times the matrix, and bytes a
    /// node, by plates of all elements whose cells are twenty times flatter than wide.
    const COPIES: f64 = 3.5;
    const BYTES_PER_ROW: f64 = 16e3;
    /// A column of the near-kernel is dependent if orthogonalisation leaves less than this multiple of its length.
    const DEPENDENT: f64 = 1e-8;
    /// Steps of the power iteration; the damping is not sensitive to the estimate.
    const POWER_STEPS: usize = 8;
    /// Bytes of `A P` at a time: enough rows for the threads, few enough for the caches.
    const SLAB: usize = 16 << 20;
    /// Coarse nodes a thread takes at a time.
    const COARSE_NODES: usize = 8;
}

/// An orthonormal basis of the near-kernel on each aggregate, as one block a node, and the near-kernel in it.
/// Columns that depend on the earlier ones there are zero.
fn tentative<const R: usize>(of: &[u32], count: usize, kernel: &[Kernel<R>]) -> (Vec<Block<R, 6>>, Vec<Kernel<6>>) {
    let mut start = vec![0usize; count + 1];
    of.iter().for_each(|&g| start[g as usize + 1] += 1);
    (0..count).for_each(|g| start[g + 1] += start[g]);
    let (mut next, mut member) = (start.clone(), vec![0u32; of.len()]);
    for (i, &g) in of.iter().enumerate() {
        member[next[g as usize]] = i as u32;
        next[g as usize] += 1;
    }
    let nodes = |g: usize| &member[start[g]..start[g + 1]];
    let of_aggregate = |g: usize| {
        let mut basis: Vec<Block<R, 6>> = nodes(g).iter().map(|&i| kernel[i as usize]).collect();
        let coarse = orthonormalise(&mut basis);
        (basis, coarse)
    };
    let made: Vec<(Vec<Block<R, 6>>, Kernel<6>)> = (0..count).into_par_iter().map(of_aggregate).collect();
    let mut basis = vec![[[0.0; 6]; R]; of.len()];
    for (g, (own, _)) in made.iter().enumerate() {
        nodes(g).iter().zip(own).for_each(|(&i, block)| basis[i as usize] = *block);
    }
    (basis, made.into_iter().map(|(_, coarse)| coarse).collect())
}

/// Makes the columns of a few blocks orthonormal, or zero, and returns the triangular factor of the decomposition.
fn orthonormalise<const R: usize>(basis: &mut [Block<R, 6>]) -> Kernel<6> {
    let mut coarse = [[0.0; 6]; 6];
    let product = |basis: &[Block<R, 6>], p: usize, q: usize| -> f64 {
        basis.iter().map(|block| block.iter().map(|row| row[p] * row[q]).sum::<f64>()).sum()
    };
    for q in 0..6 {
        let before = product(basis, q, q).sqrt();
        // Twice is enough (Giraud, Langou & Rozloznik 2005).
        for _ in 0..2 {
            for p in 0..q {
                let along = product(basis, p, q);
                coarse[p][q] += along;
                basis.iter_mut().flatten().for_each(|row| row[q] -= along * row[p]);
            }
        }
        let length = product(basis, q, q).sqrt();
        let scale = if length > Threshold::DEPENDENT * before { 1.0 / length } else { 0.0 };
        coarse[q][q] = if scale > 0.0 { length } else { 0.0 };
        basis.iter_mut().flatten().for_each(|row| row[q] *= scale);
    }
    coarse
}

/// Estimate of the largest eigenvalue of `D⁻¹ A`, `D` the block diagonal, with blocks `out` of reach lumped on the
/// diagonal: power iteration from a rough start.
fn largest_eigenvalue<const R: usize>(a: &Blocks<R, R>, halo: &Halo, out: &[bool], inverses: &[Block<R, R>]) -> f64 {
    let mut x: Vec<[f64; R]> =
        (0..a.rows).map(|i| std::array::from_fn(|c| ((i * R + c) as f64 * 1.618).fract() - 0.5)).collect();
    let mut value = 1.0;
    for _ in 0..Threshold::POWER_STEPS {
        halo.update(&mut x);
        let product = |i: usize| -> [f64; R] {
            let mut y = [0.0; R];
            for place in a.start[i]..a.start[i + 1] {
                let x = &x[if out[place] { i } else { a.column[place] as usize }];
                for (y, row) in y.iter_mut().zip(&a.value[place]) {
                    *y += row.iter().zip(x).map(|(a, x)| a * x).sum::<f64>();
                }
            }
            inverses[i].map(|row| row.iter().zip(&y).map(|(d, y)| d * y).sum())
        };
        x = (0..a.rows).into_par_iter().map(product).collect();
        let mut square = [x.iter().flatten().map(|v| v * v).sum::<f64>()];
        halo.sum(&mut square);
        value = square[0].sqrt();
        if !(value > 0.0 && value.is_finite()) {
            return 1.0;
        }
        x.iter_mut().flatten().for_each(|v| *v /= value);
    }
    value
}

/// The data of the prolongation smoother.
struct Smoother<'a, const R: usize> {
    inverses: &'a [Block<R, R>],
    omega: f64,
    /// Aggregate of each node, and the basis there.
    of: &'a [u32],
    /// Coordinates of each node.
    place: &'a [[f64; 3]],
    tentative: &'a [Block<R, 6>],
    /// Blocks of `A` that couple a node to an aggregate out of its reach.
    out: &'a [bool],
}

/// `P = (I - omega D⁻¹ A) T` within the reach of each node. In a row with omitted blocks the others are changed so that the
/// near-kernel is still represented exactly: the smallest change in the sum of squares, weighted with those of the blocks
/// (the constraint of energy-minimising prolongations, Olson, Schroder & Tuminaro 2011). Without the weights stiff nodes
/// would be tied to soft aggregates.
///
/// Where a support is near, the rows of `A` have forces on the near-kernel. Those on translations are kept. Those on
/// rotations about the node are not: a rotation moves the far end of a stretched cell a thousand times as far as the nodes of
/// the aggregate, which would have to balance that by entries of a hundred where basis functions are at most one.
fn smoothed<const R: usize>(
    a: &Blocks<R, R>,
    smoother: &Smoother<'_, R>,
    kernel: &[Kernel<R>],
    coarse_kernel: &[Kernel<6>],
) -> Blocks<R, 6> {
    let Smoother { inverses, omega, of, place, tentative, out } = *smoother;
    let aggregates = |i: usize, name: &mut dyn FnMut(u32)| {
        let within = a.row(i).0.iter().zip(&out[a.start[i]..]).filter(|(_, out)| !**out);
        within.for_each(|(&j, _)| name(of[j as usize]));
    };
    Blocks::from_rows(
        a.rows,
        coarse_kernel.len(),
        aggregates,
        #[inline(always)]
        |i, row| {
            let mut scaled = inverses[i];
            scaled.iter_mut().flatten().for_each(|v| *v *= -omega);
            let (columns, blocks) = a.row(i);
            // A T first, by aggregates; D⁻¹ once for each of them.
            for ((&j, block), _) in columns.iter().zip(blocks).zip(&out[a.start[i]..]).filter(|(_, out)| !**out) {
                add_product(block, &tentative[j as usize], row.at(of[j as usize]));
            }
            if out[a.start[i]..a.start[i + 1]].contains(&true) {
                let mut forces = [[0.0; 6]; R];
                columns.iter().zip(blocks).for_each(|(&j, a)| add_product(a, &kernel[j as usize], &mut forces));
                balance(&at_node(&forces, &place[i]), coarse_kernel, row);
            }
            for block in row.values.iter_mut() {
                let mut result = [[0.0; 6]; R];
                add_product(&scaled, block, &mut result);
                *block = result;
            }
            let own = row.at(of[i]);
            own.iter_mut().flatten().zip(tentative[i].iter().flatten()).for_each(|(p, t)| *p += t);
        },
    )
}

/// The forces on translations, and the moments that they have if they act at `place`.
fn at_node<const R: usize>(forces: &Block<R, 6>, place: &[f64; 3]) -> Block<R, 6> {
    let [x, y, z] = place.map(|c| if c.is_finite() { c } else { 0.0 });
    forces.map(|f| [f[0], f[1], f[2], y * f[2] - z * f[1], z * f[0] - x * f[2], x * f[1] - y * f[0]])
}

/// Changes the blocks of a row least, in the sum of squares with the weights of [`smoothed`], so that their product with the
/// near-kernel is `wanted`.
fn balance<const R: usize>(wanted: &Block<R, 6>, kernel: &[Kernel<6>], row: &mut Row<'_, R, 6>) {
    let weights: Vec<f64> = row.values.iter().map(square).collect();
    let (mut gram, mut lost) = ([[0.0; 6]; 6], *wanted);
    for ((&k, &weight), block) in row.columns.iter().zip(&weights).zip(row.values.iter()) {
        let motions = &kernel[k as usize];
        add_transpose_product(motions, &motions.map(|r| r.map(|v| weight * v)), &mut gram);
        add_product(&block.map(|r| r.map(|v| -v)), motions, &mut lost);
    }
    let mut multiplier = [[0.0; 6]; R];
    add_product(&lost, &inverse(&gram), &mut multiplier);
    for ((&k, &weight), block) in row.columns.iter().zip(&weights).zip(row.values.iter_mut()) {
        let motions = &kernel[k as usize];
        let transposed = std::array::from_fn(|r| std::array::from_fn(|c| weight * motions[c][r]));
        add_product(&multiplier, &transposed, block);
    }
}

/// `Pᵀ A P` and the wanted rows of `A P`; an idle coarse unknown gets a positive diagonal entry. `None` if the fill exceeds
/// [`Threshold::MOST_FILL`].
///
/// `A P` would be the largest matrix of the set-up. It is computed by slabs of rows, each consumed before the next.
pub(super) fn galerkin<const R: usize, const C: usize>(
    a: &Blocks<R, R>,
    p: &Blocks<R, C>,
    wanted: &[u32],
) -> Option<(Blocks<C, C>, Blocks<R, C>)> {
    let (mut matrix, kept) = products(a, &Halo::alone(a.rows), p, wanted)?;
    mirror(&mut matrix);
    fill_idle(&mut matrix);
    Some((matrix, kept))
}

/// The products of [`galerkin`], on or above the diagonal. Where nodes are divided the part of the rows of `a` is not
/// symmetric, and all of it is computed; `p` has rows for the ghosts.
pub(super) fn products<const R: usize, const C: usize>(
    a: &Blocks<R, R>,
    halo: &Halo,
    p: &Blocks<R, C>,
    wanted: &[u32],
) -> Option<(Blocks<C, C>, Blocks<R, C>)> {
    let reached = |i: usize, name: &mut dyn FnMut(u32)| {
        a.row(i).0.iter().for_each(|&j| p.row(j as usize).0.iter().for_each(|&k| name(k)));
    };
    let middle = Pattern::new(a.rows, p.cols, reached);
    let (start, entry) = p.by_columns(a.rows);
    let whole = !halo.is_alone();
    let coarse = Pattern::new(p.cols, p.cols, |k, name| {
        // Rows of other ranks to which this one adds nothing are none of its matrix.
        if !whole || start[k] < start[k + 1] {
            name(k as u32);
        }
        entry[start[k]..start[k + 1]].iter().for_each(|&(i, _)| middle.row(i as usize).iter().for_each(|&j| name(j)));
    });
    let mut entries = [coarse.column.len() as f64, a.value.len() as f64];
    halo.sum(&mut entries);
    if C * C * entries[0] as usize > Threshold::MOST_FILL * R * R * entries[1] as usize {
        return None;
    }
    let mut value: Vec<Block<C, C>> = coarse.zeros();
    let slabs = slabs(&middle.start, Threshold::SLAB / size_of::<Block<R, C>>());
    let largest = slabs.iter().map(|rows| middle.start[rows.end] - middle.start[rows.start]).max().unwrap_or(0);
    let mut slab: Vec<Block<R, C>> = in_huge_pages(vec![[[0.0; C]; R]; largest]);
    for rows in slabs {
        let base = middle.start[rows.start];
        let own = &mut slab[..middle.start[rows.end] - base];
        middle.fill(
            &tasks(rows.clone()),
            p.cols,
            own,
            #[inline(always)]
            |i, row| product(a, p, i, row),
        );
        let tasks = coarse_tasks(&p.column[p.start[rows.start]..p.start[rows.end]]);
        let first = tasks.first().map_or(0, |task| coarse.start[task.start]);
        coarse.fill(
            &tasks,
            p.cols,
            &mut value[first..],
            #[inline(always)]
            |k, row| {
                // The rows of a column ascend.
                let entries = &entry[start[k]..start[k + 1]];
                let from = entries.partition_point(|&(i, _)| (i as usize) < rows.start);
                for &(i, place) in entries[from..].iter().take_while(|&&(i, _)| (i as usize) < rows.end) {
                    let i = i as usize;
                    let blocks = &slab[middle.start[i] - base..middle.start[i + 1] - base];
                    let columns = middle.row(i);
                    let upper = if whole { 0 } else { columns.partition_point(|&j| (j as usize) < k) };
                    for (&j, block) in columns[upper..].iter().zip(&blocks[upper..]) {
                        add_transpose_product(&p.value[place as usize], block, row.at(j));
                    }
                }
            },
        );
    }
    let Pattern { start, column } = coarse;
    let matrix = Blocks { rows: p.cols, cols: p.cols, start, column, value };
    let kept = Blocks::from_rows(
        wanted.len(),
        p.cols,
        |t, name| middle.row(wanted[t] as usize).iter().for_each(|&k| name(k)),
        #[inline(always)]
        |t, row| product(a, p, wanted[t] as usize, row),
    );
    Some((matrix, kept))
}

/// Idle coarse unknowns get a positive diagonal entry.
pub(super) fn fill_idle<const C: usize>(matrix: &mut Blocks<C, C>) {
    for k in 0..matrix.rows {
        let Some(place) = matrix.place(k, k) else { continue };
        let own = &mut matrix.value[place];
        let scale = (0..C).map(|c| own[c][c]).fold(0.0, f64::max);
        for c in 0..C {
            if own[c][c] <= 1e-14 * scale {
                own[c][c] = scale.max(f64::MIN_POSITIVE);
            }
        }
    }
}

/// Sets the blocks below the diagonal to the transposes of those above. The pattern is symmetric.
fn mirror<const C: usize>(a: &mut Blocks<C, C>) {
    let mut next = a.start.clone();
    for j in 0..a.rows {
        // The columns of a row ascend, and so do the rows that come here: each fills the next place of a row.
        for place in next[j]..a.start[j + 1] {
            let k = a.column[place] as usize;
            if k > j {
                let block = a.value[place];
                a.value[next[k]] = std::array::from_fn(|r| std::array::from_fn(|c| block[c][r]));
                next[k] += 1;
            }
        }
    }
}

/// Row `i` of `A P`. Compiled into both of its callers, for the instructions of the machine at hand.
#[inline(always)]
fn product<const R: usize, const C: usize>(a: &Blocks<R, R>, p: &Blocks<R, C>, i: usize, row: &mut Row<'_, R, C>) {
    row.values.fill([[0.0; C]; R]);
    for (j, block) in a.entries_of(i) {
        for (k, value) in p.entries_of(j as usize) {
            add_product(block, value, row.at(k));
        }
    }
}

/// The coarse nodes that a slab reaches, in small groups of neighbours, one task each.
fn coarse_tasks(reached: &[u32]) -> Vec<Range<usize>> {
    let mut nodes = reached.to_vec();
    nodes.sort_unstable();
    nodes.dedup();
    nodes.chunks(Threshold::COARSE_NODES).map(|few| few[0] as usize..few[few.len() - 1] as usize + 1).collect()
}

/// Consecutive rows with about `most` entries each time, at least one row.
fn slabs(start: &[usize], most: usize) -> Vec<Range<usize>> {
    let (mut first, mut slabs) = (0, Vec::new());
    while first + 1 < start.len() {
        let end = start.partition_point(|&s| s <= start[first] + most).saturating_sub(1).max(first + 1);
        slabs.push(first..end);
        first = end;
    }
    slabs
}
