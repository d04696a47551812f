//! How the viewer is laid out, and where things without a place of their own are drawn.

use super::super::data::{About, Row};
use super::logger::EVENTS;
use crate::model::Signal;
use crate::scene::{Load, Shape};
use ::rerun::blueprint::components::PanelState;
use ::rerun::blueprint::{Blueprint, BlueprintPanel, ContainerLike, Horizontal, SelectionPanel, Spatial2DView, Spatial3DView, Tabs};
use ::rerun::blueprint::{TextDocumentView, TextLogView, TimePanel, TimeSeriesView, Vertical};
use std::collections::BTreeSet;

/// Outlines and numbers.
pub(super) const INK: u32 = 0xd0d0_d0ff;
/// The background grid.
pub(super) const GRAY: u32 = 0x7070_70ff;
/// Probes and forces.
pub(super) const MARK: u32 = 0xff9d_2eff;

/// Space with its legend on the left, curves, events and the scene on the right.
pub(super) fn blueprint(about: &About) -> Blueprint {
    // What shares a unit shares a view.
    let chosen = |fits: &dyn Fn(&str) -> bool| -> Vec<String> {
        about.series.iter().filter(|s| fits(&s.variable)).map(|s| format!("/{}", s.variable)).collect()
    };
    const ENERGIES: [&str; 4] = ["energy/kinetic", "energy/strain", "energy/external", "energy/total"];
    let probe = |last: &'static str| move |name: &str| name.starts_with("probe/") && name.ends_with(last);
    let view = |(name, contents): (&str, Vec<String>)| {
        (!contents.is_empty()).then(|| ContainerLike::from(TimeSeriesView::new(name).with_contents(contents)))
    };
    let curves = |views: Vec<(&str, Vec<String>)>, name: &str| Vertical::new(views.into_iter().filter_map(view)).with_name(name);
    let first = curves(
        vec![
            ("energies [J]", chosen(&|name| ENERGIES.contains(&name))),
            ("probe displacements [m]", chosen(&probe("/displacement"))),
            ("reactions [N]", chosen(&|name| name.starts_with("boundary/"))),
            ("errors", chosen(&|name| name.starts_with("error/"))),
        ],
        "curves",
    );
    let loads: Vec<String> = about.inputs.iter().map(|v| format!("/{}", v.name)).collect();
    let second = curves(
        vec![
            ("momentum [kg m/s]", chosen(&|name| name == "momentum/linear")),
            ("probe velocities [m/s]", chosen(&probe("/velocity"))),
            ("inputs", loads),
            ("substep [s]", chosen(&|name| name == "pace/step")),
            ("real-time factor", chosen(&|name| name == "pace/real_time_factor")),
        ],
        "more",
    );
    let events = TextLogView::new("events").with_origin(EVENTS);
    let text = TextDocumentView::new("scene").with_origin("/scene");
    let right = Tabs::new([first.into(), second.into(), events.into(), text.into()]);
    let space: ContainerLike = if about.dimension() == 3 {
        Spatial3DView::new(about.scene.title.as_str()).with_origin("/world").into()
    } else {
        Spatial2DView::new(about.scene.title.as_str()).with_origin("/").with_contents(["/world/**"]).into()
    };
    let legend = Spatial2DView::new("color").with_origin("/legend");
    let left = Vertical::new([space, legend.into()]).with_row_shares(vec![6.5, 1.0]);
    // Activated, not only offered as default: a default layout is applied too late by some viewers.
    Blueprint::new(Horizontal::new([left.into(), right.into()]).with_column_shares(vec![2.0, 1.0]))
        .with_time_panel(TimePanel::new().with_timeline("sim_time").with_state(PanelState::Collapsed))
        .with_blueprint_panel(BlueprintPanel::from_state(PanelState::Hidden))
        .with_selection_panel(SelectionPanel::from_state(PanelState::Hidden))
}

/// The next of 1, 2, 2.5 and 5 times a power of ten.
pub(super) fn round(value: f64) -> f64 {
    if value <= 0.0 || !value.is_finite() {
        return 0.0;
    }
    let power = 10f64.powf(value.log10().floor());
    [1.0, 2.0, 2.5, 5.0, 10.0].into_iter().map(|m| m * power).find(|&v| v >= value * (1.0 - 1e-9)).unwrap_or(10.0 * power)
}

fn mean(about: &About, particles: impl Iterator<Item = usize>) -> [f64; 3] {
    let (mut sum, mut count) = ([0.0; 3], 0.0);
    for p in particles {
        for a in 0..about.dimension() {
            sum[a] += about.initial[about.dimension() * p + a];
        }
        count += 1.0;
    }
    sum.map(|s| if count > 0.0 { s / count } else { 0.0 })
}

