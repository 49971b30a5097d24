use super::super::Side;
use super::super::fill::{Map, compliance};
use super::*;
use crate::fem::elements::Law;
use crate::fem::{Material, Solid};
use crate::mesh::v3::add;
use crate::mesh::{Block, BlockElement, block};

#[test]
fn inverses_of_definite_matrices_are_theirs() {
    let a = [[4.0, 1.0, -0.5], [1.0, 3.0, 0.2], [-0.5, 0.2, 5.0]];
    let b = inverse(a);
    for i in 0..3 {
        for j in 0..3 {
            let product: f64 = (0..3).map(|k| a[i][k] * b[k][j]).sum();
            assert!((product - f64::from(u8::from(i == j))).abs() < 1e-5, "{i} {j}: {product}");
            assert_eq!(b[i][j], b[j][i]);
        }
    }
}

/// By elimination of columns.
fn rank(mut rows: Vec<Vec<f64>>) -> usize {
    let largest = rows.iter().flatten().fold(0.0, |most: f64, v| most.max(v.abs()));
    let mut rank = 0;
    while let Some((row, column)) = (rank..rows.len())
        .filter_map(|r| Some((r, (0..rows[r].len()).max_by(|&a, &b| rows[r][a].abs().total_cmp(&rows[r][b].abs()))?)))
        .max_by(|&(r, c), &(s, d)| rows[r][c].abs().total_cmp(&rows[s][d].abs()))
        .filter(|&(r, c)| rows[r][c].abs() > 1e-7 * largest)
    {
        rows.swap(rank, row);
        let (done, rest) = rows.split_at_mut(rank + 1);
        let pivot = &done[rank];
        rest.par_iter_mut().for_each(|row| {
            let factor = row[column] / pivot[column];
            row.iter_mut().zip(pivot).for_each(|(v, p)| *v -= factor * p);
            row[column] = 0.0;
        });
        rank += 1;
    }
    rank
}

/// Tractions that leave every cell balanced are all those of which force and moment vanish; the modes are as many.
#[test]
fn modes_are_all_tractions_that_leave_cells_balanced() {
    let element = BlockElement::Tet4Six;
    let mesh =
        block(&Block { size: [1.0, 1.3, 0.7], cells: [2, 2, 1], origin: [0.0; 3], grading: [1.4, 1.0, 1.0], element })
            .unwrap();
    let materials = [Material { name: "steel".into(), young: 2.0, poisson: 0.3, ..Material::default() }];
    let solid = Solid { mesh: &mesh, materials: &materials, material_of_cell: &vec![0; mesh.cell_count()] };
    let tets = Tets::new(&solid).unwrap();
    let of_material = compliance(&Law::new(&materials[0]));
    let axes: [V3; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let nothing: &[(&str, &[V3])] = &[];
    let held: &[(&str, &[V3])] = &[("x-min", &axes)];
    let planes: &[(&str, &[V3])] = &[("x-min", &axes), ("y-max", &axes[1..2])];
    for sides in [nothing, held, planes] {
        let mut given = Given { side: (0..tets.faces.len()).map(|_| None).collect() };
        for face in (0..tets.faces.len()).filter(|&face| tets.cells_of[face][1] == NONE) {
            given.side[face] = Some(Side { directions: Vec::new(), forces: [[0.0; 3]; 3] });
        }
        for (name, directions) in sides {
            for &face in &mesh.group(name).unwrap().faces {
                let side = &mut given.side[tets.of_boundary[face as usize] as usize];
                side.as_mut().unwrap().directions = directions.to_vec();
            }
        }
        let mut matrices: Vec<Matrix> = vec![[[[0.0; 9]; 9]; 10]; tets.corners.len()];
        for (cell, matrix) in matrices.iter_mut().enumerate() {
            Map::new(&tets.shape(cell)).write_matrix(&of_material, 1.0, matrix);
        }
        let system = System::new(&tets, &given, &[], matrices);
        let faces = tets.faces.len();
        let modes: Vec<Vec<f64>> = (0..9 * faces)
            .map(|at| {
                let mut residual = vec![[0.0; 9]; faces];
                residual[at / 9][at % 9] = 1.0;
                system.precondition(&residual).into_iter().flatten().collect()
            })
            .collect();
        // Of each free traction the forces and moments on the cells.
        let mut columns: Vec<Vec<f64>> = Vec::new();
        for face in 0..faces {
            let all = given.side[face].as_ref().map_or(axes.to_vec(), |side| side.directions.clone());
            let x = tets.faces[face].map(|node| mesh.nodes[node as usize]);
            for a in 0..3 {
                let arm = x.into_iter().fold(x[a], add);
                for &d in &all {
                    let mut column = vec![0.0; 6 * tets.corners.len()];
                    for &cell in tets.cells_of[face].iter().filter(|&&cell| cell != NONE) {
                        let sign = tets.sign(cell as usize, face as u32);
                        let moment = cross(scale(1.0 / 12.0, arm), d);
                        (0..3).for_each(|c| column[6 * cell as usize + c] = sign * d[c] / 3.0);
                        (0..3).for_each(|c| column[6 * cell as usize + 3 + c] = sign * moment[c]);
                    }
                    columns.push(column);
                }
            }
        }
        let free = columns.len();
        let names: Vec<&str> = sides.iter().map(|side| side.0).collect();
        for mode in &modes {
            // No mode leaves a cell out of balance.
            let mut sums = vec![0.0; 6 * tets.corners.len()];
            let values = (0..faces).flat_map(|face| {
                let all = given.side[face].as_ref().map_or(axes.to_vec(), |side| side.directions.clone());
                (0..3).flat_map(move |a| all.clone().into_iter().map(move |d| (9 * face + 3 * a, d)))
            });
            for ((at, d), column) in values.zip(&columns) {
                let value = dot(d, [mode[at], mode[at + 1], mode[at + 2]]);
                sums.iter_mut().zip(column).for_each(|(sum, c)| *sum += value * c);
            }
            let size = mode.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
            assert!(sums.iter().all(|sum| sum.abs() <= 1e-12 * size), "{names:?}");
        }
        assert_eq!(rank(modes), free - rank(columns), "{names:?}");
    }
}
