//! Smooth pieces of the edge of a plane body.

use std::f64::consts::PI;

/// A piece of an edge, by a parameter from 0 to 1. The body lies to its left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Curve {
    /// From one point straight to another \[m\].
    Segment([f64; 2], [f64; 2]),
    /// Part of a circle: centre, radius \[m\], angle of its start and the angle that it turns by \[rad\], against the clock.
    Arc { center: [f64; 2], radius: f64, start: f64, turn: f64 },
    /// A cubic: coefficients by power of the parameter \[m\].
    Cubic([[f64; 2]; 4]),
}

impl Curve {
    /// Position \[m\] and its derivative by the parameter \[m\].
    pub(crate) fn at(&self, s: f64) -> [[f64; 2]; 2] {
        match self {
            Self::Segment(a, b) => [[0, 1].map(|k| a[k] + s * (b[k] - a[k])), [0, 1].map(|k| b[k] - a[k])],
            Self::Arc { center, radius, start, turn } => {
                let (sin, cos) = (start + s * turn).sin_cos();
                [[center[0] + radius * cos, center[1] + radius * sin], [-radius * turn * sin, radius * turn * cos]]
            }
            Self::Cubic(c) => [
                [0, 1].map(|k| c[0][k] + s * (c[1][k] + s * (c[2][k] + s * c[3][k]))),
                [0, 1].map(|k| c[1][k] + s * (2.0 * c[2][k] + s * 3.0 * c[3][k])),
            ],
        }
    }

    /// Appends the parameters between 0 and 1 where a coordinate turns back.
    pub(super) fn turns(&self, axis: usize, list: &mut Vec<f64>) {
        let mut push = |s: f64| {
            if s > 0.0 && s < 1.0 {
                list.push(s);
            }
        };
        match self {
            Self::Segment(..) => {}
            Self::Arc { start, turn, .. } => {
                // cos turns at multiples of pi, sin in the middle between them
                let shift = if axis == 0 { 0.0 } else { 0.5 };
                let (low, high) = (start.min(start + turn), start.max(start + turn));
                let mut k = (low / PI - shift).ceil();
                while (k + shift) * PI < high {
                    push(((k + shift) * PI - start) / turn);
                    k += 1.0;
                }
            }
            Self::Cubic(c) => {
                let (a, b, c) = (3.0 * c[3][axis], 2.0 * c[2][axis], c[1][axis]);
                let discriminant = b * b - 4.0 * a * c;
                if discriminant > 0.0 {
                    // without cancellation
                    let q = -0.5 * (b + b.signum() * discriminant.sqrt());
                    if a != 0.0 {
                        push(q / a);
                    }
                    if q != 0.0 {
                        push(c / q);
                    }
                }
            }
        }
    }

    /// Where a coordinate has a value, in an interval in which it is monotone and within whose ends it lies: Newton's method, and halving
    /// where that leaves the interval.
    pub(super) fn crossing(&self, axis: usize, value: f64, [mut low, mut high]: [f64; 2]) -> f64 {
        let rising = self.at(high)[0][axis] > self.at(low)[0][axis];
        let mut s = 0.5 * (low + high);
        for _ in 0..60 {
            let [place, slope] = self.at(s);
            let miss = place[axis] - value;
            if miss == 0.0 {
                return s;
            }
            if (miss > 0.0) == rising {
                high = s
            } else {
                low = s
            }
            let newton = s - miss / slope[axis];
            let next = if newton >= low && newton <= high { newton } else { 0.5 * (low + high) };
            if (next - s).abs() <= 1e-15 {
                return next;
            }
            s = next;
        }
        s
    }
}
