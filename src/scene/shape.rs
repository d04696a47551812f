//! Regions of space: what a body fills, where a boundary holds, and the faces that carry tractions.

use super::{Polyhedron, half_spaces};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

/// A region of space. In TOML: `shape = { box = { min = [0, 0], max = [8, 1] } }`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Shape {
    /// An axis-aligned box (an interval in dimension 1).
    Box {
        /// Lower corner \[m\].
        min: Vec<f64>,
        /// Upper corner \[m\].
        max: Vec<f64>,
    },
    /// A disk (dimension 2).
    Disk {
        /// Centre \[m\].
        center: Vec<f64>,
        /// Radius \[m\].
        radius: f64,
    },
    /// A ball (dimension 3).
    Sphere {
        /// Centre \[m\].
        center: Vec<f64>,
        /// Radius \[m\].
        radius: f64,
    },
    /// An annulus (dimension 2).
    Ring {
        /// Centre \[m\].
        center: Vec<f64>,
        /// Inner radius \[m\].
        inner: f64,
        /// Outer radius \[m\].
        outer: f64,
    },
    /// A simple polygon, convex or not (dimension 2).
    Polygon {
        /// Corners in order \[m\], either sense of rotation.
        points: Vec<Vec<f64>>,
    },
    /// All points behind a plane: those with (x - point) . normal <= 0. Its face, as part of a composite shape, is `plane`.
    HalfSpace {
        /// A point of the plane \[m\].
        point: Vec<f64>,
        /// Outward normal, any length.
        normal: Vec<f64>,
    },
    /// All points in one of the parts.
    Union(Vec<Shape>),
    /// The points of the first part that are in none of the others.
    Difference(Vec<Shape>),
    /// The points that are in all parts.
    Intersection(Vec<Shape>),
}

/// A point of a face with its share of the face.
#[derive(Debug, Clone, PartialEq)]
pub struct FacePoint {
    /// Position \[m\], one number an axis.
    pub position: Vec<f64>,
    /// Outward unit normal times area \[m2\] (length in dimension 2, 1 in dimension 1).
    pub area: Vec<f64>,
}

/// A named piece of the surface of a shape.
#[derive(Debug, Clone, PartialEq)]
pub struct Face {
    /// Name as a load gives it.
    pub name: String,
    kind: FaceKind,
}

#[derive(Debug, Clone, PartialEq)]
enum FaceKind {
    /// Side of a box: corner, corner, axis, and whether it is the upper side.
    Side { min: Vec<f64>, max: Vec<f64>, axis: usize, upper: bool },
    /// Circle: centre, radius, +1 where the normal points away from the centre.
    Circle { center: Vec<f64>, radius: f64, sign: f64 },
    /// Sphere: centre, radius.
    Ball { center: Vec<f64>, radius: f64 },
    /// Segment from a to b with outward normal to the right of a -> b.
    Segment { a: Vec<f64>, b: Vec<f64> },
    /// Plane: a point of it and the outward unit normal.
    Plane { point: Vec<f64>, normal: Vec<f64> },
    /// Face of a part of a composite shape: points that are not on the surface of the whole are left out.
    Part { face: Box<FaceKind>, whole: Shape, inverted: bool },
}

const AXES: [char; 3] = ['x', 'y', 'z'];

impl Shape {
    /// Whether `x` lies in the region; its surface belongs to it. `slack` \[m\] widens the region.
    pub fn contains(&self, x: &[f64], slack: f64) -> bool {
        match self {
            Self::Box { min, max } => (0..x.len()).all(|a| x[a] >= min[a] - slack && x[a] <= max[a] + slack),
            Self::Disk { center, radius } | Self::Sphere { center, radius } => distance(x, center) <= radius + slack,
            Self::Ring { center, inner, outer } => {
                let r = distance(x, center);
                r >= inner - slack && r <= outer + slack
            }
            Self::Polygon { points } => inside_polygon(x, points) || (slack > 0.0 && near_polygon(x, points, slack)),
            Self::HalfSpace { point, normal } => {
                let length = norm(normal);
                (0..x.len()).map(|a| (x[a] - point[a]) * normal[a]).sum::<f64>() <= slack * length
            }
            Self::Union(parts) => parts.iter().any(|part| part.contains(x, slack)),
            Self::Intersection(parts) => parts.iter().all(|part| part.contains(x, slack)),
            // The surface of a hole belongs to the body, so the hole shrinks where the body grows.
            Self::Difference(parts) => match parts.split_first() {
                Some((first, holes)) => first.contains(x, slack) && !holes.iter().any(|hole| hole.contains_interior(x, slack)),
                None => false,
            },
        }
    }

