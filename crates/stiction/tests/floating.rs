//! Bodies held by contact alone.

mod common;

use common::*;
use stiction::contact::SurfaceFriction;
use stiction::contact::rigid::rigid_motions;
use stiction::linalg::{max_abs, norm};
use stiction::mesh::BlockElement;

const YOUNG: f64 = 2.1e11;
const ELEMENTS: [BlockElement; 2] = [BlockElement::Tet4Six, BlockElement::Hex8];

/// Turned about a skew axis, and far from the origin.
fn turned(mut case: Case, degrees: f64) -> Case {
    let (axis, (s, c)) = ([1.0 / 3.0, 2.0 / 3.0, 2.0 / 3.0], degrees.to_radians().sin_cos());
    for x in &mut case.mesh.nodes {
        let along: f64 = (0..3).map(|k| axis[k] * x[k]).sum();
        let across = [0, 1, 2].map(|k| axis[(k + 1) % 3] * x[(k + 2) % 3] - axis[(k + 2) % 3] * x[(k + 1) % 3]);
        *x = [0, 1, 2].map(|k| c * x[k] + s * across[k] + (1.0 - c) * along * axis[k] + 30.0);
    }
    case
}

#[test]
fn rigid_motions_are_those_that_no_support_stops() {
    let z = |held: bool| [None, None, held.then_some(0.0)];
    for element in ELEMENTS {
        let block = || block_of([3.0, 1.0, 0.5], [6, 3, 2], element, YOUNG, 0.3);
        let corner = |case: Case| {
            let x = case.mesh.nodes[0];
            let nodes: Vec<u32> =
                (0..case.mesh.nodes.len() as u32).filter(|&n| case.mesh.nodes[n as usize] == x).collect();
            let mut case = case;
            case.fixes
                .push(stiction::fem::Fix { nodes, value: [const { Some(stiction::fem::Field::Constant(0.0)) }; 3] });
            case
        };
        let cases = [
            (block(), 6),
            (turned(block(), 30.0), 6),
            (block().fix("z-min", z(true)), 3),
            (turned(block(), 30.0).fix("z-min", z(true)), 3),
            (block().fix("z-min", z(true)).fix("y-min", [None, Some(0.0), None]), 1),
            (corner(block()), 3),
            (corner(turned(block(), 30.0)), 3),
            (block().fix("x-min", HELD), 0),
        ];
        for (number, (case, count)) in cases.into_iter().enumerate() {
            let free = block().fix("x-min", HELD).contact("z-min", FLOOR, SurfaceFriction::None).pose().problem;
            let mut model = case.assemble();
            let (problem, _) = stiction::contact::pose(&case.mesh, &mut model, &[]).unwrap();
            let motions = rigid_motions(&problem);
            assert_eq!(motions.len(), count, "case {number} {element:?}");
            // Unstrained, orthonormal, and stopped by the fixing unknowns.
            let unit = |k: usize| (0..count).map(|j| f64::from(u8::from(j == k))).collect::<Vec<f64>>();
            for k in 0..count {
                let mut u = vec![0.0; problem.unknowns()];
                motions.add(&unit(k), &mut u);
                assert!((norm(&u) - 1.0).abs() < 1e-12);
                assert!(max_abs(&problem.K.times(&u)) < 1e-12 * problem.K.max_abs());
                assert!(motions.work(&u).iter().zip(unit(k)).all(|(w, e)| (w - e).abs() < 1e-12));
                let moved = motions.fixing().iter().map(|&i| u[i as usize].powi(2)).sum::<f64>().sqrt();
                assert!(moved > 0.3 / (problem.unknowns() as f64).sqrt());
            }
            assert!(rigid_motions(&free).is_empty());
        }
    }
}
