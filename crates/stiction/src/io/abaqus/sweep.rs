//! Plane and axisymmetric elements as one layer of solids.
//!
//! Plane strain elements are swept along z by their thickness. Those of plane stress become the layer next to the middle of a
//! plate that is thin beside its elements ([`THIN`]): in a thick one the strain along z would vary with shear, which plane
//! stress has none of. Axisymmetric elements about the y axis by [`SECTOR`], the angle that CalculiX gives them (CalculiX
//! CrunchiX User's Manual, section "Axisymmetric elements"). A corner of a quadratic element gets a node between the
//! layers as well. Nodes on the axis are their own copies, so that a quadrilateral with an edge there becomes a wedge and
//! a triangle a tetrahedron.

use std::collections::HashMap;

use super::cards::Card;
use super::elements::Role;
use super::place::{Model, Placed};
use crate::Error;
use crate::mesh::v3::{norm, sub};
use crate::mesh::{Bounds, CellKind};

/// Angle of the sector of a body of revolution, degrees.
const SECTOR: f64 = 2.0;
/// Height of a layer of plane stress as a part of the mean edge: what is left of shear falls with its square and stays below
/// 1e-4 of the strain, while cells are no thinner than multigrid and factor take without loss.
const THIN: f64 = 0.05;
/// A node within this part of the extent of all nodes lies on the axis or in the plane.
const ON: f64 = 1e-9;
/// No node.
pub(in crate::io) const NONE: u32 = u32::MAX;

/// What a layer of solids stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::io) enum Family {
    /// `CPE`: nothing moves along z.
    Strain,
    /// `CPS`: the upper half of a thin plate whose faces are free.
    Stress,
    /// `CAX`: a sector about the y axis.
    Axisymmetric,
}

/// How plane elements became solids.
pub(in crate::io) struct Swept {
    pub family: Family,
    /// The part of the whole body that the layer is.
    pub part: f64,
    /// Copy of each node in the other layer: itself on the axis, [`NONE`] where nothing is swept.
    pub top: Vec<u32>,
    /// Node between the layers.
    pub middle: Vec<u32>,
    /// Ends of the edge in whose middle a node is.
    pub ends: Vec<[u32; 2]>,
    /// Corners of the plane element that each element was; [`NONE`] behind those of triangles, and for all others.
    corners: Vec<[u32; 4]>,
    /// How many elements have each edge, the lower corner first.
    edges: HashMap<[u32; 2], u32>,
}

impl Swept {
    /// Angle of the layer a node is in, radians: 0, 1/2 or 1 time that of the sector.
    pub(in crate::io) fn angle(&self, layer: f64) -> f64 {
        if self.family == Family::Axisymmetric { layer * SECTOR.to_radians() } else { 0.0 }
    }

    /// The edges of a plane element on the outline of the body; `None` for other elements.
    pub(in crate::io) fn outline(&self, element: u32) -> Option<Vec<u8>> {
        self.corners.get(element as usize).filter(|corners| corners[0] != NONE)?;
        let sides = (0..4).filter(|&side| self.edge(element, side).is_some_and(|edge| self.edges[&sorted(edge)] == 1));
        Some(sides.filter(|&side| self.face(element, side).flatten().is_some()).collect())
    }

    fn edge(&self, element: u32, side: u8) -> Option<[u32; 2]> {
        let corners = self.corners.get(element as usize)?;
        let count = corners.iter().filter(|&&corner| corner != NONE).count();
        let side = usize::from(side);
        (side < count).then(|| [corners[side], corners[(side + 1) % count]])
    }

    /// The face of the solid over an edge of the plane element it was, `Some(None)` if there is none or it lies on the
    /// axis; `None` for other elements.
    pub(super) fn face(&self, element: u32, side: u8) -> Option<Option<[u32; 4]>> {
        self.corners.get(element as usize).filter(|corners| corners[0] != NONE)?;
        let Some([a, b]) = self.edge(element, side) else { return Some(None) };
        let [over_a, over_b] = [a, b].map(|node| self.top[node as usize]);
        Some(match (over_a == a, over_b == b) {
            (true, true) => None,
            (true, false) => Some([a, b, over_b, NONE]),
            (false, true) => Some([a, b, over_a, NONE]),
            (false, false) => Some([a, b, over_b, over_a]),
        })
    }
}

