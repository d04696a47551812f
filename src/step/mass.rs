//! Mass matrices that are not diagonal: M = sum m N N^T over the points where mass sits, never assembled, with its solvers.
//!
//! Nearly empty nodes are why the papers' consistent projection fails (Tielen 2016, section 7.2.4): little mass says next to nothing about
//! their value, so it may become anything. Rows and columns of nodes below a mass are lumped instead: what couples such a node to another
//! goes to both diagonals. The matrix stays symmetric and positive, and its row sums, so mass and momentum, stay what they are.

use super::direct::{Direct, Group};
use super::sparse::SparseRows;
use crate::grid::{Lanes, Tied};
use crate::model::{MassRule, Masses, Model};
use crate::scene::MassSolver;

/// A node that follows none.
const NONE: u32 = u32::MAX;

/// Iterations after which a solver has failed.
const MOST_ITERATIONS: usize = 10_000;

/// Mass along a direction, over that of its nodes alone, below which it has none: round-off of some hundred terms.
const NO_MASS: f64 = 1e-13;
/// Largest relative residual of a singular matrix that still is round-off.
const ROUND_OFF: f64 = 1e-7;

/// Share of the largest entry of the diagonal up to which a node has no mass: shape functions below 1e-10 are round-off of positions.
pub(super) const NOTHING: f64 = 1e-20;

/// A mass matrix and the scratch memory of its solvers.
#[derive(Debug, Default)]
pub(super) struct MassMatrix {
    rows: SparseRows,
    /// Mass at each point \[kg\].
    mass: Vec<f64>,
    diagonal: Vec<f64>,
    /// Whether no shape function is negative anywhere.
    positive: bool,
    /// Row sums.
    lumped: Vec<f64>,
    /// Whether a node is lumped.
    light: Vec<bool>,
    any_light: bool,
    /// What the couplings to lumped nodes give to the diagonal of the others.
    shared: Vec<f64>,
    residual: Vec<Lanes>,
    direction: Vec<Lanes>,
    product: Vec<Lanes>,
    masked: Vec<Lanes>,
    /// Nodes that follow others: the matrix is that of their masters.
    tied: Tied,
    /// Place of a node in that list.
    follows: Vec<u32>,
    /// Points of edges that stick to walls.
    walls: SparseRows,
    /// How strongly they do, by lane \[kg\]: a mass that moves with the wall.
    strength: Vec<Lanes>,
    /// A factor of the matrix, where it is asked for.
    direct: Direct,
    /// Residual times the inverse of what the iteration starts from.
    preconditioned: Vec<Lanes>,
}

/// A solver did not get down to its residual.
#[derive(Debug, Clone, Copy)]
pub(super) struct NotConverged {
    pub(super) iterations: usize,
    pub(super) residual: f64,
}

impl MassMatrix {
    /// Takes over points with their masses, for nodes whose functions have these integrals, over that of one in the middle of the grid.
    pub(super) fn set<E>(
        &mut self,
        model: &Model,
        shares: &[f64],
        tied: &Tied,
        fill: impl FnOnce(&mut SparseRows, &mut Vec<f64>) -> Result<(), E>,
    ) -> Result<(), E> {
        self.rows.clear(model);
        self.mass.clear();
        fill(&mut self.rows, &mut self.mass)?;
        for values in [&mut self.diagonal, &mut self.lumped, &mut self.shared] {
            values.clear();
            values.resize(shares.len(), 0.0);
        }
        self.tied.clone_from(tied);
        self.follows.clear();
        self.follows.resize(shares.len(), NONE);
        for (k, (node, _)) in tied.iter().enumerate() {
            self.follows[node] = k as u32;
        }
        let mut row = Vec::new();
        for p in 0..self.rows.len() {
            reduce(&self.rows, p, tied, &self.follows, &mut row);
            for &(node, weight) in &row {
                self.diagonal[node] += self.mass[p] * weight * weight;
                self.lumped[node] += self.mass[p] * weight;
            }
        }
        self.strength.clear();
        self.direct.clear();
        self.positive = model.masses == Masses::Positive;
        let largest = self.diagonal.iter().copied().fold(0.0, f64::max);
        for (diagonal, mass) in self.diagonal.iter_mut().zip(&self.lumped) {
            // nothing is there but round-off
            if *diagonal < NOTHING * largest || (self.positive && *mass <= 0.0) {
                *diagonal = 0.0;
            }
        }
        self.lump_light(model.lump_below, shares);
        Ok(())
    }

