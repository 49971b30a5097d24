//! Elements, materials and loads: from a mesh to a stiffness matrix and a load vector.
//!
//! [`assemble`] poses `K u = f`; [`full_displacement`], [`reactions`] and [`cell_stress`] read its solution;
//! [`unconstrained_motions`] says which rigid motions the prescribed displacements leave free.

mod assembly;
mod axes;
mod congruent_cells;
mod cut;
mod dofs;
mod elastic;
pub mod elements;
mod faces;
mod field;
mod incidence;
mod initial;
mod loads;
mod mass;
mod material;
mod model;
mod recovery;
mod rigid;
mod rotated;
mod row_assembly;
mod solid;
mod springs;
mod submerged;
#[cfg(test)]
mod tests;
mod tractions;

pub use assembly::assemble;
pub(crate) use assembly::assemble_part;
pub use axes::Axes;
pub use cut::{Cut, cut};
pub use dofs::dof_map;
pub use elastic::{Orthotropic, Stiffness, Voigt, frame, strain_along};
pub use faces::{FacePoint, face_coordinates, face_points, nodal_normals};
pub(crate) use faces::{direction, normal_sums};
pub use field::Field;
pub(crate) use incidence::Entries;
pub use initial::InitialStrain;
pub(crate) use initial::initial_strain;
pub(crate) use initial::quadratic_points;
pub(crate) use loads::FaceMoments;
pub use loads::external_forces;
pub use mass::mass;
pub use material::{Formulation, Material, NEARLY_INCOMPRESSIBLE};
pub use model::{DofMap, FeModel, Fix, Followed, Load, Nodal, Temperature};
pub use recovery::{cell_stress, full_displacement, reactions, von_mises};
pub(crate) use recovery::{cell_stress_as, middle_gradient, strain, strain_of};
pub use rigid::{Motion, Unconstrained, unconstrained_motions};
pub use rotated::RotatedNode;
pub use solid::Solid;
pub(crate) use solid::{CellList, cells_of_materials, notes};
pub use springs::{Spring, add_springs};
pub use tractions::{LinearTractions, constant_body_force, linear_tractions};
