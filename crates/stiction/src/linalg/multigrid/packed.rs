use rayon::prelude::*;

use super::blocks::{Block, Blocks, Row, by_tasks};
use crate::linalg::pattern::{Pattern, ROWS_PER_TASK, piece, tasks};
use crate::linalg::{in_huge_pages, vectorised};
use crate::ranks::Halo;

/// A block in single precision, by columns: what a cycle reads.
pub(super) type Single<const R: usize, const C: usize> = [[f32; R]; C];

/// A sparse matrix of blocks in single precision.
#[derive(Debug, Clone, Default)]
pub(super) struct Packed<const R: usize, const C: usize> {
    pub rows: usize,
    pub start: Vec<usize>,
    pub column: Vec<u32>,
    pub value: Vec<Single<R, C>>,
}

pub(super) fn single<const R: usize, const C: usize>(a: &[[f64; C]; R]) -> Single<R, C> {
    std::array::from_fn(|c| std::array::from_fn(|r| a[r][c] as f32))
}

/// The inverse of [`single`].
pub(super) fn double<const R: usize, const C: usize>(a: &Single<R, C>) -> [[f64; C]; R] {
    std::array::from_fn(|r| std::array::from_fn(|c| f64::from(a[c][r])))
}

/// Single precision with the largest entry of all ranks as the unit, because its range of exponents is narrow.
pub(super) fn unit<const R: usize>(halo: &Halo, x: &[[f64; R]]) -> (f64, Vec<[f32; R]>) {
    let scale = largest(halo, x);
    (scale, in_units(scale, x))
}

/// The largest entry of all ranks, at least the smallest positive number.
pub(super) fn largest<const R: usize>(halo: &Halo, x: &[[f64; R]]) -> f64 {
    let mut largest = [x.iter().flatten().fold(f64::MIN_POSITIVE, |m, v| m.max(v.abs()))];
    halo.max(&mut largest);
    largest[0]
}

/// Single precision over `scale`.
pub(super) fn in_units<const R: usize>(scale: f64, x: &[[f64; R]]) -> Vec<[f32; R]> {
    x.iter().map(|x| x.map(|v| (v / scale) as f32)).collect()
}

/// The inverse of [`unit`].
pub(super) fn scaled<const R: usize>(scale: f64, x: &[[f32; R]]) -> Vec<[f64; R]> {
    x.iter().map(|x| x.map(|v| scale * f64::from(v))).collect()
}

/// `x += y`.
pub(super) fn add_to<T: Copy + std::ops::AddAssign, const N: usize>(x: &mut [T; N], y: &[T; N]) {
    x.iter_mut().zip(y).for_each(|(x, y)| *x += *y);
}

/// `y += a x`.
#[inline(always)]
pub(super) fn add<const R: usize, const C: usize>(a: &Single<R, C>, x: &[f32; C], y: &mut [f32; R]) {
    for c in 0..C {
        for r in 0..R {
            y[r] += a[c][r] * x[c];
        }
    }
}

/// A sum of products `a x` of stored blocks. Lanes `W >= R` are those of a vector register, the first `R` of them count;
/// columns add up each for itself, so that no addition waits for the one before.
pub(super) struct Sum<const R: usize, const C: usize, const W: usize>([[f32; W]; C]);

impl<const R: usize, const C: usize, const W: usize> Sum<R, C, W> {
    #[inline(always)]
    pub(super) fn zero() -> Self {
        Sum([[0.0; W]; C])
    }

    /// Adds the product of the block at `place` of `entries`, all numbers of a matrix one after the other.
    #[inline(always)]
    pub(super) fn add(&mut self, entries: &[f32], place: usize, x: &[f32; C]) {
        let first = R * C * place;
        // A column is read with a few numbers of the next, and the last one of all has no next.
        match entries.get(first..first + R * (C - 1) + W) {
            Some(block) => self.add_columns(block, R, x),
            None => {
                let mut block = [[0.0; W]; C];
                for c in 0..C {
                    block[c][..R].copy_from_slice(&entries[first + R * c..][..R]);
                }
                self.add_columns(block.as_flattened(), W, x);
            }
        }
    }

    #[inline(always)]
    fn add_columns(&mut self, columns: &[f32], stride: usize, x: &[f32; C]) {
        for c in 0..C {
            let column = &columns[stride * c..stride * c + W];
            for r in 0..W {
                self.0[c][r] += column[r] * x[c];
            }
        }
    }

    #[inline(always)]
    pub(super) fn total(&self) -> [f32; R] {
        let mut total = [0.0; W];
        for column in &self.0 {
            (0..W).for_each(|r| total[r] += column[r]);
        }
        std::array::from_fn(|r| total[r])
    }
}

/// `y -= a x`.
#[inline(always)]
pub(super) fn subtract<const R: usize, const C: usize>(a: &Single<R, C>, x: &[f32; C], y: &mut [f32; R]) {
    for c in 0..C {
        for r in 0..R {
            y[r] -= a[c][r] * x[c];
        }
    }
}

/// `y += aᵀ x`.
#[inline(always)]
pub(super) fn add_transposed<const R: usize, const C: usize>(a: &Single<R, C>, x: &[f32; R], y: &mut [f32; C]) {
    for c in 0..C {
        for r in 0..R {
            y[c] += a[c][r] * x[r];
        }
    }
}

