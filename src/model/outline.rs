//! The edge of a plane shape as closed loops of curves, each curve with the face that it belongs to.

use crate::quadrature::Curve;
use crate::scene::Shape;
use std::f64::consts::PI;

/// Places on a curve at which its distance to other loops is looked at.
const LOOKS: u32 = 400;

/// The edge of a plane shape.
#[derive(Debug, Clone)]
pub(crate) struct Outline {
    /// Closed loops, each with the body on its left.
    pub(crate) loops: Vec<Vec<Curve>>,
    /// Name of the face of each curve, as [`Shape::faces`] has it.
    pub(crate) faces: Vec<Vec<String>>,
}

impl Outline {
    /// Of a box, disk, ring or polygon, or one of them with holes that are wholly inside and apart from each other; else why there is none.
    pub(crate) fn new(shape: &Shape) -> Result<Self, &'static str> {
        match shape {
            Shape::Box { min, max } if min.len() == 2 => {
                let corners = [[min[0], min[1]], [max[0], min[1]], [max[0], max[1]], [min[0], max[1]]];
                let side = |k: usize| Curve::Segment(corners[k], corners[(k + 1) % 4]);
                let names = ["y-", "x+", "y+", "x-"].map(str::to_owned);
                Ok(Self { loops: vec![(0..4).map(side).collect()], faces: vec![names.to_vec()] })
            }
            Shape::Disk { center, radius } => Ok(Self { loops: vec![circle(center, *radius)], faces: vec![vec!["outer".to_owned(); 4]] }),
            Shape::Ring { center, inner, outer } => Ok(Self {
                loops: vec![circle(center, *outer), turned(&circle(center, *inner))],
                faces: vec![vec!["outer".to_owned(); 4], vec!["inner".to_owned(); 4]],
            }),
            Shape::Polygon { points } => {
                let n = points.len();
                let corner = |i: usize| [points[i % n][0], points[i % n][1]];
                let edges: Vec<Curve> = (0..n).map(|i| Curve::Segment(corner(i), corner(i + 1))).collect();
                let names: Vec<String> = (1..=n).map(|i| format!("edge{i}")).collect();
                let area: f64 = (0..n).map(|i| corner(i)[0] * corner(i + 1)[1] - corner(i + 1)[0] * corner(i)[1]).sum();
                Ok(if area > 0.0 {
                    Self { loops: vec![edges], faces: vec![names] }
                } else {
                    Self { loops: vec![turned(&edges)], faces: vec![names.into_iter().rev().collect()] }
                })
            }
            Shape::Difference(parts) => Self::with_holes(parts),
            Shape::Union(_) => Err("unions have no outline"),
            Shape::Intersection(_) | Shape::HalfSpace { .. } => Err("intersections and half-spaces have no outline"),
            Shape::Box { .. } | Shape::Sphere { .. } => Err("outlines are for dimension 2"),
        }
    }

    fn with_holes(parts: &[Shape]) -> Result<Self, &'static str> {
        let Some((whole, holes)) = parts.split_first() else { return Err("a difference of nothing has no outline") };
        let mut all = Self::new(whole)?;
        all.name(1);
        for (k, hole) in holes.iter().enumerate() {
            let mut own = Self::new(hole)?;
            let apart = own.loops.iter().flatten().all(|curve| {
                let length = (0..LOOKS).map(|i| curve.at(f64::from(i) / f64::from(LOOKS))[1]).map(|[x, y]| x.hypot(y)).fold(0.0, f64::max);
                // between two looks a curve is less than this from one of them
                let near = length / f64::from(LOOKS);
                (0..LOOKS).all(|i| {
                    let at = curve.at(f64::from(i) / f64::from(LOOKS))[0];
                    let others = holes.iter().enumerate().filter(|(other, _)| *other != k);
                    whole.contains_interior(&at, near) && others.into_iter().all(|(_, other)| !other.contains(&at, near))
                })
            });
            if !apart {
                return Err("a hole of the difference touches its edge or another hole, or is not wholly inside");
            }
            own.name(k + 2);
            all.loops.extend(own.loops.iter().map(|curves| turned(curves)));
            all.faces.extend(own.faces.into_iter().map(|names| names.into_iter().rev().collect()));
        }
        Ok(all)
    }

    /// Names the faces after the part of a composite shape.
    fn name(&mut self, part: usize) {
        self.faces.iter_mut().flatten().for_each(|name| *name = format!("{part}/{name}"));
    }
}