fn sorted([a, b]: [u32; 2]) -> [u32; 2] {
    [a.min(b), a.max(b)]
}

/// The family of an element type, in capitals.
fn family(name: &str) -> Option<Family> {
    let digit = |rest: &str| rest.starts_with(['3', '4', '6', '8']);
    let of = |begin: &str, family| name.strip_prefix(begin).is_some_and(digit).then_some(family);
    of("CPE", Family::Strain).or(of("CPS", Family::Stress)).or(of("CAX", Family::Axisymmetric))
}

fn plane(block: &Placed) -> Option<(Family, usize)> {
    match block.role {
        Role::Face(nodes) => family(&block.type_name).map(|family| (family, nodes)),
        _ => None,
    }
}

/// Turns the plane elements of a deck that has no solids into solids.
///
/// # Errors
/// Elements of several families, nodes off the plane or beyond the axis, an element that touches the axis in one node,
/// or several thicknesses.
pub(super) fn sweep(model: &mut Model, cards: &[Card]) -> Result<Option<Swept>, Error> {
    let Some((family, first)) = model.blocks.iter().find_map(|b| Some((plane(b)?.0, b.type_name.clone()))) else {
        return Ok(None);
    };
    if CellKind::ALL.iter().any(|&kind| model.count(kind) > 0) {
        return Ok(None);
    }
    if let Some(other) = model.blocks.iter().find(|b| plane(b).is_some_and(|(own, _)| own != family)) {
        let what = format!("it has elements of the types {first} and {}", other.type_name);
        return Err(Error::new(
            "",
            what,
            "make a deck of plane strain, of plane stress or of axisymmetric elements alone",
        ));
    }
    let thickness = thickness(cards)?;
    let height = match family {
        Family::Strain => thickness,
        Family::Stress => (0.5 * thickness).min(THIN * mean_edge(model)),
        Family::Axisymmetric => 0.0,
    };
    let extent = Bounds::around(model.nodes.iter().copied()).diagonal();
    let mut roles = vec![Part::Other; model.nodes.len()];
    let mut swept = Swept {
        family,
        part: match family {
            Family::Strain => 1.0,
            Family::Stress => height / thickness,
            Family::Axisymmetric => SECTOR / 360.0,
        },
        top: Vec::new(),
        middle: Vec::new(),
        ends: vec![[NONE; 2]; model.nodes.len()],
        corners: Vec::new(),
        edges: HashMap::new(),
    };
    for block in &model.blocks {
        let Some((_, count)) = plane(block) else {
            swept.corners.resize(swept.corners.len() + block.labels.len(), [NONE; 4]);
            continue;
        };
        let n = if count.is_multiple_of(3) { 3 } else { 4 };
        for nodes in block.nodes.chunks_exact(count) {
            let mut corners = [NONE; 4];
            corners[..n].copy_from_slice(&nodes[..n]);
            swept.corners.push(corners);
            for i in 0..n {
                let ends = [nodes[i], nodes[(i + 1) % n]];
                *swept.edges.entry(sorted(ends)).or_default() += 1;
                let own = &mut roles[nodes[i] as usize];
                *own = (*own).max(if count > n { Part::Corner } else { Part::Linear });
                if count > n {
                    roles[nodes[n + i] as usize] = roles[nodes[n + i] as usize].max(Part::Middle);
                    swept.ends[nodes[n + i] as usize] = ends;
                }
            }
        }
    }
    copy_nodes(model, &mut swept, &roles, extent, height)?;
    let blocks = std::mem::take(&mut model.blocks);
    for block in blocks {
        match plane(&block) {
            Some((_, count)) => solids(model, &swept, block, count)?,
            None => model.blocks.push(block),
        }
    }
    model.recount();
    Ok(Some(swept))
}

/// What a node is to plane elements; the greatest counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Part {
    Other,
    Middle,
    Linear,
    Corner,
}

