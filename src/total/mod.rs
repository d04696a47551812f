//! ONE STEP of the explicit total-Lagrangian method: each body on a grid of its own that deforms with it.
//!
//! Displacement and velocity live at the nodes; particles are quadrature points that carry stress and are shown to the outside. A step is
//! a composition of kicks, v += b dt a(u), and drifts, u += c dt v: velocity Verlet, or a scheme of fourth order. Both are symplectic, and
//! nothing is projected, so that energy has no drift.

mod dilatation;
mod force;
mod implicit;
mod limit;
mod load;
mod mass;
mod reference;
mod sparse_mass;
mod updated;

pub(crate) use updated::Updated;

use reference::Vectors;
use sparse_mass::SparseMass;

use crate::component::StepError;
use crate::material::point;
use crate::model::{Boundary, Model};
use crate::scene::Integrator;
use crate::state::{Nodes, State, Table};
use crate::step::measure::Measures;
use crate::implicit::Matrix;
use force::{Sweeps, Task, Trouble};
use load::{Action, Host};
use mass::BoxMass;
use nalgebra::Vector3;
use reference::Reference;

/// Kicks and drifts of a step, as shares of it: kick, drift, kick, drift, ..., kick.
struct Scheme {
    kicks: &'static [f64],
    drifts: &'static [f64],
}

const VERLET: Scheme = Scheme { kicks: &[0.5, 0.5], drifts: &[1.0] };

/// Blanes and Moan 2002, Practical symplectic partitioned Runge-Kutta and Runge-Kutta-Nystroem methods, table 3, SRKN6b of order 4.
const FOURTH_ORDER: Scheme = {
    const B: [f64; 3] = [0.082_984_406_417_405_2, 0.396_309_801_498_368, -0.039_056_304_922_348_6];
    const C: [f64; 2] = [0.245_298_957_184_271, 0.604_872_665_711_08];
    const MIDDLE_KICK: f64 = 1.0 - 2.0 * (B[0] + B[1] + B[2]);
    const MIDDLE_DRIFT: f64 = 0.5 - (C[0] + C[1]);
    Scheme { kicks: &[B[0], B[1], B[2], MIDDLE_KICK, B[2], B[1], B[0]], drifts: &[C[0], C[1], MIDDLE_DRIFT, MIDDLE_DRIFT, C[1], C[0]] }
};

impl Scheme {
    fn of(integrator: Integrator) -> &'static Self {
        if integrator == Integrator::Symplectic4 { &FOURTH_ORDER } else { &VERLET }
    }
}

/// How the masses of a body are inverted.
enum Mass {
    /// Of each node \[kg\].
    Lumped(Vec<f64>),
    Consistent(BoxMass),
    /// Of a body that is no box.
    Sparse(SparseMass),
}

impl Mass {
    /// `masses` are those of the particles of a grid \[kg\]; `filled` is the body that fills it, if one does.
    fn new(model: &Model, reference: &Reference, masses: &[f64], held: &[Held], filled: Option<&crate::model::Body>) -> Self {
        if model.balance.is_lumped() {
            let mut sums = vec![0.0; reference.len()];
            for (p, mass) in masses.iter().enumerate() {
                reference.each_slowly(&reference.particle(p), |node, weight, _| sums[node - reference.start] += mass * weight);
            }
            return Self::Lumped(sums);
        }
        let mut fixed: [Vec<bool>; 3] = std::array::from_fn(|_| vec![false; reference.len()]);
        held.iter().for_each(|h| fixed[h.axis][h.node - reference.start] = true);
        match filled {
            Some(body) => Self::Consistent(BoxMass::new(body.density, &body.axes, reference.counts, fixed)),
            None => Self::Sparse(SparseMass::new(reference, masses, &fixed, model.dimension)),
        }
    }

    /// Multiplies one component of a nodal field by the matrix, in place.
    fn times(&mut self, field: &mut [f64]) {
        match self {
            Self::Lumped(masses) => field.iter_mut().zip(masses.iter()).for_each(|(v, mass)| *v *= mass),
            Self::Consistent(mass) => mass.times(field),
            Self::Sparse(mass) => mass.times(field),
        }
    }

