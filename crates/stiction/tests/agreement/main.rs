//! Second roads: independent solvers, other methods and paths, dense factorisations; work counted in bands.

mod bodies;
mod cone_program;
mod counts;
mod discrete;
mod global_forms;
mod independent_qp;
mod independent_solver;
mod layers;
mod methods;
mod multigrid;
mod multigrid_hard;
mod random_cases;
mod random_problems;
mod ranks;
mod ranks_bodies;
mod ranks_bolts;
mod ranks_couplings;
mod ranks_files;
mod ranks_generated;
mod ranks_interfaces;
mod ranks_loads;
mod ranks_motion;
mod ranks_quadratic;
mod ranks_remarks;
mod ranks_timed;
mod uniqueness;
