//! A sparse basis of the null space of constraints, by elimination of one unknown a row.

use std::collections::{BTreeMap, HashMap};

use super::Csr;

/// A pivot is at least this part of the largest entry of its row, so that no weight of the basis grows beyond its inverse in
/// one step; among these the one that fewest rows name.
const THRESHOLD: f64 = 0.3;
/// What is left of a row that depends on others, relative to its largest entry before.
const DEPENDENT: f64 = 1e-11;

/// One unknown by others.
type Expression = Vec<(u32, f64)>;

/// `Z`, `n x k`, with `C Z = 0` and full rank, where `C` has `n` columns and rank `n - k`. `k` of its rows are those of the
/// identity: their unknowns are free, the others are eliminated.
///
/// Rows of `C` that depend on rows above, and empty ones, are left out.
pub fn null_space(C: &Csr) -> Csr {
    let mut rows_at = vec![0usize; C.cols];
    C.column.iter().for_each(|&j| rows_at[j as usize] += 1);
    let mut place: HashMap<u32, usize> = HashMap::new();
    let mut eliminated: Vec<(u32, Expression)> = Vec::new();
    for i in 0..C.rows {
        let largest = C.entries_of(i).fold(0.0, |a: f64, (_, v)| a.max(v.abs()));
        let mut row: BTreeMap<u32, f64> = C.entries_of(i).collect();
        let of = |j: &u32| place.get(j).map(|&k| &eliminated[k].1);
        while let Some((j, of_j)) = row.keys().find_map(|j| Some((*j, of(j)?))) {
            substitute(&mut row, j, of_j);
        }
        row.retain(|_, v| v.abs() > DEPENDENT * largest);
        let large = THRESHOLD * row.values().fold(0.0, |a: f64, v| a.max(v.abs()));
        let Some((&pivot, &own)) =
            row.iter().filter(|(_, v)| v.abs() >= large).min_by_key(|(j, _)| rows_at[**j as usize])
        else {
            continue;
        };
        row.remove(&pivot);
        place.insert(pivot, eliminated.len());
        eliminated.push((pivot, row.into_iter().map(|(j, v)| (j, -v / own)).collect()));
    }
    // Rows below have eliminated unknowns by which those above are expressed.
    for k in (0..eliminated.len()).rev() {
        let mut row: BTreeMap<u32, f64> = std::mem::take(&mut eliminated[k].1).into_iter().collect();
        let later: Vec<u32> = row.keys().filter(|j| place.contains_key(j)).copied().collect();
        later.into_iter().for_each(|j| substitute(&mut row, j, &eliminated[place[&j]].1));
        eliminated[k].1 = row.into_iter().collect();
    }
    let mut number = vec![0u32; C.cols];
    let mut free = 0;
    for j in (0..C.cols as u32).filter(|j| !place.contains_key(j)) {
        number[j as usize] = free;
        free += 1;
    }
    let mut basis = Csr::zero(C.cols, free as usize);
    for j in 0..C.cols as u32 {
        match place.get(&j) {
            Some(&k) => {
                basis.column.extend(eliminated[k].1.iter().map(|&(j, _)| number[j as usize]));
                basis.value.extend(eliminated[k].1.iter().map(|&(_, v)| v));
            }
            None => {
                basis.column.push(number[j as usize]);
                basis.value.push(1.0);
            }
        }
        basis.start[j as usize + 1] = basis.column.len();
    }
    basis
}

/// Puts what unknown `j` is by others in its place.
fn substitute(row: &mut BTreeMap<u32, f64>, j: u32, of_j: &Expression) {
    let Some(weight) = row.remove(&j) else { return };
    of_j.iter().for_each(|&(other, v)| *row.entry(other).or_default() += weight * v);
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Largest entry of `C Z`, and the smallest eigenvalue of `Zᵀ Z`.
    fn judged(C: &Csr, Z: &Csr) -> (f64, f64) {
        let columns: Vec<Vec<f64>> = (0..Z.cols).map(|k| (0..Z.rows).map(|i| Z.entry(i, k)).collect()).collect();
        let off = columns.iter().flat_map(|z| C.times(z)).fold(0.0, |a: f64, v| a.max(v.abs()));
        let gram = faer::Mat::from_fn(Z.cols, Z.cols, |a, b| super::super::dot(&columns[a], &columns[b]));
        let values = gram.self_adjoint_eigenvalues(faer::Side::Lower).unwrap();
        (off, values[0])
    }

    #[test]
    fn chains_of_constraints_are_satisfied_and_dependent_rows_are_left_out() {
        // x0 = x1, x1 = (x2 + x3) / 2, x3 = 2 x4, and their sum.
        let rows = [
            vec![1.0, -1.0, 0.0, 0.0, 0.0, 0.0],
            vec![0.0, 1.0, -0.5, -0.5, 0.0, 0.0],
            vec![0.0, 0.0, 0.0, 1.0, -2.0, 0.0],
        ];
        let sum: Vec<f64> = (0..6).map(|j| rows.iter().map(|row| row[j]).sum()).collect();
        let entries: Vec<(usize, usize, f64)> = (rows.iter().chain([&sum, &vec![0.0; 6]]).enumerate())
            .flat_map(|(i, row)| row.iter().enumerate().map(move |(j, &v)| (i, j, v)))
            .filter(|entry| entry.2 != 0.0)
            .collect();
        let C = Csr::from_triplets(5, 6, &entries);
        let Z = null_space(&C);
        Z.validate("Z").unwrap();
        assert_eq!((Z.rows, Z.cols), (6, 3));
        let (off, least) = judged(&C, &Z);
        assert!(off < 1e-14 && least >= 1.0 - 1e-12, "{off} {least}");
    }

    #[test]
    fn random_rows_leave_what_their_rank_says() {
        let mut seed = 7u64;
        let mut random = move || {
            seed = seed.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (seed >> 11) as f64 / (1u64 << 53) as f64
        };
        for _ in 0..50 {
            let entries: Vec<(usize, usize, f64)> = (0..12)
                .flat_map(|i| (0..4).map(move |_| i))
                .map(|i| (i, (40.0 * random()) as usize, 2.0 * random() - 1.0))
                .collect();
            let C = Csr::from_triplets(12, 40, &entries);
            let Z = null_space(&C);
            let (off, least) = judged(&C, &Z);
            // Rows of random numbers in random places are independent unless one of them has no partner to differ by.
            assert_eq!(Z.cols, 40 - 12);
            assert!(off < 1e-9 && least > 1.0 - 1e-12, "{off} {least}");
        }
    }
}
