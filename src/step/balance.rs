//! Stage 4: balance of momentum on the nodes, with lumped mass, and the boundaries.

use super::Stepper;
use crate::model::Model;

impl Stepper {
    /// Turns momentum into velocity and force into acceleration, then kicks. Boundaries hold momentum and rate of momentum (Buzzi et
    /// al. 2008, section 5.5): the velocity on the way in, and its change.
    pub(super) fn balance(&mut self, model: &Model, time: f64, kick: f64, dt: f64) {
        self.hold(model, time, kick, dt);
        for (momentum, force) in self.grid.momentum.iter_mut().zip(&mut self.grid.force) {
            let mass = momentum[0];
            if mass <= 0.0 {
                // nothing is here; a force can only come from slopes of functions whose value is zero
                *force = [0.0; 4];
                continue;
            }
            let inverse = 1.0 / mass;
            // A nearly empty node of linear functions would be thrown out by its force, for its slopes are not small like its mass. Its
            // acceleration still reaches the particles, so that momentum is conserved, but not the velocity gradient.
            let light = mass < model.light;
            for a in 0..model.dimension {
                let pushed = if light { 0.0 } else { force[1 + a] * inverse };
                momentum[1 + a] = momentum[1 + a] * inverse + kick * (pushed + self.gravity[a]);
                force[1 + a] = force[1 + a] * inverse + self.gravity[a];
            }
        }
        // exactly, and for nearly empty nodes too
        self.hold_velocity(model, time + 0.5 * dt);
    }

    /// PIC and APIC take the nodal velocity: all they still lack is the acceleration by force of nearly empty nodes.
    pub(super) fn leave_to_light_nodes(&mut self, model: &Model) {
        if model.flip_share > 0.0 || model.light == 0.0 {
            return;
        }
        for (momentum, force) in self.grid.momentum.iter().zip(&mut self.grid.force) {
            let light = momentum[0] > 0.0 && momentum[0] < model.light;
            for a in 0..model.dimension {
                force[1 + a] = if light { force[1 + a] - self.gravity[a] } else { 0.0 };
            }
        }
        for c in &self.grid.constraints {
            self.grid.force[c.node as usize][1 + c.axis as usize] = 0.0;
        }
    }

    /// Puts momentum and force of held nodes to what gives the prescribed motion, and notes the reaction: what the particles gain
    /// beyond the forces that act on the node.
    fn hold(&mut self, model: &Model, time: f64, kick: f64, dt: f64) {
        // velocities are half a step before and after the time of the state; the last step was 2 kick - dt long
        let (before, after) = (time - (kick - 0.5 * dt), time + 0.5 * dt);
        for c in &self.grid.constraints {
            let (momentum, force) = (&mut self.grid.momentum[c.node as usize], &mut self.grid.force[c.node as usize]);
            let (mass, lane, axis) = (momentum[0], 1 + c.axis as usize, c.axis as usize);
            let boundary = &model.boundaries[c.boundary as usize];
            let (Some(old), Some(new)) = (boundary.velocity(axis, before), boundary.velocity(axis, after)) else { continue };
            if mass <= 0.0 {
                continue;
            }
            let acceleration = if kick > 0.0 { (new - old) / kick } else { 0.0 };
            let weight = mass * self.gravity[axis];
            let flip = mass * acceleration - force[lane] - weight;
            let pic = if kick > 0.0 { (mass * new - momentum[lane]) / kick - force[lane] - weight } else { flip };
            let reaction = model.flip_share * flip + (1.0 - model.flip_share) * pic;
            self.impulse[c.boundary as usize][axis] += reaction * kick;
            self.boundary_work += reaction * new * dt;
            momentum[lane] = mass * old;
            force[lane] = mass * acceleration - weight;
        }
    }

    /// Puts the velocity of held nodes to what is prescribed at `time`.
    pub(super) fn hold_velocity(&mut self, model: &Model, time: f64) {
        for c in &self.grid.constraints {
            let lanes = &mut self.grid.momentum[c.node as usize];
            if lanes[0] > 0.0
                && let Some(velocity) = model.boundaries[c.boundary as usize].velocity(c.axis as usize, time)
            {
                lanes[1 + c.axis as usize] = velocity;
            }
        }
    }
}
