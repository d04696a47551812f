//! Grid to particles, and the update of the particles.

use super::lanes::Vector;
use super::{Rows, nodes};
use crate::basis::{BATCH, Stencils, Third};
use crate::grid::{Lanes, Tile};
use crate::material::{Increment, embed};
use crate::model::Model;
use std::ops::Range;

/// Volume ratio from which a particle counts as not compressed: a little below 1, so that one at rest does whatever its round-off (Fei et
/// al. 2021, the code of the authors).
const NOT_COMPRESSED: f64 = 0.999;

/// What to do with the particles.
#[derive(Clone, Copy)]
pub(crate) struct GatherTask<'a> {
    pub(crate) model: &'a Model,
    pub(crate) rows: Rows<'a>,
    /// Whether the affine matrix of APIC is taken from the grid with a kick.
    pub(crate) affine: bool,
    /// Whether nodal accelerations are taken from the grid with a kick.
    pub(crate) increment: bool,
    /// Share of FLIP in a kick; at 0 the acceleration is what the nodal velocity has not got.
    pub(crate) flip_share: f64,
    /// Share of its own velocity with which a particle moves where it separates (ASFLIP).
    pub(crate) separation: f64,
    /// Length of the change of velocity \[s\]; `None` keeps the velocity.
    pub(crate) kick: Option<f64>,
    /// Length of the motion \[s\]; `None` keeps the position.
    pub(crate) drift: Option<f64>,
    /// Length of the straining \[s\]; `None` keeps deformation and stress.
    pub(crate) strain: Option<f64>,
    /// Whether the velocity gradient refers to the positions after the motion (USF), so that F' = (I - dt L)^-1 F, else
    /// F' = (I + dt L) F. Either way F stays the gradient of the motion of the particles, without drift.
    pub(crate) gradient_is_new: bool,
    /// Acceleration of everything \[m/s2\], for the work of the loads.
    pub(crate) gravity: [f64; 3],
    /// Body force of each particle \[m/s2\] by axis, for the work of the loads.
    pub(crate) body_force: &'a [Vec<f64>],
    /// Whether the next step depends on wave and particle speed.
    pub(crate) pace: bool,
}

impl<'a> GatherTask<'a> {
    /// A task that changes nothing yet: pure FLIP, no loads.
    pub(crate) fn new(model: &'a Model, rows: Rows<'a>) -> Self {
        Self {
            model,
            rows,
            affine: false,
            increment: true,
            flip_share: 1.0,
            separation: 0.0,
            kick: None,
            drift: None,
            strain: None,
            gradient_is_new: false,
            gravity: [0.0; 3],
            body_force: &[],
            pace: false,
        }
    }

    /// Whether the accelerations of the nodes are used.
    pub(crate) fn needs_force(&self) -> bool {
        self.kick.is_some() && self.increment
    }
}

/// What came of it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct GatherReport {
    /// First particle in memory that failed.
    pub(crate) fault: Option<Fault>,
    /// Work of gravity and body forces \[J\].
    pub(crate) work: f64,
    /// Smallest ratio of the wave speed at time 0 to wave plus particle speed now.
    pub(crate) pace: f64,
}

/// A particle that could not be updated.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Fault {
    pub(crate) row: usize,
    pub(crate) kind: FaultKind,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum FaultKind {
    /// Determinant of the deformation gradient that is not positive.
    Inverted(f64),
    NotFinite,
    NoThickness,
    /// Length of the domain \[m\].
    WideDomain(f64),
    /// Moved to a place outside the grid.
    Left([f64; 3]),
}

impl FaultKind {
    /// What is wrong with a position that is not in the grid.
    pub(crate) fn of_position(position: [f64; 3]) -> Self {
        if position.iter().all(|x| x.is_finite()) { Self::Left(position) } else { Self::NotFinite }
    }
}

/// # Safety
/// As [`super::Kernels::gather`].
#[inline(always)]
pub(super) unsafe fn gather<const D: usize, const W: usize, V: Vector>(
    task: &GatherTask,
    range: Range<usize>,
    tile: &Tile,
) -> GatherReport {
    let (affine, increment) = (task.kick.is_some() && task.affine, task.needs_force());
    // SAFETY: the caller's promise.
    unsafe {
        match (task.strain.is_some(), affine, increment) {
            (false, false, false) => particles::<D, W, V, false, false, false>(task, range, tile),
            (false, false, true) => particles::<D, W, V, false, false, true>(task, range, tile),
            (false, true, false) => particles::<D, W, V, false, true, false>(task, range, tile),
            (false, true, true) => particles::<D, W, V, false, true, true>(task, range, tile),
            (true, false, false) => particles::<D, W, V, true, false, false>(task, range, tile),
            (true, false, true) => particles::<D, W, V, true, false, true>(task, range, tile),
            (true, true, false) => particles::<D, W, V, true, true, false>(task, range, tile),
            (true, true, true) => particles::<D, W, V, true, true, true>(task, range, tile),
        }
    }
}

