//! A roofline: what is reached, below what arithmetic and memory allow (Williams, Waterman and Patterson 2009).

use super::scenes::{self, APIC, Size};
use super::{Bench, Count, Entry};
use crate::study::chart::{quoted, short};
use crate::study::report::{Drawing, Figure, Section};
use crate::svg::{Anchor, FAINT, INK, Svg};
use std::fmt::Write;

/// Rates of operations over operations a byte, on logarithmic axes, under the limits of a machine.
#[derive(Debug, Clone, PartialEq)]
pub struct Roofline {
    /// What it shows, in one line.
    pub title: String,
    /// Name of each limit of arithmetic, and the limit \[flop/s\].
    pub peaks: Vec<(String, f64)>,
    /// Name of each limit of a memory, and the limit \[B/s\].
    pub slopes: Vec<(String, f64)>,
    /// Name of each point, its operations a byte \[flop/B\] and a second \[flop/s\].
    pub points: Vec<(String, [f64; 2])>,
}

const LEFT: f64 = 70.0;
const TOP: f64 = 50.0;
const PLOT: [f64; 2] = [470.0, 430.0];
/// Where the names of limits and points begin, and how far apart they are at least \[px\].
const NAMES: f64 = LEFT + PLOT[0] + 34.0;
const APART: f64 = 17.0;
const POINT: &str = "#d55e00";
const ROOF: &str = "#0072b2";

/// From values to shares of a logarithmic axis.
struct Log {
    low: f64,
    high: f64,
}

impl Log {
    fn share(&self, value: f64) -> f64 {
        (value / self.low).ln() / (self.high / self.low).ln()
    }

    /// 1, 2 and 5 times powers of ten.
    fn ticks(&self) -> Vec<f64> {
        let (first, last) = (self.low.log10().floor() as i32, self.high.log10().ceil() as i32);
        let all = (first..=last).flat_map(|power| [1.0, 2.0, 5.0].map(|m| m * 10f64.powi(power)));
        all.filter(|v| (self.low..=self.high).contains(v)).collect()
    }
}

impl Roofline {
    /// The picture.
    pub fn svg(&self) -> String {
        let most = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
        let least = |values: &mut dyn Iterator<Item = f64>| values.fold(f64::INFINITY, f64::min);
        let x = Log {
            low: 0.25 * least(&mut self.points.iter().map(|p| p.1[0]).chain([1.0])),
            high: 2.0 * most(&mut self.points.iter().map(|p| p.1[0]).chain([10.0])),
        };
        let y = Log {
            low: 0.5 * least(&mut self.points.iter().map(|p| p.1[1]).chain(self.slopes.iter().map(|s| s.1 * x.low))),
            high: 1.8 * most(&mut self.peaks.iter().map(|p| p.1)),
        };
        let place = |[a, b]: [f64; 2]| [LEFT + PLOT[0] * x.share(a), TOP + PLOT[1] * (1.0 - y.share(b))];
        let mut svg = Svg::new();
        svg.text([LEFT, 30.0], 17.0, Anchor::Start, &self.title);
        for tick in x.ticks() {
            let [at, _] = place([tick, y.low]);
            svg.line([at, TOP], [at, TOP + PLOT[1]], FAINT, 1.0);
            svg.text([at, TOP + PLOT[1] + 18.0], 12.0, Anchor::Middle, tick);
        }
        for tick in y.ticks() {
            let [_, at] = place([x.low, tick]);
            svg.line([LEFT, at], [LEFT + PLOT[0], at], FAINT, 1.0);
            svg.text([LEFT - 8.0, at + 4.0], 12.0, Anchor::End, 1e-9 * tick);
        }
        svg.text([LEFT + 0.5 * PLOT[0], TOP + PLOT[1] + 40.0], 13.0, Anchor::Middle, "operations a byte [flop/B]");
        svg.text_upwards([20.0, TOP + 0.5 * PLOT[1]], 13.0, "operations a second [Gflop/s]");
        svg.rect([LEFT, TOP], PLOT, "none", INK);
        let (top, fast) = (most(&mut self.peaks.iter().map(|p| p.1)), most(&mut self.slopes.iter().map(|s| s.1)));
        // all names that stand beside the picture: where they belong, and whether a point is there
        let mut names: Vec<(String, [f64; 2], bool)> = Vec::new();
        for (name, peak) in &self.peaks {
            let [from, to] = [(peak / fast).clamp(x.low, x.high), x.high].map(|intensity| place([intensity, *peak]));
            svg.line(from, to, ROOF, 1.6);
            names.push((format!("limit, {name}: {:.0}", 1e-9 * peak), to, false));
        }
        for (name, slope) in &self.slopes {
            svg.line(place([x.low, slope * x.low]), place([top / slope, top]), ROOF, 1.6);
            // below the line, along it, near its lower end: points begin to the right of that
            let [[x0, y0], [x1, y1]] = [place([1.2 * x.low, 1.2 * x.low * slope]), place([2.0 * x.low, 2.0 * x.low * slope])];
            let angle = (y0 - y1).atan2(x1 - x0);
            let below = [x0 + 14.0 * angle.sin(), y0 + 14.0 * angle.cos()];
            svg.text_rising(below, angle.to_degrees(), 12.0, format_args!("{name}: {:.0} GB/s", 1e-9 * slope));
        }
        names.extend(self.points.iter().map(|(name, at)| (format!("{name}: {:.1}", 1e-9 * at[1]), place(*at), true)));
        names.sort_by(|a, b| a.1[1].total_cmp(&b.1[1]));
        let heights = spread(&names.iter().map(|name| name.1[1]).collect::<Vec<_>>(), TOP + PLOT[1]);
        for ((name, at, is_point), height) in names.iter().zip(heights) {
            svg.line(*at, [LEFT + PLOT[0] + 8.0, height], "#999", 0.7);
            svg.line([LEFT + PLOT[0] + 8.0, height], [NAMES - 4.0, height], "#999", 0.7);
            if *is_point {
                svg.dot(*at, 4.0, POINT);
            }
            svg.text([NAMES, height + 4.0], 12.0, Anchor::Start, name);
        }
        svg.finish(TOP + PLOT[1] + 54.0)
    }