    /// The entry of two nodes \[kg\].
    fn entry(&self, i: usize, j: usize) -> f64 {
        match self {
            Self::Lumped(masses) => if i == j { masses[i] } else { 0.0 },
            Self::Consistent(mass) => mass.entry(i, j),
            Self::Sparse(mass) => mass.entry(i, j),
        }
    }
}

/// A grid with all that never changes.
struct Body {
    reference: Reference,
    mass: Mass,
}

/// Particles of one body that follow each other in memory.
struct Part {
    /// Its grid.
    body: usize,
    /// Its material: that of this body of the scene.
    material: usize,
    first: usize,
    last: usize,
    /// Particle in memory whose functions are the first of the grid.
    offset: usize,
}

/// A component of a node whose velocity is given.
struct Held {
    node: usize,
    axis: usize,
    boundary: usize,
}

/// Grids of the bodies and scratch memory: nothing in it is needed for a restart.
pub(crate) struct Total {
    bodies: Vec<Body>,
    parts: Vec<Part>,
    /// Whether the reference is the configuration at the start of a step, not that of time 0.
    updated: bool,
    held: Vec<Held>,
    /// One a load.
    actions: Vec<Action>,
    sweeps: Sweeps,
    scheme: &'static Scheme,
    /// Stiffness of the implicit schemes; its pattern never changes.
    matrix: Option<Matrix>,
    /// Iterations of Newton's method since the last call of `begin`.
    iterations: u64,
    /// Internal forces at the displacement of the state \[N\]; empty where they are not known.
    internal: Vectors,
    external: Vectors,
    acceleration: Vectors,
    column: Vec<f64>,
    product: Vec<f64>,
    /// Impulse of each boundary since the last call of `begin` \[N s\].
    impulse: Vec<[f64; 3]>,
    kicked: f64,
    /// Particles are never sorted: the place in memory of each is its id.
    lookup: Vec<u32>,
}

impl Total {
    pub(crate) fn new(model: &Model, state: &State) -> Self {
        let mut bodies: Vec<Body> = Vec::new();
        let (mut start, mut held) = (0, Vec::new());
        for body in &model.bodies {
            let places = body.particles.clone().map(|p| model.reference(p as u32));
            let reference = Reference::new(&body.axes, body.map.as_ref(), start, places);
            let own = hold(&reference, model);
            start += reference.len();
            let masses = &state.particles.mass[body.particles.clone()];
            let full: f64 = body.density * body.axes.iter().map(|axis| axis.cell_size() * f64::from(axis.cells())).product::<f64>();
            let fills = body.map.is_none() && (masses.iter().sum::<f64>() / full - 1.0).abs() < 1e-9;
            let mass = Mass::new(model, &reference, masses, &own, fills.then_some(body));
            held.extend(own);
            bodies.push(Body { reference, mass });
        }
        let part = |(i, body): (usize, &crate::model::Body)| Part {
            body: i,
            material: i,
            first: body.particles.start,
            last: body.particles.end,
            offset: body.particles.start,
        };
        let parts = model.bodies.iter().enumerate().map(part).collect();
        let lookup = (0..state.particles.len() as u32).collect();
        Self::assemble(model, state, bodies, parts, held, lookup, false)
    }

    fn assemble(
        model: &Model,
        state: &State,
        bodies: Vec<Body>,
        parts: Vec<Part>,
        held: Vec<Held>,
        lookup: Vec<u32>,
        updated: bool,
    ) -> Self {
        let references: Vec<&Reference> = bodies.iter().map(|body| &body.reference).collect();
        let nodes = references.iter().map(|reference| reference.len()).sum();
        let host = Host { model, state, bodies: &references, lookup: &lookup, updated };
        let actions = model.loads.iter().map(|load| Action::new(load, &host)).collect();
        Self {
            actions,
            held,
            bodies,
            parts,
            updated,
            sweeps: force::sweeps(model.dimension, model.axes[0].width(), model.mean_dilatation),
            scheme: Scheme::of(model.integrator),
            matrix: None,
            iterations: 0,
            internal: Vec::new(),
            external: Vec::new(),
            acceleration: vec![[0.0; 3]; nodes],
            column: Vec::new(),
            product: Vec::new(),
            impulse: Vec::new(),
            kicked: 0.0,
            lookup,
        }
    }

