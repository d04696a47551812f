//! Line charts as SVG, 900 px wide: one panel, or several on top of each other over the same x axis.

use crate::svg::{Anchor, FAINT, INK, Scale, Svg, WIDTH, ticks};
use std::fmt::Write;

/// A line chart.
#[derive(Debug, Clone, PartialEq)]
pub struct Chart {
    /// What it shows, in one line.
    pub title: String,
    /// The axis that all panels share.
    pub x: Axis,
    /// From top to bottom.
    pub panels: Vec<Panel>,
}

/// One quantity over x.
#[derive(Debug, Clone, PartialEq)]
pub struct Panel {
    /// The quantity.
    pub y: Axis,
    /// What is drawn, the last on top. Series of one name in several panels look alike and have one entry in the legend.
    pub series: Vec<Series>,
}

/// An axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    name: String,
    unit: &'static str,
    log: bool,
    range: Option<[f64; 2]>,
    marks: Vec<f64>,
}

impl Axis {
    /// A linear axis over all that is drawn; `unit` takes an SI prefix.
    pub fn new(name: impl Into<String>, unit: &'static str) -> Self {
        Self { name: name.into(), unit, log: false, range: None, marks: Vec::new() }
    }

    /// Logarithmic; values that are not positive are left out.
    pub fn log(mut self) -> Self {
        self.log = true;
        self
    }

    /// Shows this range only; what lies outside is cut off.
    pub fn within(mut self, low: f64, high: f64) -> Self {
        self.range = Some([low, high]);
        self
    }

    /// Has its numbers at these values (on a logarithmic axis).
    pub fn marks(mut self, marks: impl IntoIterator<Item = f64>) -> Self {
        self.marks = marks.into_iter().collect();
        self
    }

    pub(super) fn name(&self) -> &str {
        &self.name
    }

    pub(super) fn unit(&self) -> &'static str {
        self.unit
    }

    /// `displacement [m]`; a pure number has no brackets.
    pub(super) fn title(&self) -> String {
        titled(&self.name, self.unit)
    }
}

/// A curve, or points.
#[derive(Debug, Clone, PartialEq)]
pub struct Series {
    name: String,
    points: Vec<[f64; 2]>,
    style: Style,
    color: Option<usize>,
}

/// How a series is drawn.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Style {
    /// A line.
    Line,
    /// A line in ink, dashed, on top of all others: what is known.
    Reference,
    /// Points.
    Markers,
    /// Points as rings, which show what lies below them.
    Rings,
    /// Points with a line through them.
    Joined,
    /// A short line at the bottom of the panel for each point; y counts for nothing.
    Pulses,
}

impl Series {
    /// A series in the next colour of the palette.
    pub fn new(name: impl Into<String>, style: Style, points: impl IntoIterator<Item = [f64; 2]>) -> Self {
        Self { name: name.into(), points: points.into_iter().collect(), style, color: None }
    }

    /// Takes this colour of the palette, so that a method looks the same in every chart.
    pub fn color(mut self, index: usize) -> Self {
        self.color = Some(index);
        self
    }
}

/// Okabe and Ito: told apart by the colour-blind, and in print.
const PALETTE: [&str; 7] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8c6d31"];
/// Dashes of references, in the order of their names.
const DASHES: [&str; 3] = ["7 4", "2 3", "9 3 2 3"];

const LEFT: f64 = 92.0;
const PLOT: f64 = WIDTH - LEFT - 34.0;
const GAP: f64 = 20.0;
/// Height of a legend row \[px\].
const ROW: f64 = 20.0;

impl Chart {
    /// A chart of one panel.
    pub fn new(title: impl Into<String>, x: Axis, y: Axis, series: impl IntoIterator<Item = Series>) -> Self {
        Self::stacked(title, x, [Panel { y, series: series.into_iter().collect() }])
    }

    /// Several panels over one x axis.
    pub fn stacked(title: impl Into<String>, x: Axis, panels: impl IntoIterator<Item = Panel>) -> Self {
        Self { title: title.into(), x, panels: panels.into_iter().collect() }
    }