    /// Whether `x` lies in the interior by more than `slack`.
    pub(crate) fn contains_interior(&self, x: &[f64], slack: f64) -> bool {
        match self {
            Self::Ring { center, inner, outer } => {
                let r = distance(x, center);
                r > inner + slack && r < outer - slack
            }
            Self::Polygon { points } => inside_polygon(x, points) && !near_polygon(x, points, slack.max(f64::MIN_POSITIVE)),
            Self::Box { min, max } => (0..x.len()).all(|a| x[a] > min[a] + slack && x[a] < max[a] - slack),
            Self::Disk { center, radius } | Self::Sphere { center, radius } => distance(x, center) < radius - slack,
            Self::HalfSpace { point, normal } => (0..x.len()).map(|a| (x[a] - point[a]) * normal[a]).sum::<f64>() < -slack * norm(normal),
            Self::Union(parts) => parts.iter().any(|part| part.contains_interior(x, slack)),
            Self::Intersection(parts) => parts.iter().all(|part| part.contains_interior(x, slack)),
            Self::Difference(parts) => match parts.split_first() {
                Some((first, holes)) => first.contains_interior(x, slack) && !holes.iter().any(|hole| hole.contains(x, slack)),
                None => false,
            },
        }
    }

    /// Smallest box around the region: lower and upper corner, infinite for a half-space.
    pub fn bounds(&self, dimension: usize) -> (Vec<f64>, Vec<f64>) {
        let all = (vec![f64::NEG_INFINITY; dimension], vec![f64::INFINITY; dimension]);
        let none = (vec![f64::INFINITY; dimension], vec![f64::NEG_INFINITY; dimension]);
        let around = |c: &[f64], r: f64| (c.iter().map(|v| v - r).collect(), c.iter().map(|v| v + r).collect());
        match self {
            Self::Box { min, max } => (min.clone(), max.clone()),
            Self::Disk { center, radius } | Self::Sphere { center, radius } => around(center, *radius),
            Self::Ring { center, outer, .. } => around(center, *outer),
            Self::Polygon { points } => points.iter().fold(none, |(lo, hi), p| (zip(&lo, p, f64::min), zip(&hi, p, f64::max))),
            Self::HalfSpace { point, normal } => {
                let (mut lo, mut hi) = all;
                // Only a half-space along an axis bounds a coordinate.
                let along: Vec<usize> = (0..dimension).filter(|&a| normal[a] != 0.0).collect();
                if let [axis] = along[..] {
                    if normal[axis] > 0.0 { hi[axis] = point[axis] } else { lo[axis] = point[axis] }
                }
                (lo, hi)
            }
            Self::Union(parts) => {
                parts.iter().map(|p| p.bounds(dimension)).fold(none, |(lo, hi), (l, h)| (zip(&lo, &l, f64::min), zip(&hi, &h, f64::max)))
            }
            Self::Intersection(_)
                if dimension == 3
                    && let Some([low, high]) = self.bounds_of_polyhedron() =>
            {
                (low.to_vec(), high.to_vec())
            }
            Self::Intersection(parts) => {
                parts.iter().map(|p| p.bounds(dimension)).fold(all, |(lo, hi), (l, h)| (zip(&lo, &l, f64::max), zip(&hi, &h, f64::min)))
            }
            Self::Difference(parts) => parts.first().map_or(none, |p| p.bounds(dimension)),
        }
    }

    /// Of boxes and half-spaces in space that intersect: planes askew bound it, too. `None` where it has no end.
    fn bounds_of_polyhedron(&self) -> Option<[[f64; 3]; 2]> {
        Some(Polyhedron::new(half_spaces(self)?)?.bounds())
    }

