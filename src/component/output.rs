//! The values behind the variables.

use super::exact::Exact;
use super::external_loads;
use super::{Causality, ComponentError, Variable};
use crate::model::Model;
use crate::scene::nearest;
use crate::state::{State, Table};
use crate::step::load::{deformation, place_of};
use crate::step::measure::Measures;
use nalgebra::{Matrix3, Vector3};
use std::collections::HashMap;
use std::sync::Arc;

/// What a variable is made of.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Quantity {
    Position,
    Velocity,
    Displacement,
    Stress,
    Strain,
    DeformationGradient,
    Volume,
    Density,
    Mass,
    Body,
    Kinetic,
    StrainEnergy,
    External,
    Total,
    NodalKinetic,
    InterpolationError,
    AlgorithmicError,
    Linear,
    Angular,
    ProbePosition(usize),
    ProbeDisplacement(usize),
    ProbeVelocity(usize),
    ProbeStress(usize),
    Reaction(usize),
    Input(usize),
    DisplacementError,
    VelocityError,
    StressError,
}

impl Quantity {
    /// Whether it needs the grid at the time of the state.
    fn is_measured(self) -> bool {
        use Quantity::*;
        matches!(
            self,
            Velocity
                | Kinetic
                | StrainEnergy
                | Total
                | NodalKinetic
                | InterpolationError
                | AlgorithmicError
                | Linear
                | Angular
                | ProbeVelocity(_)
                | VelocityError
        )
    }
    /// Whether it needs more than the nodes and what never changes.
    fn is_of_particles(self) -> bool {
        use Quantity::*;
        !matches!(self, Mass | Body | External | Reaction(_) | Input(_))
    }
    /// Whether it is of a probe, and nodes that are remembered know it: better than its particle does.
    fn is_of_a_probe(self) -> bool {
        matches!(self, Self::ProbePosition(_) | Self::ProbeDisplacement(_) | Self::ProbeVelocity(_))
    }
}

struct Entry {
    variable: Variable,
    quantity: Quantity,
    /// Shared with whoever still looks at them: values that are being looked at are not written over, new ones are made.
    values: Arc<Vec<f64>>,
    fresh: bool,
}

/// The variables with their values, computed when asked for and kept until the next step.
pub(super) struct Outputs {
    entries: Vec<Entry>,
    index: HashMap<String, usize>,
    pub(super) measures: Option<Measures>,
    /// Measures of the probes alone, where that needs no others.
    pub(super) probes: Option<Measures>,
    /// Whether nodes are remembered.
    total: bool,
}

impl Outputs {
    pub(super) fn new(model: &Model, state: &State, exact: Option<&Exact>) -> Self {
        let mut outputs = Self { entries: Vec::new(), index: HashMap::new(), measures: None, probes: None, total: model.total };
        outputs.list(model, state.particles.len(), exact);
        outputs
    }