    /// Limits and points, a row each.
    pub fn csv(&self) -> String {
        let mut out = "kind,name,operations a byte [flop/B],value [flop/s or B/s]\n".to_owned();
        for (kind, limits) in [("arithmetic", &self.peaks), ("memory", &self.slopes)] {
            for (name, limit) in limits {
                let _ = writeln!(out, "{kind},{},,{}", quoted(name), short(*limit));
            }
        }
        for (name, [intensity, rate]) in &self.points {
            let _ = writeln!(out, "point,{},{},{}", quoted(name), short(*intensity), short(*rate));
        }
        out
    }
}

/// Heights of names, from top to bottom: as near to `wanted` as room for each allows, and none below `floor`.
fn spread(wanted: &[f64], floor: f64) -> Vec<f64> {
    let mut heights = wanted.to_vec();
    for i in 1..heights.len() {
        heights[i] = heights[i].max(heights[i - 1] + APART);
    }
    let mut most = floor;
    for height in heights.iter_mut().rev() {
        *height = height.min(most);
        most = *height - APART;
    }
    heights
}

pub(super) fn section(bench: &mut Bench) -> Result<Section, String> {
    let machine = bench.machine()?.clone();
    if bench.points.is_empty() {
        // no other part has measured anything
        let name = "common work";
        let size = bench.effort.pick(Size::QUICK, Size::COMMON);
        let entries = vec![Entry::scene(name, scenes::block(size, APIC, 1), 20), Entry::peak()];
        let race = bench.race("roofline", &entries, bench.rounds())?;
        let Some(rate) = race.at_peak(name, machine.peak()) else {
            return Err(race.faults.into_iter().map(|fault| fault.1).collect());
        };
        bench.points.push((format!("{name}, {} particles", size.particles()), Count::COMMON, rate));
    }
    let roofline = Roofline {
        title: "What is reached with one thread, and what the machine allows".into(),
        peaks: machine.peaks.iter().map(|(set, peak)| (format!("{}, double", set.name()), *peak)).collect(),
        slopes: vec![("triad in L2".into(), machine.cache), ("triad in memory".into(), machine.memory)],
        points: bench.points.iter().map(|(name, count, rate)| (name.clone(), [count.intensity(), count.flops() * rate])).collect(),
    };
    let figure = Figure {
        name: "roofline".into(),
        caption: "Operations a second over operations a byte, one thread, with the limits measured in the same run".into(),
        drawing: Drawing::Roofline(roofline),
    };
    Ok(Section {
        title: "Roofline".into(),
        text: "Operations and bytes as counted by the formulas of `src/study/throughput/count.rs`: bytes are those of one pass over the state, \
               which a body in a cache does not take from memory. Each point has the share of the multiply-adds that it had in its own rounds, for \
               the machine may have changed its speed since."
            .into(),
        figures: vec![figure],
        ..Section::default()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_do_not_overlap() {
        let heights = spread(&[10.0, 11.0, 80.0, 95.0, 99.0], 100.0);
        assert!(heights.windows(2).all(|pair| pair[1] - pair[0] >= APART) && heights[4] <= 100.0, "{heights:?}");
        assert_eq!(heights[0], 10.0);
    }

    #[test]
    fn every_limit_and_point_is_in_picture_and_table() {
        let roofline = Roofline {
            title: "t".into(),
            peaks: vec![("wide".into(), 9e10), ("narrow".into(), 1e10)],
            slopes: vec![("near".into(), 7e10), ("far".into(), 1.4e10)],
            points: vec![("a".into(), [3.0, 2e10]), ("b".into(), [3.0, 2e10])],
        };
        let (svg, csv) = (roofline.svg(), roofline.csv());
        assert!(!svg.contains("NaN") && !svg.contains("inf") && svg.matches("<circle").count() == 2);
        assert!(["wide", "narrow", "near", "far"].iter().all(|name| svg.contains(name)) && csv.lines().count() == 7);
    }
}
