//! Sides of bodies in rows: tractions and pressures on them, and walls that the edges of sheets stick to.
//!
//! A wall holds the velocity of an edge wherever it lies in the grid. The traction of the body on it, t = sigma n, is part of the balance
//! of momentum, so that the exact solution fulfils it (Nitsche 1971); and each point of the edge drags a mass `strength` that moves with the wall,
//! which the edge follows within a step: (M + B) a = f + B (v_wall - v) / kick, with B = sum strength N N^T over the points. No node is held, and
//! the matrix stays symmetric and positive.

use super::integrate::{Integration, Rule};
use super::load::deformation;
use super::side::{OnSide, RowSide};
use super::sparse::SparseRows;
use super::{Stepper, integrate};
use crate::component::StepError;
use crate::grid::Lanes;
use crate::model::{Model, Side, Target};
use crate::quadrature::{Point, stretches};
use crate::state::State;
use nalgebra::{Matrix3, Vector3};

/// Mass that a length of held edge drags, over that of a strip of the body as wide as a cell.
///
/// By hand, with a vortex between two walls (12 cells a metre, degree 3, particles half a spacing inside): errors of 2.5e-5 to 3.2e-5 m from 0.1
/// to 10; from 30 on the run is unstable on some grids, for the velocity of the particles is extrapolated to the edge.
const STRENGTH: f64 = 1.0;

/// Points of the edges that something acts on.
#[derive(Debug, Default)]
pub(super) struct Edges {
    pub(super) walls: SparseRows,
    loads: SparseRows,
    /// Of each wall, in the order of `Model::walls`: its points of the edge of its body.
    held: Vec<Vec<OnSide>>,
    /// The same for each load on a side.
    loaded: Vec<(usize, Vec<OnSide>)>,
    /// Sides of bodies that are no sheets.
    rows: Vec<RowSide>,
    /// Velocity of the particles at the points of the walls \[m/s\].
    velocity: Vec<Lanes>,
    /// Velocity of the particles at the points of the loads \[m/s\].
    loaded_velocity: Vec<Lanes>,
    /// Force on each of these \[N\].
    force: Vec<Lanes>,
    /// Force of each wall by the stress of the body \[N\].
    traction: Vec<[f64; 3]>,
}

impl Edges {
    /// Whether anything acts on an edge.
    pub(super) fn is_needed(model: &Model) -> bool {
        !model.walls.is_empty() || model.loads.iter().any(|load| load.side.is_some())
    }
}

fn lanes(v: [f64; 3]) -> Lanes {
    [0.0, v[0], v[1], v[2]]
}

/// Points of a side.
fn on_side(model: &Model, all: &Integration, rows: &[RowSide], side: &Side) -> Vec<OnSide> {
    if let Some(row) = rows.iter().find(|row| row.side == *side) {
        return row.points.clone();
    }
    let (Some(Rule::Sheet(sheet)), Some((chart, _))) = (
        all.bodies.get(side.body).map(|body| &body.rule),
        model.bodies[side.body].lattice.as_ref().and_then(|lattice| lattice.sheet.as_ref()),
    ) else {
        return Vec::new();
    };
    let of = |(number, (point, now)): (usize, (&crate::quadrature::SidePoint, &crate::quadrature::EdgePoint))| {
        let mut at = [point.along; 2];
        at[side.axis] = f64::from(u8::from(side.upper));
        let ([x, y], [u, v]) = (now.position, now.area);
        (point.side == (side.axis, side.upper)).then(|| OnSide {
            number: number as u32,
            position: [x, y, 0.0],
            area: [u, v, 0.0],
            at: chart.place(at),
            rest: chart.stretch(1 - side.axis, at) * point.share,
        })
    };
    sheet.sides().iter().zip(sheet.edge()).enumerate().filter_map(of).collect()
}

