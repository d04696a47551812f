//! What extended B-splines are for: matrices and the stable step of a body that may lie anywhere in its grid.

use super::Total;
use super::implicit::Step;
use super::tests::{field, prepare};
use crate::implicit::{Balance, Scheme};
use crate::model::Model;
use crate::scene::Scene;
use nalgebra::DMatrix;

/// A rectangle of 1.1 by 0.7 at a place and angle in cells of 0.25; the fifth corner keeps the grid from being fitted to it.
fn rectangle(place: [f64; 2], angle: f64, degree: usize, law: &str, method: &str) -> Scene {
    let (sin, cos) = angle.sin_cos();
    let corners = [[0.0, 0.0], [0.4, 0.0], [1.1, 0.0], [1.1, 0.7], [0.0, 0.7]];
    let corners = corners.map(|[x, y]| [place[0] + cos * x - sin * y, place[1] + sin * x + cos * y]);
    Scene::from_toml(&format!(
        r#"
        title = "anywhere"
        dimension = 2
        grid = {{ origin = [-2, -2], size = [4, 4], cell = 0.25 }}
        material.m = {{ law = "{law}", young = 100.0, poisson = 0.3, density = 2.0 }}
        body.block = {{ material = "m", shape = {{ polygon = {{ points = {corners:?} }} }} }}
        boundary.root = {{ surface = {{ body = "block", face = "edge5" }}, fixed = ["x"], velocity = {{ y = "0.1*cos(t)" }} }}
        load.side.pressure = {{ body = "block", face = "edge3", value = [5] }}
        method = {{ formulation = "total", degree = {degree}, {method} }}
        time = {{ end = 1.0, step = 0.02 }}
        "#
    ))
    .unwrap()
}

/// Where a body has cells of which only a sliver is in it, and where it lies askew.
fn everywhere() -> impl Iterator<Item = ([f64; 2], f64)> {
    // right and upper side pass through a cell, down to slivers of 1e-8 of it
    let shifted = (0..50).map(|k| {
        let by = if k % 2 == 0 { 0.25 * f64::from(k) / 50.0 } else { 0.15 + 0.25 * 10f64.powi(-(k / 6).min(8)) };
        ([by, by - 0.1], 0.0)
    });
    let turned = (0..50).map(|k| ([0.1, 0.05], std::f64::consts::FRAC_PI_2 * f64::from(k) / 50.0));
    shifted.chain(turned)
}

/// Largest over smallest eigenvalue once the diagonal is made 1: the size of a function is a matter of taste.
pub(super) fn condition(matrix: &DMatrix<f64>) -> f64 {
    let d = matrix.diagonal().map(|v| 1.0 / v.sqrt());
    let values = DMatrix::from_fn(matrix.nrows(), matrix.ncols(), |i, j| matrix[(i, j)] * d[i] * d[j]).symmetric_eigenvalues();
    values.max() / values.min()
}

pub(super) fn total(scene: &Scene) -> (Total, Model, crate::state::State) {
    let (model, mut state) = Model::new(scene).unwrap();
    let mut total = Total::new(&model, &state);
    total.start(&model, &mut state);
    total.begin(&model);
    (total, model, state)
}

/// What is measured at a place and angle.
struct Figures {
    /// Condition, with a diagonal of 1.
    mass: f64,
    stiffness: f64,
    /// Share of the penalty from which on the stiffness is positive.
    needed: f64,
    /// Stable steps where a face is held, and where all are free \[s\].
    held: f64,
    free: f64,
    /// Where mass is lumped and all are free \[s\].
    lumped: f64,
}

/// Mass, and stiffness at rest, of a scene without loads in which a face is held; the share of the penalty from which on the latter is positive.
pub(super) fn matrices(scene: &Scene) -> (DMatrix<f64>, DMatrix<f64>, f64) {
    let (mut grid, model, state) = total(scene);
    let body = &grid.bodies[0];
    let own: Vec<usize> = (0..body.reference.len()).filter(|i| body.reference.is_own(*i)).collect();
    let mass = DMatrix::from_fn(own.len(), own.len(), |i, j| body.mass.entry(own[i], own[j]));
    let mut matrix = grid.pattern(&model);
    let nodes = grid.acceleration.len();
    let mut with_penalty = |factor: f64| {
        let penalty = grid.surfaces[0].penalty;
        grid.surfaces[0].penalty *= factor;
        let mut step = Step::new(&mut grid, &model, &state, Scheme::QuasiStatic, 1.0, &mut matrix);
        step.stiffen(&vec![[0.0; 3]; nodes]).ok().unwrap();
        grid.surfaces[0].penalty = penalty;
        let n = matrix.components().count();
        let mut full = DMatrix::zeros(n, n);
        for j in 0..n {
            let mut unit = vec![0.0; n];
            unit[j] = 1.0;
            full.set_column(j, &nalgebra::DVector::from_vec(matrix.multiply(&unit)));
        }
        full
    };
    let (full, double) = (with_penalty(1.0), with_penalty(2.0));
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..8 {
        let middle = 0.5 * (low + high);
        let part = &full + (&double - &full) * (middle - 1.0);
        if part.cholesky().is_some() { high = middle } else { low = middle }
    }
    (mass, full, high)
}

