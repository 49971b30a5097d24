use faer::linalg::{matmul, triangular_solve};
use faer::prelude::ReborrowMut;
use faer::{Accum, MatMut, MatRef, Par};

use super::Csr;
use super::lu::{Front, Lu};

/// `h' A⁻¹ h` for every row `h` of `vectors`, from the entries of `A⁻¹` on the pattern of the factor alone (Takahashi,
/// Fagan & Chin 1973; by fronts Campbell & Davis 1995). It costs about as much as the factor.
///
/// Any two unknowns of one `h` have to be an entry of `A`, which may be zero.
///
/// # Panics
/// If two unknowns of one `h` are in no common front.
pub fn inverse_forms(lu: &Lu, vectors: &Csr) -> Vec<f64> {
    let fronts = &lu.fronts;
    let mut front_of = vec![0usize; lu.unknown.len()];
    for (f, front) in fronts.iter().enumerate() {
        front_of[front.first..front.first + front.columns].fill(f);
    }
    let parent = |f: usize| fronts[f].rows.first().map(|&row| front_of[row as usize]);
    let mut waiting = vec![0usize; fronts.len()];
    (0..fronts.len()).filter_map(parent).for_each(|p| waiting[p] += 1);
    // The front of the unknown that is eliminated first holds all of them.
    let place = |i: &u32| lu.position[*i as usize] as usize;
    let mut asked: Vec<Vec<usize>> = vec![Vec::new(); fronts.len()];
    for k in 0..vectors.rows {
        if let Some(first) = vectors.row(k).0.iter().map(place).min() {
            asked[front_of[first]].push(k);
        }
    }
    let mut forms = vec![0.0; vectors.rows];
    let mut inverse: Vec<Vec<f64>> = vec![Vec::new(); fronts.len()];
    for f in (0..fronts.len()).rev() {
        let front = &fronts[f];
        let (size, above) = (front.columns + front.rows.len(), parent(f));
        let border = above.map_or(Vec::new(), |p| gathered(&fronts[p], &inverse[p], &front.rows));
        let own = invert(front, &border);
        for &k in &asked[f] {
            let (columns, values) = vectors.row(k);
            let local: Vec<usize> = columns.iter().map(|i| front.local(place(i))).collect();
            for (i, x) in local.iter().zip(values) {
                forms[k] += local.iter().zip(values).map(|(j, y)| x * own[j * size + i] * y).sum::<f64>();
            }
        }
        if waiting[f] > 0 {
            inverse[f] = own;
        }
        if let Some(p) = above {
            waiting[p] -= 1;
            if waiting[p] == 0 {
                inverse[p] = Vec::new();
            }
        }
    }
    forms
}

/// The part of a front's inverse in the places `rows`, by columns.
fn gathered(front: &Front, inverse: &[f64], rows: &[u32]) -> Vec<f64> {
    let size = front.columns + front.rows.len();
    let local: Vec<usize> = rows.iter().map(|&row| front.local(row as usize)).collect();
    local.iter().flat_map(|j| local.iter().map(move |i| inverse[j * size + i])).collect()
}