    /// The picture.
    pub fn svg(&self) -> String {
        let mut svg = Svg::new();
        svg.text([LEFT, 30.0], 17.0, Anchor::Start, &self.title);
        let looks = self.looks();
        let mut top = legend(&mut svg, 54.0, &looks) + 6.0;
        let height = if self.panels.len() > 1 { 230.0 } else { 360.0 };
        let all = || self.panels.iter().flat_map(|p| &p.series);
        let x = Ruler::new(&self.x, all().flat_map(|s| s.points.iter().map(|p| p[0])), 0.0, 9);
        for (number, panel) in self.panels.iter().enumerate() {
            self.panel(&mut svg, number, panel, &x, top, height, &looks);
            top += height + GAP;
        }
        top -= GAP;
        for (value, text) in &x.ticks {
            svg.text([LEFT + PLOT * x.share(*value), top + 18.0], 12.0, Anchor::Middle, text);
        }
        svg.text([LEFT + 0.5 * PLOT, top + 40.0], 13.0, Anchor::Middle, titled(&self.x.name, &x.unit));
        svg.finish(top + 54.0)
    }

    fn panel(&self, svg: &mut Svg, number: usize, panel: &Panel, x: &Ruler, top: f64, height: f64, looks: &[Look]) {
        let values = panel.series.iter().filter(|s| s.style != Style::Pulses).flat_map(|s| s.points.iter().map(|p| p[1]));
        let y = Ruler::new(&panel.y, values, 0.06, if height > 300.0 { 7 } else { 5 });
        let place = |p: &[f64; 2]| [LEFT + PLOT * x.share(p[0]), top + height * (1.0 - y.share(p[1]))];
        for (value, _) in &x.ticks {
            let at = LEFT + PLOT * x.share(*value);
            svg.line([at, top], [at, top + height], FAINT, 1.0);
        }
        for (value, text) in &y.ticks {
            let at = top + height * (1.0 - y.share(*value));
            svg.line([LEFT, at], [LEFT + PLOT, at], FAINT, 1.0);
            svg.text([LEFT - 8.0, at + 4.0], 12.0, Anchor::End, text);
        }
        svg.clip(&format!("panel{number}"), [LEFT, top], [PLOT, height]);
        // what is known lies on top
        let (known, ours): (Vec<&Series>, Vec<&Series>) = panel.series.iter().partition(|s| s.style == Style::Reference);
        for series in ours.into_iter().chain(known) {
            let Some(look) = looks.iter().find(|look| look.name == series.name) else { continue };
            let shown: Vec<[f64; 2]> = series.points.iter().map(place).collect();
            match series.style {
                Style::Line | Style::Joined => svg.outline(&outline(&shown), look.color, 1.6, ""),
                Style::Reference => svg.outline(&outline(&shown), look.color, 1.4, look.dashes),
                Style::Markers | Style::Rings => {}
                Style::Pulses => {
                    shown.iter().for_each(|p| svg.line([p[0], top + height], [p[0], top + height - 16.0], look.color, 1.2));
                }
            }
            let inside = shown.iter().filter(|p| p.iter().all(|v| v.is_finite()) && (top..=top + height).contains(&p[1]));
            inside.for_each(|p| marker(svg, *p, series.style, look.color, shown.len()));
        }
        svg.unclip();
        svg.rect([LEFT, top], [PLOT, height], "none", INK);
        svg.text_upwards([26.0, top + 0.5 * height], 13.0, titled(&panel.y.name, &y.unit));
    }

