//! What all pictures share: the title, the legend, and words for boundaries.

use super::Snapshot;
use crate::scene::{Axis, Boundary};
use crate::svg::{Anchor, HATCH, INK, REGION, Svg, WIDTH};

/// Left end of titles and legends \[px\].
pub(super) const LEFT: f64 = 70.0;

/// Title and time; the drawing starts below 66 px.
pub(super) fn title(svg: &mut Svg, snapshot: &Snapshot) {
    svg.text([LEFT, 30.0], 18.0, Anchor::Start, &snapshot.scene.title);
    let particles = snapshot.len();
    svg.text([LEFT, 50.0], 13.0, Anchor::Start, format_args!("t = {} s, {particles} particles", number(snapshot.time)));
}

/// Six digits, without the round-off of a time behind them.
fn number(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}

/// What a legend says of a colour or a mark.
pub(super) enum Mark {
    /// A filled box.
    Fill(&'static str),
    /// A wall.
    Wall,
    /// A held region.
    Region,
    /// A watched point.
    Probe,
    /// No mark.
    None,
}

/// The entries that every picture has.
pub(super) fn entries(snapshot: &Snapshot) -> Vec<(Mark, String)> {
    let entry = |(name, boundary): (&String, &Boundary)| {
        let mark = if boundary.face.is_some() { Mark::Wall } else { Mark::Region };
        (mark, format!("{name}: {}", holds(boundary)))
    };
    let mut all: Vec<_> = snapshot.scene.boundary.iter().map(entry).collect();
    if !snapshot.probes.is_empty() {
        all.push((Mark::Probe, "probe".to_owned()));
    }
    all
}

/// A legend from `top` down, as many rows as it takes; returns the height of the whole picture.
pub(super) fn legend(svg: &mut Svg, top: f64, entries: &[(Mark, String)]) -> f64 {
    const ROW: f64 = 20.0;
    let (mut x, mut y) = (LEFT, top);
    for (mark, text) in entries {
        // No font is at hand to measure: 6.5 px is a little above the mean width of a letter at 12 px.
        let width = 6.5 * text.chars().count() as f64 + 42.0;
        if x + width > WIDTH && x > LEFT {
            (x, y) = (LEFT, y + ROW);
        }
        match mark {
            Mark::Fill(color) => svg.rect([x, y - 10.0], [16.0, 12.0], color, "#bbb"),
            Mark::Wall => svg.rect([x, y - 10.0], [16.0, 12.0], HATCH, INK),
            Mark::Region => svg.rect([x, y - 10.0], [16.0, 12.0], REGION, "#bbb"),
            Mark::Probe => svg.circle([x + 8.0, y - 4.0], 4.0, "white", INK),
            Mark::None => {}
        }
        let indent = if matches!(mark, Mark::None) { 0.0 } else { 22.0 };
        svg.text([x + indent, y], 12.0, Anchor::Start, text);
        x += width;
    }
    y + ROW
}

/// `x, y fixed; z moved`.
fn holds(boundary: &Boundary) -> String {
    let name = |axis: &Axis| match axis {
        Axis::X => "x",
        Axis::Y => "y",
        Axis::Z => "z",
    };
    let list = |axes: Vec<&str>, word: &str| if axes.is_empty() { None } else { Some(format!("{} {word}", axes.join(", "))) };
    let parts = [list(boundary.fixed.iter().map(name).collect(), "fixed"), list(boundary.velocity.keys().map(name).collect(), "moved")];
    parts.into_iter().flatten().collect::<Vec<_>>().join("; ")
}

/// Axis and side (true: upper) of a face name such as `x-`.
pub(super) fn side(face: &str) -> Option<(usize, bool)> {
    let (axis, sign) = face.split_at_checked(1)?;
    Some((["x", "y", "z"].iter().position(|&a| a == axis)?, sign == "+"))
}

/// Every how many cells a grid line is drawn, so that they are at least 6 px apart.
pub(super) fn line_stride(cell_px: f64) -> usize {
    [1, 2, 5, 10, 20, 50, 100, 200, 500].into_iter().find(|&k| k as f64 * cell_px >= 6.0).unwrap_or(1000)
}
