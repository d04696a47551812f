//! A cube whose face at x = 1 is free and carries a traction that varies along it.

use super::{Method, Race, Required, TOTAL, known, particles};
use std::f64::consts::PI;

/// Angular frequency \[1/s\].
const C: f64 = 20.0;

pub(in super::super) const CUBE: Race = Race {
    id: "cube",
    title: "pulled cube in 3D with a free face: run time against error",
    heading: "A pulled cube",
    text: "The unit cube with u_i = a_i s_i(X_i) sin(20 t), s_x = sin(1.2 X), s_y = sin(pi Y), s_z = sin(pi Z), a = (0.1, 0.04, -0.03) m, of neo-Hookean rubber, \
           E = 100 Pa, nu = 0.3, 1 kg/m3, at a quarter of a period. Its face at x = 1 is free and carries the traction that belongs to this, which varies along it; \
           on the others the displacement normal to them is 0. Total: consistent mass, the symplectic scheme of fourth order; the classical methods have 2 \
           particles a cell and axis. All go at the default share of the stable step. Stress: its component xx.",
    cells: "cells",
    end: 0.5 * PI / C,
    forms: &[("", "")],
    ours: &[(&TOTAL, [&[3, 4], &[3, 4, 6, 8]])],
    classical: [&[4, 8], &[4, 8, 16, 24]],
    step: |_| f64::NAN,
    scene,
    errors: known,
    required: &[Required { method: &TOTAL, at: None, orders: &[3.0], from: 3 }],
    shorter: None,
};

fn scene(_: usize, method: &Method, cells: usize, time: &str) -> String {
    let (young, poisson): (f64, f64) = (100.0, 0.3);
    let (mu, lambda) = (young / (2.0 * (1.0 + poisson)), young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)));
    let along = |a: usize| [("x", 1.2, 0.1), ("y", PI, 0.04), ("z", PI, -0.03)][a];
    let shape = |a: usize| format!("({}*sin({}*{}))", along(a).2, along(a).1, along(a).0);
    let wave = format!("sin({C}*t)");
    let displacement = |a: usize| format!("{}*{wave}", shape(a));
    let stretch = |a: usize| format!("(1+{}*cos({}*{})*{wave})", along(a).2 * along(a).1, along(a).1, along(a).0);
    let log = format!("(ln{}+ln{}+ln{})", stretch(0), stretch(1), stretch(2));
    let piola = |a: usize| format!("({mu}*({f}-1/{f})+{lambda}*{log}/{f})", f = stretch(a));
    // b = u'' - dP/dF F', with F' = -k^2 u
    let force = |a: usize| {
        let (f, k) = (stretch(a), along(a).1);
        format!("{}*({kk}*({mu}*(1+1/{f}^2)+{lambda}*(1-{log})/{f}^2)-{cc})", displacement(a), kk = k * k, cc = C * C)
    };
    let list = |of: &dyn Fn(usize) -> String| (0..3).map(|a| format!("\"{}\"", of(a))).collect::<Vec<_>>().join(", ");
    format!(
        r#"
        title = "a pulled cube"
        dimension = 3
        grid = {{ origin = [0, 0, 0], size = [2, 1, 1], cell = {cell} }}
        material.rubber = {{ law = "neo_hookean", young = {young}, poisson = {poisson}, density = 1 }}
        body.cube = {{ material = "rubber", shape = {{ box = {{ min = [0, 0, 0], max = [1, 1, 1] }} }}, velocity = [{velocity}]{particles} }}
        boundary.x = {{ face = "x-", fixed = ["x"] }}
        boundary.y = {{ face = "y-", fixed = ["y"] }}
        boundary.yy = {{ face = "y+", fixed = ["y"] }}
        boundary.z = {{ face = "z-", fixed = ["z"] }}
        boundary.zz = {{ face = "z+", fixed = ["z"] }}
        load.source.body_force = {{ body = "cube", value = [{force}] }}
        load.pull.traction = {{ body = "cube", face = "x+", value = ["{pull}", "0", "0"] }}
        method = {{ {method} }}
        time = {{ {time} }}
        exact = {{ displacement = [{displacement}], stress.xx = "{pull}/({g}*{h})" }}
        "#,
        cell = 1.0 / cells as f64,
        velocity = list(&|a| format!("{C}*{}", shape(a))),
        particles = particles(method, [4, 2]),
        force = list(&force),
        pull = piola(0),
        displacement = list(&displacement),
        g = stretch(1),
        h = stretch(2),
        method = method.toml,
    )
}
