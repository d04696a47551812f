//! Smooth surfaces that bound a body in space.

/// A surface, and the side of it that is inside.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Bound {
    /// Points x with normal . x <= offset; the normal is of length 1, the offset in \[m\].
    Plane { normal: [f64; 3], offset: f64 },
    /// A ball \[m\].
    Sphere { center: [f64; 3], radius: f64 },
}

/// Sine of the angle below which surfaces count as parallel.
const PARALLEL: f64 = 1e-14;

pub(super) fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross(a: &[f64; 3], b: &[f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

impl Bound {
    /// The plane across an axis at a place; its lower side is inside.
    pub(super) fn across(axis: usize, place: f64) -> Self {
        let mut normal = [0.0; 3];
        normal[axis] = 1.0;
        Self::Plane { normal, offset: place }
    }

    /// Distance from the surface, negative inside \[m\].
    pub(crate) fn distance(&self, x: &[f64; 3]) -> f64 {
        match self {
            Self::Plane { normal, offset } => dot(normal, x) - offset,
            Self::Sphere { center, radius } => (0..3).map(|a| (x[a] - center[a]).powi(2)).sum::<f64>().sqrt() - radius,
        }
    }

    /// Least and largest distance in a box.
    pub(super) fn range(&self, low: &[f64; 3], high: &[f64; 3]) -> [f64; 2] {
        match self {
            Self::Plane { normal, offset } => {
                let least = |n: f64, low: f64, high: f64| if n > 0.0 { n * low } else { n * high };
                let [below, above] = [[low, high], [high, low]].map(|[l, h]| (0..3).map(|a| least(normal[a], l[a], h[a])).sum::<f64>());
                [below - offset, above - offset]
            }
            Self::Sphere { center, radius } => {
                let far: [[f64; 2]; 3] = std::array::from_fn(|a| reach(center[a], low[a], high[a]));
                [0, 1].map(|k| far.iter().map(|reach| reach[k] * reach[k]).sum::<f64>().sqrt() - radius)
            }
        }
    }

    /// Outward normal at a point of it.
    pub(super) fn normal(&self, x: &[f64; 3]) -> [f64; 3] {
        match self {
            Self::Plane { normal, .. } => *normal,
            Self::Sphere { center, radius } => std::array::from_fn(|a| (x[a] - center[a]) / radius),
        }
    }

    /// Calls `f` where it crosses a line along an axis, with the coordinate there.
    pub(super) fn roots(&self, line: &[f64; 3], axis: usize, mut f: impl FnMut(f64)) {
        match self {
            Self::Plane { normal, offset } => {
                if normal[axis].abs() > PARALLEL {
                    let others: f64 = (0..3).filter(|a| *a != axis).map(|a| normal[a] * line[a]).sum();
                    f((offset - others) / normal[axis]);
                }
            }
            Self::Sphere { center, radius } => {
                let others: f64 = (0..3).filter(|a| *a != axis).map(|a| (line[a] - center[a]).powi(2)).sum();
                let square = radius * radius - others;
                if square > 0.0 {
                    f(center[axis] - square.sqrt());
                    f(center[axis] + square.sqrt());
                }
            }
        }
    }
}

/// Least and largest distance of an interval from a point.
pub(super) fn reach(center: f64, low: f64, high: f64) -> [f64; 2] {
    [(low - center).max(center - high).max(0.0), (center - low).max(high - center)]
}

/// Calls `f` with the points that three surfaces have in common; with none where two of them are spheres or two planes are parallel.
pub(super) fn meet(bounds: [&Bound; 3], mut f: impl FnMut([f64; 3])) {
    let planes = bounds.iter().filter_map(|bound| if let Bound::Plane { normal, offset } = bound { Some((normal, *offset)) } else { None });
    let mut planes = planes.take(3);
    let (Some((m, o)), Some((n, q))) = (planes.next(), planes.next()) else { return };
    let along = cross(m, n);
    let square = dot(&along, &along);
    if square < PARALLEL * PARALLEL {
        return;
    }
    // the point of the line that is nearest to the origin
    let (a, b) = (cross(n, &along), cross(&along, m));
    let start: [f64; 3] = std::array::from_fn(|k| (o * a[k] + q * b[k]) / square);
    let at = |s: f64| std::array::from_fn(|k| start[k] + s * along[k]);
    if let Some((normal, offset)) = planes.next() {
        let slope = dot(normal, &along);
        if slope.abs() > PARALLEL {
            f(at((offset - dot(normal, &start)) / slope));
        }
        return;
    }
    for bound in bounds {
        if let Bound::Sphere { center, radius } = bound {
            let from: [f64; 3] = std::array::from_fn(|k| start[k] - center[k]);
            // along^2 s^2 + 2 b s + c = 0
            let (b, c) = (dot(&along, &from), dot(&from, &from) - radius * radius);
            let discriminant = b * b - square * c;
            if discriminant > 0.0 {
                let root = discriminant.sqrt();
                f(at((-b - root) / square));
                f(at((-b + root) / square));
            }
        }
    }
}