    /// Takes over points of edges that stick to walls, with the strength by lane.
    pub(super) fn set_walls(&mut self, walls: &SparseRows, strength: Vec<Lanes>) {
        let mut row = Vec::new();
        for (p, strength) in strength.iter().enumerate() {
            reduce(walls, p, &self.tied, &self.follows, &mut row);
            for &(node, weight) in &row {
                // one preconditioner for all lanes
                self.diagonal[node] += weight * weight * strength.iter().copied().fold(0.0, f64::max);
            }
        }
        self.walls.clone_from(walls);
        self.strength = strength;
    }

    /// Adds what walls with these velocities give to the right side.
    pub(super) fn add_walls(&self, velocities: &[Lanes], to: &mut [Lanes]) {
        for (p, (v, strength)) in velocities.iter().zip(&self.strength).enumerate() {
            self.walls.add(p, std::array::from_fn(|lane| strength[lane] * v[lane]), to);
        }
        self.tied.fold(to);
    }

    /// Impulse of the walls on a field \[kg times its unit\], point by point: what is still missing from `velocities`.
    pub(super) fn wall_impulses(&self, velocities: &[Lanes], field: &[Lanes]) -> Vec<Lanes> {
        let of = |(p, (v, strength)): (usize, (&Lanes, &Lanes))| {
            let now = self.walls.value(p, field);
            std::array::from_fn(|lane| strength[lane] * (v[lane] - now[lane]))
        };
        velocities.iter().zip(&self.strength).enumerate().map(of).collect()
    }

    /// Whether a node has a value of its own.
    #[cfg(test)]
    pub(super) fn stands(&self, node: usize) -> bool {
        self.diagonal[node] > 0.0 && self.follows[node] == NONE
    }

    /// Row sum of a node \[kg\], where there is a matrix.
    pub(super) fn lumped(&self, node: usize) -> Option<f64> {
        self.lumped.get(node).copied()
    }

    /// Mass at each point \[kg\].
    pub(super) fn masses(&self) -> &[f64] {
        &self.mass
    }

    /// Adds `sum m v N` over the points to all lanes of the nodes but the first; `anew`: to 0.
    pub(super) fn to_nodes(&self, velocities: &[[f64; 3]], anew: bool, to: &mut [Lanes]) {
        if anew {
            to.iter_mut().for_each(|lanes| lanes[1..].fill(0.0));
        }
        for (p, v) in velocities.iter().enumerate() {
            let m = self.mass[p];
            self.rows.add(p, [0.0, m * v[0], m * v[1], m * v[2]], to);
        }
    }

    /// Lumps nodes below a mass: a function that the end of the grid makes narrower may have as much less in full cells.
    fn lump_light(&mut self, below: f64, shares: &[f64]) {
        self.light.clear();
        self.light.extend(self.lumped.iter().zip(shares).map(|(&m, share)| m > 0.0 && m < below * share));
        self.any_light = self.light.contains(&true);
        if !self.any_light {
            return;
        }
        for p in 0..self.rows.len() {
            let to_light: f64 = self.rows.row(p).filter(|(node, _)| self.light[*node]).map(|(_, weight)| weight).sum();
            for (node, weight) in self.rows.row(p) {
                self.shared[node] += self.mass[p] * weight * to_light;
            }
        }
        for node in 0..self.light.len() {
            self.diagonal[node] = if self.light[node] { self.lumped[node] } else { self.diagonal[node] + self.shared[node] };
        }
    }

    /// Factors the matrix with its walls. Points of one cell come one after the other.
    fn factor(&mut self) {
        let mut groups: Vec<Group> = Vec::new();
        let (mut row, mut place) = (Vec::new(), Vec::new());
        let mut before = usize::MAX;
        for p in 0..self.rows.len() {
            reduce(&self.rows, p, &self.tied, &self.follows, &mut row);
            row.retain(|(node, _)| !self.light[*node]);
            let first = self.rows.row(p).next().map_or(usize::MAX, |(node, _)| node);
            if first != before {
                groups.push(Group::new(&row));
            }
            before = first;
            if let Some(group) = groups.last_mut() {
                group.add(&row, self.mass[p], &mut place);
            }
        }
        for (p, strength) in self.strength.iter().enumerate() {
            reduce(&self.walls, p, &self.tied, &self.follows, &mut row);
            let mut group = Group::new(&row);
            group.add(&row, strength.iter().copied().fold(0.0, f64::max), &mut place);
            groups.push(group);
        }
        for node in (0..self.light.len()).filter(|_| self.any_light) {
            let own = if self.light[node] { self.lumped[node] } else { self.shared[node] };
            if own > 0.0 {
                groups.push(Group::of(node, own));
            }
        }
        self.direct.factor(self.lumped.len(), &groups);
    }

