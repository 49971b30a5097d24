use rayon::prelude::*;

use super::{Formulation, Material, NEARLY_INCOMPRESSIBLE};
use crate::Error;
use crate::mesh::{CellKind, Cells, Mesh};

/// Numbers that a thread looks through at a time.
const AT_A_TIME: usize = 1 << 14;

/// A mesh and what it is made of.
#[derive(Debug, Clone, Copy)]
pub struct Solid<'a> {
    /// Its cells.
    pub mesh: &'a Mesh,
    /// Its materials.
    pub materials: &'a [Material],
    /// Index into `materials` for each cell of the mesh.
    pub material_of_cell: &'a [u32],
}

impl<'a> Solid<'a> {
    /// Checks the materials, that each cell has one, and that the cells name nodes of the mesh.
    ///
    /// # Errors
    /// If a material is out of range, a cell has none, or a cell names a node that is not there.
    pub fn validate(&self) -> Result<(), Error> {
        let cells = self.mesh.cell_count();
        if cells == 0 {
            return Err(Error::new("mesh", "there is no cell", "give a mesh of tetrahedra, wedges or hexahedra"));
        }
        if self.mesh.nodes.len() >= (u32::MAX / 3) as usize {
            let what = format!("{} nodes are more than can be numbered", self.mesh.nodes.len());
            return Err(Error::new("mesh", what, "stay below 1.4e9 nodes"));
        }
        if self.material_of_cell.len() != cells {
            let what = format!("{} cells but materials for {}", cells, self.material_of_cell.len());
            return Err(Error::new("materials", what, "give each cell one material"));
        }
        let without = |materials: &[u32]| materials.iter().position(|&m| m as usize >= self.materials.len());
        let parts = self.material_of_cell.par_chunks(AT_A_TIME).enumerate();
        if let Some(cell) = parts.find_map_first(|(k, some)| Some(k * AT_A_TIME + without(some)?)) {
            return Err(Error::new(format!("cell {cell}"), "the cell has no material", "give each cell a material"));
        }
        for block in &self.mesh.cells {
            if block.nodes.par_chunks(AT_A_TIME).any(|some| some.iter().any(|&i| i as usize >= self.mesh.nodes.len())) {
                let what = format!("a {} names a node beyond {}", block.kind.name(), self.mesh.nodes.len());
                return Err(Error::new("mesh", what, "number nodes from zero"));
            }
        }
        self.materials.iter().try_for_each(Material::validate)
    }

    /// Cells by number.
    pub(crate) fn cells(&self) -> CellList<'a> {
        let mut first = 0;
        let blocks = self.mesh.cells.iter().map(|block| {
            first += block.len();
            (first, block)
        });
        CellList { blocks: blocks.collect() }
    }
}

/// Kind and nodes of a cell by its number, which runs through the blocks of the mesh.
pub(crate) struct CellList<'a> {
    /// Each block with the number of the first cell after it.
    blocks: Vec<(usize, &'a Cells)>,
}

impl<'a> CellList<'a> {
    /// Kind and nodes of cell number `cell`.
    #[inline]
    pub(crate) fn get(&self, cell: usize) -> (CellKind, &'a [u32]) {
        let (block, local) = self.place(cell);
        let (_, block) = self.blocks[block];
        (block.kind, block.cell(local))
    }

    /// Its block, and its number there.
    #[inline]
    pub(crate) fn place(&self, cell: usize) -> (usize, usize) {
        let place = self.blocks.partition_point(|&(end, _)| end <= cell);
        let (end, block) = self.blocks[place];
        (place, cell + block.len() - end)
    }
}

/// An error if the mesh, which has `count` of `what`, has not all that are `named`.
pub(super) fn all_exist(what: &str, named: &[u32], count: usize) -> Result<(), Error> {
    let Some(number) = named.iter().find(|&&number| number as usize >= count) else { return Ok(()) };
    let missing = format!("{what} {number} does not exist, the mesh has {count}");
    Err(Error::new("", missing, format!("name {what}s of the mesh")))
}

/// By which cells each material is used: linear tetrahedra, linear hexahedra and wedges, quadratic cells.
pub(crate) fn cells_of_materials(solid: &Solid) -> Vec<[bool; 3]> {
    let mut used = vec![[false; 3]; solid.materials.len()];
    let kinds = solid.mesh.cells.iter().flat_map(|block| std::iter::repeat_n(block.kind, block.len()));
    for (kind, &m) in kinds.zip(solid.material_of_cell) {
        if let Some(used) = used.get_mut(m as usize) {
            let place = match kind {
                CellKind::Tet4 => 0,
                CellKind::Hex8 | CellKind::Wedge6 => 1,
                CellKind::Tet10 | CellKind::Hex20 | CellKind::Wedge15 => 2,
            };
            used[place] = true;
        }
    }
    used
}

/// What a person should know about the elements and did not ask: which material is integrated by B-bar, where
/// linear tetrahedra lock. Materials no cell uses are not mentioned; `used` is that of [`cells_of_materials`].
pub(crate) fn notes(materials: &[Material], used: &[[bool; 3]]) -> Vec<String> {
    let mut notes = Vec::new();
    for (material, &[tets, hexes, quadratic]) in materials.iter().zip(used) {
        let (name, nu) = (&material.name, material.poisson);
        if material.orthotropic.is_some() {
            continue;
        }
        if tets && nu > NEARLY_INCOMPRESSIBLE {
            notes.push(format!(
                "material \"{name}\": linear tetrahedra lock at Poisson's ratio {nu}, displacements come out too \
                 small; use hexahedra or quadratic elements"
            ));
        }
        if hexes && material.formulation == Formulation::Auto && material.averages_dilatation() {
            notes.push(format!(
                "material \"{name}\": linear hexahedra and wedges average the dilatation over the cell (B-bar) because Poisson's \
                 ratio {nu} exceeds {NEARLY_INCOMPRESSIBLE}"
            ));
        }
        if hexes && material.formulation == Formulation::Full && nu > NEARLY_INCOMPRESSIBLE {
            notes.push(format!(
                "material \"{name}\": fully integrated linear hexahedra and wedges lock at Poisson's ratio {nu}; use B-bar"
            ));
        }
        if quadratic && material.formulation == Formulation::BBar {
            notes.push(format!(
                "material \"{name}\": B-bar is for linear hexahedra and wedges; quadratic elements are integrated in full"
            ));
        }
    }
    notes
}
