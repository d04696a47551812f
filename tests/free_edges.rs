//! High order where edges of bodies cut cells and particles move through the grid: the updated formulation with sheets of particles.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use matpoint::Simulation;
use matpoint::scene::Scene;
use std::f64::consts::PI;

const METHOD: &str =
    r#"degree = 3, mass = "consistent", mass_residual = 1e-12, quadrature = "splines", quadrature_of = "force_and_velocity""#;

fn build(text: &str) -> Simulation {
    Scene::from_toml(text).unwrap().build().unwrap()
}

/// Errors of displacement \[m\] and stress \[Pa\].
fn errors(sim: &mut Simulation) -> [f64; 2] {
    ["error/displacement", "error/stress"].map(|name| sim.get(name).unwrap()[0])
}

/// Orders between two grids.
fn orders(cells: [usize; 2], found: &[[f64; 2]; 2]) -> [f64; 2] {
    [0, 1].map(|k| (found[0][k] / found[1][k]).ln() / (cells[1] as f64 / cells[0] as f64).ln())
}

const RADIUS: &str = "sqrt(x^2+y^2)";

/// The generalised vortex: particles of a ring between two walls turn by g(t) h(R), with the body force of `state-of-the-art.md`, B6, for
/// neo-Hookean rubber; `turn` is the largest angle \[rad\].
fn vortex(cells: usize, turn: f64, method: &str) -> [f64; 2] {
    let (young, poisson, density) = (1000.0, 0.3, 1000.0);
    let mu = young / 2.0 / (1.0 + poisson);
    let m = mu / density;
    let s = format!("({RADIUS}-1)");
    let (h, h1, h2) = (format!("(1-32*{s}^2+256*{s}^4)"), format!("(-64*{s}+1024*{s}^3)"), format!("(-64+3072*{s}^2)"));
    let (g, g1, g2) = (format!("({turn}*sin(PI*t))"), format!("({turn}*PI*cos(PI*t))"), format!("(-{turn}*PI^2*sin(PI*t))"));
    let a = format!("({g}*{h})");
    let along = format!("({m}*(3*{g}*{h1}+{RADIUS}*{g}*{h2})-{RADIUS}*{g2}*{h})");
    let inward = format!("({m}*{RADIUS}*({g}*{h1})^2-{RADIUS}*({g1}*{h})^2)");
    let radial = format!("({along}*sin({a})+{inward}*cos({a}))");
    let hoop = format!("(-{along}*cos({a})+{inward}*sin({a}))");
    // F = Q (1 + k e_theta e_R), so that b = Q (1 + k (e_R e_theta + e_theta e_R) + k^2 e_theta e_theta) Q^T
    let k = format!("({RADIUS}*{g}*{h1})");
    let (c, d) = (format!("((x*cos({a})-y*sin({a}))/{RADIUS})"), format!("((y*cos({a})+x*sin({a}))/{RADIUS})"));
    let mut sim = build(&format!(
        r#"
        title = "vortex"
        dimension = 2
        grid = {{ origin = [-1.5, -1.5], size = [3, 3], cell = {cell} }}
        material.m = {{ law = "neo_hookean", young = {young}, poisson = {poisson}, density = {density} }}
        body.ring = {{ material = "m", shape = {{ ring = {{ center = [0, 0], inner = 0.75, outer = 1.25 }} }}, particles_per_cell = 3, velocity = ["-y*{turn}*PI*{h}", "x*{turn}*PI*{h}"] }}
        boundary.inner = {{ surface = {{ body = "ring", face = "inner" }}, fixed = ["x", "y"] }}
        boundary.outer = {{ surface = {{ body = "ring", face = "outer" }}, fixed = ["x", "y"] }}
        load.source.body_force = {{ body = "ring", value = ["({radial}*x-{hoop}*y)/{RADIUS}", "({radial}*y+{hoop}*x)/{RADIUS}"] }}
        method = {{ {method} }}
        time = {{ end = 0.25, step = {step} }}
        exact = {{ displacement = ["x*cos({a})-y*sin({a})-x", "x*sin({a})+y*cos({a})-y"], stress.xx = "{mu}*({k}^2*{d}^2-2*{k}*{c}*{d})", stress.xy = "{mu}*({k}*({c}^2-{d}^2)-{k}^2*{c}*{d})" }}
        "#,
        cell = 1.0 / cells as f64,
        step = 8e-3 * (8.0 / cells as f64).powi(2),
    ));
    sim.step(0.25).unwrap();
    errors(&mut sim)
}

/// Steps go with the square of the cell, here and below, so that their error, of second order, falls as fast as that of the cells.
#[test]
fn a_vortex_between_walls_that_cut_cells() {
    let cells = [8, 12];
    let found = cells.map(|cells| vortex(cells, 0.2, METHOD));
    let order = orders(cells, &found);
    println!("vortex, 8 and 12 cells a metre: {found:?}, orders {order:?}");
    assert!(order[0] >= 3.5 && order[1] >= 2.5);
}

