//! Bodies whose edge cuts the cells of their grid, in the total formulation: against exact solutions, and anywhere in the grid.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use matpoint::Simulation;
use matpoint::scene::Scene;

fn build(text: &str) -> Simulation {
    Scene::from_toml(text).unwrap().build().unwrap()
}

fn value(sim: &mut Simulation, name: &str) -> f64 {
    sim.get(name).unwrap()[0]
}

/// Order of convergence from the first to the last of errors on these cells.
fn order(cells: &[f64], errors: &[f64]) -> f64 {
    let n = cells.len() - 1;
    (errors[0] / errors[n]).ln() / (cells[0] / cells[n]).ln()
}

/// What happens to a ring: displacement a g(R) X with g = c1 + c2 R + c3 R^2.
#[derive(Clone, Copy)]
struct Ring {
    coefficients: [&'static str; 3],
    /// As a formula of t.
    a: &'static str,
    /// -a'' / a and a' at time 0, as formulas.
    rates: [&'static str; 2],
    /// Whether its rims are held.
    held: bool,
}

/// Vibration with free rims: u_R' vanishes at both radii, 0.4 and 0.6. Stretches from 0.9 to 1.26.
const FREE: Ring = Ring { coefficients: ["20/3", "-125/9", "250/27"], a: ".1*sin(100*PI*t)", rates: ["1e4*PI^2", "10*PI"], held: false };
/// Vibration with both rims held: u vanishes there. Stretches along R from 0.8 to 1.2.
const HELD: Ring = Ring { coefficients: ["-.24", "1", "-1"], a: "2.5*sin(100*PI*t)", rates: ["1e4*PI^2", "250*PI"], held: true };
/// The same at rest.
const STILL: Ring = Ring { coefficients: ["-.24", "1", "-1"], a: "2.5", rates: ["0", "0"], held: true };

/// A manufactured solution in a ring. With nu = 0 the law of this program is P = mu (F - F^-T), mu = E / 2: diagonal in polar axes, with the
/// stretches lr = 1 + a (g + R g') and lt = 1 + a g. The acceleration that is missing is a'' R g - (P_rr' + (P_rr - P_tt) / R) / rho along R,
/// with P_rr' = mu (1 + 1 / lr^2) a (2 g' + R g''). E = 1e7 and rho = 1000. Errors of displacement and stress at `end`.
fn ring(case: Ring, cell: f64, degree: usize, end: f64, method: &str) -> [f64; 2] {
    let Ring { coefficients: [c1, c2, c3], a, rates: [square, rate], held } = case;
    let (a, r) = (format!("({a})"), "sqrt(x^2+y^2)");
    let g = format!("({c1}+({c2})*{r}+({c3})*(x^2+y^2))");
    let radial = format!("(1+{a}*({c1}+2*({c2})*{r}+3*({c3})*(x^2+y^2)))");
    let around = format!("(1+{a}*{g})");
    let change = format!("(1+1/{radial}^2)*{a}*(2*({c2})+6*({c3})*{r})");
    let differ = format!("({radial}-1/{radial}-{around}+1/{around})/{r}");
    let force = format!("(-{square}*{a}*{g}-5000*({change}+{differ})/{r})");
    // Cauchy stress: P_rr / lt and P_tt / lr, turned to x and y
    let rr = format!("(({radial}-1/{radial})/{around})");
    let tt = format!("(({around}-1/{around})/{radial})");
    let rim = |name: &str| format!("boundary.{name} = {{ surface = {{ body = \"ring\", face = \"{name}\" }}, fixed = [\"x\", \"y\"] }}");
    let boundaries = if held { rim("inner") + "\n" + &rim("outer") } else { String::new() };
    let mut sim = build(&format!(
        r#"
        title = "ring"
        dimension = 2
        grid = {{ origin = [-0.7, -0.7], size = [1.4, 1.4], cell = {cell} }}
        material.m = {{ law = "neo_hookean", young = 1e7, density = 1000 }}
        body.ring = {{ material = "m", shape = {{ ring = {{ center = [0, 0], inner = 0.4, outer = 0.6 }} }}, velocity = ["{rate}*{g}*x", "{rate}*{g}*y"] }}
        {boundaries}
        load.source.body_force = {{ body = "ring", value = ["{force}*x", "{force}*y"] }}
        method = {{ formulation = "total", degree = {degree}, {method} }}
        [exact]
        displacement = ["{a}*{g}*x", "{a}*{g}*y"]
        stress = {{ xx = "5e6*({rr}*x^2+{tt}*y^2)/(x^2+y^2)", yy = "5e6*({rr}*y^2+{tt}*x^2)/(x^2+y^2)", xy = "5e6*({rr}-{tt})*x*y/(x^2+y^2)" }}
        "#
    ));
    sim.step(end).unwrap();
    [value(&mut sim, "error/displacement"), value(&mut sim, "error/stress")]
}

/// Orders between the last two of these cells are the best, p + 1 in displacement and p in stress, less a little.
fn converges(name: &str, case: Ring, degree: usize, cells: [f64; 3], end: f64, method: &str) {
    let errors = cells.map(|cell| ring(case, cell, degree, end, method));
    let [u, s] = [0, 1].map(|k| errors.map(|e| e[k]));
    let orders = [&u, &s].map(|e| order(&cells[1..], &e[1..]));
    println!(
        "{name}, degree {degree}, cells {cells:?}: displacement {u:?} m, order {:.2}; stress {s:?} Pa, order {:.2}",
        orders[0], orders[1]
    );
    let best = degree as f64;
    assert!(orders[0] >= best + 0.6 && orders[1] >= best - 0.4, "{name}, degree {degree}: {orders:?}");
}

const SYMPLECTIC: &str = "integrator = \"symplectic4\" }\n time = { end = 1.0, cfl = 0.8";
const STATIC: &str = "integrator = \"quasi_static\" }\n time = { end = 1.0, step = 1.0";

#[test]
fn free_curved_edges_keep_the_best_order() {
    converges("free ring", FREE, 2, [0.1, 0.05, 1.0 / 30.0], 0.001, SYMPLECTIC);
    converges("free ring", FREE, 3, [0.1, 0.05, 1.0 / 30.0], 0.001, SYMPLECTIC);
}

#[test]
fn held_curved_edges_keep_the_best_order_explicit() {
    converges("held ring", HELD, 2, [0.1, 0.05, 1.0 / 30.0], 0.001, SYMPLECTIC);
    converges("held ring", HELD, 3, [0.1, 0.05, 1.0 / 30.0], 0.001, SYMPLECTIC);
}

#[test]
fn held_curved_edges_keep_the_best_order_implicit() {
    converges("still ring", STILL, 2, [0.1, 0.05, 0.025], 1.0, STATIC);
    converges("still ring", STILL, 3, [0.1, 0.05, 0.025], 1.0, STATIC);
}

/// Corners of a rectangle of 1.1 by 0.7 at a place and angle; a fifth one, on its lower side, keeps the grid from being fitted to it.
fn rectangle([x, y]: [f64; 2], angle: f64) -> String {
    let (sin, cos) = angle.sin_cos();
    let corners = [[0.0, 0.0], [0.4, 0.0], [1.1, 0.0], [1.1, 0.7], [0.0, 0.7]];
    format!("{:?}", corners.map(|[s, t]| [x + cos * s - sin * t, y + sin * s + cos * t]))
}

/// Error of u = (phi, 0), phi = sin(pi s / 1.1) sin(pi t / 0.7) in the axes s, t of a rectangle that is held all around, at rest: body force
/// -E / 2 (laplace u + grad div u) at nu = 0.
fn anywhere(place: [f64; 2], angle: f64, degree: usize) -> f64 {
    let (sin, cos) = angle.sin_cos();
    let s = format!("(PI/1.1*({cos}*(x-({0}))+({sin})*(y-({1}))))", place[0], place[1]);
    let t = format!("(PI/.7*({cos}*(y-({1}))-({sin})*(x-({0}))))", place[0], place[1]);
    let (k, l) = (std::f64::consts::PI / 1.1, std::f64::consts::PI / 0.7);
    let (both, mixed) = (format!("sin{s}*sin{t}"), format!("cos{s}*cos{t}"));
    // phi_xx and phi_xy with d/dx = cos d/ds - sin d/dt, d/dy = sin d/ds + cos d/dt
    let xx = [-(cos * cos * k * k + sin * sin * l * l), -2.0 * cos * sin * k * l];
    let xy = [-cos * sin * (k * k - l * l), (cos * cos - sin * sin) * k * l];
    let half = 50.0;
    let held: String = (1..=5)
        .map(|k| format!("boundary.b{k} = {{ surface = {{ body = \"block\", face = \"edge{k}\" }}, fixed = [\"x\", \"y\"] }}\n"))
        .collect();
    let mut sim = build(&format!(
        r#"
        title = "anywhere"
        dimension = 2
        grid = {{ origin = [-2, -2], size = [4, 4], cell = 0.03125 }}
        material.m = {{ law = "linear_elastic", young = 100.0, density = 1.0 }}
        body.block = {{ material = "m", shape = {{ polygon = {{ points = {corners} }} }} }}
        {held}
        load.source.body_force = {{ body = "block", value = ["{xs}*{both}-({xc})*{mixed}", "({ys})*{both}-({yc})*{mixed}"] }}
        method = {{ formulation = "total", degree = {degree}, integrator = "quasi_static" }}
        time = {{ end = 1.0, step = 1.0 }}
        exact = {{ displacement = ["{both}", "0"] }}
        "#,
        corners = rectangle(place, angle),
        xs = half * (k * k + l * l - xx[0]),
        xc = half * xx[1],
        ys = -half * xy[0],
        yc = half * xy[1],
    ));
    sim.step(1.0).unwrap();
    value(&mut sim, "error/displacement")
}

/// How much the error depends on where the body lies: shifted through a cell in 50 steps, among them slivers down to 1e-8 of a cell, and turned by
/// 50 angles. Part of the change with the angle is that of splines without any cut, which are best along their axes.
#[test]
fn errors_hardly_depend_on_how_cells_are_cut() {
    for degree in [2, 3] {
        let shifted = (0..50).map(|k| {
            let by = if k % 2 == 0 { 0.03125 * f64::from(k) / 50.0 } else { 0.025 + 0.03125 * 10f64.powi(-(k / 6)) };
            ([by, 0.025 + by], 0.0)
        });
        let turned = (0..50).map(|k| ([0.1, 0.05], std::f64::consts::FRAC_PI_2 * f64::from(k) / 50.0));
        let all = |places: &mut dyn Iterator<Item = ([f64; 2], f64)>| -> Vec<f64> {
            places.map(|(place, angle)| anywhere(place, angle, degree)).collect()
        };
        for (name, errors) in [("shifted", all(&mut { shifted })), ("turned", all(&mut { turned }))] {
            let [low, high] = [errors.iter().copied().fold(f64::INFINITY, f64::min), errors.iter().copied().fold(0.0, f64::max)];
            println!("degree {degree}, {name}: errors from {low:e} to {high:e} m, {:.2} times", high / low);
            // measured 1.80, 1.56, 1.02, 1.96; with cells twice and four times as large 2.3, 1.6, 1.05, 2.3 and 3.5, 2.1, 1.2, 3.0
            assert!(high < 2.0 * low, "degree {degree}, {name}");
        }
    }
}

/// On a grid that is fitted to a body, a held face is the nodes of that face.
#[test]
fn a_held_face_of_a_box_is_that_of_its_grid() {
    let tip = |boundary: &str, shape: &str| {
        let mut sim = build(&format!(
            r#"
            title = "cantilever"
            dimension = 2
            grid = {{ origin = [0, 0], size = [4, 4], cell = 0.5 }}
            material.m = {{ law = "neo_hookean", young = 100.0, poisson = 0.3, density = 1.0 }}
            body.beam = {{ material = "m", shape = {shape} }}
            boundary.root = {{ {boundary}, fixed = ["x", "y"] }}
            load.weight.gravity = [0, -0.1]
            probe.tip = {{ at = [3, 1] }}
            method = {{ formulation = "total", degree = 2 }}
            time = {{ end = 1.0 }}
            "#
        ));
        sim.step(0.5).unwrap();
        value(&mut sim, "energy/strain")
    };
    let region = tip("face = \"x-\"", "{ box = { min = [0, 0], max = [3, 1] } }");
    assert!(region > 0.0);
    assert_eq!(region, tip("surface = { body = \"beam\", face = \"x-\" }", "{ box = { min = [0, 0], max = [3, 1] } }"));
    let bent = tip("surface = { body = \"beam\", face = \"edge4\" }", "{ polygon = { points = [[0, 0], [3, 0], [3, 1], [0, 1]] } }");
    assert!((region - bent).abs() < 1e-9 * region, "the same grid, by way of a map: {region} {bent}");
}

/// What cannot be cut says so.
#[test]
fn shapes_without_an_outline_say_why() {
    let scene = |shape: &str, more: &str| {
        Scene::from_toml(&format!(
            r#"
            title = "shapes"
            dimension = 2
            grid = {{ origin = [0, 0], size = [4, 4], cell = 0.5 }}
            material.m = {{ law = "neo_hookean", young = 100.0, density = 1.0 }}
            body.b = {{ material = "m", shape = {shape} }}
            {more}
            method = {{ formulation = "total" }}
            time = {{ end = 1.0 }}
            "#
        ))
        .unwrap()
    };
    let grid = |shape: &str| {
        let described = scene(shape, "").build().unwrap().describe();
        described.method.iter().find(|(name, _)| *name == "grid").unwrap().1.clone()
    };
    let disk = "{ disk = { center = [2, 2], radius = 1 } }";
    assert!(grid(disk).contains("cut by its edge") && grid(disk).contains("extended B-splines"), "{}", grid(disk));
    assert_eq!(grid("{ box = { min = [0, 0], max = [1, 1] } }"), "fitted to its faces");
    let union = format!("{{ union = [{disk}, {{ box = {{ min = [2, 2], max = [4, 3] }} }}] }}");
    assert!(grid(&union).contains("unions have no outline"), "{}", grid(&union));
    let held = "boundary.h = { surface = { body = \"b\", face = \"1/outer\" }, fixed = [\"x\"] }";
    let fault = scene(&union, held).build().err().unwrap().to_string();
    assert!(fault.contains("unions have no outline") && fault.contains("boundary.h.surface"), "{fault}");
}

/// A uniform stress on a rectangle askew: u = d s along its axis s, held at s = 0, dead tractions P N on the other sides.
#[test]
fn a_patch_is_exact() {
    let angle = 0.4f64;
    let (n, d) = ([angle.cos(), angle.sin()], [0.12, -0.07]);
    // F = 1 + d (x) n, P = mu (F - F^-T) with F^-T = 1 - n (x) d / (1 + n . d)
    let mu = 50.0;
    let inner = 1.0 + n[0] * d[0] + n[1] * d[1];
    let piola = |i: usize, j: usize| mu * (d[i] * n[j] + n[i] * d[j] / inner);
    let traction = |normal: [f64; 2]| [0, 1].map(|i| piola(i, 0) * normal[0] + piola(i, 1) * normal[1]);
    let sides = [(1, [n[1], -n[0]]), (2, [n[1], -n[0]]), (3, n), (4, [-n[1], n[0]])];
    let loads: String = sides
        .iter()
        .map(|(k, normal)| format!("load.l{k}.traction = {{ body = \"block\", face = \"edge{k}\", value = {:?} }}\n", traction(*normal)))
        .collect();
    for degree in [1, 3] {
        let mut sim = build(&format!(
            r#"
            title = "patch"
            dimension = 2
            grid = {{ origin = [-2, -2], size = [4, 4], cell = 0.25 }}
            material.m = {{ law = "neo_hookean", young = 100.0, density = 1.0 }}
            body.block = {{ material = "m", shape = {{ polygon = {{ points = {corners} }} }} }}
            boundary.root = {{ surface = {{ body = "block", face = "edge5" }}, fixed = ["x", "y"] }}
            {loads}
            method = {{ formulation = "total", degree = {degree}, integrator = "quasi_static", newton_residual = 1e-13 }}
            time = {{ end = 1.0, step = 1.0 }}
            exact = {{ displacement = ["{dx}*({nx}*(x-0.03)+{ny}*(y-0.07))", "({dy})*({nx}*(x-0.03)+{ny}*(y-0.07))"] }}
            "#,
            corners = rectangle([0.03, 0.07], angle),
            dx = d[0],
            dy = d[1],
            nx = n[0],
            ny = n[1],
        ));
        sim.step(1.0).unwrap();
        let error = value(&mut sim, "error/displacement");
        let reaction = sim.get("boundary/root/reaction").unwrap().to_vec();
        let exact = traction([-n[0], -n[1]]).map(|t| 0.7 * t);
        println!("patch, degree {degree}: {error:e} m, reaction {reaction:?} N of {exact:?} N");
        // what Newton's method may leave: 1e-13 of the forces, times the condition of the stiffness, below 1e5
        assert!(error < 1e-8 * 0.14);
        assert!((0..2).all(|a| (reaction[a] - exact[a]).abs() < 1e-8 * mu));
    }
}

/// A free plate with a hole, with spin and stretch, explicit: momenta to round-off, energy without drift.
#[test]
fn momentum_and_energy_are_kept() {
    for mass in ["consistent", "lumped"] {
        let mut sim = build(&format!(
            r#"
            title = "free"
            dimension = 2
            grid = {{ origin = [-0.9, -0.9], size = [1.8, 1.8], cell = 0.15 }}
            material.m = {{ law = "neo_hookean", young = 1e4, poisson = 0.3, density = 10.0 }}
            body.plate = {{ material = "m", shape = {{ difference = [{{ disk = {{ center = [0.03, 0.01], radius = 0.7 }} }}, {{ disk = {{ center = [0.1, 0.2], radius = 0.25 }} }}] }}, velocity = ["1-3*y+x*y", "2+3*x"] }}
            method = {{ formulation = "total", degree = 3, mass = "{mass}" }}
            time = {{ end = 1.0, cfl = 0.5 }}
            "#
        ));
        let read = |sim: &mut Simulation| {
            let linear = sim.get("momentum/linear").unwrap().to_vec();
            [linear[0], linear[1], value(sim, "momentum/angular"), value(sim, "energy/kinetic") + value(sim, "energy/strain")]
        };
        let start = read(&mut sim);
        let mut drift = [0.0f64; 4];
        for _ in 0..10 {
            sim.step(0.02).unwrap();
            let now = read(&mut sim);
            (0..4).for_each(|k| drift[k] = drift[k].max(((now[k] - start[k]) / start[k]).abs()));
        }
        println!("{mass}: momenta and energy off by {drift:?}");
        // round-off of some thousand steps; the energy of Verlet's scheme swings with the square of the step
        assert!(drift[..3].iter().all(|d| *d < 1e-11) && drift[3] < 1e-3, "{mass}: {drift:?}");
    }
}

/// A block whose held face moves, with the velocity of that face: nothing is strained.
#[test]
fn a_held_face_carries_its_body_along() {
    let mut sim = build(&format!(
        r#"
        title = "carried"
        dimension = 2
        grid = {{ origin = [-2, -2], size = [4, 4], cell = 0.25 }}
        material.m = {{ law = "neo_hookean", young = 100.0, poisson = 0.3, density = 1.0 }}
        body.block = {{ material = "m", shape = {{ polygon = {{ points = {} }} }}, velocity = [0.3, -0.2] }}
        boundary.root = {{ surface = {{ body = "block", face = "edge5" }}, velocity = {{ x = 0.3, y = -0.2 }} }}
        method = {{ formulation = "total", degree = 3 }}
        time = {{ end = 1.0 }}
        exact = {{ displacement = ["0.3*t", "-0.2*t"] }}
        "#,
        rectangle([0.03, 0.07], 0.4)
    ));
    sim.step(0.5).unwrap();
    let (error, energy) = (value(&mut sim, "error/displacement"), value(&mut sim, "energy/strain"));
    println!("carried: {error:e} m, {energy:e} J");
    // round-off of a path of 0.18 m in some hundred steps, and of the stored energy, beside the modulus times the area
    assert!(error < 1e-12 && energy < 1e-12 * 100.0 * 0.77);
}