/// The inverse on a whole front, by columns, from the inverse `border` on its rows: with `A11 = P' L U`, `A21 = L21 U`
/// and `A12 = P' L U12`,
///
/// ```text
/// Z12 = -U⁻¹ U12 Z22,   Z21 = -Z22 L21 L⁻¹ P,   Z11 = (U⁻¹ - Z12 L21) L⁻¹ P
/// ```
fn invert(front: &Front, border: &[f64]) -> Vec<f64> {
    let (c, below) = (front.columns, front.rows.len());
    let size = c + below;
    let left = MatRef::from_column_major_slice(&front.left, size, c);
    let (a11, l21) = left.split_at_row(c);
    let right = MatRef::from_column_major_slice(&front.right, c, below);
    let z22 = MatRef::from_column_major_slice(border, below, below);
    // L⁻¹ P and U⁻¹.
    let (mut lower, mut upper) = (vec![0.0; c * c], vec![0.0; c * c]);
    for (k, &p) in front.pivot.iter().enumerate() {
        lower[p as usize * c + k] = 1.0;
        upper[k * c + k] = 1.0;
    }
    let lower_solved = MatMut::from_column_major_slice_mut(&mut lower, c, c);
    triangular_solve::solve_unit_lower_triangular_in_place(a11, lower_solved, Par::Seq);
    let upper_solved = MatMut::from_column_major_slice_mut(&mut upper, c, c);
    triangular_solve::solve_upper_triangular_in_place(a11, upper_solved, Par::Seq);
    let (g, u) = (MatRef::from_column_major_slice(&lower, c, c), MatRef::from_column_major_slice(&upper, c, c));
    let mut whole = vec![0.0; size * size];
    let z = MatMut::from_column_major_slice_mut(&mut whole, size, size);
    let (mut z11, mut z12, mut z21, mut z22_out) = z.split_at_mut(c, c);
    let mut t = upper.clone();
    let mut t = MatMut::from_column_major_slice_mut(&mut t, c, c);
    if below > 0 {
        z22_out.copy_from(z22);
        let mut y = vec![0.0; c * below];
        let mut y = MatMut::from_column_major_slice_mut(&mut y, c, below);
        matmul::matmul(y.rb_mut(), Accum::Replace, right, z22, 1.0, Par::Seq);
        matmul::matmul(z12.rb_mut(), Accum::Replace, u, y.as_ref(), -1.0, Par::Seq);
        let mut x = vec![0.0; below * c];
        let mut x = MatMut::from_column_major_slice_mut(&mut x, below, c);
        matmul::matmul(x.rb_mut(), Accum::Replace, z22, l21, 1.0, Par::Seq);
        matmul::matmul(z21.rb_mut(), Accum::Replace, x.as_ref(), g, -1.0, Par::Seq);
        matmul::matmul(t.rb_mut(), Accum::Add, z12.as_ref(), l21, -1.0, Par::Seq);
    }
    matmul::matmul(z11.rb_mut(), Accum::Replace, t.as_ref(), g, 1.0, Par::Seq);
    whole
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::{NodeGraph, nested_dissection, plan};

    #[test]
    fn forms_are_those_of_solves() {
        // Unsymmetric, with pivots that have to be exchanged within a front.
        let n = 12;
        let mut entries = Vec::new();
        for x in 0..n * n {
            entries.extend([
                (2 * x, 2 * x, 0.01),
                (2 * x, 2 * x + 1, 3.0),
                (2 * x + 1, 2 * x, 2.5),
                (2 * x + 1, 2 * x + 1, 0.3),
            ]);
            for y in [x + 1, x + n].into_iter().filter(|&y| y < n * n && (y != x + 1 || y % n != 0)) {
                entries.extend([(2 * x, 2 * y, -0.4), (2 * y, 2 * x, -0.1), (2 * x + 1, 2 * y + 1, 0.2)]);
                entries.extend([(2 * y + 1, 2 * x + 1, 0.3), (2 * x, 2 * y + 1, 0.0), (2 * y + 1, 2 * x, 0.0)]);
                entries.extend([(2 * y, 2 * x + 1, 0.0), (2 * x + 1, 2 * y, 0.0)]);
            }
        }
        let a = Csr::from_triplets(2 * n * n, 2 * n * n, &entries);
        let labels: Vec<u32> = (0..a.rows as u32).map(|i| i / 2).collect();
        let graph = NodeGraph::new(&a, Some(&labels));
        let lu = Lu::new(&a, &plan(&graph, &nested_dissection(&graph), 0)).unwrap();
        let vectors: Vec<(usize, usize, f64)> = (0..n * n - n)
            .flat_map(|x| [(x, 2 * x, 1.0 + x as f64), (x, 2 * x + 1, -2.0), (x, 2 * (x + n), 0.5)])
            .collect();
        let vectors = Csr::from_triplets(n * n - n, a.rows, &vectors);
        for (k, form) in inverse_forms(&lu, &vectors).into_iter().enumerate() {
            let mut h = vec![0.0; a.rows];
            let (columns, values) = vectors.row(k);
            columns.iter().zip(values).for_each(|(&j, v)| h[j as usize] = *v);
            let wanted = crate::linalg::dot(&h, &lu.solve(&h));
            assert!((form - wanted).abs() <= 1e-11 * wanted.abs().max(1.0), "{k}: {form} {wanted}");
        }
    }
}