/// A ring that expands and shrinks, free on both sides: `state-of-the-art.md`, B7, for neo-Hookean rubber without Poisson's ratio.
fn expanding_ring(cells: usize) -> [f64; 2] {
    let (young, density, inner, outer, amplitude): (f64, f64, f64, f64, f64) = (1e7, 1000.0, 0.4, 0.6, 0.1);
    let (mu, w) = (young / 2.0, PI * (young / density).sqrt());
    let [c1, c2, c3] =
        [-6.0 * inner / outer, 3.0 * (inner + outer) / outer.powi(2), -2.0 / outer.powi(2)].map(|c| c / (outer - 3.0 * inner));
    // u_R = T q(R), with stretches 1 + T q' and 1 + T q / R
    let time = format!("({amplitude}*sin({w}*t))");
    let ratio = format!("({c1}+{RADIUS}*({c2}+{RADIUS}*({c3})))");
    let slope = format!("({c1}+{RADIUS}*(2*{c2}+{RADIUS}*3*{c3}))");
    let bend = format!("(2*({c2})+6*({c3})*{RADIUS})");
    let (radial, hoop) = (format!("(1+{time}*{slope})"), format!("(1+{time}*{ratio})"));
    // first Piola-Kirchhoff stress mu (l - 1 / l) along both
    let force = format!(
        "(-{ww}*{time}*{RADIUS}*{ratio}-{m}*((1+1/{radial}^2)*{time}*{bend}+(({radial}-1/{radial})-({hoop}-1/{hoop}))/{RADIUS}))/{RADIUS}",
        ww = w * w,
        m = mu / density
    );
    let (sr, st) = (format!("({mu}*({radial}-1/{radial})/{hoop})"), format!("({mu}*({hoop}-1/{hoop})/{radial})"));
    let end = 0.5 * PI / w;
    let speed = amplitude * w;
    let mut sim = build(&format!(
        r#"
        title = "ring"
        dimension = 2
        grid = {{ origin = [-1, -1], size = [2, 2], cell = {cell} }}
        material.m = {{ law = "neo_hookean", young = {young}, density = {density} }}
        body.ring = {{ material = "m", shape = {{ ring = {{ center = [0, 0], inner = {inner}, outer = {outer} }} }}, particles_per_cell = 3, velocity = ["{speed}*x*{ratio}", "{speed}*y*{ratio}"] }}
        load.source.body_force = {{ body = "ring", value = ["x*{force}", "y*{force}"] }}
        method = {{ {METHOD} }}
        time = {{ end = {end}, step = {step} }}
        exact = {{ displacement = ["x*{ratio}*{time}", "y*{ratio}*{time}"], stress.xx = "({sr}*x^2+{st}*y^2)/{RADIUS}^2", stress.xy = "({sr}-{st})*x*y/{RADIUS}^2" }}
        "#,
        cell = 1.0 / cells as f64,
        step = end / (200.0 * (cells as f64 / 20.0).powi(2)).round(),
    ));
    sim.step(end).unwrap();
    errors(&mut sim)
}

#[test]
fn a_ring_with_free_edges() {
    let cells = [16, 24];
    let found = cells.map(expanding_ring);
    let order = orders(cells, &found);
    println!("ring, 16 and 24 cells a metre: {found:?}, orders {order:?}");
    assert!(order[0] >= 3.0 && order[1] >= 2.0);
}

