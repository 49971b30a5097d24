//! What cards say of plane and axisymmetric elements, said of the solids these became.
//!
//! A node of the deck stays in the first layer of the solids. Its supports, forces and temperatures are those of its
//! copies as well, along axes turned with them in a body of revolution; planes of symmetry hold the layers.

use super::history::Course;
use super::reader::Reader;
use super::supports::NONE;
use super::text::triple;
use super::transform::Transform;
use crate::Error;
use crate::fem::{Axes, frame};
use crate::io::abaqus::{Family, Input, NO_NODE};

/// The layer of solids that plane or axisymmetric elements became.
#[derive(Debug, Clone, PartialEq)]
pub struct DeckLayer {
    /// What forces of the layer are multiplied with in tables of text: one over the part of a plate that it is; 1 in plane
    /// strain, and in bodies of revolution, where CalculiX too gives those of its sector.
    pub factor: f64,
    /// A node of the deck, its copy in another layer, and the angle between these layers about the y axis, radians.
    pub copies: Vec<(u32, u32, f64)>,
}

impl DeckLayer {
    /// Forces at nodes of the deck from those at all nodes of the mesh: in their plane, with those of their copies.
    pub fn whole(&self, forces: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let mut whole: Vec<[f64; 3]> = forces.iter().map(|[x, y, _]| [*x, *y, 0.0]).collect();
        for &(node, copy, angle) in &self.copies {
            let [x, y, z] = forces[copy as usize];
            whole[node as usize][0] += x * angle.cos() + z * angle.sin();
            whole[node as usize][1] += y;
        }
        whole.iter().map(|force| force.map(|f| self.factor * f)).collect()
    }
}

/// The layer of an input, by the numbers of the nodes in its mesh.
pub(super) fn layer(input: &Input) -> Option<DeckLayer> {
    let swept = input.swept()?;
    // The mesh has the nodes of cells only.
    let mut next = 0;
    let number = |used: bool| {
        next += u32::from(used);
        next.wrapping_sub(1)
    };
    let place: Vec<u32> = input.nodes_of_cells().into_iter().map(number).collect();
    let mut copies = Vec::new();
    for node in (0..swept.top.len()).filter(|&node| swept.top[node] != NO_NODE && swept.top[node] as usize != node) {
        for (copy, layer) in [(swept.middle[node], 0.5), (swept.top[node], 1.0)] {
            if copy != NO_NODE {
                copies.push((place[node], place[copy as usize], swept.angle(layer)));
            }
        }
    }
    let factor = if swept.family == Family::Stress { 1.0 / swept.part } else { 1.0 };
    Some(DeckLayer { factor, copies })
}

/// Nodes with their copies in the other layers, ascending.
pub(super) fn with_copies(input: &Input, nodes: &[u32]) -> Vec<u32> {
    let mut all = nodes.to_vec();
    let Some(swept) = input.swept() else { return all };
    for &node in nodes {
        let copies = [&swept.middle, &swept.top].map(|of| of.get(node as usize).copied().unwrap_or(NO_NODE));
        all.extend(copies.into_iter().filter(|&copy| copy != NO_NODE));
    }
    all.sort_unstable();
    all.dedup();
    all
}

/// Whether a node is no node of the deck.
pub(super) fn is_copy(input: &Input, node: u32) -> bool {
    input.swept().is_some_and(|swept| node as usize >= swept.top.len())
}

