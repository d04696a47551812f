//! Stage 2: loads in the configuration and at the time of the state.

use super::Stepper;
use crate::component::StepError;
use crate::material::embed;
use crate::model::{Anchor, Model, Target};
use crate::state::State;
use crate::transfer::What;
use nalgebra::{Matrix3, Vector3};

/// A force on a point that hangs on a particle.
#[derive(Debug, Clone, Copy)]
pub(super) struct PointLoad {
    pub(super) anchor: Anchor,
    /// Where it acts now \[m\].
    pub(super) position: Vector3<f64>,
    /// \[N\]
    pub(super) force: Vector3<f64>,
}

impl Stepper {
    pub(super) fn load(&mut self, model: &Model, state: &State) -> Result<(), StepError> {
        self.gravity = [0.0; 3];
        self.surface.clear();
        if model.needs.body_force {
            self.body_force.resize(model.dimension, Vec::new());
            for column in &mut self.body_force {
                column.clear();
                column.resize(state.particles.len(), 0.0);
            }
        }
        for (load, input) in model.loads.iter().zip(&state.inputs) {
            let bad = || StepError::BadLoad { time: state.time, load: load.name.clone() };
            // of a body force that varies in space: its value at the origin, which is not used
            let value = load.signal.value([0.0; 3], state.time, input);
            if !load.signal.varies_in_space() && value.iter().any(|v| !v.is_finite()) {
                return Err(bad());
            }
            // a load that is not there now costs nothing, however large its surface
            if !load.signal.varies_in_space() && value == [0.0; 3] {
                continue;
            }
            match &load.target {
                Target::Gravity => {
                    for a in 0..3 {
                        self.gravity[a] += value[a];
                    }
                }
                Target::BodyForce(members) => {
                    let of =
                        |id| if load.signal.varies_in_space() { load.signal.value(model.reference(id), state.time, input) } else { value };
                    self.body_force(members, of).ok_or_else(bad)?;
                }
                Target::Traction(points) | Target::Pressure(points) => {
                    for point in points {
                        let value = if load.signal.varies_in_space() {
                            load.signal.value(point.anchor.place(model), state.time, input)
                        } else {
                            value
                        };
                        if value.iter().any(|v| !v.is_finite()) {
                            return Err(bad());
                        }
                        let area = Vector3::from(point.area);
                        if matches!(load.target, Target::Pressure(_)) {
                            // Nanson: n da = J F^-T N dA; the cofactor of F is J F^-T
                            self.hang(model, state, point.anchor, |f| cofactor(f) * area * -value[0]);
                        } else {
                            self.hang(model, state, point.anchor, |_| Vector3::from(value) * area.norm());
                        }
                    }
                }
                Target::PointForce(anchor) => {
                    let force = Vector3::from(value);
                    self.hang(model, state, *anchor, |_| force);
                }
            }
        }
        Ok(())
    }

    /// Adds a body force on some particles, `of` their ids; `None` where it is not finite.
    fn body_force(&mut self, members: &[u32], of: impl Fn(u32) -> [f64; 3]) -> Option<()> {
        for &id in members {
            let place = self.lookup[id as usize] as usize;
            for (column, v) in self.body_force.iter_mut().zip(of(id)) {
                column[place] += v.is_finite().then_some(v)?;
            }
        }
        Some(())
    }

    /// Hangs a force on a point: `force` of the deformation gradient there.
    fn hang(&mut self, model: &Model, state: &State, anchor: Anchor, force: impl FnOnce(&Matrix3<f64>) -> Vector3<f64>) {
        let (position, f) = place_of(model, state, &self.lookup, &anchor);
        self.surface.push(PointLoad { anchor, position, force: force(&f) });
    }

    /// Adds the forces of surface and point loads to the nodes, or what they give in a kick. The sum of the forces and of their moments is
    /// exact.
    pub(super) fn add_surface_forces(&mut self, model: &Model, state: &State, what: What) {
        let (to, share) = match what {
            What::Kicked(kick) => (&mut self.grid.momentum, kick),
            _ => (&mut self.grid.force, 1.0),
        };
        let mut to = std::mem::take(to);
        for load in &self.surface {
            let host = self.lookup[load.anchor.particle as usize] as usize;
            let x: [f64; 3] = state.particles.position.row(host);
            let arm = load.position - Vector3::from(x);
            let half = model.half_lengths(&state.particles, host);
            self.kernels.point_weights(&model.axes, [x, half, arm.into()], &mut self.rows);
            let bin = state.bin_of(host);
            for (node, weight) in self.rows.nodes.iter().zip(&self.rows.weights) {
                let node = self.grid.node_of_bin(bin, &state.bins[bin], *node);
                for a in 0..model.dimension {
                    to[node][1 + a] += share * weight * load.force[a];
                }
            }
        }
        match what {
            What::Kicked(_) => self.grid.momentum = to,
            _ => self.grid.force = to,
        }
    }

    /// Adds the work that boundaries and surface loads did over the step.
    pub(super) fn close_work(&mut self, model: &Model, state: &mut State) {
        if !model.needs.work {
            return;
        }
        state.external_work += std::mem::take(&mut self.boundary_work);
        for load in &self.surface {
            let (now, _) = place_of(model, state, &self.lookup, &load.anchor);
            state.external_work += load.force.dot(&(now - load.position));
        }
    }
}

/// Position of an anchored point, and the deformation gradient of its particle.
pub(crate) fn place_of(model: &Model, state: &State, lookup: &[u32], anchor: &Anchor) -> (Vector3<f64>, Matrix3<f64>) {
    let host = lookup[anchor.particle as usize] as usize;
    let f = deformation(model.dimension, state, host);
    let position = Vector3::from(state.particles.position.row::<3>(host)) + f * Vector3::from(anchor.offset);
    (position, f)
}

/// Deformation gradient in 3x3 of the particle at a place in memory.
pub(crate) fn deformation(dimension: usize, state: &State, row: usize) -> Matrix3<f64> {
    let lateral = if state.particles.lateral.width() > 0 { state.particles.lateral.column(0)[row] } else { 1.0 };
    let f: [f64; 9] = state.particles.deformation.row(row);
    match dimension {
        1 => embed(&[[f[0]]], lateral),
        2 => embed(&[[f[0], f[1]], [f[2], f[3]]], lateral),
        _ => embed(&[[f[0], f[1], f[2]], [f[3], f[4], f[5]], [f[6], f[7], f[8]]], lateral),
    }
}

/// J F^-T.
pub(crate) fn cofactor(f: &Matrix3<f64>) -> Matrix3<f64> {
    let column = |c: usize| f.column((c + 1) % 3).cross(&f.column((c + 2) % 3));
    Matrix3::from_columns(&[column(0), column(1), column(2)])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cofactor_is_j_times_inverse_transpose() {
        let f = Matrix3::new(1.2, 0.3, -0.1, 0.05, 0.9, 0.2, 0.1, -0.15, 1.1);
        let exact = f.try_inverse().unwrap().transpose() * f.determinant();
        assert!((cofactor(&f) - exact).norm() < 1e-15);
    }
}