impl Stepper {
    /// Finds the points of sides that something acts on, and the functions there.
    pub(super) fn place_edges(&mut self, model: &Model, state: &State, all: &mut Integration) -> Result<(), StepError> {
        let mut edges = std::mem::take(&mut all.edges);
        edges.walls.clear(model);
        edges.loads.clear(model);
        self.place_rows(model, state, all, &mut edges.rows)?;
        let points = |side: &Side| on_side(model, all, &edges.rows, side);
        edges.held = model.walls.iter().map(|(_, side)| points(side)).collect();
        edges.loaded = model.loads.iter().enumerate().filter_map(|(number, load)| Some((number, points(&load.side?)))).collect();
        for ((_, side), points) in model.walls.iter().zip(&edges.held) {
            self.push_edge(model, state.time, side, points, &mut edges.walls)?;
        }
        for (number, points) in &edges.loaded {
            if let Some(side) = &model.loads[*number].side {
                self.push_edge(model, state.time, side, points, &mut edges.loads)?;
            }
        }
        all.edges = edges;
        Ok(())
    }

    /// Finds the points of sides of bodies that are no sheets.
    fn place_rows(&self, model: &Model, state: &State, all: &Integration, rows: &mut Vec<RowSide>) -> Result<(), StepError> {
        let (d, particles) = (model.dimension, &state.particles);
        if rows.is_empty() {
            for side in model.loads.iter().filter_map(|load| load.side).chain(model.walls.iter().map(|(_, side)| *side)) {
                let body = &model.bodies[side.body];
                let known = rows.iter().any(|row| row.side == side);
                if let (false, Rule::Lines(lines), Some(lattice)) = (known, &all.bodies[side.body].rule, &body.lattice) {
                    rows.push(RowSide::new(side, lattice, &lines.axes(), &lattice.extents));
                }
            }
        }
        for row in rows {
            let (body, places) = (&model.bodies[row.side.body], &all.bodies[row.side.body].places);
            let Some(lattice) = &body.lattice else { continue };
            let place = |p: usize| places[p] as usize;
            row.prepare(
                lattice,
                |p, axis| body.half[axis] * stretches(&deformation(d, state, place(p)))[axis],
                |p, axis| particles.position.column(axis)[place(p)],
                |p, axis| model.reference(particles.id[place(p)])[axis],
                |p| deformation(d, state, place(p)),
            )
            .map_err(|_| StepError::NoReconstruction {
                time: state.time,
                position: particles.position.row::<3>(place(0))[..d].to_vec(),
                reason: format!("a side of body `{}` is folded", body.name),
            })?;
        }
        Ok(())
    }

    fn push_edge(&mut self, model: &Model, time: f64, side: &Side, points: &[OnSide], rows: &mut SparseRows) -> Result<(), StepError> {
        let points: Vec<Point> = points.iter().map(|point| Point { cell: [0; 3], position: point.position, weight: 0.0 }).collect();
        self.push_points(model, time, model.field(side.body as u16), &points, false, rows)
    }

    /// Adds tractions and pressures on sides. Their sum and moment are those of the edge, for the functions add up to 1 and to the place.
    pub(super) fn add_side_forces(&mut self, model: &Model, state: &State) -> Result<(), StepError> {
        let all = &mut self.integration;
        all.edges.force.clear();
        let mut row = 0;
        for (number, points) in &all.edges.loaded {
            let load = &model.loads[*number];
            for point in points {
                let value = load.signal.value(point.at, state.time, &state.inputs[*number]);
                if value.iter().any(|v| !v.is_finite()) {
                    return Err(StepError::BadLoad { time: state.time, load: load.name.clone() });
                }
                let force = if matches!(load.target, Target::Pressure(_)) {
                    point.area.map(|area| -value[0] * area)
                } else {
                    value.map(|v| v * point.rest)
                };
                all.edges.loads.add(row, lanes(force), &mut self.grid.force);
                all.edges.force.push(lanes(force));
                row += 1;
            }
        }
        if !model.quadrature_of_velocity {
            // what the projection does not ask for, the work of the loads does
            all.velocity_at_edges(model, |p, a| state.particles.velocity.column(a)[p]);
        }
        Ok(())
    }

