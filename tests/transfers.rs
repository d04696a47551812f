//! XPIC(m) and ASFLIP: the equations of their papers written out once more, for a bar; and what ASFLIP is for.

#![allow(clippy::unwrap_used, reason = "a test may panic")]

use matpoint::Simulation;
use matpoint::scene::Scene;
use std::f64::consts::PI;

const CELL: f64 = 0.25;
const YOUNG: f64 = 100.0;
const STEP: f64 = 0.002;

/// A free bar between 4 and 6 that moves and vibrates, three particles a cell at random places, quadratic B-splines. Lumping of nearly
/// empty nodes, which no paper has, is off.
fn bar(method: &str) -> Simulation {
    bar_in(CELL, method)
}

/// The same in cells of any size \[m\].
fn bar_in(cell: f64, method: &str) -> Simulation {
    let tolerance = if method.contains("fmpm") { ", mass_tolerance = 0" } else { "" };
    let text = format!(
        r#"
        title = "bar"
        dimension = 1
        grid = {{ origin = [0], size = [10], cell = {cell} }}
        material.m = {{ law = "linear_elastic", young = {YOUNG}, density = 1 }}
        method = {{ {method}{tolerance} }}
        body.b = {{ material = "m", shape = {{ box = {{ min = [4], max = [6] }} }}, particles_per_cell = 3, positions = "jittered",
                    velocity = ["1+0.4*sin(3*x)+0.1*sin(17*x)"] }}
        time = {{ end = 9, step = {STEP} }}
        "#
    );
    Scene::from_toml(&text).unwrap().build().unwrap_or_else(|e| panic!("{method}: {e}"))
}

/// Particles as the papers have them.
struct Particles {
    /// Size of the cells \[m\].
    cell: f64,
    x: Vec<f64>,
    /// Velocity, and its slope where the scheme has one.
    v: Vec<f64>,
    c: Vec<f64>,
    stress: Vec<f64>,
    /// Volume ratio.
    ratio: Vec<f64>,
    mass: Vec<f64>,
}

/// Shape functions at the particles: S maps from the grid to them.
struct Shapes {
    first: Vec<usize>,
    weight: Vec<[f64; 3]>,
    slope: Vec<[f64; 3]>,
    /// From a particle to its nodes \[m\].
    arm: Vec<[f64; 3]>,
    /// Mass of the nodes.
    mass: Vec<f64>,
}

/// Nodes of the finest grid.
const NODES: usize = 82;
type Nodes = [f64; NODES];

impl Particles {
    fn of(sim: &mut Simulation, cell: f64) -> Self {
        let [x, v, mass] = ["particle/position", "particle/velocity", "particle/mass"].map(|name| sim.get(name).unwrap().to_vec());
        let n = x.len();
        // the slope of the velocity of `bar`
        let c = x.iter().map(|x| 1.2 * (3.0 * x).cos() + 1.7 * (17.0 * x).cos()).collect();
        Self { cell, x, v, c, stress: vec![0.0; n], ratio: vec![1.0; n], mass }
    }

    fn shapes(&self) -> Shapes {
        let mut s = Shapes { first: vec![], weight: vec![], slope: vec![], arm: vec![], mass: vec![0.0; NODES] };
        for x in &self.x {
            // nodes are in the middle of cells, node 0 in the one before the grid
            let place = x / self.cell + 0.5;
            let near = place.round();
            let r = place - near;
            s.first.push(near as usize - 1);
            s.weight.push([0.5 * (0.5 - r).powi(2), 0.75 - r * r, 0.5 * (0.5 + r).powi(2)]);
            s.slope.push([r - 0.5, -2.0 * r, r + 0.5].map(|slope| slope / self.cell));
            s.arm.push([-1.0, 0.0, 1.0].map(|k| (k - r) * self.cell));
        }
        s.mass = s.sum(|p, k| self.mass[p] * s.weight[p][k]).to_vec();
        s
    }

    /// Acceleration of the nodes by the lumped mass.
    fn acceleration(&self, s: &Shapes) -> Nodes {
        // the density is 1: the volume at time 0 is the mass
        s.over_mass(s.sum(|p, k| -self.mass[p] * self.stress[p] * s.slope[p][k]))
    }