    /// Nodes at time 0: at rest, with the velocity of the scene, projected as the mass matrix has it.
    pub(crate) fn start(&mut self, model: &Model, state: &mut State) {
        let velocity = self.project(model, state, &state.particles.velocity);
        state.nodes = Nodes { displacement: vec![[0.0; 3]; velocity.len()], velocity, acceleration: Vec::new() };
        self.show(model, state);
    }

    /// A field of the particles, projected on the nodes as the mass matrix has it; held nodes get the velocity of their boundary.
    fn project(&mut self, model: &Model, state: &State, field: &Table) -> Vectors {
        let n = self.acceleration.len();
        let mut sum = vec![[0.0; 3]; n];
        for part in &self.parts {
            let reference = &self.bodies[part.body].reference;
            for p in part.first..part.last {
                let (value, mass): ([f64; 3], f64) = (field.row(p), state.particles.mass[p]);
                reference.each_slowly(&reference.particle(p - part.offset), |node, weight, _| {
                    for a in 0..3 {
                        sum[node][a] += mass * weight * value[a];
                    }
                });
            }
        }
        let mut projected = vec![[0.0; 3]; n];
        for held in &self.held {
            projected[held.node][held.axis] = model.boundaries[held.boundary].velocity(held.axis, state.time).unwrap_or(0.0);
        }
        self.solve(model, &sum, &mut projected);
        projected
    }

    /// Memory of nodes and tables \[bytes\].
    pub(crate) fn bytes(&self) -> usize {
        5 * std::mem::size_of::<[f64; 3]>() * self.acceleration.len()
    }

    pub(crate) fn lookup(&self) -> &[u32] {
        &self.lookup
    }

    /// Forgets what belongs to another state.
    pub(crate) fn forget(&mut self) {
        self.internal.clear();
    }

    /// Starts to add up boundary reactions.
    pub(crate) fn begin(&mut self, model: &Model) {
        self.impulse.clear();
        self.impulse.resize(model.boundaries.len(), [0.0; 3]);
        self.kicked = 0.0;
        self.iterations = 0;
    }

    /// Iterations of Newton's method since [`Self::begin`].
    pub(crate) fn iterations(&self) -> u64 {
        self.iterations
    }

    /// Mean force of each boundary on the bodies since [`Self::begin`] \[N\].
    pub(crate) fn mean_reactions(&self) -> impl Iterator<Item = [f64; 3]> {
        self.impulse.iter().map(|impulse| impulse.map(|i| i / self.kicked))
    }

    /// One step of length `dt` \[s\]. On an error the state is spoilt; the caller holds a copy.
    pub(crate) fn advance(&mut self, model: &Model, state: &mut State, dt: f64) -> Result<(), StepError> {
        if let Some(scheme) = model.implicit {
            return self.advance_implicitly(model, state, scheme, dt);
        }
        let Scheme { kicks, drifts } = self.scheme;
        // displacements and velocities are at different times between kicks and drifts
        let (start, mut at, mut velocity_at) = (state.time, 0.0, 0.0);
        for (k, share) in kicks.iter().enumerate() {
            let end = if k + 1 == kicks.len() { 1.0 } else { velocity_at + share };
            self.kick(model, state, start + at * dt, [start + velocity_at * dt, start + end * dt])?;
            velocity_at = end;
            if let Some(share) = drifts.get(k) {
                at += share;
                let nodes = &mut state.nodes;
                for (u, v) in nodes.displacement.iter_mut().zip(&nodes.velocity) {
                    for a in 0..3 {
                        u[a] += share * dt * v[a];
                    }
                }
                self.internal.clear();
            }
        }
        state.last_step = dt;
        state.time = start + dt;
        state.steps += 1;
        self.keep_pace(model, state);
        Ok(())
    }