/// # Safety
/// As [`super::Kernels::gather`].
#[inline(always)]
unsafe fn particles<const D: usize, const W: usize, V: Vector, const GRADIENT: bool, const AFFINE: bool, const INCREMENT: bool>(
    task: &GatherTask,
    range: Range<usize>,
    tile: &Tile,
) -> GatherReport {
    let rows = &task.rows;
    let mut report = GatherReport { fault: None, work: 0.0, pace: 1.0 };
    // First the stencils of a few particles, then the fields there, then the particles: no stage waits for the one before it.
    let third = if AFFINE { Third::Affine } else { Third::Nothing };
    let (mut stencils, mut samples) = (Stencils::<W>::default(), [Sample::default(); BATCH]);
    let mut start = range.start;
    while start < range.end {
        let count = BATCH.min(range.end - start);
        // SAFETY: these rows are ours.
        stencils.set::<D>(&task.model.axes, &unsafe { rows.places(task.model, start, start + count) }, third);
        for (lane, sample) in samples[..count].iter_mut().enumerate() {
            *sample = interpolate::<D, W, V, GRADIENT, AFFINE, INCREMENT>(&stencils, lane, tile);
        }
        for (sample, p) in samples[..count].iter().zip(start..) {
            // SAFETY: row p is ours.
            unsafe { update::<D, GRADIENT, AFFINE, INCREMENT>(task, p, sample, &mut report) };
        }
        start += count;
    }
    report
}

/// Velocity, position, deformation and stress of one particle.
///
/// # Safety
/// Row `p` of the task is the caller's.
#[inline(always)]
unsafe fn update<const D: usize, const GRADIENT: bool, const AFFINE: bool, const INCREMENT: bool>(
    task: &GatherTask,
    p: usize,
    sample: &Sample,
    report: &mut GatherReport,
) {
    let rows = &task.rows;
    if let Some(kick) = task.kick {
        let mut velocity: [f64; D] = std::array::from_fn(|a| sample.velocity[1 + a]);
        if INCREMENT {
            let share = task.flip_share;
            // SAFETY: row p is ours.
            let old = unsafe { rows.vector::<D, 3>(&rows.velocity, p) };
            for a in 0..D {
                let flip = old[a] + kick * sample.acceleration[1 + a];
                // a pure FLIP must not touch the PIC velocity: 0 times it may lose the last bit
                velocity[a] = if share == 1.0 {
                    flip
                } else if share == 0.0 {
                    velocity[a] + kick * sample.acceleration[1 + a]
                } else {
                    share * flip + (1.0 - share) * velocity[a]
                };
            }
        }
        // SAFETY: row p is ours.
        unsafe { rows.set_vector(&rows.velocity, p, velocity) };
        if AFFINE {
            let c: [[f64; D]; D] = std::array::from_fn(|a| std::array::from_fn(|k| sample.affine[3 - D + k][1 + a]));
            // SAFETY: row p is ours.
            unsafe { rows.set_tensor(&rows.affine, p, c) };
        }
    }
    if let Some(dt) = task.drift {
        // SAFETY: row p is ours.
        let mut position = unsafe { rows.vector::<D, 3>(&rows.position, p) };
        let mut motion: [f64; D] = std::array::from_fn(|a| dt * sample.velocity[1 + a]);
        // SAFETY: row p is ours, and there is an affine matrix where particles separate.
        if task.separation > 0.0 && sample.acceleration[0] == 0.0 && unsafe { separates::<D>(task, p, dt) } {
            // SAFETY: row p is ours.
            let own = unsafe { rows.vector::<D, 3>(&rows.velocity, p) };
            for a in 0..D {
                motion[a] += dt * task.separation * (own[a] - sample.velocity[1 + a]);
            }
        }
        for a in 0..D {
            position[a] += motion[a];
            let own = task.body_force.get(a).map_or(0.0, |b| b[p]);
            report.work += rows.mass[p] * (task.gravity[a] + own) * motion[a];
        }
        if position.iter().zip(&task.model.axes).all(|(&x, axis)| axis.holds(x)) {
            // SAFETY: row p is ours.
            unsafe { rows.set_vector(&rows.position, p, position) };
        } else {
            // the old position stays, for the error to tell
            let place = std::array::from_fn(|a| if a < D { position[a] } else { 0.0 });
            report.fault.get_or_insert(Fault { row: p, kind: FaultKind::of_position(place) });
        }
    }
    if GRADIENT {
        let dt = task.strain.unwrap_or(0.0);
        let gradient: [[f64; D]; D] = std::array::from_fn(|a| std::array::from_fn(|k| dt * sample.gradient[3 - D + k][1 + a]));
        // SAFETY: row p is ours.
        if let Err(kind) = unsafe { strain::<D>(task, p, gradient, report) } {
            report.fault.get_or_insert(Fault { row: p, kind });
        }
    }
}