    /// `product` = M `field`, with what walls add or without.
    fn apply(&mut self, field: &[Lanes], with_walls: bool) {
        let Self { rows, mass, light, lumped, shared, product, masked, tied, walls, strength, .. } = self;
        product.clear();
        product.resize(field.len(), Lanes::default());
        let seen = if self.any_light || !tied.is_empty() {
            masked.clear();
            masked.extend_from_slice(field);
            tied.spread(masked);
            if self.any_light {
                masked.iter_mut().zip(light.iter()).filter(|(_, light)| **light).for_each(|(v, _)| *v = Lanes::default());
            }
            masked.as_slice()
        } else {
            field
        };
        for p in 0..rows.len() {
            let value = rows.value(p, seen);
            rows.add(p, value.map(|v| mass[p] * v), product);
        }
        if with_walls {
            for (p, strength) in strength.iter().enumerate() {
                let value = walls.value(p, seen);
                walls.add(p, std::array::from_fn(|lane| strength[lane] * value[lane]), product);
            }
        }
        tied.fold(product);
        if self.any_light {
            for node in 0..field.len() {
                for lane in 0..4 {
                    let own = shared[node] * field[node][lane];
                    product[node][lane] = if light[node] { lumped[node] * field[node][lane] } else { product[node][lane] + own };
                }
            }
        }
    }

    /// M `field`, valid until the next call.
    pub(super) fn times(&mut self, field: &[Lanes], with_walls: bool) -> &[Lanes] {
        self.apply(field, with_walls);
        &self.product
    }

    /// Solves M x = right side, lane by lane but for the first, which is left alone. Nodes without mass get zero. Returns the number of
    /// iterations.
    pub(super) fn solve(&mut self, rule: MassRule, held: &[Held], right: &[Lanes], x: &mut [Lanes]) -> Result<usize, NotConverged> {
        // the lumped solution: where the series starts, and a good guess elsewhere; it means nothing where functions are negative
        for (node, value) in x.iter_mut().enumerate() {
            let mass = if self.positive { self.lumped[node] } else { 0.0 };
            for lane in 1..4 {
                value[lane] = if mass > 0.0 { right[node][lane] / mass } else { 0.0 };
            }
        }
        for h in held {
            x[h.node][h.lane] = h.value;
        }
        match rule {
            MassRule::Lumped => Ok(0),
            MassRule::Series(terms) => {
                for _ in 1..terms {
                    self.find_residual(held, right, x);
                    self.correct(x);
                }
                Ok(terms - 1)
            }
            MassRule::Solved { solver: MassSolver::Richardson, residual } => self.richardson(residual, held, right, x),
            MassRule::Solved { solver: MassSolver::Direct, residual } => {
                if !self.direct.is_ready() {
                    self.factor();
                }
                self.conjugate_gradients(residual, held, right, x)
            }
            MassRule::Solved { solver: MassSolver::Pcg, residual } => self.conjugate_gradients(residual, held, right, x),
        }
    }

    /// `residual` = right side - M x, zero where x is held.
    fn find_residual(&mut self, held: &[Held], right: &[Lanes], x: &[Lanes]) {
        self.apply(x, true);
        self.residual.clear();
        self.residual.extend(right.iter().zip(&self.product).map(|(r, m)| std::array::from_fn::<f64, 4, _>(|l| r[l] - m[l])));
        for h in held {
            self.residual[h.node][h.lane] = 0.0;
        }
    }

    /// x += M_L^-1 residual.
    fn correct(&self, x: &mut [Lanes]) {
        for (node, value) in x.iter_mut().enumerate() {
            if self.lumped[node] > 0.0 {
                for lane in 1..4 {
                    value[lane] += self.residual[node][lane] / self.lumped[node];
                }
            }
        }
    }

