//! B4 and B5: manufactured solutions u_i = +-A sin(pi X_i) sin(pi c t) on the unit interval and square, finite strain, neo-Hookean rubber.

use super::{Kind, Method, Race, Required, TOTAL, UPDATED, known, particles};
use std::f64::consts::PI;

/// Wave speeds \[m/s\].
const C1: f64 = 10.0;
const C2: f64 = 100.0;
/// A quarter of a period \[s\].
const END1: f64 = 0.25 / C1;
const END2: f64 = 0.25 / C2;

pub(in super::super) const B4: Race = Race {
    id: "B4",
    title: "manufactured solution in 1D: run time against error",
    heading: "B4, a manufactured solution in 1D",
    text: "u = A sin(pi X) sin(pi c t) on the unit interval, c = 10 m/s, with the body force that this takes in neo-Hookean rubber of 100 Pa, at \
           a quarter of a period, with 16 and 31 % strain. 4 particles a cell, at even distances or, where it says so, each moved by up to \
           40 % of their distance; those of the total formulation are Gauss points and cannot be moved, so that its runs are the same in both. \
           Steps of the updated formulation are the time over the square of the number of cells; all else as in T2. The last table has the classical \
           methods with a tenth of their step too: FLIP gains little or nothing and APIC less than the time that it takes, so that the default \
           is the fairer one.",
    cells: "cells",
    end: END1,
    forms: &[
        ("A = 0.05, even particles", "-005-even"),
        ("A = 0.05, jittered particles", "-005-jittered"),
        ("A = 0.1, even particles", "-010-even"),
        ("A = 0.1, jittered particles", "-010-jittered"),
    ],
    ours: &[(&UPDATED, [&[8, 16, 32], &[8, 16, 32, 64]]), (&TOTAL, [&[8, 16, 32], &[4, 8, 16, 32, 64]])],
    classical: [&[8, 16, 32], &[8, 16, 32, 64, 128, 256, 512]],
    step: |cells| END1 / (cells * cells) as f64,
    scene: interval,
    errors: known,
    required: &[Required { method: &UPDATED, at: None, orders: &[3.5, 3.0], from: 8 }],
    shorter: Some([32, 256]),
};

pub(in super::super) const B5: Race = Race {
    id: "B5",
    title: "manufactured solution in 2D: run time against error",
    heading: "B5, a manufactured solution in 2D",
    text: "The unit square with u_i = +-A sin(pi X_i) sin(pi c t), A = 0.05 m, c = 100 m/s, E = 1e4 Pa, nu = 0.3, no displacement normal to the \
           faces; stress is its component xx. 4 particles a cell and axis, 2 of classical methods; all else as in B4.",
    cells: "cells",
    end: END2,
    forms: &[("", "")],
    ours: &[(&UPDATED, [&[4, 8], &[4, 8, 16]]), (&TOTAL, [&[4, 8], &[4, 8, 16]])],
    classical: [&[4, 8, 16], &[4, 8, 16, 32, 64, 128]],
    step: |cells| END2 / (cells * cells) as f64,
    scene: square,
    errors: known,
    required: &[Required { method: &UPDATED, at: None, orders: &[3.5, 2.8], from: 4 }],
    shorter: None,
};

fn interval(form: usize, method: &Method, cells: usize, time: &str) -> String {
    let amplitude = [0.05, 0.05, 0.1, 0.1][form];
    // Gauss points stand where they stand
    let jittered = form % 2 == 1 && method.kind != Kind::Total;
    let wave = format!("({amplitude}*sin(PI*{C1}*t))");
    let stretch = format!("(1+PI*cos(PI*x)*{wave})");
    let displacement = format!("sin(PI*x)*{wave}");
    format!(
        r#"
        title = "a manufactured solution"
        dimension = 1
        grid = {{ origin = [0], size = [1], cell = {cell} }}
        material.rubber = {{ law = "neo_hookean", young = 100, density = 1 }}
        body.bar = {{ material = "rubber", shape = {{ box = {{ min = [0], max = [1] }} }}, velocity = ["{speed}*sin(PI*x)"]{particles}{jitter} }}
        boundary.left = {{ face = "x-", fixed = ["x"] }}
        boundary.right = {{ face = "x+", fixed = ["x"] }}
        load.source.body_force = {{ body = "bar", value = ["PI^2*{displacement}*(50+50/{stretch}^2-{C1}^2)"] }}
        method = {{ {method} }}
        time = {{ {time} }}
        exact = {{ displacement = ["{displacement}"], stress.xx = "50*({stretch}^2-1)/{stretch}" }}
        "#,
        cell = 1.0 / cells as f64,
        speed = amplitude * PI * C1,
        particles = particles(method, [4, 4]),
        jitter = if jittered { r#", positions = "jittered""# } else { "" },
        method = method.toml,
    )
}

fn square(_: usize, method: &Method, cells: usize, time: &str) -> String {
    let (young, poisson, amplitude) = (1e4, 0.3, 0.05);
    let (mu, lambda) = (young / (2.0 * (1.0 + poisson)), young * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)));
    let wave = |sign: f64| format!("({}*sin(PI*{C2}*t))", sign * amplitude);
    let axes = [("x", 1.0), ("y", -1.0)];
    let [f, g] = axes.map(|(axis, sign)| format!("(1+PI*cos(PI*{axis})*{})", wave(sign)));
    let [u, v] = axes.map(|(axis, sign)| format!("sin(PI*{axis})*{}", wave(sign)));
    let log = format!("(ln{f}+ln{g})");
    let force = |u: &str, f: &str| format!("PI^2*{u}*({mu}-{}-({lambda}*({log}-1)-{mu})/{f}^2)", C2 * C2);
    format!(
        r#"
        title = "a manufactured solution"
        dimension = 2
        grid = {{ origin = [0, 0], size = [1, 1], cell = {cell} }}
        material.rubber = {{ law = "neo_hookean", young = {young}, poisson = {poisson}, density = 1 }}
        body.block = {{ material = "rubber", shape = {{ box = {{ min = [0, 0], max = [1, 1] }} }}, velocity = ["{speed}*sin(PI*x)", "-{speed}*sin(PI*y)"]{particles} }}
        boundary.left = {{ face = "x-", fixed = ["x"] }}
        boundary.right = {{ face = "x+", fixed = ["x"] }}
        boundary.floor = {{ face = "y-", fixed = ["y"] }}
        boundary.ceiling = {{ face = "y+", fixed = ["y"] }}
        load.source.body_force = {{ body = "block", value = ["{x}", "{y}"] }}
        method = {{ {method} }}
        time = {{ {time} }}
        exact = {{ displacement = ["{u}", "{v}"], stress.xx = "({mu}*({f}^2-1)+{lambda}*{log})/({f}*{g})" }}
        "#,
        cell = 1.0 / cells as f64,
        speed = amplitude * PI * C2,
        particles = particles(method, [4, 2]),
        x = force(&u, &f),
        y = force(&v, &g),
        method = method.toml,
    )
}
