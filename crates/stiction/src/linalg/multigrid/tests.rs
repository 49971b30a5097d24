use super::blocks::{Block, Blocks};
use super::coarsen::{Coarser, Kernel, galerkin};
use super::dense::{add_product, add_transpose_product};
use super::distance::place;
use super::packed::Single;
use super::*;

/// On one rank.
pub(super) fn coarsen<const R: usize>(
    a: &Blocks<R, R>,
    kernel: &[Kernel<R>],
    threshold: f64,
    wanted: &[u32],
) -> Result<Option<Coarser<R>>, Error> {
    super::coarsen(a, &Halo::alone(a.rows), kernel, threshold, &[], None, wanted)
}

/// A lattice of springs along edges and face diagonals with steps of these lengths, weakly supported everywhere: an
/// elastic body without elements.
pub(super) fn lattice(size: [usize; 3], step: [f64; 3]) -> (Blocks<3, 3>, Vec<Kernel<3>>) {
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
            let along: [f64; 3] = std::array::from_fn(|d| o[d] as f64 * step[d]);
            let length = along.iter().map(|v| v * v).sum::<f64>();
            for r in 0..3 {
                for s in 0..3 {
                    let stiffness = along[r] * along[s] / length;
                    row.at(v as u32)[r][s] += stiffness;
                    row.at(w as u32)[r][s] -= stiffness;
                }
            }
        }
    });
    let kernel = (0..a * b * c)
        .map(|v| {
            let at = place(v);
            let x: [f64; 3] = std::array::from_fn(|d| at[d] as f64 * step[d]);
            [[1., 0., 0., 0., x[2], -x[1]], [0., 1., 0., -x[2], 0., x[0]], [0., 0., 1., x[1], -x[0], 0.]]
        })
        .collect();
    (matrix, kernel)
}

