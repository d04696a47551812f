//! SVG as text: the few shapes that the pictures need, and the numbers on their axes.

use crate::color::viridis;
use std::fmt::{Display, Write};

/// Width of every picture \[px\].
pub(crate) const WIDTH: f64 = 900.0;
/// Colour of text and axes.
pub(crate) const INK: &str = "#222";
/// Colour of grid lines.
pub(crate) const FAINT: &str = "#e6e6e6";

/// Where a text is held.
#[derive(Clone, Copy)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

/// A picture while it is drawn; lengths in pixels, y down.
pub(crate) struct Svg {
    body: String,
}

impl Svg {
    pub(crate) fn new() -> Self {
        Self { body: String::new() }
    }

    /// Appends an element. Writing to a String cannot fail.
    fn push(&mut self, element: std::fmt::Arguments<'_>) {
        let _ = self.body.write_fmt(element);
        self.body.push('\n');
    }

    pub(crate) fn text(&mut self, [x, y]: [f64; 2], size: f64, anchor: Anchor, text: impl Display) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let text = escape(&text.to_string());
        self.push(format_args!(r#"<text x="{x:.1}" y="{y:.1}" font-size="{size}" text-anchor="{anchor}">{text}</text>"#));
    }

    /// Text that reads upwards, centred at a point.
    pub(crate) fn text_upwards(&mut self, [x, y]: [f64; 2], size: f64, text: impl Display) {
        let text = escape(&text.to_string());
        self.push(format_args!(
            r#"<text transform="translate({x:.1} {y:.1}) rotate(-90)" font-size="{size}" text-anchor="middle">{text}</text>"#
        ));
    }

    /// Text with a white rim that rises by an angle \[degrees\] from where it begins.
    pub(crate) fn text_rising(&mut self, [x, y]: [f64; 2], angle: f64, size: f64, text: impl Display) {
        let text = escape(&text.to_string());
        // the rim first, then the letters: not every program knows `paint-order`
        for rim in [r#" stroke="white" stroke-width="3""#, ""] {
            self.push(format_args!(
                r#"<text transform="translate({x:.1} {y:.1}) rotate({:.1})" font-size="{size}"{rim}>{text}</text>"#,
                -angle
            ));
        }
    }

    /// Text with a white rim, readable on any ground.
    pub(crate) fn label(&mut self, [x, y]: [f64; 2], text: impl Display) {
        let text = escape(&text.to_string());
        self.push(format_args!(
            r#"<text x="{x:.1}" y="{y:.1}" font-size="13" stroke="white" stroke-width="3" paint-order="stroke">{text}</text>"#
        ));
    }

    /// What is drawn until [`Svg::unclip`] shows only within a rectangle; `id` is a name that no other clip has.
    pub(crate) fn clip(&mut self, id: &str, [x, y]: [f64; 2], [w, h]: [f64; 2]) {
        self.push(format_args!(
            r##"<clipPath id="{id}"><rect x="{x:.1}" y="{y:.1}" width="{w:.1}" height="{h:.1}"/></clipPath><g clip-path="url(#{id})">"##
        ));
    }

    pub(crate) fn unclip(&mut self) {
        self.push(format_args!("</g>"));
    }

    pub(crate) fn line(&mut self, [x1, y1]: [f64; 2], [x2, y2]: [f64; 2], color: &str, width: f64) {
        self.push(format_args!(r#"<line x1="{x1:.1}" y1="{y1:.1}" x2="{x2:.1}" y2="{y2:.1}" stroke="{color}" stroke-width="{width}"/>"#));
    }

    /// A rectangle from its upper left corner.
    pub(crate) fn rect(&mut self, [x, y]: [f64; 2], [w, h]: [f64; 2], fill: &str, stroke: &str) {
        self.push(format_args!(r#"<rect x="{x:.1}" y="{y:.1}" width="{w:.1}" height="{h:.1}" fill="{fill}" stroke="{stroke}"/>"#));
    }

    pub(crate) fn circle(&mut self, [x, y]: [f64; 2], radius: f64, fill: &str, stroke: &str) {
        self.push(format_args!(r#"<circle cx="{x:.1}" cy="{y:.1}" r="{radius}" fill="{fill}" stroke="{stroke}" stroke-width="1.5"/>"#));
    }

    /// An area; its rim has the same colour, so that no seam shows between neighbours.
    pub(crate) fn area(&mut self, outline: &str, fill: &str) {
        self.push(format_args!(r#"<path d="{outline}" fill="{fill}" stroke="{fill}" stroke-width="0.4"/>"#));
    }

    /// A dot without a rim.
    pub(crate) fn dot(&mut self, [x, y]: [f64; 2], radius: f64, fill: &str) {
        self.push(format_args!(r#"<circle cx="{x:.1}" cy="{y:.1}" r="{radius:.1}" fill="{fill}"/>"#));
    }

    /// An outline without an area.
    pub(crate) fn outline(&mut self, outline: &str, stroke: &str, width: f64, dashes: &str) {
        self.push(format_args!(
            r#"<path d="{outline}" fill="none" stroke="{stroke}" stroke-width="{width}" stroke-dasharray="{dashes}"/>"#
        ));
    }

    /// A vertical colour bar, 16 px wide, with its ticks.
    pub(crate) fn color_bar(&mut self, [x, y]: [f64; 2], height: f64, scale: &Scale, title: &str) {
        const STEPS: usize = 64;
        for i in 0..STEPS {
            let fill = hex(viridis((i as f64 + 0.5) / STEPS as f64));
            let top = y + height * (1.0 - (i + 1) as f64 / STEPS as f64);
            self.area(&format!("M{x:.1} {top:.2}h16v{:.2}h-16z", height / STEPS as f64), &fill);
        }
        self.rect([x, y], [16.0, height], "none", INK);
        for (value, text) in scale.ticks(5) {
            let at = y + height * (1.0 - scale.share(value));
            self.line([x + 16.0, at], [x + 20.0, at], INK, 1.0);
            self.text([x + 24.0, at + 4.0], 12.0, Anchor::Start, text);
        }
        self.text_upwards([x - 8.0, y + 0.5 * height], 12.0, format_args!("{title} [{}]", scale.unit));
    }

    /// The whole file.
    pub(crate) fn finish(self, height: f64) -> String {
        format!(
            r##"<svg xmlns="http://www.w3.org/2000/svg" width="{WIDTH}" height="{height:.0}" viewBox="0 0 {WIDTH} {height:.0}"
 font-family="Helvetica, Arial, 'Liberation Sans', 'DejaVu Sans', sans-serif" fill="{INK}">
<defs><pattern id="hatch" width="6" height="6" patternUnits="userSpaceOnUse" patternTransform="rotate(45)">
<line x1="0" y1="0" x2="0" y2="6" stroke="#666" stroke-width="2"/></pattern>
<pattern id="region" width="8" height="8" patternUnits="userSpaceOnUse" patternTransform="rotate(45)">
<line x1="0" y1="0" x2="0" y2="8" stroke="#bbb" stroke-width="1.5"/></pattern></defs>
<rect width="100%" height="100%" fill="white"/>
{}</svg>
"##,
            self.body
        )
    }
}

/// Fill for walls, defined by [`Svg::finish`].
pub(crate) const HATCH: &str = "url(#hatch)";
/// Fill for held regions, in which bodies are seen.
pub(crate) const REGION: &str = "url(#region)";

/// A closed outline through `corners`, in the short relative form: pictures hold thousands of them.
pub(crate) fn polygon(out: &mut String, corners: &[[f64; 2]]) {
    // Steps are taken between rounded corners, so that rounding does not add up.
    let rounded = |v: f64| (v * 100.0).round() / 100.0;
    let mut last = [0.0; 2];
    for (i, corner) in corners.iter().enumerate() {
        let [x, y] = corner.map(rounded);
        let _ = match i {
            0 => write!(out, "M{x} {y}"),
            _ => write!(out, "l{} {}", rounded(x - last[0]), rounded(y - last[1])),
        };
        last = [x, y];
    }
    out.push('z');
}

/// `#rrggbb`.
pub(crate) fn hex([r, g, b]: [u8; 3]) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// A range of values with the SI prefix that makes its numbers short.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Scale {
    low: f64,
    high: f64,
    factor: f64,
    /// Unit with its prefix.
    pub(crate) unit: String,
}

impl Scale {
    /// From the smallest to the largest of `values`; never empty.
    pub(crate) fn over(values: impl IntoIterator<Item = f64>, unit: &str) -> Self {
        let seen = |(low, high): (f64, f64), v: f64| (low.min(v), high.max(v));
        let (mut low, mut high) = values.into_iter().filter(|v| v.is_finite()).fold((f64::INFINITY, f64::NEG_INFINITY), seen);
        if low > high {
            (low, high) = (0.0, 1.0);
        }
        let largest = low.abs().max(high.abs());
        // A constant is drawn in the middle of a range around it; round-off is no range.
        if high - low <= 1e-12 * largest || largest == 0.0 {
            let half = if largest == 0.0 { 1.0 } else { 0.5 * largest };
            (low, high) = (low - half, high + half);
        }
        // a pure number has no unit that a prefix could stand before
        let (factor, prefix) = if unit.is_empty() { (1.0, "") } else { prefix(low.abs().max(high.abs())) };
        Self { low, high, factor, unit: format!("{prefix}{unit}") }
    }

    /// Lower and upper end.
    pub(crate) fn ends(&self) -> [f64; 2] {
        [self.low, self.high]
    }

    /// 0 at the lower end, 1 at the upper end.
    pub(crate) fn share(&self, value: f64) -> f64 {
        (value - self.low) / (self.high - self.low)
    }

    /// About `count` round values in the range, each with its text.
    pub(crate) fn ticks(&self, count: usize) -> Vec<(f64, String)> {
        ticks(self.low / self.factor, self.high / self.factor, count).into_iter().map(|(v, text)| (v * self.factor, text)).collect()
    }
}

/// The power of a thousand below `value`, with its SI prefix.
fn prefix(value: f64) -> (f64, &'static str) {
    const PREFIXES: [(f64, &str); 9] =
        [(1e12, "T"), (1e9, "G"), (1e6, "M"), (1e3, "k"), (1.0, ""), (1e-3, "m"), (1e-6, "µ"), (1e-9, "n"), (1e-12, "p")];
    // A little below the next power still counts as it: 999.9999 is shown as 1 k.
    PREFIXES.into_iter().find(|(factor, _)| value >= factor * 0.999_999).unwrap_or((1.0, ""))
}

/// Round values (1, 2 or 5 times a power of ten apart) from `low` to `high`, each with its text.
pub(crate) fn ticks(low: f64, high: f64, count: usize) -> Vec<(f64, String)> {
    let rough = (high - low) / count.max(1) as f64;
    let power = 10f64.powf(rough.log10().floor());
    let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|&s| s >= 0.999 * rough).unwrap_or(10.0 * power);
    let decimals = (-step.log10().floor()).max(0.0) as usize;
    let slack = 1e-9 * (high - low);
    let (first, last) = (((low - slack) / step).ceil() as i64, ((high + slack) / step).floor() as i64);
    (first..=last).map(|i| (i as f64 * step, format!("{:.decimals$}", i as f64 * step))).collect()
}

fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round() {
        let texts = |low, high| ticks(low, high, 5).into_iter().map(|t| t.1).collect::<Vec<_>>();
        assert_eq!(texts(0.0, 9.0), ["0", "2", "4", "6", "8"]);
        assert_eq!(texts(-0.1, 0.1), ["-0.10", "-0.05", "0.00", "0.05", "0.10"]);
    }

    #[test]
    fn scale_has_a_prefix_and_a_width() {
        let scale = Scale::over([0.0, 2.5e5], "Pa");
        assert_eq!((scale.unit.as_str(), scale.share(1.25e5)), ("kPa", 0.5));
        assert_eq!(scale.ticks(5)[1].1, "50");
        assert_eq!(Scale::over([3.0, 3.0], "m").share(3.0), 0.5);
        assert_eq!(Scale::over([0.0], "Pa").share(0.0), 0.5);
    }

    #[test]
    fn rounding_does_not_add_up() {
        let mut path = String::new();
        polygon(&mut path, &[[0.004, 0.004], [1.008, 0.0], [1.0, 1.0]]);
        assert_eq!(path, "M0 0l1.01 0l-0.01 1z");
    }
}
