//! Files and cases as others write them, damaged ones, and the order of the modules.

mod architecture;
mod documents;
mod door;
mod fclib;
mod friction_arrays;
mod inputs;
mod ranks;
