//! Stage 4: balance of momentum on the nodes, and the boundaries.

use super::mass::Held;
use super::{Stepper, Wrong, worth_sharing};
use crate::component::StepError;
use crate::grid::{Constraint, Grid, Lanes};
use crate::model::{Boundary, MassRule, Masses, Model};
use crate::state::State;
use crate::transfer::What;
use rayon::prelude::*;

/// Share of the largest nodal mass up to which a negative one is round-off.
const ROUND_OFF: f64 = 1e-12;

/// Nodes that a thread works on at once.
const NODES_A_TASK: usize = 4096;

/// A field of the grid that is solved for.
#[derive(Debug, Clone, Copy)]
pub(super) enum Field {
    Momentum,
    Force,
}

impl Field {
    fn of(self, grid: &mut Grid) -> &mut [Lanes] {
        match self {
            Self::Momentum => &mut grid.momentum,
            Self::Force => &mut grid.force,
        }
    }
}

impl Stepper {
    /// Turns momentum into velocity and force into acceleration, then kicks. Boundaries hold momentum and rate of momentum (Buzzi et
    /// al. 2008, section 5.5): the velocity on the way in, and its change. The velocity is that of the projection only where it is
    /// `wanted`; a FLIP kick needs the acceleration alone.
    pub(super) fn balance(&mut self, model: &Model, state: &mut State, sums: What, dt: f64, wanted: bool) -> Result<(), StepError> {
        self.check_masses(model, state.time)?;
        let kick = 0.5 * (state.last_step + dt);
        if matches!(sums, What::Kicked(_)) {
            self.balance_kicked(model, worth_sharing(state), state.time, kick, dt);
        } else if model.balance.is_lumped() && (model.projection.is_lumped() || !wanted) {
            self.balance_lumped(model, state.time, kick, dt);
        } else {
            self.balance_with_matrix(model, state, kick, dt, wanted)?;
        }
        // exactly, and for nearly empty nodes too
        if self.wrong != Some(Wrong::ImproperBoundary) {
            self.hold_velocity(model, state.time + 0.5 * dt);
        }
        Ok(())
    }

    /// Where the sums are those of momenta after the kick. Nobody asks for accelerations then.
    fn balance_kicked(&mut self, model: &Model, shared: bool, time: f64, kick: f64, dt: f64) {
        let (before, after) = around(time, kick, dt);
        for c in &self.grid.constraints {
            let momentum = &mut self.grid.momentum[c.node as usize];
            let (mass, lane, axis) = (momentum[0], 1 + c.axis as usize, c.axis as usize);
            let boundary = &model.boundaries[c.boundary as usize];
            let (Some(_), Some(new)) = (boundary.velocity(axis, before), boundary.velocity(axis, after)) else { continue };
            if is_empty(model, mass) {
                continue;
            }
            // what the particles gain beyond the forces on the node, as they take the whole nodal velocity (see `hold`)
            let held = mass * (new - kick * self.gravity[axis]);
            let impulse = held - momentum[lane];
            self.impulse[c.boundary as usize][axis] += impulse;
            self.boundary_work += impulse / kick * new * dt;
            momentum[lane] = held;
        }
        let change = self.gravity.map(|g| kick * g);
        let balance = |nodes: &mut [Lanes]| {
            for momentum in nodes {
                let mass = momentum[0];
                if !is_empty(model, mass) {
                    let inverse = 1.0 / mass;
                    *momentum =
                        [mass, momentum[1] * inverse + change[0], momentum[2] * inverse + change[1], momentum[3] * inverse + change[2]];
                }
            }
        };
        if shared {
            self.grid.momentum.par_chunks_mut(NODES_A_TASK).for_each(balance);
        } else {
            balance(&mut self.grid.momentum);
        }
    }