    /// The named faces of the region, for tractions.
    pub fn faces(&self) -> Vec<Face> {
        let face = |name: String, kind| Face { name, kind };
        match self {
            Self::Box { min, max } => (0..min.len())
                .flat_map(|axis| [false, true].map(|upper| (axis, upper)))
                .map(|(axis, upper)| {
                    face(
                        format!("{}{}", AXES[axis.min(2)], if upper { '+' } else { '-' }),
                        FaceKind::Side { min: min.clone(), max: max.clone(), axis, upper },
                    )
                })
                .collect(),
            Self::Disk { center, radius } => {
                vec![face("outer".into(), FaceKind::Circle { center: center.clone(), radius: *radius, sign: 1.0 })]
            }
            Self::Sphere { center, radius } => vec![face("outer".into(), FaceKind::Ball { center: center.clone(), radius: *radius })],
            Self::Ring { center, inner, outer } => vec![
                face("inner".into(), FaceKind::Circle { center: center.clone(), radius: *inner, sign: -1.0 }),
                face("outer".into(), FaceKind::Circle { center: center.clone(), radius: *outer, sign: 1.0 }),
            ],
            Self::Polygon { points } => {
                let counter_clockwise = signed_area(points) > 0.0;
                (0..points.len())
                    .map(|i| {
                        let (a, b) = (points[i].clone(), points[(i + 1) % points.len()].clone());
                        let (a, b) = if counter_clockwise { (a, b) } else { (b, a) };
                        face(format!("edge{}", i + 1), FaceKind::Segment { a, b })
                    })
                    .collect()
            }
            // A plane has no end; its face is what the rest of a composite shape leaves of it.
            Self::HalfSpace { point, normal } => {
                let length = norm(normal);
                vec![face("plane".into(), FaceKind::Plane { point: point.clone(), normal: normal.iter().map(|n| n / length).collect() })]
            }
            Self::Union(parts) | Self::Intersection(parts) | Self::Difference(parts) => {
                let subtracts = matches!(self, Self::Difference(_));
                parts
                    .iter()
                    .enumerate()
                    .flat_map(|(i, part)| part.faces().into_iter().map(move |f| (i, f)))
                    .map(|(i, f)| {
                        face(
                            format!("{}/{}", i + 1, f.name),
                            FaceKind::Part { face: Box::new(f.kind), whole: self.clone(), inverted: subtracts && i > 0 },
                        )
                    })
                    .collect()
            }
        }
    }
}

impl Face {
    /// Points that cover the face, about `spacing` \[m, one an axis\] apart, each with its exact share of the area (of a sphere: by
    /// equal angles, exact in sum). None of a plane that is not part of a bounded shape.
    pub fn points(&self, spacing: &[f64]) -> Vec<FacePoint> {
        self.kind.points(spacing, None)
    }
}

impl FaceKind {
    /// `room` are the lower and upper corner of the shape that it is a face of.
    fn points(&self, spacings: &[f64], room: Option<&(Vec<f64>, Vec<f64>)>) -> Vec<FacePoint> {
        let spacing = spacings.iter().copied().fold(f64::INFINITY, f64::min);
        match self {
            Self::Side { min, max, axis, upper } => side_points(min, max, *axis, *upper, spacings),
            Self::Circle { center, radius, sign } => {
                // a multiple of four, so that the points are as symmetric as the circle and the grid
                let n = ((2.0 * PI * radius / spacing).ceil() as usize).clamp(8, 1_000_000).next_multiple_of(4);
                let share = 2.0 * PI * radius / n as f64;
                (0..n)
                    .map(|i| {
                        let (s, c) = (2.0 * PI * (i as f64 + 0.5) / n as f64).sin_cos();
                        FacePoint {
                            position: vec![center[0] + radius * c, center[1] + radius * s],
                            area: vec![sign * share * c, sign * share * s],
                        }
                    })
                    .collect()
            }
            Self::Ball { center, radius } => ball_points(center, *radius, spacing),
            Self::Segment { a, b } => {
                let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
                let n = ((dx.hypot(dy) / spacing).ceil() as usize).clamp(1, 1_000_000);
                (0..n)
                    .map(|i| {
                        let s = (i as f64 + 0.5) / n as f64;
                        FacePoint { position: vec![a[0] + s * dx, a[1] + s * dy], area: vec![dy / n as f64, -dx / n as f64] }
                    })
                    .collect()
            }
            Self::Plane { point, normal } => room.map_or_else(Vec::new, |room| plane_points(point, normal, room, spacing)),
            Self::Part { face, whole, inverted } => face
                .points(spacings, room.or(bounded(whole, spacings.len()).as_ref()))
                .into_iter()
                .map(|p| if *inverted { FacePoint { area: p.area.iter().map(|v| -v).collect(), ..p } } else { p })
                .filter(|p| {
                    let step = 1e-6 * spacing / norm(&p.area);
                    let at = |s: f64| zip(&p.position, &p.area, |x, n| x + s * step * n);
                    whole.contains(&at(-1.0), 0.0) && !whole.contains(&at(1.0), 0.0)
                })
                .collect(),
        }
    }
}