fn figures(place: [f64; 2], angle: f64, degree: usize) -> Figures {
    let mut scene = rectangle(place, angle, degree, "linear_elastic", "integrator = \"quasi_static\"");
    scene.load.clear();
    let (mass, full, high) = matrices(&scene);
    let stable = |method: &str, held: bool| {
        let mut scene = rectangle(place, angle, degree, "linear_elastic", method);
        if !held {
            scene.boundary.clear();
        }
        let (mut grid, model, state) = total(&scene);
        grid.stable_step(&model, &state).unwrap()
    };
    let explicit = "integrator = \"verlet\"";
    let (held, free) = (stable(explicit, true), stable(explicit, false));
    let lumped = stable("integrator = \"verlet\", mass = \"lumped\"", false);
    Figures { mass: condition(&mass), stiffness: condition(&full), needed: high, held, free, lumped }
}

/// Where functions with next to nothing of the body stand for themselves, the stable step of the same bodies goes to 0 (below 1e-6 s)
/// and the conditions at degree 3 go to 9e14 and 2e9, and no penalty makes the stiffness positive.
#[test]
fn slivers_and_angles_change_little() {
    for degree in [1, 2, 3] {
        let all: Vec<Figures> = everywhere().map(|(place, angle)| figures(place, angle, degree)).collect();
        let range = |of: &dyn Fn(&Figures) -> f64| {
            let values = all.iter().map(of);
            [values.clone().fold(f64::INFINITY, f64::min), values.fold(0.0, f64::max)]
        };
        let (mass, stiffness, needed) = (range(&|f| f.mass), range(&|f| f.stiffness), range(&|f| f.needed));
        let (held, free, lumped) = (range(&|f| f.held), range(&|f| f.free), range(&|f| f.lumped));
        println!("degree {degree}: condition of mass {mass:.0?}, of stiffness {stiffness:.0?}, penalty needed {needed:.2?}");
        println!("   stable step free {free:.6?} s, held {held:.6?} s, lumped {lumped:.6?} s");
        for (name, [low, high], times) in [
            ("mass", mass, 10.0),
            ("stiffness", stiffness, 10.0),
            ("free", free, 3.0),
            ("held", held, 3.0),
            // linear functions, lumped, do depend on the slivers
            ("lumped", lumped, if degree > 1 { 2.0 } else { f64::INFINITY }),
        ] {
            assert!(high < times * low, "degree {degree}, {name}: {low:e} to {high:e}");
        }
        assert!(needed[1] < 0.75, "degree {degree}: {needed:?}");
    }
}

/// A field of the nodes that the functions make of a smooth one.
fn bent(grid: &mut Total, model: &Model, state: &crate::state::State) -> Vec<[f64; 3]> {
    let mut field = state.particles.velocity.clone();
    for p in 0..state.particles.len() {
        let [x, y, _]: [f64; 3] = model.reference(p as u32);
        field.set_row(p, &[0.3 * x * y - 0.2 * y * y, 0.25 * x * x + 0.1 * y, 0.0]);
    }
    grid.project(model, state, &field)
}

