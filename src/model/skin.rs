//! The surface of a shape in space, piece by piece, each with the face that it belongs to: the counterpart of [`super::outline`].

use crate::quadrature::{Bound, Solid};
use crate::scene::{Polyhedron, Shape, half_spaces};

/// The surface of a shape in space.
#[derive(Debug, Clone)]
pub(super) struct Skin {
    pub(super) solid: Solid,
    /// Name of the face of each bound, as [`Shape::faces`] has it.
    pub(super) faces: Vec<Vec<String>>,
    parts: Vec<Convex>,
}

#[derive(Debug, Clone)]
enum Convex {
    Ball([f64; 3], f64),
    Polyhedron(Polyhedron),
}

impl Skin {
    /// Of a sphere, or of boxes and half-spaces that intersect, or one of them with such holes that are wholly inside and apart from each other;
    /// else why there is none.
    pub(super) fn new(shape: &Shape) -> Result<Self, &'static str> {
        if let Shape::Difference(parts) = shape {
            return Self::with_holes(parts);
        }
        let convex = Convex::new(shape)?;
        let (bounds, faces) = convex.bounds();
        Ok(Self { solid: Solid { parts: vec![bounds] }, faces: vec![faces], parts: vec![convex] })
    }

    fn with_holes(parts: &[Shape]) -> Result<Self, &'static str> {
        let Some((whole, holes)) = parts.split_first() else { return Err("a difference of nothing has no outline") };
        let mut all = Self::new(whole)?;
        all.faces.iter_mut().flatten().for_each(|name| *name = format!("1/{name}"));
        for (k, hole) in holes.iter().enumerate() {
            let hole = Convex::new(hole)?;
            if !all.parts[0].holds(&hole) || !all.parts[1..].iter().all(|other| other.is_apart(&hole)) {
                return Err("a hole of the difference touches its surface or another hole, or is not wholly inside");
            }
            let (bounds, faces) = hole.bounds();
            all.solid.parts.push(bounds);
            all.faces.push(faces.iter().map(|name| format!("{}/{name}", k + 2)).collect());
            all.parts.push(hole);
        }
        Ok(all)
    }
}

impl Convex {
    fn new(shape: &Shape) -> Result<Self, &'static str> {
        match shape {
            Shape::Sphere { center, radius } => match center[..] {
                [x, y, z] => Ok(Self::Ball([x, y, z], *radius)),
                _ => Err("a sphere is for dimension 3"),
            },
            Shape::Union(_) => Err("unions have no outline"),
            Shape::Difference(_) => Err("a hole that has a hole has no outline"),
            _ => {
                let half_spaces = half_spaces(shape)
                    .ok_or("an intersection has an outline where its parts are boxes and half-spaces, of up to 100 planes")?;
                let polyhedron = Polyhedron::new(half_spaces).ok_or("what half-spaces have in common has no end")?;
                Ok(Self::Polyhedron(polyhedron))
            }
        }
    }

    fn bounds(&self) -> (Vec<Bound>, Vec<String>) {
        match self {
            Self::Ball(center, radius) => (vec![Bound::Sphere { center: *center, radius: *radius }], vec!["outer".to_owned()]),
            Self::Polyhedron(polyhedron) => {
                let sides = polyhedron.sides.iter().map(|side| &side.half_space);
                sides.map(|h| (Bound::Plane { normal: h.normal, offset: h.offset }, h.face.clone())).unzip()
            }
        }
    }

    /// Whether another is wholly in its interior.
    fn holds(&self, other: &Self) -> bool {
        let distance = |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt();
        match (self, other) {
            (Self::Ball(center, radius), Self::Ball(of, own)) => distance(center, of) + own < *radius,
            (Self::Ball(center, radius), Self::Polyhedron(inner)) => inner.corners().all(|corner| distance(center, corner) < *radius),
            (Self::Polyhedron(_), _) => self.bounds().0.iter().all(|bound| match other {
                Self::Ball(of, own) => bound.distance(of) + own < 0.0,
                Self::Polyhedron(inner) => inner.corners().all(|corner| bound.distance(corner) < 0.0),
            }),
        }
    }

    /// Whether two have no point in common.
    fn is_apart(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Ball(a, radius), Self::Ball(b, own)) => (0..3).map(|k| (a[k] - b[k]).powi(2)).sum::<f64>().sqrt() > radius + own,
            (Self::Ball(center, radius), Self::Polyhedron(flat)) | (Self::Polyhedron(flat), Self::Ball(center, radius)) => {
                flat.distance(center) > *radius
            }
            (Self::Polyhedron(a), Self::Polyhedron(b)) => a.is_apart(b),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cube(low: f64, high: f64) -> Shape {
        Shape::Box { min: vec![low; 3], max: vec![high; 3] }
    }

    fn ball(x: f64, radius: f64) -> Shape {
        Shape::Sphere { center: vec![x, 0.0, 0.0], radius }
    }

    #[test]
    fn holes_must_be_inside_and_apart() {
        let corner = Shape::HalfSpace { point: vec![0.5; 3], normal: vec![1.0; 3] };
        let cut = Shape::Intersection(vec![cube(-1.0, 1.0), corner.clone()]);
        let cases = [
            (vec![cube(-1.0, 1.0), ball(0.0, 0.5)], true),
            (vec![cube(-1.0, 1.0), ball(0.5, 0.5)], false),
            (vec![cube(-1.0, 1.0), ball(-0.5, 0.4), ball(0.5, 0.4)], true),
            (vec![cube(-1.0, 1.0), ball(-0.3, 0.4), ball(0.3, 0.4)], false),
            (vec![cube(-1.0, 1.0), ball(3.0, 0.4)], false),
            (vec![ball(0.0, 1.0), cube(-0.5, 0.5)], true),
            (vec![ball(0.0, 1.0), cube(-0.6, 0.6)], false),
            (vec![ball(0.0, 1.0), cube(-0.1, 0.1), ball(0.5, 0.35)], true),
            (vec![ball(0.0, 1.0), cube(-0.1, 0.1), ball(0.5, 0.45)], false),
            (vec![cut.clone(), ball(0.0, 0.8)], true),
            // the plane is 0.866 from the origin
            (vec![cut, ball(0.0, 0.87)], false),
            (vec![ball(0.0, 1.0), ball(0.5, 0.5)], false),
        ];
        for (parts, good) in cases {
            assert_eq!(Skin::new(&Shape::Difference(parts.clone())).is_ok(), good, "{parts:?}");
        }
        assert!(Skin::new(&Shape::Union(vec![cube(0.0, 1.0)])).is_err());
        assert!(Skin::new(&Shape::Intersection(vec![cube(0.0, 1.0), ball(0.0, 0.5)])).is_err());
        assert!(Skin::new(&corner).is_err());
    }

    #[test]
    fn faces_are_named_as_those_of_the_shape() {
        let shape = Shape::Difference(vec![
            Shape::Intersection(vec![cube(-1.0, 1.0), Shape::HalfSpace { point: vec![0.5; 3], normal: vec![1.0; 3] }]),
            ball(-0.5, 0.2),
            cube(0.1, 0.3),
        ]);
        let skin = Skin::new(&shape).unwrap();
        let mut names: Vec<String> = skin.faces.into_iter().flatten().collect();
        let mut known: Vec<String> = shape.faces().into_iter().map(|face| face.name).collect();
        names.sort();
        known.sort();
        assert_eq!(names, known);
    }
}