    /// Accelerates the nodes by the forces at `time`, from one time to another.
    fn kick(&mut self, model: &Model, state: &mut State, time: f64, [from, to]: [f64; 2]) -> Result<(), StepError> {
        let h = to - from;
        self.forces(model, state, time)?;
        let total: Vectors = self.internal.iter().zip(&self.external).map(|(i, e)| std::array::from_fn(|a| i[a] + e[a])).collect();
        let mut acceleration = std::mem::take(&mut self.acceleration);
        acceleration.fill([0.0; 3]);
        for held in &self.held {
            let velocity = |t: f64| model.boundaries[held.boundary].velocity(held.axis, t).unwrap_or(0.0);
            acceleration[held.node][held.axis] = (velocity(to) - velocity(from)) / h;
        }
        self.solve(model, &total, &mut acceleration);
        let velocity = &mut state.nodes.velocity;
        // what a force does in a kick is the mean of the velocities before and after
        let path = |node: usize, a: usize, velocity: &Vectors| h * (velocity[node][a] + 0.5 * h * acceleration[node][a]);
        if model.needs.work {
            for (node, force) in self.external.iter().enumerate() {
                for a in 0..model.dimension {
                    state.external_work += force[a] * path(node, a, velocity);
                }
            }
        }
        if !self.held.is_empty() {
            let pulled = self.times(model, &acceleration);
            for held in &self.held {
                let reaction = pulled[held.node][held.axis] - total[held.node][held.axis];
                self.impulse[held.boundary][held.axis] += h * reaction;
                state.external_work += reaction * path(held.node, held.axis, velocity);
            }
        }
        for (v, a) in velocity.iter_mut().zip(&acceleration) {
            for k in 0..3 {
                v[k] += h * a[k];
            }
        }
        for held in &self.held {
            velocity[held.node][held.axis] = model.boundaries[held.boundary].velocity(held.axis, to).unwrap_or(0.0);
        }
        self.acceleration = acceleration;
        self.kicked += h;
        Ok(())
    }

    /// Internal forces at the displacement of the state, where they are not known, and external ones.
    fn forces(&mut self, model: &Model, state: &mut State, time: f64) -> Result<(), StepError> {
        let n = self.acceleration.len();
        if self.internal.is_empty() {
            self.update(model, state, time)?;
        }
        let mut external = std::mem::take(&mut self.external);
        external.clear();
        external.resize(n, [0.0; 3]);
        let loaded = self.load(model, state, time, &state.nodes.displacement, &mut external);
        self.external = external;
        loaded
    }

    /// Carries the particles along with the nodes, and sums the internal forces.
    fn update(&mut self, model: &Model, state: &mut State, time: f64) -> Result<(), StepError> {
        let mut internal = vec![[0.0; 3]; self.acceleration.len()];
        for part in &self.parts {
            let task = self.task(model, part, &state.nodes.displacement, false);
            if let Err(trouble) = (self.sweeps.advance)(&task, &mut state.particles, &mut internal) {
                return Err(self.explain(model, state, time, &trouble));
            }
        }
        self.internal = internal;
        Ok(())
    }