impl<const R: usize, const C: usize> Packed<R, C> {
    pub(super) fn new(a: &Blocks<R, C>) -> Self {
        let mut value = in_huge_pages(vec![[[0.0; R]; C]; a.value.len()]);
        value.par_iter_mut().zip(&a.value).for_each(|(v, a)| *v = single(a));
        Packed { rows: a.rows, start: a.start.clone(), column: a.column.clone(), value }
    }

    /// The matrix with these rows, columns and blocks of each.
    pub(super) fn of_rows<'a>(rows: usize, row: impl Fn(usize) -> (&'a [u32], &'a [Block<R, C>]) + Sync) -> Self {
        let mut start = vec![0; rows + 1];
        (0..rows).for_each(|i| start[i + 1] = start[i] + row(i).0.len());
        let mut column = in_huge_pages(vec![0; start[rows]]);
        let mut value = in_huge_pages(vec![[[0.0; R]; C]; start[rows]]);
        let tasks = tasks(0..rows);
        let (columns, values) = (by_tasks(&start, &tasks, &mut column), by_tasks(&start, &tasks, &mut value));
        columns.into_par_iter().zip(values).for_each(|((own, columns), (_, values))| {
            let blocks = own.flat_map(|i| row(i).0.iter().zip(row(i).1));
            for ((column, value), (j, a)) in columns.iter_mut().zip(values).zip(blocks) {
                (*column, *value) = (*j, single(a));
            }
        });
        Packed { rows, start, column, value }
    }

    /// A matrix whose rows have the columns that `columns` names and the values that `fill` accumulates, as [`Blocks::from_rows`].
    /// Only the rows at work are in double precision.
    pub(super) fn from_rows(
        rows: usize,
        cols: usize,
        columns: impl Fn(usize, &mut dyn FnMut(u32)) + Sync,
        fill: impl Fn(usize, &mut Row<'_, R, C>) + Sync,
    ) -> Self {
        let Pattern { start, column } = Pattern::new(rows, cols, columns);
        let mut value = in_huge_pages(vec![[[0.0; R]; C]; start[rows]]);
        let tasks = tasks(0..rows);
        let at_once = piece(tasks.len());
        by_tasks(&start, &tasks, &mut value).into_par_iter().with_max_len(at_once).for_each_init(
            || (vec![0u32; cols], Vec::new()),
            |(slot, sums), (own, values)| {
                vectorised(
                    #[inline(always)]
                    || {
                        for i in own.clone() {
                            let columns = &column[start[i]..start[i + 1]];
                            sums.clear();
                            sums.resize(columns.len(), [[0.0; C]; R]);
                            fill(i, &mut Row::new(slot, columns, sums));
                            let values = &mut values[start[i] - start[own.start]..];
                            values.iter_mut().zip(&*sums).for_each(|(value, sum)| *value = single(sum));
                        }
                    },
                );
            },
        );
        Packed { rows, start, column, value }
    }

    pub(super) fn row(&self, i: usize) -> (&[u32], &[Single<R, C>]) {
        let range = self.start[i]..self.start[i + 1];
        (&self.column[range.clone()], &self.value[range])
    }

    pub(super) fn entries_of(&self, i: usize) -> impl Iterator<Item = (u32, &Single<R, C>)> {
        let (columns, values) = self.row(i);
        columns.iter().copied().zip(values)
    }

    /// `y += A x`.
    pub(super) fn add_times(&self, x: &[[f32; C]], y: &mut [[f32; R]]) {
        y.par_chunks_mut(ROWS_PER_TASK).enumerate().for_each(|(task, y)| {
            for (k, y) in y.iter_mut().enumerate() {
                self.entries_of(task * ROWS_PER_TASK + k).for_each(|(j, a)| add(a, &x[j as usize], y));
            }
        });
    }

    /// `Aᵀ x` for a matrix with `cols` columns; one thread, so that its result is always the same.
    pub(super) fn transpose_times(&self, x: &[[f32; R]], cols: usize) -> Vec<[f32; C]> {
        let mut y = vec![[0.0; C]; cols];
        for (i, x) in x.iter().enumerate() {
            self.entries_of(i).for_each(|(j, a)| add_transposed(a, x, &mut y[j as usize]));
        }
        y
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn products<const R: usize, const W: usize>() {
        let number = |i: usize| (i * 37 % 101) as f32 / 101.0 - 0.5;
        let blocks: Vec<Single<R, R>> =
            (0..5).map(|p| std::array::from_fn(|c| std::array::from_fn(|r| number(R * (R * p + c) + r)))).collect();
        let x: Vec<[f32; R]> = (0..5).map(|p| std::array::from_fn(|c| number(1000 + R * p + c))).collect();
        // In any order, the last block among them, whose last column has no next one.
        for places in [vec![4], vec![0, 3], vec![4, 2, 1, 0]] {
            let (mut sum, mut expected) = (Sum::<R, R, W>::zero(), [0.0; R]);
            for &p in &places {
                sum.add(blocks.as_flattened().as_flattened(), p, &x[p]);
                add(&blocks[p], &x[p], &mut expected);
            }
            for (found, expected) in sum.total().iter().zip(expected) {
                assert!((found - expected).abs() < 1e-6, "{R} {places:?}: {found} {expected}");
            }
        }
    }

    #[test]
    fn sums_by_lanes_are_those_of_the_products() {
        products::<3, 4>();
        products::<6, 8>();
    }
}