    fn balance_lumped(&mut self, model: &Model, time: f64, kick: f64, dt: f64) {
        self.hold(model, time, kick, dt);
        let [x, y, z] = self.gravity;
        for (momentum, force) in self.grid.momentum.iter_mut().zip(&mut self.grid.force) {
            let mass = momentum[0];
            if is_empty(model, mass) {
                // nothing is here; a force can only come from slopes of functions whose value is zero
                *force = [0.0; 4];
                continue;
            }
            let inverse = 1.0 / mass;
            let velocity = momentum.map(|p| p * inverse);
            *force = [force[0] * inverse, force[1] * inverse + x, force[2] * inverse + y, force[3] * inverse + z];
            // A nearly empty node of linear functions would be thrown out by its force, for its slopes are not small like its mass. Its
            // acceleration still reaches the particles, so that momentum is conserved, but not the velocity gradient.
            let [_, a, b, c] = if mass.abs() < model.light { [0.0, x, y, z] } else { *force };
            *momentum = [mass, velocity[1] + kick * a, velocity[2] + kick * b, velocity[3] + kick * c];
        }
    }

    /// The same with mass matrices that are not diagonal. Held degrees of freedom keep their values within the solution.
    fn balance_with_matrix(&mut self, model: &Model, state: &mut State, kick: f64, dt: f64, wanted: bool) -> Result<(), StepError> {
        let time = state.time;
        self.assemble(model, state)?;
        let (before, after) = around(time, kick, dt);
        let old = self.held(model, |boundary, axis| boundary.velocity(axis, before));
        // gravity accelerates all alike: it is left out here and added to the solution
        let change = self.held(model, |boundary, axis| {
            let rise = boundary.velocity(axis, after)? - boundary.velocity(axis, before)?;
            Some(if kick > 0.0 { rise / kick } else { 0.0 } - self.gravity[axis])
        });
        let mut right = std::mem::take(&mut self.right);

        (*self.grid.momentum).clone_into(&mut right);
        let velocity = |boundary: usize, axis: usize, at: f64| model.boundaries[boundary].velocity(axis, at).unwrap_or(0.0);
        if !model.walls.is_empty() {
            let wanted = self.wall_values(model, |boundary, axis, _| velocity(boundary, axis, before));
            self.matrix.add_walls(&wanted, &mut right);
        }
        let rule = if wanted { model.projection } else { MassRule::Lumped };
        self.solve(rule, time, &old, &right, Field::Momentum, model)?;
        // PIC takes the whole nodal velocity: what the projection was held to counts too
        let gained = if model.flip_share < 1.0 { self.gained(rule, &old, &right, Field::Momentum) } else { vec![0.0; old.len()] };
        (*self.grid.force).clone_into(&mut right);
        let drags = self.wall_values(model, |boundary, axis, now| {
            let rise = velocity(boundary, axis, after) - now;
            (if kick > 0.0 { rise / kick } else { 0.0 }) - self.gravity[axis]
        });
        if !drags.is_empty() {
            self.matrix.add_walls(&drags, &mut right);
        }
        self.solve(model.balance, time, &change, &right, Field::Force, model)?;
        if !drags.is_empty() {
            self.grid.spread_tied(true);
            let pulls = self.matrix.wall_impulses(&drags, &self.grid.force);
            self.count_walls(model, &pulls, kick, dt, after);
        }
        let pushed = self.gained(model.balance, &change, &right, Field::Force);
        for (k, h) in change.iter().enumerate() {
            let flip = pushed[k];
            let pic = if kick > 0.0 { gained[k] / kick } else { 0.0 };
            let reaction = flip + (1.0 - model.flip_share) * pic;
            let c = &self.grid.constraints[k];
            self.impulse[c.boundary as usize][h.lane - 1] += reaction * kick;
            self.boundary_work += reaction * model.boundaries[c.boundary as usize].velocity(h.lane - 1, after).unwrap_or(0.0) * dt;
        }
        self.right = right;
        for (velocity, acceleration) in self.grid.momentum.iter_mut().zip(&mut self.grid.force) {
            if is_empty(model, velocity[0]) {
                *acceleration = Lanes::default();
                continue;
            }
            for a in 0..model.dimension {
                acceleration[1 + a] += self.gravity[a];
                velocity[1 + a] += kick * acceleration[1 + a];
            }
        }
        Ok(())
    }