    /// What is measured at the time of the positions.
    fn velocity_now(&self, half: f64) -> Vec<f64> {
        let s = self.shapes();
        let pull = s.at(&self.acceleration(&s));
        self.v.iter().zip(pull).map(|(v, a)| v + half * a).collect()
    }

    fn strain(&mut self, s: &Shapes, nodes: &Nodes, dt: f64) {
        for (p, slope) in s.slope.iter().enumerate() {
            let rate: f64 = (0..3).map(|k| slope[k] * nodes[s.first[p] + k]).sum();
            self.stress[p] += YOUNG * dt * rate;
            self.ratio[p] *= 1.0 + dt * rate;
        }
    }
}

impl Shapes {
    fn sum(&self, f: impl Fn(usize, usize) -> f64) -> Nodes {
        let mut nodes = [0.0; NODES];
        for (p, first) in self.first.iter().enumerate() {
            (0..3).for_each(|k| nodes[first + k] += f(p, k));
        }
        nodes
    }
    fn over_mass(&self, mut nodes: Nodes) -> Nodes {
        nodes.iter_mut().zip(&self.mass).for_each(|(v, m)| *v = if *m > 0.0 { *v / m } else { 0.0 });
        nodes
    }
    /// S+: momentum over lumped mass.
    fn project(&self, mass: &[f64], values: &[f64]) -> Nodes {
        self.over_mass(self.sum(|p, k| mass[p] * values[p] * self.weight[p][k]))
    }
    /// S.
    fn at(&self, nodes: &Nodes) -> Vec<f64> {
        self.first.iter().zip(&self.weight).map(|(first, w)| (0..3).map(|k| w[k] * nodes[first + k]).sum()).collect()
    }
}

fn combine(a: f64, x: &Nodes, b: f64, y: &Nodes) -> Nodes {
    std::array::from_fn(|i| a * x[i] + b * y[i])
}

/// v* of XPIC(m): the sum over r = 2 to m of (-1)^r v*_r with v*_r = (m - r + 1) / r S+ S v*_(r-1) and v*_1 = v (Hammerquist and Nairn
/// 2017).
fn v_star(order: usize, particles: &Particles, s: &Shapes, v: &Nodes) -> Nodes {
    let (mut term, mut sum) = (*v, [0.0; NODES]);
    for r in 2..=order {
        let share = (order - r + 1) as f64 / r as f64;
        let back = s.project(&particles.mass, &s.at(&term));
        term = combine(share, &back, 0.0, &back);
        sum = combine(1.0, &sum, if r % 2 == 0 { 1.0 } else { -1.0 }, &term);
    }
    sum
}

/// The change of velocity of XPIC(m) over a kick: A dt = (1 - m) S a dt - V + m S v+ - m S v*, with v+ = v + a dt and a lumped mass.
fn xpic_change(order: usize, particles: &Particles, s: &Shapes, kick: f64) -> Vec<f64> {
    let m = order as f64;
    let v = s.project(&particles.mass, &particles.v);
    let a = particles.acceleration(s);
    let (pull, plus, star) = (s.at(&a), s.at(&combine(1.0, &v, kick, &a)), s.at(&v_star(order, particles, s, &v)));
    (0..particles.x.len()).map(|p| (1.0 - m) * kick * pull[p] - particles.v[p] + m * plus[p] - m * star[p]).collect()
}

fn largest_difference(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).fold(0.0, |m, (a, b)| m.max((a - b).abs()))
}

