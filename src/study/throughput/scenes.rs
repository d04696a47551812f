//! Scenes that are timed, all with a fixed step.

/// A block of a unit cube's cells.
#[derive(Debug, Clone, Copy)]
pub(super) struct Size {
    /// Cells along an edge of the block.
    pub(super) block: usize,
    /// Cells along an edge of the cube of 1 m in which it falls.
    pub(super) cube: usize,
    /// Cells below and beside it.
    pub(super) below: usize,
}

impl Size {
    /// 13 824 particles.
    pub(super) const QUICK: Self = Self { block: 12, cube: 20, below: 4 };
    /// 97 336 particles.
    pub(super) const COMMON: Self = Self { block: 23, cube: 32, below: 4 };
    /// A million particles.
    pub(super) const MILLION: Self = Self { block: 50, cube: 64, below: 7 };

    pub(super) fn particles(self) -> usize {
        (2 * self.block).pow(3)
    }
}

/// The method of the common work.
pub(super) const APIC: &str = r#"transfer = "apic", integrator = "usl""#;

/// The common work: a neo-Hookean block (1 MPa, 0.3, 1000 kg/m3) that turns and shears while it falls on a floor, 8 particles a cell, jittered,
/// in steps of a fifth of the time that a wave takes through a cell. The cube is so many times as wide as it need be.
pub(super) fn block(size: Size, method: &str, times_wider: usize) -> String {
    let cell = 1.0 / size.cube as f64;
    let corner = |cells: usize| vec![cells as f64 * cell; 3];
    format!(
        r#"
        title = "elastic block"
        dimension = 3
        grid = {{ origin = [0, 0, 0], size = {cube:?}, cell = {cell} }}
        material.rubber = {{ law = "neo_hookean", young = 1e6, poisson = 0.3, density = 1e3 }}
        boundary.floor = {{ face = "y-", fixed = ["y"] }}
        load.weight.gravity = [0, -9.8, 0]
        method = {{ {method} }}
        time = {{ end = 100, step = {step} }}
        [body.block]
        material = "rubber"
        shape = {{ box = {{ min = {low:?}, max = {high:?} }} }}
        particles_per_cell = 2
        positions = "jittered"
        velocity = ["0.5*sin(2*PI*y)", "0.5*sin(2*PI*z)", "0.5*sin(2*PI*x)"]
        "#,
        cube = corner(size.cube * times_wider),
        step = 0.2 * cell / WAVE,
        low = corner(size.below),
        high = corner(size.below + size.block),
    )
}

/// Speed of a wave in the rubber of the block \[m/s\]: the root of (lambda + 2 mu) / density.
const WAVE: f64 = 36.69;

/// The same for the total formulation, which has neither a grid around the body nor a floor below it; so many particles along an edge of a cell.
pub(super) fn block_alone(size: Size, law: &str, method: &str, particles: usize) -> String {
    let cell = 1.0 / size.cube as f64;
    let high = vec![size.block as f64 * cell; 3];
    format!(
        r#"
        title = "elastic block"
        dimension = 3
        grid = {{ origin = [0, 0, 0], size = {high:?}, cell = {cell} }}
        material.rubber = {{ law = "{law}", young = 1e6, poisson = 0.3, density = 1e3 }}
        load.weight.gravity = [0, -9.8, 0]
        method = {{ formulation = "total", degree = 2, {method} }}
        time = {{ end = 100, step = {step} }}
        [body.block]
        material = "rubber"
        shape = {{ box = {{ min = [0, 0, 0], max = {high:?} }} }}
        particles_per_cell = {particles}
        velocity = ["0.5*sin(2*PI*y)", "0.5*sin(2*PI*z)", "0.5*sin(2*PI*x)"]
        "#,
        step = 0.05 * cell / WAVE,
    )
}

/// A cantilever 8 m by 1 m in the plane, `cells` through its height, 4 particles a cell, jittered.
pub(super) fn cantilever(cells: usize, method: &str) -> String {
    let cell = 1.0 / cells as f64;
    format!(
        r#"
        title = "cantilever"
        dimension = 2
        grid = {{ origin = [0, -0.25], size = [9, 1.5], cell = {cell} }}
        material.rubber = {{ law = "neo_hookean", young = 1e6, poisson = 0.3, density = 1e3 }}
        boundary.wall = {{ face = "x-", fixed = ["x", "y"] }}
        load.weight.gravity = [0, -9.8]
        method = {{ {method} }}
        time = {{ end = 100, step = {step} }}
        [body.beam]
        material = "rubber"
        shape = {{ box = {{ min = [0, 0], max = [8, 1] }} }}
        particles_per_cell = 2
        positions = "jittered"
        "#,
        step = 0.2 * cell / WAVE,
    )
}

/// A2: the cantilever of Andersen and Andersen (2007), 288 particles, pulled at its tip by a force that is set from outside.
pub(super) fn a2() -> String {
    format!(
        r#"{}
        load.tip.point_force = {{ body = "beam", at = [7.9166666667, 0.9166666667], value = "external" }}
        probe.tip = {{ at = [8, 0.5] }}
        "#,
        a2_unloaded("", 20.0)
    )
}

/// The same without its force; more about the method, and the end \[s\].
pub(super) fn a2_unloaded(method: &str, end: f64) -> String {
    format!(
        r#"
        title = "Andersen 2007, cantilever"
        dimension = 2
        plane = "strain"
        grid = {{ origin = [0, -1], size = [9, 3], cell = 0.5 }}
        material.steel = {{ law = "hypo_elastic", young = 3e5, poisson = 0, density = 1e3 }}
        body.beam = {{ material = "steel", shape = {{ box = {{ min = [0, 0], max = [8, 1] }} }}, particles_per_cell = 3 }}
        boundary.wall = {{ face = "x-", fixed = ["x", "y"] }}
        method = {{ integrator = "usf"{method} }}
        time = {{ end = {end}, step = 0.003 }}"#
    )
}

/// T2: the bar of Tielen (2016) with 7 % strain, in so many cells.
pub(super) fn t2(cells: usize, method: &str, end: f64) -> String {
    format!(
        r#"
        title = "Tielen 2016, vibrating bar, large deformations"
        dimension = 1
        grid = {{ origin = [0], size = [1], cell = {} }}
        material.elastic = {{ law = "hypo_elastic", young = 50, density = 25 }}
        boundary.left = {{ face = "x-", fixed = ["x"] }}
        boundary.right = {{ face = "x+", fixed = ["x"] }}
        method = {{ integrator = "musl"{method} }}
        time = {{ end = {end}, step = 1e-4 }}
        [body.bar]
        material = "elastic"
        shape = {{ box = {{ min = [0], max = [1] }} }}
        particles_per_cell = 4
        velocity = ["0.1*sin(PI*x)"]
        "#,
        1.0 / cells as f64
    )
}