impl Reader<'_> {
    /// Gives what the cards say of nodes to their copies, and holds the planes of symmetry.
    pub(super) fn complete_sweep(&mut self) -> Result<(), Error> {
        let input = self.input;
        let Some(swept) = input.swept() else { return Ok(()) };
        let axisymmetric = swept.family == Family::Axisymmetric;
        if let Some(point) = self.points.first() {
            let what = "a reference point is not read at plane and axisymmetric elements";
            return Err(point
                .card
                .error(what, "prescribe the nodes by *BOUNDARY, tie them by *EQUATION, or mesh with solids"));
        }
        let turning = input.cards.iter().find(|card| card.keyword.name == "TRANSFORM");
        if let Some(card) = turning.filter(|_| axisymmetric) {
            let what = "*TRANSFORM is not read at axisymmetric elements";
            return Err(card.error(what, "give supports and forces along the radius and the axis"));
        }
        for of in [&swept.middle, &swept.top] {
            let copy = |node: u32| of.get(node as usize).copied().filter(|&copy| copy != NO_NODE);
            let copies: Vec<_> = self.equations.iter().filter_map(|equation| equation.copied(copy)).collect();
            self.equations.extend(copies);
        }
        for (transform, card) in
            self.transforms.iter().zip(input.cards.iter().filter(|card| card.keyword.name == "TRANSFORM"))
        {
            let third = transform.axes.direction(2, [f64::NAN; 3]).unwrap_or([0.0; 3]);
            if third[2].abs() < 1.0 - 1e-9 {
                return Err(
                    card.error("the third axis of this *TRANSFORM is not z", "turn plane elements in their plane")
                );
            }
        }
        self.notes.add(match swept.family {
            Family::Strain => "plane strain: one layer of solids of the whole thickness".to_string(),
            Family::Stress => format!(
                "plane stress: one layer of solids of {:.4e} of the thickness; forces of the summary and of files are those of \
                 the layer",
                swept.part
            ),
            Family::Axisymmetric => "axisymmetric elements: a sector of 2 degrees, 1/180 of the body; forces of the summary \
                                     and of files are those of the sector, *CLOAD those of the whole circle"
                .to_string(),
        });
        let turned = [0.5, 1.0].map(|layer| {
            let (sin, cos) = swept.angle(layer).sin_cos();
            let axes = [[cos, 0.0, sin], [0.0, 1.0, 0.0]];
            let text = format!("[{}, {}]", triple(axes[0]), triple(axes[1]));
            frame(axes).map(|axes| Transform { text, axes: Axes::Turned(axes) })
        });
        let first = self.transforms.len() as u32;
        if swept.family == Family::Axisymmetric {
            self.transforms.extend(turned.into_iter().flatten());
        }
        let zero = self.histories.change(None, 0, 0.0, Course::Instant, false).unwrap_or(NONE);
        for node in (0..swept.top.len()).filter(|&node| swept.top[node] != NO_NODE) {
            let [middle, top] = [swept.middle[node], swept.top[node]];
            if top as usize == node {
                // On the axis.
                self.supports[3 * node] = zero;
                self.supports[3 * node + 2] = zero;
                continue;
            }
            for (layer, copy) in [middle, top].into_iter().enumerate().filter(|(_, copy)| *copy != NO_NODE) {
                let copy = copy as usize;
                for c in 0..2 {
                    self.supports[3 * copy + c] = self.supports[3 * node + c];
                }
                self.temperatures[copy] = self.temperatures[node];
                self.initial[copy] = self.initial[node];
                self.transform_of[copy] = match swept.family {
                    Family::Axisymmetric => first + layer as u32,
                    _ => self.transform_of[node],
                };
            }
            self.supports[3 * node + 2] = zero;
            if swept.family != Family::Stress {
                for copy in [middle, top].into_iter().filter(|&copy| copy != NO_NODE) {
                    self.supports[3 * copy as usize + 2] = zero;
                }
            }
        }
        self.plane_loads()
    }

    /// Refuses loads that no plane or axisymmetric state answers.
    fn plane_loads(&self) -> Result<(), Error> {
        use super::loads::CellLoad;
        let Some(swept) = self.input.swept() else { return Ok(()) };
        for load in self.on_cells.iter().filter(|_| swept.family == Family::Axisymmetric) {
            let along = |v: [f64; 3]| v[0].hypot(v[2]) <= 1e-9 * v[1].abs();
            let fits = match &load.kind {
                CellLoad::Gravity(direction, _) => along(*direction),
                CellLoad::Rotation(point, axis, _) => along(*axis) && point[0] == 0.0 && point[2] == 0.0,
            };
            if !fits {
                let what = "a body of revolution is not loaded alike all around by this";
                return Err(load.row.error(what, "give GRAV along y, CENTRIF about the y axis, or mesh with solids"));
            }
        }
        Ok(())
    }

    /// The nodes that a force at a node of the deck acts on, each with its part: forces of plane elements are those of
    /// the whole thickness, of axisymmetric ones of the whole circle. A displacement that is the same in all layers does
    /// the same work.
    pub(super) fn spread(&self, node: u32) -> Vec<(u32, f64)> {
        let Some(swept) = self.input.swept() else { return vec![(node, 1.0)] };
        let (part, of) = (swept.part, |list: &[u32], node: u32| list.get(node as usize).copied().unwrap_or(NO_NODE));
        let top = of(&swept.top, node);
        if top == node || top == NO_NODE {
            return vec![(node, part)];
        }
        match of(&swept.middle, node) {
            NO_NODE => {
                let mut spread = vec![(node, part / 2.0), (top, part / 2.0)];
                // The functions of a face's edge between the layers have a part in the middle of its other edges.
                for end in swept.ends[node as usize].into_iter().filter(|&end| end != NO_NODE) {
                    let (middle, top) = (of(&swept.middle, end), of(&swept.top, end));
                    if middle != NO_NODE {
                        spread.extend([(end, -part / 6.0), (middle, part / 3.0), (top, -part / 6.0)]);
                    }
                }
                spread
            }
            middle => vec![(node, part / 6.0), (middle, part * 2.0 / 3.0), (top, part / 6.0)],
        }
    }
}