    /// Work of loads on sides over a step, once accelerations are known \[J\].
    pub(super) fn side_work(&self, kick: f64, dt: f64) -> f64 {
        let edges = &self.integration.edges;
        let of = |(row, force): (usize, &Lanes)| {
            let a = edges.loads.value(row, &self.grid.force);
            (1..4).map(|lane| force[lane] * (edges.loaded_velocity[row][lane] + kick * a[lane]) * dt).sum::<f64>()
        };
        edges.force.iter().enumerate().map(of).sum()
    }

    /// Adds the tractions on the walls of a body from its stress there (see [`Integration::stress_at_walls`]).
    pub(super) fn add_wall_tractions(&mut self, model: &Model, all: &mut Integration, body: usize, stress: &[Vec<Matrix3<f64>>]) {
        all.edges.traction.resize(model.walls.len(), [0.0; 3]);
        let mut row = 0;
        for (wall, (boundary, side)) in model.walls.iter().enumerate() {
            let points = &all.edges.held[wall];
            if side.body == body {
                let mut sum = [0.0; 3];
                for (k, (point, stress)) in points.iter().zip(&stress[wall]).enumerate() {
                    let pull = stress * Vector3::from(point.area);
                    let force = [0, 1, 2].map(|a| if model.boundaries[*boundary].holds_axis(a) { pull[a] } else { 0.0 });
                    (0..3).for_each(|a| sum[a] += force[a]);
                    all.edges.walls.add(row + k, lanes(force), &mut self.grid.force);
                }
                all.edges.traction[wall] = sum;
            }
            row += points.len();
        }
    }

    /// Hands the points of the walls to the mass matrix.
    pub(super) fn set_walls(&mut self, model: &Model, all: &Integration, matrix: &mut super::mass::MassMatrix) {
        let mut strength = Vec::new();
        for ((boundary, side), points) in model.walls.iter().zip(&all.edges.held) {
            let of_length = STRENGTH * model.bodies[side.body].density * model.cell();
            for point in points {
                let own = of_length * Vector3::from(point.area).norm();
                strength.push(lanes([0, 1, 2].map(|a| if model.boundaries[*boundary].holds_axis(a) { own } else { 0.0 })));
            }
        }
        matrix.set_walls(&all.edges.walls, strength);
    }

    /// What the walls want of a field, point by point: `value` of the boundary, the axis and the velocity of the particles there.
    pub(super) fn wall_values(&self, model: &Model, value: impl Fn(usize, usize, f64) -> f64) -> Vec<Lanes> {
        let edges = &self.integration.edges;
        let boundaries = model.walls.iter().zip(&edges.held).flat_map(|((boundary, _), points)| points.iter().map(move |_| *boundary));
        boundaries
            .enumerate()
            .map(|(row, boundary)| {
                let velocity = edges.velocity.get(row).copied().unwrap_or_default();
                lanes([0, 1, 2].map(|a| if model.boundaries[boundary].holds_axis(a) { value(boundary, a, velocity[1 + a]) } else { 0.0 }))
            })
            .collect()
    }

    /// Adds what the walls did in a kick to the reactions, and to the work: `pulls` are their forces beside the traction, point by point \[N\].
    pub(super) fn count_walls(&mut self, model: &Model, pulls: &[Lanes], kick: f64, dt: f64, time: f64) {
        let edges = &self.integration.edges;
        let mut row = 0;
        for (wall, (boundary, _)) in model.walls.iter().enumerate() {
            for axis in 0..model.dimension {
                let points = &pulls[row..row + edges.held[wall].len()];
                let force = edges.traction[wall][axis] + points.iter().map(|pull| pull[1 + axis]).sum::<f64>();
                self.impulse[*boundary][axis] += force * kick;
                self.boundary_work += force * model.boundaries[*boundary].velocity(axis, time).unwrap_or(0.0) * dt;
            }
            row += edges.held[wall].len();
        }
    }
}

