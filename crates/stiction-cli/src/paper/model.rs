//! The paper's model problem.

use stiction::Error;
use stiction::io::case;
use stiction::run::{Prepared, prepare};

/// The slip bound of the tables with given friction, and the start of the fixed point in the fitted setting, newton.
pub const SLIP_BOUND: f64 = 5.25e4;
/// The coefficient of friction of the tables with Coulomb friction.
pub const COEFFICIENT: f64 = 0.35;

/// The brick's mesh and load.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Brick {
    /// 1: 12 x 4 x 4 cubes, 2: 24 x 8 x 8 cubes.
    pub partition: u8,
    /// Of the two ways to cut alternating cubes into five tetrahedra, 0 or 1.
    pub parity: u8,
    /// Factor on the printed tractions.
    pub load: f64,
}

/// The law of friction on the floor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Law {
    /// [`SLIP_BOUND`] at each node.
    Given,
    /// [`COEFFICIENT`].
    Coulomb,
}

/// Meshes, assembles and poses the brick (section 6 of the paper).
///
/// # Errors
/// None for the bricks of the paper.
pub fn brick(brick: Brick, law: Law) -> Result<Prepared, Error> {
    prepare(&case::parse(&text(brick, law), "the paper's model problem", &[])?)
}

/// The case file of the brick.
pub fn text(brick: Brick, law: Law) -> String {
    let Brick { partition, parity, load } = brick;
    let n = 4 * usize::from(partition);
    let friction = match law {
        Law::Given => format!("tresca = {SLIP_BOUND:e}, nodal = true"),
        Law::Coulomb => format!("coulomb = {COEFFICIENT}"),
    };
    format!(
        "title = \"Brick, partition {partition}\"\n\
         units = \"m, N, Pa\"\n\
         [mesh]\n\
         block = {{ size = [3, 1, 1], cells = [{}, {n}, {n}], element = \"tet4\", split = \"five\", parity = {parity} }}\n\
         [materials.steel]\n\
         young = 21.19e10\n\
         poisson = 0.277\n\
         [[fix]]\n\
         on = \"x-min\"\n\
         [[load]]\n\
         on = \"x-max\"\n\
         traction = [0, 0, \"{load:e} * 1e6\"]\n\
         [[load]]\n\
         on = \"z-max\"\n\
         traction = [0, 0, \"-{load:e} * 2/3 * 1e6 * (3 - x)\"]\n\
         [[contact]]\n\
         on = \"z-min\"\n\
         against = {{ plane = {{ point = [0, 0, 0], normal = [0, 0, 1] }} }}\n\
         friction = {{ {friction} }}\n",
        3 * n
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiction::contact::Friction;

    #[test]
    fn both_partitions_have_the_published_numbers_of_unknowns() {
        for (partition, primal, dual) in [(1, 900, 180), (2, 5832, 648)] {
            for parity in [0, 1] {
                let p = brick(Brick { partition, parity, load: 1.0 }, Law::Coulomb).unwrap().problem;
                assert_eq!((p.unknowns(), 3 * p.points()), (primal, dual));
            }
        }
    }

    #[test]
    fn the_load_is_the_integral_of_the_printed_tractions_times_the_factor() {
        // 1e6 on a unit square, and 2/3 * 1e6 times the integral of 3 - x over (0, 3) x (0, 1).
        let prepared = brick(Brick { partition: 1, parity: 0, load: 4.0 }, Law::Given).unwrap();
        let [x, y, z] = prepared.facts.resultant();
        assert!((z + 4.0 * 2e6).abs() < 1e-3 && x == 0.0 && y == 0.0, "{z}");
        assert!(prepared.problem.contact.friction.iter().all(|f| *f == Friction::Given { slip_bound: SLIP_BOUND }));
    }
}
