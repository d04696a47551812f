//! `~/state`: what the simulation does, as a message.

use crate::interfaces::matpoint::{ComponentState, Probe, Reaction};
use crate::interfaces::standard::{Header, Point, Vector3};
use crate::loads::Loads;
use matpoint::Simulation;
use matpoint::component::{ComponentError, Variable};

/// Names of what a state message lists, found once.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Watched {
    probes: Vec<String>,
    boundaries: Vec<String>,
}

impl Watched {
    /// The probes and boundaries among the variables.
    pub fn new(variables: &[Variable]) -> Self {
        let named = |before: &str, after: &str| {
            let inner = |v: &Variable| Some(v.name.strip_prefix(before)?.strip_suffix(after)?.to_owned());
            variables.iter().filter_map(inner).collect()
        };
        Self { probes: named("probe/", "/position"), boundaries: named("boundary/", "/reaction") }
    }

    /// The state, but for what the loop counts.
    ///
    /// # Errors
    /// A state that cannot be measured.
    pub fn state(&self, sim: &mut Simulation, loads: &Loads, header: Header) -> Result<ComponentState, ComponentError> {
        let mut probes = Vec::with_capacity(self.probes.len());
        for name in &self.probes {
            let mut get = |quantity: &str| sim.get(&format!("probe/{name}/{quantity}")).map(<[f64]>::to_vec);
            let stress = get("stress")?;
            probes.push(Probe {
                name: name.clone(),
                position: Point::from_slice(&get("position")?),
                displacement: Vector3::from_slice(&get("displacement")?),
                velocity: Vector3::from_slice(&get("velocity")?),
                stress: std::array::from_fn(|i| stress[i]),
            });
        }
        let mut reactions = Vec::with_capacity(self.boundaries.len());
        for name in &self.boundaries {
            let force = Vector3::from_slice(sim.get(&format!("boundary/{name}/reaction"))?);
            reactions.push(Reaction { name: name.clone(), force });
        }
        let mut energy = |kind: &str| sim.get(&format!("energy/{kind}")).map(|v| v[0]);
        Ok(ComponentState {
            header,
            kinetic_energy: energy("kinetic")?,
            strain_energy: energy("strain")?,
            external_work: energy("external")?,
            total_energy: energy("total")?,
            momentum: Vector3::from_slice(sim.get("momentum/linear")?),
            probes,
            reactions,
            loads: loads.states(sim)?,
            ..Default::default()
        })
    }
}
