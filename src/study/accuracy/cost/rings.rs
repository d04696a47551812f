//! B6 and B7: rings whose edges cut cells, held and free.

use super::{Kind, Method, Race, Required, TOTAL, UPDATED, known, particles};
use std::f64::consts::PI;

const RADIUS: &str = "sqrt(x^2+y^2)";
const END6: f64 = 0.25;
const END7: f64 = 0.005;

pub(in super::super) const B6: Race = Race {
    id: "B6",
    title: "generalised vortex between walls that cut cells: run time against error",
    heading: "B6, the generalised vortex",
    text: "A ring between two walls at R = 0.75 and 1.25 m, to which it sticks and which cut cells; its particles turn by g(t) h(R), at most 0.2 \
           rad, with h = 1 - 32 (R - 1)^2 + 256 (R - 1)^4, g = 0.2 sin(pi t), and the body force that this takes in neo-Hookean rubber, E = 1000 Pa, \
           nu = 0.3, 1000 kg/m3; at 0.25 s. 3 particles a cell and axis. Ours are held at the faces of the ring. Classical methods cannot hold a curved \
           wall: as users do, all nodes (Greville points of B-splines) on and beyond a wall are held, and their particles stand on a lattice, \
           where they lie in the ring. Steps of the updated formulation are 8 ms with 8 cells a metre, else as the square of the cell. Stress: \
           its components xx and xy.",
    cells: "cells a metre",
    end: END6,
    forms: &[("", "")],
    ours: &[(&UPDATED, [&[8, 12], &[8, 12, 16, 24]]), (&TOTAL, [&[], &[8, 12]])],
    classical: [&[8, 16], &[8, 16, 32, 48]],
    step: |cells| 8e-3 * (8.0 / cells as f64).powi(2),
    scene: vortex,
    errors: known,
    required: &[Required { method: &UPDATED, at: None, orders: &[3.0, 2.0], from: 8 }],
    shorter: None,
};

pub(in super::super) const B7: Race = Race {
    id: "B7",
    title: "expanding ring with free curved edges: run time against error",
    heading: "B7, the expanding ring",
    text: "A ring of 0.4 to 0.6 m, free on both sides, whose particles move along their radii by A sin(pi c t) (c1 + c2 R + c3 R^2) R, A = 0.1, \
           without traction on both edges, which cut cells; neo-Hookean rubber, E = 1e7 Pa, nu = 0, 1000 kg/m3, c = 100 m/s; at 5 ms, where they \
           are the farthest out, with stretches up to 1.26. 3 particles a cell and axis; those of classical methods on a lattice, where they lie in the ring. \
           Steps of the updated formulation are 25 us with 20 cells a metre, else as the square of the cell. Stress: its components xx and xy.",
    cells: "cells a metre",
    end: END7,
    forms: &[("", "")],
    ours: &[(&UPDATED, [&[12, 16], &[12, 16, 24]]), (&TOTAL, [&[12, 16], &[8, 12, 16, 24]])],
    classical: [&[16], &[8, 16, 32, 64]],
    step: |cells| END7 / (200.0 * (cells as f64 / 20.0).powi(2)).round(),
    scene: expanding,
    errors: known,
    required: &[
        Required { method: &UPDATED, at: None, orders: &[3.0, 2.0], from: 12 },
        Required { method: &TOTAL, at: None, orders: &[3.0, 2.0], from: 12 },
    ],
    shorter: None,
};