    /// The one list of names, units, shapes and meanings.
    fn list(&mut self, model: &Model, n: usize, exact: Option<&Exact>) {
        use Quantity::*;
        let d = model.dimension;
        let mut add = |name: &str, causality, unit, shape: &[usize], doc, quantity| {
            let variable = Variable { name: name.into(), causality, unit, shape: shape.to_vec(), doc };
            self.index.insert(name.into(), self.entries.len());
            self.entries.push(Entry { variable, quantity, values: Arc::default(), fresh: false });
        };
        for load in external_loads(model) {
            let l = &model.loads[load];
            let quantity = l.quantity();
            let (unit, doc) = match quantity {
                "body_force" => ("m/s2", "specific body force (an acceleration), held until set again"),
                "traction" => ("Pa", "dead traction: force an undeformed area, held until set again"),
                "pressure" => ("Pa", "follower pressure, positive when it pushes on the body, held until set again"),
                _ => ("N", "force on one particle, held until set again"),
            };
            add(&format!("load/{}/{quantity}", l.name), Causality::Input, unit, &[l.components(d)], doc, Input(load));
        }
        let out = Causality::Output;
        add("particle/position", out, "m", &[n, d], "position", Position);
        add("particle/velocity", out, "m/s", &[n, d], "velocity", Velocity);
        add("particle/displacement", out, "m", &[n, d], "position less position at time 0", Displacement);
        add("particle/stress", out, "Pa", &[n, 3, 3], "Cauchy stress, tension positive", Stress);
        add("particle/strain", out, "", &[n, 3, 3], "Green-Lagrange strain (F^T F - I) / 2", Strain);
        add("particle/deformation_gradient", out, "", &[n, 3, 3], "deformation gradient", DeformationGradient);
        add("particle/volume", out, "m3", &[n], "volume (area in dimension 2, length in dimension 1)", Volume);
        add("particle/density", out, "kg/m3", &[n], "density", Density);
        add("particle/mass", out, "kg", &[n], "mass (a metre of thickness in dimension 2, a square metre of section in dimension 1)", Mass);
        add("particle/body", out, "", &[n], "number of the body, in the order of the scene", Body);
        add("energy/kinetic", out, "J", &[], "kinetic energy of the particles", Kinetic);
        add("energy/strain", out, "J", &[], "stored elastic energy", StrainEnergy);
        add("energy/external", out, "J", &[], "work of loads and moving boundaries since time 0", External);
        add("energy/total", out, "J", &[], "kinetic plus stored energy less external work: constant where nothing dissipates", Total);
        add("energy/nodal_kinetic", out, "J", &[], "kinetic energy of the nodes", NodalKinetic);
        add(
            "energy/interpolation_error",
            out,
            "J",
            &[],
            "change of nodal less change of particle kinetic energy (Bardenhagen 2002)",
            InterpolationError,
        );
        add(
            "energy/algorithmic_error",
            out,
            "J",
            &[],
            "what else the energy lost (Bardenhagen 2002), external work taken off",
            AlgorithmicError,
        );
        add("momentum/linear", out, "kg m/s", &[d], "momentum", Linear);
        if d > 1 {
            add("momentum/angular", out, "kg m2/s", &[if d == 2 { 1 } else { 3 }], "moment of momentum about the origin", Angular);
        }
        for (i, probe) in model.probes.iter().enumerate() {
            let name = |quantity: &str| format!("probe/{}/{quantity}", probe.name);
            add(&name("position"), out, "m", &[d], "position of the material point", ProbePosition(i));
            add(&name("displacement"), out, "m", &[d], "displacement of the material point", ProbeDisplacement(i));
            add(&name("velocity"), out, "m/s", &[d], "velocity of the material point", ProbeVelocity(i));
            add(&name("stress"), out, "Pa", &[3, 3], "Cauchy stress of the nearest particle", ProbeStress(i));
        }
        for (i, boundary) in model.boundaries.iter().enumerate() {
            let doc = "mean force of the boundary on the bodies over the last call of step";
            add(&format!("boundary/{}/reaction", boundary.name), out, "N", &[d], doc, Reaction(i));
        }
        if let Some(exact) = exact {
            let kinds = [
                (
                    exact.has_displacement(),
                    "displacement",
                    "m",
                    "RMS and largest error of the displacement against [exact]",
                    DisplacementError,
                ),
                (exact.has_velocity(), "velocity", "m/s", "RMS and largest error of the velocity against [exact]", VelocityError),
                (exact.has_stress(), "stress", "Pa", "RMS and largest error of the stress components given in [exact]", StressError),
            ];
            for (known, name, unit, doc, quantity) in kinds {
                if known {
                    add(&format!("error/{name}"), out, unit, &[2], doc, quantity);
                }
            }
        }
    }

    pub(super) fn variables(&self) -> Vec<Variable> {
        self.entries.iter().map(|e| e.variable.clone()).collect()
    }

    pub(super) fn variable(&self, index: usize) -> &Variable {
        &self.entries[index].variable
    }

    pub(super) fn find(&self, name: &str) -> Result<usize, ComponentError> {
        self.index.get(name).copied().ok_or_else(|| {
            let names = self.entries.iter().map(|e| e.variable.name.as_str());
            ComponentError::UnknownVariable { name: name.into(), nearest: nearest(name, names).map(Into::into) }
        })
    }

    /// The load that an input sets, once name and values are found good.
    pub(super) fn input(&self, name: &str, values: &[f64]) -> Result<usize, ComponentError> {
        let entry = &self.entries[self.find(name)?];
        let Quantity::Input(load) = entry.quantity else { return Err(ComponentError::ReadOnly { name: name.into() }) };
        if values.len() != entry.variable.len() {
            return Err(ComponentError::WrongShape { name: name.into(), expected: entry.variable.len(), found: values.len() });
        }
        match values.iter().position(|v| !v.is_finite()) {
            Some(index) => Err(ComponentError::NotFinite { name: name.into(), index, value: values[index] }),
            None => Ok(load),
        }
    }

