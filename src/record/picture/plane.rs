//! The picture of a plane scene: every particle as the parallelogram it has become.

use super::frame::{self, Mark};
use super::{MOST_DRAWN, Snapshot};
use crate::color::viridis;
use crate::scene::Shape;
use crate::svg::{Anchor, FAINT, HATCH, INK, REGION, Scale, Svg, WIDTH, hex, polygon, ticks};
use std::collections::BTreeMap;

const UNDEFORMED: &str = "#dcdcdc";
/// Thickness of the hatching along a held side \[px\].
const WALL: f64 = 9.0;

/// From metres to pixels.
struct View {
    origin: [f64; 2],
    size: [f64; 2],
    /// Upper left corner of the grid \[px\].
    corner: [f64; 2],
    /// Pixels a metre, the same along both axes.
    scale: f64,
}

impl View {
    fn new(snapshot: &Snapshot) -> Self {
        let grid = &snapshot.scene.grid;
        let [origin, size] = [&grid.origin, &grid.size].map(|v| [v[0], v[1]]);
        let (width, height) = (WIDTH - frame::LEFT - 130.0, 620.0);
        let scale = f64::min(width / size[0], height / size[1]);
        // A tall grid stands in the middle of the free width.
        Self { origin, size, corner: [frame::LEFT + 0.5 * (width - scale * size[0]), 72.0], scale }
    }

    fn px(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.corner[0] + (x - self.origin[0]) * self.scale, self.corner[1] + (self.origin[1] + self.size[1] - y) * self.scale]
    }

    /// Width and height of the grid \[px\].
    fn extent(&self) -> [f64; 2] {
        self.size.map(|s| s * self.scale)
    }
}

pub(super) fn draw(snapshot: &Snapshot) -> String {
    let view = View::new(snapshot);
    let mut svg = Svg::new();
    frame::title(&mut svg, snapshot);
    grid(&mut svg, &view, snapshot);
    boundaries(&mut svg, &view, snapshot);
    let scale = Scale::over(snapshot.von_mises.iter().copied().chain([0.0, snapshot.largest]), "Pa");
    let stride = particles(&mut svg, &view, snapshot, &scale);
    let [width, height] = view.extent();
    svg.rect(view.corner, [width, height], "none", INK);
    axes(&mut svg, &view);
    probes(&mut svg, &view, snapshot);
    let bar = height.clamp(140.0, 320.0);
    svg.color_bar([view.corner[0] + width + 44.0, view.corner[1]], bar, &scale, "von Mises stress");

    let mut entries = vec![(Mark::Fill(UNDEFORMED), "at t = 0".to_owned())];
    entries.extend(frame::entries(snapshot));
    if stride > 1 {
        entries.push((Mark::None, format!("(every {stride}th particle drawn)")));
    }
    let total = frame::legend(&mut svg, view.corner[1] + height.max(bar) + 66.0, &entries);
    svg.finish(total)
}

/// Light lines along the cells.
fn grid(svg: &mut Svg, view: &View, snapshot: &Snapshot) {
    let mut lines = String::new();
    let end = std::array::from_fn::<_, 2, _>(|a| view.origin[a] + view.size[a]);
    for axis in 0..2 {
        let cell = snapshot.scene.grid.cell.axis(axis).unwrap_or(view.size[axis]);
        let count = (view.size[axis] / cell).round() as usize;
        for i in (0..=count).step_by(frame::line_stride(cell * view.scale)) {
            let (mut from, mut to) = (view.origin, end);
            from[axis] = view.origin[axis] + i as f64 * cell;
            to[axis] = from[axis];
            polygon(&mut lines, &[view.px(from), view.px(to)]);
        }
    }
    svg.outline(&lines, FAINT, 1.0, "");
}

