//! A column of tetrahedra, assembled here by hand, is moved down onto a rough floor and dragged along it. For those who
//! have an assembly of their own: K, f, B, the gap and the coefficient are all that is handed over.
//!
//! ```sh
//! cargo run --release -p stiction --example own_mesh
//! ```
//! What to see: without drag and with a Poisson ratio of zero the state is uniform, the force on the floor is
//! `E A (d - gap) / h`; dragged far enough, friction is the coefficient times that force wherever the floor is met.
//! What to try next: more cells (`N`), `elastic.near_kernel` from coordinates, which multigrid needs beyond some ten
//! thousand unknowns.

use stiction::{ContactProblem, Csr, Error, Friction, Settings, Solution, Status, SymmetricCsr, solve};

const N: usize = 4; // cells along each edge of the unit cube, mm
const YOUNG: f64 = 2000.0; // MPa; the Poisson ratio is zero
const GAP: f64 = 1e-3; // mm between the column and the floor
const DOWN: f64 = 5e-3; // mm that the top is moved down
const COEFFICIENT: f64 = 0.3;

fn node(i: [usize; 3]) -> usize {
    i[0] + (N + 1) * (i[1] + (N + 1) * i[2])
}

fn place(node: usize) -> [f64; 3] {
    [node % (N + 1), node / (N + 1) % (N + 1), node / (N + 1) / (N + 1)].map(|i| i as f64 / N as f64)
}

/// Six tetrahedra a cell, along the paths from its lowest corner to its highest.
fn cells() -> Vec<[usize; 4]> {
    let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let path = |lowest: [usize; 3], order: [usize; 3]| {
        let mut at = lowest;
        let mut step = |axis: usize| {
            at[axis] += 1;
            node(at)
        };
        [node(lowest), step(order[0]), step(order[1]), step(order[2])]
    };
    let corner = |c: usize| [c % N, c / N % N, c / N / N];
    (0..N * N * N).flat_map(|c| orders.map(|order| path(corner(c), order))).collect()
}

/// Gradients of the four linear functions, and the volume.
fn gradients(cell: [usize; 4]) -> ([[f64; 3]; 4], f64) {
    let [o, a, b, c] = cell.map(place);
    let edge = |p: [f64; 3]| [p[0] - o[0], p[1] - o[1], p[2] - o[2]];
    let [a, b, c] = [edge(a), edge(b), edge(c)];
    let cross =
        |p: [f64; 3], q: [f64; 3]| [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
    let det = cross(a, b).iter().zip(c).map(|(x, y)| x * y).sum::<f64>();
    let [ga, gb, gc] = [cross(b, c), cross(c, a), cross(a, b)].map(|g| g.map(|x| x / det));
    ([[0, 1, 2].map(|i| -ga[i] - gb[i] - gc[i]), ga, gb, gc], det.abs() / 6.0)
}

/// Solves the column whose top is moved down and by `drag` along x.
fn column(drag: f64) -> Result<Solution, Error> {
    let (layer, nodes) = ((N + 1) * (N + 1), (N + 1) * (N + 1) * (N + 1));
    let free = 3 * (nodes - layer); // the nodes of the top come last: their displacements are prescribed
    let imposed = |dof: usize| [drag, 0.0, -DOWN][dof % 3];
    let (mut k, mut f) = (Vec::new(), vec![0.0; free]);
    for cell in cells() {
        let (g, volume) = gradients(cell);
        for (a, ga) in cell.into_iter().zip(g) {
            for (b, gb) in cell.into_iter().zip(g) {
                let dot: f64 = ga.iter().zip(gb).map(|(x, y)| x * y).sum();
                for (i, gb_i) in gb.into_iter().enumerate() {
                    for (j, ga_j) in ga.into_iter().enumerate() {
                        // Without contraction the stress is E times the strain, (grad u + grad u')/2.
                        let same = if i == j { dot } else { 0.0 };
                        let value = 0.5 * YOUNG * volume * (same + ga_j * gb_i);
                        match (3 * a + i, 3 * b + j) {
                            (row, column) if row < free && column < free => k.push((row, column, value)),
                            (row, column) if row < free => f[row] -= value * imposed(column),
                            _ => {}
                        }
                    }
                }
            }
        }
    }
    let rows = |p: usize| [(p, 3 * p + 2, -1.0), (layer + p, 3 * p, 1.0), (2 * layer + p, 3 * p + 1, 1.0)];
    let b = Csr::from_triplets(3 * layer, free, &(0..layer).flat_map(rows).collect::<Vec<_>>());
    let k = SymmetricCsr::from_full(&Csr::from_triplets(free, free, &k), "K")?;
    let friction = vec![Friction::Coulomb { coefficient: COEFFICIENT }; layer];
    let mut problem = ContactProblem::from_matrices(k, f, b, vec![GAP; layer], friction);
    problem.elastic.node_of = Some((0..free as u32).map(|dof| dof / 3).collect()); // orders faster; not needed
    solve(&problem, &Settings::default())
}

fn main() -> Result<(), Error> {
    let layer = (N + 1) * (N + 1);
    let forces = |s: &Solution| [0, 1].map(|row| s.lambda[row * layer..(row + 1) * layer].iter().sum::<f64>());
    let uniform = YOUNG * (DOWN - GAP); // the area and the height are one
    for drag in [0.0, 0.05] {
        let solution = column(drag)?;
        let [normal, friction] = forces(&solution);
        println!(
            "dragged by {drag} mm: {:?}, force on the floor {normal:.4} N, friction {friction:.4} N",
            solution.status
        );
        assert_eq!(solution.status, Status::Solved);
        if drag == 0.0 {
            assert!((normal - uniform).abs() < 1e-6 * uniform, "{normal} and {uniform}");
        } else {
            assert!((friction - COEFFICIENT * normal).abs() < 1e-3 * friction, "{friction} and {normal}");
        }
    }
    Ok(())
}

#[test]
fn the_column_presses_as_hooke_says_and_slides_as_coulomb_says() {
    main().unwrap();
}
