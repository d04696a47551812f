//! What is well-formed but makes no sense. Every fault is found at once; [`parse`](super::parse) gives them their places.

mod action;
mod exact;
mod method;
mod region;

use super::fault::{counted, hint, plain, short};
use super::{Body, Expr, Fault, OneOrEach, Plane, Positions, Scene, Shape};
use region::Cells;

/// Most cells along an axis.
const MOST_CELLS: f64 = (1u64 << 28) as f64;
/// Most particles of a body.
const MOST_PARTICLES: f64 = (1u64 << 27) as f64;
/// About what a particle takes \[bytes\].
const BYTES_A_PARTICLE: f64 = 300.0;
/// Most positions that are tried to find out whether a body holds a particle.
const MOST_TRIED: f64 = 4e6;
/// Most steps of a run.
const MOST_STEPS: f64 = 1e12;
/// Most records of a run.
const MOST_RECORDS: f64 = 1e7;

/// The axes by number.
const AXES: [&str; 3] = ["x", "y", "z"];
/// What the formulas of an initial velocity may use.
const SPACE: [&str; 3] = AXES;
/// What formulas of time may use.
const TIME: [&str; 1] = ["t"];
/// What formulas of space and time may use.
const SPACE_TIME: [&str; 4] = ["x", "y", "z", "t"];

/// Every fault of a scene; none where it can be simulated.
pub fn check(scene: &Scene) -> Vec<Fault> {
    let mut check = Check { scene, dimension: scene.dimension, cells: None, faults: Vec::new() };
    check.materials();
    check.counts();
    check.method();
    check.time();
    check.record();
    check.names();
    // Without a dimension there is no telling how many components anything must have.
    if (1..=3).contains(&scene.dimension) {
        check.plane();
        check.cells = check.grid();
        check.method_on_grid();
        check.bodies();
        check.boundaries();
        check.loads();
        check.probes();
        check.exact();
    } else {
        check.fault("dimension", format!("is {}; must be 1, 2 or 3", scene.dimension));
    }
    check.faults
}

/// What can be simulated but is seldom wise, with the reason.
pub fn warnings(scene: &Scene) -> Vec<Fault> {
    method::warnings(scene)
}

struct Check<'a> {
    scene: &'a Scene,
    dimension: usize,
    /// The grid, once it is known to make sense.
    cells: Option<Cells>,
    faults: Vec<Fault>,
}

impl<'a> Check<'a> {
    fn fault(&mut self, path: &str, message: impl Into<String>) {
        self.faults.push(Fault::new(path, message));
    }

    /// A fault unless `right`; returns `right`.
    fn require(&mut self, right: bool, path: &str, message: impl FnOnce() -> String) -> bool {
        if !right {
            self.fault(path, message());
        }
        right
    }

    /// A fault unless `value` is above zero and finite.
    fn positive(&mut self, path: &str, value: f64) -> bool {
        let wanted = if value == f64::INFINITY { "above 0 and finite" } else { "above 0" };
        self.require(value > 0.0 && value.is_finite(), path, || format!("is {}; must be {wanted}", plain(value)))
    }

    /// A fault unless there is one finite component an axis.
    fn vector(&mut self, path: &str, vector: &[f64]) -> bool {
        self.components(path, vector.len(), self.dimension) && self.finite(path, vector)
    }

    fn components(&mut self, path: &str, found: usize, wanted: usize) -> bool {
        let dimension = self.dimension;
        self.require(found == wanted, path, || format!("has {}; must have {wanted} in dimension {dimension}", counted(found, "component")))
    }

    fn finite(&mut self, path: &str, values: &[f64]) -> bool {
        let wrong = values.iter().position(|value| !value.is_finite());
        self.require(wrong.is_none(), path, || {
            let index = wrong.unwrap_or_default();
            format!("has {} as component {index}; must be finite numbers", values[index])
        })
    }

    /// A fault unless the formula can be read; with values for its variables, also unless it is finite there.
    fn formula(&mut self, path: &str, expr: &Expr, variables: &[&'static str], at: Option<&[f64]>) {
        match (expr.compile(variables), at) {
            (Err(message), _) => self.fault(path, message),
            (Ok(formula), Some(at)) => {
                let value = formula.eval(at);
                self.require(value.is_finite(), path, || {
                    let at: Vec<String> = variables.iter().zip(at).map(|(name, value)| format!("{name} = {}", short(*value))).collect();
                    format!("is {} at {}; must be finite", plain(value), at.join(", "))
                });
            }
            (Ok(_), None) => {}
        }
    }

    /// A fault unless there is a body of that name.
    fn body(&mut self, path: &str, name: &str) -> Option<&'a Body> {
        let scene = self.scene;
        let names: Vec<&str> = scene.body.keys().map(String::as_str).collect();
        let body = scene.body.get(name);
        self.require(body.is_some(), path, || format!("there is no body `{name}`{}", hint(name, &names)));
        body
    }

