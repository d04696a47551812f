//! Run time against error: methods of high order beside the classical ones, on problems with known answers.
//!
//! A [`Race`] is a problem, the methods that solve it and the grids of each; all its runs are timed with nothing beside them. `bar`, `manufactured`,
//! `rings` and `cube` hold the races.

pub(super) mod bar;
pub(super) mod cube;
pub(super) mod manufactured;
pub(super) mod rings;

use super::{order, tabulate};
use crate::Simulation;
use crate::component::ComponentError;
use crate::study::tools::{chart, small, times};
use crate::study::{Axis, Chart, Effort, Figure, Finding, Job, Panel, Run, Runs, Section, Series, Style, Table};

/// What is measured: root mean squares over the particles.
const KINDS: [(&str, &str); 2] = [("displacement", "m"), ("stress", "Pa")];

/// Share of the stable step: a tenth of the default one.
const SHORT: f64 = 0.04;

/// A method of solution.
pub(super) struct Method {
    name: &'static str,
    toml: &'static str,
    kind: Kind,
    color: usize,
}

#[derive(Clone, Copy, PartialEq)]
enum Kind {
    /// Moves through the grid with an error in time of second order: steps go with the square of the cell, so that it falls as that in space.
    Moving,
    /// The grid moves with the body; fourth order in time, at the default share of the stable step.
    Total,
    /// Order two or less in space: at the default share of the stable step.
    Classical,
}

