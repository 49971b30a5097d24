use super::blocks::{Block, Blocks};
use super::coarsen::{Coarser, Kernel, coarsen};
use super::dense::{add_product, add_transpose_product};
use super::*;

/// A lattice of springs along edges and face diagonals, held weakly everywhere: an elastic body without elements.
pub(super) fn lattice(size: [usize; 3]) -> (Blocks<3, 3>, Vec<Kernel<3>>) {
    let [a, b, c] = size;
    let at = |i: usize, j: usize, k: usize| (i * b + j) * c + k;
    let place = |v: usize| [v / (b * c), v / c % b, v % c];
    let offsets: Vec<[i64; 3]> = (0..27)
        .map(|q| [q / 9 - 1, q / 3 % 3 - 1, q % 3 - 1])
        .filter(|o| (1..=2).contains(&o.iter().map(|v| v * v).sum::<i64>()))
        .collect();
    let neighbour = |x: [usize; 3], o: &[i64; 3]| -> Option<usize> {
        let y: [i64; 3] = std::array::from_fn(|d| x[d] as i64 + o[d]);
        let inside = (0..3).all(|d| y[d] >= 0 && y[d] < size[d] as i64);
        inside.then(|| at(y[0] as usize, y[1] as usize, y[2] as usize))
    };
    let columns = |v: usize, name: &mut dyn FnMut(u32)| {
        name(v as u32);
        offsets.iter().filter_map(|o| neighbour(place(v), o)).for_each(|w| name(w as u32));
    };
    let matrix = Blocks::from_rows(a * b * c, a * b * c, columns, |v, row| {
        let x = place(v);
        for c in 0..3 {
            row.at(v as u32)[c][c] += 1e-3;
        }
        for o in &offsets {
            let Some(w) = neighbour(x, o) else { continue };
            let length = o.iter().map(|v| (v * v) as f64).sum::<f64>();
            for r in 0..3 {
                for s in 0..3 {
                    let stiffness = (o[r] * o[s]) as f64 / length;
                    row.at(v as u32)[r][s] += stiffness;
                    row.at(w as u32)[r][s] -= stiffness;
                }
            }
        }
    });
    let kernel = (0..a * b * c)
        .map(|v| {
            let x = place(v).map(|v| v as f64);
            [[1., 0., 0., 0., x[2], -x[1]], [0., 1., 0., -x[2], 0., x[0]], [0., 0., 1., x[1], -x[0], 0.]]
        })
        .collect();
    (matrix, kernel)
}

/// `Pᵀ (I - S)(A + spring)(I - S) P` the long way.
fn truncated_galerkin(
    a: &Blocks<3, 3>,
    step: &Coarser<3>,
    nodes: &[u32],
    conditions: &[Condition],
) -> Vec<Vec<Block<6, 6>>> {
    let condition = |v: usize| nodes.iter().position(|&n| n as usize == v).map(|k| conditions[k]).unwrap_or_default();
    let p = |v: usize, k: usize| {
        let mut block = step.prolongation.place(v, k).map_or([[0.0; 6]; 3], |place| step.prolongation.value[place]);
        let held = condition(v).held;
        (0..3).filter(|&r| held[r]).for_each(|r| block[r] = [0.0; 6]);
        block
    };
    let coarse = step.matrix.rows;
    let mut result = vec![vec![[[0.0; 6]; 6]; coarse]; coarse];
    for i in 0..a.rows {
        let (columns, blocks) = a.row(i);
        for (&j, block) in columns.iter().zip(blocks) {
            let mut block = *block;
            if j as usize == i {
                let spring = condition(i).spring;
                block.iter_mut().flatten().zip(spring.iter().flatten()).for_each(|(a, s)| *a += s);
            }
            for l in 0..coarse {
                let mut right = [[0.0; 6]; 3];
                add_product(&block, &p(j as usize, l), &mut right);
                for k in 0..coarse {
                    add_transpose_product(&p(i, k), &right, &mut result[k][l]);
                }
            }
        }
    }
    result
}

#[test]
fn local_changes_give_the_galerkin_product_of_the_truncated_prolongation() {
    let (a, kernel) = lattice([7, 5, 4]);
    let nodes: Vec<u32> = (0..a.rows as u32).filter(|v| v % 4 == 0).collect();
    let spring = [[0.0; 3], [0.0, 2.0, -1.0], [0.0, -1.0, 0.5]];
    let conditions: Vec<Condition> = (0..nodes.len())
        .map(|k| match k % 4 {
            0 => Condition { held: [true; 3], ..Default::default() },
            1 => Condition { held: [true, false, false], spring },
            2 => Condition::default(),
            _ => Condition { held: [true, false, false], ..Default::default() },
        })
        .collect();
    let step = coarsen(&a, &kernel, STRONG).unwrap();
    assert_local_changes(&a, &a, &step, &nodes, &conditions);
}

/// The coarse matrix of `a` and its local change beside the product with the matrix `conditioned` the long way.
pub(super) fn assert_local_changes(
    a: &Blocks<3, 3>,
    conditioned: &Blocks<3, 3>,
    step: &Coarser<3>,
    nodes: &[u32],
    conditions: &[Condition],
) {
    let local = truncate::Local::new(a, step, nodes);
    let expected = truncated_galerkin(conditioned, step, nodes, conditions);
    let change = local.change(conditions, step.matrix.rows);
    for k in 0..step.matrix.rows {
        for l in 0..step.matrix.rows {
            let before = step.matrix.place(k, l).map_or([[0.0; 6]; 6], |place| step.matrix.value[place]);
            // What changes has its place in the matrix.
            let room = step.matrix.place(k, l).is_some();
            let row = local.touched[0].iter().position(|&t| t as usize == k);
            let d = row.and_then(|t| change.place(t, l).map(|place| change.value[place])).unwrap_or([[0.0; 6]; 6]);
            for r in 0..6 {
                for c in 0..6 {
                    assert!(room || d[r][c] == 0.0, "no room at {k} {l}");
                    let found = before[r][c] + d[r][c];
                    assert!((found - expected[k][l][r][c]).abs() < 1e-11, "{k} {l}: {found} {}", expected[k][l][r][c]);
                }
            }
        }
    }
}
