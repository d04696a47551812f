//! Quadrature points in the cells of the grid, with fields reconstructed from the particles: integrals over the body are then taken with
//! Gauss rules instead of at the particles, whose error caps the order of convergence (Tielen 2016, chapter 7; Wobbes et al. 2019).
//!
//! Two reconstructions: [`lines`] interpolates with splines along the lines of particles of a body that is a lattice,
//! [`least_squares`] fits a polynomial in each full cell to the particles of any body.

mod cut;
mod gauss;
mod least_squares;
mod lines;
mod sheet;
mod solid;
mod spline;
mod taylor;

use crate::basis::Axis;
pub(crate) use cut::{Curve, CutQuadrature, EdgePoint, Lost};
pub(crate) use gauss::gauss_legendre;
pub(crate) use least_squares::{CellQuadrature, FULL_SHARE};
pub(crate) use lines::{Folded, LineQuadrature, Scratch, stretches};
pub(crate) use sheet::{SheetQuadrature, SidePoint, Trouble};
pub(crate) use solid::{Bound, Solid, SolidQuadrature};

/// An axis of the grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct GridAxis {
    /// Lower end of the first cell \[m\].
    pub(crate) origin: f64,
    /// Size of a cell \[m\].
    pub(crate) cell: f64,
    /// Number of cells.
    pub(crate) cells: usize,
    /// Gauss points along this axis: in [`lines`] on each half cell, in [`least_squares`] on each cell.
    pub(crate) gauss: usize,
}

impl GridAxis {
    /// The cells of an axis of functions, with this many Gauss points in each.
    pub(crate) fn of(axis: &Axis, gauss: usize) -> Self {
        Self { origin: axis.origin(), cell: axis.cell_size(), cells: axis.cells() as usize, gauss }
    }
}

/// Where the integrand is taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Point {
    /// Cell by axis, counted from 0; 0 for axes beyond the dimension.
    pub(crate) cell: [i32; 3],
    /// Position \[m\]; 0 for axes beyond the dimension.
    pub(crate) position: [f64; 3],
    /// Share of the length, area or volume of the body \[m, m2 or m3\].
    pub(crate) weight: f64,
}