    /// Richardson iteration M_L v' = P + (M_L - M) v, until |P - M v| <= residual |P| (Tielen 2016, section 7.2).
    fn richardson(&mut self, target: f64, held: &[Held], right: &[Lanes], x: &mut [Lanes]) -> Result<usize, NotConverged> {
        self.find_residual(held, right, x);
        let wanted = self.scale(right);
        for iteration in 0..MOST_ITERATIONS {
            if largest(&ratios(&norms(&self.residual), &wanted)) <= target {
                return Ok(iteration);
            }
            self.correct(x);
            self.find_residual(held, right, x);
        }
        Err(NotConverged { iterations: MOST_ITERATIONS, residual: largest(&ratios(&norms(&self.residual), &wanted)) })
    }

    /// Conjugate gradients with the diagonal as preconditioner, a system a lane. The same stopping rule; besides, a lane stops where its
    /// direction has no mass: fewer particles than nodes leave the matrix singular, and what is left of the residual is round-off.
    fn conjugate_gradients(&mut self, target: f64, held: &[Held], right: &[Lanes], x: &mut [Lanes]) -> Result<usize, NotConverged> {
        self.find_residual(held, right, x);
        let wanted = self.scale(right);
        let mut direction = std::mem::take(&mut self.direction);
        direction.clear();
        direction.resize(x.len(), Lanes::default());
        let (mut before, mut stopped) = ([0.0; 4], [false; 4]);
        let mut outcome = Err(NotConverged { iterations: MOST_ITERATIONS, residual: f64::NAN });
        for iteration in 0..MOST_ITERATIONS {
            let left = ratios(&norms(&self.residual), &wanted);
            if (1..4).all(|lane| stopped[lane] || left[lane] <= target) {
                // a right side that no velocity can have is none of round-off
                let lost = (1..4).any(|lane| left[lane] > target.max(ROUND_OFF));
                outcome = if lost { Err(NotConverged { iterations: iteration, residual: largest(&left) }) } else { Ok(iteration) };
                break;
            }
            outcome = Err(NotConverged { iterations: iteration, residual: largest(&left) });
            self.precondition(held);
            let now = dots(&self.residual, &self.preconditioned);
            for (d, z) in direction.iter_mut().zip(&self.preconditioned) {
                for lane in 1..4 {
                    let more = if before[lane] > 0.0 { now[lane] / before[lane] } else { 0.0 };
                    d[lane] = z[lane] + more * d[lane];
                }
            }
            before = now;
            self.apply(&direction, true);
            for h in held {
                self.product[h.node][h.lane] = 0.0;
            }
            let curvature = dots(&direction, &self.product);
            let mut size = Lanes::default();
            for (d, mass) in direction.iter().zip(&self.diagonal) {
                (1..4).for_each(|lane| size[lane] += mass * d[lane] * d[lane]);
            }
            for lane in 1..4 {
                stopped[lane] |= curvature[lane] <= NO_MASS * size[lane];
            }
            for (node, value) in x.iter_mut().enumerate() {
                for lane in (1..4).filter(|lane| !stopped[*lane]) {
                    let step = now[lane] / curvature[lane];
                    value[lane] += step * direction[node][lane];
                    self.residual[node][lane] -= step * self.product[node][lane];
                }
            }
        }
        self.direction = direction;
        outcome
    }

    /// What a residual is compared with: the right side, and M times the first guess, for held values may be all that drives a field.
    fn scale(&self, right: &[Lanes]) -> Lanes {
        let (right, first) = (norms(right), norms(&self.product));
        std::array::from_fn(|lane| right[lane] + first[lane])
    }

    /// What the residual says about the solution: by the factor where there is one, else by the diagonal.
    fn precondition(&mut self, held: &[Held]) {
        let Self { direct, residual, preconditioned, diagonal, .. } = self;
        if direct.is_ready() {
            direct.solve(residual, preconditioned);
            for h in held {
                preconditioned[h.node][h.lane] = 0.0;
            }
        } else {
            let of = |(r, d): (&Lanes, &f64)| if *d > 0.0 { r.map(|r| r / d) } else { Lanes::default() };
            preconditioned.clear();
            preconditioned.extend(residual.iter().zip(diagonal.iter()).map(of));
        }
    }
}

