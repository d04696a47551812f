//! 8 STUDIES: many runs, compared with what others published. A study sees scenes and simulations from outside, as any adapter does.
//!
//! [`runner`] runs [`Job`]s side by side and keeps what they watched; [`chart`] and [`cloud`] draw it; [`report`] puts tables, figures
//! and findings into a Markdown file with pictures. A [`Study`] is a list of [`Problem`]s, one file a problem: [`papers`] holds those of the
//! papers, [`accuracy`] those whose answers are known, and how close the total-Lagrangian formulation comes to them. [`throughput`] is about time alone.
//!
//! ```
//! use matpoint::study::{Axis, Chart, Drawing, Figure, Finding, Job, Section, Series, Style, run, value};
//!
//! let scene = |speed: f64| format!(r#"
//!     title = "a block that drifts"
//!     dimension = 1
//!     grid = {{ origin = [0], size = [4], cell = 0.5 }}
//!     material.soft = {{ law = "neo_hookean", young = 1e3, density = 1e3 }}
//!     body.block = {{ material = "soft", shape = {{ box = {{ min = [1], max = [2] }} }}, velocity = [{speed}] }}
//!     time = {{ end = 1 }}
//! "#);
//! let job = |speed| Job::new(format!("X1/{speed}"), scene(speed)).every(0.1).watch("energy", value("energy/total", 0));
//! let runs = run(vec![job(0.5), job(1.0)], |_| {});
//!
//! let curve = |speed: f64| Some(Series::new(format!("{speed} m/s"), Style::Line, runs.get(&format!("X1/{speed}"))?.curve("energy")));
//! let chart = Chart::new("energy", Axis::new("time", "s"), Axis::new("energy", "J"), [0.5, 1.0].into_iter().filter_map(curve));
//! let finding = Finding::judge("1", "The energy stays.", true, || {
//!     let energy = runs.done("X1/1")?.samples("energy");
//!     let change = energy.last()? - energy.first()?;
//!     Some((format!("It changes by {change:.1e} J."), change.abs() < 1e-9))
//! });
//! let figure = Figure { name: "x1".into(), caption: "Figure 1".into(), drawing: Drawing::Chart(chart) };
//! let section = Section { title: "X1".into(), figures: vec![figure], findings: vec![finding], ..Section::default() };
//! assert_eq!(section.findings[0].holds, Some(true));
//! ```

pub mod accuracy;
pub mod chart;
pub mod cloud;
mod gallery;
pub mod papers;
mod problem;
mod reference;
pub mod report;
pub mod runner;
pub mod throughput;
mod tools;

pub use chart::{Axis, Chart, Panel, Series, Style};
pub use cloud::{Cloud, View};
pub use gallery::{GalleryError, gallery};
pub use problem::{Effort, Problem, Study};
pub use report::{Cell, Drawing, Figure, Finding, Report, Section, Table, Verdict};
pub use runner::{Job, Progress, Run, Runs, run, value};
