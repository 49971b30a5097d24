//! Cyclic symmetry: the displacements of one cut are those of the other, turned by one sector.
//!
//! Loads, contact and displacements are the same in every sector (nodal diameter zero), so that `u(R x) = R u(x)` with the
//! rotation `R` by one sector (D. L. Thomas, Int. J. Numer. Meth. Eng. 14 (1979) 81-102, for the phase zero).

use std::collections::BTreeMap;

use super::regions;
use super::ties::{Tie, along_at};
use crate::Error;
use crate::contact::{ContactSurface, Counterpart, area_met_when_moved};
use crate::fem::{Axes, DofMap, Field, Fix, Followed};
use crate::io::case::{ContactSpec, CyclicSpec, Spot};
use crate::mesh::v3::{V3, across, add, cross, dot, norm, scale, sub};
use crate::mesh::{Bounds, Mesh, Tree, bodies};

/// How far apart nodes of the two cuts may be, over the diagonal of the mesh: meshes are written with some six digits.
const APART: f64 = 1e-4;
/// Entries of an equation below this cancel.
const ROUNDING: f64 = 1e-12;

const UNITS: [V3; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// A rotation about an axis.
#[derive(Clone, Copy)]
struct Turn {
    point: V3,
    axis: V3,
    /// Cosine and sine of its angle.
    cosine: f64,
    sine: f64,
}

impl Turn {
    /// A vector turned (Rodrigues' formula).
    fn vector(&self, v: V3) -> V3 {
        let along = scale(dot(self.axis, v) * (1.0 - self.cosine), self.axis);
        add(add(scale(self.cosine, v), scale(self.sine, cross(self.axis, v))), along)
    }

    fn place(&self, x: V3) -> V3 {
        add(self.point, self.vector(sub(x, self.point)))
    }

    fn back(&self) -> Turn {
        Turn { sine: -self.sine, ..*self }
    }
}

/// The two cuts of a sector.
pub(crate) struct Cuts {
    /// A node that follows, and the one it follows.
    pairs: Vec<(u32, u32)>,
    /// Nodes on the axis.
    on_axis: Vec<u32>,
    /// From the nodes that are followed to those that follow.
    turn: Turn,
    spot: Spot,
}

/// The nodes of all cuts.
///
/// # Errors
/// Cuts whose nodes do not lie upon one another when one is turned.
pub(crate) fn cuts(mesh: &Mesh, specs: &[CyclicSpec]) -> Result<Vec<Cuts>, Error> {
    if specs.is_empty() {
        return Ok(Vec::new());
    }
    let body = bodies(mesh);
    let diagonal = Bounds::around(mesh.nodes.iter().copied()).diagonal();
    let cuts = |spec: &CyclicSpec| {
        let (sine, cosine) = (std::f64::consts::TAU / spec.sectors as f64).sin_cos();
        let forth = Turn { point: spec.point, axis: spec.axis, cosine, sine };
        let [on, against] = [&spec.on, &spec.against].map(|region| regions::nodes(mesh, region, &spec.spot));
        let (on, against) = (on?, against?);
        let search = spec.search.unwrap_or(APART * diagonal);
        let back = forth.back();
        let [a, b] = [&forth, &back].map(|turn| partners(mesh, &body, [&on, &against], turn, search));
        let farthest = |pairs: &[(u32, u32, f64)]| pairs.iter().map(|p| p.2).fold(0.0, f64::max);
        let (turn, pairs) = if farthest(&a) <= farthest(&b) { (forth, a) } else { (back, b) };
        refuse_apart(mesh, spec, [&on, &against], &pairs, search)?;
        let (on_axis, pairs): (Vec<_>, Vec<_>) = pairs.into_iter().map(|p| (p.0, p.1)).partition(|p| p.0 == p.1);
        let on_axis = on_axis.into_iter().map(|pair| pair.0).collect();
        Ok(Cuts { pairs, on_axis, turn, spot: spec.spot.clone() })
    };
    specs.iter().map(cuts).collect()
}

impl Cuts {
    /// What holds nodes on the axis: they move along it alone.
    pub(crate) fn on_axis(&self) -> Option<(Fix, Spot)> {
        let axis = self.turn.axis;
        let held = || Some(Field::Constant(0.0));
        let (axes, value) = match (0..3).find(|&c| axis[c].abs() == 1.0) {
            Some(along) => (Axes::Global, [0, 1, 2].map(|c| if c == along { None } else { held() })),
            None => {
                let [a, b] = across(axis);
                (Axes::Turned([a, b, axis]), [held(), held(), None])
            }
        };
        let fix = Fix { nodes: self.on_axis.clone(), value, axes, faces: Vec::new() };
        (!self.on_axis.is_empty()).then(|| (fix, self.spot.clone()))
    }

    /// Each node that follows another, with that one.
    pub(crate) fn followers(&self) -> impl Iterator<Item = (u32, Followed)> {
        let back = self.turn.back();
        let axes = UNITS.map(|unit| back.vector(unit));
        self.pairs.iter().map(move |&(node, followed)| (node, Followed { node: followed, axes }))
    }

    /// The equations of the nodes that follow.
    pub(crate) fn ties(&self, dofs: &DofMap) -> Vec<Tie> {
        let (back, mut ties) = (self.turn.back(), Vec::new());
        for &(node, partner) in &self.pairs {
            for unit in UNITS {
                let mut entries: BTreeMap<u32, f64> = along_at(dofs, node, unit);
                for (dof, part) in along_at(dofs, partner, back.vector(unit)) {
                    *entries.entry(dof).or_default() -= part;
                }
                entries.retain(|_, v| v.abs() > ROUNDING);
                // Supports may hold both cuts already.
                ties.push(Tie { idle: true, ..Tie::always(entries, Vec::new(), self.spot.clone()) });
            }
        }
        ties
    }
}

/// The part of a surface that may meet the next sector of the other one by the roughness of meshes.
const ACROSS: f64 = 2e-3;

/// Refuses a pair whose surfaces meet across the cuts, each in another sector: points look for the other surface in the mesh alone.
pub(crate) fn refuse_contact_across(
    mesh: &Mesh,
    cuts: &[Cuts],
    surfaces: &[ContactSurface],
    specs: &[ContactSpec],
) -> Result<(), Error> {
    for (surface, spec) in surfaces.iter().zip(specs) {
        let Counterpart::Surface(master) = &surface.against else { continue };
        for turn in cuts.iter().flat_map(|cuts| [cuts.turn, cuts.turn.back()]) {
            let [met, whole] = area_met_when_moved(mesh, surface, master, &|x| turn.place(x));
            if met > ACROSS * whole {
                let what = format!(
                    "{:.1} % of the surface meet the other one in the next sector, where contact is not looked for: the bodies are cut at different angles",
                    100.0 * met / whole
                );
                let remedy = "cut both bodies by the same planes, or choose cuts beside the contact";
                return Err(spec.spot.error(what, remedy));
            }
        }
    }
    Ok(())
}

/// Each node of a cut with the one of the other cut that is nearest to it once that is turned, and their distance. Of bodies
/// that touch nodes lie in one place: the one of the same body is taken.
fn partners(mesh: &Mesh, body: &[u32], cuts: [&[u32]; 2], turn: &Turn, search: f64) -> Vec<(u32, u32, f64)> {
    let [on, against] = cuts;
    let turned: Vec<V3> = against.iter().map(|&node| turn.place(mesh.nodes[node as usize])).collect();
    let tree = Tree::new(turned.iter().map(|&x| Bounds::around([x])).collect());
    let nearest = |&node: &u32| {
        let x = mesh.nodes[node as usize];
        let distance = |i: u32| norm(sub(turned[i as usize], x));
        let other = |i: u32| body[against[i as usize] as usize] != body[node as usize];
        let farther = |i: u32| distance(i) + if other(i) { search } else { 0.0 };
        let (i, _) = tree.nearest(x, f64::INFINITY, |i| farther(i).powi(2))?;
        Some((node, against[i as usize], distance(i)))
    };
    on.iter().filter_map(nearest).collect()
}

fn refuse_apart(
    mesh: &Mesh,
    spec: &CyclicSpec,
    [on, against]: [&[u32]; 2],
    pairs: &[(u32, u32, f64)],
    search: f64,
) -> Result<(), Error> {
    let names = [&spec.on, &spec.against].map(regions::name);
    if on.len() != against.len() || pairs.len() != on.len() {
        let what =
            format!("the cuts do not match: {} has {} nodes, {} has {}", names[0], on.len(), names[1], against.len());
        let remedy = "mesh one cut as a copy of the other, turned by one sector (Gmsh: setPeriodic)";
        return Err(spec.spot.error(what, remedy));
    }
    let farthest = pairs.iter().max_by(|a, b| a.2.total_cmp(&b.2));
    if let Some(&(node, _, distance)) = farthest.filter(|pair| pair.2 > search) {
        let x = mesh.nodes[node as usize];
        let what = format!(
            "node {} at {x:?} is {distance:.3e} away from the nearest node of {} turned by 360/{} degrees",
            node + 1,
            names[1],
            spec.sectors
        );
        let remedy = "check sectors, axis and point, mesh one cut as a copy of the other, or widen `search`";
        return Err(spec.spot.error(what, remedy));
    }
    let mut seen: Vec<u32> = pairs.iter().map(|pair| pair.1).collect();
    seen.sort_unstable();
    if let Some(twice) = seen.windows(2).find(|pair| pair[0] == pair[1]) {
        let what = format!("node {} of {} is the nearest to two nodes of {}", twice[0] + 1, names[1], names[0]);
        return Err(spec.spot.error(what, "mesh one cut as a copy of the other, turned by one sector"));
    }
    if let Some(&(node, _, _)) = pairs.iter().find(|pair| pair.0 == pair.1 && off_axis(mesh, spec, pair.0) > search) {
        let what = format!("node {} lies on both cuts and not on the axis", node + 1);
        return Err(spec.spot.error(what, "take it out of one of the cuts"));
    }
    Ok(())
}

fn off_axis(mesh: &Mesh, spec: &CyclicSpec, node: u32) -> f64 {
    norm(cross(spec.axis, sub(mesh.nodes[node as usize], spec.point)))
}
