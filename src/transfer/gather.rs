//! Grid to particles, and the update of the particles.

use super::{Rows, fma, nodes};
use crate::basis::Stencil;
use crate::grid::{Lanes, Tile};
use crate::material::{Increment, embed};
use crate::model::Model;
use std::ops::Range;

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
    /// Moved to a place outside the grid.
    Left([f64; 3]),
}

/// # Safety
/// As [`super::Kernels::gather`].
#[inline(always)]
pub(super) unsafe fn gather<const D: usize, const W: usize, const FMA: bool>(task: &GatherTask, range: Range<usize>, tile: &Tile) -> GatherReport {
    let kicks = task.kick.is_some();
    let (affine, increment) = (kicks && task.affine, kicks && task.increment);
    // SAFETY: the caller's promise.
    unsafe {
        match (task.strain.is_some(), affine, increment) {
            (false, false, false) => particles::<D, W, FMA, false, false, false>(task, range, tile),
            (false, false, true) => particles::<D, W, FMA, false, false, true>(task, range, tile),
            (false, true, false) => particles::<D, W, FMA, false, true, false>(task, range, tile),
            (false, true, true) => particles::<D, W, FMA, false, true, true>(task, range, tile),
            (true, false, false) => particles::<D, W, FMA, true, false, false>(task, range, tile),
            (true, false, true) => particles::<D, W, FMA, true, false, true>(task, range, tile),
            (true, true, false) => particles::<D, W, FMA, true, true, false>(task, range, tile),
            (true, true, true) => particles::<D, W, FMA, true, true, true>(task, range, tile),
        }
    }
}

/// # Safety
/// As [`super::Kernels::gather`].
#[inline(always)]
unsafe fn particles<const D: usize, const W: usize, const FMA: bool, const GRADIENT: bool, const AFFINE: bool, const INCREMENT: bool>(
    task: &GatherTask,
    range: Range<usize>,
    tile: &Tile,
) -> GatherReport {
    let rows = &task.rows;
    let mut report = GatherReport { fault: None, work: 0.0, pace: 1.0 };
    for p in range {
        // SAFETY: row p is ours.
        let mut position = unsafe { rows.vector::<D, 3>(&rows.position, p) };
        let stencil = Stencil::<W>::at::<D, AFFINE>(&task.model.axes, position);
        let sample = interpolate::<D, W, FMA, GRADIENT, AFFINE, INCREMENT>(&stencil, tile);
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
            for a in 0..D {
                let motion = dt * sample.velocity[1 + a];
                position[a] += motion;
                let own = task.body_force.get(a).map_or(0.0, |b| b[p]);
                report.work += rows.mass[p] * (task.gravity[a] + own) * motion;
            }
            if !position.iter().zip(&task.model.axes).all(|(&x, axis)| axis.holds(x)) {
                let finite = position.iter().all(|x| x.is_finite());
                let place = std::array::from_fn(|a| if a < D { position[a] } else { 0.0 });
                report.fault.get_or_insert(Fault { row: p, kind: if finite { FaultKind::Left(place) } else { FaultKind::NotFinite } });
            }
            // SAFETY: row p is ours.
            unsafe { rows.set_vector(&rows.position, p, position) };
        }
        if GRADIENT {
            let dt = task.strain.unwrap_or(0.0);
            let gradient: [[f64; D]; D] = std::array::from_fn(|a| std::array::from_fn(|k| dt * sample.gradient[3 - D + k][1 + a]));
            // SAFETY: row p is ours.
            if let Err(kind) = unsafe { strain::<D>(task, p, gradient, &mut report) } {
                report.fault.get_or_insert(Fault { row: p, kind });
            }
        }
    }
    report
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

/// Grid fields at a particle. Lane 0 carries nothing of use.
struct Sample {
    velocity: Lanes,
    acceleration: Lanes,
    /// Derivative of the velocity along each slot.
    gradient: [Lanes; 3],
    /// Affine matrix of APIC by slot of the arm.
    affine: [Lanes; 3],
}

#[inline(always)]
fn interpolate<const D: usize, const W: usize, const FMA: bool, const GRADIENT: bool, const AFFINE: bool, const INCREMENT: bool>(
    s: &Stencil<W>,
    tile: &Tile,
) -> Sample {
    let zero = Lanes::default();
    let mut sample = Sample { velocity: zero, acceleration: zero, gradient: [zero; 3], affine: [zero; 3] };
    let start = tile.frame.index(s.first);
    let stride = tile.frame.stride;
    for i in 0..nodes::<D, W>(0) {
        // sums over slots 1 and 2: value; derivative along slot 1, slot 2; moment along slot 1, slot 2
        let (mut v, mut a) = (zero, zero);
        let (mut d1, mut d2, mut m1, mut m2) = (zero, zero, zero, zero);
        for j in 0..nodes::<D, W>(1) {
            let row = start + i * stride[0] + j * stride[1];
            let velocities = &tile.momentum[row..row + W];
            let (mut value, mut slope, mut moment) = (zero, zero, zero);
            for k in 0..W {
                value = fma::<FMA>(s.weight[2][k], velocities[k], value);
                if GRADIENT {
                    slope = fma::<FMA>(s.slope[2][k], velocities[k], slope);
                }
                if AFFINE {
                    moment = fma::<FMA>(s.affine[2][k], velocities[k], moment);
                }
            }
            let n1 = s.weight[1][j];
            v = fma::<FMA>(n1, value, v);
            if GRADIENT {
                d1 = fma::<FMA>(s.slope[1][j], value, d1);
                d2 = fma::<FMA>(n1, slope, d2);
            }
            if AFFINE {
                m1 = fma::<FMA>(s.affine[1][j], value, m1);
                m2 = fma::<FMA>(n1, moment, m2);
            }
            if INCREMENT {
                let accelerations = &tile.force[row..row + W];
                let mut value = zero;
                for k in 0..W {
                    value = fma::<FMA>(s.weight[2][k], accelerations[k], value);
                }
                a = fma::<FMA>(n1, value, a);
            }
        }
        let n0 = s.weight[0][i];
        sample.velocity = fma::<FMA>(n0, v, sample.velocity);
        if INCREMENT {
            sample.acceleration = fma::<FMA>(n0, a, sample.acceleration);
        }
        if GRADIENT {
            sample.gradient[0] = fma::<FMA>(s.slope[0][i], v, sample.gradient[0]);
            sample.gradient[1] = fma::<FMA>(n0, d1, sample.gradient[1]);
            sample.gradient[2] = fma::<FMA>(n0, d2, sample.gradient[2]);
        }
        if AFFINE {
            sample.affine[0] = fma::<FMA>(s.affine[0][i], v, sample.affine[0]);
            sample.affine[1] = fma::<FMA>(n0, m1, sample.affine[1]);
            sample.affine[2] = fma::<FMA>(n0, m2, sample.affine[2]);
        }
    }
    sample
}
