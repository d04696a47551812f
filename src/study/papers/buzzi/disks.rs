//! B3: two disks bounce off each other along the diagonal of a square.

use super::{BASES, chart, energies, largest, percent, rms, times};
use crate::Simulation;
use crate::component::ComponentError;
use crate::study::{
    Axis, Cell, Chart, Cloud, Drawing, Effort, Figure, Finding, Job, Panel, Run, Runs, Section, Series, Style, Table, View,
};

/// Centre of the first disk along both axes \[m\]; the other is its image in the middle of the square.
const CENTRE: f64 = 0.3;
const RADIUS: f64 = 0.14;
/// Speed of each disk \[m/s\].
const SPEED: f64 = 0.1;
/// End of all runs \[s\].
const END: f64 = 4.0;
/// Time of the pictures after the impact \[s\].
const AFTER: f64 = 2.5;
/// Time of the pictures in the impact \[s\], for each of [`SIZES`]: about that of the least distance. Large cells are felt earlier.
const IMPACT: [f64; 2] = [1.45, 1.7];
/// Cells of the grid along an axis: with 2 particles a cell along each, these are the 24 and 392 particles a disk of the paper.
const SIZES: [(usize, usize); 2] = [(10, 24), (40, 392)];
/// How disks meet: key and name.
const CONTACTS: [(&str, &str); 2] = [("shared", "one velocity field"), ("separate", "a field a disk")];

/// Shape functions, particles a disk, and how the disks meet.
#[derive(Clone, Copy)]
struct Case {
    basis: usize,
    size: usize,
    contact: usize,
}

impl Case {
    fn name(self) -> String {
        format!("B3/{}/{}/{}", BASES[self.basis].0, SIZES[self.size].1, CONTACTS[self.contact].0)
    }

    fn label(self) -> String {
        format!("{}, {} particles, {}", BASES[self.basis].1, SIZES[self.size].1, CONTACTS[self.contact].1)
    }

    fn scene(self) -> String {
        let contact = if CONTACTS[self.contact].0 == "separate" { "contact = { friction = 0.0 }" } else { "" };
        let component = SPEED / f64::sqrt(2.0);
        format!(
            r#"
            title = "Buzzi et al. 2008, two bouncing disks"
            dimension = 2
            grid = {{ origin = [0, 0], size = [1, 1], cell = {cell} }}
            {contact}
            material.soft = {{ law = "neo_hookean", young = 1, poisson = 0.2, density = 1 }}
            method = {{ basis = "{basis}", integrator = "usf" }}
            time = {{ end = {END}, step = 1e-3 }}
            [body.lower]
            material = "soft"
            shape = {{ disk = {{ center = [{CENTRE}, {CENTRE}], radius = {RADIUS} }} }}
            particles_per_cell = 2
            velocity = [{component}, {component}]
            [body.upper]
            material = "soft"
            shape = {{ disk = {{ center = [{other}, {other}], radius = {RADIUS} }} }}
            particles_per_cell = 2
            velocity = [-{component}, -{component}]
            "#,
            cell = 1.0 / SIZES[self.size].0 as f64,
            basis = BASES[self.basis].0,
            other = 1.0 - CENTRE,
        )
    }

    fn job(self) -> Job {
        let images = |image: fn([f64; 2]) -> [f64; 2]| move |sim: &mut Simulation| furthest(sim, image);
        energies(Job::new(self.name(), self.scene()).every(0.025))
            .watch("distance", distance)
            .watch("turned", images(|[x, y]| [1.0 - x, 1.0 - y]))
            .watch("swapped", images(|[x, y]| [y, x]))
            .snapshot(IMPACT[self.size], PICTURE)
            .snapshot(AFTER, PICTURE)
    }
}

/// What a picture needs.
const PICTURE: [&str; 2] = ["particle/position", "particle/stress"];

fn cases(effort: Effort) -> Vec<Case> {
    let all =
        [0, 1].into_iter().flat_map(|size| [0, 1].into_iter().flat_map(move |basis| [0, 1].map(|contact| Case { basis, size, contact })));
    // the fine disks of the figures are those of GIMP
    all.filter(|case| effort == Effort::Full || case.size == 0 || (case.basis == 1 && case.contact == 0)).collect()
}

pub(super) fn jobs(effort: Effort) -> Vec<Job> {
    cases(effort).into_iter().map(Case::job).collect()
}

fn positions(sim: &mut Simulation) -> Result<Vec<[f64; 2]>, ComponentError> {
    Ok(pairs(sim.get("particle/position")?))
}

fn pairs(values: &[f64]) -> Vec<[f64; 2]> {
    values.chunks_exact(2).map(|p| [p[0], p[1]]).collect()
}