/// Whether a particle is free to leave its neighbours: what is compressed would be driven through them (Fei et al. 2021).
///
/// # Safety
/// Row `p` of the task is the caller's, and has an affine matrix.
#[inline(always)]
unsafe fn separates<const D: usize>(task: &GatherTask, p: usize, dt: f64) -> bool {
    let rows = &task.rows;
    // SAFETY: row p is ours.
    let (f, c, lateral) = unsafe { (rows.tensor::<D>(&rows.deformation, p), rows.tensor::<D>(&rows.affine, p), rows.lateral(p)) };
    let spread: f64 = (0..D).map(|a| c[a][a]).sum();
    embed(&f, lateral).determinant() * (1.0 + dt * spread) >= NOT_COMPRESSED
}

/// Deformation gradient, stress history and thickness of one particle.
///
/// # Safety
/// Row `p` of the task is the caller's.
#[inline(always)]
unsafe fn strain<const D: usize>(task: &GatherTask, p: usize, gradient: [[f64; D]; D], report: &mut GatherReport) -> Result<(), FaultKind> {
    let rows = &task.rows;
    let material = task.model.material(rows.body[p]);
    // SAFETY: row p is ours.
    let (old, old_lateral) = unsafe { (rows.tensor::<D>(&rows.deformation, p), rows.lateral(p)) };
    let mut map = [[0.0; D]; D];
    for r in 0..D {
        for c in 0..D {
            let identity = if r == c { 1.0 } else { 0.0 };
            map[r][c] = if task.gradient_is_new { identity - gradient[r][c] } else { identity + gradient[r][c] };
        }
    }
    if task.gradient_is_new {
        map = inverse(&map).ok_or(FaultKind::Inverted(0.0))?;
    }
    let mut new = [[0.0; D]; D];
    for r in 0..D {
        for c in 0..D {
            for k in 0..D {
                new[r][c] += map[r][k] * old[k][c];
            }
        }
    }
    let mut lateral = old_lateral;
    if task.model.embedding.stress_free {
        lateral = if material.history() == 0 {
            task.model.embedding.stress_free_stretch(material, &new, old_lateral).ok_or(FaultKind::NoThickness)?
        } else {
            let across = task.model.embedding.gradient(material.lame(), &gradient)[(2, 2)];
            if task.gradient_is_new { old_lateral / (1.0 - across) } else { old_lateral * (1.0 + across) }
        };
        // SAFETY: row p is ours, and there is a lateral stretch where the plane is stress-free.
        unsafe { rows.set_lateral(p, lateral) };
    }
    let f = embed(&new, lateral);
    let jacobian = f.determinant();
    // also false for NaN
    if !(jacobian > 0.0 && jacobian < f64::INFINITY) {
        return Err(if jacobian.is_finite() { FaultKind::Inverted(jacobian) } else { FaultKind::NotFinite });
    }
    if task.model.domains == Some(true) {
        for a in 0..D {
            let half = task.model.bodies[rows.body[p] as usize].half[a] * new[a][a];
            if !task.model.axes[a].fits(half) {
                return Err(FaultKind::WideDomain(2.0 * half));
            }
        }
    }
    // SAFETY: row p is ours.
    unsafe { rows.set_tensor(&rows.deformation, p, new) };
    if material.history() > 0 {
        let at = if task.gradient_is_new { jacobian } else { embed(&old, old_lateral).determinant() };
        let increment = Increment { gradient: task.model.embedding.gradient(material.lame(), &gradient), jacobian: at };
        // SAFETY: row p is ours.
        unsafe {
            let mut history = rows.history(p);
            material.update(&mut history, &increment);
            rows.set_history(p, &history);
        }
    }
    if task.pace {
        // SAFETY: row p is ours.
        let velocity = unsafe { rows.vector::<D, 3>(&rows.velocity, p) };
        let speed = velocity.iter().map(|v| v * v).sum::<f64>().sqrt();
        let body = &task.model.bodies[rows.body[p] as usize];
        let at_rest = (material.lame().wave_modulus() / body.density).sqrt();
        let now = (material.wave_modulus(&f) / body.density).sqrt();
        report.pace = report.pace.min(at_rest / (now + speed));
    }
    Ok(())
}