/// A cube whose face at x = 1 is free and carries a traction that varies along it: u_i = a_i s_i(X_i) sin(c t), of neo-Hookean rubber.
/// Displacements normal to the other faces are 0. In the updated formulation both faces across x cut cells, one of them a wall.
fn pulled_cube(cells: usize, updated: bool) -> [f64; 2] {
    let (young, poisson, c): (f64, f64, f64) = (100.0, 0.3, 20.0);
    let (mu, lambda) = (young / (2.0 * (1.0 + poisson)), young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)));
    let along = |a: usize| [("x", 1.2, 0.1), ("y", PI, 0.04), ("z", PI, -0.03)][a];
    let shape = |a: usize| format!("({}*sin({}*{}))", along(a).2, along(a).1, along(a).0);
    let time = format!("sin({c}*t)");
    let displacement = |a: usize| format!("{}*{time}", shape(a));
    let stretch = |a: usize| format!("(1+{}*cos({}*{})*{time})", along(a).2 * along(a).1, along(a).1, along(a).0);
    let log = format!("(ln{}+ln{}+ln{})", stretch(0), stretch(1), stretch(2));
    let piola = |a: usize| format!("({mu}*({f}-1/{f})+{lambda}*{log}/{f})", f = stretch(a));
    // b = u'' - dP/dF F', with F' = -k^2 u
    let force = |a: usize| {
        let (f, k) = (stretch(a), along(a).1);
        format!("{}*({kk}*({mu}*(1+1/{f}^2)+{lambda}*(1-{log})/{f}^2)-{cc})", displacement(a), kk = k * k, cc = c * c)
    };
    let list = |of: &dyn Fn(usize) -> String| (0..3).map(|a| format!("\"{}\"", of(a))).collect::<Vec<_>>().join(", ");
    let end = 0.5 * PI / c;
    let (wall, offset, method) = if updated {
        (r#"surface = { body = "cube", face = "x-" }"#, 1.4 / cells as f64, METHOD.to_owned())
    } else {
        (r#"face = "x-""#, 0.0, r#"formulation = "total", degree = 3, integrator = "symplectic4""#.to_owned())
    };
    let step = if updated { format!(", step = {}", end / (2 * cells * cells) as f64) } else { String::new() };
    let cauchy = format!("{}/({}*{})", piola(0), stretch(1), stretch(2));
    let mut sim = build(&format!(
        r#"
        title = "cube"
        dimension = 3
        grid = {{ origin = [-{offset}, 0, 0], size = [2, 1, 1], cell = {cell} }}
        material.m = {{ law = "neo_hookean", young = {young}, poisson = {poisson}, density = 1 }}
        body.cube = {{ material = "m", shape = {{ box = {{ min = [0, 0, 0], max = [1, 1, 1] }} }}, particles_per_cell = 4, velocity = [{velocity}] }}
        boundary.x = {{ {wall}, fixed = ["x"] }}
        boundary.y = {{ face = "y-", fixed = ["y"] }}
        boundary.yy = {{ face = "y+", fixed = ["y"] }}
        boundary.z = {{ face = "z-", fixed = ["z"] }}
        boundary.zz = {{ face = "z+", fixed = ["z"] }}
        load.source.body_force = {{ body = "cube", value = [{force}] }}
        load.pull.traction = {{ body = "cube", face = "x+", value = ["{pull}", "0", "0"] }}
        method = {{ {method} }}
        time = {{ end = {end}{step} }}
        exact = {{ displacement = [{displacement}], stress.xx = "{cauchy}" }}
        "#,
        cell = 1.0 / cells as f64,
        velocity = list(&|a| format!("{c}*{}", shape(a))),
        force = list(&force),
        pull = piola(0),
        displacement = list(&displacement),
    ));
    sim.step(end).unwrap();
    errors(&mut sim)
}

#[test]
fn a_cube_with_a_free_face_that_is_pulled() {
    for (name, cells, updated) in [("total", [3, 6], false), ("updated, cut", [3, 4], true)] {
        let found = cells.map(|cells| pulled_cube(cells, updated));
        let order = orders(cells, &found);
        println!("pulled cube, {name}, {cells:?} cells: {found:?}, orders {order:?}");
        assert!(order[0] >= 3.5 && order[1] >= 2.5);
    }
}

/// Bodies of high order that meet: contact is of first order, is said to be, and does not make energy.
#[test]
fn contact_falls_back() {
    let mut sim = build(&format!(
        r#"
        title = "meeting"
        dimension = 2
        grid = {{ origin = [0, 0], size = [3, 2], cell = 0.1 }}
        material.m = {{ law = "neo_hookean", young = 100, poisson = 0.3, density = 1 }}
        body.left = {{ material = "m", shape = {{ box = {{ min = [0.43, 0.52], max = [1.04, 1.13] }} }}, particles_per_cell = 3, velocity = [0.5, 0] }}
        body.right = {{ material = "m", shape = {{ box = {{ min = [1.56, 0.61], max = [2.17, 1.22] }} }}, particles_per_cell = 3, velocity = [-0.5, 0] }}
        contact = {{ friction = 0.2 }}
        method = {{ {method} }}
        time = {{ end = 1.0 }}
        "#,
        method = METHOD.replace("1e-12", "1e-8")
    ));
    assert_eq!(sim.fallback().contacts, 0);
    let energy = |sim: &mut Simulation| sim.get("energy/kinetic").unwrap()[0] + sim.get("energy/strain").unwrap()[0];
    let start = energy(&mut sim);
    let (mut touched, mut most) = (0, 0.0f64);
    for _ in 0..100 {
        sim.step(0.01).unwrap();
        touched = touched.max(sim.fallback().contacts);
        most = most.max(energy(&mut sim) / start);
    }
    let end = energy(&mut sim) / start;
    let momentum = sim.get("momentum/linear").unwrap().to_vec();
    println!("contact at up to {touched} nodes, energy at most {most} of that at the start, at the end {end}; momentum {momentum:?}");
    // measured 1.10 while they push each other, when a sum over particles knows steep stresses badly, and 0.95 at the end
    assert!(touched > 0 && most < 1.2 && end < 1.0);
}
