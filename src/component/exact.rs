//! The known solution of a scene: formulas, or a table made by another program.

use crate::model::SPACE_TIME;
use crate::scene::{self, Formula, StressComponent};
use nalgebra::Matrix3;

/// The known solution.
#[derive(Clone)]
pub(super) struct Exact {
    displacement: Vec<Formula>,
    velocity: Vec<Formula>,
    stress: Vec<(StressComponent, Formula)>,
    reference: Option<Reference>,
}

impl Exact {
    pub(super) fn new(exact: &scene::Exact, dimension: usize) -> Result<Self, String> {
        let compile = |list: &[scene::Expr]| list.iter().map(|e| e.compile(&SPACE_TIME)).collect::<Result<Vec<_>, _>>();
        let reference = exact.reference.as_ref().map(|file| Reference::read(file)).transpose()?;
        debug_assert!(reference.is_none() || dimension == 1, "checked with the scene");
        Ok(Self {
            displacement: compile(&exact.displacement)?,
            velocity: compile(&exact.velocity)?,
            stress: exact.stress.iter().map(|(c, e)| Ok((*c, e.compile(&SPACE_TIME)?))).collect::<Result<_, String>>()?,
            reference,
        })
    }

    pub(super) fn has_displacement(&self) -> bool {
        !self.displacement.is_empty() || self.reference.is_some()
    }
    pub(super) fn has_velocity(&self) -> bool {
        !self.velocity.is_empty() || self.reference.is_some()
    }
    pub(super) fn has_stress(&self) -> bool {
        !self.stress.is_empty() || self.reference.is_some()
    }

    /// Displacement of the particle that was at `x` at time 0 \[m\]; `None` where the table has no such time.
    pub(super) fn displacement(&self, x: [f64; 3], time: f64) -> Option<Vec<f64>> {
        self.vector(&self.displacement, x, time, 0)
    }

    pub(super) fn velocity(&self, x: [f64; 3], time: f64) -> Option<Vec<f64>> {
        self.vector(&self.velocity, x, time, 1)
    }

    fn vector(&self, formulas: &[Formula], [x, y, z]: [f64; 3], time: f64, column: usize) -> Option<Vec<f64>> {
        match (&self.reference, formulas.is_empty()) {
            (Some(reference), true) => Some(vec![reference.at(time, x, column)?]),
            _ => Some(formulas.iter().map(|f| f.eval(&[x, y, z, time])).collect()),
        }
    }

    /// The known components of the stress: those of `stress`, and the exact ones \[Pa\].
    pub(super) fn stress(&self, x: [f64; 3], time: f64, stress: &Matrix3<f64>) -> Option<(Vec<f64>, Vec<f64>)> {
        if let (Some(reference), true) = (&self.reference, self.stress.is_empty()) {
            return Some((vec![stress[(0, 0)]], vec![reference.at(time, x[0], 2)?]));
        }
        let known = self.stress.iter().map(|(c, f)| (stress[place(*c)], f.eval(&[x[0], x[1], x[2], time])));
        Some(known.unzip())
    }
}

fn place(component: StressComponent) -> (usize, usize) {
    match component {
        StressComponent::Xx => (0, 0),
        StressComponent::Yy => (1, 1),
        StressComponent::Zz => (2, 2),
        StressComponent::Yz => (1, 2),
        StressComponent::Xz => (0, 2),
        StressComponent::Xy => (0, 1),
    }
}

/// Displacement, velocity and stress over X at some times.
#[derive(Clone)]
struct Reference {
    times: Vec<Frame>,
}

#[derive(Clone)]
struct Frame {
    time: f64,
    /// X, displacement, velocity, stress, by X.
    rows: Vec<[f64; 4]>,
}

/// Points of the local polynomial through the table: of order 6 where the solution is smooth, and narrow where it is not.
const STENCIL: usize = 6;

impl Reference {
    fn read(file: &str) -> Result<Self, String> {
        let text = std::fs::read_to_string(file).map_err(|e| format!("{file}: cannot be read: {e}"))?;
        let mut times: Vec<Frame> = Vec::new();
        for (number, line) in text.lines().enumerate().skip(1) {
            let numbers: Vec<f64> = line.split(',').map_while(|v| v.trim().parse().ok()).collect();
            let [time, x, u, v, s] = numbers[..] else { return Err(format!("{file}:{}: needs five numbers", number + 1)) };
            match times.last_mut() {
                Some(frame) if frame.time == time => frame.rows.push([x, u, v, s]),
                _ => times.push(Frame { time, rows: vec![[x, u, v, s]] }),
            }
        }
        for frame in &mut times {
            frame.rows.sort_by(|a, b| a[0].total_cmp(&b[0]));
        }
        Ok(Self { times })
    }

    /// Column 0 is displacement, 1 velocity, 2 stress. `None` where the table has no such time.
    fn at(&self, time: f64, x: f64, column: usize) -> Option<f64> {
        let frame = self.times.iter().find(|f| (f.time - time).abs() <= 1e-9 * time.abs().max(1.0))?;
        let rows = &frame.rows;
        let width = STENCIL.min(rows.len());
        let first = rows.partition_point(|r| r[0] <= x).saturating_sub(width / 2).min(rows.len() - width);
        let near = &rows[first..first + width];
        // Lagrange interpolation
        let weight = |i: usize| (0..width).filter(|&j| j != i).map(|j| (x - near[j][0]) / (near[i][0] - near[j][0])).product::<f64>();
        Some((0..width).map(|i| near[i][1 + column] * weight(i)).sum())
    }
}
