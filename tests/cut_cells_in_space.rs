//! Bodies in space whose surface cuts the cells of their grid, in the total formulation: against exact solutions.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use matpoint::Simulation;
use matpoint::scene::Scene;

fn build(text: &str) -> Simulation {
    Scene::from_toml(text).unwrap().build().unwrap()
}

fn value(sim: &mut Simulation, name: &str) -> f64 {
    sim.get(name).unwrap()[0]
}

/// Errors of displacement and stress on some cells, and the orders from the first to the last.
fn converges(name: &str, degree: usize, cells: &[f64], errors: impl Fn(f64) -> [f64; 2]) -> [f64; 2] {
    let started = std::time::Instant::now();
    let errors: Vec<[f64; 2]> = cells.iter().map(|cell| errors(*cell)).collect();
    let n = cells.len() - 1;
    let orders = [0, 1].map(|k| (errors[0][k] / errors[n][k]).ln() / (cells[0] / cells[n]).ln());
    println!(
        "{name}, degree {degree}, cells {cells:?}: displacement {:?} m, stress {:?} Pa; orders {orders:.2?}; {:.1} s",
        errors.iter().map(|e| e[0]).collect::<Vec<_>>(),
        errors.iter().map(|e| e[1]).collect::<Vec<_>>(),
        started.elapsed().as_secs_f64()
    );
    orders
}

/// A hollow sphere with radii 0.5 and 1, bonded to a rigid core and pulled outside: u = (A + B / R^3) X with A + 8 B = 0 (Lame 1852), and a
/// traction 269.2308 A outside, at E = 100, nu = 0.3: lambda = 750 / 13, mu = 500 / 13.
fn hollow(cell: f64, degree: usize) -> [f64; 2] {
    let (lambda, mu) = (750.0 / 13.0, 500.0 / 13.0);
    let a = 0.01;
    let b = -a / 8.0;
    let pull = (3.0 * lambda + 2.0 * mu) * a - 4.0 * mu * b;
    let r = "sqrt(x^2+y^2+z^2)";
    let u = format!("({a}+({b})/{r}^3)");
    let normal = |x: &str| format!("{}+{}*({u}-3*({b})*{x}^2/{r}^5)", 3.0 * lambda * a, 2.0 * mu);
    let shear = |x: &str, y: &str| format!("{}*{x}*{y}/{r}^5", -6.0 * mu * b);
    let mut sim = build(&format!(
        r#"
        title = "hollow sphere"
        dimension = 3
        grid = {{ origin = [-1.23, -1.23, -1.23], size = [{size}, {size}, {size}], cell = {cell} }}
        material.m = {{ law = "linear_elastic", young = 100.0, poisson = 0.3, density = 1.0 }}
        body.b = {{ material = "m", shape = {{ difference = [{{ sphere = {{ center = [0, 0, 0], radius = 1 }} }}, {{ sphere = {{ center = [0, 0, 0], radius = 0.5 }} }}] }} }}
        boundary.core = {{ surface = {{ body = "b", face = "2/outer" }}, fixed = ["x", "y", "z"] }}
        load.pull.traction = {{ body = "b", face = "1/outer", value = ["{pull}*x/{r}", "{pull}*y/{r}", "{pull}*z/{r}"] }}
        method = {{ formulation = "total", degree = {degree}, integrator = "quasi_static" }}
        time = {{ end = 1.0, step = 1.0 }}
        [exact]
        displacement = ["{u}*x", "{u}*y", "{u}*z"]
        stress = {{ xx = "{xx}", yy = "{yy}", zz = "{zz}", xy = "{xy}", yz = "{yz}", xz = "{xz}" }}
        "#,
        size = cell * (2.5 / cell).ceil(),
        xx = normal("x"),
        yy = normal("y"),
        zz = normal("z"),
        xy = shear("x", "y"),
        yz = shear("y", "z"),
        xz = shear("x", "z"),
    ));
    let described = sim.describe();
    let grid = described.method.iter().find(|(name, _)| *name == "grid").unwrap().1.clone();
    println!("cell {cell}: {grid}");
    sim.step(1.0).unwrap();
    [value(&mut sim, "error/displacement"), value(&mut sim, "error/stress")]
}