/// `Pᵀ (I - S)(A + spring)(I - S) P` the long way.
fn truncated_galerkin<const C: usize>(
    a: &Blocks<3, 3>,
    step: &Coarser<3, C>,
    nodes: &[u32],
    constraints: &[NodeConstraint],
) -> Vec<Vec<Block<C, C>>> {
    let constraint = |v: usize| nodes.iter().position(|&n| n as usize == v).map(|k| constraints[k]).unwrap_or_default();
    let p = |v: usize, k: usize| {
        let mut block = step.prolongation.place(v, k).map_or([[0.0; C]; 3], |place| step.prolongation.value[place]);
        let constrained = constraint(v).constrained;
        (0..3).filter(|&r| constrained[r]).for_each(|r| block[r] = [0.0; C]);
        block
    };
    let coarse = step.matrix.rows;
    let mut result = vec![vec![[[0.0; C]; C]; coarse]; coarse];
    for i in 0..a.rows {
        for (j, block) in a.entries_of(i) {
            let mut block = *block;
            if j as usize == i {
                let spring = constraint(i).spring;
                block.iter_mut().flatten().zip(spring.iter().flatten()).for_each(|(a, s)| *a += s);
            }
            for l in 0..coarse {
                let mut right = [[0.0; C]; 3];
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
fn places_are_read_from_turned_rigid_motions_and_aggregates_have_their_centre() {
    let (a, mut kernel) = lattice([4, 4, 4], [20.0, 1.0, 1.0]);
    // A node in a frame of its own, and one that can move along y and z only.
    let (c, s) = (0.6, 0.8);
    let [x, y, z] = kernel[21];
    kernel[21] = [z, std::array::from_fn(|q| c * x[q] + s * y[q]), std::array::from_fn(|q| c * y[q] - s * x[q])];
    kernel[42][0] = [0.0; 6];
    let near = |p: [f64; 3], q: [f64; 3]| (0..3).all(|d| (p[d] - q[d]).abs() < 1e-12);
    assert!(near(place(&kernel[21]), [20.0, 1.0, 1.0]) && near(place(&kernel[42]), [40.0, 2.0, 2.0]));
    // Without turns there are no places, and nothing is far.
    let flat: Vec<Kernel<3>> = kernel.iter().map(|k| k.map(|r| [r[0], r[1], r[2], 0.0, 0.0, 0.0])).collect();
    let (norms, halo) = (aggregate::diagonal_norms(&a), Halo::alone(a.rows));
    let strong = aggregate::strong(&a, &norms, Threshold::STRONG);
    assert_eq!(distance::near(&a, &halo, &distance::places(&a, &halo, &norms, &flat), &strong), strong);
    // With them only couplings within a plane across x stay.
    let kept = distance::near(&a, &halo, &distance::places(&a, &halo, &norms, &kernel), &strong);
    for i in 0..a.rows {
        for place in a.start[i]..a.start[i + 1] {
            let j = a.column[place] as usize;
            assert_eq!(kept[place], strong[place] && i / 16 == j / 16, "{i} {j}");
        }
    }
    // No aggregate reaches across x.
    let step = coarsen(&a, &lattice([4, 4, 4], [20.0, 1.0, 1.0]).1, Threshold::STRONG, &[]).unwrap().unwrap();
    let x: Vec<f64> = step.kernel.iter().map(|k| place(k)[0]).collect();
    assert!(x.iter().all(|x| (x / 20.0 - (x / 20.0).round()).abs() < 1e-12), "{x:?}");
}

#[test]
fn what_is_out_of_reach_leaves_the_near_kernel_as_it_is_also_beside_a_support() {
    // Nodes on the plane x = 0 are held, nothing reaches along y, where A does. P B_c - B is a step omega D⁻¹ of the forces on
    // the translation that moves the neighbours as it moves the node: zero without the support, and no motion is as long as
    // the cells along y, 20, which the entries of a basis would have to make up for.
    let (mut a, mut kernel) = lattice([6, 7, 5], [1.0, 20.0, 1.0]);
    let is_held = |v: usize| v < 35;
    for v in 0..a.rows {
        for place in a.start[v]..a.start[v + 1] {
            let w = a.column[place] as usize;
            if w != v && (is_held(v) || is_held(w)) {
                a.value[place] = [[0.0; 3]; 3];
            }
        }
    }
    (0..a.rows).filter(|&v| is_held(v)).for_each(|v| kernel[v] = [[0.0; 6]; 3]);
    let step = coarsen(&a, &kernel, Threshold::STRONG, &[]).unwrap().unwrap();
    let mut omega = 0.0;
    for i in (0..a.rows).filter(|&i| !is_held(i)) {
        let here = place(&kernel[i]);
        let mut sum = [[0.0; 3]; 3];
        a.entries_of(i).filter(|(j, _)| !is_held(*j as usize)).for_each(|(_, block)| {
            sum.iter_mut().flatten().zip(block.iter().flatten()).for_each(|(s, a)| *s += a);
        });
        let mut moved = [[0.0; 6]; 3];
        add_product(&sum, &kernel[i], &mut moved);
        let mut change = kernel[i].map(|r| r.map(|v| -v));
        for (k, p) in step.prolongation.entries_of(i) {
            assert!((place(&step.kernel[k as usize])[1] - here[1]).abs() < 1e-9);
            assert!(p.iter().flatten().all(|p| p.abs() <= 1.0), "{i}: {p:?}");
            add_product(p, &step.kernel[k as usize], &mut change);
        }
        let mut force = [[0.0; 6]; 3];
        add_product(&a.diagonal(i), &change, &mut force);
        if omega == 0.0 {
            omega = -force[0][0] / moved[0][0];
            assert!(omega > 0.3 && omega < 2.0, "{omega}");
        }
        for (f, s) in force.iter().flatten().zip(moved.iter().flatten()) {
            assert!((f + omega * s).abs() < 1e-9, "{i}: {f} {s}");
        }
    }
}

#[test]
fn a_cycle_reads_little_more_than_the_finest_matrix_and_a_few_times_that_on_flat_cells() {
    // Fully coarsened, 27 blocks of 36 numbers stand for 27 nodes of 19 blocks of 9, and boundaries add to that; along
    // lines of three nodes for three of them (27 x 36 against 3 x 19 x 9, 1.9 times, and a third of it on each level).
    for (step, most) in [([1.0; 3], 1.6), ([20.0, 1.0, 1.0], 2.2), ([20.0, 20.0, 1.0], 4.0)] {
        let (a, kernel) = lattice([13, 13, 13], step);
        let levels = Hierarchy::new(&RelativeMatrix::new(a.clone(), None), &kernel, &[], 0, None, &Stop::never())
            .unwrap()
            .unwrap()
            .level_sizes();
        let all: usize = levels.iter().map(|l| l.1).sum();
        let complexity = all as f64 / levels[0].1 as f64;
        assert!(complexity < most, "{step:?}: {complexity} {levels:?}");
        assert!(levels.last().unwrap().0 <= Threshold::COARSEST_NODES, "{levels:?}");
    }
}

#[test]
fn local_changes_give_the_galerkin_product_of_the_truncated_prolongation() {
    for step in [[1.0; 3], [20.0, 1.0, 1.0]] {
        local_changes_are_exact(lattice([7, 5, 4], step));
    }
}

fn local_changes_are_exact((a, kernel): (Blocks<3, 3>, Vec<Kernel<3>>)) {
    let nodes: Vec<u32> = (0..a.rows as u32).filter(|v| v % 4 == 0).collect();
    let spring = [[0.0; 3], [0.0, 2.0, -1.0], [0.0, -1.0, 0.5]];
    let constraints: Vec<NodeConstraint> = (0..nodes.len())
        .map(|k| match k % 4 {
            0 => NodeConstraint { constrained: [true; 3], ..Default::default() },
            1 => NodeConstraint { constrained: [true, false, false], spring, ..Default::default() },
            2 => NodeConstraint::default(),
            _ => NodeConstraint { constrained: [true, false, false], ..Default::default() },
        })
        .collect();
    let step = coarsen(&a, &kernel, Threshold::STRONG, &nodes).unwrap().unwrap();
    assert_local_changes(&a, &a, &step, &nodes, &constraints);
}

/// Every other node of the lattice's lines is in the middle between its neighbours; the others are the corners of a lattice
/// twice as coarse.
fn linear_space(size: [usize; 3]) -> LinearSpace {
    let [a, b, c] = size;
    let place = |v: usize| [v / (b * c), v / c % b, v % c];
    let at = |x: [usize; 3]| (x[0] * b + x[1]) * c + x[2];
    let is_corner = |v: usize| place(v).iter().all(|x| x % 2 == 0);
    let corners: Vec<usize> = (0..a * b * c).filter(|&v| is_corner(v)).collect();
    let number = |v: usize| corners.binary_search(&v).unwrap() as u32;
    let scaled = |w: f64| [[w, 0.0, 0.0], [0.0, w, 0.0], [0.0, 0.0, w]];
    let row = |v: usize| {
        let x = place(v);
        let odd: Vec<usize> = (0..3).filter(|&d| x[d] % 2 == 1).collect();
        let ends = (0..1usize << odd.len()).map(|which| {
            let mut y = x;
            odd.iter().enumerate().for_each(|(k, &d)| y[d] = x[d] + 2 * (which >> k & 1) - 1);
            (number(at(y)), scaled(1.0 / (1 << odd.len()) as f64))
        });
        ends.collect::<Vec<_>>()
    };
    let rows: Vec<_> = (0..a * b * c).map(row).collect();
    let kernel = lattice(size, [1.0; 3]).1;
    let named = |v: usize, name: &mut dyn FnMut(u32)| rows[v].iter().for_each(|entry| name(entry.0));
    let fill = |v: usize, row: &mut blocks::Row<'_, 3, 3>| rows[v].iter().for_each(|(k, block)| *row.at(*k) = *block);
    let prolongation = Blocks::from_rows(a * b * c, corners.len(), named, fill);
    let halo = Halo::alone(corners.len());
    let ends = vec![[NO_NODE; 2]; corners.len()];
    LinearSpace { prolongation, kernel: corners.iter().map(|&v| kernel[v]).collect(), halo, ends }
}

#[test]
fn local_changes_of_the_linear_level_and_below_it_are_those_of_the_truncated_functions() {
    let (a, kernel) = lattice([7, 5, 5], [1.0; 3]);
    let space = linear_space([7, 5, 5]);
    let nodes: Vec<u32> = (0..a.rows as u32).filter(|v| v % 3 == 0).collect();
    let spring = [[0.0; 3], [0.0, 2.0, -1.0], [0.0, -1.0, 0.5]];
    let kinds = [
        NodeConstraint { constrained: [true; 3], ..Default::default() },
        NodeConstraint { constrained: [true, false, false], spring, ..Default::default() },
        NodeConstraint::default(),
    ];
    let constraints: Vec<NodeConstraint> = (0..nodes.len()).map(|k| kinds[k % 3]).collect();
    let (matrix, a_times_p) = galerkin(&a, &space.prolongation, &nodes).unwrap();
    let LinearSpace { prolongation, kernel: corners, halo, .. } = space.clone();
    let step = Coarser { prolongation, a_times_p, matrix, kernel: corners, halo };
    assert_local_changes(&a, &a, &step, &nodes, &constraints);
    // The aggregated level below: functions of the linear level, truncated on the finest one.
    let below = coarsen(&step.matrix, &step.kernel, Threshold::STRONG, &[]).unwrap().unwrap();
    let support = truncation::Support::of_step(&step, &nodes).within(&below.prolongation);
    let columns = |i: usize, name: &mut dyn FnMut(u32)| {
        step.prolongation
            .row(i)
            .0
            .iter()
            .for_each(|&j| below.prolongation.row(j as usize).0.iter().for_each(|&k| name(k)));
    };
    let prolongation = Blocks::from_rows(a.rows, below.matrix.rows, columns, |i, row| {
        for (j, block) in step.prolongation.entries_of(i) {
            below.prolongation.entries_of(j as usize).for_each(|(k, value)| add_product(block, value, row.at(k)));
        }
    });
    let whole = Coarser { prolongation, a_times_p: Blocks::default(), ..below };
    let expected = truncated_galerkin(&a, &whole, &nodes, &constraints);
    let touched = support.touched();
    let (all, halo) = (RelativeMatrix::new(a.clone(), None), Halo::alone(nodes.len()));
    let truncation = truncation::Truncation::new(&all, &nodes, (halo, &[]), Default::default(), &Halo::alone(0));
    let change = truncation.change(
        &support,
        &touched,
        [&vec![Default::default(); nodes.len()], &constraints],
        whole.matrix.rows,
    );
    let mut matrix = vec![vec![[[0.0; 6]; 6]; whole.matrix.rows]; whole.matrix.rows];
    for k in 0..whole.matrix.rows {
        whole.matrix.entries_of(k).for_each(|(l, block)| matrix[k][l as usize] = *block);
    }
    for (t, &k) in touched.iter().enumerate() {
        for (l, block) in change.entries_of(t) {
            let sum = matrix[k as usize][l as usize].iter_mut().flatten();
            sum.zip(block.iter().flatten()).for_each(|(sum, d)| *sum += d);
        }
    }
    let values = |m: Vec<Vec<Block<6, 6>>>| m.into_iter().flatten().flatten().flatten();
    for (found, expected) in values(matrix).zip(values(expected)) {
        assert!((found - expected).abs() < 1e-11, "{found} {expected}");
    }
    // Cycles with the linear level contract, and what is constrained does not move.
    let mut hierarchy = Hierarchy::new(
        &RelativeMatrix::new(a.clone(), None),
        &kernel,
        &nodes,
        nodes.len(),
        Some(space),
        &Stop::never(),
    )
    .unwrap()
    .unwrap();
    hierarchy.constrain(&constraints, CoarseLevels::ChangeCoupled, true);
    let truncated = |x: &mut Vec<[f64; 3]>| {
        for (&v, constraint) in nodes.iter().zip(&constraints) {
            (0..3).filter(|&c| constraint.constrained[c]).for_each(|c| x[v as usize][c] = 0.0);
        }
    };
    let stiff = |x: &[[f64; 3]]| {
        let mut y = a.times(x);
        for (&v, constraint) in nodes.iter().zip(&constraints) {
            for (r, row) in constraint.spring.iter().enumerate() {
                y[v as usize][r] += (0..3).map(|c| row[c] * x[v as usize][c]).sum::<f64>();
            }
        }
        truncated(&mut y);
        y
    };
    let mut x: Vec<[f64; 3]> = scattered(a.rows, 5).iter().map(|x: &[f32; 3]| x.map(f64::from)).collect();
    truncated(&mut x);
    let start = dot(&x, &stiff(&x));
    for _ in 0..10 {
        let r = stiff(&x);
        let z = hierarchy.cycle(&r);
        let mut same = z.clone();
        truncated(&mut same);
        assert_eq!(same, z);
        let step = dot(&r, &z) / dot(&z, &stiff(&z));
        x.iter_mut().flatten().zip(z.iter().flatten()).for_each(|(x, z)| *x -= step * z);
    }
    let left = dot(&x, &stiff(&x)) / start;
    assert!(left < 1e-7, "{left:e}");
}

/// A block with a slipping face, and its constrained hierarchy.
struct SlippingFace {
    a: Blocks<3, 3>,
    nodes: Vec<u32>,
    constraints: Vec<NodeConstraint>,
    hierarchy: Hierarchy,
}

const COULOMB: [f64; 2] = [0.3, -0.4];

impl SlippingFace {
    fn new() -> Self {
        let (a, kernel) = lattice([25, 21, 23], [1.0; 3]);
        // One face, whose normal component comes first; a node in seven is open.
        let nodes: Vec<u32> = (0..a.rows as u32).filter(|&v| place(&kernel[v as usize])[0] < 0.5).collect();
        let slips = NodeConstraint { constrained: [true, false, false], coulomb: COULOMB, ..Default::default() };
        let constraints: Vec<NodeConstraint> =
            (0..nodes.len()).map(|k| if k % 7 == 0 { NodeConstraint::default() } else { slips }).collect();
        let mut hierarchy =
            Hierarchy::new(&RelativeMatrix::new(a.clone(), None), &kernel, &nodes, nodes.len(), None, &Stop::never())
                .unwrap()
                .unwrap();
        hierarchy.constrain(&constraints, CoarseLevels::ChangeCoupled, true);
        SlippingFace { a, nodes, constraints, hierarchy }
    }

    /// Displacements of the first coarse level on the finest.
    fn fine(&self, x: &[[f32; 6]]) -> Vec<[f64; 3]> {
        let mut up = vec![[0.0; 3]; self.a.rows];
        self.hierarchy.first.add_times(x, &mut up);
        up.iter().map(|x| x.map(f64::from)).collect()
    }

    fn truncated(&self, x: &[[f32; 6]]) -> Vec<[f64; 3]> {
        let mut u = self.fine(x);
        let constrained = self.nodes.iter().zip(&self.constraints).filter(|(_, c)| c.constrained[0]);
        constrained.for_each(|(&v, _)| u[v as usize][0] = 0.0);
        u
    }

    fn lifted(&self, x: &[[f32; 6]]) -> Vec<[f64; 3]> {
        let mut up = vec![[0.0; 6]; x.len()];
        let lifts = self.hierarchy.coulomb_coupling.lifts.iter();
        lifts.for_each(|(k, lift)| packed::add(lift, &x[*k as usize], &mut up[*k as usize]));
        self.fine(&up)
    }
}

/// Numbers between -1/2 and 1/2 without order.
fn scattered<const R: usize>(size: usize, from: usize) -> Vec<[f32; R]> {
    let value = |i: usize| (f64::from((i * 7919 % 1009) as u32) / 1009.0 - 0.5) as f32;
    (0..size).map(|i| std::array::from_fn(|c| value(from + R * i + c))).collect()
}

fn dot<A: Copy + Into<f64>, const R: usize>(a: &[[A; R]], b: &[[A; R]]) -> f64 {
    a.iter().flatten().zip(b.iter().flatten()).map(|(&a, &b)| a.into() * b.into()).sum()
}

/// The coupling's part of the second coarse level, by the functions themselves: `-(lifts of the tests)ᵀ A (functions truncated
/// at constrained components)`.
#[test]
fn the_coulomb_coupling_is_tested_by_lifts_and_lifts_fit_the_coupled_tangential_motion() {
    let face = SlippingFace::new();
    let SlippingFace { a, nodes, constraints, hierarchy } = &face;
    let size = hierarchy.coarse.get(1).map_or(hierarchy.halos[1].own(), |level| level.matrix.rows);
    let (x, test) = (scattered(size, 0), scattered(size, 333));
    let mut found = vec![[0.0f32; 6]; size];
    hierarchy.subtract_coulomb(1, &x, &mut found);
    let first = |x: &[[f32; 6]]| {
        let mut up = vec![[0.0; 6]; hierarchy.coarse[0].matrix.rows];
        hierarchy.further[0].add_times(x, &mut up);
        up
    };
    let force = a.times(&face.truncated(&first(&x)));
    let (given, expected) = (dot(&test, &found), dot(&face.lifted(&first(&test)), &force));
    assert!((given - expected).abs() < 1e-4 * expected.abs(), "{given} {expected}");
    // The motion along the face of the first coarse level: lifts move the face by about the coupled part, each by its own fit.
    let (_, kernel) = lattice([25, 21, 23], [1.0; 3]);
    let step = coarsen(a, &kernel, Threshold::STRONG, nodes).unwrap().unwrap();
    let along: Vec<[f32; 6]> = step.kernel.iter().map(|k| std::array::from_fn(|c| k[c][1] as f32)).collect();
    let up = face.lifted(&along);
    let mean = nodes.iter().map(|&v| up[v as usize][0]).sum::<f64>() / nodes.len() as f64;
    let part = constraints.iter().filter(|c| c.constrained[0]).count() as f64 / nodes.len() as f64;
    assert!((mean / (part * COULOMB[0]) - 1.0).abs() < 0.25, "{mean}");
}

/// What constraints add to the coarse levels one after the other is what the last ones add to levels without any.
#[test]
fn constraints_that_follow_each_other_leave_the_coarse_levels_of_the_last_ones() {
    let SlippingFace { nodes, constraints, hierarchy: renewed, .. } = SlippingFace::new();
    let mut followed = renewed.clone();
    let stiff = [[0.0; 3], [0.0, 4e3, 1e3], [0.0, 1e3, 2e3]];
    for pass in [3, 5, 2] {
        let other = |k: usize| match k % pass {
            0 => NodeConstraint { constrained: [true; 3], ..Default::default() },
            1 => NodeConstraint { constrained: [true, false, false], spring: stiff, ..Default::default() },
            _ => constraints[k],
        };
        let others: Vec<NodeConstraint> = (0..nodes.len()).map(other).collect();
        followed.constrain(&others, CoarseLevels::ChangeCoupled, true);
    }
    followed.constrain(&constraints, CoarseLevels::ChangeCoupled, true);
    for (found, expected) in followed.coarse.iter().zip(&renewed.coarse) {
        let values = |of: &[Single<6, 6>]| of.as_flattened().as_flattened().to_vec();
        let [a, b] = [found, expected].map(|level| values(&level.matrix.value));
        let [inverse, other] = [found, expected].map(|level| values(&level.inverse));
        assert!(a.iter().zip(&b).all(|(a, b)| (a - b).abs() < 1e-6) && a.len() > 1000);
        let largest = other.iter().fold(0.0, |most: f32, x| most.max(x.abs()));
        assert!(inverse.iter().zip(&other).all(|(a, b)| (a - b).abs() < 1e-5 * largest));
    }
    let x = scattered::<3>(followed.fine.matrix.rows, 7).iter().map(|x| x.map(f64::from)).collect::<Vec<_>>();
    let largest = |x: &[[f64; 3]]| x.iter().flatten().fold(0.0, |most: f64, x| most.max(x.abs()));
    let (found, expected) = (followed.cycle(&x), renewed.cycle(&x));
    let off: Vec<[f64; 3]> = found.iter().zip(&expected).map(|(a, b)| std::array::from_fn(|c| a[c] - b[c])).collect();
    assert!(largest(&off) < 1e-4 * largest(&expected), "{:e}", largest(&off) / largest(&expected));
}

/// The work of the residual on the functions of the first coarse level, truncated at constrained components, less that on their
/// lifts; the residual is that of the matrix itself, though the sweeps solve the coupled rows.
#[test]
fn the_restricted_residual_is_that_on_truncated_functions_less_that_on_lifts() {
    let face = SlippingFace::new();
    let SlippingFace { a, nodes, constraints, hierarchy } = &face;
    let mut b: Vec<[f32; 3]> = scattered(a.rows, 77);
    nodes.iter().zip(constraints).filter(|(_, c)| c.constrained[0]).for_each(|(&v, _)| b[v as usize][0] = 0.0);
    let (x, left) = hierarchy.fine.forward(&b);
    let truncated = hierarchy.truncated_residual(&x, left);
    let mut found = hierarchy.first.transpose_times(&truncated, hierarchy.first_coarse());
    hierarchy.subtract_lifted(&x, &mut found);
    let mut residual = a.times(&x.iter().map(|x| x.map(f64::from)).collect::<Vec<_>>());
    for (r, b) in residual.iter_mut().flatten().zip(b.iter().flatten()) {
        *r = f64::from(*b) - *r;
    }
    // One test that does not vary and one without order.
    let even = vec![[0.0, 1.0, 1.0, 0.0, 0.0, 0.0]; found.len()];
    for test in [even, scattered(found.len(), 333)] {
        let on_lifts = dot(&face.lifted(&test), &residual);
        let expected = dot(&face.truncated(&test), &residual) - on_lifts;
        let given = dot(&test, &found);
        assert!((given - expected).abs() < 1e-3 * on_lifts.abs().min(expected.abs()), "{given} {expected} {on_lifts}");
    }
}

#[test]
fn the_coarse_problem_is_that_of_the_finest_level_in_a_smaller_space() {
    let (a, kernel) = lattice([25, 21, 23], [1.0; 3]);
    let nodes: Vec<u32> = (0..a.rows as u32).filter(|v| v % 5 == 0).collect();
    let mut hierarchy =
        Hierarchy::new(&RelativeMatrix::new(a.clone(), None), &kernel, &nodes, nodes.len(), None, &Stop::never())
            .unwrap()
            .unwrap();
    // Earlier constraints of the levels do not matter.
    hierarchy.constrain(
        &vec![NodeConstraint { constrained: [true; 3], ..Default::default() }; nodes.len()],
        CoarseLevels::Change,
        true,
    );
    let spring = [[3.0, 0.0, 0.0], [0.0, 2.0, -1.0], [0.0, -1.0, 0.5]];
    let mut coarse = CoarseProblem::new(&mut hierarchy).unwrap();
    let f: Vec<[f64; 3]> = (0..a.rows).map(|i| [1.0, (i % 3) as f64, (i % 7) as f64 - 3.0]).collect();
    let f_coarse = coarse.restrict(&f);
    let pulls = |u: &[[f64; 3]]| -> Vec<[f64; 3]> {
        u.iter().map(|u| spring.map(|row| row.iter().zip(u).map(|(s, u)| s * u).sum())).collect()
    };
    coarse.set_springs(&vec![spring; nodes.len()]);
    let mut x = vec![[0.0; 6]; f_coarse.len()];
    let size = |r: &[[f64; 6]]| r.iter().flatten().map(|v| v * v).sum::<f64>().sqrt();
    let residual = |coarse: &CoarseProblem, x: &[[f64; 6]]| -> Vec<[f64; 6]> {
        let (inner, springs) = (coarse.times(x), coarse.restrict_from_nodes(&pulls(&coarse.to_nodes(x))));
        let all = f_coarse.iter().zip(inner).zip(springs);
        all.map(|((f, inner), springs)| std::array::from_fn(|c| f[c] - inner[c] - springs[c])).collect()
    };
    for _ in 0..40 {
        let r = residual(&coarse, &x);
        // The same residual by way of the finest level.
        let u = coarse.prolong(&x);
        let mut fine = a.times(&u);
        fine.iter_mut().flatten().zip(f.iter().flatten()).for_each(|(r, f)| *r = f - *r);
        let at_nodes: Vec<[f64; 3]> = nodes.iter().map(|&v| u[v as usize]).collect();
        for (&v, pull) in nodes.iter().zip(pulls(&at_nodes)) {
            (0..3).for_each(|c| fine[v as usize][c] -= pull[c]);
        }
        for (r, s) in r.iter().flatten().zip(coarse.restrict(&fine).iter().flatten()) {
            assert!((r - s).abs() < 1e-4 * size(&f_coarse), "{r} {s}");
        }
        let z = coarse.cycle(&r);
        x.iter_mut().flatten().zip(z.iter().flatten()).for_each(|(x, z)| *x += z);
    }
    // Cycles that knew of other springs would not converge to the solution with these.
    let r = residual(&coarse, &x);
    assert!(size(&r) < 1e-4 * size(&f_coarse), "{:e}", size(&r) / size(&f_coarse));
}

/// Compared with the displacement of a node on the surface under a unit force on it, of which the node's own compliance
/// is only a tenth in flat cells.
#[test]
fn the_levels_contain_the_compliance_of_a_node_in_flat_cells_too() {
    for step in [[1.0; 3], [20.0, 20.0, 1.0]] {
        let (a, kernel) = lattice([13, 13, 13], step);
        let node = (6 * 13 + 6) * 13;
        let hierarchy =
            Hierarchy::new(&RelativeMatrix::new(a.clone(), None), &kernel, &[node as u32], 1, None, &Stop::never())
                .unwrap()
                .unwrap();
        let (own, coarse) = (inverse(&a.diagonal(node)), hierarchy.coarse_compliances()[0]);
        for c in 0..3 {
            let mut u = vec![[0.0; 3]; a.rows];
            for _ in 0..60 {
                let mut r = a.times(&u);
                r.iter_mut().flatten().for_each(|r| *r = -*r);
                r[node][c] += 1.0;
                let z = hierarchy.cycle(&r);
                u.iter_mut().flatten().zip(z.iter().flatten()).for_each(|(u, z)| *u += z);
            }
            let ratio = (own[c][c] + coarse[c]) / u[node][c];
            assert!(ratio > 0.2 && ratio < 1.0, "{step:?} {c}: {ratio}");
        }
    }
}

/// Compares the coarse matrix of `a` and its local change with the full product of the matrix `conditioned`.
pub(super) fn assert_local_changes<const C: usize>(
    a: &Blocks<3, 3>,
    conditioned: &Blocks<3, 3>,
    step: &Coarser<3, C>,
    nodes: &[u32],
    constraints: &[NodeConstraint],
) {
    let support = truncation::Support::of_step(step, nodes);
    let touched = support.touched();
    let (whole, halo) = (RelativeMatrix::new(a.clone(), None), Halo::alone(nodes.len()));
    let truncation = truncation::Truncation::new(&whole, nodes, (halo, &[]), Default::default(), &Halo::alone(0));
    let expected = truncated_galerkin(conditioned, step, nodes, constraints);
    let change =
        truncation.change(&support, &touched, [&vec![Default::default(); nodes.len()], constraints], step.matrix.rows);
    for k in 0..step.matrix.rows {
        for l in 0..step.matrix.rows {
            let before = step.matrix.place(k, l).map_or([[0.0; C]; C], |place| step.matrix.value[place]);
            // What changes has its place in the matrix.
            let room = step.matrix.place(k, l).is_some();
            let row = touched.iter().position(|&t| t as usize == k);
            let d = row.and_then(|t| change.place(t, l).map(|place| change.value[place])).unwrap_or([[0.0; C]; C]);
            for r in 0..C {
                for c in 0..C {
                    assert!(room || d[r][c] == 0.0, "no room at {k} {l}");
                    let found = before[r][c] + d[r][c];
                    assert!((found - expected[k][l][r][c]).abs() < 1e-11, "{k} {l}: {found} {}", expected[k][l][r][c]);
                }
            }
        }
    }
}
