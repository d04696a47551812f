//! Quadrature points beside the particles: internal forces, and where the scene says so mass and momentum, from fields that are
//! reconstructed there (Tielen 2016, section 7.2; Wobbes et al. 2019).

use super::Stepper;
use super::balance::is_empty;
use super::edge::Edges;
use super::extend::Extender;
use super::load::deformation;
use super::sparse::SparseRows;
use crate::basis::{BATCH, Places};
use crate::component::StepError;
use crate::grid::{Lanes, Tied};
use crate::model::{Lattice, Model};
use crate::quadrature::{CellQuadrature, FULL_SHARE, GridAxis, LineQuadrature, Point, Scratch, SheetQuadrature, Trouble, stretches};
use crate::state::State;

/// The points of one body, and memory for its fields.
#[derive(Debug)]
pub(super) struct BodyPoints {
    pub(super) rule: Rule,
    /// Place in memory of each particle, in the order of the lattice or of the ids.
    pub(super) places: Vec<u32>,
}

impl BodyPoints {
    pub(super) fn points(&self) -> &[Point] {
        self.rule.points()
    }
}

#[derive(Debug)]
pub(super) enum Rule {
    Lines(LineQuadrature),
    Sheet(Box<SheetQuadrature>),
    Cells(CellQuadrature),
}

impl Rule {
    fn points(&self) -> &[Point] {
        match self {
            Self::Lines(lines) => lines.points(),
            Self::Sheet(sheet) => sheet.points(),
            Self::Cells(cells) => cells.points(),
        }
    }
}

/// The points of all bodies where the particles are now.
#[derive(Debug, Default)]
pub(super) struct Integration {
    pub(super) bodies: Vec<BodyPoints>,
    is_current: bool,
    /// Shape functions at the points, with slopes.
    pub(super) rows: SparseRows,
    pub(super) edges: Edges,
    pub(super) extender: Extender,
    /// Nodes in whose support two bodies are.
    pub(super) touching: Vec<usize>,
    /// By place in memory: whether the stress of a particle is integrated elsewhere.
    relieved: Vec<bool>,
    pub(super) columns: Vec<Vec<f64>>,
    of_1: Fields<1>,
    of_2: Fields<2>,
    pub(super) of_3: Fields<3>,
    of_6: Fields<6>,
}

/// `K` fields at the points of a body.
#[derive(Debug)]
pub(super) struct Fields<const K: usize> {
    scratch: Scratch<K>,
    /// Coefficients of a sheet.
    pub(super) coefficients: Vec<f64>,
    values: Vec<[f64; K]>,
}

impl<const K: usize> Default for Fields<K> {
    fn default() -> Self {
        Self { scratch: Scratch::default(), coefficients: Vec::new(), values: Vec::new() }
    }
}

impl<const K: usize> Fields<K> {
    /// Takes the first `K` columns to the points.
    fn take(&mut self, rule: &Rule, columns: &[Vec<f64>]) {
        let fields: [&[f64]; K] = std::array::from_fn(|k| columns[k].as_slice());
        match rule {
            Rule::Lines(lines) => lines.evaluate(fields, &mut self.scratch, &mut self.values),
            Rule::Sheet(sheet) => {
                sheet.fit(fields, &mut self.coefficients);
                sheet.at_points(&self.coefficients, &mut self.values);
            }
            Rule::Cells(cells) => cells.evaluate(fields, &mut self.values),
        }
    }
}