    /// Held degrees of freedom with the values that `value` gives them, by boundary and axis.
    pub(super) fn held(&self, model: &Model, value: impl Fn(&Boundary, usize) -> Option<f64>) -> Vec<Held> {
        let of = |c: &Constraint| {
            let (boundary, axis) = (&model.boundaries[c.boundary as usize], c.axis as usize);
            Some(Held { node: c.node as usize, lane: 1 + axis, value: value(boundary, axis)? })
        };
        self.grid.constraints.iter().filter_map(of).collect()
    }

    /// What held degrees of freedom have got beyond the right side of a solution.
    fn gained(&mut self, rule: MassRule, held: &[Held], right: &[Lanes], field: Field) -> Vec<f64> {
        self.matrix_times(rule, field, true);
        let mut gained: Vec<f64> = held.iter().map(|h| self.product[h.node][h.lane] - right[h.node][h.lane]).collect();
        if matches!(rule, MassRule::Series(_)) {
            // a series that is cut short leaves a part at the free nodes too, which the particles get all the same: shared by mass
            for lane in 1..4 {
                let mass = |h: &Held| if h.lane == lane { self.grid.momentum[h.node][0] } else { 0.0 };
                let all: f64 = held.iter().map(mass).sum();
                let whole: f64 = self.product.iter().zip(right).map(|(m, r)| m[lane] - r[lane]).sum();
                let counted: f64 = held.iter().zip(gained.iter()).map(|(h, g)| if h.lane == lane { *g } else { 0.0 }).sum();
                if all > 0.0 {
                    gained.iter_mut().zip(held).for_each(|(g, h)| *g += (whole - counted) * mass(h) / all);
                }
            }
        }
        gained
    }

    /// Solves for a field of the grid in place.
    pub(super) fn solve(
        &mut self,
        rule: MassRule,
        time: f64,
        held: &[Held],
        right: &[Lanes],
        field: Field,
        model: &Model,
    ) -> Result<(), StepError> {
        if rule.is_lumped() {
            for node in 0..right.len() {
                let mass = self.grid.momentum[node][0];
                for lane in 1..4 {
                    field.of(&mut self.grid)[node][lane] = if is_empty(model, mass) { 0.0 } else { right[node][lane] / mass };
                }
            }
            for h in held {
                field.of(&mut self.grid)[h.node][h.lane] = h.value;
            }
            return Ok(());
        }
        let found = self.matrix.solve(rule, held, right, field.of(&mut self.grid));
        self.iterations += found.map_err(|e| StepError::NoConvergence { time, iterations: e.iterations, residual: e.residual })? as u64;
        Ok(())
    }

    /// `product` = M times a field of the grid, with what walls add to M or without.
    fn matrix_times(&mut self, rule: MassRule, field: Field, with_walls: bool) {
        self.product.clear();
        if rule.is_lumped() {
            let masses = self.grid.momentum.iter().map(|lanes| lanes[0]);
            let values = match field {
                Field::Momentum => &self.grid.momentum,
                Field::Force => &self.grid.force,
            };
            self.product.extend(values.iter().zip(masses).map(|(v, m)| v.map(|v| m * v)));
        } else {
            self.product.extend_from_slice(self.matrix.times(field.of(&mut self.grid), with_walls));
        }
    }

    /// Kinetic energy of the nodes \[J\] (Andersen 2007, eqs 28 and 29).
    pub(super) fn nodal_kinetic_energy(&mut self, model: &Model) -> f64 {
        self.matrix_times(model.projection, Field::Momentum, false);
        let dot = |(v, m): (&Lanes, &Lanes)| (1..4).map(|l| v[l] * m[l]).sum::<f64>();
        0.5 * self.grid.momentum.iter().zip(&self.product).map(dot).sum::<f64>()
    }

