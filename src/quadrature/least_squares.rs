//! Quadrature of any body, cell by cell: Gauss points in the cells that the body fills, with fields fitted to the particles there
//! (Wobbes, Moller, Galavi, Vuik 2019, IJNME 117, 271-290). Cells at the surface are left to particle quadrature.
//!
//! Wobbes et al. fix the mean of density and momentum density in each cell to what its particles carry. That holds the sum in the cell but
//! ruins the field once particles cross cells: one of four more or less is a quarter of the density (Tielen's bar, 32 cells: displacement
//! error 5.3e-5 m with fixed means, 2.5e-7 m without). So means are fitted too, and sums are made good over the whole body instead.

#[cfg(test)]
mod tests;

use super::gauss::gauss_legendre;
use super::taylor::{Factor, MOST, basis, factor_length};
use super::{GridAxis, Point};
use std::ops::Range;

/// Share of its volume from which on a cell with particles all around counts as full.
///
/// With `m` particles a cell and axis a covered cell of a stretched body holds as little as (1 - 1 / m) an axis, so a high share would
/// leave covered cells to particles: in rectangles of stretch 0.75 to 1.35, turned by 0 to 45 degrees, 0.9 lost 2 to 38 % of the
/// covered cells with 3 and 4 particles, 0.7 up to 7 %, 0.5 up to 0.1 %, 0.4 none. No cut cell passed for full at any share, as its
/// neighbours are empty; the share is there for gaps within a body.
pub(crate) const FULL_SHARE: f64 = 0.4;

/// A cell with particles.
#[derive(Debug, Clone)]
pub(crate) struct Cell {
    /// By axis, counted from 0.
    pub(crate) index: [i32; 3],
    /// Its particles: a range of [`CellQuadrature::particles`].
    pub(crate) particles: Range<usize>,
    /// Sum of the volumes of its particles over its own \[-\].
    pub(crate) share: f64,
    /// Fit of a full cell; none for a cell that is left to particle quadrature.
    pub(crate) fit: Option<Factor>,
}

/// The cells of a body, the Gauss points of the full ones, and how fields at the particles lead to values there.
#[derive(Debug, Clone)]
pub(crate) struct CellQuadrature {
    grid: Grid,
    full_share: f64,
    /// Points of a cell: local coordinates and share of the volume.
    rule: Vec<([f64; 3], f64)>,
    /// The functions at the points of a cell.
    functions: Vec<[f64; MOST]>,
    /// Cell number and particle, sorted.
    particles: Vec<(u64, u32)>,
    /// Local coordinates, in the same order.
    local: Vec<[f64; 3]>,
    cells: Vec<Cell>,
    points: Vec<Point>,
    /// Of the full cells, one after the other.
    factors: Vec<f64>,
}

impl CellQuadrature {
    /// A cell is full from `full_share` of its volume on; see [`FULL_SHARE`].
    pub(crate) fn new(axes: &[GridAxis], full_share: f64) -> Self {
        let mut rule = vec![([0.0; 3], 1.0)];
        for (a, axis) in axes.iter().enumerate() {
            let line = gauss_legendre(axis.gauss);
            let with = |&(place, share): &([f64; 3], f64)| {
                line.iter().map(move |(at, weight)| {
                    let mut place = place;
                    place[a] = 2.0 * at - 1.0;
                    (place, share * weight)
                })
            };
            rule = rule.iter().flat_map(with).collect();
        }
        let functions = rule.iter().map(|(place, _)| basis(axes.len(), place)).collect();
        Self {
            grid: Grid(axes.to_vec()),
            full_share,
            rule,
            functions,
            particles: Vec::new(),
            local: Vec::new(),
            cells: Vec::new(),
            points: Vec::new(),
            factors: Vec::new(),
        }
    }

    /// Gauss points of the full cells, cell by cell with the last axis fastest.
    pub(crate) fn points(&self) -> &[Point] {
        &self.points
    }

    /// Cells with particles, in the same order.
    #[cfg(test)]
    pub(crate) fn cells(&self) -> &[Cell] {
        &self.cells
    }

    /// Particles of a cell.
    pub(crate) fn particles(&self, cell: &Cell) -> impl Iterator<Item = usize> {
        self.particles[cell.particles.clone()].iter().map(|(_, p)| *p as usize)
    }

    /// Particles in cells that are not full: there the integrals are sums over them.
    pub(crate) fn left(&self) -> impl Iterator<Item = usize> {
        self.cells.iter().filter(|cell| cell.fit.is_none()).flat_map(|cell| self.particles(cell))
    }

    /// How many cells these are in.
    pub(crate) fn left_cells(&self) -> usize {
        self.cells.iter().filter(|cell| cell.fit.is_none()).count()
    }