/// Inverse of a matrix near the identity; `None` where it has none.
#[inline(always)]
fn inverse<const D: usize>(m: &[[f64; D]; D]) -> Option<[[f64; D]; D]> {
    let full = embed(m, 1.0);
    // the motion of one step never turns a particle inside out
    let inverse = (full.determinant() > 0.0).then(|| full.try_inverse()).flatten()?;
    Some(std::array::from_fn(|r| std::array::from_fn(|c| inverse[(r, c)])))
}

/// Grid fields at a particle. Lane 0 carries nothing of use but that of the acceleration, which is not zero near held nodes (ASFLIP).
#[derive(Clone, Copy, Default)]
struct Sample {
    velocity: Lanes,
    acceleration: Lanes,
    /// Derivative of the velocity along each slot.
    gradient: [Lanes; 3],
    /// Affine matrix of APIC by slot of the arm.
    affine: [Lanes; 3],
}

#[inline(always)]
fn interpolate<const D: usize, const W: usize, V: Vector, const GRADIENT: bool, const AFFINE: bool, const INCREMENT: bool>(
    s: &Stencils<W>,
    lane: usize,
    tile: &Tile,
) -> Sample {
    let zero = V::zero();
    let (mut velocity, mut acceleration, mut gradient, mut affine) = (zero, zero, [zero; 3], [zero; 3]);
    let start = tile.frame.index(s.first(lane));
    let stride = tile.frame.stride;
    for i in 0..nodes::<D, W>(0) {
        // sums over slots 1 and 2: value; derivative along slot 1, slot 2; moment along slot 1, slot 2
        let (mut v, mut a) = (zero, zero);
        let (mut d1, mut d2, mut m1, mut m2) = (zero, zero, zero, zero);
        for j in 0..nodes::<D, W>(1) {
            let row = start + i * stride[0] + j * stride[1];
            let velocities: &[Lanes; W] = row_of(&tile.momentum, row);
            let (mut value, mut slope, mut moment) = (zero, zero, zero);
            for k in 0..W {
                let node = V::load(&velocities[k]);
                value = V::fma(s.weight[2][k][lane], node, value);
                if GRADIENT {
                    slope = V::fma(s.slope[2][k][lane], node, slope);
                }
                if AFFINE {
                    moment = V::fma(s.third[2][k][lane], node, moment);
                }
            }
            let n1 = s.weight[1][j][lane];
            v = V::fma(n1, value, v);
            if GRADIENT {
                d1 = V::fma(s.slope[1][j][lane], value, d1);
                d2 = V::fma(n1, slope, d2);
            }
            if AFFINE {
                m1 = V::fma(s.third[1][j][lane], value, m1);
                m2 = V::fma(n1, moment, m2);
            }
            if INCREMENT {
                let accelerations: &[Lanes; W] = row_of(&tile.force, row);
                let mut value = zero;
                for k in 0..W {
                    value = V::fma(s.weight[2][k][lane], V::load(&accelerations[k]), value);
                }
                a = V::fma(n1, value, a);
            }
        }
        let n0 = s.weight[0][i][lane];
        velocity = V::fma(n0, v, velocity);
        if INCREMENT {
            acceleration = V::fma(n0, a, acceleration);
        }
        if GRADIENT {
            gradient[0] = V::fma(s.slope[0][i][lane], v, gradient[0]);
            gradient[1] = V::fma(n0, d1, gradient[1]);
            gradient[2] = V::fma(n0, d2, gradient[2]);
        }
        if AFFINE {
            affine[0] = V::fma(s.third[0][i][lane], v, affine[0]);
            affine[1] = V::fma(n0, m1, affine[1]);
            affine[2] = V::fma(n0, m2, affine[2]);
        }
    }
    Sample {
        velocity: velocity.lanes(),
        acceleration: acceleration.lanes(),
        gradient: gradient.map(V::lanes),
        affine: affine.map(V::lanes),
    }
}

/// The `W` nodes from `start` on. The tile covers the cells of its bin.
#[inline(always)]
fn row_of<const W: usize>(nodes: &[Lanes], start: usize) -> &[Lanes; W] {
    nodes[start..].first_chunk().expect("a tile covers the stencils of its particles")
}
