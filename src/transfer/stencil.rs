//! Stencils written out node by node, for whatever is not a sweep over all particles: point loads, probes, quadrature points, the mass
//! matrix.

use super::nodes;
use crate::basis::{Axis, Places, Stencils, Third};
use crate::grid::Frame;
use crate::lanes::Wide;

/// Shape functions at a few places, place by place.
#[derive(Debug, Default)]
pub(crate) struct StencilRows {
    /// Nodes in slots.
    pub(crate) nodes: Vec<[i32; 3]>,
    /// N.
    pub(crate) weights: Vec<f64>,
    /// dN/dx \[1/m\] by axis; zero beyond the dimension.
    pub(crate) slopes: Vec<[f64; 3]>,
}

/// Place in a tile of the first node of eight particles; the functions of the grid are elements.
#[inline(always)]
pub(super) fn first_nodes<const D: usize, const W: usize, V: Wide>(axes: &[Axis], x: &[V; D], frame: &Frame, to: &mut [u32]) {
    let mut places = Places { position: [[0.0; 8]; D], half: [[0.0; 8]; D] };
    for a in 0..D {
        x[a].store_lanes(&mut places.position[a]);
    }
    let stencils = Stencils::<W>::at::<D>(axes, &places, Third::Nothing);
    for (lane, to) in to.iter_mut().enumerate() {
        *to = frame.index(stencils.first(lane)) as u32;
    }
}

/// Writes the shape functions at the first `count` of some places.
pub(super) fn tabulate<const D: usize, const W: usize>(axes: &[Axis], places: &Places<3>, count: usize, rows: &mut StencilRows) {
    let places = Places::<D> { position: std::array::from_fn(|a| places.position[a]), half: std::array::from_fn(|a| places.half[a]) };
    let s = Stencils::<W>::at::<D>(axes, &places, Third::Nothing);
    rows.nodes.clear();
    rows.weights.clear();
    rows.slopes.clear();
    for lane in 0..count {
        let first = s.first(lane);
        for i in 0..nodes::<D, W>(0) {
            for j in 0..nodes::<D, W>(1) {
                for k in 0..nodes::<D, W>(2) {
                    let at = [i, j, k];
                    let n: [f64; 3] = std::array::from_fn(|slot| s.weight[slot][at[slot]][lane]);
                    let mut slopes = [0.0; 3];
                    for axis in 0..D {
                        let slot = 3 - D + axis;
                        let others: f64 = (0..3).filter(|&o| o != slot).map(|o| n[o]).product();
                        slopes[axis] = s.slope[slot][at[slot]][lane] * others;
                    }
                    rows.nodes.push(std::array::from_fn(|slot| first[slot] + at[slot] as i32));
                    rows.weights.push(n[0] * n[1] * n[2]);
                    rows.slopes.push(slopes);
                }
            }
        }
    }
}