/// Adds the copies of all nodes of plane elements.
fn copy_nodes(model: &mut Model, swept: &mut Swept, roles: &[Part], extent: f64, height: f64) -> Result<(), Error> {
    let old = model.nodes.len();
    (swept.top, swept.middle) = (vec![NONE; old], vec![NONE; old]);
    let mut label = model.node_labels.iter().copied().max().unwrap_or(0);
    let axisymmetric = swept.family == Family::Axisymmetric;
    for (node, role) in roles.iter().enumerate().filter(|(_, role)| **role != Part::Other) {
        let [x, y, z] = model.nodes[node];
        let place = format!("node {}", model.node_labels[node]);
        if z.abs() > ON * extent {
            let what = format!("it belongs to a plane element and lies at z = {z}");
            return Err(Error::new(place, what, "plane and axisymmetric elements lie in the plane z = 0"));
        }
        if axisymmetric && x < -ON * extent {
            let what = format!("it belongs to an axisymmetric element and has the radius x = {x}");
            return Err(Error::new(place, what, "axisymmetric elements lie at x >= 0, y is the axis"));
        }
        if axisymmetric && x <= ON * extent {
            model.nodes[node] = [0.0, y, 0.0];
            swept.top[node] = node as u32;
            continue;
        }
        model.nodes[node] = [x, y, 0.0];
        let family = swept.family;
        let at = |layer: f64| match family {
            Family::Strain | Family::Stress => [x, y, layer * height],
            Family::Axisymmetric => {
                let (sin, cos) = (layer * SECTOR.to_radians()).sin_cos();
                [x * cos, y, x * sin]
            }
        };
        let layers: &[f64] = if *role == Part::Corner { &[0.5, 1.0] } else { &[1.0] };
        for &layer in layers {
            label = label.checked_add(1).filter(|_| model.nodes.len() < (NONE - 2) as usize).ok_or_else(|| {
                Error::new(place.clone(), "no numbers are left for the nodes of the solids", "number nodes from 1")
            })?;
            let of = if layer == 1.0 { &mut swept.top } else { &mut swept.middle };
            of[node] = model.nodes.len() as u32;
            model.nodes.push(at(layer));
            model.node_labels.push(label);
        }
    }
    Ok(())
}

/// The solids of a block of plane elements with `count` nodes each, as blocks of one kind in their order.
fn solids(model: &mut Model, swept: &Swept, block: Placed, count: usize) -> Result<(), Error> {
    let n = if count.is_multiple_of(3) { 3 } else { 4 };
    let (mut first, mut cells) = (block.first, HashMap::new());
    for old in &model.blocks {
        if let Role::Cell(kind) = old.role {
            *cells.entry(kind).or_insert(0) += old.labels.len();
        }
    }
    let mut open: Option<Placed> = None;
    for (label, nodes) in block.labels.iter().zip(block.nodes.chunks_exact(count)) {
        let (kind, solid) = solid(model, swept, nodes, n).ok_or_else(|| {
            let what = format!("it is a {} that touches the axis in one node, or lies along it", block.type_name);
            let remedy = "mesh with quadrilaterals along the axis, each with an edge on it";
            Error::new(format!("element {label}"), what, remedy)
        })?;
        if open.as_ref().is_none_or(|open| open.role != Role::Cell(kind)) {
            model.blocks.extend(open.take());
            let first_cell = cells.get(&kind).copied().unwrap_or(0);
            let type_name = block.type_name.clone();
            let (labels, nodes) = (Vec::new(), Vec::new());
            open = Some(Placed { role: Role::Cell(kind), type_name, labels, nodes, first, first_cell });
        }
        *cells.entry(kind).or_insert(0) += 1;
        first += 1;
        if let Some(open) = &mut open {
            open.labels.push(*label);
            open.nodes.extend(solid);
        }
    }
    model.blocks.extend(open);
    Ok(())
}