/// Nodes and weights of a point, once those of tied nodes are counted to their masters.
pub(super) type Reduced = [(usize, f64)];

/// The row of a point, with tied nodes counted to their masters.
fn reduce(rows: &SparseRows, point: usize, tied: &Tied, follows: &[u32], row: &mut Vec<(usize, f64)>) {
    row.clear();
    row.extend(rows.row(point));
    if tied.is_empty() {
        return;
    }
    let own = row.len();
    for k in 0..own {
        let (node, weight) = row[k];
        if follows[node] == NONE {
            continue;
        }
        row[k].1 = 0.0;
        for &(master, share) in tied.masters(follows[node] as usize) {
            match row.iter_mut().find(|(known, _)| *known == master as usize) {
                Some((_, sum)) => *sum += share * weight,
                None => row.push((master as usize, share * weight)),
            }
        }
    }
    row.retain(|(node, _)| follows[*node] == NONE);
}

/// A degree of freedom whose value is given.
#[derive(Debug, Clone, Copy)]
pub(super) struct Held {
    pub(super) node: usize,
    pub(super) lane: usize,
    pub(super) value: f64,
}

fn dots(a: &[Lanes], b: &[Lanes]) -> Lanes {
    let mut sum = Lanes::default();
    for (a, b) in a.iter().zip(b) {
        for lane in 1..4 {
            sum[lane] += a[lane] * b[lane];
        }
    }
    sum
}

fn norms(field: &[Lanes]) -> Lanes {
    dots(field, field).map(f64::sqrt)
}

/// Ratio of each lane; a lane that is all zero has none.
fn ratios(of: &Lanes, over: &Lanes) -> Lanes {
    std::array::from_fn(|l| if of[l] == 0.0 { 0.0 } else { of[l] / over[l] })
}