    /// Time has moved: values are to be computed anew.
    pub(super) fn outdate(&mut self) {
        (self.measures, self.probes) = (None, None);
        self.entries.iter_mut().for_each(|e| e.fresh = false);
    }

    /// Whether a variable is to be computed from the tables of the particles.
    pub(super) fn needs_particles(&self, index: usize) -> bool {
        let entry = &self.entries[index];
        !entry.fresh && entry.quantity.is_of_particles() && !self.is_of_nodes(index)
    }

    pub(super) fn needs_probes(&self, index: usize) -> bool {
        !self.entries[index].fresh && self.is_of_nodes(index) && self.measures.is_none() && self.probes.is_none()
    }

    pub(super) fn needs_measures(&self, index: usize) -> bool {
        let entry = &self.entries[index];
        !entry.fresh && entry.quantity.is_measured() && !self.is_of_nodes(index) && self.measures.is_none()
    }

    fn is_of_nodes(&self, index: usize) -> bool {
        self.total && self.entries[index].quantity.is_of_a_probe()
    }

    pub(super) fn value(
        &mut self,
        index: usize,
        model: &Model,
        state: &State,
        lookup: &[u32],
        initial: &Measures,
        exact: Option<&Exact>,
    ) -> &Arc<Vec<f64>> {
        let entry = &mut self.entries[index];
        if !entry.fresh {
            let source = Source { model, state, lookup, initial, measures: self.measures.as_ref().or(self.probes.as_ref()), exact };
            if Arc::get_mut(&mut entry.values).is_none() {
                entry.values = Arc::default();
            }
            let values = Arc::make_mut(&mut entry.values);
            values.resize(entry.variable.len(), 0.0);
            source.compute(entry.quantity, values);
            entry.fresh = true;
        }
        &entry.values
    }
}

/// Everything that values are computed from.
struct Source<'a> {
    model: &'a Model,
    state: &'a State,
    /// Place in memory by particle id; empty where the scene has no probe and no such load.
    lookup: &'a [u32],
    initial: &'a Measures,
    measures: Option<&'a Measures>,
    exact: Option<&'a Exact>,
}