impl Integration {
    pub(super) fn new(model: &Model) -> Self {
        if !model.needs.quadrature {
            return Self::default();
        }
        let axes = |gauss: usize| -> Vec<GridAxis> { model.axes.iter().map(|axis| GridAxis::of(axis, gauss)).collect() };
        let width = model.axes[0].width();
        let bodies = model.bodies.iter().map(|body| {
            let rule = match &body.lattice {
                Some(Lattice { sheet: Some((chart, sites)), .. }) => {
                    let axes = axes(width);
                    Rule::Sheet(Box::new(SheetQuadrature::new([&sites[0], &sites[1]], chart.is_joined(), [axes[0], axes[1]])))
                }
                // two on each half cell, as in the thesis; higher degrees take more
                Some(lattice) => Rule::Lines(LineQuadrature::new(lattice.counts, &lattice.ends, &axes((width - 1).max(2)))),
                // exact for the products of shape functions that a mass matrix is made of
                None => Rule::Cells(CellQuadrature::new(&axes(width), FULL_SHARE)),
            };
            BodyPoints { rule, places: Vec::new() }
        });
        Self { bodies: bodies.collect(), ..Self::default() }
    }

    /// The particles have moved.
    pub(super) fn outdate(&mut self) {
        self.is_current = false;
    }

    /// Which particles the scatter must leave out of the forces, by place in memory.
    pub(super) fn relieved(&self) -> &[bool] {
        &self.relieved
    }
}

impl Stepper {
    /// Makes the points for the particles where they are.
    pub(super) fn integrate(&mut self, model: &Model, state: &State) -> Result<(), StepError> {
        if !model.needs.quadrature || self.integration.is_current {
            return Ok(());
        }
        let mut all = std::mem::take(&mut self.integration);
        let made = self.make_points(model, state, &mut all);
        all.is_current = made.is_ok();
        self.integration = all;
        made
    }

    fn make_points(&mut self, model: &Model, state: &State, all: &mut Integration) -> Result<(), StepError> {
        let (d, particles) = (model.dimension, &state.particles);
        all.rows.clear(model);
        all.relieved.clear();
        all.relieved.resize(particles.len(), true);
        for (b, (points, body)) in all.bodies.iter_mut().zip(&model.bodies).enumerate() {
            let ids = body.particles.clone().map(|id| id as u32);
            points.places.clear();
            match &body.lattice {
                Some(lattice) => points.places.extend(lattice.ids.iter().map(|&id| self.lookup[id as usize])),
                None => points.places.extend(ids.map(|id| self.lookup[id as usize])),
            }
            let places = &points.places;
            let columns = if body.lattice.as_ref().is_some_and(|lattice| lattice.sheet.is_some()) { d } else { 2 * d };
            fill(&mut all.columns, columns, places, |p, a| {
                if a < d { particles.position.column(a)[p] } else { body.half[a - d] * stretches(&deformation(d, state, p))[a - d] }
            });
            let columns: Vec<&[f64]> = all.columns[..columns].iter().map(Vec::as_slice).collect();
            match &mut points.rule {
                Rule::Lines(lines) => lines.prepare(&columns[..d], &columns[d..]).map_err(|fold| {
                    let [_, n1, n2] = body.lattice.as_ref().map_or([1; 3], |l| l.counts);
                    let place = places[(fold.index[0] * n1 + fold.index[1]) * n2 + fold.index[2]] as usize;
                    let reason = format!("a row of particles no longer leads up axis {}", ["x", "y", "z"][fold.axis]);
                    StepError::NoReconstruction { time: state.time, position: particles.position.row::<3>(place)[..d].to_vec(), reason }
                })?,
                Rule::Sheet(sheet) => sheet.prepare([columns[0], columns[1]]).map_err(|trouble| {
                    let (place, reason) = match trouble {
                        Trouble::Folded(place) => (place, "rows and columns of particles are folded there"),
                        Trouble::Edge(lost) => (lost.position, "the edge of the body cannot be followed there"),
                    };
                    StepError::NoReconstruction { time: state.time, position: place.to_vec(), reason: reason.into() }
                })?,
                Rule::Cells(cells) => {
                    let volumes: Vec<f64> =
                        places.iter().map(|&p| particles.volume[p as usize] * deformation(d, state, p as usize).determinant()).collect();
                    cells.prepare(&columns[..d], &volumes);
                    for p in cells.left() {
                        all.relieved[places[p] as usize] = false;
                    }
                }
            }
            self.push_points(model, state.time, model.field(b as u16), points.rule.points(), true, &mut all.rows)?;
        }
        if Edges::is_needed(model) {
            self.place_edges(model, state, all)?;
        }
        if model.friction.is_some() {
            self.find_touching(all);
        }
        if model.needs.extension {
            self.extend(model, all);
        }
        Ok(())
    }