fn largest(of: &Lanes) -> f64 {
    of[1..].iter().copied().fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::basis::BATCH;
    use crate::basis::Places;
    use crate::model::Model;
    use crate::scene::Scene;
    use crate::step::Stepper;
    use crate::transfer::StencilRows;

    /// The matrix of particles at these places on a grid of ten cells of length 1, quadratic B-splines.
    fn matrix(places: &[f64], tolerance: f64) -> (MassMatrix, Model) {
        let text = format!(
            r#"
            title = "mass"
            dimension = 1
            grid = {{ origin = [0], size = [10], cell = 1 }}
            material.m = {{ law = "linear_elastic", young = 1, density = 1 }}
            method = {{ mass = "consistent", mass_tolerance = {tolerance} }}
            body.b = {{ material = "m", shape = {{ box = {{ min = [0], max = [10] }} }}, particles_per_cell = 1 }}
            time = {{ end = 1 }}
            "#
        );
        let (model, _) = Model::new(&Scene::from_toml(&text).unwrap()).unwrap();
        let stepper = Stepper::new(&model);
        let mut matrix = MassMatrix::default();
        let set: Result<(), usize> = matrix.set(&model, &[1.0; 12], &Tied::default(), |rows, mass| {
            let mut stencils = StencilRows::default();
            for x in places {
                let place = Places { position: [[*x; BATCH]; 3], half: [[0.0; BATCH]; 3] };
                stepper.kernels.stencils(&model.axes, &place, 1, &mut stencils);
                rows.push(&stencils, false, |node| Some(node[2] as usize))?;
                mass.push(1.0);
            }
            Ok(())
        });
        set.unwrap();
        (matrix, model)
    }

    fn full() -> Vec<f64> {
        (0..40).map(|i| 0.25 * (f64::from(i) + 0.5)).collect()
    }

    fn field(f: impl Fn(usize) -> f64) -> Vec<Lanes> {
        (0..12).map(|i| [0.0, f(i), 0.0, 1.0]).collect()
    }

    #[test]
    fn solvers_invert_what_times_does() {
        let (mut matrix, _) = matrix(&full(), 0.1);
        let exact = field(|i| (i as f64).sin());
        let right = matrix.times(&exact, false).to_vec();
        for solver in [MassSolver::Pcg, MassSolver::Richardson] {
            let mut x = field(|_| 0.0);
            let rule = MassRule::Solved { solver, residual: 1e-12 };
            let iterations = matrix.solve(rule, &[], &right, &mut x).unwrap();
            // residual times condition, which is about 20
            assert!(x.iter().zip(&exact).all(|(a, b)| (a[1] - b[1]).abs() < 1e-10), "{solver:?}");
            assert!(iterations < if solver == MassSolver::Pcg { 15 } else { 400 }, "{solver:?}: {iterations}");
        }
    }

    #[test]
    fn the_series_is_richardson_cut_short() {
        let (mut matrix, _) = matrix(&full(), 0.1);
        let right = matrix.times(&field(|i| (i as f64).sin()), false).to_vec();
        let mut errors = Vec::new();
        for terms in [1, 2, 4, 8, 16] {
            let mut x = field(|_| 0.0);
            assert_eq!(matrix.solve(MassRule::Series(terms), &[], &right, &mut x).unwrap(), terms - 1);
            errors.push(x.iter().enumerate().map(|(i, v)| (v[1] - (i as f64).sin()).abs()).fold(0.0, f64::max));
            if terms == 1 {
                assert!((x[5][1] - right[5][1] / matrix.lumped[5]).abs() < 1e-15, "one term is the lumped mass");
            }
        }
        assert!(errors.is_sorted_by(|a, b| a > b), "{errors:?}");
    }

    #[test]
    fn held_values_stay_and_drive_the_others() {
        let (mut matrix, _) = matrix(&full(), 0.1);
        let exact = field(|i| 1.0 + i as f64);
        let right = matrix.times(&exact, false).to_vec();
        let held = [Held { node: 0, lane: 1, value: 1.0 }, Held { node: 11, lane: 1, value: 12.0 }];
        let mut x = field(|_| 0.0);
        let rule = MassRule::Solved { solver: MassSolver::Pcg, residual: 1e-12 };
        matrix.solve(rule, &held, &right, &mut x).unwrap();
        assert!(x.iter().zip(&exact).all(|(a, b)| (a[1] - b[1]).abs() < 1e-10));
        assert_eq!((x[0][1], x[11][1]), (1.0, 12.0));
    }

    #[test]
    fn nearly_empty_nodes_are_lumped_and_sums_are_kept() {
        // a body that ends just above a cell edge: the last node it reaches has next to no mass
        let places: Vec<f64> = full().into_iter().map(|x| 0.5 * x).chain([5.01]).collect();
        let (mut raw, _) = matrix(&places, 0.0);
        let (mut mended, _) = matrix(&places, 0.1);
        assert!(!raw.any_light && mended.any_light);
        let field = field(|i| (0.7 * i as f64).cos());
        let sum = |v: &[Lanes]| v.iter().map(|l| l[1]).sum::<f64>();
        let (a, b) = (raw.times(&field, false).to_vec(), mended.times(&field, false).to_vec());
        // row sums: a constant field has the same momentum, node by node
        let ones: Vec<Lanes> = vec![[1.0; 4]; 12];
        for (r, m) in raw.times(&ones, false).to_vec().iter().zip(mended.times(&ones, false)) {
            assert!((r[1] - m[1]).abs() < 1e-14);
        }
        assert!((sum(&a) - sum(&b)).abs() < 1e-13, "columns sum up to the lumped mass too: the matrix is symmetric");
        let light = mended.light.iter().position(|l| *l).unwrap();
        assert!((b[light][1] - mended.lumped[light] * field[light][1]).abs() < 1e-16);
    }

    #[test]
    fn a_singular_matrix_is_solved_where_it_can_be() {
        // one particle for three nodes: infinitely many solutions, all of which have its velocity there
        let (mut matrix, _) = matrix(&[4.3], 0.0);
        let velocity = 2.5;
        let mut right = vec![[0.0; 4]; 12];
        matrix.to_nodes(&[[velocity, 0.0, 0.0]], true, &mut right);
        let mut x = field(|_| 0.0);
        let rule = MassRule::Solved { solver: MassSolver::Pcg, residual: 1e-15 };
        matrix.solve(rule, &[], &right, &mut x).unwrap();
        assert!((matrix.rows.value(0, &x)[1] - velocity).abs() < 1e-14);
        // and one that has none says so
        right[5][1] += 1.0;
        assert!(matrix.solve(rule, &[], &right, &mut x).unwrap_err().residual > 0.1);
    }
}
