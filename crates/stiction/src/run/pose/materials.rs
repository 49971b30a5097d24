//! Which material each cell is made of.

use super::regions;
use crate::Error;
use crate::fem::Material;
use crate::io::case::{MaterialSpec, Region};
use crate::mesh::Mesh;

/// The materials, and for each cell its number among them.
pub(crate) fn materials(mesh: &Mesh, specs: &[MaterialSpec]) -> Result<(Vec<Material>, Vec<u32>), Error> {
    // One material for all is all there is to say, mostly.
    let of_cell = match specs {
        [MaterialSpec { on: None, .. }] => vec![0; mesh.cell_count()],
        _ => of_groups(mesh, specs)?,
    };
    Ok((specs.iter().map(|spec| spec.material.clone()).collect(), of_cell))
}

/// For each cell the number of the material whose groups it belongs to.
fn of_groups(mesh: &Mesh, specs: &[MaterialSpec]) -> Result<Vec<u32>, Error> {
    let mut of_cell = vec![u32::MAX; mesh.cell_count()];
    for (number, spec) in specs.iter().enumerate() {
        let cells = match &spec.on {
            None => (0..mesh.cell_count() as u32).collect(),
            Some(groups) => regions::cells(mesh, &Region::Groups(groups.clone()), &spec.spot)?,
        };
        let twice = cells.iter().filter(|&&cell| of_cell[cell as usize] != u32::MAX);
        if let Some(&first) = twice.clone().next() {
            let other = &specs[of_cell[first as usize] as usize].material.name;
            let what = format!("{} cells are made of both \"{other}\" and \"{}\"", twice.count(), spec.material.name);
            return Err(spec.spot.error(what, "let each cell belong to the groups of one material only"));
        }
        cells.iter().for_each(|&cell| of_cell[cell as usize] = number as u32);
    }
    let bare: Vec<u32> = (0..).zip(&of_cell).filter(|(_, m)| **m == u32::MAX).map(|(cell, _)| cell).collect();
    if let (Some(first), Some(spec)) = (bare.first(), specs.first()) {
        let home = mesh.groups.iter().find(|group| group.cells.binary_search(first).is_ok());
        let home =
            home.map_or("in no group of cells".to_string(), |g| format!("the first of them in group \"{}\"", g.name));
        let what = format!("{} of {} cells have no material, {home}", bare.len(), of_cell.len());
        return Err(spec.spot.error(what, "name their group in the `on` of a material"));
    }
    Ok(of_cell)
}