    fn names(&mut self) {
        let scene = self.scene;
        let groups: [(&str, Vec<&String>); 5] = [
            ("material", scene.material.keys().collect()),
            ("body", scene.body.keys().collect()),
            ("boundary", scene.boundary.keys().collect()),
            ("load", scene.load.keys().collect()),
            ("probe", scene.probe.keys().collect()),
        ];
        for (group, names) in groups {
            for name in names {
                let right = !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-');
                self.require(right, &format!("{group}.{name}"), || format!("the name {name:?} must be made of A-Z, a-z, 0-9, _ and -"));
            }
        }
        self.require(!scene.body.is_empty(), "body", || "is empty; must have at least one body".into());
        self.require(!scene.material.is_empty(), "material", || "is empty; must have at least one material".into());
    }

    fn plane(&mut self) {
        let right = self.dimension < 3 || self.scene.plane == Plane::Strain;
        self.require(right, "plane", || "is \"stress\", which has no meaning in dimension 3".into());
    }

    fn materials(&mut self) {
        for (name, material) in &self.scene.material {
            self.positive(&format!("material.{name}.young"), material.young);
            self.positive(&format!("material.{name}.density"), material.density);
            let poisson = material.poisson;
            self.require(poisson > -1.0 && poisson < 0.5, &format!("material.{name}.poisson"), || {
                format!("is {}; must be above -1 and below 0.5", plain(poisson))
            });
        }
    }

    /// Bodies and boundaries are known by 16-bit numbers.
    fn counts(&mut self) {
        for (path, count) in [("body", self.scene.body.len()), ("boundary", self.scene.boundary.len())] {
            self.require(count <= usize::from(u16::MAX), path, || format!("has {count} entries; must have at most {}", u16::MAX));
        }
    }

    fn time(&mut self) {
        let time = &self.scene.time;
        let ends = self.positive("time.end", time.end);
        if let Some(step) = time.step
            && self.positive("time.step", step)
            && ends
        {
            let steps = time.end / step;
            self.require(steps <= MOST_STEPS, "time.step", || {
                format!("is {}, which makes {} steps; must make at most {}", plain(step), short(steps), plain(MOST_STEPS))
            });
        }
        if let Some(cfl) = time.cfl {
            self.require(cfl > 0.0 && cfl <= 1.0, "time.cfl", || format!("is {}; must be above 0 and at most 1", plain(cfl)));
            self.require(time.step.is_none(), "time.cfl", || "is given beside `step`; give one of the two".into());
        }
    }

    fn record(&mut self) {
        let record = &self.scene.record;
        if let Some(steps) = record.every_steps {
            self.require(steps > 0, "record.every_steps", || "is 0; must be at least 1".into());
            self.require(record.every.is_none(), "record.every_steps", || "is given beside `every`; give one of the two".into());
        }
        for (path, every) in [("record.every", record.every), ("record.history", record.history)] {
            if let Some(every) = every
                && self.positive(path, every)
            {
                let records = self.scene.time.end / every;
                self.require(records.is_nan() || records <= MOST_RECORDS, path, || {
                    format!("is {}, which makes {} records; must make at most {}", plain(every), short(records), plain(MOST_RECORDS))
                });
            }
        }
    }

    fn grid(&mut self) -> Option<Cells> {
        let grid = &self.scene.grid;
        let cells = match &grid.cell {
            OneOrEach::One(cell) => std::slice::from_ref(cell),
            OneOrEach::Each(cells) => cells,
        };
        let found = self.faults.len();
        self.vector("grid.origin", &grid.origin);
        self.components("grid.size", grid.size.len(), self.dimension);
        for (axis, size) in grid.size.iter().enumerate() {
            self.positive(&format!("grid.size[{axis}]"), *size);
        }
        if !grid.cell.fits(self.dimension) {
            self.components("grid.cell", cells.len(), self.dimension);
        }
        for (axis, cell) in cells.iter().enumerate() {
            self.positive(&each_path("grid.cell", &grid.cell, axis), *cell);
        }
        if self.faults.len() > found {
            return None;
        }
        let cells = Cells::new(grid, self.dimension);
        for (axis, (size, cell)) in grid.size.iter().zip(&cells.size).enumerate() {
            self.whole_cells(&format!("grid.size[{axis}]"), *size, *cell);
        }
        (self.faults.len() == found).then_some(cells)
    }

