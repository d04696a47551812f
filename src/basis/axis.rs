//! One axis of the grid and the shape functions along it.

use super::{bspline, lagrange};

/// How far outside the grid, in cells, a position still counts as on its edge: round-off of positions, not motion.
const EDGE_TOLERANCE: f64 = 1e-9;

/// A particle exactly on a node would give the next node no mass but, with linear functions and at open ends, a slope: that node's velocity
/// would be 0/0. So local coordinates keep this much off the edges of a cell, which shifts nothing beyond round-off.
pub(crate) const OFF_EDGE: f64 = 1e-14;

/// Families of shape functions along an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Family {
    /// B-splines of this degree, with open knots at the ends of the grid; degree 1 is piecewise linear.
    OpenSpline(usize),
    /// Quadratic Lagrange elements, each over two cells.
    Elements,
    /// Uniform cubic B-splines, with one node outside the grid at either end (Andersen 2007, section 3.4).
    UniformCubic,
    /// Linear functions averaged over the domain of a particle (GIMP): up to one cell wide where domains keep their size, up to two where
    /// they follow the deformation. One node outside the grid at either end.
    Domains { follow: bool },
}

/// Polynomials of the local coordinate, by class of cell.
#[derive(Debug, Clone, Default)]
pub(super) struct Pieces {
    /// Coefficients by class, power of the local coordinate, function.
    pub(super) coefficients: Vec<f64>,
    /// Places of the nodes by class and function, in cells from the lower edge of the cell.
    pub(super) places: Vec<f64>,
}

/// Cells far from the ends of the grid, which all see the same polynomials.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Inner {
    /// First and last of them.
    pub(crate) cells: (f64, f64),
    class: usize,
}

/// The shape functions of one axis. In a cell `width` functions in a row are not zero.
#[derive(Debug, Clone)]
pub(crate) struct Axis {
    origin: f64,
    cell: f64,
    inverse: f64,
    cells: i32,
    family: Family,
    width: usize,
    pieces: Pieces,
    /// Cells at an end that see the repeated knots.
    border: i32,
}

impl Axis {
    pub(crate) fn new(origin: f64, cell: f64, cells: usize, family: Family) -> Self {
        let cells = cells as i32;
        let (width, border, pieces) = match family {
            Family::OpenSpline(degree) => (degree + 1, bspline::border(degree), bspline::open(cells, degree)),
            Family::Elements => (3, 0, lagrange::pieces()),
            Family::UniformCubic => (4, 0, bspline::uniform_cubic()),
            Family::Domains { follow } => (if follow { 4 } else { 3 }, 0, Pieces::default()),
        };
        Self { origin, cell, inverse: 1.0 / cell, cells, family, width, pieces, border }
    }

    pub(crate) fn family(&self) -> Family {
        self.family
    }
    /// Number of functions that are not zero in a cell.
    pub(crate) fn width(&self) -> usize {
        self.width
    }
    /// Number of functions.
    pub(crate) fn functions(&self) -> i32 {
        match self.family {
            Family::OpenSpline(degree) => self.cells + degree as i32,
            Family::Elements => self.cells + 1,
            Family::UniformCubic | Family::Domains { follow: false } => self.cells + 3,
            // a domain of two cells may reach as far, with weight zero
            Family::Domains { follow: true } => self.cells + 4,
        }
    }
    #[inline(always)]
    pub(crate) fn cells(&self) -> i32 {
        self.cells
    }
    pub(crate) fn origin(&self) -> f64 {
        self.origin
    }
    #[inline(always)]
    pub(crate) fn cell_size(&self) -> f64 {
        self.cell
    }
    /// Smallest cell size of several axes \[m\].
    pub(crate) fn smallest_cell(axes: &[Self]) -> f64 {
        axes.iter().map(Self::cell_size).fold(f64::INFINITY, f64::min)
    }
    #[inline(always)]
    pub(crate) fn inverse_cell(&self) -> f64 {
        self.inverse
    }

    /// Cell and local coordinate of a position in the grid. Cells are half-open, the last one is closed.
    #[inline(always)]
    pub(crate) fn cell(&self, x: f64) -> (i32, f64) {
        let s = (x - self.origin) * self.inverse;
        // `as` saturates, so that even a wild position yields a cell that exists; it rounds towards zero, and `floor` may be a call
        let toward_zero = s as i32;
        let cell = toward_zero.saturating_sub(i32::from(f64::from(toward_zero) > s)).clamp(0, self.cells - 1);
        (cell, (s - cell as f64).clamp(OFF_EDGE, 1.0 - OFF_EDGE))
    }

    /// Lowest and highest number of cells from the origin at which a position still is in the grid.
    #[inline(always)]
    pub(crate) fn ends_of_places(&self) -> (f64, f64) {
        (-EDGE_TOLERANCE, self.cells as f64 + EDGE_TOLERANCE)
    }