#[test]
fn a_pulled_hollow_sphere_converges() {
    for degree in [2, 3] {
        let orders = converges("hollow sphere", degree, &[0.4, 0.25], |cell| hollow(cell, degree));
        // cells are as large as the wall, or half as large: orders of more than p + 1 and p, 3.4 to 4.7, are not those of small cells yet
        assert!(orders[0] >= degree as f64 + 1.0 && orders[1] >= degree as f64, "degree {degree}: {orders:?}");
    }
}

/// What happens to a ball of radius 0.5: displacement a g(R) X with g = c0 + c2 R^2 + c4 R^4 and a = 0.3 sin(100 pi t).
#[derive(Clone, Copy)]
struct Ball {
    g: [f64; 3],
    held: bool,
}

/// u_R' = g + R g' vanishes at R = 0.5.
const FREE: Ball = Ball { g: [1.0, -4.0, 6.4], held: false };
/// u vanishes there.
const HELD: Ball = Ball { g: [1.0, -2.0, -8.0], held: true };

/// A manufactured vibration of a ball. At nu = 0 the stress is E times the strain, and of a displacement without curl its divergence is
/// E grad div u, so that the acceleration a'' g X - E / rho (10 c2 + 28 c4 R^2) a X is missing. E = 1e7 and rho = 1000.
fn ball(case: Ball, cell: f64, degree: usize, end: f64) -> [f64; 2] {
    let Ball { g: [c0, c2, c4], held } = case;
    let (a, s) = ("(.3*sin(100*PI*t))", "(x^2+y^2+z^2)");
    let g = format!("({c0}+({c2})*{s}+({c4})*{s}^2)");
    let force = format!("{a}*(-1e4*PI^2*{g}-1e4*({}+({})*{s}))", 10.0 * c2, 28.0 * c4);
    // grad u = a (g 1 + (2 c2 + 4 c4 R^2) X X)
    let slope = format!("(2*({c2})+4*({c4})*{s})");
    let normal = |x: &str| format!("1e7*{a}*({g}+{slope}*{x}^2)");
    let shear = |x: &str, y: &str| format!("1e7*{a}*{slope}*{x}*{y}");
    let boundary = if held { r#"boundary.h = { surface = { body = "b", face = "outer" }, fixed = ["x", "y", "z"] }"# } else { "" };
    let mut sim = build(&format!(
        r#"
        title = "ball"
        dimension = 3
        grid = {{ origin = [-0.61, -0.61, -0.61], size = [{size}, {size}, {size}], cell = {cell} }}
        material.m = {{ law = "linear_elastic", young = 1e7, density = 1000 }}
        body.b = {{ material = "m", shape = {{ sphere = {{ center = [0, 0, 0], radius = 0.5 }} }}, velocity = ["30*PI*{g}*x", "30*PI*{g}*y", "30*PI*{g}*z"] }}
        {boundary}
        load.source.body_force = {{ body = "b", value = ["{force}*x", "{force}*y", "{force}*z"] }}
        method = {{ formulation = "total", degree = {degree}, integrator = "symplectic4" }}
        time = {{ end = 1.0, cfl = 0.8 }}
        [exact]
        displacement = ["{a}*{g}*x", "{a}*{g}*y", "{a}*{g}*z"]
        stress = {{ xx = "{xx}", yy = "{yy}", zz = "{zz}", xy = "{xy}", yz = "{yz}", xz = "{xz}" }}
        "#,
        size = cell * (1.25 / cell).ceil(),
        xx = normal("x"),
        yy = normal("y"),
        zz = normal("z"),
        xy = shear("x", "y"),
        yz = shear("y", "z"),
        xz = shear("x", "z"),
    ));
    let steps = sim.step(end).unwrap().substeps;
    println!("cell {cell}: {} points, {steps} steps", sim.get("particle/volume").unwrap().len());
    [value(&mut sim, "error/displacement"), value(&mut sim, "error/stress")]
}

fn vibrates(name: &str, case: Ball) {
    for degree in [2, 3] {
        let orders = converges(name, degree, &[0.2, 0.125], |cell| ball(case, cell, degree, 0.001));
        // p + 1 and p, as far as balls of ten and sixteen cells show it (measured: 2.97 and 1.82 at least for degree 2)
        assert!(orders[0] >= degree as f64 + 0.8 && orders[1] >= degree as f64 - 0.3, "{name}, degree {degree}: {orders:?}");
    }
}

#[test]
fn a_free_vibrating_ball_converges() {
    vibrates("free ball", FREE);
}

#[test]
fn a_held_vibrating_ball_converges() {
    vibrates("held ball", HELD);
}

/// A uniform stress on a box askew with a hole askew: u = d s along its first axis s, held at s = 0, dead tractions P N on all other faces.
#[test]
fn a_patch_in_space_is_exact() {
    let axis = [0.6, 0.0, 0.8];
    let frame = [[0.48, 0.8, -0.36], [-0.64, 0.6, 0.48], axis];
    let (n, d) = (frame[0], [0.12, -0.07, 0.05]);
    // F = 1 + d (x) n, P = mu (F - F^-T) with F^-T = 1 - n (x) d / (1 + n . d)
    let mu = 50.0;
    let inner = 1.0 + (0..3).map(|a| n[a] * d[a]).sum::<f64>();
    let traction = |normal: [f64; 3]| [0, 1, 2].map(|i| (0..3).map(|j| mu * (d[i] * n[j] + n[i] * d[j] / inner) * normal[j]).sum::<f64>());
    let (mut parts, mut loads) = ([String::new(), String::new()], String::new());
    for (part, low, high) in [(0, [0.0; 3], [1.1, 0.7, 0.9]), (1, [0.3; 3], [0.7, 0.45, 0.6])] {
        for k in 0..6 {
            let (axis, upper) = (k / 2, k % 2 == 1);
            let out = frame[axis].map(|x| if upper { x } else { -x });
            let along = if upper { high[axis] } else { low[axis] };
            let point = [0, 1, 2].map(|a| along * frame[axis][a] - 0.3);
            parts[part] += &format!("{{ half_space = {{ point = {point:?}, normal = {out:?} }} }}, ");
            if (part, k) != (0, 0) {
                let value = traction(out.map(|x| if part == 0 { x } else { -x }));
                let face = format!("{}/{}/plane", part + 1, k + 1);
                loads += &format!("load.l{part}{k}.traction = {{ body = \"block\", face = \"{face}\", value = {value:?} }}\n");
            }
        }
    }
    let start = (0..3).map(|a| -0.3 * n[a]).sum::<f64>();
    let s = format!("(({})*x+({})*y+({})*z-({start}))", n[0], n[1], n[2]);
    for degree in [1, 2] {
        let mut sim = build(&format!(
            r#"
            title = "patch"
            dimension = 3
            grid = {{ origin = [-2, -2, -2], size = [4, 4, 4], cell = 0.25 }}
            material.m = {{ law = "neo_hookean", young = 100.0, density = 1.0 }}
            body.block = {{ material = "m", shape = {{ difference = [{{ intersection = [{}] }}, {{ intersection = [{}] }}] }} }}
            boundary.root = {{ surface = {{ body = "block", face = "1/1/plane" }}, fixed = ["x", "y", "z"] }}
            {loads}
            method = {{ formulation = "total", degree = {degree}, integrator = "quasi_static", newton_residual = 1e-13 }}
            time = {{ end = 1.0, step = 1.0 }}
            exact = {{ displacement = ["{}*{s}", "({})*{s}", "{}*{s}"] }}
            "#,
            parts[0], parts[1], d[0], d[1], d[2],
        ));
        sim.step(1.0).unwrap();
        let error = value(&mut sim, "error/displacement");
        let reaction = sim.get("boundary/root/reaction").unwrap().to_vec();
        let exact = traction(n.map(|x| -x)).map(|t| 0.63 * t);
        println!("patch, degree {degree}: {error:e} m, reaction {reaction:?} N of {exact:?} N");
        // what Newton's method may leave: 1e-13 of the forces, times the condition of the stiffness, below 1e5
        assert!(error < 1e-8 * 0.14);
        assert!((0..3).all(|a| (reaction[a] - exact[a]).abs() < 1e-8 * mu));
    }
}

/// What cuts cells, and what cannot be cut, says so.
#[test]
fn shapes_say_how_their_grid_fits() {
    let scene = |shape: &str, more: &str| {
        Scene::from_toml(&format!(
            r#"
            title = "shapes"
            dimension = 3
            grid = {{ origin = [0, 0, 0], size = [4, 4, 4], cell = 0.5 }}
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
    let ball = |x: f64, radius: f64| format!("{{ sphere = {{ center = [{x}, 2, 2], radius = {radius} }} }}");
    let cube = "{ box = { min = [0.5, 0.5, 0.5], max = [3.5, 3.5, 3.5] } }";
    let cut = "{ half_space = { point = [3, 3, 3], normal = [1, 1, 1] } }";
    assert_eq!(grid(cube), "fitted to its faces");
    for shape in [
        ball(2.0, 1.3),
        format!("{{ intersection = [{cube}, {cut}] }}"),
        format!("{{ difference = [{cube}, {}, {}] }}", ball(1.5, 0.4), ball(2.5, 0.4)),
    ] {
        assert!(grid(&shape).contains("cut by its surface") && grid(&shape).contains("extended B-splines"), "{}", grid(&shape));
    }
    for (shape, why) in [
        (format!("{{ union = [{cube}, {}] }}", ball(2.0, 1.0)), "unions have no outline"),
        (format!("{{ intersection = [{cube}, {}] }}", ball(2.0, 1.0)), "boxes and half-spaces"),
        (format!("{{ difference = [{cube}, {}] }}", ball(0.5, 1.0)), "touches its surface"),
        (format!("{{ difference = [{cube}, {}, {}] }}", ball(1.5, 0.6), ball(2.5, 0.6)), "another hole"),
    ] {
        assert!(grid(&shape).contains(why), "{}", grid(&shape));
    }
    let held = "boundary.h = { surface = { body = \"b\", face = \"1/x-\" }, fixed = [\"x\"] }";
    let fault = scene(&format!("{{ union = [{cube}, {}] }}", ball(2.0, 1.0)), held).build().err().unwrap().to_string();
    assert!(fault.contains("unions have no outline") && fault.contains("boundary.h.surface"), "{fault}");
}

/// A body of half-spaces alone ends where they meet, and the plane of one carries a load in both formulations.
#[test]
fn half_spaces_alone_are_a_body_with_faces() {
    // a tetrahedron with a corner at (0.5, 0.5, 0.5) and edges of 2
    let sides =
        ["[-1, 0, 0]", "[0, -1, 0]", "[0, 0, -1]"].map(|n| format!("{{ half_space = {{ point = [0.5, 0.5, 0.5], normal = {n} }} }}"));
    let shape =
        format!("{{ intersection = [{}, {{ half_space = {{ point = [2.5, 0.5, 0.5], normal = [2, 2, 2] }} }}] }}", sides.join(", "));
    for (method, tolerance) in [
        // round-off
        ("formulation = \"total\"", 1e-12),
        // particles of an eighth of a cell, and points of the face as far apart
        ("basis = \"linear\"", 0.05),
    ] {
        let mut sim = build(&format!(
            r#"
            title = "tetrahedron"
            dimension = 3
            grid = {{ origin = [0, 0, 0], size = [4, 4, 4], cell = 0.25 }}
            material.m = {{ law = "neo_hookean", young = 100.0, density = 3.0 }}
            body.b = {{ material = "m", shape = {shape} }}
            load.push.traction = {{ body = "b", face = "4/plane", value = [0, 0, 0.5] }}
            method = {{ {method} }}
            time = {{ end = 1.0 }}
            "#
        ));
        let mass: f64 = sim.get("particle/mass").unwrap().iter().sum();
        sim.step(0.01).unwrap();
        let momentum = sim.get("momentum/linear").unwrap()[2];
        // volume 8 / 6, area 2 sqrt(3)
        let push = 0.5 * 2.0 * 3f64.sqrt() * 0.01;
        println!("{method}: mass {mass}, momentum {momentum} of {push}");
        assert!((mass - 4.0).abs() < 4.0 * tolerance && (momentum - push).abs() < push * tolerance);
    }
}