    /// What each name looks like, in the order of the legend.
    fn looks(&self) -> Vec<Look<'_>> {
        let mut looks: Vec<Look> = Vec::new();
        let (mut colors, mut dashes) = (0, 0);
        // what has no point is not in the picture
        for series in self.panels.iter().flat_map(|p| &p.series).filter(|s| !s.points.is_empty()) {
            if looks.iter().any(|look| look.name == series.name) {
                continue;
            }
            let (color, dash) = if series.style == Style::Reference {
                dashes += 1;
                (INK, DASHES[(dashes - 1) % DASHES.len()])
            } else {
                colors += 1;
                (PALETTE[series.color.unwrap_or(colors - 1) % PALETTE.len()], "")
            };
            looks.push(Look { name: &series.name, style: series.style, color, dashes: dash });
        }
        looks
    }

    /// Every point of every series, a row each: `panel,series,x,y`, the axes named in the header.
    pub fn csv(&self) -> String {
        let names: Vec<String> = self.panels.iter().map(|p| p.y.title()).collect();
        let mut out = format!("panel,series,{},value\n", quoted(&self.x.title()));
        for (panel, name) in self.panels.iter().zip(&names) {
            for series in &panel.series {
                for [x, y] in series.points.iter().map(|p| p.map(short)) {
                    let _ = writeln!(out, "{},{},{x},{y}", quoted(name), quoted(&series.name));
                }
            }
        }
        out
    }
}

struct Look<'a> {
    name: &'a str,
    style: Style,
    color: &'static str,
    dashes: &'static str,
}

/// Draws the legend in as many rows as it takes; returns its lower end.
fn legend(svg: &mut Svg, top: f64, looks: &[Look]) -> f64 {
    let (mut x, mut y) = (LEFT, top);
    for look in looks {
        // no font is at hand to measure: 6.6 px is a little above the mean width of a letter at 12.5 px
        let width = 6.6 * look.name.chars().count() as f64 + 54.0;
        if x + width > WIDTH && x > LEFT {
            (x, y) = (LEFT, y + ROW);
        }
        let middle = y - 4.0;
        let line = outline(&[[x, middle], [x + 26.0, middle]]);
        match look.style {
            Style::Line | Style::Reference | Style::Joined => svg.outline(&line, look.color, 2.0, look.dashes),
            Style::Pulses => svg.line([x + 13.0, y + 2.0], [x + 13.0, y - 11.0], look.color, 1.6),
            Style::Markers | Style::Rings => {}
        }
        marker(svg, [x + 13.0, middle], look.style, look.color, 1);
        svg.text([x + 32.0, y], 12.5, Anchor::Start, look.name);
        x += width;
    }
    y + ROW - 10.0
}

/// The mark of one of `count` points, for styles that have marks.
fn marker(svg: &mut Svg, at: [f64; 2], style: Style, color: &str, count: usize) {
    match style {
        Style::Markers | Style::Joined => svg.dot(at, if count > 100 { 1.8 } else { 3.2 }, color),
        Style::Rings => svg.circle(at, 6.0, "none", color),
        Style::Line | Style::Reference | Style::Pulses => {}
    }
}

/// A line through points; it is broken where a point cannot be drawn.
fn outline(points: &[[f64; 2]]) -> String {
    let mut path = String::new();
    let mut drawing = false;
    let mut last = [f64::NAN; 2];
    for [x, y] in points {
        // far outside is outside; numbers with many digits are not for a picture
        let y = y.clamp(-1e4, 1e4);
        if !x.is_finite() || y.is_nan() {
            drawing = false;
            continue;
        }
        // points that nobody can tell from the one before
        if drawing && (x - last[0]).abs() < 0.4 && (y - last[1]).abs() < 0.4 {
            continue;
        }
        let _ = write!(path, "{}{x:.1} {y:.1}", if drawing { 'L' } else { 'M' });
        (drawing, last) = (true, [*x, y]);
    }
    path
}

/// From values to shares of an axis.
struct Ruler {
    low: f64,
    high: f64,
    log: bool,
    ticks: Vec<(f64, String)>,
    unit: String,
}

