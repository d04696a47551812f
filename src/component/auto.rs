//! `method = "auto"`: the method by what the scene holds.

use crate::component::StepError;
use crate::model::{Model, Quadrilateral, Signal};
use crate::scene::{Fault, Formulation, Integrator, Law, Method, Plane, Scene, SceneError, Shape};
use crate::solver::Solver;
use crate::state::State;
use crate::text::si;

/// What was chosen, and why.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Choice {
    /// Part of the method.
    pub part: &'static str,
    /// What was chosen, as a scene would say it.
    pub chosen: String,
    /// Why.
    pub why: String,
}

/// Why the total formulation is taken.
const FITS: &str = "one body, without contact, that a grid can be fitted to";
/// Poisson's ratio from which on volume locks.
const LOCKS: f64 = 0.45;
/// Share of its largest value by which a load may change in the slowest period of a body that follows it without inertia.
const SLOW: f64 = 0.05;
/// Times at which loads are looked at.
const LOOKS: usize = 400;
/// Steps of a quasi-static run whose scene names none.
const STEPS: f64 = 20.0;

/// The scene with its method chosen, where it leaves that open.
pub(super) fn choose(mut scene: Scene) -> Result<(Scene, Vec<Choice>), SceneError> {
    if !scene.method.auto {
        return Ok((scene, Vec::new()));
    }
    let mut choices = Vec::new();
    let mut choose = |part, chosen: &str, why: String| choices.push(Choice { part, chosen: chosen.to_owned(), why });

    let total = |degree: usize| Method { formulation: Formulation::Total, degree: Some(degree), ..Method::default() };
    let built = match fitted(&mut scene, total(3))? {
        Ok(_) if locks(&scene) => {
            choose("formulation", "total", FITS.into());
            choose("degree", "2", "with mean_dilatation, of which higher degrees gain little".into());
            choose("mean_dilatation", "true", format!("a Poisson's ratio from {LOCKS} on would lock the change of volume"));
            scene.method = Method { mean_dilatation: true, ..total(2) };
            Built::new(&scene)?
        }
        Ok(built) => {
            choose("formulation", "total", FITS.into());
            choose("degree", "3", "of order 4 in displacement, smooth in stress".into());
            built
        }
        Err(why) => {
            choose("formulation", "updated", why);
            choose("degree", "2", "smooth slopes at the least cost, where particles move through the grid".into());
            scene.method = Method { degree: Some(2), ..Method::default() };
            Built::new(&scene)?
        }
    };
    let integrator = integrator(&scene, &built);
    choose("integrator", integrator.name, integrator.why);
    scene.method.integrator = Some(integrator.of);
    if integrator.of == Integrator::QuasiStatic && scene.time.step.is_none() {
        let step = scene.time.end / STEPS;
        choose("time.step", &step.to_string(), format!("{STEPS} steps: a balance of forces does not depend on the steps that led to it"));
        scene.time.step = Some(step);
    }
    scene.check()?;
    Ok((scene, choices))
}

/// The scene made ready in the total formulation, or why that cannot do with it.
fn fitted(scene: &mut Scene, method: Method) -> Result<Result<Built, String>, SceneError> {
    if let Some(why) = obstacle(scene) {
        return Ok(Err(why));
    }
    scene.method = method;
    let built = Built::new(scene)?;
    Ok(match built.apart() {
        Some(name) => Err(format!("boundary `{name}` is not on the body at time 0, which may yet come to it")),
        None => Ok(built),
    })
}

/// Why the total formulation cannot do with a scene, where that shows in it.
fn obstacle(scene: &Scene) -> Option<String> {
    let fits = |shape: &Shape| matches!(shape, Shape::Box { .. }) || Quadrilateral::new(shape).is_some_and(|map| map.is_convex());
    if scene.contact.is_some() {
        return Some("bodies touch".into());
    }
    if scene.body.len() > 1 {
        return Some(format!("{} bodies may meet", scene.body.len()));
    }
    let odd = scene.body.iter().find(|(_, body)| !fits(&body.shape));
    odd.map(|(name, _)| format!("no grid can be fitted to body `{name}`, which is neither a box nor a convex polygon of four corners"))
}

fn locks(scene: &Scene) -> bool {
    let volume = scene.dimension == 3 || scene.dimension == 2 && scene.plane == Plane::Strain;
    let law = |law| matches!(law, Law::NeoHookean | Law::Hencky);
    volume && scene.material.values().any(|m| m.poisson >= LOCKS) && scene.material.values().all(|m| law(m.law))
}

/// A scene made ready, with an explicit integrator, to be asked.
struct Built {
    model: Model,
    state: State,
    solver: Solver,
    stable_step: f64,
}

impl Built {
    fn new(scene: &Scene) -> Result<Self, SceneError> {
        let (model, mut state) = Model::new(scene)?;
        let mut solver = Solver::new(&model, &mut state);
        let fault = |e: StepError| SceneError::Faults { file: None, faults: vec![Fault::new("body", e.to_string())] };
        let stable_step = solver.stable_step(&model, &state).map_err(fault)?;
        Ok(Self { model, state, solver, stable_step })
    }

    /// A boundary that holds no node.
    fn apart(&self) -> Option<&str> {
        let Solver::Total(total) = &self.solver else { return None };
        let boundaries = self.model.boundaries.iter().enumerate();
        boundaries.into_iter().find(|(b, _)| !total.is_held_by(*b)).map(|(_, boundary)| boundary.name.as_str())
    }
}

