//! Numbers derived from the stress of a particle, and how wide a particle is drawn.

use crate::scene::Scene;

/// Von Mises stress \[Pa\] of a 3x3 stress in C-order.
pub fn von_mises(s: &[f64]) -> f64 {
    let normal = (s[0] - s[4]).powi(2) + (s[4] - s[8]).powi(2) + (s[8] - s[0]).powi(2);
    let shear = s[1] * s[1] + s[2] * s[2] + s[5] * s[5];
    (0.5 * normal + 3.0 * shear).sqrt()
}

/// Pressure \[Pa\] of a 3x3 stress in C-order, positive in compression.
pub fn pressure(s: &[f64]) -> f64 {
    -(s[0] + s[4] + s[8]) / 3.0
}

/// Von Mises stress \[Pa\] of every particle.
pub(super) fn all_von_mises(stress: &[f64]) -> Vec<f64> {
    stress.chunks_exact(9).map(von_mises).collect()
}

/// Distance of neighbouring particles along each axis at time 0 \[m\], body by body in the order of the scene.
pub(super) fn spacing(scene: &Scene) -> Vec<Vec<f64>> {
    let along = |body: &crate::scene::Body, axis| {
        let cell = scene.grid.cell.axis(axis).unwrap_or(1.0);
        cell / scene.particles_per_cell(body).axis(axis).unwrap_or(1).max(1) as f64
    };
    scene.body.values().map(|body| (0..scene.dimension).map(|axis| along(body, axis)).collect()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn uniaxial_and_shear() {
        let pull = [5.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        assert_eq!(von_mises(&pull), 5.0);
        let shear = [0.0, 2.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0];
        assert_eq!(von_mises(&shear), 12f64.sqrt());
    }
}