/// Distance of the centres of mass \[m\].
fn distance(sim: &mut Simulation) -> Result<f64, ComponentError> {
    let body = sim.get("particle/body")?.to_vec();
    let at = positions(sim)?;
    let centre = |wanted: f64| {
        let own: Vec<&[f64; 2]> = at.iter().zip(&body).filter(|(_, b)| **b == wanted).map(|(p, _)| p).collect();
        [0, 1].map(|axis| own.iter().map(|p| p[axis]).sum::<f64>() / own.len() as f64)
    };
    let (a, b) = (centre(0.0), centre(1.0));
    Ok((a[0] - b[0]).hypot(a[1] - b[1]))
}

/// Largest distance from the image of a particle to the particle nearest to it \[m\].
fn furthest(sim: &mut Simulation, image: fn([f64; 2]) -> [f64; 2]) -> Result<f64, ComponentError> {
    let at = positions(sim)?;
    let nearest = |p: &[f64; 2]| {
        let image = image(*p);
        at.iter().map(|q| (q[0] - image[0]).powi(2) + (q[1] - image[1]).powi(2)).fold(f64::INFINITY, f64::min)
    };
    Ok(at.iter().map(nearest).fold(0.0, f64::max).sqrt())
}

/// Energy lost at the end, over that at the start.
fn lost(run: &Run) -> Option<f64> {
    Some(-super::drift(run)?)
}

/// Speed at which the centres part at the end, over that of the approach (over the last half second).
fn rebound(run: &Run) -> Option<f64> {
    let curve = run.curve("distance");
    let (last, before) = (curve.last()?, curve.iter().rev().find(|p| p[0] < END - 0.5)?);
    Some((last[1] - before[1]) / (last[0] - before[0]) / (2.0 * SPEED))
}

/// How rough a curve is: RMS of its second differences from sample to sample, over the first total energy.
fn roughness(run: &Run, name: &str) -> Option<f64> {
    let first = run.samples("energy").first()?;
    Some(rms(run.samples(name).windows(3).map(|w| w[0] - 2.0 * w[1] + w[2])) / first)
}

/// Largest distance between a particle and the image of another over the run \[m\], by turning and by swapping axes.
fn asymmetry(run: &Run) -> f64 {
    largest(run.samples("turned").iter().chain(run.samples("swapped")).copied())
}

pub(super) fn section(effort: Effort, runs: &Runs) -> Section {
    Section {
        title: "B3 Two bouncing disks (Buzzi et al. 2008, section 5.6)".into(),
        text: format!(
            "Radius {RADIUS} m, E = 1 Pa, nu = 0.2, plane strain, speed {SPEED} m/s towards each other along the diagonal of the unit square. \
             Not given in the paper, and chosen here: density 1 kg/m3 (so that sound travels at about 1 m/s, ten times as fast as the disks), \
             centres at {CENTRE} and {:.1} m on the diagonal, a step of 0.001 s, and a neo-Hookean law. The cells are 0.1 m and 0.025 m with 2 x 2 \
             particles: exactly the 24 and 392 particles a disk of the paper. It has one velocity field for both disks; a field a disk, with \
             frictionless contact where both are felt, is ours.",
            1.0 - CENTRE
        ),
        tables: vec![table(effort, runs)],
        figures: figures(effort, runs),
        findings: findings(effort, runs),
        ..Section::default()
    }
}

fn table(effort: Effort, runs: &Runs) -> Table {
    let row = |case: &Case| {
        let run = runs.done(&case.name());
        let rough = |name| run.and_then(|run| roughness(run, name));
        let values = [
            run.and_then(lost),
            run.and_then(rebound),
            rough("energy"),
            rough("kinetic"),
            run.map(|run| run.samples("distance").iter().copied().fold(f64::INFINITY, f64::min)),
            run.map(asymmetry),
        ];
        (case.label(), values.map(|ours| Cell { paper: None, ours }).to_vec())
    };
    Table {
        title: "Energy lost, speed of parting over that of the approach, roughness of total and kinetic energy (RMS second difference of \
                samples 0.025 s apart, over the first energy), least distance of the centres [m], largest asymmetry [m]"
            .into(),
        header: ["case", "lost", "rebound", "rough, total", "rough, kinetic", "distance", "asymmetry"].map(str::to_owned).to_vec(),
        rows: cases(effort).iter().map(row).collect(),
        beside: "paper",
        band: None,
    }
}

/// Mean pressure as the paper has it, tension positive \[Pa\].
fn view(run: &Run, time: f64, title: String) -> Option<View> {
    let [position, stress] = PICTURE.map(|name| run.at(time, name));
    let pressure = stress?.chunks_exact(9).map(|s| (s[0] + s[4] + s[8]) / 3.0).collect();
    Some(View { title, points: pairs(position?), values: pressure })
}