    /// Appends the shape functions at points of a field.
    pub(super) fn push_points(
        &mut self,
        model: &Model,
        time: f64,
        field: u16,
        points: &[Point],
        with_slopes: bool,
        rows: &mut SparseRows,
    ) -> Result<(), StepError> {
        let grid = &self.grid;
        for some in points.chunks(BATCH) {
            let position = |a: usize| std::array::from_fn(|l: usize| some[l.min(some.len() - 1)].position[a]);
            let places = Places { position: [position(0), position(1), position(2)], half: [[0.0; BATCH]; 3] };
            self.kernels.stencils(&model.axes, &places, some.len(), &mut self.rows);
            rows.push(&self.rows, with_slopes, |node| grid.node(field, node)).map_err(|p| StepError::NoReconstruction {
                time,
                position: some[p].position[..model.dimension].to_vec(),
                reason: "the particles around it are more than a cell away".into(),
            })?;
        }
        Ok(())
    }

    /// Adds the internal forces from the points: f_i -= sum w sigma grad N_i.
    pub(super) fn add_point_forces(&mut self, model: &Model, state: &State) {
        let mut all = std::mem::take(&mut self.integration);
        let mut first = 0;
        for body in 0..all.bodies.len() {
            let points = &all.bodies[body];
            let d = model.dimension;
            // components xx; xx yy xy; xx yy zz yz xz xy
            let components: &[(usize, usize)] = match d {
                1 => &[(0, 0)],
                2 => &[(0, 0), (1, 1), (0, 1)],
                _ => &[(0, 0), (1, 1), (2, 2), (1, 2), (0, 2), (0, 1)],
            };
            for column in &mut all.columns {
                column.clear();
            }
            all.columns.resize(all.columns.len().max(6), Vec::new());
            for &p in &points.places {
                let f = deformation(d, state, p as usize);
                let material = model.material(state.particles.body[p as usize]);
                let sigma = material.cauchy(&f, &state.particles.history.row(p as usize));
                for (column, (r, c)) in all.columns.iter_mut().zip(components) {
                    column.push(sigma[(*r, *c)]);
                }
            }
            // where the masses come from the particles, a force on a node that none of them reaches would be lost, and momentum with it
            let wants_mass = !model.quadrature_of_velocity || model.balance.is_lumped();
            let mut target = Target { force: &mut self.grid.force, mass: wants_mass.then_some(&*self.grid.momentum), model };
            let rule = &points.rule;
            match d {
                1 => {
                    all.of_1.take(rule, &all.columns);
                    push_forces(&all.rows, first, rule.points(), &all.of_1.values, [[0, 9, 9], [9; 3], [9; 3]], &mut target);
                }
                2 => {
                    all.of_3.take(rule, &all.columns);
                    push_forces(&all.rows, first, rule.points(), &all.of_3.values, [[0, 2, 9], [2, 1, 9], [9; 3]], &mut target);
                }
                _ => {
                    all.of_6.take(rule, &all.columns);
                    push_forces(&all.rows, first, rule.points(), &all.of_6.values, [[0, 5, 4], [5, 1, 3], [4, 3, 2]], &mut target);
                }
            }
            first += rule.points().len();
            if model.walls.iter().any(|(_, side)| side.body == body) {
                let stress = all.stress_at_walls(model, body);
                self.add_wall_tractions(model, &mut all, body, &stress);
            }
        }
        self.integration = all;
    }

