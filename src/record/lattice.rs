//! Who was whose neighbour at time 0: from it come the outline of a deformed body and the shape of a particle, without a deformation gradient.

#![cfg_attr(not(feature = "rerun"), expect(dead_code, reason = "only Rerun shows outlines"))]

use super::data::About;
use crate::scene::Shape;
use std::collections::{BTreeMap, HashMap};

/// No neighbour there.
const NONE: u32 = u32::MAX;

/// The lattice on which the particles of a scene are made.
pub(crate) struct Lattice {
    dimension: usize,
    /// For each particle: the next one down and up each axis.
    neighbours: Vec<[u32; 6]>,
    /// Which place each particle took: axis by axis.
    slots: Vec<[i64; 3]>,
    body: Vec<u32>,
    spacing: Vec<Vec<f64>>,
    /// Bodies whose edges are worth drawing: plane ones, and boxes.
    outlined: Vec<bool>,
}

impl Lattice {
    pub(crate) fn new(about: &About) -> Self {
        let dimension = about.dimension();
        let origin = &about.scene.grid.origin;
        let slot = |p: usize| -> [i64; 3] {
            let spacing = &about.spacing[about.body[p] as usize];
            std::array::from_fn(|a| match spacing.get(a) {
                Some(spacing) => ((about.initial[dimension * p + a] - origin[a]) / spacing).floor() as i64,
                None => 0,
            })
        };
        let slots: Vec<[i64; 3]> = (0..about.body.len()).map(slot).collect();
        let places: HashMap<(u32, [i64; 3]), u32> = slots.iter().enumerate().map(|(p, &s)| ((about.body[p], s), p as u32)).collect();
        let neighbours = slots.iter().enumerate().map(|(p, &slot)| {
            std::array::from_fn(|side| {
                let mut next = slot;
                next[side / 2] += if side % 2 == 1 { 1 } else { -1 };
                places.get(&(about.body[p], next)).copied().unwrap_or(NONE)
            })
        });
        let outlined = about.scene.body.values().map(|body| dimension == 2 || matches!(body.shape, Shape::Box { .. })).collect();
        Self { dimension, neighbours: neighbours.collect(), slots, body: about.body.clone(), spacing: about.spacing.clone(), outlined }
    }

    fn at(&self, position: &[f64], p: u32) -> [f64; 3] {
        let p = p as usize * self.dimension;
        std::array::from_fn(|a| if a < self.dimension { position[p + a] } else { 0.0 })
    }

    /// Edge `axis` of the cuboid that particle `p` has become \[m\]: from where its neighbours are.
    pub(crate) fn edge(&self, position: &[f64], p: usize, axis: usize) -> [f64; 3] {
        let (low, high) = (self.neighbours[p][2 * axis], self.neighbours[p][2 * axis + 1]);
        let here = p as u32;
        let (from, to, count) = match (low, high) {
            (NONE, NONE) => {
                let mut edge = [0.0; 3];
                edge[axis] = self.spacing[self.body[p] as usize][axis];
                return edge;
            }
            (NONE, high) => (here, high, 1.0),
            (low, NONE) => (low, here, 1.0),
            (low, high) => (low, high, 2.0),
        };
        let (from, to) = (self.at(position, from), self.at(position, to));
        std::array::from_fn(|a| (to[a] - from[a]) / count)
    }

    fn is_free(&self, p: usize, axis: usize, upper: bool) -> bool {
        self.neighbours[p][2 * axis + usize::from(upper)] == NONE
    }

    /// The outline of the bodies as pairs of points \[m\]: the rim of plane bodies, the edges of boxes in space.
    pub(crate) fn outline(&self, position: &[f64]) -> Vec<[[f64; 3]; 2]> {
        // Particles around a corner see it at places that differ a little: it is drawn at their mean.
        let mut corners: BTreeMap<(u32, [i64; 3]), ([f64; 3], f64)> = BTreeMap::new();
        let mut lines: Vec<[(u32, [i64; 3]); 2]> = Vec::new();
        for p in 0..self.slots.len() {
            if !self.outlined[self.body[p] as usize] || self.neighbours[p][..2 * self.dimension].iter().all(|&n| n != NONE) {
                continue;
            }
            for ends in self.lines(p) {
                let keys = ends.map(|end| (self.body[p], std::array::from_fn(|a| self.slots[p][a] + i64::from(end[a] > 0))));
                for (key, end) in keys.iter().zip(ends) {
                    let mut corner = self.at(position, p as u32);
                    for axis in 0..self.dimension {
                        let edge = self.edge(position, p, axis);
                        (0..3).for_each(|a| corner[a] += 0.5 * f64::from(end[axis]) * edge[a]);
                    }
                    let sum = corners.entry(*key).or_default();
                    (0..3).for_each(|a| sum.0[a] += corner[a]);
                    sum.1 += 1.0;
                }
                lines.push(keys);
            }
        }
        let place = |key: &(u32, [i64; 3])| corners.get(key).map_or([0.0; 3], |(sum, count)| sum.map(|s| s / count));
        lines.iter().map(|[from, to]| [place(from), place(to)]).collect()
    }

    /// The lines that particle `p` adds to the outline; each end is -1 or 1 along each axis.
    fn lines(&self, p: usize) -> Vec<[[i8; 3]; 2]> {
        let sign = |upper: bool| if upper { 1 } else { -1 };
        let mut lines = Vec::new();
        let sides: Vec<(usize, bool)> = (0..self.dimension).flat_map(|axis| [(axis, false), (axis, true)]).collect();
        match self.dimension {
            2 => {
                for &(axis, upper) in sides.iter().filter(|&&(axis, upper)| self.is_free(p, axis, upper)) {
                    let mut ends = [[0; 3]; 2];
                    for (end, along) in ends.iter_mut().zip([-1, 1]) {
                        (end[axis], end[1 - axis]) = (sign(upper), along);
                    }
                    lines.push(ends);
                }
            }
            3 => {
                for (i, &(a, above)) in sides.iter().enumerate() {
                    for &(b, beyond) in &sides[i + 1..] {
                        if a != b && self.is_free(p, a, above) && self.is_free(p, b, beyond) {
                            let mut ends = [[0; 3]; 2];
                            for (end, along) in ends.iter_mut().zip([-1, 1]) {
                                (end[a], end[b], end[3 - a - b]) = (sign(above), sign(beyond), along);
                            }
                            lines.push(ends);
                        }
                    }
                }
            }
            _ => {}
        }
        lines
    }
}
