//! A row of nodes joined by springs lies on a rough floor, each node pressed down by its weight; the first is pulled.
//! Only matrices enter: no mesh.
//!
//! ```sh
//! cargo run --release -p stiction --example row_of_springs
//! ```
//! What to see: slip starts at the pulled end and reaches as many nodes as are needed to carry the pull. With the pull
//! `F`, the limit of friction `g` of a node and `F = 3.5 g`, three nodes slip, the fourth carries `g / 2` and stays, and
//! by statics node 0 moves by `(F - g)/k + (F - 2g)/k + (F - 3g)/k`.
//! What to try next: a larger pull, a coefficient of each node's own, `slip_reference` for a second load step.

use stiction::{ContactProblem, Csr, Error, Friction, PointState, Settings, Status, SymmetricCsr, solve};

const NODES: usize = 8;
const STIFFNESS: f64 = 200.0; // N/mm
const WEIGHT: f64 = 5.0; // N
const COEFFICIENT: f64 = 0.4;
const PULL: f64 = 3.5 * COEFFICIENT * WEIGHT; // N

fn main() -> Result<(), Error> {
    // Unknowns x, y, z of each node. Along x the springs of the row, the last one to a wall; springs to the ground hold
    // y and z, so that K is positive definite.
    let mut k = Vec::new();
    for node in 0..NODES {
        let x = 3 * node;
        k.extend([(x, x, STIFFNESS), (x + 1, x + 1, STIFFNESS), (x + 2, x + 2, STIFFNESS)]);
        if node + 1 < NODES {
            k.extend([(x + 3, x + 3, STIFFNESS), (x, x + 3, -STIFFNESS), (x + 3, x, -STIFFNESS)]);
        }
    }
    let stiffness = SymmetricCsr::from_full(&Csr::from_triplets(3 * NODES, 3 * NODES, &k), "K")?;

    let mut load = vec![0.0; 3 * NODES];
    (0..NODES).for_each(|node| load[3 * node + 2] = -WEIGHT);
    load[0] = PULL;

    // The floor is below: the normal jump is -u_z, the tangential ones are u_x and u_y.
    let row = |node: usize| {
        [(node, 3 * node + 2, -1.0), (NODES + node, 3 * node, 1.0), (2 * NODES + node, 3 * node + 1, 1.0)]
    };
    let jump = Csr::from_triplets(3 * NODES, 3 * NODES, &(0..NODES).flat_map(row).collect::<Vec<_>>());
    let friction = vec![Friction::Coulomb { coefficient: COEFFICIENT }; NODES];
    let problem = ContactProblem::from_matrices(stiffness, load, jump, vec![0.0; NODES], friction);

    let solution = solve(&problem, &Settings::default())?;
    println!("{:?}, certificate {:.1e}", solution.status, solution.certificate.worst);
    for node in 0..NODES {
        let (force, moves) = (solution.lambda[NODES + node], solution.u[3 * node]);
        println!("node {node}: {:?}, friction {force:.4} N, moves {moves:.5} mm", solution.states[node]);
    }
    let limit = COEFFICIENT * WEIGHT;
    let statics = (3.0 * PULL - 6.0 * limit) / STIFFNESS;
    assert_eq!(solution.status, Status::Solved);
    assert!((solution.u[0] - statics).abs() < 1e-7 * statics, "{} and {statics}", solution.u[0]);
    assert!((solution.lambda[NODES + 3] - 0.5 * limit).abs() < 1e-7 * limit);
    assert_eq!(solution.states.iter().filter(|&&s| s == PointState::Slip).count(), 3);
    Ok(())
}

#[test]
fn three_nodes_slip_as_statics_says() {
    main().unwrap();
}
