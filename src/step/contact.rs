//! Contact: each body moves in its own velocity field, and where two fields meet at a node they must not come closer there (Bardenhagen et
//! al. 2001, section 2). Momentum is exchanged, pair by pair, so its sum is what it was.

use super::Stepper;
use super::integrate::Integration;
use crate::grid::Lanes;
use crate::model::Model;

impl Stepper {
    /// Finds the nodes that two bodies reach with their quadrature points.
    pub(super) fn find_touching(&self, all: &mut Integration) {
        let mut reached = vec![false; self.grid.momentum.len()];
        for point in 0..all.rows.len() {
            all.rows.row(point).for_each(|(node, _)| reached[node] = true);
        }
        let pairs =
            self.grid.encounters.iter().flat_map(|pair| (0..self.grid.nodes_a_block()).map(|k| pair.map(|first| first as usize + k)));
        all.touching.clear();
        all.touching.extend(pairs.filter(|pair| pair.iter().all(|node| reached[*node])).flatten());
        all.touching.sort_unstable();
        all.touching.dedup();
    }

    /// Corrects the velocities of nodes that two bodies reach. With a kick their accelerations are corrected too, through which the
    /// particles get the impulse; without one only the motion of the particles is.
    pub(super) fn contact(&mut self, model: &Model, kick: Option<f64>) {
        let Some(friction) = model.friction else { return };
        let encounters = std::mem::take(&mut self.grid.encounters);
        if kick.is_some() {
            self.contacts = 0;
        }
        for &[a, b] in &encounters {
            for k in 0..self.grid.nodes_a_block() {
                let (a, b) = (a as usize + k, b as usize + k);
                let [m, n] = [a, b].map(|i| self.pushed_mass(i));
                if m <= 0.0 || n <= 0.0 {
                    continue;
                }
                let Some(normal) = self.normal(model, a, b) else { continue };
                if kick.is_some_and(|kick| !self.approached(a, b, normal, kick)) {
                    continue;
                }
                self.contacts += usize::from(kick.is_some());
                let [v, w] = [a, b].map(|i| self.grid.momentum[i]);
                let impulse = impulse(&[m, v[1], v[2], v[3]], &[n, w[1], w[2], w[3]], normal, friction);
                for (index, mass, sign) in [(a, m, -1.0), (b, n, 1.0)] {
                    for lane in 0..3 {
                        let change = sign * impulse[lane] / mass;
                        self.push(model, index, lane, change, kick);
                    }
                }
            }
        }
        self.grid.encounters = encounters;
    }

    /// Mass that an impulse on a node moves \[kg\]: that of the matrix which its velocity comes from.
    fn pushed_mass(&self, node: usize) -> f64 {
        let of_matrix = if self.integration.touching.is_empty() { None } else { self.matrix.lumped(node) };
        of_matrix.unwrap_or(self.grid.momentum[node][0])
    }

    /// Whether two nodes came closer before the kick. An impulse does work with the mean of the velocities before and after it: between nodes
    /// that part and are only pushed back by the kick it would add energy (two bars head-on: up to 47 %, in proportion to the step).
    fn approached(&self, a: usize, b: usize, normal: [f64; 3], kick: f64) -> bool {
        let before = |i: usize, k: usize| self.grid.momentum[i][1 + k] - kick * self.grid.force[i][1 + k];
        (0..3).map(|k| (before(a, k) - before(b, k)) * normal[k]).sum::<f64>() > 0.0
    }

    /// Changes a velocity. A held one stays, and its boundary takes the impulse.
    fn push(&mut self, model: &Model, index: usize, axis: usize, change: f64, kick: Option<f64>) {
        if change == 0.0 {
            return;
        }
        let held = self.grid.holder(index, axis);
        let lanes = &mut self.grid.momentum[index];
        match (held, kick) {
            (Some(boundary), Some(_)) => {
                self.impulse[boundary as usize][axis] -= lanes[0] * change;
                self.boundary_work -= lanes[0] * change * lanes[1 + axis];
            }
            (Some(_), None) => {}
            (None, _) => {
                lanes[1 + axis] += change;
                // PIC and APIC have taken their acceleration into the velocity already
                if let Some(kick) = kick.filter(|kick| *kick > 0.0 && model.flip_share > 0.0) {
                    self.grid.force[index][1 + axis] += change / kick;
                }
            }
        }
    }

    /// Unit vector from body a to body b at a node they share: down the volume of one and up that of the other.
    fn normal(&self, model: &Model, a: usize, b: usize) -> Option<[f64; 3]> {
        let dimension = model.dimension;
        let mut normal = [0.0; 3];
        for (index, sign) in [(a, -1.0), (b, 1.0)] {
            let (field, node) = self.grid.place(index);
            let density = model.bodies[field as usize].density;
            for axis in 0..dimension {
                let slot = 3 - dimension + axis;
                let functions = model.axes[axis].functions();
                let beside = |step: i32| {
                    let mut next = node;
                    // at an end of the grid the body may go on: its volume is taken as the node's own
                    next[slot] = (node[slot] + step).clamp(0, functions - 1);
                    let mass = self.grid.node(field, next).map_or(0.0, |n| self.grid.momentum[n][0]);
                    mass / density
                };
                normal[axis] += sign * (beside(1) - beside(-1)) * model.axes[axis].inverse_cell();
            }
        }
        let length = normal.iter().map(|n| n * n).sum::<f64>().sqrt();
        (length > 0.0).then(|| normal.map(|n| n / length))
    }
}

/// What b gets of a \[N s\]: as much as stops their approach along the normal, and against sliding at most `friction` times that.
fn impulse(a: &Lanes, b: &Lanes, normal: [f64; 3], friction: f64) -> [f64; 3] {
    let reduced = a[0] * b[0] / (a[0] + b[0]);
    let relative: [f64; 3] = std::array::from_fn(|k| a[1 + k] - b[1 + k]);
    let approach: f64 = (0..3).map(|k| relative[k] * normal[k]).sum();
    if approach <= 0.0 {
        return [0.0; 3];
    }
    let sliding: [f64; 3] = std::array::from_fn(|k| relative[k] - approach * normal[k]);
    let speed = sliding.iter().map(|v| v * v).sum::<f64>().sqrt();
    let share = if speed > 0.0 { (friction * approach / speed).min(1.0) } else { 0.0 };
    std::array::from_fn(|k| reduced * (approach * normal[k] + share * sliding[k]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn friction_is_coulombs() {
        let (a, b) = ([2.0, 1.0, 3.0, 0.0], [3.0, -1.0, 0.0, 0.0]);
        // reduced mass 1.2, approach 2, sliding 3
        let close = |x: [f64; 3], y: [f64; 3]| x.iter().zip(y).all(|(x, y)| (x - y).abs() < 1e-15);
        assert!(close(impulse(&a, &b, [1.0, 0.0, 0.0], 0.0), [2.4, 0.0, 0.0]));
        assert!(close(impulse(&a, &b, [1.0, 0.0, 0.0], 0.5), [2.4, 1.2, 0.0]), "slides");
        assert!(close(impulse(&a, &b, [1.0, 0.0, 0.0], 9.0), [2.4, 3.6, 0.0]), "sticks");
        assert!(close(impulse(&a, &b, [-1.0, 0.0, 0.0], 9.0), [0.0; 3]), "parts");
    }
}
