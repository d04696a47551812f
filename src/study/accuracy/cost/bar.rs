//! T2: the vibrating bar of Tielen (2016), chapter 6, with 7 % strain.

use super::{Method, Race, Required, TOTAL, UPDATED, particles};
use crate::Simulation;
use crate::component::ComponentError;
use crate::study::reference::Table;
use crate::study::tools::{rms, stress_xx};

const END: f64 = 0.5;

pub(in super::super) const T2: Race = Race {
    id: "T2-cost",
    title: "vibrating bar, large deformations: run time against error",
    heading: "T2",
    text: "The bar of above at 0.5 s, with 4 particles a cell at even distances. Updated: cubic B-splines, consistent mass, splines through the \
           particles integrated by Gauss' rule; steps of 0.4 ms with 16 cells, else as the square of the cell, so that their error, of second \
           order, falls as that of the cells. Total: consistent mass, the symplectic scheme of fourth order. This and the classical methods, \
           which have lumped masses and integrate at the particles, with MUSL, go at the default share of the stable step.",
    cells: "cells",
    end: END,
    forms: &[("", "")],
    ours: &[(&UPDATED, [&[16, 32], &[8, 16, 32, 64]]), (&TOTAL, [&[16, 32], &[4, 8, 16, 32, 64]])],
    classical: [&[16, 32], &[8, 16, 32, 64, 128, 256, 512]],
    step: |cells| 4e-4 * (16.0 / cells as f64).powi(2),
    scene,
    errors,
    required: &[Required { method: &UPDATED, at: Some((16, [5e-8, 2e-4])), orders: &[3.5, 3.0], from: 16 }],
    shorter: None,
};

fn scene(_: usize, method: &Method, cells: usize, time: &str) -> String {
    format!(
        r#"
        title = "Tielen 2016, vibrating bar, large deformations"
        dimension = 1
        grid = {{ origin = [0], size = [1], cell = {} }}
        material.elastic = {{ law = "hypo_elastic", young = 50.0, density = 25.0 }}
        body.bar = {{ material = "elastic", shape = {{ box = {{ min = [0], max = [1] }} }}, velocity = ["0.1*sin(PI*x)"]{} }}
        boundary.left = {{ face = "x-", fixed = ["x"] }}
        boundary.right = {{ face = "x+", fixed = ["x"] }}
        method = {{ {} }}
        time = {{ {time} }}
        "#,
        1.0 / cells as f64,
        particles(method, [4, 4]),
        method.toml
    )
}

fn errors(sim: &mut Simulation) -> Result<Vec<f64>, ComponentError> {
    let position = sim.get("particle/position")?.to_vec();
    let moved = sim.get("particle/displacement")?.to_vec();
    let stress = stress_xx(sim.get("particle/stress")?);
    let known = Table::bar();
    let exact: Vec<[f64; 3]> = position.iter().zip(&moved).map(|(x, u)| known.over_place(END, x - u, 6)).collect();
    Ok(vec![rms(moved.iter().zip(&exact).map(|(u, e)| u - e[0])), rms(stress.iter().zip(&exact).map(|(s, e)| s - e[2]))])
}