    /// Sorts particles at `position` by axis \[m\] with `volume` \[m, m2 or m3\] into cells and makes the points of the full ones. All
    /// particles must lie in the grid. Beyond the grid nothing is asked for: a body that ends with it fills its last cells.
    pub(crate) fn prepare(&mut self, position: &[&[f64]], volume: &[f64]) {
        self.particles.clear();
        self.particles.extend((0..volume.len()).map(|p| (self.grid.number(|a| self.grid.locate(a, position[a][p]).0), p as u32)));
        self.particles.sort_unstable();
        self.local.clear();
        for &(_, p) in &self.particles {
            let mut local = [0.0; 3];
            for a in 0..self.grid.dimension() {
                local[a] = self.grid.locate(a, position[a][p as usize]).1;
            }
            self.local.push(local);
        }
        let cell_volume = self.grid.cell_volume();
        self.cells.clear();
        let mut start = 0;
        for particles in self.particles.chunk_by(|p, q| p.0 == q.0) {
            let range = start..start + particles.len();
            start = range.end;
            let share = particles.iter().map(|(_, p)| volume[*p as usize]).sum::<f64>() / cell_volume;
            self.cells.push(Cell { index: self.grid.index(particles[0].0), particles: range, share, fit: None });
        }
        self.fit();
    }

    /// Factors the fits of the full cells and makes their points.
    fn fit(&mut self) {
        let (dimension, length, volume) = (self.grid.dimension(), factor_length(self.grid.dimension()), self.grid.cell_volume());
        self.points.clear();
        self.factors.clear();
        for c in 0..self.cells.len() {
            if !self.is_full(&self.cells[c]) {
                continue;
            }
            let local = &self.local[self.cells[c].particles.clone()];
            let start = self.factors.len();
            self.factors.resize(start + length, 0.0);
            self.cells[c].fit = Some(Factor::new(dimension, local, &mut self.factors[start..]));
            let index = self.cells[c].index;
            for (place, share) in &self.rule {
                let mut position = [0.0; 3];
                for (a, axis) in self.grid.0.iter().enumerate() {
                    position[a] = axis.origin + axis.cell * (index[a] as f64 + 0.5 + 0.5 * place[a]);
                }
                self.points.push(Point { cell: index, position, weight: share * volume });
            }
        }
    }

    /// A neighbour without particles says that the surface may run here. Neighbours by an edge or a corner count as well: at a surface
    /// that runs across the grid those by a face all have particles (at 45 degrees cut cells then passed for full, 2 % of the area).
    fn is_full(&self, cell: &Cell) -> bool {
        let dimension = self.grid.dimension();
        let occupied = |neighbour: usize| {
            let mut index = cell.index;
            let mut digits = neighbour;
            for a in 0..dimension {
                index[a] += (digits % 3) as i32 - 1;
                digits /= 3;
                if index[a] < 0 || index[a] >= self.grid.0[a].cells as i32 {
                    return true;
                }
            }
            self.cells.binary_search_by_key(&self.grid.number(|a| index[a]), |c| self.particles[c.particles.start].0).is_ok()
        };
        cell.share >= self.full_share && (0..3_usize.pow(dimension as u32)).all(occupied)
    }

    /// Values at the points of `fields` at the particles.
    pub(crate) fn evaluate<const K: usize>(&self, fields: [&[f64]; K], values: &mut Vec<[f64; K]>) {
        values.clear();
        let full = self.cells.iter().filter_map(|cell| Some((cell, cell.fit?)));
        for ((cell, factor), lower) in full.zip(self.factors.chunks_exact(factor_length(self.grid.dimension()))) {
            let at_particles = self.particles(cell).map(|p| fields.map(|field| field[p]));
            let coefficients = factor.solve(self.grid.dimension(), lower, &self.local[cell.particles.clone()], at_particles);
            let terms = &coefficients[..factor.functions];
            values.extend(self.functions.iter().map(|psi| std::array::from_fn(|k| terms.iter().zip(psi).map(|(c, psi)| c[k] * psi).sum())));
        }
    }
}

/// The cells of the grid.
#[derive(Debug, Clone)]
struct Grid(Vec<GridAxis>);

impl Grid {
    fn dimension(&self) -> usize {
        self.0.len()
    }

    fn cell_volume(&self) -> f64 {
        self.0.iter().map(|axis| axis.cell).product()
    }

    /// Cell along an axis and local coordinate in it, -1 to 1.
    fn locate(&self, axis: usize, x: f64) -> (i32, f64) {
        let axis = &self.0[axis];
        let place = (x - axis.origin) / axis.cell;
        // the upper end of the grid belongs to its last cell
        let cell = (place as i32).min(axis.cells as i32 - 1);
        (cell, 2.0 * (place - cell as f64) - 1.0)
    }

    /// Number of a cell of the grid, the last axis fastest.
    fn number(&self, index: impl Fn(usize) -> i32) -> u64 {
        self.0.iter().enumerate().fold(0, |number, (a, axis)| number * axis.cells as u64 + index(a) as u64)
    }

    /// Cell of a number.
    fn index(&self, mut number: u64) -> [i32; 3] {
        let mut index = [0; 3];
        for (a, axis) in self.0.iter().enumerate().rev() {
            index[a] = (number % axis.cells as u64) as i32;
            number /= axis.cells as u64;
        }
        index
    }
}
