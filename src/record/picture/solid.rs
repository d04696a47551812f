//! The picture of a scene in space: the surface of the bodies in parallel projection, every particle as the block it has become.

use super::frame::{self, Mark};
use super::{MOST_DRAWN, Snapshot};
use crate::color::viridis;
use crate::svg::{Anchor, FAINT, HATCH, INK, Scale, Svg, WIDTH, hex, polygon, ticks};
use std::collections::HashSet;

/// Where the eye is: x to the right, y to the right and back, z up.
const AZIMUTH: f64 = -60.0;
const ELEVATION: f64 = 24.0;

/// Parallel projection.
struct View {
    right: [f64; 3],
    up: [f64; 3],
    towards: [f64; 3],
    scale: f64,
    offset: [f64; 2],
    low: [f64; 3],
    high: [f64; 3],
    height: f64,
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl View {
    fn new(snapshot: &Snapshot) -> Self {
        let grid = &snapshot.scene.grid;
        let low: [f64; 3] = std::array::from_fn(|a| grid.origin[a]);
        let high = std::array::from_fn(|a| grid.origin[a] + grid.size[a]);
        let ((sa, ca), (se, ce)) = (AZIMUTH.to_radians().sin_cos(), ELEVATION.to_radians().sin_cos());
        let (right, up, towards) = ([-sa, ca, 0.0], [-se * ca, -se * sa, ce], [ce * ca, ce * sa, se]);
        let mut view = Self { right, up, towards, scale: 1.0, offset: [0.0; 2], low, high, height: 0.0 };
        let mut least = [f64::INFINITY; 2];
        let mut most = [f64::NEG_INFINITY; 2];
        for corner in 0..8 {
            let px = view.px(view.corner(corner));
            least = std::array::from_fn(|k| least[k].min(px[k]));
            most = std::array::from_fn(|k| most[k].max(px[k]));
        }
        let (width, height) = (WIDTH - frame::LEFT - 150.0, 560.0);
        view.scale = f64::min(width / (most[0] - least[0]), height / (most[1] - least[1]));
        view.height = view.scale * (most[1] - least[1]);
        let free = width - view.scale * (most[0] - least[0]);
        view.offset = [frame::LEFT + 0.5 * free - view.scale * least[0], 72.0 - view.scale * least[1]];
        view
    }

    fn px(&self, x: [f64; 3]) -> [f64; 2] {
        [self.offset[0] + self.scale * dot(self.right, x), self.offset[1] - self.scale * dot(self.up, x)]
    }

    /// Corner of the grid; bit k of `corner` chooses the end of axis k.
    fn corner(&self, corner: usize) -> [f64; 3] {
        std::array::from_fn(|a| if corner >> a & 1 == 1 { self.high[a] } else { self.low[a] })
    }

    /// The corners of a side of the grid, in order around it.
    fn side(&self, axis: usize, upper: bool) -> [[f64; 2]; 4] {
        let (b, c) = ((axis + 1) % 3, (axis + 2) % 3);
        let base = usize::from(upper) << axis;
        [0, 1 << b, (1 << b) | (1 << c), 1 << c].map(|corner| self.px(self.corner(base | corner)))
    }

    /// Whether the eye sees the outside of a side, so that it stands in front of what is inside.
    fn in_front(&self, axis: usize, upper: bool) -> bool {
        (self.towards[axis] > 0.0) == upper
    }
}

pub(super) fn draw(snapshot: &Snapshot) -> String {
    let view = View::new(snapshot);
    let mut svg = Svg::new();
    frame::title(&mut svg, snapshot);
    room(&mut svg, &view, snapshot);
    let scale = Scale::over(snapshot.von_mises.iter().copied().chain([0.0, snapshot.largest]), "Pa");
    let stride = surface(&mut svg, &view, snapshot, &scale);
    axes(&mut svg, &view);
    for (name, x) in &snapshot.probes {
        let [px, py] = view.px([x[0], x[1], x[2]]);
        svg.circle([px, py], 4.0, "white", INK);
        svg.label([px + 8.0, py - 7.0], name);
    }
    svg.color_bar([WIDTH - 86.0, 72.0], view.height.clamp(140.0, 320.0), &scale, "von Mises stress");
    let mut entries = frame::entries(snapshot);
    if stride > 1 {
        entries.push((Mark::None, format!("(every {stride}th particle of the surface drawn)")));
    }
    let total = frame::legend(&mut svg, 72.0 + view.height.max(140.0) + 62.0, &entries);
    svg.finish(total)
}

/// The sides of the grid behind the bodies with their cells, the hatching of held ones, and all edges.
fn room(svg: &mut Svg, view: &View, snapshot: &Snapshot) {
    for axis in 0..3 {
        svg.outline(&cells(view, snapshot, axis, view.towards[axis] < 0.0), FAINT, 1.0, "");
    }
    for boundary in snapshot.scene.boundary.values() {
        // A held side in front would hide the bodies; the legend still names it.
        if let Some((axis, upper)) = boundary.face.as_deref().and_then(frame::side)
            && !view.in_front(axis, upper)
        {
            let mut outline = String::new();
            polygon(&mut outline, &view.side(axis, upper));
            svg.area(&outline, "#f3f3f3");
            svg.outline(&cells(view, snapshot, axis, upper), "#d4d4d4", 1.0, "");
            svg.outline(&outline, "#888", 1.5, "");
            // A rim of hatching, not a whole side: the bodies stand before it.
            rim(svg, view, axis, upper);
        }
    }
    let mut edges = String::new();
    for axis in 0..3 {
        polygon(&mut edges, &view.side(axis, view.towards[axis] < 0.0));
    }
    svg.outline(&edges, "#aaa", 1.0, "");
}

/// Cell lines of one side.
fn cells(view: &View, snapshot: &Snapshot, axis: usize, upper: bool) -> String {
    let mut lines = String::new();
    for along in [(axis + 1) % 3, (axis + 2) % 3] {
        let cell = snapshot.scene.grid.cell.axis(along).unwrap_or(view.high[along] - view.low[along]);
        let count = ((view.high[along] - view.low[along]) / cell).round() as usize;
        for i in (0..=count).step_by(frame::line_stride(cell * view.scale)) {
            let (mut from, mut to) = (view.low, view.high);
            from[axis] = if upper { view.high[axis] } else { view.low[axis] };
            to[axis] = from[axis];
            from[along] = view.low[along] + i as f64 * cell;
            to[along] = from[along];
            polygon(&mut lines, &[view.px(from), view.px(to)]);
        }
    }
    lines
}

/// Hatching below the edge of a held side that is nearest to the eye.
fn rim(svg: &mut Svg, view: &View, axis: usize, upper: bool) {
    let mut corners = view.side(axis, upper).to_vec();
    corners.sort_by(|a, b| b[1].total_cmp(&a[1]));
    for pair in [[corners[0], corners[1]], [corners[0], corners[2]]] {
        let mut strip = String::new();
        polygon(&mut strip, &[pair[0], pair[1], [pair[1][0], pair[1][1] + 8.0], [pair[0][0], pair[0][1] + 8.0]]);
        svg.area(&strip, HATCH);
    }
}

/// One visible side of a block.
struct Facet {
    depth: f64,
    corners: [[f64; 2]; 4],
    color: [u8; 3],
}

/// The blocks, far ones first; returns every how many particles of the surface one is drawn.
fn surface(svg: &mut Svg, view: &View, snapshot: &Snapshot, scale: &Scale) -> usize {
    // Which part of which cell each particle filled at time 0: neighbours there hide the sides between them.
    let slot = |p: usize| -> [i64; 4] {
        let (x, spacing) = (Snapshot::at::<3>(&snapshot.initial, p), &snapshot.spacing[snapshot.body[p]]);
        std::array::from_fn(|a| if a == 3 { snapshot.body[p] as i64 } else { ((x[a] - view.low[a]) / spacing[a]).floor() as i64 })
    };
    let filled: HashSet<[i64; 4]> = (0..snapshot.len()).map(slot).collect();
    let free = |p: usize, axis: usize, upper: bool| {
        let mut neighbour = slot(p);
        neighbour[axis] += if upper { 1 } else { -1 };
        !filled.contains(&neighbour)
    };
    let sides = (0..3).flat_map(|axis| [(axis, false), (axis, true)]).collect::<Vec<_>>();
    let outer: Vec<usize> = (0..snapshot.len()).filter(|&p| sides.iter().any(|&(axis, upper)| free(p, axis, upper))).collect();
    let stride = outer.len().div_ceil(MOST_DRAWN).max(1);
    let grow = (stride as f64).sqrt();

    let mut facets = Vec::new();
    for &p in outer.iter().step_by(stride) {
        let edges: [[f64; 3]; 3] = std::array::from_fn(|axis| snapshot.edge(p, axis).1.map(|v| 0.5 * grow * v));
        let color = viridis(scale.share(snapshot.von_mises[p]));
        for &(axis, upper) in sides.iter().filter(|&&(axis, upper)| stride > 1 || free(p, axis, upper)) {
            facets.extend(facet(view, Snapshot::at(&snapshot.position, p), edges, axis, upper, color));
        }
    }
    facets.sort_by(|a, b| a.depth.total_cmp(&b.depth));
    for Facet { corners, color, .. } in facets {
        let mut outline = String::new();
        polygon(&mut outline, &corners);
        svg.area(&outline, &hex(color));
    }
    stride
}

/// A side of the block around `center` with half edges `edges`, if the eye sees it.
fn facet(view: &View, center: [f64; 3], edges: [[f64; 3]; 3], axis: usize, upper: bool, color: [u8; 3]) -> Option<Facet> {
    let (b, c) = (edges[(axis + 1) % 3], edges[(axis + 2) % 3]);
    let sign = if upper { 1.0 } else { -1.0 };
    let cross = [b[1] * c[2] - b[2] * c[1], b[2] * c[0] - b[0] * c[2], b[0] * c[1] - b[1] * c[0]].map(|v| sign * v);
    let length = dot(cross, cross).sqrt();
    if dot(cross, view.towards) <= 0.0 || length == 0.0 {
        return None;
    }
    let middle: [f64; 3] = std::array::from_fn(|k| center[k] + sign * edges[axis][k]);
    let corner = |s: f64, t: f64| view.px(std::array::from_fn(|k| middle[k] + s * b[k] + t * c[k]));
    // Light from above and from the left tells the sides of a block apart.
    let light = 0.80 + 0.20 * dot(cross, [-0.3, -0.4, 0.87]) / length;
    Some(Facet {
        depth: dot(middle, view.towards),
        corners: [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
        color: color.map(|v| (f64::from(v) * light) as u8),
    })
}

/// Ticks in metres along the three edges at the rim of the drawing.
fn axes(svg: &mut Svg, view: &View) {
    const NAMES: [&str; 3] = ["x [m]", "y [m]", "z [m]"];
    // Where each edge stands, and which way its numbers are moved \[px\].
    let edges = [(view.low, [-8.0, 24.0]), ([view.high[0], view.low[1], view.low[2]], [16.0, 20.0]), (view.low, [-12.0, 4.0])];
    for (axis, (base, shift)) in edges.into_iter().enumerate() {
        let at = |value: f64| {
            let mut x = base;
            x[axis] = value;
            view.px(x)
        };
        let (from, to) = (at(view.low[axis]), at(view.high[axis]));
        svg.line(from, to, INK, 1.0);
        let length = (from[0] - to[0]).hypot(from[1] - to[1]);
        let anchor = if axis == 2 { Anchor::End } else { Anchor::Middle };
        for (value, text) in ticks(view.low[axis], view.high[axis], ((length / 70.0) as usize).max(2)) {
            let [x, y] = at(value);
            svg.line([x, y], [x + 0.3 * shift[0], y + if axis == 2 { 0.0 } else { 5.0 }], INK, 1.0);
            svg.text([x + shift[0], y + shift[1]], 12.0, anchor, text);
        }
        let [x, y] = at(0.5 * (view.low[axis] + view.high[axis]));
        let further = if axis == 2 { [3.2, 1.0] } else { [2.6, 1.8] };
        svg.text([x + further[0] * shift[0], y + further[1] * shift[1]], 12.0, anchor, NAMES[axis]);
    }
}