    /// Whether a position lies in the grid, its edges included. False for NaN.
    #[inline(always)]
    pub(crate) fn holds(&self, x: f64) -> bool {
        let s = (x - self.origin) * self.inverse;
        let (low, high) = self.ends_of_places();
        s >= low && s <= high
    }

    /// The position, or the nearest end of the grid \[m\].
    pub(crate) fn clamped(&self, x: f64) -> f64 {
        x.clamp(self.origin, self.origin + self.cell * self.cells as f64)
    }

    /// Half-length of the longest particle domain that fits the stencil \[m\].
    pub(crate) fn widest(&self) -> f64 {
        let cells = match self.family {
            Family::Domains { follow: true } => 1.0,
            Family::Domains { follow: false } => 0.5,
            _ => f64::INFINITY,
        };
        cells * self.cell * (1.0 + EDGE_TOLERANCE)
    }

    /// Whether a particle domain of this half-length \[m\] does.
    pub(crate) fn fits(&self, half: f64) -> bool {
        half <= self.widest() && (half > 0.0 || self.widest() == f64::INFINITY)
    }

    /// First function of the polynomials of a cell.
    #[inline(always)]
    pub(crate) fn first(&self, cell: i32) -> i32 {
        if self.family == Family::Elements { cell & !1 } else { cell }
    }

    /// First and last function that particles in a cell may touch.
    #[inline(always)]
    pub(crate) fn reach(&self, cell: i32) -> (i32, i32) {
        let first = self.first(cell);
        let more = if matches!(self.family, Family::Domains { .. }) { 0 } else { 1 };
        (first, first + self.width as i32 - more)
    }

    /// The cells that see the same B-splines, if there are any.
    pub(crate) fn inner(&self) -> Option<Inner> {
        let border = match self.family {
            Family::OpenSpline(_) if self.border == 0 || self.cells > 2 * self.border + 1 => self.border,
            Family::UniformCubic => 0,
            _ => return None,
        };
        Some(Inner { cells: (f64::from(border), f64::from(self.cells - 1 - border)), class: border as usize })
    }

    /// Polynomial coefficients of the functions in the inner cells, by power and function, and the places of their nodes, in cells from the
    /// lower edge of the cell.
    #[inline(always)]
    pub(crate) fn inner_piece<const W: usize>(&self, inner: Inner) -> (&[[f64; W]; W], &[f64; W]) {
        self.piece(inner.class)
    }

    /// Polynomial coefficients of the functions in cells of a class, by power and function, and the places of their nodes, in cells from
    /// the lower edge of the cell.
    #[inline(always)]
    pub(crate) fn piece<const W: usize>(&self, class: usize) -> (&[[f64; W]; W], &[f64; W]) {
        let pieces = &self.pieces;
        (&pieces.coefficients.as_chunks::<W>().0.as_chunks::<W>().0[class], &pieces.places.as_chunks::<W>().0[class])
    }

    /// Position of the node of function `i` \[m\], for B-splines its Greville point: where the coefficient acts like a nodal value.
    pub(crate) fn node_position(&self, i: i32) -> f64 {
        let place = match self.family {
            Family::OpenSpline(degree) => bspline::greville_point(self.cells, degree, i),
            Family::Elements => i as f64,
            Family::UniformCubic | Family::Domains { .. } => (i - 1) as f64,
        };
        self.origin + self.cell * place
    }

    /// Integral of function `i` over that of one in the middle: splines at open knots are narrower.
    pub(crate) fn share(&self, i: i32) -> f64 {
        match self.family {
            Family::OpenSpline(degree) => bspline::share(self.cells, degree, i),
            _ => 1.0,
        }
    }

    /// Weights of the functions from `first` on, as many as are not zero in a cell, that give function `i` the coefficient it has in the
    /// polynomial that they stand for. For B-splines.
    pub(crate) fn extension(&self, i: i32, first: i32) -> Vec<f64> {
        bspline::extension(self.cells, self.width - 1, i, first)
    }

    /// Whether function `i` belongs to the lower or upper end of the grid: its node lies there or outside.
    pub(crate) fn ends(&self, i: i32, upper: bool) -> bool {
        match self.family {
            Family::OpenSpline(_) | Family::Elements => i == if upper { self.functions() - 1 } else { 0 },
            Family::UniformCubic | Family::Domains { .. } => {
                if upper {
                    i > self.cells
                } else {
                    i <= 1
                }
            }
        }
    }

    /// Cells of one class have the same polynomials: with open knots each cell near an end is its own class, all others are one.
    #[inline(always)]
    pub(crate) fn class(&self, cell: i32) -> usize {
        let (border, cells) = (self.border, self.cells);
        let class = if self.family == Family::Elements {
            cell & 1
        } else if border == 0 {
            0
        } else if cells <= 2 * border + 1 || cell < border {
            cell
        } else if cell >= cells - border {
            2 * border + 1 - (cells - cell)
        } else {
            border
        };
        class as usize
    }
}
