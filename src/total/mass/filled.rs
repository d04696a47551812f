//! The mass matrix of a body that fills its grid: a Kronecker product of one matrix an axis, factorised once.

use super::line::Factor;
use crate::basis::Axis;
use crate::quadrature::gauss_legendre;
use crate::total::reference::{Line, MOST};
use std::ops::Range;

/// A symmetric matrix with a band of `MOST - 1` beside the diagonal: entry `[i][k]` is that of row i and column i - k.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::total) struct Band(Vec<[f64; MOST]>);

impl Band {
    /// Integrals of the products of the functions of an axis \[m\].
    pub(in crate::total) fn mass(axis: &Axis) -> Self {
        Self::integrals(axis, |line| line.weight)
    }

    /// Integrals of the products of their slopes \[1/m\].
    pub(in crate::total) fn stiffness(axis: &Axis) -> Self {
        Self::integrals(axis, |line| line.slope)
    }

    fn integrals(axis: &Axis, of: impl Fn(&Line) -> [f64; MOST]) -> Self {
        let mut band = vec![[0.0; MOST]; axis.functions() as usize];
        for cell in 0..axis.cells() {
            for (xi, share) in gauss_legendre(axis.width()) {
                let line = Line::at(axis, axis.origin() + axis.cell_size() * (f64::from(cell) + xi));
                let values = of(&line);
                for a in 0..axis.width() {
                    for b in 0..=a {
                        band[line.first + a][a - b] += share * axis.cell_size() * values[a] * values[b];
                    }
                }
            }
        }
        Self(band)
    }

    /// Rows and columns of a range.
    fn part(&self, range: &Range<usize>) -> Self {
        let cut = |i: usize| std::array::from_fn(|k| if i >= range.start + k { self.0[i][k] } else { 0.0 });
        Self(range.clone().map(cut).collect())
    }

    /// The Cholesky factor.
    fn factor(mut self) -> Factor {
        for i in 0..self.0.len() {
            for k in (0..MOST.min(i + 1)).rev() {
                let j = i - k;
                // entries (i, m) and (j, m) of the factor, for m < j
                let sum: f64 = (1..MOST - k).filter(|d| *d <= j).map(|d| self.0[i][k + d] * self.0[j][d]).sum();
                let entry = self.0[i][k] - sum;
                self.0[i][k] = if k > 0 { entry / self.0[j][0] } else { entry.sqrt() };
            }
        }
        Factor::new(self.0)
    }

    pub(in crate::total) fn entry(&self, i: usize, j: usize) -> f64 {
        let (low, high) = (i.min(j), i.max(j));
        self.0[high].get(high - low).copied().unwrap_or(0.0)
    }

    fn times(&self, x: &[f64], y: &mut [f64]) {
        y.fill(0.0);
        for (i, row) in self.0.iter().enumerate() {
            y[i] += row[0] * x[i];
            for k in 1..MOST.min(i + 1) {
                y[i] += row[k] * x[i - k];
                y[i - k] += row[k] * x[i];
            }
        }
    }
}

/// The mass matrix of a box.
#[derive(Debug)]
pub(in crate::total) struct FilledMass {
    density: f64,
    counts: [usize; 3],
    axes: [Option<Band>; 3],
    /// Of each component: which nodes are free, and factors.
    free: [Free; 3],
    line: Vec<f64>,
    image: Vec<f64>,
}

/// The free nodes of a component and how their part of the matrix is solved.
#[derive(Debug)]
struct Free {
    held: Vec<bool>,
    ranges: [Range<usize>; 3],
    factors: [Option<Factor>; 3],
    /// Whether the free nodes are all of the ranges.
    whole: bool,
}

impl FilledMass {
    /// `held` tells for each component and node whether it is held.
    pub(super) fn new(density: f64, axes: &[Axis], counts: [usize; 3], held: [Vec<bool>; 3]) -> Self {
        let bands: [Option<Band>; 3] = std::array::from_fn(|a| axes.get(a).map(Band::mass));
        let free = held.map(|held| Free::new(held, counts, &bands));
        Self { density, counts, axes: bands, free, line: Vec::new(), image: Vec::new() }
    }