    fn task<'a>(&'a self, model: &'a Model, part: &Part, displacement: &'a [[f64; 3]], conserving: bool) -> Task<'a> {
        Task {
            reference: &self.bodies[part.body].reference,
            material: &model.bodies[part.material].material,
            embedding: model.embedding,
            first: part.first,
            last: part.last,
            offset: part.offset,
            displacement,
            updated: self.updated,
            conserving,
        }
    }

    /// Adds the loads at a time and displacement \[N\].
    fn load(&self, model: &Model, state: &State, time: f64, displacement: &[[f64; 3]], force: &mut Vectors) -> Result<(), StepError> {
        let references: Vec<&Reference> = self.bodies.iter().map(|body| &body.reference).collect();
        for ((action, load), input) in self.actions.iter().zip(&model.loads).zip(&state.inputs) {
            action.add(load, input, model, &references, time, displacement, force)?;
        }
        Ok(())
    }

    /// Adds this share of minus the derivative of the loads by the displacement; tells whether there is any.
    fn load_stiffness(
        &self,
        model: &Model,
        state: &State,
        time: f64,
        displacement: &[[f64; 3]],
        share: f64,
        matrix: &mut Matrix,
    ) -> Result<bool, StepError> {
        let references: Vec<&Reference> = self.bodies.iter().map(|body| &body.reference).collect();
        let mut any = false;
        for ((action, load), input) in self.actions.iter().zip(&model.loads).zip(&state.inputs) {
            any |= action.add_stiffness(load, input, model, &references, time, displacement, share, matrix);
        }
        Ok(any)
    }

    fn explain(&self, model: &Model, state: &State, time: f64, trouble: &Trouble) -> StepError {
        let particle = trouble.particle;
        let position = self.moved(model, state, particle)[..model.dimension].to_vec();
        match trouble.why {
            point::Trouble::NoThickness => StepError::NoThickness { time, particle, position },
            point::Trouble::Inverted(det) if det.is_finite() => StepError::Inverted { time, particle, position, det },
            point::Trouble::Inverted(_) => {
                StepError::NotFinite { time, particle, position: model.reference(particle as u32)[..model.dimension].to_vec() }
            }
        }
    }

    /// Position of a particle \[m\].
    fn moved(&self, model: &Model, state: &State, particle: usize) -> [f64; 3] {
        if self.updated {
            return state.particles.position.row(particle);
        }
        let Some(part) = self.parts.iter().find(|part| (part.first..part.last).contains(&particle)) else { return [f64::NAN; 3] };
        let reference = &self.bodies[part.body].reference;
        let mut place = model.reference(particle as u32);
        reference.each_slowly(&reference.particle(particle - part.offset), |node, weight, _| {
            for a in 0..3 {
                place[a] += weight * state.nodes.displacement[node][a];
            }
        });
        place
    }

    /// Solves M x = `right` for the free components; `x` comes with the values of those that are held.
    fn solve(&mut self, model: &Model, right: &Vectors, x: &mut Vectors) {
        for body in &mut self.bodies {
            let nodes = body.reference.start..body.reference.start + body.reference.len();
            for a in 0..model.dimension {
                match &mut body.mass {
                    Mass::Lumped(masses) => {
                        let held: Vec<f64> =
                            self.held.iter().filter(|h| h.axis == a && nodes.contains(&h.node)).map(|h| x[h.node][a]).collect();
                        for (node, mass) in nodes.clone().zip(masses.iter()) {
                            x[node][a] = if *mass > 0.0 { right[node][a] / mass } else { 0.0 };
                        }
                        for (h, value) in self.held.iter().filter(|h| h.axis == a && nodes.contains(&h.node)).zip(held) {
                            x[h.node][a] = value;
                        }
                    }
                    matrix => {
                        self.column.clear();
                        self.column.extend(nodes.clone().map(|node| x[node][a]));
                        let moves = self.column.iter().any(|v| *v != 0.0);
                        self.product.clone_from(&self.column);
                        if moves {
                            matrix.times(&mut self.product);
                        }
                        for (p, node) in self.product.iter_mut().zip(nodes.clone()) {
                            *p = right[node][a] - *p;
                        }
                        match matrix {
                            Mass::Consistent(mass) => mass.solve(a, &mut self.product),
                            Mass::Sparse(mass) => mass.solve(a, &mut self.product),
                            Mass::Lumped(_) => {}
                        }
                        for (k, node) in nodes.clone().enumerate() {
                            x[node][a] = self.product[k] + self.column[k];
                        }
                    }
                }
            }
        }
    }

    /// The mass matrix times a field.
    fn times(&mut self, model: &Model, x: &Vectors) -> Vectors {
        let mut y = vec![[0.0; 3]; x.len()];
        for body in &mut self.bodies {
            let nodes = body.reference.start..body.reference.start + body.reference.len();
            for a in 0..model.dimension {
                self.column.clear();
                self.column.extend(nodes.clone().map(|node| x[node][a]));
                body.mass.times(&mut self.column);
                nodes.clone().zip(&self.column).for_each(|(node, value)| y[node][a] = *value);
            }
        }
        y
    }

    /// How much of the stable step is left: stiffness seen from time 0.
    fn keep_pace(&mut self, model: &Model, state: &mut State) {
        if !matches!(model.pace, crate::model::Pace::Cfl(_)) {
            return;
        }
        let d = model.dimension;
        let mut pace = 1.0f64;
        for p in 0..state.particles.len() {
            let f = crate::step::load::deformation(d, state, p);
            let material = model.material(state.particles.body[p]);
            if matches!(material, crate::material::Material::Linear(_)) {
                continue;
            }
            // a wave along N at time 0 sees the modulus times |F^-T N|^2
            let inverse = f.try_inverse().unwrap_or_else(nalgebra::Matrix3::identity);
            let steep = inverse.fixed_view::<3, 3>(0, 0).norm_squared().min(1e12);
            let ratio = material.wave_modulus(&f) * (steep / 3.0).max(largest(&inverse)) / material.lame().wave_modulus();
            pace = pace.min(1.0 / ratio.sqrt());
        }
        state.pace = pace.clamp(f64::MIN_POSITIVE, 1.0);
    }

    /// Shows the particles as the nodes have moved them.
    pub(crate) fn show(&mut self, model: &Model, state: &mut State) {
        for part in &self.parts {
            let reference = &self.bodies[part.body].reference;
            for p in part.first..part.last {
                let mut place = model.reference(p as u32);
                let mut speed = [0.0; 3];
                reference.each_slowly(&reference.particle(p - part.offset), |node, weight, _| {
                    for a in 0..3 {
                        place[a] += weight * state.nodes.displacement[node][a];
                        speed[a] += weight * state.nodes.velocity[node][a];
                    }
                });
                state.particles.position.set_row(p, &place);
                state.particles.velocity.set_row(p, &speed);
            }
        }
    }

    /// Measures the state.
    pub(crate) fn measure(&mut self, model: &Model, state: &State) -> Measures {
        let mut measures = Measures { velocity: state.particles.velocity.clone(), ..Measures::default() };
        let momentum = self.times(model, &state.nodes.velocity);
        let mut angular = Vector3::zeros();
        for body in &self.bodies {
            for i in 0..body.reference.len() {
                let node = body.reference.start + i;
                let (v, p) = (&state.nodes.velocity[node], Vector3::from(momentum[node]));
                measures.kinetic += 0.5 * Vector3::from(*v).dot(&p);
                let place = Vector3::from(body.reference.place(i)) + Vector3::from(state.nodes.displacement[node]);
                angular += place.cross(&p);
                for a in 0..3 {
                    measures.linear[a] += p[a];
                }
            }
        }
        measures.angular = angular.into();
        measures.nodal_kinetic = measures.kinetic;
        let particles = &state.particles;
        for p in 0..particles.len() {
            let f = crate::step::load::deformation(model.dimension, state, p);
            measures.strain += particles.volume[p] * model.material(particles.body[p]).energy(&f, &particles.history.row(p));
        }
        for probe in &model.probes {
            let number = usize::from(particles.body[probe.anchor.particle as usize]);
            let reference = &self.bodies[number].reference;
            let host: [f64; 3] = model.reference(probe.anchor.particle);
            let start: [f64; 3] = std::array::from_fn(|a| host[a] + probe.anchor.offset[a]);
            let (mut place, mut speed) = (start, [0.0; 3]);
            reference.each_slowly(&reference.point(start), |node, weight, _| {
                for a in 0..3 {
                    place[a] += weight * state.nodes.displacement[node][a];
                    speed[a] += weight * state.nodes.velocity[node][a];
                }
            });
            measures.probes.push(speed);
            measures.places.push(place);
        }
        measures
    }
}

/// Largest diagonal entry of A A^T: the square of the longest row.
fn largest(a: &nalgebra::Matrix3<f64>) -> f64 {
    (0..3).map(|r| a.row(r).norm_squared()).fold(0.0, f64::max)
}

/// Components that boundaries hold; a later boundary overrides an earlier one.
fn hold(reference: &Reference, model: &Model) -> Vec<Held> {
    let mut held = Vec::new();
    for i in 0..reference.len() {
        let place = reference.place(i);
        for axis in 0..model.dimension {
            let holds = |b: &Boundary| b.holds_axis(axis) && b.holds_place(&model.axes, &place[..model.dimension]);
            if let Some(boundary) = model.boundaries.iter().rposition(holds) {
                held.push(Held { node: reference.start + i, axis, boundary });
            }
        }
    }
    held
}
