//! Mass matrices that are not diagonal: M = sum m N N^T over the points where mass sits, never assembled, with its solvers.
//!
//! Nearly empty nodes are why the papers' consistent projection fails (Tielen 2016, section 7.2.4): little mass says next to nothing about
//! their value, so it may become anything. Rows and columns of nodes below a mass are lumped instead: what couples such a node to another
//! goes to both diagonals. The matrix stays symmetric and positive, and its row sums, so mass and momentum, stay what they are.

use super::sparse::SparseRows;
use crate::grid::Lanes;
use crate::model::{MassRule, Model};
use crate::scene::MassSolver;

/// Iterations after which a solver has failed.
const MOST_ITERATIONS: usize = 10_000;

/// A mass matrix and the scratch memory of its solvers.
#[derive(Debug, Default)]
pub(super) struct MassMatrix {
    rows: SparseRows,
    /// Mass at each point \[kg\].
    mass: Vec<f64>,
    diagonal: Vec<f64>,
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
}

/// A solver did not get down to its residual.
#[derive(Debug, Clone, Copy)]
pub(super) struct NotConverged {
    pub(super) iterations: usize,
    pub(super) residual: f64,
}

impl MassMatrix {
    /// Takes over points with their masses, for a grid of this many nodes.
    pub(super) fn set<E>(
        &mut self,
        model: &Model,
        nodes: usize,
        fill: impl FnOnce(&mut SparseRows, &mut Vec<f64>) -> Result<(), E>,
    ) -> Result<(), E> {
        self.rows.clear(model);
        self.mass.clear();
        fill(&mut self.rows, &mut self.mass)?;
        for values in [&mut self.diagonal, &mut self.lumped, &mut self.shared] {
            values.clear();
            values.resize(nodes, 0.0);
        }
        for p in 0..self.rows.len() {
            for (node, weight) in self.rows.row(p) {
                self.diagonal[node] += self.mass[p] * weight * weight;
                self.lumped[node] += self.mass[p] * weight;
            }
        }
        self.lump_light(model.lump_below);
        Ok(())
    }

    /// Momentum on the nodes, `sum m v N` over the points, in all lanes but the first.
    pub(super) fn momentum(&self, velocities: &[[f64; 3]], to: &mut [Lanes]) {
        for lanes in to.iter_mut() {
            lanes[1..].fill(0.0);
        }
        for (p, v) in velocities.iter().enumerate() {
            let m = self.mass[p];
            self.rows.add(p, [0.0, m * v[0], m * v[1], m * v[2]], to);
        }
    }

    fn lump_light(&mut self, below: f64) {
        self.light.clear();
        self.light.extend(self.lumped.iter().map(|&m| m > 0.0 && m < below));
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

    /// `product` = M `field`.
    fn apply(&mut self, field: &[Lanes]) {
        let Self { rows, mass, light, lumped, shared, product, masked, .. } = self;
        product.clear();
        product.resize(field.len(), Lanes::default());
        let seen = if self.any_light {
            masked.clear();
            masked.extend(field.iter().zip(light.iter()).map(|(v, light)| if *light { Lanes::default() } else { *v }));
            masked.as_slice()
        } else {
            field
        };
        for p in 0..rows.len() {
            let value = rows.value(p, seen);
            rows.add(p, value.map(|v| mass[p] * v), product);
        }
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
    pub(super) fn times(&mut self, field: &[Lanes]) -> &[Lanes] {
        self.apply(field);
        &self.product
    }

    /// Solves M x = right side, lane by lane but for the first, which is left alone. Nodes without mass get zero. Returns the number of
    /// iterations.
    pub(super) fn solve(&mut self, rule: MassRule, held: &[Held], right: &[Lanes], x: &mut [Lanes]) -> Result<usize, NotConverged> {
        // the lumped solution: where the series starts, and a good guess elsewhere; it means nothing where functions are negative
        for (node, value) in x.iter_mut().enumerate() {
            let mass = self.lumped[node];
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
            MassRule::Solved { solver: MassSolver::Pcg, residual } => self.conjugate_gradients(residual, held, right, x),
        }
    }

    /// `residual` = right side - M x, zero where x is held.
    fn find_residual(&mut self, held: &[Held], right: &[Lanes], x: &[Lanes]) {
        self.apply(x);
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
            if worst(&norms(&self.residual), &wanted) <= target {
                return Ok(iteration);
            }
            self.correct(x);
            self.find_residual(held, right, x);
        }
        Err(NotConverged { iterations: MOST_ITERATIONS, residual: worst(&norms(&self.residual), &wanted) })
    }

    /// Conjugate gradients with the diagonal as preconditioner, a system a lane. The same stopping rule.
    fn conjugate_gradients(&mut self, target: f64, held: &[Held], right: &[Lanes], x: &mut [Lanes]) -> Result<usize, NotConverged> {
        self.find_residual(held, right, x);
        let wanted = self.scale(right);
        let mut direction = std::mem::take(&mut self.direction);
        direction.clear();
        direction.resize(x.len(), Lanes::default());
        let mut before = [0.0; 4];
        let mut outcome = Err(NotConverged { iterations: MOST_ITERATIONS, residual: f64::NAN });
        for iteration in 0..MOST_ITERATIONS {
            let left = worst(&norms(&self.residual), &wanted);
            if left <= target {
                outcome = Ok(iteration);
                break;
            }
            outcome = Err(NotConverged { iterations: iteration, residual: left });
            let now = self.preconditioned_square();
            for (node, d) in direction.iter_mut().enumerate() {
                let inverse = if self.diagonal[node] > 0.0 { 1.0 / self.diagonal[node] } else { 0.0 };
                for lane in 1..4 {
                    let more = if before[lane] > 0.0 { now[lane] / before[lane] } else { 0.0 };
                    d[lane] = self.residual[node][lane] * inverse + more * d[lane];
                }
            }
            before = now;
            self.apply(&direction);
            for h in held {
                self.product[h.node][h.lane] = 0.0;
            }
            let curvature = dots(&direction, &self.product);
            for (node, value) in x.iter_mut().enumerate() {
                for lane in 1..4 {
                    if curvature[lane] > 0.0 {
                        let step = now[lane] / curvature[lane];
                        value[lane] += step * direction[node][lane];
                        self.residual[node][lane] -= step * self.product[node][lane];
                    }
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

    /// r . D^-1 r by lane.
    fn preconditioned_square(&self) -> Lanes {
        let mut sum = Lanes::default();
        for (r, d) in self.residual.iter().zip(&self.diagonal) {
            if *d > 0.0 {
                for lane in 1..4 {
                    sum[lane] += r[lane] * r[lane] / d;
                }
            }
        }
        sum
    }
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

/// Largest ratio of a lane; a lane that is all zero has none.
fn worst(of: &Lanes, over: &Lanes) -> f64 {
    (1..4).map(|l| if of[l] == 0.0 { 0.0 } else { of[l] / over[l] }).fold(0.0, f64::max)
}