/// The bounds of a shape, if it has an end.
fn bounded(shape: &Shape, dimension: usize) -> Option<(Vec<f64>, Vec<f64>)> {
    Some(shape.bounds(dimension)).filter(|(low, high)| low.iter().chain(high).all(|x| x.is_finite()))
}

/// Points of a plane in rows and columns as far as a box reaches.
fn plane_points(point: &[f64], normal: &[f64], (low, high): &(Vec<f64>, Vec<f64>), spacing: f64) -> Vec<FacePoint> {
    let middle = zip(low, high, |l, h| 0.5 * (l + h));
    let above: f64 = (0..normal.len()).map(|a| (middle[a] - point[a]) * normal[a]).sum();
    let foot = zip(&middle, normal, |x, n| x - above * n);
    let reach = 0.5 * distance(low, high);
    // directions in the plane
    let directions: Vec<Vec<f64>> = match normal {
        [x, y] => vec![vec![-y, *x]],
        [x, y, z] => {
            // across the axis that is farthest from the normal
            let most = [x, y, z].iter().map(|n| n.abs()).fold(f64::INFINITY, f64::min);
            let axis = [x, y, z].iter().position(|n| n.abs() == most).unwrap_or(0);
            let mut u: Vec<f64> = (0..3).map(|a| f64::from(u8::from(a == axis)) - normal[axis] * normal[a]).collect();
            let length = norm(&u);
            u.iter_mut().for_each(|v| *v /= length);
            let v = vec![y * u[2] - z * u[1], z * u[0] - x * u[2], x * u[1] - y * u[0]];
            vec![u, v]
        }
        _ => Vec::new(),
    };
    let n = ((2.0 * reach / spacing).ceil() as usize).clamp(1, 1000);
    let mut points = vec![foot];
    for direction in &directions {
        let along = |k: usize| reach * ((2 * k + 1) as f64 / n as f64 - 1.0);
        let widen = |from: &Vec<f64>| (0..n).map(|k| zip(from, direction, |x, d| x + along(k) * d)).collect::<Vec<_>>();
        points = points.iter().flat_map(widen).collect();
    }
    let share = (2.0 * reach / n as f64).powi(directions.len() as i32);
    points.into_iter().map(|position| FacePoint { position, area: normal.iter().map(|n| share * n).collect() }).collect()
}

fn side_points(min: &[f64], max: &[f64], axis: usize, upper: bool, spacing: &[f64]) -> Vec<FacePoint> {
    let others: Vec<usize> = (0..min.len()).filter(|&a| a != axis).collect();
    let counts: Vec<usize> = others.iter().map(|&a| (((max[a] - min[a]) / spacing[a] - 1e-9).ceil() as usize).max(1)).collect();
    let share: f64 = others.iter().zip(&counts).map(|(&a, &n)| (max[a] - min[a]) / n as f64).product();
    let total: usize = counts.iter().product();
    (0..total)
        .map(|flat| {
            let mut position = vec![if upper { max[axis] } else { min[axis] }; min.len()];
            let mut rest = flat;
            for (&a, &n) in others.iter().zip(&counts) {
                position[a] = min[a] + (max[a] - min[a]) * ((rest % n) as f64 + 0.5) / n as f64;
                rest /= n;
            }
            let mut area = vec![0.0; min.len()];
            area[axis] = if upper { share } else { -share };
            FacePoint { position, area }
        })
        .collect()
}

fn ball_points(center: &[f64], radius: f64, spacing: f64) -> Vec<FacePoint> {
    let rings = ((PI * radius / spacing).ceil() as usize).clamp(4, 2_000).next_multiple_of(2);
    let mut points = Vec::new();
    for i in 0..rings {
        let (low, high) = (PI * i as f64 / rings as f64, PI * (i + 1) as f64 / rings as f64);
        let polar = 0.5 * (low + high);
        let band = 2.0 * PI * radius * radius * (low.cos() - high.cos());
        let n = ((2.0 * PI * radius * polar.sin() / spacing).ceil() as usize).clamp(4, 4_000).next_multiple_of(4);
        for j in 0..n {
            let azimuth = 2.0 * PI * (j as f64 + 0.5) / n as f64;
            let normal = [polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos()];
            points.push(FacePoint {
                position: (0..3).map(|a| center[a] + radius * normal[a]).collect(),
                area: normal.iter().map(|v| v * band / n as f64).collect(),
            });
        }
    }
    points
}

