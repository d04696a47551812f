//! Convex polyhedra: what half-spaces have in common.

use super::Shape;

/// A half-space: points x with normal . x <= offset. The normal is of length 1.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct HalfSpace {
    /// Name of its face, as [`Shape::faces`] has it.
    pub(crate) face: String,
    pub(crate) normal: [f64; 3],
    /// \[m\]
    pub(crate) offset: f64,
}

/// A half-space with its face, which has an area.
#[derive(Debug, Clone)]
pub(crate) struct Side {
    pub(crate) half_space: HalfSpace,
    /// Corners of the face, one after the other.
    corners: Vec<[f64; 3]>,
}

/// A bounded convex polyhedron; without sides where nothing is in common.
#[derive(Debug, Clone)]
pub(crate) struct Polyhedron {
    pub(crate) sides: Vec<Side>,
}

/// Most half-spaces: all threes of them are looked at.
const MOST: usize = 100;
/// Round-off of corners, over the size of the whole.
const ROUND_OFF: f64 = 1e-11;
/// How many times as far as its planes a polyhedron may reach: beyond, it has no end.
const FAR: f64 = 1e6;

type Vector = [f64; 3];

fn dot(a: &Vector, b: &Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn cross(a: &Vector, b: &Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn minus(a: &Vector, b: &Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn along(a: &Vector, s: f64, d: &Vector) -> Vector {
    [a[0] + s * d[0], a[1] + s * d[1], a[2] + s * d[2]]
}

fn length(a: &Vector) -> f64 {
    dot(a, a).sqrt()
}

impl HalfSpace {
    fn new(face: impl Into<String>, point: &[f64], normal: &[f64]) -> Option<Self> {
        let (point, normal): (Vector, Vector) = (point.try_into().ok()?, normal.try_into().ok()?);
        let unit = normal.map(|n| n / length(&normal));
        let offset = dot(&unit, &point);
        offset.is_finite().then_some(Self { face: face.into(), normal: unit, offset })
    }

    fn distance(&self, x: &Vector) -> f64 {
        dot(&self.normal, x) - self.offset
    }
}

/// The half-spaces of a shape in space that is what they have in common: a half-space, a box, or an intersection of such; at most [`MOST`].
pub(crate) fn half_spaces(shape: &Shape) -> Option<Vec<HalfSpace>> {
    let found = match shape {
        Shape::HalfSpace { point, normal } => vec![HalfSpace::new("plane", point, normal)?],
        Shape::Box { min, max } => {
            let side = |k: usize| {
                let (axis, upper) = (k / 2, k % 2 == 1);
                let mut normal = [0.0; 3];
                normal[axis] = if upper { 1.0 } else { -1.0 };
                let face = format!("{}{}", ["x", "y", "z"][axis], if upper { '+' } else { '-' });
                HalfSpace::new(face, if upper { max } else { min }, &normal)
            };
            (0..6).map(side).collect::<Option<_>>()?
        }
        Shape::Intersection(parts) => {
            let mut all = Vec::new();
            for (number, part) in parts.iter().enumerate() {
                let named = |own: HalfSpace| HalfSpace { face: format!("{}/{}", number + 1, own.face), ..own };
                all.extend(half_spaces(part)?.into_iter().map(named));
            }
            all
        }
        _ => return None,
    };
    (found.len() <= MOST).then_some(found)
}

impl Polyhedron {
    /// What half-spaces have in common; `None` where it has no end.
    pub(crate) fn new(mut half_spaces: Vec<HalfSpace>) -> Option<Self> {
        let size = half_spaces.iter().map(|h| h.offset.abs()).fold(0.0, f64::max);
        let size = if size > 0.0 { size } else { 1.0 };
        let near = ROUND_OFF * size;
        let mut k = 0;
        while k < half_spaces.len() {
            let own = &half_spaces[k];
            let same = |h: &HalfSpace| length(&minus(&h.normal, &own.normal)) < ROUND_OFF && (h.offset - own.offset).abs() < near;
            if half_spaces[..k].iter().any(same) { drop(half_spaces.remove(k)) } else { k += 1 }
        }
        let real = half_spaces.len();
        for axis in 0..6 {
            let mut normal = [0.0; 3];
            normal[axis / 2] = if axis % 2 == 1 { 1.0 } else { -1.0 };
            half_spaces.push(HalfSpace { face: String::new(), normal, offset: FAR * size });
        }
        let mut corners: Vec<Vec<Vector>> = vec![Vec::new(); half_spaces.len()];
        for i in 0..half_spaces.len() {
            for j in i + 1..half_spaces.len() {
                let line = cross(&half_spaces[i].normal, &half_spaces[j].normal);
                for k in j + 1..half_spaces.len() {
                    let determinant = dot(&line, &half_spaces[k].normal);
                    if determinant.abs() < ROUND_OFF {
                        continue;
                    }
                    let [m, n, o] = [i, j, k].map(|h| &half_spaces[h]);
                    let (jk, ki) = (cross(&n.normal, &o.normal), cross(&o.normal, &m.normal));
                    let corner = [0, 1, 2].map(|a| (m.offset * jk[a] + n.offset * ki[a] + o.offset * line[a]) / determinant);
                    if half_spaces.iter().all(|h| h.distance(&corner) <= near) {
                        for of in [i, j, k] {
                            if corners[of].iter().all(|known| length(&minus(known, &corner)) > near) {
                                corners[of].push(corner);
                            }
                        }
                    }
                }
            }
        }
        if corners[real..].iter().any(|corners| !corners.is_empty()) {
            return None;
        }
        let mut sides = Vec::new();
        for (half_space, mut corners) in half_spaces.into_iter().zip(corners) {
            // a plane that touches an edge has no face
            if corners.len() < 3 {
                continue;
            }
            sort_around(&mut corners, &half_space.normal);
            let start = corners[0];
            let fan = corners.windows(2).map(|pair| cross(&minus(&pair[0], &start), &minus(&pair[1], &start)));
            let area = fan.fold([0.0; 3], |sum, part| along(&sum, 0.5, &part));
            if length(&area) > near * near {
                sides.push(Side { half_space, corners });
            }
        }
        // what is flat is nothing
        Some(Self { sides: if sides.len() < 4 { Vec::new() } else { sides } })
    }

    pub(crate) fn corners(&self) -> impl Iterator<Item = &Vector> {
        self.sides.iter().flat_map(|side| &side.corners)
    }

    /// Lower and upper corner of the box around it.
    pub(crate) fn bounds(&self) -> [Vector; 2] {
        let of = |start: f64, f: fn(f64, f64) -> f64| [0, 1, 2].map(|a| self.corners().map(|corner| corner[a]).fold(start, f));
        [of(f64::INFINITY, f64::min), of(f64::NEG_INFINITY, f64::max)]
    }

    /// How far a point is from it; 0 inside \[m\].
    pub(crate) fn distance(&self, x: &Vector) -> f64 {
        if self.sides.iter().all(|side| side.half_space.distance(x) <= 0.0) {
            return 0.0;
        }
        self.sides.iter().map(|side| side.distance(x)).fold(f64::INFINITY, f64::min)
    }

    /// Whether two have no point in common: then a plane along a face of one, or along an edge of each, is between them.
    pub(crate) fn is_apart(&self, other: &Self) -> bool {
        let normals = self.sides.iter().chain(&other.sides).map(|side| side.half_space.normal);
        let edges = self.sides.iter().flat_map(Side::edges);
        let across = edges.flat_map(|[a, b]| other.sides.iter().flat_map(Side::edges).map(move |[c, d]| cross(&minus(b, a), &minus(d, c))));
        normals.chain(across).any(|axis| {
            let range = |of: &Self| {
                let along = of.corners().map(|corner| dot(corner, &axis));
                along.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], s| [low.min(s), high.max(s)])
            };
            let ([low, high], [other_low, other_high]) = (range(self), range(other));
            let slack = ROUND_OFF * (high - low).max(other_high - other_low);
            low > other_high + slack || other_low > high + slack
        })
    }
}

impl Side {
    fn edges(&self) -> impl Iterator<Item = [&Vector; 2]> {
        let n = self.corners.len();
        (0..n).map(move |k| [&self.corners[k], &self.corners[(k + 1) % n]])
    }

    /// How far a point is from the face \[m\].
    fn distance(&self, x: &Vector) -> f64 {
        let normal = &self.half_space.normal;
        let above = self.half_space.distance(x);
        let foot = along(x, -above, normal);
        if self.edges().all(|[a, b]| dot(&cross(&minus(b, a), &minus(&foot, a)), normal) >= 0.0) {
            return above.abs();
        }
        let to_edge = |[a, b]: [&Vector; 2]| {
            let edge = minus(b, a);
            let s = (dot(&minus(x, a), &edge) / dot(&edge, &edge)).clamp(0.0, 1.0);
            length(&minus(x, &along(a, s, &edge)))
        };
        self.edges().map(to_edge).fold(f64::INFINITY, f64::min)
    }
}

/// Puts points of a plane one after the other around their middle, against the clock seen from where the normal points.
fn sort_around(points: &mut [Vector], normal: &Vector) {
    let n = points.len() as f64;
    let middle = [0, 1, 2].map(|a| points.iter().map(|point| point[a]).sum::<f64>() / n);
    let first = minus(&points[0], &middle);
    let second = cross(normal, &first);
    let angle = |point: &Vector| {
        let from = minus(point, &middle);
        dot(&from, &second).atan2(dot(&from, &first))
    };
    points.sort_by(|a, b| angle(a).total_cmp(&angle(b)));
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(shape: &Shape) -> Option<Polyhedron> {
        Polyhedron::new(half_spaces(shape).unwrap())
    }

    fn cube(min: [f64; 3], max: [f64; 3]) -> Shape {
        Shape::Box { min: min.to_vec(), max: max.to_vec() }
    }

    fn behind(point: [f64; 3], normal: [f64; 3]) -> Shape {
        Shape::HalfSpace { point: point.to_vec(), normal: normal.to_vec() }
    }

    #[test]
    fn a_cut_corner_is_a_triangle_and_a_plane_beside_has_no_face() {
        let shape = Shape::Intersection(vec![
            cube([0.0; 3], [1.0, 2.0, 3.0]),
            behind([1.0, 2.0, 2.5], [2.0, 2.0, 2.0]),
            behind([1.0, 0.0, 0.0], [3.0, 0.0, 0.0]),
            behind([5.0, 0.0, 0.0], [1.0, 1.0, 0.0]),
        ]);
        let found = of(&shape).unwrap();
        let names: Vec<(&str, usize)> = found.sides.iter().map(|side| (side.half_space.face.as_str(), side.corners.len())).collect();
        assert_eq!(names, [("1/x-", 4), ("1/x+", 5), ("1/y-", 4), ("1/y+", 5), ("1/z-", 4), ("1/z+", 5), ("2/plane", 3)]);
        assert_eq!(found.bounds(), [[0.0; 3], [1.0, 2.0, 3.0]]);
        // from the cut corner to the plane: 0.5 / sqrt(3)
        assert!((found.distance(&[1.0, 2.0, 3.0]) - 0.5 / 3f64.sqrt()).abs() < 1e-14);
        // from an edge and a face
        assert!((found.distance(&[-1.0, -1.0, 1.0]) - 2f64.sqrt()).abs() < 1e-14 && (found.distance(&[0.5, 5.0, 1.0]) - 3.0).abs() < 1e-14);
        assert_eq!(found.distance(&[0.5; 3]), 0.0);
    }

    #[test]
    fn what_has_no_end_or_is_empty_says_so() {
        assert!(of(&behind([0.0; 3], [0.0, 0.0, 1.0])).is_none());
        // a tube
        let sides = [[1.0, 0.0, 0.1], [-1.0, 0.0, -0.1], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0]];
        assert!(of(&Shape::Intersection(sides.map(|normal| behind([0.0; 3], normal)).to_vec())).is_none());
        // a tetrahedron has an end
        let sides = [[-1.0, 0.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, -1.0]];
        let mut parts = sides.map(|normal| behind([0.0; 3], normal)).to_vec();
        parts.push(behind([1.0, 0.0, 0.0], [1.0, 1.0, 1.0]));
        let found = of(&Shape::Intersection(parts)).unwrap();
        assert_eq!(found.sides.len(), 4);
        assert_eq!(found.bounds()[1].map(|x| (x * 1e9).round()), [1e9; 3]);
        let nothing = Shape::Intersection(vec![cube([0.0; 3], [1.0; 3]), behind([-1.0, 0.0, 0.0], [1.0, 0.0, 0.0])]);
        assert!(of(&nothing).unwrap().sides.is_empty());
    }

    #[test]
    fn boxes_that_only_an_edge_keeps_apart_are_apart() {
        let still = of(&cube([-1.0; 3], [1.0; 3])).unwrap();
        // a box on its edge, that edge turned by a right angle against the nearest one of the cube
        let turned = |off: f64| {
            let (n, m) = ([1.0, 1.0, 0.6], [1.0, 1.0, -0.6]);
            let at = |k: f64| [k, k, 0.0];
            let sides =
                [behind(at(off), n.map(|n| -n)), behind(at(off), m.map(|n| -n)), behind(at(off + 1.0), n), behind(at(off + 1.0), m)];
            let ends = [behind([off, off, 0.0], [1.0, -1.0, 0.0]), behind([off, off, 0.0], [-1.0, 1.0, 0.001])];
            of(&Shape::Intersection(sides.into_iter().chain(ends).collect()))
        };
        for (off, apart) in [(1.01, true), (0.99, false)] {
            if let Some(turned) = turned(off) {
                assert_eq!(still.is_apart(&turned), apart, "{off}");
                assert_eq!(turned.is_apart(&still), apart, "{off}");
            }
        }
        let other = of(&cube([1.5, -1.0, -1.0], [2.0; 3])).unwrap();
        assert!(still.is_apart(&other) && !still.is_apart(&still));
    }
}