/// Dead traction has the resultant and moment that it should on a bent body; pressure on a closed edge has neither.
#[test]
fn resultants_at_cut_edges_are_exact() {
    let mut scene = rectangle([0.03, 0.07], 0.4, 2, "neo_hookean", "integrator = \"verlet\"");
    scene.boundary.clear();
    scene.load.clear();
    let dead = r#"{"traction": {"body": "block", "face": "edge3", "value": [3, -2]}}"#;
    scene.load.insert("dead".into(), serde_json::from_str(dead).unwrap());
    let follower = scene.clone();
    let (mut grid, model, state) = total(&scene);
    let displacement = bent(&mut grid, &model, &state);
    let resultant = |grid: &Total, model: &Model, state: &crate::state::State, displacement: &[[f64; 3]]| {
        let mut force = vec![[0.0; 3]; displacement.len()];
        grid.load(model, state, 0.0, displacement, &mut force).ok().unwrap();
        let mut sum = [0.0; 3];
        for (i, f) in force.iter().enumerate() {
            let place = grid.bodies[0].reference.place(i);
            let at = [0, 1].map(|a| place[a] + displacement[i][a]);
            (0..2).for_each(|a| sum[a] += f[a]);
            sum[2] += at[0] * f[1] - at[1] * f[0];
        }
        sum
    };
    let found = resultant(&grid, &model, &state, &displacement);
    // of the quadratic field, along the side from (1.1, 0) to (1.1, 0.7) of the rectangle
    let (sin, cos) = 0.4f64.sin_cos();
    let mut exact = [3.0 * 0.7, -2.0 * 0.7, 0.0];
    for (t, weight) in crate::quadrature::gauss_legendre(4) {
        let [x, y] = [0.03 + cos * 1.1 - sin * 0.7 * t, 0.07 + sin * 1.1 + cos * 0.7 * t];
        let at = [x + 0.3 * x * y - 0.2 * y * y, y + 0.25 * x * x + 0.1 * y];
        exact[2] += 0.7 * weight * (at[0] * -2.0 - at[1] * 3.0);
    }
    println!("dead traction {found:?} of {exact:?}");
    // round-off: the projection of the field has that of the condition of the mass matrix, below 1e3
    assert!((0..3).all(|a| (found[a] - exact[a]).abs() < 1e-12));

    let mut scene = follower;
    scene.load.clear();
    for k in 1..=5 {
        let pressure = format!(r#"{{"pressure": {{"body": "block", "face": "edge{k}", "value": [5]}}}}"#);
        scene.load.insert(format!("p{k}"), serde_json::from_str(&pressure).unwrap());
    }
    let (mut grid, model, state) = total(&scene);
    let displacement = bent(&mut grid, &model, &state);
    let found = resultant(&grid, &model, &state, &displacement);
    println!("pressure all around {found:?}");
    assert!(found.iter().all(|f| f.abs() < 1e-12));
}

/// Largest difference between the stiffness times a direction and that of the residuals along it, and the largest entry of the former.
pub(super) fn tangent_error(scene: &Scene) -> [f64; 2] {
    let (model, state) = Model::new(scene).unwrap();
    let seed = &mut 5;
    let (mut total, mut state) = prepare(&model, state, seed);
    let n = total.acceleration.len();
    total.spread(&mut state.nodes.displacement);
    total.spread(&mut state.nodes.velocity);
    total.spread(&mut state.nodes.acceleration);
    let (mut at, mut direction) = (field(n, model.dimension, 0.002, seed), field(n, model.dimension, 1.0, seed));
    for field in [&mut at, &mut direction] {
        (0..n).filter(|i| !total.bodies[0].reference.is_own(*i)).for_each(|i| field[i] = [0.0; 3]);
        total.spread(field);
    }
    let mut matrix = total.pattern(&model);
    let scheme = model.implicit.unwrap();
    let mut step = Step::new(&mut total, &model, &state, scheme, 0.02, &mut matrix);
    let h = 1e-6;
    let mut forces = |by: f64| {
        let moved: Vec<[f64; 3]> = at.iter().zip(&direction).map(|(u, d)| std::array::from_fn(|a| u[a] + by * d[a])).collect();
        step.residual(&moved).ok().unwrap().forces
    };
    let (plus, minus) = (forces(h), forces(-h));
    step.stiffen(&at).ok().unwrap();
    let x: Vec<f64> = matrix.components().map(|(node, a)| direction[node][a]).collect();
    let y = matrix.multiply(&x);
    let (mut error, mut size) = (0.0f64, 0.0f64);
    for ((node, a), y) in matrix.components().zip(y) {
        let difference = (minus[node][a] - plus[node][a]) / (2.0 * h);
        error = error.max((difference - y).abs());
        size = size.max(y.abs());
    }
    [error, size]
}

/// Residuals of held faces and loads at cut edges against differences.
#[test]
fn tangents_of_cut_bodies_are_derivatives() {
    for law in ["linear_elastic", "neo_hookean", "hencky"] {
        for integrator in ["quasi_static", "newmark", "generalized_alpha"] {
            let scene = rectangle([0.03, 0.07], 0.4, 2, law, &format!("integrator = \"{integrator}\""));
            let [error, size] = tangent_error(&scene);
            println!("{law} {integrator}: {:e}", error / size);
            // differences leave some 1e-9; the change of the moduli at the held face, left out, is of the displacement beside it (0.01)
            let limit = if law == "linear_elastic" { 1e-7 } else { 1e-2 };
            assert!(error < limit * size, "{law} {integrator}: {error:e} of {size:e}");
        }
    }
}