    /// Multiplies one component of a nodal field by the matrix, in place.
    pub(super) fn times(&mut self, field: &mut [f64]) {
        for (a, band) in self.axes.iter().enumerate() {
            let Some(band) = band else { continue };
            let image = &mut self.image;
            along(self.counts, a, &mut self.line, field, |line| {
                image.resize(line.len(), 0.0);
                band.times(line, image);
                line.copy_from_slice(image);
            });
        }
        field.iter_mut().for_each(|v| *v *= self.density);
    }

    /// The rows of the matrix of a box of nodes, times one component of a field.
    pub(super) fn rows_times(&self, rows: &[Range<usize>; 3], field: &[f64]) -> Vec<f64> {
        let mut counts = self.counts;
        let mut left = field.to_vec();
        // axes with few rows first: they leave less to do
        let mut order = [0, 1, 2];
        order.sort_by(|a, b| (rows[*a].len() * self.counts[*b]).cmp(&(rows[*b].len() * self.counts[*a])));
        for a in order {
            let Some(band) = &self.axes[a] else { continue };
            let stride: usize = counts[a + 1..].iter().product();
            let mut product = Vec::with_capacity(left.len() / counts[a] * rows[a].len());
            for block in left.chunks_exact(stride * counts[a]) {
                for i in rows[a].clone() {
                    let start = product.len();
                    product.resize(start + stride, 0.0);
                    for j in i.saturating_sub(MOST - 1)..counts[a].min(i + MOST) {
                        let entry = band.entry(i, j);
                        if entry != 0.0 {
                            product[start..].iter_mut().zip(&block[j * stride..]).for_each(|(p, x)| *p += entry * x);
                        }
                    }
                }
            }
            counts[a] = rows[a].len();
            left = product;
        }
        left.iter_mut().for_each(|v| *v *= self.density);
        left
    }

    /// The entry of two nodes \[kg\].
    pub(super) fn entry(&self, i: usize, j: usize) -> f64 {
        let [_, y, z] = self.counts;
        let index = |i: usize| [i / (y * z), i / z % y, i % z];
        let (i, j) = (index(i), index(j));
        let along = |a: usize| self.axes[a].as_ref().map_or(1.0, |band| band.entry(i[a], j[a]));
        self.density * along(0) * along(1) * along(2)
    }

    /// Solves for the free nodes of a component, in place; what stands at held nodes becomes 0.
    pub(super) fn solve(&mut self, component: usize, right: &mut [f64]) {
        let free = &self.free[component];
        for (value, held) in right.iter_mut().zip(&free.held) {
            if *held {
                *value = 0.0;
            }
        }
        if free.whole {
            solve_box(free, self.counts, self.density, right);
        } else {
            self.iterate(component, right);
        }
    }

    /// Conjugate gradients, preconditioned by the matrix of all nodes in the ranges.
    fn iterate(&mut self, component: usize, right: &mut [f64]) {
        let held = std::mem::take(&mut self.free[component].held);
        let mask = |v: &mut [f64]| v.iter_mut().zip(&held).for_each(|(v, held)| *v = if *held { 0.0 } else { *v });
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let mut residual = right.to_vec();
        let size = dot(&residual, &residual).sqrt();
        right.fill(0.0);
        let (mut direction, mut rho) = (vec![0.0; right.len()], 1.0);
        for _ in 0..1000 {
            if dot(&residual, &residual).sqrt() <= 1e-14 * size {
                break;
            }
            let mut z = residual.clone();
            solve_box(&self.free[component], self.counts, self.density, &mut z);
            mask(&mut z);
            let next = dot(&residual, &z);
            direction.iter_mut().zip(&z).for_each(|(d, z)| *d = z + next / rho * *d);
            rho = next;
            let mut image = direction.clone();
            self.times(&mut image);
            mask(&mut image);
            let step = rho / dot(&direction, &image);
            right.iter_mut().zip(&direction).for_each(|(x, d)| *x += step * d);
            residual.iter_mut().zip(&image).for_each(|(r, i)| *r -= step * i);
        }
        self.free[component].held = held;
    }
}

