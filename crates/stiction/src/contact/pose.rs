//! From surfaces on an assembled model to a [`ContactProblem`].
//!
//! Nodes that cannot move towards their counterpart are dropped and counted. At nodes with axes of their own
//! ([`DofMap::axes`](crate::fem::DofMap::axes)) `K`, `f`, `B` and the rigid motions are posed in the components along
//! these axes; nothing right of the [`ContactProblem`] knows. A force "at a node" is `Bᵀ lambda`, not `lambda`: rows of
//! quadratic faces and of pairs reach further than one node.

use rayon::prelude::*;

use super::layer::add_layer;
use super::rows::jump;
use super::{
    AllMet, Bodies, Body, Contact, ContactProblem, ContactSurface, Elastic, Labels, PosedPoints, Supports, SurfaceFacts,
};
use crate::Error;
use crate::fem::FeModel;
use crate::linalg::in_huge_pages;
use crate::mesh::v3::{Sum, cross, norm, scale, sub};
use crate::mesh::{self, Mesh};

/// Poses contact of the surfaces on `model`, which was assembled on `mesh`. The stiffness matrix moves from the model
/// into the problem: it is the largest thing there is, and nobody needs it twice.
///
/// Normals and gaps are those of the reference configuration (small sliding). The rows of a point whose node has
/// prescribed components are restricted to the free ones: tangents are chosen among the free directions across the
/// normal, so that on a symmetry plane friction acts within the plane.
///
/// # Errors
/// A surface without faces or without a single free node, an obstacle without a normal at a node, a prescribed
/// displacement that pushes a node into the obstacle, drags it along the surface or moves a bonded one.
pub fn pose(
    mesh: &Mesh,
    model: &mut FeModel,
    surfaces: &[ContactSurface],
) -> Result<(ContactProblem, Vec<SurfaceFacts>), Error> {
    let (points, (of_node, list)) =
        rayon::join(|| PosedPoints::new(mesh, &model.dofs, surfaces, AllMet::default()), || bodies_of(mesh));
    let (points, facts) = points?;
    Ok((pose_points(mesh, model, points, centroid(mesh), &of_node, list), facts))
}

/// Poses contact at `points`, with rigid motions about `center`, length: those of a piece of a mesh are those of the whole.
/// `bodies` are those of the whole mesh, and `body_of_node` are numbers of them.
pub(crate) fn pose_points(
    mesh: &Mesh,
    model: &mut FeModel,
    PosedPoints { mut points, pairs, .. }: PosedPoints,
    center: [f64; 3],
    body_of_node: &[u32],
    bodies: Vec<Body>,
) -> ContactProblem {
    add_layer(model, &mut points);
    let (free, constrained) = jump(&model.dofs, &points);
    let mut offset = constrained.times(&model.dofs.value);
    let slip_reference = offset.split_off(points.len()).into_iter().map(|slip| 0.0 - slip).collect();
    let rigid = |dofs: &[u32]| {
        let mut rows = in_huge_pages(Vec::with_capacity(dofs.len()));
        rows.par_extend(
            dofs.par_iter().map(|&d| rigid_row(mesh, center, model.dofs.mesh_dof(d), model.dofs.direction(d))),
        );
        rows
    };
    let [motions, of_supports] = [&model.dofs.free, &model.dofs.prescribed].map(|dofs| rigid(dofs));
    let body = |dofs: &[u32]| dofs.iter().map(|&dof| body_of_node[model.dofs.mesh_node(dof / 3) as usize]).collect();
    let (of, of_support) = (body(&model.dofs.free), body(&model.dofs.prescribed));
    let bodies = Bodies { list: bodies, of, of_support, origin: center };
    let mut free_load = model.support_stiffness.transpose_times(&model.dofs.value);
    free_load.iter_mut().zip(&model.load).for_each(|(x, f)| *x += f);
    let elastic = Elastic {
        K: std::mem::take(&mut model.stiffness).into(),
        f: model.load.clone(),
        node_of: Some(model.dofs.free.iter().map(|d| d / 3).collect()),
        near_kernel: Some(motions),
        middles: middles(mesh),
    };
    let contact = Contact {
        B: free,
        gap: points.iter().zip(offset).map(|(p, imposed)| p.gap - imposed).collect(),
        slip_reference,
        friction: points.iter().map(|p| p.friction).collect(),
        orthotropy: (points.iter().any(|p| p.orthotropy != 1.0)).then(|| points.iter().map(|p| p.orthotropy).collect()),
        rounding: 0.0,
        out: Vec::new(),
    };
    let labels = Labels {
        area: points.iter().map(|p| p.area).collect(),
        unity_sum: points.iter().map(|p| p.unity_sum).collect(),
        pairs,
        supports: Some(Supports {
            K: model.support_stiffness.clone(),
            K_own: model.support_support.clone(),
            load: model.support_load.clone(),
            free_load,
            displacement: model.dofs.value.clone(),
            B: constrained,
            rigid: of_supports,
            springs: model.springs.clone(),
        }),
        bodies: Some(bodies),
    };
    ContactProblem { elastic, contact, labels }
}

