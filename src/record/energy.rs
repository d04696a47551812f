//! A sink without a file: how well a run kept its energy.

use super::{RecordError, Sink};
use crate::Simulation;
use crate::component::ComponentError;

/// Watches the energies at every row of the history.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct EnergyWatch {
    first: Option<f64>,
    last: f64,
    largest: f64,
}

impl EnergyWatch {
    /// Takes note of the energies at a time \[J\].
    pub fn see(&mut self, kinetic: f64, strain: f64, total: f64) {
        self.last = total;
        self.first.get_or_insert(total);
        self.largest = self.largest.max(kinetic + strain);
    }

    /// Change of the total energy since the start, relative to the largest kinetic plus strain energy seen. Zero where there
    /// was no energy at all.
    pub fn drift(&self) -> f64 {
        if self.largest > 0.0 { (self.last - self.first.unwrap_or(0.0)) / self.largest } else { 0.0 }
    }
}

impl Sink for EnergyWatch {
    fn begin(&mut self, _: &mut Simulation) -> Result<(), RecordError> {
        *self = Self::default();
        Ok(())
    }

    fn history(&mut self, sim: &mut Simulation, _: u64) -> Result<(), RecordError> {
        let mut scalar = |name| Ok::<f64, ComponentError>(sim.get(name)?.first().copied().unwrap_or(0.0));
        let [kinetic, strain, total] = [scalar("energy/kinetic")?, scalar("energy/strain")?, scalar("energy/total")?];
        self.see(kinetic, strain, total);
        Ok(())
    }
}