fn cloud(runs: &Runs, name: &str, caption: &str, case: Case) -> Figure {
    let view = |time: f64| view(runs.get(&case.name())?, time, format!("{time} s"));
    let value = Axis::new("mean stress", "Pa");
    let cloud = Cloud::new(format!("B3: {}", case.label()), value, [IMPACT[case.size], AFTER].into_iter().filter_map(view)).columns(2);
    Figure { name: name.into(), caption: caption.into(), drawing: Drawing::Cloud(cloud) }
}

fn figures(effort: Effort, runs: &Runs) -> Vec<Figure> {
    let case = |basis, size, contact| Case { basis, size, contact };
    let energy = |cases: &[Case]| {
        let panel = |(name, title): (&'static str, &'static str)| {
            let series = cases.iter().filter_map(|case| Some(Series::new(case.label(), Style::Line, runs.get(&case.name())?.curve(name))));
            Panel { y: Axis::new(title, "J"), series: series.collect() }
        };
        [("kinetic", "kinetic energy"), ("strain", "stored energy"), ("energy", "total energy")].map(panel)
    };
    let time = || Axis::new("time", "s");
    let distance = |size: usize| {
        let own = cases(effort).into_iter().filter(|case| case.size == size);
        let curve = |case: Case| {
            let label = format!("{}, {}", BASES[case.basis].1, CONTACTS[case.contact].1);
            let color = 2 * case.basis + case.contact;
            Some(Series::new(label, Style::Line, runs.get(&case.name())?.curve("distance")).color(color))
        };
        Panel { y: Axis::new(format!("{} particles: distance", SIZES[size].1), "m"), series: own.filter_map(curve).collect() }
    };
    vec![
        cloud(runs, "b3-gimp", "Figures 26 (during the impact) and 27 (after it): GIMP, 24 particles a disk", case(1, 0, 0)),
        cloud(runs, "b3-mpm", "Figures 29 (during the impact) and 30 (after it): MPM, 24 particles a disk", case(0, 0, 0)),
        cloud(runs, "b3-fine", "Figures 32 (during the impact) and 33 (after it): GIMP, 392 particles a disk", case(1, 1, 0)),
        cloud(runs, "b3-separate", "Not in the paper: GIMP, 24 particles a disk, a velocity field a disk", case(1, 0, 1)),
        chart(
            "b3-energy",
            "Figures 28 (GIMP, 24 particles a disk), 31 (MPM, 24) and 34 (GIMP, 392): energies",
            Chart::stacked("B3: energies, one velocity field", time(), energy(&[case(1, 0, 0), case(0, 0, 0), case(1, 1, 0)])),
        ),
        chart(
            "b3-distance",
            "Not in the paper: distance of the centres of mass, with one velocity field and with a field a disk",
            Chart::stacked("B3: distance of the centres", time(), [0, 1].map(distance)),
        ),
    ]
}

