//! The picture of a scene in one dimension: displacement and stress over the bar.

use super::frame::{self, Mark};
use super::{MOST_DRAWN, Snapshot};
use crate::color::viridis;
use crate::svg::{Anchor, FAINT, HATCH, INK, Scale, Svg, WIDTH, hex, ticks};
use std::fmt::Write;

const TOP: f64 = 76.0;
const HEIGHT: f64 = 190.0;
const GAP: f64 = 34.0;
const PLOT: f64 = WIDTH - frame::LEFT - 50.0;

pub(super) fn draw(snapshot: &Snapshot) -> String {
    let mut svg = Svg::new();
    frame::title(&mut svg, snapshot);
    let stride = snapshot.len().div_ceil(MOST_DRAWN).max(1);
    let mut order: Vec<usize> = (0..snapshot.len()).step_by(stride).collect();
    order.sort_by(|&a, &b| snapshot.position[a].total_cmp(&snapshot.position[b]));

    let displacement = |p: usize| snapshot.position[p] - snapshot.initial[p];
    let stress = |p: usize| snapshot.stress[9 * p];
    panel(&mut svg, TOP, snapshot, &order, &displacement, "displacement", "m");
    panel(&mut svg, TOP + HEIGHT + GAP, snapshot, &order, &stress, "stress xx", "Pa");

    let bottom = TOP + 2.0 * HEIGHT + GAP;
    for (x, text) in ticks(origin(snapshot), origin(snapshot) + length(snapshot), 9) {
        svg.text([px(snapshot, x), bottom + 20.0], 12.0, Anchor::Middle, text);
    }
    svg.text([frame::LEFT + 0.5 * PLOT, bottom + 38.0], 12.0, Anchor::Middle, "x [m]");
    let mut entries = frame::entries(snapshot);
    entries.retain(|(mark, _)| !matches!(mark, Mark::Probe));
    if stride > 1 {
        entries.push((Mark::None, format!("(every {stride}th particle drawn)")));
    }
    let total = frame::legend(&mut svg, bottom + 62.0, &entries);
    svg.finish(total)
}

fn origin(snapshot: &Snapshot) -> f64 {
    snapshot.scene.grid.origin[0]
}

fn length(snapshot: &Snapshot) -> f64 {
    snapshot.scene.grid.size[0]
}

fn px(snapshot: &Snapshot, x: f64) -> f64 {
    frame::LEFT + (x - origin(snapshot)) / length(snapshot) * PLOT
}

/// One quantity over x: grid lines at the cells, a line through the particles in `order`, a dot each.
fn panel(svg: &mut Svg, top: f64, snapshot: &Snapshot, order: &[usize], value: &dyn Fn(usize) -> f64, name: &str, unit: &str) {
    let scale = Scale::over(order.iter().map(|&p| value(p)).chain([0.0]), unit);
    // A tenth of the height stays free at both ends, so that no dot sits on the frame.
    let py = |v: f64| top + HEIGHT * (0.9 - 0.8 * scale.share(v));
    let cell = snapshot.scene.grid.cell.axis(0).unwrap_or(length(snapshot));
    let cells = (length(snapshot) / cell).round() as usize;
    for i in (0..=cells).step_by(frame::line_stride(cell / length(snapshot) * PLOT)) {
        let x = px(snapshot, origin(snapshot) + i as f64 * cell);
        svg.line([x, top], [x, top + HEIGHT], FAINT, 1.0);
    }
    for (v, text) in scale.ticks(4) {
        svg.line([frame::LEFT, py(v)], [frame::LEFT + PLOT, py(v)], FAINT, 1.0);
        svg.text([frame::LEFT - 13.0, py(v) + 4.0], 12.0, Anchor::End, text);
    }
    svg.line([frame::LEFT, py(0.0)], [frame::LEFT + PLOT, py(0.0)], "#999", 1.0);
    let mut outline = String::new();
    for (i, &p) in order.iter().enumerate() {
        let command = if i == 0 { 'M' } else { 'L' };
        let _ = write!(outline, "{command}{:.2} {:.2}", px(snapshot, snapshot.position[p]), py(value(p)));
    }
    let color = hex(viridis(0.3));
    svg.outline(&outline, &color, 1.5, "");
    // Dots that touch are a thick line.
    if order.len() <= 200 {
        for &p in order {
            svg.circle([px(snapshot, snapshot.position[p]), py(value(p))], 2.5, "white", &color);
        }
    }
    for boundary in snapshot.scene.boundary.values() {
        if let Some((_, upper)) = boundary.face.as_deref().and_then(frame::side) {
            svg.rect([if upper { frame::LEFT + PLOT } else { frame::LEFT - 9.0 }, top], [9.0, HEIGHT], HATCH, INK);
        }
    }
    svg.rect([frame::LEFT, top], [PLOT, HEIGHT], "none", INK);
    svg.text_upwards([frame::LEFT - 52.0, top + 0.5 * HEIGHT], 12.0, format_args!("{name} [{}]", scale.unit));
}