struct Chosen {
    of: Integrator,
    name: &'static str,
    why: String,
}

fn integrator(scene: &Scene, built: &Built) -> Chosen {
    let time = &scene.time;
    let total = scene.method.is_total();
    let period = slowest_period(scene);
    let moving = if time.cfl.is_some() || time.error.is_some() {
        Some("`time` asks for steps that resolve it".to_owned())
    } else {
        moves(built, time.end, period)
    };
    if moving.is_none() {
        let why =
            format!("loads change by less than {} % in {}, the slowest period of a body of this length", 100.0 * SLOW, si(period, "s"));
        return Chosen { of: Integrator::QuasiStatic, name: "quasi_static", why };
    }
    if scene.contact.is_none() && (time.error.is_some() || time.step.is_some_and(|step| step > built.stable_step)) {
        let why = match time.step {
            Some(step) if time.error.is_none() => {
                format!("the step asked for, {}, is above the {} that explicit ones need", si(step, "s"), si(built.stable_step, "s"))
            }
            _ => "steps by their error are implicit".to_owned(),
        };
        // what the step does not resolve is damped; the conserving scheme would keep it, as noise
        return Chosen { of: Integrator::GeneralizedAlpha, name: "generalized_alpha", why };
    }
    let why = format!("cheapest a step, and {} is stable; inertia counts: {}", si(built.stable_step, "s"), moving.unwrap_or_default());
    if total { Chosen { of: Integrator::Verlet, name: "verlet", why } } else { Chosen { of: Integrator::Musl, name: "musl", why } }
}

/// Why inertia counts; `None` where the loads are followed through states of balance.
fn moves(built: &Built, end: f64, period: f64) -> Option<String> {
    let (model, state) = (&built.model, &built.state);
    let Solver::Total(total) = &built.solver else { return Some("bodies may come apart or meet".into()) };
    let particles = &state.particles;
    if (0..particles.len()).any(|p| particles.velocity.row::<3>(p) != [0.0; 3]) {
        return Some("a body moves at time 0".into());
    }
    if let Some(load) = model.loads.iter().find(|load| matches!(load.signal, Signal::External)) {
        return Some(format!("load `{}` is set from outside", load.name));
    }
    if !total.is_supported(model.dimension) {
        return Some("a body is free to drift or turn".into());
    }
    let times: Vec<f64> = (0..=LOOKS).map(|k| end * k as f64 / LOOKS as f64).collect();
    let ahead = (period / end * LOOKS as f64).ceil() as usize;
    // a formula of space may vanish anywhere: look at several places
    let places: Vec<[f64; 3]> = [0, 1, 2, 3, 4].map(|k| model.reference((k * (particles.len() - 1) / 4) as u32)).to_vec();
    let mut acts = false;
    for load in &model.loads {
        let values: Vec<Vec<f64>> =
            times.iter().map(|&t| places.iter().flat_map(|&place| load.signal.value(place, t, &[])).collect()).collect();
        if !is_slow(&values, ahead) {
            return Some(format!("load `{}` starts or changes fast", load.name));
        }
        acts |= values.iter().flatten().any(|v| *v != 0.0);
    }
    for boundary in &model.boundaries {
        let mut path = vec![vec![0.0; 3]];
        for pair in times.windows(2) {
            let speed = |axis: usize, t: f64| boundary.velocity(axis, t).unwrap_or(0.0);
            let step = |axis: usize| 0.5 * (pair[1] - pair[0]) * (speed(axis, pair[0]) + speed(axis, pair[1]));
            let last = &path[path.len() - 1];
            path.push((0..3).map(|axis| last[axis] + if axis < model.dimension { step(axis) } else { 0.0 }).collect());
        }
        if !is_slow(&path, ahead) {
            return Some(format!("boundary `{}` moves fast", boundary.name));
        }
        acts |= path.iter().flatten().any(|v| *v != 0.0);
    }
    (!acts).then(|| "nothing acts on the body".into())
}

/// Whether vectors sampled over time begin small and change little within as many samples, against the largest of them.
fn is_slow(values: &[Vec<f64>], within: usize) -> bool {
    let distance = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
    let none = vec![0.0; values[0].len()];
    let largest = values.iter().map(|v| distance(v, &none)).fold(0.0, f64::max);
    let change = (0..values.len()).map(|i| distance(&values[i], &values[(i + within).min(values.len() - 1)])).fold(0.0, f64::max);
    largest == 0.0 || distance(&values[0], &none) <= SLOW * largest && change <= SLOW * largest
}

/// The slowest period that a body of the scene may have \[s\]: that of a cantilever of its longest by its shortest side, or of a bar.
fn slowest_period(scene: &Scene) -> f64 {
    let mut slowest = 0.0f64;
    for body in scene.body.values() {
        let Some(material) = scene.material.get(&body.material) else { continue };
        let (low, high) = body.shape.bounds(scene.dimension);
        let sides = || low.iter().zip(&high).map(|(low, high)| high - low);
        let (long, short) = (sides().fold(0.0, f64::max), sides().fold(f64::INFINITY, f64::min));
        let speed = (material.young / material.density).sqrt();
        let bar = 4.0 * long / speed;
        // Euler and Bernoulli: omega = 1.8751^2 / L^2 sqrt(E I / rho A)
        let beam = std::f64::consts::TAU * 12f64.sqrt() * long * long / (1.8751f64.powi(2) * short * speed);
        slowest = slowest.max(bar).max(if scene.dimension > 1 { beam } else { 0.0 });
    }
    slowest
}