    /// A fault unless `size` is a whole number of cells, up to round-off.
    fn whole_cells(&mut self, path: &str, size: f64, cell: f64) {
        let count = size / cell;
        let whole = count.round().max(1.0);
        let near = (count - whole).abs() <= 1e-9 * whole;
        let few = self.require(count <= MOST_CELLS, path, || format!("makes {} cells; must make at most 2^28", short(count)));
        self.require(near || !few, path, || {
            let (is, cells, nearest) = (plain(size), short(count), short(whole * cell));
            format!("is {is}, which is {cells} cells of {}; the nearest size that would do is {nearest}", plain(cell))
        });
    }

    fn bodies(&mut self) {
        let scene = self.scene;
        let materials: Vec<&str> = scene.material.keys().map(String::as_str).collect();
        for (name, body) in &scene.body {
            let path = format!("body.{name}");
            let material = body.material.as_str();
            self.require(materials.contains(&material), &format!("{path}.material"), || {
                format!("there is no material `{material}`{}", hint(material, &materials))
            });
            let parted = self.particles_per_cell(&format!("{path}.particles_per_cell"), &self.scene.particles_per_cell(body));
            let shape_path = format!("{path}.shape");
            let bounds = if self.region(&shape_path, &body.shape) { self.extent(&shape_path, &body.shape) } else { None };
            self.velocity(&format!("{path}.velocity"), &body.velocity, bounds.as_ref());
            if let (Some((low, high)), Some(cells), true) = (&bounds, self.cells.clone(), parted)
                && self.inside_grid(&shape_path, &cells, low, high)
            {
                self.particles(&shape_path, body, &cells.split(&self.scene.particles_per_cell(body)), low, high);
            }
        }
    }

    fn particles_per_cell(&mut self, path: &str, counts: &OneOrEach<usize>) -> bool {
        let values = match counts {
            OneOrEach::One(count) => std::slice::from_ref(count),
            OneOrEach::Each(counts) => counts,
        };
        let mut right = counts.fits(self.dimension) || self.components(path, values.len(), self.dimension);
        for (index, count) in values.iter().enumerate() {
            right &= self.require((1..=16).contains(count), &each_path(path, counts, index), || format!("is {count}; must be 1 to 16"));
        }
        right
    }

    fn velocity(&mut self, path: &str, velocity: &[Expr], bounds: Option<&(Vec<f64>, Vec<f64>)>) {
        if velocity.is_empty() {
            return;
        }
        self.components(path, velocity.len(), self.dimension);
        let center = bounds.map(|(low, high)| {
            let middle = |axis: usize| if axis < low.len() { 0.5 * (low[axis] + high[axis]) } else { 0.0 };
            [middle(0), middle(1), middle(2)]
        });
        for (index, expr) in velocity.iter().enumerate() {
            self.formula(&format!("{path}[{index}]"), expr, &SPACE, center.as_ref().map(|center| center.as_slice()));
        }
    }

    /// Faults where a body would hold more particles than there is room for, or none.
    fn particles(&mut self, path: &str, body: &Body, spots: &Cells, low: &[f64], high: &[f64]) {
        let estimate: f64 = (0..self.dimension).map(|axis| (high[axis] - low[axis]) / spots.size[axis]).product();
        let few = self.require(estimate <= MOST_PARTICLES, path, || {
            let memory = short(estimate * BYTES_A_PARTICLE / 1e9);
            format!("holds about {} particles, at 300 bytes each about {memory} GB; must be at most 2^27 a body", short(estimate))
        });
        // Gauss points stand elsewhere than equal parts do, though never by more than one of these.
        let slack = if self.scene.positions(body) == Positions::Gauss { spots.size.iter().sum() } else { 0.0 };
        if few && spots.count(low, high, slack) <= MOST_TRIED {
            self.require(spots.any(low, high, slack, |x| body.shape.contains(x, slack)), path, || {
                let spacing: Vec<String> = spots.size.iter().map(|size| short(*size)).collect();
                format!("holds no particle, which would stand {} apart; make the body larger or the cells smaller", spacing.join(" x "))
            });
        }
    }

    /// A fault unless the point is in the shape or at most a cell beside it.
    fn near(&mut self, path: &str, at: &[f64], name: &str, shape: &Shape) {
        // A grid or shape that makes no sense has a fault of its own, and nothing can be said of what is near.
        let Some(cells) = self.cells.as_ref().filter(|_| self.fits(shape)) else { return };
        let slack = cells.size.iter().copied().fold(0.0, f64::max);
        self.require(shape.contains(at, slack), path, || {
            let at: Vec<String> = at.iter().map(|x| plain(*x)).collect();
            format!("is ({}), more than a cell outside body `{name}`", at.join(", "))
        });
    }
}

/// The path of one of several values, or of the one for all.
fn each_path<T>(path: &str, values: &OneOrEach<T>, index: usize) -> String {
    match values {
        OneOrEach::One(_) => path.to_string(),
        OneOrEach::Each(_) => format!("{path}[{index}]"),
    }
}