/// The bodies at time 0 and now; returns every how many particles one is drawn.
fn particles(svg: &mut Svg, view: &View, snapshot: &Snapshot, scale: &Scale) -> usize {
    let stride = snapshot.len().div_ceil(MOST_DRAWN).max(1);
    // Fewer are drawn larger, so that the body still looks whole.
    let grow = (stride as f64).sqrt();
    let mut before = String::new();
    // One path a colour is a fifth of the size of one a particle.
    const COLORS: f64 = 96.0;
    let mut now: BTreeMap<usize, String> = BTreeMap::new();
    for p in (0..snapshot.len()).step_by(stride) {
        let (u, v) = (snapshot.edge(p, 0), snapshot.edge(p, 1));
        parallelogram(&mut before, view, Snapshot::at(&snapshot.initial, p), u.0, v.0, grow);
        let level = (scale.share(snapshot.von_mises[p]) * COLORS).round().max(0.0) as usize;
        parallelogram(now.entry(level).or_default(), view, Snapshot::at(&snapshot.position, p), u.1, v.1, grow);
    }
    svg.area(&before, UNDEFORMED);
    for (level, outline) in now {
        svg.area(&outline, &hex(viridis(level as f64 / COLORS)));
    }
    stride
}

fn parallelogram(out: &mut String, view: &View, center: [f64; 2], u: [f64; 2], v: [f64; 2], grow: f64) {
    let corner = |a: f64, b: f64| view.px(std::array::from_fn(|k| center[k] + 0.5 * grow * (a * u[k] + b * v[k])));
    polygon(out, &[corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]);
}

/// Hatching along held sides of the grid and over held regions.
fn boundaries(svg: &mut Svg, view: &View, snapshot: &Snapshot) {
    let [width, height] = view.extent();
    let [left, top] = view.corner;
    for boundary in snapshot.scene.boundary.values() {
        if let Some((axis, upper)) = boundary.face.as_deref().and_then(frame::side) {
            let (corner, size) = match (axis, upper) {
                (0, false) => ([left - WALL, top], [WALL, height]),
                (0, true) => ([left + width, top], [WALL, height]),
                (_, false) => ([left, top + height], [width, WALL]),
                (_, true) => ([left, top - WALL], [width, WALL]),
            };
            svg.rect(corner, size, HATCH, INK);
        }
        if let Some(region) = &boundary.region {
            let [low, high] = clipped(region, view);
            let (corner, opposite) = (view.px([low[0], high[1]]), view.px([high[0], low[1]]));
            svg.rect(corner, [opposite[0] - corner[0], opposite[1] - corner[1]], REGION, "#bbb");
        }
    }
}

/// The box around a region, within the grid.
fn clipped(region: &Shape, view: &View) -> [[f64; 2]; 2] {
    let (low, high) = region.bounds(2);
    let end = |a: usize| view.origin[a] + view.size[a];
    [std::array::from_fn(|a| low[a].clamp(view.origin[a], end(a))), std::array::from_fn(|a| high[a].clamp(view.origin[a], end(a)))]
}

/// Ticks in metres to the left of and below the grid.
fn axes(svg: &mut Svg, view: &View) {
    let [width, height] = view.extent();
    let [left, bottom] = [view.corner[0], view.corner[1] + height];
    let count = |length: f64, apart: f64| ((length / apart) as usize).max(2);
    for (x, text) in ticks(view.origin[0], view.origin[0] + view.size[0], count(width, 80.0)) {
        let [at, _] = view.px([x, 0.0]);
        svg.line([at, bottom], [at, bottom + 5.0], INK, 1.0);
        svg.text([at, bottom + 22.0], 12.0, Anchor::Middle, text);
    }
    for (y, text) in ticks(view.origin[1], view.origin[1] + view.size[1], count(height, 60.0)) {
        let [_, at] = view.px([0.0, y]);
        svg.line([left - 5.0, at], [left, at], INK, 1.0);
        svg.text([left - 13.0, at + 4.0], 12.0, Anchor::End, text);
    }
    svg.text([left + 0.5 * width, bottom + 40.0], 12.0, Anchor::Middle, "x [m]");
    svg.text_upwards([left - 48.0, bottom - 0.5 * height], 12.0, "y [m]");
}

fn probes(svg: &mut Svg, view: &View, snapshot: &Snapshot) {
    for (name, x) in &snapshot.probes {
        let [px, py] = view.px([x[0], x[1]]);
        svg.circle([px, py], 4.0, "white", INK);
        svg.label([px + 8.0, py - 7.0], name);
    }
}