    /// Takes the points for those of the mass matrix, and particles where there are none.
    pub(super) fn assemble_points(&mut self, model: &Model, state: &State) -> Result<(), StepError> {
        let (mut matrix, mut all) = (std::mem::take(&mut self.matrix), std::mem::take(&mut self.integration));
        let mut shares = std::mem::take(&mut self.shares);
        self.grid.shares(&model.axes, &mut shares);
        if model.needs.extension {
            // what follows others needs no lumping; what could not is lumped
            shares.fill(0.0);
            all.extender.ragged.iter().for_each(|node| shares[*node] = 1.0);
        }
        // contact pushes nodes one by one: by a mass that no other shares
        all.touching.iter().for_each(|node| shares[*node] = f64::INFINITY);
        // serendipity elements have theirs within the rows
        let (tied, none) = (std::mem::take(&mut self.grid.tied), Tied::default());
        let made = matrix.set(model, &shares, if model.needs.extension { &tied } else { &none }, |rows, mass| {
            let d = model.dimension;
            for (b, points) in all.bodies.iter().enumerate() {
                let field = model.field(b as u16);
                self.push_points(model, state.time, field, points.rule.points(), false, rows)?;
                let density = |p: usize, _| state.particles.mass[p] / (state.particles.volume[p] * deformation(d, state, p).determinant());
                fill(&mut all.columns, 1, &points.places, density);
                all.of_1.take(&points.rule, &all.columns);
                let start = mass.len();
                mass.extend(points.rule.points().iter().zip(&all.of_1.values).map(|(point, density)| point.weight * density[0]));
                if let Rule::Cells(cells) = &points.rule {
                    let of = |p: usize| state.particles.mass[points.places[p] as usize];
                    let carried = (0..points.places.len()).map(of).sum::<f64>() - cells.left().map(of).sum::<f64>();
                    let ratio = carried / mass[start..].iter().sum::<f64>();
                    mass[start..].iter_mut().for_each(|m| *m *= ratio);
                }
                self.push_left(model, state, points, rows, mass);
            }
            Ok(())
        });
        self.grid.tied = tied;
        if !model.walls.is_empty() {
            self.set_walls(model, &all, &mut matrix);
        }
        (self.matrix, self.integration, self.shares) = (matrix, all, shares);
        made
    }

    /// Appends particles that no point stands for.
    fn push_left(&mut self, model: &Model, state: &State, points: &BodyPoints, rows: &mut SparseRows, mass: &mut Vec<f64>) {
        let Rule::Cells(cells) = &points.rule else { return };
        for p in cells.left() {
            let place = points.places[p] as usize;
            let x: [f64; 3] = state.particles.position.row(place);
            let half = model.half_lengths(&state.particles, place);
            self.kernels.point_weights(&model.axes, [x, half, [0.0; 3]], &mut self.rows);
            let field = model.field(state.particles.body[place]);
            // the nodes of a particle are always there
            if rows.push(&self.rows, false, |node| self.grid.node(field, node)).is_ok() {
                mass.push(state.particles.mass[place]);
            }
        }
    }

    /// Sums momentum over the points instead of the particles, whose mass stays on the nodes; and, with forces, those of body forces.
    pub(super) fn sum_at_points(&mut self, model: &Model, state: &State, forces: bool) {
        let mut all = std::mem::take(&mut self.integration);
        let mut values = Vec::new();
        all.at_points(model.dimension, |p, a| state.particles.velocity.column(a)[p], &mut values);
        self.matrix.to_nodes(&all.conserve(model, state, values, self.matrix.masses()), true, &mut self.grid.momentum);
        all.velocity_at_edges(model, |p, a| state.particles.velocity.column(a)[p]);
        if forces && model.needs.body_force {
            let mut values = Vec::new();
            all.at_points(model.dimension, |p, a| self.body_force[a][p], &mut values);
            self.matrix.to_nodes(&values, false, &mut self.grid.force);
        }
        self.integration = all;
    }
}