/// The solid of a plane element with `n` corners; `None` if it has no shape.
fn solid(model: &Model, swept: &Swept, nodes: &[u32], n: usize) -> Option<(CellKind, Vec<u32>)> {
    let (mut p, mut m) = (nodes[..n].to_vec(), nodes[n..].to_vec());
    let x = |i: usize| model.nodes[p[i % n] as usize];
    let twice: f64 = (0..n).map(|i| x(i)[0] * x(i + 1)[1] - x(i + 1)[0] * x(i)[1]).sum();
    if twice < 0.0 {
        // clockwise: the same corners and edges the other way round
        p[1..].reverse();
        m.reverse();
    }
    let (top, middle) = (|i: u32| swept.top[i as usize], |i: u32| swept.middle[i as usize]);
    let on_axis = |i: u32| top(i) == i;
    let touching = p.iter().filter(|&&i| on_axis(i)).count();
    let turned = (0..n).find(|&i| on_axis(p[i]) && on_axis(p[(i + 1) % n]));
    let over = |list: &[u32]| list.iter().map(|&i| top(i)).collect::<Vec<u32>>();
    let between = |list: &[u32]| list.iter().map(|&i| middle(i)).collect::<Vec<u32>>();
    let quadratic = !m.is_empty();
    match (touching, turned) {
        (0, _) => {
            let kind = [[CellKind::Wedge6, CellKind::Hex8], [CellKind::Wedge15, CellKind::Hex20]];
            let mut solid = [p.clone(), over(&p)].concat();
            if quadratic {
                solid.extend([m.clone(), over(&m), between(&p)].concat());
            }
            Some((kind[usize::from(quadratic)][n - 3], solid))
        }
        (2, Some(turn)) => {
            p.rotate_left(turn);
            let first = *m.get(turn).unwrap_or(&p[0]);
            if quadratic {
                m.rotate_left(turn);
            }
            if !on_axis(first) {
                return None;
            }
            if n == 3 {
                let [a, b, c] = [p[0], p[1], p[2]];
                let mut solid = vec![a, b, c, top(c)];
                if quadratic {
                    solid.extend([m[0], m[1], m[2], top(m[2]), top(m[1]), middle(c)]);
                }
                return Some((if quadratic { CellKind::Tet10 } else { CellKind::Tet4 }, solid));
            }
            let [a, b, c, d] = [p[0], p[1], p[2], p[3]];
            let mut solid = vec![a, d, top(d), b, c, top(c)];
            if quadratic {
                let [on, low, far, high] = [m[0], m[1], m[2], m[3]];
                solid.extend([high, middle(d), top(high), low, middle(c), top(low), on, far, top(far)]);
            }
            Some((if quadratic { CellKind::Wedge15 } else { CellKind::Wedge6 }, solid))
        }
        _ => None,
    }
}

/// Mean length of the edges of plane elements between corners.
fn mean_edge(model: &Model) -> f64 {
    let (mut sum, mut edges) = (0.0, 0.0);
    for (block, (_, count)) in model.blocks.iter().filter_map(|block| Some((block, plane(block)?))) {
        let n = if count.is_multiple_of(3) { 3 } else { 4 };
        for nodes in block.nodes.chunks_exact(count) {
            let x = |i: usize| model.nodes[nodes[i % n] as usize];
            sum += (0..n).map(|i| norm(sub(x(i), x(i + 1)))).sum::<f64>();
            edges += n as f64;
        }
    }
    sum / edges
}

/// The thickness that the sections give; 1 without one.
fn thickness(cards: &[Card]) -> Result<f64, Error> {
    let mut found: Option<f64> = None;
    for card in cards.iter().filter(|card| card.keyword.name == "SOLIDSECTION") {
        let Some(row) = card.row()? else { continue };
        let Some(thickness) = row.number(0)? else { continue };
        if !(thickness > 0.0 && thickness.is_finite()) {
            return Err(row.error(format!("{thickness} is no thickness"), "give a positive length"));
        }
        if found.is_some_and(|other| other != thickness) {
            let what = "the sections of plane elements have several thicknesses";
            return Err(row.error(what, "give all of them one, or mesh with solids"));
        }
        found = Some(thickness);
    }
    Ok(found.unwrap_or(1.0))
}