fn vortex(_: usize, method: &Method, cells: usize, time: &str) -> String {
    let (young, poisson, density) = (1000.0, 0.3, 1000.0);
    let mu = young / 2.0 / (1.0 + poisson);
    let m = mu / density;
    let s = format!("({RADIUS}-1)");
    let (h, h1, h2) = (format!("(1-32*{s}^2+256*{s}^4)"), format!("(-64*{s}+1024*{s}^3)"), format!("(-64+3072*{s}^2)"));
    let (g, g1, g2) = ("(0.2*sin(PI*t))", "(0.2*PI*cos(PI*t))", "(-0.2*PI^2*sin(PI*t))");
    let a = format!("({g}*{h})");
    let along = format!("({m}*(3*{g}*{h1}+{RADIUS}*{g}*{h2})-{RADIUS}*{g2}*{h})");
    let inward = format!("({m}*{RADIUS}*({g}*{h1})^2-{RADIUS}*({g1}*{h})^2)");
    let radial = format!("({along}*sin({a})+{inward}*cos({a}))");
    let hoop = format!("(-{along}*cos({a})+{inward}*sin({a}))");
    // F = Q (1 + k e_theta e_R), so that b = Q (1 + k (e_R e_theta + e_theta e_R) + k^2 e_theta e_theta) Q^T
    let k = format!("({RADIUS}*{g}*{h1})");
    let (c, d) = (format!("((x*cos({a})-y*sin({a}))/{RADIUS})"), format!("((y*cos({a})+x*sin({a}))/{RADIUS})"));
    let walls = if method.kind == Kind::Classical {
        "boundary.inner = { region = { disk = { center = [0, 0], radius = 0.75 } }, fixed = [\"x\", \"y\"] }
        boundary.outer = { region = { difference = [{ box = { min = [-1.5, -1.5], max = [1.5, 1.5] } }, { disk = { center = [0, 0], radius = 1.25 } }] }, fixed = [\"x\", \"y\"] }"
    } else {
        "boundary.inner = { surface = { body = \"ring\", face = \"inner\" }, fixed = [\"x\", \"y\"] }
        boundary.outer = { surface = { body = \"ring\", face = \"outer\" }, fixed = [\"x\", \"y\"] }"
    };
    format!(
        r#"
        title = "vortex"
        dimension = 2
        grid = {{ origin = [-1.5, -1.5], size = [3, 3], cell = {cell} }}
        material.rubber = {{ law = "neo_hookean", young = {young}, poisson = {poisson}, density = {density} }}
        body.ring = {{ material = "rubber", shape = {{ ring = {{ center = [0, 0], inner = 0.75, outer = 1.25 }} }}, velocity = ["-y*0.2*PI*{h}", "x*0.2*PI*{h}"]{particles} }}
        {walls}
        load.source.body_force = {{ body = "ring", value = ["({radial}*x-{hoop}*y)/{RADIUS}", "({radial}*y+{hoop}*x)/{RADIUS}"] }}
        method = {{ {method} }}
        time = {{ {time} }}
        exact = {{ displacement = ["x*cos({a})-y*sin({a})-x", "x*sin({a})+y*cos({a})-y"], stress.xx = "{mu}*({k}^2*{d}^2-2*{k}*{c}*{d})", stress.xy = "{mu}*({k}*({c}^2-{d}^2)-{k}^2*{c}*{d})" }}
        "#,
        cell = 1.0 / cells as f64,
        particles = particles(method, [3, 3]),
        method = method.toml,
    )
}

fn expanding(_: usize, method: &Method, cells: usize, time: &str) -> String {
    let (young, density, inner, outer, amplitude): (f64, f64, f64, f64, f64) = (1e7, 1000.0, 0.4, 0.6, 0.1);
    let (mu, w) = (young / 2.0, PI * (young / density).sqrt());
    let [c1, c2, c3] =
        [-6.0 * inner / outer, 3.0 * (inner + outer) / outer.powi(2), -2.0 / outer.powi(2)].map(|c| c / (outer - 3.0 * inner));
    // u_R = T q(R), with stretches 1 + T q' and 1 + T q / R
    let wave = format!("({amplitude}*sin({w}*t))");
    let ratio = format!("({c1}+{RADIUS}*({c2}+{RADIUS}*({c3})))");
    let slope = format!("({c1}+{RADIUS}*(2*{c2}+{RADIUS}*3*{c3}))");
    let bend = format!("(2*({c2})+6*({c3})*{RADIUS})");
    let (radial, hoop) = (format!("(1+{wave}*{slope})"), format!("(1+{wave}*{ratio})"));
    // first Piola-Kirchhoff stress mu (l - 1 / l) along both
    let force = format!(
        "(-{ww}*{wave}*{RADIUS}*{ratio}-{m}*((1+1/{radial}^2)*{wave}*{bend}+(({radial}-1/{radial})-({hoop}-1/{hoop}))/{RADIUS}))/{RADIUS}",
        ww = w * w,
        m = mu / density
    );
    let (sr, st) = (format!("({mu}*({radial}-1/{radial})/{hoop})"), format!("({mu}*({hoop}-1/{hoop})/{radial})"));
    format!(
        r#"
        title = "ring"
        dimension = 2
        grid = {{ origin = [-1, -1], size = [2, 2], cell = {cell} }}
        material.rubber = {{ law = "neo_hookean", young = {young}, density = {density} }}
        body.ring = {{ material = "rubber", shape = {{ ring = {{ center = [0, 0], inner = {inner}, outer = {outer} }} }}, velocity = ["{speed}*x*{ratio}", "{speed}*y*{ratio}"]{particles} }}
        load.source.body_force = {{ body = "ring", value = ["x*{force}", "y*{force}"] }}
        method = {{ {method} }}
        time = {{ {time} }}
        exact = {{ displacement = ["x*{ratio}*{wave}", "y*{ratio}*{wave}"], stress.xx = "({sr}*x^2+{st}*y^2)/{RADIUS}^2", stress.xy = "({sr}-{st})*x*y/{RADIUS}^2" }}
        "#,
        cell = 1.0 / cells as f64,
        speed = amplitude * w,
        particles = particles(method, [3, 3]),
        method = method.toml,
    )
}