impl Integration {
    /// A vector at the particles, taken to the points of all bodies and the particles that no point stands for.
    fn at_points(&mut self, dimension: usize, vector: impl Fn(usize, usize) -> f64, values: &mut Vec<[f64; 3]>) {
        let Self { bodies, columns, of_1, of_2, of_3, .. } = self;
        for points in bodies {
            fill(columns, dimension, &points.places, &vector);
            match dimension {
                1 => {
                    of_1.take(&points.rule, columns);
                    values.extend(of_1.values.iter().map(|v| [v[0], 0.0, 0.0]));
                }
                2 => {
                    of_2.take(&points.rule, columns);
                    values.extend(of_2.values.iter().map(|v| [v[0], v[1], 0.0]));
                }
                _ => {
                    of_3.take(&points.rule, columns);
                    values.extend(of_3.values.iter().copied());
                }
            }
            if let Rule::Cells(cells) = &points.rule {
                let of = |p: usize| std::array::from_fn(|a| if a < dimension { vector(points.places[p] as usize, a) } else { 0.0 });
                values.extend(cells.left().map(of));
            }
        }
    }

    /// Makes the momentum of bodies whose points stand in cells that of their particles.
    fn conserve(&self, model: &Model, state: &State, mut velocities: Vec<[f64; 3]>, masses: &[f64]) -> Vec<[f64; 3]> {
        let mut start = 0;
        for points in &self.bodies {
            let left = if let Rule::Cells(cells) = &points.rule { cells.left().count() } else { 0 };
            let own = start..start + points.rule.points().len() + left;
            start = own.end;
            if matches!(points.rule, Rule::Lines(_) | Rule::Sheet(_)) {
                continue;
            }
            let whole: f64 = masses[own.clone()].iter().sum();
            for a in 0..model.dimension {
                let column = state.particles.velocity.column(a);
                let carried: f64 = points.places.iter().map(|&p| state.particles.mass[p as usize] * column[p as usize]).sum();
                let found: f64 = masses[own.clone()].iter().zip(&velocities[own.clone()]).map(|(m, v)| m * v[a]).sum();
                velocities[own.clone()].iter_mut().for_each(|v| v[a] += (carried - found) / whole);
            }
        }
        velocities
    }
}

/// Columns of a quantity at the particles at `places`.
pub(super) fn fill(columns: &mut Vec<Vec<f64>>, count: usize, places: &[u32], value: impl Fn(usize, usize) -> f64) {
    columns.resize(columns.len().max(count), Vec::new());
    for (k, column) in columns.iter_mut().enumerate().take(count) {
        column.clear();
        column.extend(places.iter().map(|&p| value(p as usize, k)));
    }
}

/// Nodes that get forces.
struct Target<'a> {
    force: &'a mut [Lanes],
    /// Mass of the nodes, where a point that reaches a node without any is left out.
    mass: Option<&'a [Lanes]>,
    model: &'a Model,
}

/// Forces from the stress at the points of a body, whose first row is `first`; `component` is the place of each stress component among the
/// values, 9 for none.
fn push_forces<const K: usize>(
    rows: &SparseRows,
    first: usize,
    points: &[Point],
    stress: &[[f64; K]],
    component: [[usize; 3]; 3],
    target: &mut Target,
) {
    for (row, (point, values)) in (first..).zip(points.iter().zip(stress)) {
        let empty = |(node, slope): (usize, [f64; 3])| target.mass.is_some_and(|m| slope != [0.0; 3] && is_empty(target.model, m[node][0]));
        if rows.slopes(row).any(empty) {
            continue;
        }
        let sigma = component.map(|row| row.map(|k| values.get(k).map_or(0.0, |s| point.weight * s)));
        for (node, slope) in rows.slopes(row) {
            for a in 0..3 {
                target.force[node][1 + a] -= sigma[a][0] * slope[0] + sigma[a][1] * slope[1] + sigma[a][2] * slope[2];
            }
        }
    }
}
