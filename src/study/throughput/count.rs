//! Operations and bytes of a particle in a step, by formula: what the algorithm asks for, whatever the program does.

/// What a step does for a particle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Count {
    /// Dimensions of space, D.
    pub(super) dimension: u32,
    /// Shape functions that a particle meets along an axis, W.
    pub(super) width: u32,
    /// Whether it carries an affine matrix (APIC); else the increment of the velocity is interpolated too (FLIP).
    pub(super) affine: bool,
    /// Particles in a cell.
    pub(super) in_cell: u32,
}

impl Count {
    /// The common work: 3D, quadratic B-splines, APIC, 8 particles a cell, double precision.
    pub(super) const COMMON: Self = Self { dimension: 3, width: 3, affine: true, in_cell: 8 };

    /// Operations (an addition or a multiplication each; a fused one is two), in the separable form: sums over the W^D nodes are taken axis by
    /// axis, which is the least that is known.
    ///
    /// - particles to grid: at each of the W^d partial products after axis d: momentum of the node and its slope along d (3 D), the mass (1),
    ///   and D numbers for each axis to come; at the W^D nodes D + 1 additions;
    /// - grid to particles: the same backwards: at each of the W^d partial sums the value and its slope along d, and the slopes along later axes,
    ///   two operations for each of D components; FLIP sums the increment too;
    /// - 6 for each of the D W weights and slopes;
    /// - the particle: F <- (1 + dt grad v) F, neo-Hookean stress with 30 for the logarithm and what goes with it, position and velocity, and
    ///   the sum of affine momentum and stress.
    pub(super) fn flops(&self) -> f64 {
        let (d, w) = (f64::from(self.dimension), f64::from(self.width));
        let mut sum = w.powf(d) * (d + 1.0);
        for axis in 1..=self.dimension {
            let (nodes, later) = (w.powi(axis as i32), d - f64::from(axis));
            sum += nodes * (3.0 * d + 1.0 + later * d);
            sum += nodes * 2.0 * d * (2.0 + later + if self.affine { 0.0 } else { 1.0 });
        }
        let determinant = if self.dimension == 3 { 14.0 } else { 3.0 };
        let stress = d * (d + 1.0) / 2.0 * (2.0 * d + 1.0) + determinant + 30.0;
        sum + 6.0 * d * w + 2.0 * d.powi(3) + d + stress + 4.0 * d + 3.0 * d * d
    }

    /// Bytes between the memory and a core, if each number of the state goes in once and out once: position, deformation gradient, and the velocity
    /// of FLIP; mass and volume go in. Velocity and affine matrix of APIC are worked out from the grid and given to it in one pass: they need no
    /// memory but in the last step of a call. A node has four numbers, moved six times: cleared, in and out for the particles, in and out for the
    /// balance of momentum, in for the particles.
    pub(super) fn bytes(&self) -> f64 {
        let d = f64::from(self.dimension);
        let state = d + d * d + if self.affine { 0.0 } else { d };
        8.0 * (2.0 * state + 2.0 + 6.0 * 4.0 / f64::from(self.in_cell))
    }

    /// Operations over bytes \[flop/B\].
    pub(super) fn intensity(&self) -> f64 {
        self.flops() / self.bytes()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_common_work_is_what_is_counted_by_hand() {
        // 108 + (48 + 117 + 270) + (72 + 162 + 324) + 54 + 57 + (42 + 14 + 30) + 12 + 27
        assert_eq!(Count::COMMON.flops(), 1337.0);
        // 12 numbers in and out, mass and volume, 3 numbers for the share of a node
        assert_eq!(Count::COMMON.bytes(), 8.0 * (24.0 + 2.0 + 3.0));
        // FLIP: three more in and out
        assert_eq!(Count { affine: false, ..Count::COMMON }.bytes(), 280.0);
    }
}
