//! Counts of a case before it has a mesh or a matrix, by which it is refused at once where no path could solve it in the
//! memory there is.

use super::memory::MemoryLimit;
use super::place;
use crate::Error;
use crate::dual::{Neighbours, least_entries_of_box, least_entries_of_graph};
use crate::fem::Fix;
use crate::friction::Method;
use crate::io::case::{Case, FixSpec, MeshSource, MeshSpec, Region};
use crate::mesh::{Block, BlockElement, Buckets, CellKind, Mesh};
use crate::solve::{LeastCounts, fits_by_counts};

/// Groups of blocks and rings that are sides of them, with the axis they lie across.
const SIDES: [(&str, usize); 10] = [
    ("x-min", 0),
    ("x-max", 0),
    ("y-min", 1),
    ("y-max", 1),
    ("z-min", 2),
    ("z-max", 2),
    ("inner", 0),
    ("outer", 0),
    ("start", 1),
    ("end", 1),
];

/// Refuses a case by the counts of its blocks and rings, before any mesh is made. Meshes that are read or given count nothing here, nor
/// do parts that are fixed elsewhere than at their sides.
///
/// # Errors
/// If no path that the case allows fits the memory.
pub(super) fn before_the_mesh(case: &Case, limit: &MemoryLimit) -> Result<(), Error> {
    let counts = match &case.mesh.source {
        MeshSource::Parts(parts) => {
            let each = parts.iter().map(|(name, part)| of_part(part, Some(name), &case.fixes));
            each.fold(LeastCounts::default(), LeastCounts::and)
        }
        _ => of_part(&case.mesh, None, &case.fixes),
    };
    refuse(counts, case, limit, || 0.0)
}

/// The same by the mesh and the nodes that are fixed.
///
/// # Errors
/// As [`before_the_mesh`].
pub(super) fn before_assembly(mesh: &Mesh, fixes: &[Fix], case: &Case, limit: &MemoryLimit) -> Result<(), Error> {
    let mut fixed = vec![false; mesh.nodes.len()];
    fixes.iter().flat_map(|fix| &fix.nodes).for_each(|&node| fixed[node as usize] = true);
    let free = fixed.iter().filter(|fixed| !**fixed).count() as f64;
    let kinds = mesh.cells.iter().filter(|cells| !cells.is_empty()).map(|cells| cells.kind);
    let counts = of_nodes(free, kinds.map(neighbours_at_least).fold(f64::INFINITY, f64::min));
    refuse(counts, case, limit, || least_entries(mesh, &fixed))
}

fn refuse(counts: LeastCounts, case: &Case, limit: &MemoryLimit, factor: impl FnOnce() -> f64) -> Result<(), Error> {
    let by_newton = case.solver.method.method == Method::Newton;
    let fits = fits_by_counts(counts, case.solver.path, by_newton, limit.bytes, factor);
    fits.map_err(|error| place::at(&case.mesh.spot, limit.named(error)))
}

/// Neighbours of a node on average at least: those in a bar of one cell across.
fn neighbours_at_least(kind: CellKind) -> f64 {
    match kind {
        CellKind::Tet4 => 6.0,
        CellKind::Hex8 => 10.0,
        CellKind::Tet10 => 15.0,
        CellKind::Hex20 => 25.0,
        CellKind::Wedge6 => 8.0,
        CellKind::Wedge15 => 18.0,
    }
}

fn of_nodes(nodes: f64, neighbours: f64) -> LeastCounts {
    // Lower triangles of the blocks at the diagonal, and a block for each pair.
    LeastCounts { unknowns: 3.0 * nodes, entries: nodes * (6.0 + 9.0 * 0.5 * neighbours), factor: 0.0 }
}

/// A block or ring without the layers of cells at the sides that are fixed: no node of what is left is.
fn of_part(part: &MeshSpec, name: Option<&str>, fixes: &[FixSpec]) -> LeastCounts {
    let (mut cells, element) = match &part.source {
        MeshSource::Block(block) => (block.cells, block.element),
        MeshSource::Ring(ring) => (ring.cells, ring.element),
        MeshSource::File { .. } | MeshSource::Given(_) | MeshSource::Parts(_) => return LeastCounts::default(),
    };
    let Some(mut sides) = fixed_sides(fixes, name) else { return LeastCounts::default() };
    sides.sort_unstable();
    sides.dedup();
    for side in sides {
        let (_, axis) = SIDES[side];
        cells[axis] = cells[axis].saturating_sub(1);
    }
    if cells.contains(&0) {
        return LeastCounts::default();
    }
    let nodes = Block { size: [1.0; 3], cells, origin: [0.0; 3], grading: [1.0; 3], element }.nodes();
    let five = matches!(element, BlockElement::Tet4Five { .. } | BlockElement::Tet10Five { .. });
    let factor = least_entries_of_box(nodes, cells.map(|n| n as f64 + 1.0), five);
    let kind = match element {
        BlockElement::Hex8 => CellKind::Hex8,
        BlockElement::Hex20 => CellKind::Hex20,
        BlockElement::Wedge6 => CellKind::Wedge6,
        BlockElement::Wedge15 => CellKind::Wedge15,
        BlockElement::Tet4Five { .. } | BlockElement::Tet4Six => CellKind::Tet4,
        BlockElement::Tet10Five { .. } | BlockElement::Tet10Six => CellKind::Tet10,
    };
    LeastCounts { factor, ..of_nodes(nodes, neighbours_at_least(kind)) }
}