fn findings(effort: Effort, runs: &Runs) -> Vec<Finding> {
    let run = |basis, size, contact| runs.done(&Case { basis, size, contact }.name());
    // mean stress in tension and in compression, in the impact: the least near the contact, and the mean of all
    let pressures = |basis, size| {
        let shown = view(run(basis, size, 0)?, IMPACT[size], String::new())?;
        let near = |limit: f64| {
            let some: Vec<f64> = shown
                .points
                .iter()
                .zip(&shown.values)
                .filter(|(p, _)| ((p[0] + p[1] - 1.0).abs() / f64::sqrt(2.0)) < limit)
                .map(|(_, v)| *v)
                .collect();
            some.iter().sum::<f64>() / some.len() as f64
        };
        Some([near(0.08), near(f64::INFINITY)])
    };
    let contact = |figure: &'static str, basis, size| {
        Finding::judge(figure, "In the impact, points near the contact have the higher compressive pressure.", true, move || {
            let [near, all] = pressures(basis, size)?;
            let seen = format!(
                "At {} s the mean stress is {near:.3} Pa within 0.08 m of the plane of contact, {all:.3} Pa over all.",
                IMPACT[size]
            );
            Some((seen, near < 0.0 && near < 1.5 * all))
        })
    };
    let smooth =
        |names: [&'static str; 2]| Some(names.map(|name| Some([roughness(run(0, 0, 0)?, name)?, roughness(run(1, 0, 0)?, name)?])));
    let mut all = vec![
        contact("26", 1, 0),
        contact("29", 0, 0),
        contact("32", 1, 1),
        Finding::judge("28, 31", "The energies are slightly less smooth with MPM than with GIMP.", true, || {
            let [total, kinetic] = smooth(["energy", "kinetic"])?;
            let ([a, b], [c, d]) = (total?, kinetic?);
            let seen = format!(
                "Roughness of the total energy {} with MPM, {} with GIMP; of the kinetic energy {} and {}.",
                percent(a),
                percent(b),
                percent(c),
                percent(d)
            );
            Some((seen, a > b))
        }),
        Finding::judge("27, 30", "After the impact, the shape with GIMP is more like that of the finer disks than with MPM.", true, || {
            let [mpm, gimp, fine] = [(0, 0), (1, 0), (1, 1)].map(|(basis, size)| extent(run(basis, size, 0)?));
            let (mpm, gimp, fine) = (mpm?, gimp?, fine?);
            let off = |shape: [f64; 2]| rms([0, 1].map(|k| shape[k] / fine[k] - 1.0));
            let seen = format!(
                "Radii of gyration of a disk along and across the diagonal, over those of the fine disks: MPM {:.4} and {:.4}, GIMP {:.4} and {:.4}.",
                mpm[0] / fine[0],
                mpm[1] / fine[1],
                gimp[0] / fine[0],
                gimp[1] / fine[1]
            );
            Some((seen, off(gimp) < off(mpm)))
        }),
        Finding::judge("33, 34", "More particles and cells conserve the energy better.", true, || {
            let (coarse, fine) = (run(1, 0, 0)?, run(1, 1, 0)?);
            let (few, many) = (super::drift(coarse)?, super::drift(fine)?);
            let seen = format!(
                "GIMP: the total energy changes by {} with 24 particles a disk and by {} with 392; the disks part with {} and {} of their speed.",
                percent(few),
                percent(many),
                percent(rebound(coarse)?),
                percent(rebound(fine)?)
            );
            Some((seen, many.abs() < few.abs()))
        }),
        Finding::judge("none", "With a velocity field for each disk they part as well.", true, || {
            let list: Vec<(String, f64)> = cases(effort)
                .into_iter()
                .filter(|case| case.contact == 1)
                .map(|case| Some((case.label(), rebound(runs.done(&case.name())?)?)))
                .collect::<Option<_>>()?;
            let text: Vec<String> = list.iter().map(|(label, speed)| format!("{label}: {}", percent(*speed))).collect();
            Some((format!("Speed of parting over that of the approach: {}.", text.join("; ")), list.iter().all(|(_, v)| *v > 0.3)))
        }),
        Finding::judge("none", "The disks stay images of each other, and of themselves, to 1e-10 m.", true, || {
            let list: Vec<(String, f64)> =
                cases(effort).into_iter().map(|case| Some((case.label(), asymmetry(runs.done(&case.name())?)))).collect::<Option<_>>()?;
            let (label, worst) = list.iter().max_by(|a, b| a.1.total_cmp(&b.1))?;
            Some((format!("The largest distance is {worst:.1e} m ({label})."), *worst < 1e-10))
        }),
    ];
    if effort == Effort::Full {
        all.push(Finding::judge("none", "Contact between fields never adds energy.", true, || {
            let list: Vec<(String, f64)> = [0, 1]
                .map(|basis| Case { basis, size: 1, contact: 1 })
                .into_iter()
                .map(|case| Some((case.label(), lost(runs.done(&case.name())?)?)))
                .collect::<Option<_>>()?;
            let text: Vec<String> = list.iter().map(|(label, lost)| format!("{label}: {}", percent(-lost))).collect();
            Some((format!("The total energy changes by: {}.", text.join("; ")), list.iter().all(|(_, lost)| *lost > -1e-3)))
        }));
        all.push(Finding::judge("32, 33", "With the fine disks, MPM is quite similar to GIMP.", true, || {
            let [mpm, gimp] = [run(0, 1, 0)?, run(1, 1, 0)?];
            let apart = largest(mpm.samples("kinetic").iter().zip(gimp.samples("kinetic")).map(|(a, b)| a - b))
                / gimp.samples("kinetic").first()?;
            let coarse = largest(run(0, 0, 0)?.samples("kinetic").iter().zip(run(1, 0, 0)?.samples("kinetic")).map(|(a, b)| a - b))
                / run(0, 0, 0)?.samples("kinetic").first()?;
            let seen = format!(
                "The curves of the kinetic energy are at most {} of its first value apart, with the coarse disks {}: {} less.",
                percent(apart),
                percent(coarse),
                times(coarse / apart)
            );
            Some((seen, apart < coarse))
        }));
    }
    all
}

/// Radii of gyration of the lower disk along and across the diagonal, after the impact \[m\].
fn extent(run: &Run) -> Option<[f64; 2]> {
    let all = pairs(run.at(AFTER, PICTURE[0])?);
    // all particles of the lower disk come first, and both are as large
    let turned: Vec<[f64; 2]> = all.iter().take(all.len() / 2).map(|[x, y]| [(x + y) / f64::sqrt(2.0), (x - y) / f64::sqrt(2.0)]).collect();
    Some([0, 1].map(|axis| {
        let mean = turned.iter().map(|p| p[axis]).sum::<f64>() / turned.len() as f64;
        rms(turned.iter().map(|p| p[axis] - mean))
    }))
}
