//! 4 INPUTS: loads, compiled: what each acts on, and its value in time.

use super::Anchor;
use crate::scene::{self, Formula, PLACES, Results, Tape};
use rayon::prelude::*;

/// A load: what it acts on, and its value in time.
#[derive(Debug, Clone)]
pub(crate) struct Load {
    pub(crate) name: String,
    pub(crate) target: Target,
    pub(crate) signal: Signal,
    /// The side of a body in rows that a traction or pressure acts on, instead of on points: its face is known.
    pub(crate) side: Option<Side>,
}

/// A side of a body in rows: of the square of a sheet (see [`super::Chart`]), or of a box.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Side {
    /// Number of the body.
    pub(crate) body: usize,
    /// Axis across it.
    pub(crate) axis: usize,
    pub(crate) upper: bool,
}

/// What a load acts on.
#[derive(Debug, Clone)]
pub(crate) enum Target {
    /// Acceleration of everything \[m/s2\].
    Gravity,
    /// Acceleration of the particles with these ids \[m/s2\].
    BodyForce(Vec<u32>),
    /// Dead traction \[Pa\] on surface points.
    Traction(Vec<SurfacePoint>),
    /// Follower pressure \[Pa\] on surface points.
    Pressure(Vec<SurfacePoint>),
    /// Force on one particle \[N\].
    PointForce(Anchor),
}

/// A point of a loaded surface: it hangs on a particle and carries a piece of the undeformed area.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SurfacePoint {
    pub(crate) anchor: Anchor,
    /// Outward normal times area at time 0 \[m2\].
    pub(crate) area: [f64; 3],
}

impl Load {
    /// Name of the input variable, after `load/NAME/`.
    pub(crate) fn quantity(&self) -> &'static str {
        match self.target {
            Target::Gravity | Target::BodyForce(_) => "body_force",
            Target::Traction(_) => "traction",
            Target::Pressure(_) => "pressure",
            Target::PointForce(_) => "force",
        }
    }
    /// Number of components.
    pub(crate) fn components(&self, dimension: usize) -> usize {
        if matches!(self.target, Target::Pressure(_)) { 1 } else { dimension }
    }
}

/// A value in time.
#[derive(Debug, Clone)]
pub(crate) enum Signal {
    /// Formulas of x, y, z (position at time 0) and t.
    Formulas {
        components: Vec<Formula>,
        varies_in_space: bool,
        /// The same, for many places.
        tape: Tape,
    },
    /// Linear between rows, constant outside.
    Table(scene::Table),
    /// Set from outside.
    External,
}

/// Variables of the formulas of a load.
pub(crate) const SPACE_TIME: [&str; 4] = ["x", "y", "z", "t"];

/// Places that a thread works on at a time.
const SHARE: usize = 1024;

impl Signal {
    pub(crate) fn new(signal: &scene::Signal) -> Result<Self, String> {
        Ok(match signal {
            scene::Signal::Components(list) => {
                let components = list.iter().map(|e| e.compile(&SPACE_TIME)).collect::<Result<Vec<_>, _>>()?;
                let varies_in_space = components.iter().any(|f| (0..3).any(|v| f.uses(v)));
                let tape = Tape::new(&components, SPACE_TIME.len());
                Self::Formulas { components, varies_in_space, tape }
            }
            scene::Signal::Table(table) => Self::Table(table.clone()),
            scene::Signal::External(_) => Self::External,
        })
    }

    pub(crate) fn varies_in_space(&self) -> bool {
        matches!(self, Self::Formulas { varies_in_space: true, .. })
    }

    /// The value at a place (position at time 0) and time; `input` is what was set from outside.
    pub(crate) fn value(&self, place: [f64; 3], time: f64, input: &[f64]) -> [f64; 3] {
        let mut value = [0.0; 3];
        match self {
            Self::Formulas { components, .. } => {
                let [x, y, z] = place;
                for (v, formula) in value.iter_mut().zip(components) {
                    *v = formula.eval(&[x, y, z, time]);
                }
            }
            Self::Table(table) => {
                // first row after `time`
                let next = table.time.partition_point(|&t| t <= time);
                let last = table.time.len() - 1;
                let (a, b) = (next.saturating_sub(1), next.min(last));
                let share = if a == b { 0.0 } else { (time - table.time[a]) / (table.time[b] - table.time[a]) };
                for (c, v) in value.iter_mut().enumerate().take(table.value[a].len()) {
                    *v = table.value[a][c] + share.clamp(0.0, 1.0) * (table.value[b][c] - table.value[a][c]);
                }
            }
            Self::External => value[..input.len()].copy_from_slice(input),
        }
        value
    }

    /// The values at many places (at time 0), as [`value`](Self::value).
    pub(crate) fn values(&self, places: &[[f64; 3]], time: f64, input: &[f64]) -> Vec<[f64; 3]> {
        let mut values = vec![[0.0; 3]; places.len()];
        let Self::Formulas { components, tape, .. } = self else {
            values.fill(self.value([0.0; 3], time, input));
            return values;
        };
        let each = |(places, values): (&[[f64; 3]], &mut [[f64; 3]])| {
            let mut results = Results::default();
            tape.begin(time, &mut results);
            for (places, values) in places.chunks(PLACES).zip(values.chunks_mut(PLACES)) {
                // a batch that is not full repeats its last place
                let at = |k: usize| places[k.min(places.len() - 1)];
                let variables: [[f64; PLACES]; 3] = std::array::from_fn(|a| std::array::from_fn(|k| at(k)[a]));
                tape.evaluate(&variables, &mut results);
                for c in 0..components.len().min(3) {
                    let output = tape.output(c, &results);
                    values.iter_mut().zip(output).for_each(|(value, output)| value[c] = *output);
                }
            }
        };
        if places.len() > SHARE && rayon::current_num_threads() > 1 {
            places.par_chunks(SHARE).zip(values.par_chunks_mut(SHARE)).for_each(each);
        } else {
            each((places, &mut values));
        }
        values
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_is_linear_between_its_rows_and_constant_outside() {
        let table = scene::Table { time: vec![1.0, 2.0, 4.0], value: vec![vec![0.0, 1.0], vec![10.0, 1.0], vec![0.0, 3.0]] };
        let signal = Signal::Table(table);
        let at = |t: f64| signal.value([0.0; 3], t, &[]);
        assert_eq!(at(0.0), [0.0, 1.0, 0.0]);
        assert_eq!(at(1.5), [5.0, 1.0, 0.0]);
        assert_eq!(at(3.0), [5.0, 2.0, 0.0]);
        assert_eq!(at(9.0), [0.0, 3.0, 0.0]);
    }
}