fn zip(a: &[f64], b: &[f64], f: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    a.iter().zip(b).map(|(&x, &y)| f(x, y)).collect()
}

fn norm(a: &[f64]) -> f64 {
    a.iter().map(|v| v * v).sum::<f64>().sqrt()
}

fn distance(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| (x - y) * (x - y)).sum::<f64>().sqrt()
}

fn signed_area(points: &[Vec<f64>]) -> f64 {
    let n = points.len();
    0.5 * (0..n).map(|i| points[i][0] * points[(i + 1) % n][1] - points[(i + 1) % n][0] * points[i][1]).sum::<f64>()
}

/// Even-odd rule.
fn inside_polygon(x: &[f64], points: &[Vec<f64>]) -> bool {
    let n = points.len();
    let crosses = |i: usize| {
        let (a, b) = (&points[i], &points[(i + 1) % n]);
        (a[1] > x[1]) != (b[1] > x[1]) && x[0] < a[0] + (x[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0])
    };
    (0..n).filter(|&i| crosses(i)).count() % 2 == 1
}

fn near_polygon(x: &[f64], points: &[Vec<f64>], slack: f64) -> bool {
    let n = points.len();
    (0..n).any(|i| {
        let (a, b) = (&points[i], &points[(i + 1) % n]);
        let (d, r) = ([b[0] - a[0], b[1] - a[1]], [x[0] - a[0], x[1] - a[1]]);
        let s = ((d[0] * r[0] + d[1] * r[1]) / (d[0] * d[0] + d[1] * d[1])).clamp(0.0, 1.0);
        (r[0] - s * d[0]).hypot(r[1] - s * d[1]) <= slack
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(min: f64, max: f64) -> Shape {
        Shape::Box { min: vec![min; 2], max: vec![max; 2] }
    }

    #[test]
    fn closed_surfaces_have_no_net_area_and_the_right_total() {
        let ring = Shape::Ring { center: vec![1.0, 2.0], inner: 0.5, outer: 1.0 };
        let ball = Shape::Sphere { center: vec![0.0; 3], radius: 2.0 };
        let triangle = Shape::Polygon { points: vec![vec![0.0, 0.0], vec![0.0, 1.0], vec![1.0, 0.0]] };
        let totals = [(square(0.0, 2.0), 8.0), (ring, 3.0 * PI), (ball, 16.0 * PI), (triangle, 2.0 + 2f64.sqrt())];
        for (shape, area) in totals {
            let points: Vec<FacePoint> = shape.faces().iter().flat_map(|f| f.points(&[0.1; 3])).collect();
            let sum: f64 = points.iter().map(|p| norm(&p.area)).sum();
            // round-off of some thousand additions
            assert!((sum - area).abs() < 1e-11 * area, "{shape:?}: {sum} is not {area}");
            for axis in 0..points[0].area.len() {
                assert!(points.iter().map(|p| p.area[axis]).sum::<f64>().abs() < 1e-11 * area);
            }
            // the normal points outwards
            for p in &points {
                let out = zip(&p.position, &p.area, |x, n| x + 1e-3 * n / norm(&p.area));
                assert!(!shape.contains(&out, 0.0), "{shape:?}");
            }
        }
    }

    #[test]
    fn hole_of_a_difference_faces_into_the_hole() {
        let plate = Shape::Difference(vec![square(-1.0, 1.0), Shape::Disk { center: vec![0.0; 2], radius: 0.5 }]);
        assert!(plate.contains(&[0.7, 0.0], 0.0) && !plate.contains(&[0.3, 0.0], 0.0));
        let faces = plate.faces();
        let hole = faces.iter().find(|f| f.name == "2/outer").expect("named after its part");
        for p in hole.points(&[0.1; 2]) {
            assert!(p.position[0] * p.area[0] + p.position[1] * p.area[1] < 0.0);
        }
    }
}