    /// With Lagrange elements the method breaks down where a nodal mass turns negative (Andersen 2007, appendix).
    pub(super) fn check_masses(&self, model: &Model, time: f64) -> Result<(), StepError> {
        if model.masses != Masses::MustBePositive {
            return Ok(());
        }
        let largest = self.grid.momentum.iter().map(|lanes| lanes[0]).fold(0.0, f64::max);
        let Some(index) = self.grid.momentum.iter().position(|lanes| lanes[0] < -ROUND_OFF * largest) else { return Ok(()) };
        let node = self.grid.place(index).1;
        let d = model.dimension;
        let position = (0..d).map(|a| model.axes[a].node_position(node[3 - d + a])).collect();
        Err(StepError::NegativeMass { time, position, mass: self.grid.momentum[index][0] })
    }

    /// PIC and APIC take the nodal velocity: all they still lack is the acceleration by force of nearly empty nodes.
    pub(super) fn leave_to_light_nodes(&mut self, model: &Model) {
        if model.flip_share > 0.0 || model.light == 0.0 {
            return;
        }
        for (momentum, force) in self.grid.momentum.iter().zip(&mut self.grid.force) {
            let light = !is_empty(model, momentum[0]) && momentum[0].abs() < model.light;
            for a in 0..model.dimension {
                force[1 + a] = if light { force[1 + a] - self.gravity[a] } else { 0.0 };
            }
        }
        for c in &self.grid.constraints {
            self.grid.force[c.node as usize][1 + c.axis as usize] = 0.0;
        }
    }

    /// ASFLIP: marks held nodes in the lane of their acceleration that is no axis, for particles that see one to stay with the grid: their
    /// own velocity would carry them through the boundary.
    pub(super) fn mark_held_nodes(&mut self, model: &Model) {
        if model.separation > 0.0 {
            for c in &self.grid.constraints {
                self.grid.force[c.node as usize][0] = 1.0;
            }
        }
    }

    /// Puts momentum and force of held nodes to what gives the prescribed motion, and notes the reaction: what the particles gain
    /// beyond the forces that act on the node.
    fn hold(&mut self, model: &Model, time: f64, kick: f64, dt: f64) {
        let (before, after) = around(time, kick, dt);
        for c in &self.grid.constraints {
            let (momentum, force) = (&mut self.grid.momentum[c.node as usize], &mut self.grid.force[c.node as usize]);
            let (mass, lane, axis) = (momentum[0], 1 + c.axis as usize, c.axis as usize);
            let boundary = &model.boundaries[c.boundary as usize];
            let (Some(old), Some(new)) = (boundary.velocity(axis, before), boundary.velocity(axis, after)) else { continue };
            if is_empty(model, mass) {
                continue;
            }
            let acceleration = if kick > 0.0 { (new - old) / kick } else { 0.0 };
            let weight = mass * self.gravity[axis];
            let flip = mass * acceleration - force[lane] - weight;
            let pic = if kick > 0.0 { (mass * new - momentum[lane]) / kick - force[lane] - weight } else { flip };
            let reaction = model.flip_share * flip + (1.0 - model.flip_share) * pic;
            self.impulse[c.boundary as usize][axis] += reaction * kick;
            self.boundary_work += reaction * new * dt;
            if self.wrong != Some(Wrong::ImproperBoundary) {
                momentum[lane] = mass * old;
            }
            force[lane] = mass * acceleration - weight;
        }
    }

    /// Puts the velocity of held nodes to what is prescribed at `time`.
    pub(super) fn hold_velocity(&mut self, model: &Model, time: f64) {
        for c in &self.grid.constraints {
            let lanes = &mut self.grid.momentum[c.node as usize];
            if !is_empty(model, lanes[0])
                && let Some(velocity) = model.boundaries[c.boundary as usize].velocity(c.axis as usize, time)
            {
                lanes[1 + c.axis as usize] = velocity;
            }
        }
    }
}

/// Velocities are half a step before and after the time of the state; the last step was 2 kick - dt long.
fn around(time: f64, kick: f64, dt: f64) -> (f64, f64) {
    (time - (kick - 0.5 * dt), time + 0.5 * dt)
}

/// Whether there is nothing at a node.
pub(super) fn is_empty(model: &Model, mass: f64) -> bool {
    if model.masses == Masses::Signed { mass == 0.0 } else { mass <= 0.0 }
}
