//! Sides of bodies whose particles stand in rows: where they are now, and fields there.
//!
//! A side is a body in rows of one dimension less. Its Gauss points in cells come from splines along it, and what is known at the end of each
//! row across it. It may bend, as long as it can be seen along the axis across it.

use crate::model::{Lattice, Side};
use crate::quadrature::{Folded, GridAxis, LineQuadrature, Point, Scratch};
use nalgebra::Matrix3;

/// A point of a side of any body.
#[derive(Debug, Clone, Copy)]
pub(super) struct OnSide {
    /// Among the points of the edge of a sheet, or of this side.
    pub(super) number: u32,
    /// Position \[m\].
    pub(super) position: [f64; 3],
    /// Outward unit normal times area \[m2\] (length in dimension 2, 1 in dimension 1).
    pub(super) area: [f64; 3],
    /// Position at time 0 \[m\].
    pub(super) at: [f64; 3],
    /// Area at time 0 \[m2\].
    pub(super) rest: f64,
}

/// A side of a body in rows.
#[derive(Debug)]
pub(super) struct RowSide {
    pub(super) side: Side,
    /// Axes along it.
    along: Vec<usize>,
    /// Area at time 0 \[m2\].
    whole: f64,
    /// What makes the points; none for the end of a line.
    rule: Option<LineQuadrature>,
    pub(super) points: Vec<OnSide>,
}

impl RowSide {
    /// Of a body with these extents \[m\] at time 0.
    pub(super) fn new(side: Side, lattice: &Lattice, axes: &[GridAxis], extents: &[f64]) -> Self {
        let along: Vec<usize> = (0..axes.len()).filter(|axis| *axis != side.axis).collect();
        let (mut counts, mut ends): ([usize; 3], [[Vec<f64>; 2]; 3]) = ([1; 3], Default::default());
        for (k, axis) in along.iter().enumerate() {
            counts[k] = lattice.counts[*axis];
            ends[k] = lattice.ends[*axis].clone();
        }
        let axes: Vec<GridAxis> = along.iter().map(|axis| axes[*axis]).collect();
        let rule = (!axes.is_empty()).then(|| LineQuadrature::new(counts, &ends, &axes));
        let whole = along.iter().map(|axis| extents[*axis]).product();
        Self { side, along, whole, rule, points: Vec::new() }
    }

    /// What a field of the lattice is at the ends of the rows across the side.
    fn end(&self, lattice: &Lattice, field: impl Fn(usize) -> f64) -> Vec<f64> {
        let [n0, n1, n2] = lattice.counts;
        let weights = &lattice.ends[self.side.axis][usize::from(self.side.upper)];
        let count = lattice.counts[self.side.axis];
        let mut values = Vec::new();
        let only = |axis: usize, n: usize| if axis == self.side.axis { 0..1 } else { 0..n };
        for i in only(0, n0) {
            for j in only(1, n1) {
                for k in only(2, n2) {
                    let at = |from_end: usize| {
                        let mut at = [i, j, k];
                        at[self.side.axis] = if self.side.upper { count - 1 - from_end } else { from_end };
                        (at[0] * n1 + at[1]) * n2 + at[2]
                    };
                    values.push(weights.iter().enumerate().map(|(k, weight)| weight * field(at(k))).sum());
                }
            }
        }
        values
    }

    /// Values at the points of fields of the lattice.
    pub(super) fn values<const K: usize>(&self, lattice: &Lattice, field: impl Fn(usize, usize) -> f64) -> Vec<[f64; K]> {
        let columns: [Vec<f64>; K] = std::array::from_fn(|k| self.end(lattice, |p| field(p, k)));
        let mut values = Vec::new();
        match &self.rule {
            Some(rule) => rule.evaluate(columns.each_ref().map(Vec::as_slice), &mut Scratch::default(), &mut values),
            None => values.push(columns.map(|column| column[0])),
        }
        values
    }

    /// Finds the points. By place in the lattice: `half` is that of a particle along an axis \[m\], the others are position, position at time 0, and
    /// the deformation gradient.
    pub(super) fn prepare(
        &mut self,
        lattice: &Lattice,
        half: impl Fn(usize, usize) -> f64,
        position: impl Fn(usize, usize) -> f64,
        reference: impl Fn(usize, usize) -> f64,
        deformation: impl Fn(usize) -> Matrix3<f64>,
    ) -> Result<(), Folded> {
        self.points.clear();
        let columns = |of: &dyn Fn(usize, usize) -> f64| -> Vec<Vec<f64>> {
            self.along.iter().map(|axis| self.end(lattice, |p| of(p, *axis))).collect()
        };
        let (places, halves) = (columns(&position), columns(&half));
        let found = match &mut self.rule {
            Some(rule) => {
                let [places, halves] = [&places, &halves].map(|columns| columns.iter().map(Vec::as_slice).collect::<Vec<_>>());
                rule.prepare(&places, &halves)?;
                rule.points().to_vec()
            }
            None => vec![Point { cell: [0; 3], position: [0.0; 3], weight: 1.0 }],
        };
        let across = self.side.axis;
        let fields = self.values::<4>(lattice, |p, k| if k == 3 { position(p, across) } else { reference(p, k) });
        let slopes = self.values::<9>(lattice, |p, k| deformation(p)[(k / 3, k % 3)]);
        let sign = if self.side.upper { 1.0 } else { -1.0 };
        for (number, ((point, field), slope)) in found.iter().zip(fields).zip(slopes).enumerate() {
            let mut at = [0.0; 3];
            self.along.iter().enumerate().for_each(|(k, axis)| at[*axis] = point.position[k]);
            at[across] = field[3];
            // Nanson: n da = J F^-T N dA; the weight is the part of it along the axis across
            let normal = super::load::cofactor(&Matrix3::from_row_slice(&slope)).column(across) * sign;
            let rest = point.weight / (sign * normal[across]);
            let area = (normal * rest).into();
            self.points.push(OnSide { number: number as u32, position: at, area, at: [field[0], field[1], field[2]], rest });
        }
        // so that the resultant of a dead traction is exact
        let sum: f64 = self.points.iter().map(|point| point.rest).sum();
        self.points.iter_mut().for_each(|point| point.rest *= self.whole / sum);
        Ok(())
    }
}