const UPDATED: Method = Method {
    name: "updated, degree 3",
    toml: r#"degree = 3, mass = "consistent", mass_residual = 1e-13, quadrature = "splines", quadrature_of = "force_and_velocity""#,
    kind: Kind::Moving,
    color: 0,
};
const TOTAL: Method = Method {
    name: "total, degree 3",
    toml: r#"formulation = "total", degree = 3, integrator = "symplectic4""#,
    kind: Kind::Total,
    color: 2,
};
const LINEAR: Method = classical("linear, FLIP", r#"basis = "linear""#, 1);
const GIMP: Method = classical("GIMP, FLIP", r#"basis = "gimp""#, 4);
const FLIP: Method = classical("quadratic, FLIP", "degree = 2", 3);
const APIC: Method = classical("quadratic, APIC", r#"degree = 2, transfer = "apic""#, 5);
const CLASSICAL: [&Method; 4] = [&LINEAR, &GIMP, &FLIP, &APIC];

const fn classical(name: &'static str, toml: &'static str, color: usize) -> Method {
    Method { name, toml, kind: Kind::Classical, color }
}

/// A problem that methods solve side by side.
pub(super) struct Race {
    /// Short name, with which the names of its runs begin.
    pub(super) id: &'static str,
    /// What it is, in one line.
    pub(super) title: &'static str,
    heading: &'static str,
    text: &'static str,
    /// What a grid is counted in.
    cells: &'static str,
    /// End \[s\].
    end: f64,
    /// Forms of the problem: name, and what stands for it in names of files. A single one has no name.
    forms: &'static [(&'static str, &'static str)],
    /// Methods and their grids: of the quick subset, and all.
    ours: &'static [(&'static Method, [&'static [usize]; 2])],
    classical: [&'static [usize]; 2],
    /// Step \[s\] of a method that moves through the grid.
    step: fn(usize) -> f64,
    /// Form, method, cells, and what the scene says of time.
    scene: fn(usize, &Method, usize, &str) -> String,
    /// Errors of displacement \[m\] and stress \[Pa\] at the end.
    errors: fn(&mut Simulation) -> Result<Vec<f64>, ComponentError>,
    required: &'static [Required],
    /// Grid on which the classical methods run with a tenth of their steps too, in the first form: of the quick subset, and of all.
    shorter: Option<[usize; 2]>,
}

/// What is asked of a method, in each form.
struct Required {
    method: &'static Method,
    /// Cells, and the largest errors with them.
    at: Option<(usize, [f64; 2])>,
    /// Least order of the displacement, and of the stress where something is asked of it.
    orders: &'static [f64],
    /// Coarsest grid that counts for them.
    from: usize,
}

/// The run of a method on a grid.
struct Entry {
    form: usize,
    method: &'static Method,
    cells: usize,
}

/// Errors that the simulation computes.
fn known(sim: &mut Simulation) -> Result<Vec<f64>, ComponentError> {
    ["error/displacement", "error/stress"].into_iter().map(|name| Ok(sim.get(name)?[0])).collect()
}

impl Race {
    fn grids(&self, effort: Effort, method: &Method) -> &'static [usize] {
        let given = self.ours.iter().find(|(ours, _)| ours.name == method.name).map_or(self.classical, |(_, grids)| *grids);
        effort.pick(given[0], given[1])
    }

    fn methods(&self) -> impl Iterator<Item = &'static Method> + '_ {
        self.ours.iter().map(|(method, _)| *method).chain(CLASSICAL)
    }

    fn entries(&self, effort: Effort, form: usize) -> impl Iterator<Item = Entry> + '_ {
        self.methods().flat_map(move |method| self.grids(effort, method).iter().map(move |&cells| Entry { form, method, cells }))
    }

    fn name(&self, entry: &Entry) -> String {
        let form = self.forms[entry.form].0;
        format!("{}/{form}{}{}, {} {}", self.id, if form.is_empty() { "" } else { ", " }, entry.method.name, entry.cells, self.cells)
    }

    /// The runs, grid after grid and in each all methods: what slows the machine for a while slows all of them.
    pub(super) fn jobs(&self, effort: Effort) -> Vec<Job> {
        let mut entries: Vec<(usize, Entry)> = Vec::new();
        for form in 0..self.forms.len() {
            for method in self.methods() {
                let grids = self.grids(effort, method).iter().enumerate();
                entries.extend(grids.map(|(level, &cells)| (level, Entry { form, method, cells })));
            }
        }
        entries.sort_by_key(|(level, _)| *level);
        let job = |(_, entry): (usize, Entry)| {
            let end = self.end;
            let time = match entry.method.kind {
                Kind::Moving => format!("end = {end}, step = {}", (self.step)(entry.cells)),
                Kind::Total | Kind::Classical => format!("end = {end}"),
            };
            let scene = (self.scene)(entry.form, entry.method, entry.cells, &time);
            Job::new(self.name(&entry), scene).alone().keep(end, "errors", self.errors)
        };
        let shorter = self.shorter(effort).map(|entry| {
            let scene = (self.scene)(0, entry.method, entry.cells, &format!("end = {}, cfl = {SHORT}", self.end));
            Job::new(self.short_name(&entry), scene).alone().keep(self.end, "errors", self.errors)
        });
        entries.into_iter().map(job).chain(shorter).collect()
    }

    /// The classical methods that run with a tenth of their steps too.
    fn shorter(&self, effort: Effort) -> impl Iterator<Item = Entry> + use<> {
        let cells = self.shorter.map(|[quick, full]| effort.pick(quick, full));
        cells.into_iter().flat_map(|cells| CLASSICAL.into_iter().map(move |method| Entry { form: 0, method, cells }))
    }

    fn short_name(&self, entry: &Entry) -> String {
        format!("{}, a tenth of the step", self.name(entry))
    }

    /// What shorter steps do to the classical methods.
    fn shorter_table(&self, effort: Effort, runs: &Runs) -> Option<Table> {
        let header = ["method, step", "steps", "wall time [s]", "displacement [m]", "stress [Pa]"];
        let cells = self.shorter(effort).next()?.cells;
        let rows = self.shorter(effort).flat_map(|entry| {
            let row = |what: &str, name: String| {
                let run = runs.done(&name);
                let errors = run.and_then(|run| run.at(self.end, "errors"));
                let error = |kind: usize| errors.and_then(|errors| errors.get(kind).copied());
                (format!("{}{what}", entry.method.name), vec![run.map(|r| r.substeps as f64), run.map(|r| r.wall), error(0), error(1)])
            };
            [row("", self.name(&entry)), row(", a tenth of it", self.short_name(&entry))]
        });
        Some(tabulate(
            &format!("What shorter steps do to the classical methods, {}, {cells} {}", self.forms[0].0, self.cells),
            &header,
            rows,
            |r| r,
        ))
    }

    fn run<'a>(&self, runs: &'a Runs, entry: &Entry) -> Option<&'a Run> {
        runs.done(&self.name(entry))
    }

    /// Errors of a run that reached its end.
    fn errors(&self, runs: &Runs, entry: &Entry) -> Option<[f64; 2]> {
        self.run(runs, entry)?.at(self.end, "errors")?.try_into().ok().filter(|errors: &[f64; 2]| errors.iter().all(|e| e.is_finite()))
    }

    /// Wall time \[s\] and error of each run of a method that reached its end, and what the run was.
    fn costs(&self, effort: Effort, runs: &Runs, form: usize, kind: usize) -> Vec<(Entry, f64, f64)> {
        let cost = |entry: Entry| {
            let (wall, error) = (self.run(runs, &entry)?.wall, self.errors(runs, &entry)?[kind]);
            Some((entry, wall, error))
        };
        self.entries(effort, form).filter_map(cost).collect()
    }

    /// Order over the grids of a method that count; `None` where one is missing.
    fn order(&self, effort: Effort, runs: &Runs, form: usize, required: &Required, kind: usize) -> Option<f64> {
        let method = required.method;
        let grids = self.grids(effort, method).iter().filter(|&&cells| cells >= required.from);
        let found: Option<Vec<[f64; 2]>> =
            grids.map(|&cells| Some([cells as f64, self.errors(runs, &Entry { form, method, cells })?[kind]])).collect();
        order(&found?)
    }

    fn table(&self, effort: Effort, runs: &Runs, form: usize) -> Table {
        let header = ["method", "steps", "wall time [s]", "displacement [m]", "order", "stress [Pa]", "order"];
        let row = |entry: Entry| {
            let coarser = self.grids(effort, entry.method).iter().rev().find(|&&cells| cells < entry.cells);
            let before = coarser.and_then(|&cells| Some((cells, self.errors(runs, &Entry { cells, ..entry })?)));
            let errors = self.errors(runs, &entry);
            let slope = |kind: usize| {
                let (cells, before) = before?;
                order(&[[cells as f64, before[kind]], [entry.cells as f64, errors?[kind]]])
            };
            let run = self.run(runs, &entry);
            let ended = if run.is_some() { "" } else { ": failed, see below" };
            let [u, s] = [0, 1].map(|kind| errors.map(|e| e[kind]));
            (
                format!("{}, {} {}{ended}", entry.method.name, entry.cells, self.cells),
                vec![run.map(|r| r.substeps as f64), run.map(|r| r.wall), u, slope(0), s, slope(1)],
            )
        };
        let form_name = self.forms[form].0;
        let title =
            if form_name.is_empty() { "Run time and RMS errors".to_owned() } else { format!("Run time and RMS errors, {form_name}") };
        tabulate(&title, &header, self.entries(effort, form), row)
    }

    fn figure(&self, effort: Effort, runs: &Runs, form: usize) -> Figure {
        let panels = [0, 1].map(|kind| {
            let costs = self.costs(effort, runs, form, kind);
            let series = self.methods().map(|method| {
                let own = costs.iter().filter(|(entry, ..)| entry.method.name == method.name);
                Series::new(method.name, Style::Joined, own.map(|(_, wall, error)| [*wall, *error])).color(method.color)
            });
            let (what, unit) = KINDS[kind];
            Panel { y: Axis::new(format!("RMS error, {what} [{unit}]"), "").log(), series: series.collect() }
        });
        let (name, slug) = self.forms[form];
        let comma = if name.is_empty() { "" } else { ", " };
        let title = format!("RMS errors over run time, a point a grid{comma}{name}");
        let axis = Axis::new("wall time [s]", "").log();
        chart(
            &format!("cost-{}{slug}", self.id.to_lowercase().trim_end_matches("-cost")),
            &format!("{}: {title}", self.heading),
            Chart::stacked(title, axis, panels),
        )
    }

    /// What it takes to be as close as the classical methods ever are.
    fn sentence(&self, effort: Effort, runs: &Runs, form: usize, kind: usize) -> Option<String> {
        let costs = self.costs(effort, runs, form, kind);
        let (classical, ours): (Vec<_>, Vec<_>) = costs.into_iter().partition(|(entry, ..)| entry.method.kind == Kind::Classical);
        let (best, wall, error) = classical.into_iter().min_by(|a, b| a.2.total_cmp(&b.2))?;
        let reach = self.ours.iter().map(|(method, _)| {
            let good = ours.iter().filter(|(entry, _, own)| entry.method.name == method.name && *own <= error);
            match good.min_by(|a, b| a.1.total_cmp(&b.1)) {
                None => format!("{} does not reach it on these grids", method.name),
                Some((entry, own, reached)) => {
                    let factor = if *own < wall { format!("{} less", times(wall / own)) } else { format!("{} more", times(own / wall)) };
                    format!(
                        "{} is below it, at {}, with {} {} in {}: {factor} time",
                        method.name,
                        small(*reached),
                        entry.cells,
                        self.cells,
                        seconds(*own)
                    )
                }
            }
        });
        let (what, unit) = KINDS[kind];
        let form = self.forms[form].0;
        Some(format!(
            "- {what}{}{form}: the least error of the classical methods is {} {unit} ({}, {} {}, {}); {}.",
            if form.is_empty() { "" } else { ", " },
            small(error),
            best.method.name,
            best.cells,
            self.cells,
            seconds(wall),
            reach.collect::<Vec<_>>().join("; ")
        ))
    }

    fn finding(&self, effort: Effort, runs: &Runs, form: usize, required: &Required) -> Finding {
        let Required { method, at, orders, from } = required;
        let list = |values: &[f64]| values.iter().map(f64::to_string).collect::<Vec<_>>().join(" and ");
        let of = if orders.len() > 1 { "of displacement and stress" } else { "of the displacement" };
        let mut claim = format!("Order {of} at least {}, from {from} {} on.", list(orders), self.cells);
        if let Some((cells, [u, s])) = at {
            claim = format!("RMS errors with {cells} {} at most {u:e} m and {s:e} Pa. {claim}", self.cells);
        }
        let name = self.forms[form].0;
        let what = if name.is_empty() { method.name.to_owned() } else { format!("{}, {name}", method.name) };
        Finding::judge(what, claim, true, || {
            let found: Vec<f64> = (0..orders.len()).map(|kind| self.order(effort, runs, form, required, kind)).collect::<Option<_>>()?;
            let mut holds = found.iter().zip(*orders).all(|(found, least)| found >= least);
            let mut seen = format!("Order {}.", found.iter().map(|v| format!("{v:.2}")).collect::<Vec<_>>().join(" and "));
            if let &Some((cells, most)) = at {
                let own = self.errors(runs, &Entry { form, method, cells })?;
                holds &= own.iter().zip(most).all(|(own, most)| *own <= most);
                seen = format!("{} m and {} Pa. {seen}", small(own[0]), small(own[1]));
            }
            Some((seen, holds))
        })
    }

    pub(super) fn section(&self, effort: Effort, runs: &Runs) -> Section {
        let forms = || 0..self.forms.len();
        let sentences: Vec<String> =
            forms().flat_map(|form| [0, 1].map(|kind| self.sentence(effort, runs, form, kind))).flatten().collect();
        Section {
            title: format!("{}: run time against error", self.heading),
            text: format!(
                "{} What it takes to be as close as the classical methods ever are on these grids:\n\n{}",
                self.text,
                sentences.join("\n")
            ),
            tables: forms().map(|form| self.table(effort, runs, form)).chain(self.shorter_table(effort, runs)).collect(),
            figures: forms().map(|form| self.figure(effort, runs, form)).collect(),
            findings: forms().flat_map(|form| self.required.iter().map(move |r| self.finding(effort, runs, form, r))).collect(),
            ..Section::default()
        }
    }
}

/// `1.2 s`, `340 ms`, `35 us`: two or three digits of a wall time.
fn seconds(wall: f64) -> String {
    match wall {
        w if w >= 9.95 => format!("{w:.0} s"),
        w if w >= 0.995 => format!("{w:.1} s"),
        w if w >= 0.00995 => format!("{:.0} ms", 1e3 * w),
        w if w >= 0.000995 => format!("{:.1} ms", 1e3 * w),
        w => format!("{:.0} us", 1e6 * w),
    }
}

/// How many particles a cell has along an axis, for a scene: of methods that move through the grid, and of classical ones. Those of the total
/// formulation are Gauss points.
fn particles(method: &Method, [moving, classical]: [usize; 2]) -> String {
    match method.kind {
        Kind::Moving => format!(", particles_per_cell = {moving}"),
        Kind::Classical => format!(", particles_per_cell = {classical}"),
        Kind::Total => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_have_two_digits() {
        assert_eq!([12.3, 1.23, 0.123, 0.00123, 0.0000349].map(seconds), ["12 s", "1.2 s", "123 ms", "1.2 ms", "35 us"]);
    }

    /// Times and errors that were never measured: ours is twice as fast as GIMP, which is the closest of the classical methods.
    #[test]
    fn the_sentence_compares_with_the_closest_classical_run() {
        let race = &cube::CUBE;
        let runs: Runs = race
            .entries(Effort::Quick, 0)
            .map(|entry| {
                let error = match entry.method.kind {
                    Kind::Total => 0.1 / entry.cells as f64,
                    _ if entry.method.name == GIMP.name => 1.0 / entry.cells as f64,
                    _ => 2.0,
                };
                let wall = if entry.method.kind == Kind::Total { 0.5 } else { 1.0 };
                Run::of_numbers(race.name(&entry), wall, race.end, "errors", vec![error; 2])
            })
            .collect();
        let said = race.sentence(Effort::Quick, &runs, 0, 0).unwrap();
        assert!(
            said.contains("1.2e-1 m (GIMP, FLIP, 8 cells, 1.0 s)") && said.contains("3 cells in 500 ms: 2.0 times less time"),
            "{said}"
        );
    }
}