/// Four quarters, against the clock.
fn circle(center: &[f64], radius: f64) -> Vec<Curve> {
    let quarter = |k: u32| Curve::Arc { center: [center[0], center[1]], radius, start: 0.5 * PI * f64::from(k), turn: 0.5 * PI };
    (0..4).map(quarter).collect()
}

/// The same loop the other way round.
fn turned(curves: &[Curve]) -> Vec<Curve> {
    let back = |curve: &Curve| match *curve {
        Curve::Segment(a, b) => Curve::Segment(b, a),
        Curve::Arc { center, radius, start, turn } => Curve::Arc { center, radius, start: start + turn, turn: -turn },
        Curve::Cubic(c) => {
            // by powers of 1 - s
            let of = |f: [f64; 4]| [0, 1].map(|k| f[0] * c[0][k] + f[1] * c[1][k] + f[2] * c[2][k] + f[3] * c[3][k]);
            Curve::Cubic([of([1.0, 1.0, 1.0, 1.0]), of([0.0, -1.0, -2.0, -3.0]), of([0.0, 0.0, 1.0, 3.0]), of([0.0, 0.0, 0.0, -1.0])])
        }
    };
    curves.iter().rev().map(back).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature::gauss_legendre;

    /// Area and length by face.
    fn measure(outline: &Outline) -> (f64, Vec<(String, f64)>) {
        let (mut area, mut lengths) = (0.0, Vec::<(String, f64)>::new());
        for (curves, names) in outline.loops.iter().zip(&outline.faces) {
            for (k, (curve, name)) in curves.iter().zip(names).enumerate() {
                let gap = [0, 1].map(|a| curve.at(1.0)[0][a] - curves[(k + 1) % curves.len()].at(0.0)[0][a]);
                assert!(gap.iter().all(|g| g.abs() < 1e-14), "loops are closed");
                let mut length = 0.0;
                for (s, weight) in gauss_legendre(12) {
                    let [at, slope] = curve.at(s);
                    area += 0.5 * weight * (at[0] * slope[1] - at[1] * slope[0]);
                    length += weight * slope[0].hypot(slope[1]);
                }
                match lengths.iter_mut().find(|(known, _)| known == name) {
                    Some((_, sum)) => *sum += length,
                    None => lengths.push((name.clone(), length)),
                }
            }
        }
        (area, lengths)
    }

    #[test]
    fn outlines_have_area_and_faces_of_their_shapes() {
        let square = Shape::Box { min: vec![-1.0; 2], max: vec![1.0, 2.0] };
        let disk = Shape::Disk { center: vec![0.2, 0.1], radius: 0.5 };
        let ring = Shape::Ring { center: vec![0.0; 2], inner: 0.5, outer: 1.0 };
        let triangle = Shape::Polygon { points: vec![vec![0.0, 0.0], vec![0.0, 1.0], vec![2.0, 0.0]] };
        let plate = Shape::Difference(vec![square.clone(), disk.clone()]);
        let areas = [(&square, 6.0), (&disk, 0.25 * PI), (&ring, 0.75 * PI), (&triangle, 1.0), (&plate, 6.0 - 0.25 * PI)];
        for (shape, exact) in areas {
            let (area, lengths) = measure(&Outline::new(shape).unwrap());
            // round-off
            assert!((area - exact).abs() < 1e-14 * exact.max(1.0) * 10.0, "{shape:?}: {area}");
            for face in shape.faces() {
                let length: f64 = face.points(&[0.01; 2]).iter().map(|p| p.area[0].hypot(p.area[1])).sum();
                let own = lengths.iter().find(|(name, _)| *name == face.name).map_or(0.0, |(_, length)| *length);
                assert!((own - length).abs() < 1e-12, "{} of {shape:?}: {own} {length}", face.name);
            }
            assert_eq!(lengths.len(), shape.faces().len());
        }
    }

    #[test]
    fn holes_that_touch_have_no_outline() {
        let square = Shape::Box { min: vec![-1.0; 2], max: vec![1.0; 2] };
        let disk = |x: f64| Shape::Disk { center: vec![x, 0.0], radius: 0.5 };
        for (holes, good) in [(vec![0.0], true), (vec![0.5], false), (vec![0.7], false), (vec![-0.4, 0.4], false), (vec![3.0], false)] {
            let parts = std::iter::once(square.clone()).chain(holes.iter().map(|x| disk(*x))).collect();
            assert_eq!(Outline::new(&Shape::Difference(parts)).is_ok(), good, "{holes:?}");
        }
        assert!(Outline::new(&Shape::Union(vec![square])).is_err());
    }
}