impl Ruler {
    /// `margin` is the share of the range that stays free at both ends.
    fn new(axis: &Axis, values: impl Iterator<Item = f64>, margin: f64, count: usize) -> Self {
        let usable = values.filter(|v| v.is_finite() && (!axis.log || *v > 0.0));
        let seen = |(low, high): (f64, f64), v: f64| (low.min(v), high.max(v));
        let (mut low, mut high) = usable.fold((f64::INFINITY, f64::NEG_INFINITY), seen);
        if let Some([a, b]) = axis.range {
            (low, high) = (a, b);
        } else if axis.log {
            let room = (high / low).powf(margin.max(0.03)).max(1.05);
            (low, high) = if low <= high { (low / room, high * room) } else { (0.1, 1.0) };
        } else if low <= high {
            let room = margin * (high - low);
            (low, high) = (low - room, high + room);
        }
        if axis.log {
            let ticks = if axis.marks.is_empty() { decades(low, high) } else { axis.marks.iter().map(|&v| (v, v.to_string())).collect() };
            return Self { low: low.log10(), high: high.log10(), log: true, ticks, unit: axis.unit.to_owned() };
        }
        let scale = Scale::over([low, high], axis.unit);
        let [low, high] = scale.ends();
        Self { low, high, log: false, ticks: scale.ticks(count), unit: scale.unit }
    }

    fn share(&self, value: f64) -> f64 {
        ((if self.log { value.log10() } else { value }) - self.low) / (self.high - self.low)
    }
}

/// Powers of ten; 1, 2 and 5 times them where there are few.
fn decades(low: f64, high: f64) -> Vec<(f64, String)> {
    let (first, last) = (low.log10().ceil() as i32, high.log10().floor() as i32);
    if last > first {
        let stride = ((last - first) / 8 + 1) as usize;
        return (first..=last).step_by(stride).map(|power| (10f64.powi(power), power_of_ten(power))).collect();
    }
    let fine = (first - 1..=last + 1).flat_map(|power| [1.0, 2.0, 5.0].map(|m| m * 10f64.powi(power)));
    let near = fine.filter(|v| (low..=high).contains(v)).map(|v| (v, format!("{v:e}"))).collect::<Vec<_>>();
    if near.is_empty() { ticks(low, high, 4) } else { near }
}

fn power_of_ten(power: i32) -> String {
    if power == 0 {
        return "1".to_owned();
    }
    let raised = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => char::from_u32('⁰' as u32 + digit as u32 - '0' as u32).unwrap_or(digit),
    };
    format!("10{}", power.to_string().chars().map(raised).collect::<String>())
}

fn titled(name: &str, unit: &str) -> String {
    if unit.is_empty() { name.to_owned() } else { format!("{name} [{unit}]") }
}

/// Seven digits: more than a picture or a comparison needs.
pub(super) fn short(value: f64) -> f64 {
    format!("{value:.6e}").parse().unwrap_or(value)
}

/// A field of a CSV row.
pub(super) fn quoted(text: &str) -> String {
    if text.contains([',', '"']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_are_written_raised() {
        assert_eq!([power_of_ten(-12), power_of_ten(0), power_of_ten(3)], ["10⁻¹²", "1", "10³"]);
        let texts = |low, high| decades(low, high).into_iter().map(|t| t.1).collect::<Vec<_>>();
        assert_eq!(texts(2e-4, 0.3), ["10⁻³", "10⁻²", "10⁻¹"]);
        assert_eq!(texts(0.15, 0.6), ["2e-1", "5e-1"]);
    }

    #[test]
    fn a_chart_survives_what_cannot_be_drawn() {
        let series = Series::new("a <b>", Style::Joined, [[0.0, f64::NAN], [1.0, 1e300], [2.0, f64::INFINITY], [3.0, -1.0]]);
        for y in [Axis::new("y", "m"), Axis::new("y", "").log(), Axis::new("y", "m").within(0.0, 1.0)] {
            let svg = Chart::new("t", Axis::new("x", "s"), y, [series.clone()]).svg();
            assert!(!svg.contains("NaN") && !svg.contains("inf") && svg.contains("a &lt;b&gt;"), "{svg}");
        }
        assert!(Chart::stacked("empty", Axis::new("x", "s"), []).svg().contains("empty"));
    }

    #[test]
    fn csv_has_a_row_a_point() {
        let chart = Chart::new("t", Axis::new("x, along", "m"), Axis::new("u", "m"), [Series::new("s", Style::Line, [[0.5, 2.0]])]);
        assert_eq!(chart.csv(), "panel,series,\"x, along [m]\",value\nu [m],s,0.5,2\n");
    }
}
