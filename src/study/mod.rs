//! 8 STUDIES: many runs, compared with what others published. A study sees scenes and simulations from outside, as any adapter does.
//!
//! [`runner`] runs [`Job`]s side by side and keeps what they watched; [`chart`] and [`cloud`] draw it; [`report`] puts tables, figures
//! and findings into a Markdown file with pictures; [`papers`] holds the problems of the papers, one file a problem.

pub mod chart;
pub mod cloud;
pub mod papers;
pub mod report;
pub mod runner;

pub use chart::{Axis, Chart, Panel, Series, Style};
pub use cloud::{Cloud, View};
pub use report::{Cell, Drawing, Figure, Finding, Report, Section, Table, Verdict};
pub use runner::{Job, Progress, Run, Runs, run, value};
