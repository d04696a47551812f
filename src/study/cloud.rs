//! Particles in the plane as SVG, 900 px wide: where they are, coloured by a value; one view, or several side by side.

use super::chart::{Axis, quoted, short};
use crate::color::viridis;
use crate::svg::{Anchor, INK, Scale, Svg, WIDTH, hex, ticks};
use std::fmt::Write;

/// Particles coloured by a value, seen at several times or by several methods.
#[derive(Debug, Clone, PartialEq)]
pub struct Cloud {
    /// What it shows, in one line.
    pub title: String,
    /// What the colour means.
    pub value: Axis,
    /// In reading order; all have the same scale and the same colours.
    pub views: Vec<View>,
    /// Views side by side.
    pub columns: usize,
}

/// Some particles.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    /// What differs from the other views.
    pub title: String,
    /// Position \[m\].
    pub points: Vec<[f64; 2]>,
    /// Value of each particle.
    pub values: Vec<f64>,
}

const LEFT: f64 = 64.0;
const RIGHT: f64 = 120.0;
const TOP: f64 = 46.0;
/// Room for the title of a view \[px\].
const HEAD: f64 = 24.0;
/// Room for the numbers under and beside a view \[px\].
const FOOT: f64 = 46.0;

impl Cloud {
    /// Views below each other.
    pub fn new(title: impl Into<String>, value: Axis, views: impl IntoIterator<Item = View>) -> Self {
        Self { title: title.into(), value, views: views.into_iter().collect(), columns: 1 }
    }

    /// So many views side by side.
    pub fn columns(mut self, columns: usize) -> Self {
        self.columns = columns.max(1);
        self
    }

    /// The picture, true to scale.
    pub fn svg(&self) -> String {
        let mut svg = Svg::new();
        svg.text([LEFT, 30.0], 17.0, Anchor::Start, &self.title);
        let range: [(f64, f64); 2] = std::array::from_fn(|axis| self.range(axis));
        // as much room above and below as at the sides
        let room = 0.03 * range.iter().map(|(low, high)| high - low).fold(0.0, f64::max);
        let range = range.map(|(low, high)| (low - room, high + room));
        let size = range.map(|(low, high)| high - low);
        let columns = self.columns as f64;
        let width = (WIDTH - LEFT - RIGHT - (columns - 1.0) * FOOT) / columns;
        let scale = f64::min(width / size[0], 460.0 / size[1]);
        let [width, height] = size.map(|s| s * scale);
        let colors = Scale::over(self.views.iter().flat_map(|v| v.values.iter().copied()), self.value.unit());
        for (i, view) in self.views.iter().enumerate() {
            let corner =
                [LEFT + (i % self.columns) as f64 * (width + FOOT), TOP + HEAD + (i / self.columns) as f64 * (height + HEAD + FOOT)];
            svg.text([corner[0], corner[1] - 8.0], 13.0, Anchor::Start, &view.title);
            // a dot as wide as the room of a particle
            let radius = (0.5 * (width * height / view.points.len().max(1) as f64).sqrt()).clamp(0.8, 3.5);
            for ([x, y], value) in view.points.iter().zip(&view.values).filter(|(p, _)| p.iter().all(|v| v.is_finite())) {
                let at = [corner[0] + (x - range[0].0) * scale, corner[1] + (range[1].1 - y) * scale];
                svg.dot(at, radius, &hex(viridis(colors.share(*value))));
            }
            svg.rect(corner, [width, height], "none", INK);
            for (x, text) in ticks(range[0].0, range[0].1, 5) {
                svg.text([corner[0] + (x - range[0].0) * scale, corner[1] + height + 16.0], 12.0, Anchor::Middle, text);
            }
            if i % self.columns == 0 {
                for (y, text) in ticks(range[1].0, range[1].1, 4) {
                    svg.text([corner[0] - 6.0, corner[1] + (range[1].1 - y) * scale + 4.0], 12.0, Anchor::End, text);
                }
                svg.text_upwards([22.0, corner[1] + 0.5 * height], 12.0, "y [m]");
            }
            svg.text([corner[0] + 0.5 * width, corner[1] + height + 32.0], 12.0, Anchor::Middle, "x [m]");
        }
        let rows = self.views.len().div_ceil(self.columns) as f64;
        let total = (TOP + rows * (height + HEAD + FOOT)).max(TOP + HEAD + 180.0);
        let right = LEFT + columns.min(self.views.len() as f64) * (width + FOOT);
        svg.color_bar([right, TOP + HEAD], (height).clamp(140.0, 320.0), &colors, self.value.name());
        svg.finish(total)
    }

    /// Range of the positions along an axis.
    fn range(&self, axis: usize) -> (f64, f64) {
        let seen = |(low, high): (f64, f64), v: f64| (low.min(v), high.max(v));
        let all = self.views.iter().flat_map(|v| v.points.iter().map(|p| p[axis])).filter(|v| v.is_finite());
        let (low, high) = all.fold((f64::INFINITY, f64::NEG_INFINITY), seen);
        if low < high { (low, high) } else { (-0.5, 0.5) }
    }

    /// A row a particle: `view,x [m],y [m],value`.
    pub fn csv(&self) -> String {
        let mut out = format!("view,x [m],y [m],{}\n", quoted(&self.value.title()));
        for view in &self.views {
            for ([x, y], value) in view.points.iter().zip(&view.values) {
                let _ = writeln!(out, "{},{},{},{}", quoted(&view.title), short(*x), short(*y), short(*value));
            }
        }
        out
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn draws_views_side_by_side() {
        let view =
            |title: &str| View { title: title.into(), points: vec![[0.0, 0.0], [1.0, 0.5], [f64::NAN, 0.0]], values: vec![1.0, 2.0, 3.0] };
        let cloud = Cloud::new("stress", Axis::new("von Mises stress", "Pa"), [view("a"), view("b")]).columns(2);
        let svg = cloud.svg();
        assert!(!svg.contains("NaN") && svg.matches("<circle").count() == 4);
        assert_eq!(cloud.csv().lines().count(), 7);
        assert!(Cloud::new("none", Axis::new("v", ""), []).svg().contains("none"));
    }
}
