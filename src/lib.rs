//! `matpoint` simulates elastic solids with the material point method (MPM), made to be stepped by somebody else.

mod basis;
pub mod component;
mod grid;
mod material;
mod model;
pub mod record;
pub mod scene;
mod state;
mod step;
mod transfer;

pub use component::Simulation;