fn xpic_method(order: usize, integrator: &str) -> String {
    match order {
        1 => format!(r#"transfer = "pic", integrator = "{integrator}""#),
        m => format!(r#"mass = "fmpm", fmpm_order = {m}, balance_mass = "lumped", transfer = "pic", integrator = "{integrator}""#),
    }
}

/// Velocities are those of XPIC(m), m = 1 being PIC. Particles move, and are strained, in the field that their velocities come from (USL),
/// or in that of their new velocities (MUSL), as with any transfer of ours.
#[test]
fn pic_with_a_series_of_the_mass_matrix_is_xpic() {
    for order in [1, 2, 3, 5, 8] {
        for integrator in ["usl", "musl"] {
            let mut sim = bar(&xpic_method(order, integrator));
            let mut ours = Particles::of(&mut sim, CELL);
            let start = ours.x.clone();
            for step in 0..300 {
                let kick = if step == 0 { 0.5 * STEP } else { STEP };
                let s = ours.shapes();
                let (before, a) = (s.project(&ours.mass, &ours.v), ours.acceleration(&s));
                let series = |v: &Nodes, of: &Particles| {
                    let m = order as f64;
                    combine(m, v, -m, &v_star(order, of, &s, v))
                };
                let change = xpic_change(order, &ours, &s, kick);
                let mut field = combine(1.0, &series(&before, &ours), kick, &a);
                ours.v.iter_mut().zip(&change).for_each(|(v, c)| *v += c);
                if integrator == "musl" {
                    field = series(&s.project(&ours.mass, &ours.v), &ours);
                }
                let moves = s.at(&field);
                ours.x.iter_mut().zip(&moves).for_each(|(x, v)| *x += STEP * v);
                ours.strain(&s, &field, STEP);
                sim.step(STEP).unwrap();
                let velocity = ours.velocity_now(0.5 * STEP);
                let differences = [
                    largest_difference(sim.get("particle/velocity").unwrap(), &velocity),
                    largest_difference(sim.get("particle/position").unwrap(), &ours.x),
                ];
                // round-off of so many steps on numbers of order 1 to 10
                assert!(differences.iter().all(|d| *d < 1e-11), "XPIC({order}) {integrator}, step {step}: {differences:?}");
            }
            let moved = largest_difference(&ours.x, &start);
            let off = largest_difference(sim.get("particle/velocity").unwrap(), &ours.velocity_now(0.5 * STEP));
            println!("XPIC({order}) {integrator}: velocities differ by {off:.1e} m/s after {moved:.2} m");
        }
    }
}

/// The paper's motion X += S v dt + A dt^2 / 2 has V at the time of X, and takes the velocity of a lumped mass; ours is a leapfrog, and
/// takes that of the particle. What is between them is what the lumped mass smooths away, which goes with the cells.
#[test]
fn motion_tends_to_that_of_the_xpic_paper_as_cells_shrink() {
    let order = 5;
    let difference = |cell: f64| {
        let mut sim = bar_in(cell, &xpic_method(order, "usl"));
        let mut paper = Particles::of(&mut sim, cell);
        let start = paper.x.clone();
        for _ in 0..300 {
            let s = paper.shapes();
            let (v, a) = (s.project(&paper.mass, &paper.v), paper.acceleration(&s));
            let (slow, change) = (s.at(&v), xpic_change(order, &paper, &s, STEP));
            for p in 0..paper.x.len() {
                paper.x[p] += STEP * (slow[p] + 0.5 * change[p]);
                paper.v[p] += change[p];
            }
            paper.strain(&s, &combine(1.0, &v, STEP, &a), STEP);
            sim.step(STEP).unwrap();
        }
        let off = largest_difference(sim.get("particle/position").unwrap(), &paper.x);
        let moved = largest_difference(&paper.x, &start);
        println!("cells of {cell}: after {moved:.2} m particles are up to {off:.1e} m from where the paper's motion has them");
        off
    };
    let (coarse, fine) = (difference(CELL), difference(0.5 * CELL));
    assert!(coarse < 0.05 * CELL && fine < 0.6 * coarse, "{coarse} {fine}");
}

/// v_p = S v+ + alpha (v_p - S v), C as in APIC, x_p += dt (S v+ + alpha beta (v_p - S v)), beta = 0 where a particle is compressed (Fei et
/// al. 2021).
#[test]
fn asflip_is_that_of_its_paper() {
    let (alpha, beta) = (0.9, 0.7);
    let mut sim = bar(&format!(r#"transfer = "asflip", flip_share = {alpha}, separation = {beta}, integrator = "usl""#));
    let mut ours = Particles::of(&mut sim, CELL);
    let (mut apart, mut together) = (0, 0);
    for step in 0..300 {
        let kick = if step == 0 { 0.5 * STEP } else { STEP };
        let s = ours.shapes();
        let v = s.over_mass(s.sum(|p, k| s.weight[p][k] * ours.mass[p] * (ours.v[p] + ours.c[p] * s.arm[p][k])));
        let plus = combine(1.0, &v, kick, &ours.acceleration(&s));
        let (old, new) = (s.at(&v), s.at(&plus));
        for p in 0..ours.x.len() {
            let own = ours.v[p] - old[p];
            ours.v[p] = new[p] + alpha * own;
            // the second moment of quadratic B-splines is a quarter of a cell squared
            ours.c[p] = (0..3).map(|k| s.weight[p][k] * s.arm[p][k] * plus[s.first[p] + k]).sum::<f64>() / (0.25 * CELL * CELL);
            let free = ours.ratio[p] * (1.0 + STEP * ours.c[p]) >= 0.999;
            *(if free { &mut apart } else { &mut together }) += 1;
            ours.x[p] += STEP * (new[p] + if free { alpha * beta * own } else { 0.0 });
        }
        ours.strain(&s, &plus, STEP);
        sim.step(STEP).unwrap();
        let differences = [
            largest_difference(sim.get("particle/velocity").unwrap(), &ours.velocity_now(0.5 * STEP)),
            largest_difference(sim.get("particle/position").unwrap(), &ours.x),
        ];
        // round-off of so many steps on numbers of order 1 to 10
        assert!(differences.iter().all(|d| *d < 1e-11), "step {step}: {differences:?}");
    }
    println!("{apart} motions of particles that are not compressed, {together} of others");
    assert!(apart > 1000 && together > 1000, "both happen");
}

#[test]
fn asflip_without_flip_is_apic() {
    for integrator in ["usl", "usf"] {
        let run = |transfer: &str| {
            let mut sim = bar(&format!(r#"transfer = {transfer}, integrator = "{integrator}""#));
            sim.step(0.5).unwrap();
            ["particle/position", "particle/velocity", "particle/stress"].map(|name| sim.get(name).unwrap().to_vec())
        };
        let (asflip, apic) = (run(r#""asflip", flip_share = 0"#), run(r#""apic""#));
        for (ours, theirs) in asflip.iter().zip(&apic) {
            let largest = theirs.iter().fold(0.0f64, |m, v| m.max(v.abs()));
            // APIC alone sums forces with the momenta they change: the same but for the round-off of so many steps
            assert!(largest_difference(ours, theirs) < 1e-12 * largest, "{integrator}");
        }
    }
}

/// Energy left of a bar after ten periods of its first mode.
#[test]
fn asflip_keeps_more_of_a_vibration_than_apic() {
    let left = |transfer: &str, integrator: &str| {
        let text = format!(
            r#"
            title = "vibration"
            dimension = 1
            grid = {{ origin = [-1], size = [4], cell = 0.125 }}
            material.m = {{ law = "linear_elastic", young = 100, density = 1 }}
            method = {{ transfer = {transfer}, integrator = "{integrator}" }}
            body.b = {{ material = "m", shape = {{ box = {{ min = [0], max = [2] }} }}, velocity = ["0.05*cos(PI*x/2)"] }}
            time = {{ end = 9, cfl = 0.4 }}
            "#
        );
        let mut sim = Scene::from_toml(&text).unwrap().build().unwrap();
        let start = sim.get("energy/total").unwrap()[0];
        sim.step(4.0).unwrap();
        sim.get("energy/total").unwrap()[0] / start
    };
    for integrator in ["usf", "usl"] {
        let [apic, affine, separable, flip] =
            [r#""apic""#, r#""asflip", separation = 0"#, r#""asflip""#, r#""flip""#].map(|transfer| left(transfer, integrator));
        println!(
            "{integrator}: energy left after 10 periods: APIC {apic:.5}, ASFLIP {separable:.5} (separation 0: {affine:.5}), FLIP {flip:.5}"
        );
        assert!(apic < affine && apic < separable, "{integrator}");
        // USL takes energy itself, of FLIP more than of others
        assert!(integrator == "usl" || affine < flip && separable < flip, "{integrator}");
    }
}

/// A square that turns once about its middle, with elastic waves in it. What ASFLIP leaves with the particles has a moment of its own: it
/// does not keep angular momentum as APIC does, but loses some hundred times less of it than FLIP.
#[test]
fn angular_momentum_of_a_turning_square() {
    let drift = |transfer: &str, integrator: &str| {
        let text = format!(
            r#"
            title = "turning"
            dimension = 2
            grid = {{ origin = [-2, -2], size = [4, 4], cell = 0.125 }}
            material.m = {{ law = "neo_hookean", young = 1e3, poisson = 0.3, density = 1 }}
            method = {{ transfer = {transfer}, integrator = "{integrator}" }}
            [body.b]
            material = "m"
            shape = {{ box = {{ min = [-0.5, -0.5], max = [0.5, 0.5] }} }}
            velocity = ["-3*y+0.5*sin(9*x)", "3*x"]
            [time]
            end = 9
            cfl = 0.4
            "#
        );
        let mut sim = Scene::from_toml(&text).unwrap().build().unwrap();
        let spin = |sim: &mut Simulation| (sim.get("momentum/angular").unwrap()[0], sim.get("energy/total").unwrap()[0]);
        let start = spin(&mut sim);
        sim.step(2.0 * PI / 3.0).unwrap();
        let end = spin(&mut sim);
        (end.0 / start.0 - 1.0, end.1 / start.1)
    };
    for integrator in ["usf", "usl"] {
        let [apic, affine, separable, flip] =
            [r#""apic""#, r#""asflip", separation = 0"#, r#""asflip""#, r#""flip""#].map(|transfer| drift(transfer, integrator));
        println!(
            "{integrator}: angular momentum changes by APIC {:.1e}, ASFLIP {:.1e} (separation 0: {:.1e}), FLIP {:.1e} in one turn; energy \
             left {:.4}, {:.4} ({:.4}), {:.4}",
            apic.0, separable.0, affine.0, flip.0, apic.1, separable.1, affine.1, flip.1
        );
        assert!(apic.0.abs() < 1e-9, "{integrator}");
        assert!(affine.0.abs() < 0.05 * flip.0.abs() && separable.0.abs() < 0.05 * flip.0.abs(), "{integrator}");
    }
}

/// Two bars end to end in one velocity field are pulled apart: the grid holds them together as long as they share nodes.
#[test]
fn bodies_part_more_easily_with_their_own_velocity() {
    let speed = |transfer: &str| {
        let text = format!(
            r#"
            title = "parting"
            dimension = 1
            grid = {{ origin = [-4], size = [8], cell = 0.125 }}
            material.m = {{ law = "neo_hookean", young = 10, density = 1 }}
            method = {{ transfer = {transfer}, integrator = "usl" }}
            body.left = {{ material = "m", shape = {{ box = {{ min = [-1], max = [0] }} }}, velocity = [-0.5] }}
            body.right = {{ material = "m", shape = {{ box = {{ min = [0], max = [1] }} }}, velocity = [0.5] }}
            time = {{ end = 9, cfl = 0.4 }}
            "#
        );
        let mut sim = Scene::from_toml(&text).unwrap().build().unwrap();
        let first = |sim: &mut Simulation| {
            let bodies = sim.get("particle/body").unwrap().to_vec();
            let (v, m) = (sim.get("particle/velocity").unwrap().to_vec(), sim.get("particle/mass").unwrap());
            (0..v.len()).filter(|p| bodies[*p] == 0.0).map(|p| -m[p] * v[p]).sum::<f64>()
        };
        let start = first(&mut sim);
        sim.step(2.0).unwrap();
        first(&mut sim) / start
    };
    let [apic, affine, separable, flip] = [r#""apic""#, r#""asflip", separation = 0"#, r#""asflip""#, r#""flip""#].map(speed);
    println!("momentum that a bar keeps: APIC {apic:.3}, ASFLIP {separable:.3} (separation 0: {affine:.3}), FLIP {flip:.3}");
    assert!(separable > affine && separable > apic);
}

/// Next to a boundary particles go with the grid: their own velocity knows nothing of it.
#[test]
fn particles_do_not_pass_a_held_face() {
    let scenes = [include_str!("../launch_scripts/scenes/follower_beam.toml"), include_str!("../launch_scripts/scenes/twist_3d.toml")];
    for (scene, integrator) in scenes.into_iter().flat_map(|scene| ["usl", "usf"].map(|integrator| (scene, integrator))) {
        let text: String = scene.lines().filter(|line| !line.starts_with("integrator")).map(|line| format!("{line}\n")).collect();
        let text = text.replace("transfer = \"apic\"", &format!("integrator = \"{integrator}\"\ntransfer = \"asflip\""));
        let scene = Scene::from_toml(&text).unwrap();
        let (title, end) = (scene.title.clone(), scene.time.end);
        scene.build().unwrap().step(end).unwrap_or_else(|e| panic!("{title} {integrator}: {e}"));
    }
}