impl Integration {
    /// Stress at the points of each wall of a body \[Pa\]; its columns are those of the particles, or their coefficients.
    pub(super) fn stress_at_walls(&self, model: &Model, body: usize) -> Vec<Vec<Matrix3<f64>>> {
        let of_sheet = |sheet: &crate::quadrature::SheetQuadrature, points: &[OnSide]| -> Vec<Matrix3<f64>> {
            let mut stress: Vec<[f64; 3]> = Vec::new();
            sheet.at_edge(&self.of_3.coefficients, &mut stress);
            let at = |point: &OnSide| {
                let [xx, yy, xy] = stress[point.number as usize];
                Matrix3::new(xx, xy, 0.0, xy, yy, 0.0, 0.0, 0.0, 0.0)
            };
            points.iter().map(at).collect()
        };
        let of_row = |row: &RowSide| -> Vec<Matrix3<f64>> {
            let Some(lattice) = &model.bodies[body].lattice else { return Vec::new() };
            let known = if model.dimension == 1 { 1 } else { 6 };
            let stress = row.values::<6>(lattice, |p, k| if k < known { self.columns[k][p] } else { 0.0 });
            stress.into_iter().map(|[xx, yy, zz, yz, xz, xy]| Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz)).collect()
        };
        let of = |((_, side), points): (&(usize, Side), &Vec<OnSide>)| match (&self.bodies[body].rule, side.body == body) {
            (Rule::Sheet(sheet), true) => of_sheet(sheet, points),
            (_, true) => self.edges.rows.iter().find(|row| row.side == *side).map(of_row).unwrap_or_default(),
            _ => Vec::new(),
        };
        model.walls.iter().zip(&self.edges.held).map(of).collect()
    }

    /// Takes the velocity of the particles to the points of edges; `columns` are its components.
    pub(super) fn velocity_at_edges(&mut self, model: &Model, velocity: impl Fn(usize, usize) -> f64) {
        if !Edges::is_needed(model) {
            return;
        }
        let mut of_bodies: Vec<Vec<[f64; 2]>> = Vec::new();
        for body in &self.bodies {
            let mut values = Vec::new();
            if let Rule::Sheet(sheet) = &body.rule {
                integrate::fill(&mut self.columns, 2, &body.places, &velocity);
                let mut coefficients = Vec::new();
                sheet.fit([&self.columns[0], &self.columns[1]], &mut coefficients);
                sheet.at_edge::<2>(&coefficients, &mut values);
            }
            of_bodies.push(values);
        }
        let of_rows = |row: &RowSide| {
            let (lattice, places) = (model.bodies[row.side.body].lattice.as_ref()?, &self.bodies[row.side.body].places);
            let of = |p: usize, axis: usize| if axis < model.dimension { velocity(places[p] as usize, axis) } else { 0.0 };
            Some((row.side, row.values::<3>(lattice, of)))
        };
        let of_rows: Vec<(Side, Vec<[f64; 3]>)> = self.edges.rows.iter().filter_map(of_rows).collect();
        let of = |side: &Side, point: &OnSide| match of_rows.iter().find(|(known, _)| known == side) {
            Some((_, values)) => lanes(values[point.number as usize]),
            None => {
                let [x, y] = of_bodies[side.body][point.number as usize];
                [0.0, x, y, 0.0]
            }
        };
        let Edges { held, loaded, velocity, loaded_velocity, .. } = &mut self.edges;
        velocity.clear();
        for ((_, side), points) in model.walls.iter().zip(held) {
            velocity.extend(points.iter().map(|point| of(side, point)));
        }
        loaded_velocity.clear();
        for (number, points) in loaded {
            let Some(side) = &model.loads[*number].side else { continue };
            loaded_velocity.extend(points.iter().map(|point| of(side, point)));
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::model::Model;
    use crate::quadrature::gauss_legendre;
    use crate::scene::Scene;
    use crate::step::Stepper;
    use crate::transfer::What;

    /// A bar that is turned and bent like a cubic, in cells that its edges cut: force and moment of what acts on an edge are those of
    /// integrals along it, once the nodes inside have taken over what the others were given.
    #[test]
    fn forces_and_moments_on_a_bent_turned_edge_are_exact() {
        for (kind, value) in [("traction", "[30, -20]"), ("pressure", "[40]")] {
            let text = format!(
                r#"
                title = "bent"
                dimension = 2
                grid = {{ origin = [-2, -2], size = [5.04, 5.04], cell = 0.21 }}
                material.m = {{ law = "neo_hookean", young = 1000, density = 1 }}
                body.b = {{ material = "m", shape = {{ box = {{ min = [0, 0], max = [1.3, 0.7] }} }}, particles_per_cell = 3 }}
                load.l.{kind} = {{ body = "b", face = "y+", value = {value} }}
                method = {{ degree = 3, mass = "consistent", quadrature = "splines", quadrature_of = "force_and_velocity" }}
                time = {{ end = 1 }}
                "#
            );
            let (model, mut state) = Model::new(&Scene::from_toml(&text).unwrap()).unwrap();
            let (sin, cos) = 0.4f64.sin_cos();
            let map = |x: f64, y: f64| {
                let (a, b) = (x + 0.1 * y * y - 0.05 * x * x, y + 0.3 * x * x - 0.1 * x * x * x + 0.1 * x * y);
                [0.13 + cos * a - sin * b, -0.21 + sin * a + cos * b]
            };
            for p in 0..state.particles.len() {
                let x: [f64; 3] = state.particles.position.row(p);
                let [a, b] = map(x[0], x[1]);
                state.particles.position.set_row(p, &[a, b, 0.0]);
            }
            let mut stepper = Stepper::new(&model);
            stepper.begin(&model);
            stepper.locate(&model, &mut state).unwrap();
            stepper.load(&model, &state).unwrap();
            stepper.particles_to_grid(&model, &mut state, What::MassMomentumForce).unwrap();
            assert!(!stepper.grid.tied.is_empty(), "the edge cuts cells");
            let (mut force, mut moment) = ([0.0; 2], 0.0);
            stepper.grid.for_nodes(|index, node| {
                let f = stepper.grid.force[index];
                let x = [0, 1].map(|a| model.axes[a].node_position(node[1 + a]));
                (0..2).for_each(|a| force[a] += f[1 + a]);
                moment += x[0] * f[2] - x[1] * f[1];
            });
            let (mut exact, mut about) = ([0.0; 2], 0.0);
            for (s, weight) in gauss_legendre(12) {
                let (x, h) = (1.3 * s, 1e-3);
                let place = map(x, 0.7);
                // the fourth-order difference of a cubic is exact
                let at = |k: f64| map(x + k * h, 0.7);
                let slope = [0, 1].map(|a| (8.0 * (at(1.0)[a] - at(-1.0)[a]) - (at(2.0)[a] - at(-2.0)[a])) / (12.0 * h));
                // the body is on the right of the edge from left to right
                let f = if kind == "traction" { [30.0, -20.0] } else { [40.0 * slope[1], -40.0 * slope[0]] };
                let share = 1.3 * weight;
                (0..2).for_each(|a| exact[a] += share * f[a]);
                about += share * (place[0] * f[1] - place[1] * f[0]);
            }
            println!("{kind}: force {force:?} {exact:?}, moment {moment} {about}");
            // the difference is good to 1e-12, and so is the sum of some thousand terms
            let size = exact[0].hypot(exact[1]);
            assert!((0..2).all(|a| (force[a] - exact[a]).abs() < 1e-11 * size) && (moment - about).abs() < 1e-11 * size, "{kind}");
        }
    }
}