/// Places in [`SIDES`] of all that is fixed of the part called `name`; `None` where that may be more than sides.
fn fixed_sides(fixes: &[FixSpec], name: Option<&str>) -> Option<Vec<usize>> {
    let mut all = Vec::new();
    for fix in fixes {
        let Region::Groups(groups) = &fix.on else { return None };
        for (group, _) in groups {
            let side = match (name, group.split_once('.')) {
                (Some(name), Some((part, _))) if part != name => continue,
                (Some(name), None) if group != name => continue,
                (Some(_), Some((_, side))) => side,
                _ => group.as_str(),
            };
            all.push(SIDES.iter().position(|(of, _)| *of == side)?);
        }
    }
    Some(all)
}

/// Entries of the factor at least, by the graph of the nodes that are not fixed.
fn least_entries(mesh: &Mesh, fixed: &[bool]) -> f64 {
    let cells_at = Buckets::new(mesh.nodes.len(), mesh.cell_count(), |range| {
        mesh.cells_in(range).flat_map(|(cell, nodes)| nodes.iter().map(move |&node| [node, cell as u32]))
    });
    let neighbours: &Neighbours = &|v, visit| {
        if fixed[v as usize] {
            return;
        }
        for &cell in cells_at.at(v as usize) {
            let (_, nodes) = mesh.cell(cell as usize);
            nodes.iter().filter(|&&w| !fixed[w as usize]).for_each(|&w| visit(w));
        }
    };
    least_entries_of_graph(mesh.nodes.len(), neighbours)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dual::{DualSettings, Form, choose};
    use crate::io::case;
    use crate::run::pose::prepare;

    /// Counts may not say more than the matrix and the plan of its elimination, which know everything.
    #[test]
    fn counts_are_never_above_what_the_problem_has() {
        let shapes = [("hex8", [31, 30, 29]), ("tet4", [60, 60, 7]), ("tet10", [30, 30, 6]), ("hex20", [20, 22, 24])];
        for (element, cells) in shapes {
            let text = format!(
                "[mesh]\nblock = {{ size = [1, 1, 1], cells = {cells:?}, element = \"{element}\" }}\n\
                 [materials.a]\nyoung = 1\npoisson = 0.3\n[[fix]]\non = [\"x-min\", \"z-max\"]\n"
            );
            let case = case::parse(&text, "case.toml", &[]).unwrap();
            let prepared = prepare(&case).unwrap();
            let k = &prepared.problem.elastic.K;
            let choice = choose(&prepared.problem, &DualSettings { form: Form::Solves, ..Default::default() }).unwrap();
            // The numbers of the plan are rounded up by merging its supernodes.
            let planned = choice.bytes as f64 / 8.0;
            let before = of_part(&case.mesh, None, &case.fixes);
            let mut fixed = vec![false; prepared.mesh.nodes.len()];
            let groups = ["x-min", "z-max"].map(|name| prepared.mesh.group(name).unwrap());
            groups.iter().flat_map(|g| prepared.mesh.group_nodes(g)).for_each(|node| fixed[node as usize] = true);
            let factor = least_entries(&prepared.mesh, &fixed);
            assert!(before.unknowns > 0.85 * prepared.problem.unknowns() as f64, "{element}: {before:?}");
            assert!(before.unknowns <= prepared.problem.unknowns() as f64, "{element}: {before:?}");
            assert!(before.entries < k.value.len() as f64, "{element}: {before:?}, {}", k.value.len());
            let share = [before.factor, factor].map(|entries| entries / planned);
            assert!(share[0] < 0.8 && share[1] < 0.8 && share[1] > 0.03, "{element}: {share:?} of {planned}");
        }
    }

    #[test]
    fn a_part_fixed_elsewhere_than_at_its_sides_counts_nothing() {
        let text = |fix: &str| {
            format!(
                "[mesh.parts.low]\nblock = {{ size = [1, 1, 1], cells = [50, 50, 50], element = \"hex8\" }}\n\
                 [mesh.parts.high]\nblock = {{ size = [1, 1, 1], cells = [40, 40, 40], element = \"hex8\" }}\n\
                 [materials.a]\nyoung = 1\npoisson = 0.3\n[[fix]]\n{fix}\n"
            )
        };
        let unknowns = |fix: &str| {
            let case = case::parse(&text(fix), "case.toml", &[]).unwrap();
            let MeshSource::Parts(parts) = &case.mesh.source else { panic!("parts") };
            let of = |(name, part): &(String, MeshSpec)| of_part(part, Some(name), &case.fixes).unknowns;
            parts.iter().map(of).collect::<Vec<f64>>()
        };
        let [low, high] = [50.0f64, 40.0].map(|n| 3.0 * n * (n + 1.0).powi(2));
        assert_eq!(unknowns("on = [\"low.z-min\", \"high.x-max\"]"), [low, high]);
        assert_eq!(unknowns("on = \"low\""), [0.0, 3.0 * 41.0f64.powi(3)]);
        assert_eq!(unknowns("on = \"high.body\""), [3.0 * 51.0f64.powi(3), 0.0]);
        assert_eq!(unknowns("on = { box = [[0, 0, 0], [1, 1, 1]] }"), [0.0, 0.0]);
    }
}