/// The nodes in the middle of edges with the ends of these; none in a mesh of linear cells.
fn middles(mesh: &Mesh) -> Option<Vec<[u32; 3]>> {
    let mut seen = vec![false; mesh.nodes.len()];
    let mut middles = Vec::new();
    for cells in &mesh.cells {
        let (edges, corners) = (cells.kind.edges(), cells.kind.linear().nodes());
        for cell in cells.nodes.chunks_exact(cells.kind.nodes()).filter(|_| !edges.is_empty()) {
            for (edge, &middle) in edges.iter().zip(&cell[corners..]) {
                if !std::mem::replace(&mut seen[middle as usize], true) {
                    middles.push([middle, cell[edge[0]], cell[edge[1]]]);
                }
            }
        }
    }
    (!middles.is_empty()).then_some(middles)
}

/// The number of the body of each node, and the bodies by the names of the groups of cells they are, otherwise by their numbers.
pub(crate) fn bodies_of(mesh: &Mesh) -> (Vec<u32>, Vec<Body>) {
    let of_node = mesh::bodies(mesh);
    let count = of_node.iter().max().map_or(0, |&last| last as usize + 1);
    let of_cell: Vec<u32> = mesh.cell_iter().map(|(_, nodes)| of_node[nodes[0] as usize]).collect();
    let (mut cells, mut nodes) = (vec![0; count], vec![Vec::new(); count]);
    of_cell.iter().for_each(|&body| cells[body as usize] += 1);
    of_node.iter().zip(&mesh.nodes).for_each(|(&body, &x)| nodes[body as usize].push(x));
    let group_of = |body: usize| {
        let is = |group: &&mesh::Group| {
            group.cells.len() == cells[body] && group.cells.iter().all(|&c| of_cell[c as usize] as usize == body)
        };
        mesh.groups.iter().find(is).map(|group| group.name.clone())
    };
    let list = (0..count).map(|body| {
        let size = nodes[body].len().max(1) as f64;
        let centre = scale(1.0 / size, Sum::of(nodes[body].iter().copied()).value());
        let radius = nodes[body].iter().map(|&x| norm(sub(x, centre))).fold(0.0, f64::max);
        Body { name: group_of(body).unwrap_or_else(|| (body + 1).to_string()), centre, radius }
    });
    let list = list.collect();
    (of_node, list)
}

/// The mean of all nodes.
pub(crate) fn centroid(mesh: &Mesh) -> [f64; 3] {
    let count = mesh.nodes.len().max(1) as f64;
    scale(1.0 / count, Sum::of(mesh.nodes.iter().copied()).value())
}

/// The displacement of degree of freedom `dof`, which moves its node along `d`, under unit translations along and rotations
/// about the three axes.
fn rigid_row(mesh: &Mesh, center: [f64; 3], dof: u32, d: [f64; 3]) -> [f64; 6] {
    let turns = cross(sub(mesh.nodes[(dof / 3) as usize], center), d); // (e_k x r) . d = e_k . (r x d)
    [d[0], d[1], d[2], turns[0], turns[1], turns[2]]
}