impl Free {
    fn new(held: Vec<bool>, counts: [usize; 3], bands: &[Option<Band>; 3]) -> Self {
        let free: Vec<bool> = held.iter().map(|held| !held).collect();
        let ranges = super::bounds(&free, counts);
        let number = free.iter().filter(|free| **free).count();
        let whole = number == ranges.iter().map(ExactSizeIterator::len).product::<usize>();
        let factors = std::array::from_fn(|a| bands[a].as_ref().map(|band| band.part(&ranges[a]).factor()));
        Self { held, ranges, factors, whole }
    }
}

fn solve_box(free: &Free, counts: [usize; 3], density: f64, right: &mut [f64]) {
    right.iter_mut().for_each(|v| *v *= 1.0 / density);
    for (a, factor) in free.factors.iter().enumerate() {
        if let Some(factor) = factor {
            factor.solve(counts, a, &free.ranges[a], right);
        }
    }
}

/// Calls `f` with each line of a nodal field along an axis.
fn along(counts: [usize; 3], axis: usize, line: &mut Vec<f64>, field: &mut [f64], mut f: impl FnMut(&mut [f64])) {
    let stride: usize = counts[axis + 1..].iter().product();
    let count = counts[axis];
    line.resize(count, 0.0);
    for block in 0..field.len() / (stride * count) {
        for offset in 0..stride {
            let start = block * stride * count + offset;
            for k in 0..count {
                line[k] = field[start + k * stride];
            }
            f(line);
            for k in 0..count {
                field[start + k * stride] = line[k];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::basis::Family;

    /// Solving undoes multiplying, for held sets that are whole faces and for others.
    #[test]
    fn solving_undoes_multiplying() {
        for degree in 1..=5 {
            let axes: Vec<Axis> = [4, 3, 2].iter().map(|&cells| Axis::new(0.5, 0.3, cells, Family::OpenSpline(degree))).collect();
            let counts: [usize; 3] = std::array::from_fn(|a| axes[a].functions() as usize);
            let n: usize = counts.iter().product();
            let face: Vec<bool> = (0..n).map(|i| i < counts[1] * counts[2]).collect();
            let scattered: Vec<bool> = (0..n).map(|i| i % 7 == 3).collect();
            let mut mass = FilledMass::new(3.0, &axes, counts, [vec![false; n], face.clone(), scattered.clone()]);
            for (component, held) in [vec![false; n], face, scattered].iter().enumerate() {
                let x: Vec<f64> = (0..n).map(|i| if held[i] { 0.0 } else { (i as f64).sin() }).collect();
                let mut y = x.clone();
                mass.times(&mut y);
                mass.solve(component, &mut y);
                let error = x.iter().zip(&y).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
                // the condition number of the matrix of degree 5 in three dimensions is about 1e5
                assert!(error < 1e-9, "degree {degree}, component {component}: {error:e}");
            }
            // some rows give what all rows give there
            let x: Vec<f64> = (0..n).map(|i| (i as f64).cos()).collect();
            let mut y = x.clone();
            mass.times(&mut y);
            let rows = [1..2, 0..counts[1], 1..3];
            let some = mass.rows_times(&rows, &x);
            let each = rows[0].clone().flat_map(|i| rows[1].clone().flat_map(move |j| (1..3).map(move |k| (i, j, k))));
            for ((i, j, k), value) in each.zip(some) {
                assert!((value - y[(i * counts[1] + j) * counts[2] + k]).abs() < 1e-13);
            }
            // the sum of all entries is the mass of the box
            let mut ones = vec![1.0; n];
            mass.times(&mut ones);
            assert!((ones.iter().sum::<f64>() - 3.0 * 1.2 * 0.9 * 0.6).abs() < 1e-12);
        }
    }
}