/// Where the reaction of a boundary is drawn: in the middle of its side, or of the particles in its region.
pub(super) fn boundary_place(about: &About, name: &str) -> [f64; 3] {
    let all = 0..about.body.len();
    let mut place = mean(about, all.clone());
    let Some(boundary) = about.scene.boundary.get(name) else { return place };
    let axes = ["x", "y", "z"];
    if let Some((axis, sign)) = boundary.face.as_deref().and_then(|face| face.split_at_checked(1))
        && let Some(axis) = axes.iter().position(|&a| a == axis)
    {
        let grid = &about.scene.grid;
        place[axis] = grid.origin[axis] + if sign == "+" { grid.size[axis] } else { 0.0 };
    } else if let Some(region) = &boundary.region {
        let (low, high) = region.bounds(about.dimension());
        let inside = |p: &usize| (0..about.dimension()).all(|a| (low[a]..=high[a]).contains(&about.initial[about.dimension() * p + a]));
        place = mean(about, all.filter(inside));
    }
    place
}

/// Name, place and value of each load that has a place: tractions and forces, by the geometry at time 0.
pub(super) fn loads(about: &About, row: &Row) -> Vec<(String, [f64; 3], Vec<f64>)> {
    let mut all = Vec::new();
    for (name, load) in &about.scene.load {
        let (place, signal, kind) = match load {
            Load::Traction(t) => (face(about, &t.body, &t.face), &t.value, "traction"),
            Load::PointForce(f) => (Some(std::array::from_fn(|a| f.at.get(a).copied().unwrap_or(0.0))), &f.value, "force"),
            _ => continue,
        };
        let (Some(place), Ok(signal)) = (place, Signal::new(signal)) else { continue };
        let input = about.inputs.iter().position(|v| v.name == format!("load/{name}/{kind}"));
        let input = input.map_or(&[][..], |i| &row.values[about.series.len() + i]);
        all.push((format!("{name}/{kind}"), place, signal.value(place, row.time, input)[..about.dimension()].to_vec()));
    }
    all
}

/// The cells of the background grid that hold particles: their centres, in the order of the grid, and half their size.
pub(super) fn cells(about: &About, position: &[f64]) -> (impl ExactSizeIterator<Item = [f32; 3]> + use<>, [f32; 3]) {
    let (grid, dimension) = (&about.scene.grid, about.dimension());
    let size: Vec<f64> = (0..dimension).filter_map(|a| grid.cell.axis(a)).collect();
    let index = |p: &[f64]| -> [i64; 3] {
        std::array::from_fn(|a| if a < dimension { ((p[a] - grid.origin[a]) / size[a]).floor() as i64 } else { 0 })
    };
    let active: BTreeSet<[i64; 3]> = position.chunks_exact(dimension).map(index).collect();
    let center = |a: usize, i: i64| if a < dimension { grid.origin[a] + (i as f64 + 0.5) * size[a] } else { 0.0 };
    let centers: Vec<[f32; 3]> = active.iter().map(|cell| std::array::from_fn(|a| center(a, cell[a]) as f32)).collect();
    // A cell of a bar has no height: it gets one, to be seen.
    (centers.into_iter(), std::array::from_fn(|a| 0.5 * size.get(a).copied().unwrap_or(size[0]) as f32))
}

/// The middle of a face of a box.
fn face(about: &About, body: &str, face: &str) -> Option<[f64; 3]> {
    let Shape::Box { .. } = about.scene.body.get(body)?.shape else { return None };
    let (low, high) = about.scene.body.get(body)?.shape.bounds(about.dimension());
    let (axis, sign) = face.split_at_checked(1)?;
    let axis = ["x", "y", "z"].iter().position(|&a| a == axis)?;
    let mut place = std::array::from_fn(|a| if a < about.dimension() { 0.5 * (low[a] + high[a]) } else { 0.0 });
    place[axis] = if sign == "+" { high[axis] } else { low[axis] };
    Some(place)
}

/// The unit of what an arrow shows.
pub(super) fn arrow_unit(entity: &str) -> &'static str {
    if entity.ends_with("/traction") { "Pa" } else { "N" }
}

/// For each load that has a place: the particles next to it.
pub(super) fn loaded(about: &About) -> Vec<(String, Vec<usize>)> {
    let place = |load: &Load| match load {
        Load::Traction(t) => Some((
            face(about, &t.body, &t.face)?,
            t.face.split_at_checked(1).and_then(|(a, _)| ["x", "y", "z"].iter().position(|&x| x == a)),
        )),
        Load::PointForce(f) => Some((std::array::from_fn(|a| f.at.get(a).copied().unwrap_or(0.0)), None)),
        _ => None,
    };
    let d = about.dimension();
    let near = |p: &usize, (at, axis): &([f64; 3], Option<usize>)| {
        let spacing = &about.spacing[about.body[*p] as usize];
        // On a face the distance from its plane counts; at a point the distance along each axis.
        (0..d).filter(|a| axis.is_none_or(|axis| axis == *a)).all(|a| (about.initial[d * p + a] - at[a]).abs() <= spacing[a])
    };
    let particles = |place| (0..about.body.len()).filter(|p| near(p, &place)).collect::<Vec<_>>();
    let all = about.scene.load.iter().filter_map(|(name, load)| Some((name.clone(), particles(place(load)?))));
    all.filter(|(_, near)| !near.is_empty()).collect()
}