impl Source<'_> {
    fn compute(&self, quantity: Quantity, to: &mut [f64]) {
        use Quantity::*;
        let (model, state, particles) = (self.model, self.state, &self.state.particles);
        let none = Measures::default();
        let now = self.measures.unwrap_or(&none);
        let d = model.dimension;
        let potential = |m: &Measures, external: f64| m.strain - external;
        match quantity {
            Position => self.vectors(&particles.position, to),
            Velocity => self.vectors(&now.velocity, to),
            Displacement => self.each(to, |row, out| out.copy_from_slice(&self.displacement(row)[..d])),
            Stress => self.each(to, |row, out| put(&self.stress(row), out)),
            Strain => self.each(to, |row, out| {
                let f = deformation(d, state, row);
                put(&((f.transpose() * f - Matrix3::identity()) * 0.5), out);
            }),
            DeformationGradient => self.each(to, |row, out| put(&deformation(d, state, row), out)),
            Volume => self.each(to, |row, out| out[0] = particles.volume[row] * deformation(d, state, row).determinant()),
            Density => {
                self.each(to, |row, out| out[0] = particles.mass[row] / (particles.volume[row] * deformation(d, state, row).determinant()))
            }
            Mass => self.each(to, |row, out| out[0] = particles.mass[row]),
            Body => self.each(to, |row, out| out[0] = f64::from(particles.body[row])),
            Kinetic => to[0] = now.kinetic,
            StrainEnergy => to[0] = now.strain,
            External => to[0] = state.external_work,
            Total => to[0] = now.kinetic + potential(now, state.external_work),
            NodalKinetic => to[0] = now.nodal_kinetic,
            // Andersen 2007, eq. 32
            InterpolationError => to[0] = (now.nodal_kinetic - self.initial.nodal_kinetic) - (now.kinetic - self.initial.kinetic),
            AlgorithmicError => {
                to[0] = -(now.nodal_kinetic - self.initial.nodal_kinetic) - (potential(now, state.external_work) - self.initial.strain);
            }
            Linear => to.copy_from_slice(&now.linear[..d]),
            Angular => to.copy_from_slice(&now.angular[3 - to.len()..]),
            ProbePosition(i) => to.copy_from_slice(&self.probe(i).as_slice()[..d]),
            ProbeDisplacement(i) => {
                let anchor = &model.probes[i].anchor;
                let start = Vector3::from(model.reference(anchor.particle)) + Vector3::from(anchor.offset);
                to.copy_from_slice(&(self.probe(i) - start).as_slice()[..d]);
            }
            ProbeVelocity(i) => to.copy_from_slice(&now.probes[i][..d]),
            ProbeStress(i) => {
                let id = model.probes[i].anchor.particle;
                put(&self.stress(self.lookup[id as usize] as usize), to);
            }
            Reaction(i) => to.copy_from_slice(&state.reactions[i][..d]),
            Input(load) => to.copy_from_slice(&state.inputs[load]),
            DisplacementError => {
                self.error(to, |exact, row, x| exact.displacement(x, state.time).map(|e| (self.displacement(row)[..d].to_vec(), e)))
            }
            VelocityError => {
                self.error(to, |exact, row, x| exact.velocity(x, state.time).map(|e| (now.velocity.row::<3>(row)[..d].to_vec(), e)))
            }
            StressError => self.error(to, |exact, row, x| exact.stress(x, state.time, &self.stress(row))),
        }
    }

    /// Calls `f(place in memory, values)` for each particle, values in the order of the ids.
    fn each(&self, to: &mut [f64], f: impl Fn(usize, &mut [f64])) {
        let ids = &self.state.particles.id;
        let width = to.len() / ids.len();
        for (row, &id) in ids.iter().enumerate() {
            let start = id as usize * width;
            f(row, &mut to[start..start + width]);
        }
    }

    /// Copies a table of vectors.
    fn vectors(&self, from: &Table, to: &mut [f64]) {
        fn copy<const D: usize>(from: &Table, ids: &[u32], to: &mut [f64]) {
            let columns: [&[f64]; D] = std::array::from_fn(|a| &from.column(a)[..ids.len()]);
            let (to, _) = to.as_chunks_mut::<D>();
            for (row, &id) in ids.iter().enumerate() {
                to[id as usize] = columns.map(|column| column[row]);
            }
        }
        let ids = &self.state.particles.id;
        match self.model.dimension {
            1 => copy::<1>(from, ids, to),
            2 => copy::<2>(from, ids, to),
            _ => copy::<3>(from, ids, to),
        }
    }

    fn displacement(&self, row: usize) -> [f64; 3] {
        let start = self.model.reference(self.state.particles.id[row]);
        let now: [f64; 3] = self.state.particles.position.row(row);
        std::array::from_fn(|a| now[a] - start[a])
    }

    /// Cauchy stress.
    fn stress(&self, row: usize) -> Matrix3<f64> {
        let particles = &self.state.particles;
        let f = deformation(self.model.dimension, self.state, row);
        self.model.material(particles.body[row]).cauchy(&f, &particles.history.row(row))
    }

    fn probe(&self, i: usize) -> Vector3<f64> {
        if let Some(place) = self.measures.and_then(|m| m.places.get(i)) {
            return Vector3::from(*place);
        }
        place_of(self.model, self.state, self.lookup, &self.model.probes[i].anchor).0
    }

    /// RMS over particles and components, and largest error. NaN where nothing is known at this time.
    fn error(&self, to: &mut [f64], pair: impl Fn(&Exact, usize, [f64; 3]) -> Option<(Vec<f64>, Vec<f64>)>) {
        let (mut sum, mut count, mut largest) = (0.0, 0usize, 0.0f64);
        let Some(exact) = self.exact else { return };
        for (row, &id) in self.state.particles.id.iter().enumerate() {
            let Some((ours, theirs)) = pair(exact, row, self.model.reference(id)) else {
                to.fill(f64::NAN);
                return;
            };
            for (a, b) in ours.iter().zip(&theirs) {
                sum += (a - b) * (a - b);
                largest = largest.max((a - b).abs());
                count += 1;
            }
        }
        to[0] = (sum / count as f64).sqrt();
        to[1] = largest;
    }
}

/// Row by row, as numpy has it (nalgebra stores columns).
fn put(matrix: &Matrix3<f64>, to: &mut [f64]) {
    for r in 0..3 {
        for c in 0..3 {
            to[3 * r + c] = matrix[(r, c)];
        }
    }
}
