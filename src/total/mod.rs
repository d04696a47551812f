//! The total-Lagrangian method: each body on a grid of its own that deforms with it.
//!
//! Displacement and velocity live at the nodes; particles are quadrature points that carry stress and are shown to the outside.

mod dilatation;
mod explicit;
mod fast;
mod force;
mod implicit;
mod iterative;
mod limit;
mod load;
mod mass;
mod measure;
mod pace;
mod precondition;
mod reference;
mod rows;
#[cfg(test)]
mod slivers;
#[cfg(test)]
mod slivers_in_space;
mod surface;
#[cfg(test)]
mod tests;
mod ties;
mod updated;
mod wide;

pub(crate) use updated::Updated;

use crate::component::StepError;
use crate::implicit::Matrix;
use crate::material::point;
use crate::model::{Boundary, Fit, Model};
use crate::state::{Nodes, Shown, State, Table};
use explicit::Scheme;
use fast::Fast;
use force::{Sweeps, Task, Trouble};
use iterative::Precondition;
use load::{Action, Host};
use mass::Mass;
use reference::{Reference, Vectors};
use surface::Surface;
use wide::Instructions;

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
    /// Its grid.
    body: usize,
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
    /// Held faces of bodies that cut cells.
    surfaces: Vec<Surface>,
    /// One a load.
    actions: Vec<Action>,
    sweeps: Sweeps,
    scheme: &'static Scheme,
    /// Fast sums of explicit steps, where all bodies have them.
    fast: Option<Fast>,
    /// Stiffness of the implicit schemes; its pattern never changes.
    matrix: Option<Matrix>,
    /// What iterations start from.
    precondition: Option<Precondition>,
    /// Iterations of Newton's method since the last call of `begin`.
    iterations: u64,
    /// Forces out of balance over those in balance, by iteration of the last solve.
    residuals: Vec<f64>,
    /// Internal forces at the displacement of the state \[N\]; empty where they are not known.
    internal: Vectors,
    /// What boundaries do to the bodies at held faces there \[N\].
    pulls: Vectors,
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
        for (number, body) in model.bodies.iter().enumerate() {
            let places = body.particles.clone().map(|p| model.reference(p as u32));
            let mut reference = Reference::new(&body.axes, body.map.as_ref(), start, places);
            if let Some(cut) = body.fit.cut() {
                let edge = cut.points().iter().map(|point| point.position);
                reference = reference.cut(&state.particles.volume[body.particles.clone()], edge, extends(model));
            }
            let own = hold(&reference, model, number);
            start += reference.len();
            let masses = &state.particles.mass[body.particles.clone()];
            let full: f64 = body.density * body.axes.iter().map(|axis| axis.cell_size() * f64::from(axis.cells())).product::<f64>();
            let fills = matches!(body.fit, Fit::Whole) && body.map.is_none() && (masses.iter().sum::<f64>() / full - 1.0).abs() < 1e-9;
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
        let mut total = Self::assemble(model, state, bodies, parts, held, lookup, false);
        for (boundary, held) in model.boundaries.iter().enumerate() {
            if let Some((body, face)) = held.surface()
                && let Some(cut) = model.bodies[body].fit.cut()
            {
                total.surfaces.push(Surface::new(model, boundary, body, cut, face, &total.bodies[body].reference));
            }
        }
        let references: Vec<&Reference> = total.bodies.iter().map(|body| &body.reference).collect();
        let instructions = Instructions::known()[0];
        let sums = rows::all(model, &state.particles, &references, instructions);
        total.fast = sums.map(|sums| Fast::new(sums, &total.bodies, &total.held, model.dimension));
        total
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
            surfaces: Vec::new(),
            bodies,
            parts,
            updated,
            sweeps: force::sweeps(model.dimension, model.axes[0].width(), model.mean_dilatation),
            scheme: Scheme::of(model.integrator),
            fast: None,
            matrix: None,
            precondition: None,
            iterations: 0,
            residuals: Vec::new(),
            internal: Vec::new(),
            pulls: Vec::new(),
            external: Vec::new(),
            acceleration: vec![[0.0; 3]; nodes],
            column: Vec::new(),
            product: Vec::new(),
            impulse: Vec::new(),
            kicked: 0.0,
            lookup,
        }
    }

    /// Whether loops of a step are shared between threads.
    pub(crate) fn shares(&self, state: &State) -> bool {
        self.fast.is_some() && state.particles.len() >= rows::FEW && rayon::current_num_threads() > 1
    }

    /// Nodes at time 0: at rest, with the velocity of the scene, projected as the mass matrix has it.
    pub(crate) fn start(&mut self, model: &Model, state: &mut State) {
        let velocity = self.project(model, state, &state.particles.velocity);
        state.nodes = Nodes { displacement: vec![[0.0; 3]; velocity.len()], velocity, acceleration: Vec::new() };
        self.show(model, state);
        state.shown = if self.fast.is_some() { Shown::Now } else { Shown::Always };
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
        self.fold(&mut sum);
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

    /// Whether a boundary holds any node or face.
    pub(crate) fn is_held_by(&self, boundary: usize) -> bool {
        self.held.iter().any(|held| held.boundary == boundary) || self.surfaces.iter().any(|surface| surface.boundary == boundary)
    }

    /// Whether boundaries keep every body from drifting, and from turning: they hold two nodes, or a face, along each axis.
    pub(crate) fn is_supported(&self, dimension: usize) -> bool {
        self.bodies.iter().enumerate().all(|(number, body)| {
            let nodes = body.reference.start..body.reference.start + body.reference.len();
            let count = |axis: usize| self.held.iter().filter(|held| held.axis == axis && nodes.contains(&held.node)).count();
            let face = |axis: usize| self.surfaces.iter().any(|surface| surface.body == number && surface.holds_axis(axis));
            (0..dimension).all(|axis| face(axis) || count(axis) >= if dimension > 1 { 2 } else { 1 })
        })
    }

    /// How the grid of each body fits it, in words.
    pub(crate) fn grids(&self, model: &Model) -> String {
        let of = |(body, grid): (&crate::model::Body, &Body)| {
            let how = match (&body.fit, grid.reference.ties()) {
                (Fit::Around(why), _) => format!("that of the box around it, and its edge is known to a particle only: {why}"),
                (Fit::Cut(_), Some(ties)) => ties.describe(),
                (Fit::Cut(_) | Fit::Whole, _) => "fitted to its faces".into(),
            };
            if model.bodies.len() > 1 { format!("{}: {how}", body.name) } else { how }
        };
        model.bodies.iter().zip(&self.bodies).map(of).collect::<Vec<_>>().join("; ")
    }

    /// Forgets what belongs to another state.
    pub(crate) fn forget(&mut self) {
        self.internal.clear();
        self.fast.iter_mut().for_each(Fast::forget);
    }

    /// Starts to add up boundary reactions.
    pub(crate) fn begin(&mut self, model: &Model) {
        self.impulse.clear();
        self.impulse.resize(model.boundaries.len(), [0.0; 3]);
        self.kicked = 0.0;
        self.iterations = 0;
    }

    /// Functions at cut edges that found none to follow.
    pub(crate) fn alone(&self) -> usize {
        self.bodies.iter().filter_map(|body| Some(body.reference.ties()?.alone())).sum()
    }

    /// Iterations of Newton's method since [`Self::begin`].
    pub(crate) fn iterations(&self) -> u64 {
        self.iterations
    }

    /// Forces out of balance over those in balance, by iteration of the last solve.
    pub(crate) fn residuals(&self) -> &[f64] {
        &self.residuals
    }

    /// Mean force of each boundary on the bodies since [`Self::begin`] \[N\].
    pub(crate) fn mean_reactions(&self) -> impl Iterator<Item = [f64; 3]> {
        self.impulse.iter().map(|impulse| impulse.map(|i| i / self.kicked))
    }

    /// One step of length `dt` \[s\]. On an error the state is spoilt; the caller holds a copy.
    pub(crate) fn advance(&mut self, model: &Model, state: &mut State, dt: f64) -> Result<(), StepError> {
        match model.implicit {
            Some(scheme) => self.advance_implicitly(model, state, scheme, dt),
            None => self.advance_explicitly(model, state, dt),
        }
    }

    /// Internal forces at the displacement of the state, where they are not known, and external ones.
    fn forces(&mut self, model: &Model, state: &mut State, time: f64) -> Result<(), StepError> {
        let n = self.acceleration.len();
        if self.internal.is_empty() {
            self.update(model, state, time)?;
        }
        if let Some(fast) = &mut self.fast {
            let sources = self.actions.iter().zip(&model.loads).zip(&state.inputs);
            let mut values = Vec::new();
            sources.for_each(|((action, load), input)| action.source(load, input, time, &mut values));
            if fast.knows(values) && self.external.len() == n {
                return Ok(());
            }
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
        if self.fast.is_some() {
            return self.update_nodes(model, state, time);
        }
        let mut internal = vec![[0.0; 3]; self.acceleration.len()];
        for part in &self.parts {
            let task = self.task(model, part, &state.nodes.displacement, false);
            if let Err(trouble) = (self.sweeps.advance)(&task, &mut state.particles, &mut internal) {
                return Err(self.explain(model, state, time, &trouble));
            }
        }
        self.pulls = self.pull(model, state, time, &state.nodes.displacement, &mut internal)?;
        self.fold(&mut internal);
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
            action.add(load, input, model, &references, time, displacement, self.fast.as_ref(), force)?;
        }
        self.fold(force);
        Ok(())
    }

    /// Nodes that follow others hand on the forces that they got.
    fn fold(&self, force: &mut Vectors) {
        self.bodies.iter().for_each(|body| body.reference.fold(force));
    }

    /// Nodes that follow others go where those lead.
    fn spread(&self, field: &mut Vectors) {
        self.bodies.iter().for_each(|body| body.reference.spread(field));
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
        let (start, moved) = (model.reference(particle as u32), self.at(particle, &state.nodes.displacement));
        std::array::from_fn(|a| start[a] + moved[a])
    }

    /// A nodal field at a particle.
    fn at(&self, particle: usize, field: &[[f64; 3]]) -> [f64; 3] {
        let Some(part) = self.parts.iter().find(|part| (part.first..part.last).contains(&particle)) else { return [f64::NAN; 3] };
        let reference = &self.bodies[part.body].reference;
        let mut value = [0.0; 3];
        reference.each_slowly(&reference.particle(particle - part.offset), |node, weight, _| {
            for a in 0..3 {
                value[a] += weight * field[node][a];
            }
        });
        value
    }

    /// Solves M x = `right` for the free components; `x` comes with the values of those that are held.
    fn solve(&mut self, model: &Model, right: &Vectors, x: &mut Vectors) {
        for body in &mut self.bodies {
            let nodes = body.reference.start..body.reference.start + body.reference.len();
            for a in 0..model.dimension {
                self.column.clear();
                self.column.extend(nodes.clone().map(|node| x[node][a]));
                self.product.clone_from(&self.column);
                if self.column.iter().any(|v| *v != 0.0) {
                    body.mass.times(&mut self.product);
                }
                for (p, node) in self.product.iter_mut().zip(nodes.clone()) {
                    *p = right[node][a] - *p;
                }
                body.mass.solve(a, &mut self.product);
                for h in self.held.iter().filter(|h| h.axis == a && nodes.contains(&h.node)) {
                    self.product[h.node - nodes.start] = 0.0;
                }
                for (k, node) in nodes.clone().enumerate() {
                    x[node][a] = self.product[k] + self.column[k];
                }
            }
            body.reference.spread(x);
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
}

/// Whether functions with little of a body in their support follow others. Where inertia is lumped they stay as they are: rows of weights of
/// both signs may sum to a mass below zero, and from degree 2 on frequencies of lumped splines do not depend on how little of one is in the
/// body (Leidinger 2020, Explicit isogeometric B-Rep analysis for nonlinear dynamic crash simulations; proofs in arXiv:2410.17857). Their low
/// modes lose accuracy, though (arXiv:2502.00452), and a held face takes from the stable step.
fn extends(model: &Model) -> bool {
    !model.balance.is_lumped() || model.implicit.is_some_and(|scheme| !scheme.has_inertia())
}

/// Components that boundaries hold; a later boundary overrides an earlier one.
fn hold(reference: &Reference, model: &Model, body: usize) -> Vec<Held> {
    let mut held = Vec::new();
    for i in (0..reference.len()).filter(|i| reference.is_own(*i)) {
        let place = reference.place(i);
        for axis in 0..model.dimension {
            let on = |b: &Boundary| {
                b.holds_place(&model.axes, &place[..model.dimension]) || b.holds_end(body, &reference.axes, &reference.index(i))
            };
            let holds = |b: &Boundary| b.holds_axis(axis) && on(b);
            if let Some(boundary) = model.boundaries.iter().rposition(holds) {
                held.push(Held { body, node: reference.start + i, axis, boundary });
            }
        }
    }
    held
}
