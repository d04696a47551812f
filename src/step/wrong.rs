//! Ways that the papers warn of, kept so that the studies can show what they do. No scene can ask for them.

/// A way to get it wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Wrong {
    /// Mass and velocity go to the grid apart, and the momentum of a node is their product (Buzzi et al. 2008, eq. 39). Takes all particles
    /// for equally heavy.
    ProductMomentum,
    /// Held nodes get no acceleration, and their velocity is zero where the strain is taken of it, but their momentum still moves particles
    /// (Buzzi et al. 2008, figure 22).
    ImproperBoundary,
    /// A lumped mass matrix with negative entries is used all the same (Tielen 2016, section 5.2; Andersen 2007, appendix).
    NegativeMass,
}
