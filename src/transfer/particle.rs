//! The update of one particle, whatever its law: what is not worked out eight at a time.

use super::chunk::Fields;
use super::task::{Fault, FaultKind, GatherTask, Sweep, SweepReport};
use crate::lanes::Number;
use crate::material::{Increment, embed};

/// Volume ratio from which a particle counts as not compressed: a little below 1, so that one at rest does whatever its round-off (Fei et
/// al. 2021, the code of the authors).
const NOT_COMPRESSED: f64 = 0.999;

/// Velocity, position, deformation and stress history of `count` particles from `first` on, the first of which is number `at` of the chunk.
///
/// # Safety
/// The rows are the caller's.
#[inline(never)]
pub(super) unsafe fn update_some<const D: usize, N: Number>(
    sweep: &Sweep,
    task: &GatherTask,
    first: usize,
    at: usize,
    count: usize,
    fields: &mut Fields<N>,
    report: &mut SweepReport,
) {
    for lane in 0..count {
        // SAFETY: the row is ours.
        unsafe { update::<D, N>(sweep, task, first + lane, at + lane, fields, report) };
    }
}

/// The same for particle `p`, number `at` of the chunk.
///
/// # Safety
/// The row is the caller's.
#[inline(always)]
unsafe fn update<const D: usize, N: Number>(
    sweep: &Sweep,
    task: &GatherTask,
    p: usize,
    at: usize,
    fields: &mut Fields<N>,
    report: &mut SweepReport,
) {
    let rows = &sweep.rows;
    let grid_velocity: [f64; D] = std::array::from_fn(|a| fields.velocity[a].number(at));
    if let Some(kick) = task.kick {
        let mut velocity = grid_velocity;
        if task.increment {
            let share = task.flip_share;
            // SAFETY: row p is ours.
            let old = unsafe { rows.vector::<D, 3>(&rows.velocity, p) };
            for a in 0..D {
                let change = kick * fields.acceleration[1 + a].number(at);
                // a pure FLIP must not touch the PIC velocity: 0 times it may lose the last bit
                velocity[a] = if share == 1.0 {
                    old[a] + change
                } else if share == 0.0 {
                    velocity[a] + change
                } else {
                    share * (old[a] + change) + (1.0 - share) * velocity[a]
                };
            }
        }
        for a in 0..D {
            fields.velocity[a].0[at] = N::of(velocity[a]);
        }
        // SAFETY: row p is ours.
        unsafe { rows.set_vector(&rows.velocity, p, velocity) };
        if task.affine {
            let c: [[f64; D]; D] = std::array::from_fn(|a| std::array::from_fn(|k| fields.affine[a][k].number(at)));
            // SAFETY: row p is ours.
            unsafe { rows.set_tensor(&rows.affine, p, c) };
        }
    }
    if let Some(dt) = task.drift {
        // SAFETY: row p is ours.
        let mut position = unsafe { rows.vector::<D, 3>(&rows.position, p) };
        let mut motion: [f64; D] = std::array::from_fn(|a| dt * grid_velocity[a]);
        // SAFETY: row p is ours, and there is an affine matrix where particles separate.
        if task.separation > 0.0 && fields.acceleration[0].number(at) == 0.0 && unsafe { separates::<D>(sweep, p, dt) } {
            // SAFETY: row p is ours.
            let own = unsafe { rows.vector::<D, 3>(&rows.velocity, p) };
            for a in 0..D {
                motion[a] += dt * task.separation * (own[a] - grid_velocity[a]);
            }
        }
        for a in 0..D {
            report.way = report.way.max((motion[a] * sweep.model.axes[a].inverse_cell()).abs());
            position[a] += motion[a];
            let own = task.body_force.get(a).map_or(0.0, |b| b[p]);
            // SAFETY: row p is ours.
            report.work += unsafe { *rows.mass(p) } * (task.gravity[a] + own) * motion[a];
        }
        if position.iter().zip(&sweep.model.axes).all(|(&x, axis)| axis.holds(x)) {
            // SAFETY: row p is ours.
            unsafe { rows.set_vector(&rows.position, p, position) };
        } else {
            // the old position stays, for the error to tell
            let place = std::array::from_fn(|a| if a < D { position[a] } else { 0.0 });
            report.fault.get_or_insert(Fault { row: p, kind: FaultKind::of_position(place) });
        }
    }
    if let Some(dt) = task.strain {
        let gradient: [[f64; D]; D] = std::array::from_fn(|a| std::array::from_fn(|k| dt * fields.gradient[a][k].number(at)));
        // SAFETY: row p is ours.
        if let Err(kind) = unsafe { strain::<D>(sweep, task, p, gradient, report) } {
            report.fault.get_or_insert(Fault { row: p, kind });
        }
    }
}

/// Whether a particle is free to leave its neighbours: what is compressed would be driven through them (Fei et al. 2021).
///
/// # Safety
/// Row `p` is the caller's, and has an affine matrix.
#[inline(always)]
unsafe fn separates<const D: usize>(sweep: &Sweep, p: usize, dt: f64) -> bool {
    let rows = &sweep.rows;
    // SAFETY: row p is ours.
    let (f, c, lateral) = unsafe { (rows.tensor::<D>(&rows.deformation, p), rows.tensor::<D>(&rows.affine, p), rows.lateral(p)) };
    let spread: f64 = (0..D).map(|a| c[a][a]).sum();
    embed(&f, lateral).determinant() * (1.0 + dt * spread) >= NOT_COMPRESSED
}

/// Deformation gradient, stress history and thickness of one particle.
///
/// # Safety
/// Row `p` is the caller's.
#[inline(always)]
unsafe fn strain<const D: usize>(
    sweep: &Sweep,
    task: &GatherTask,
    p: usize,
    gradient: [[f64; D]; D],
    report: &mut SweepReport,
) -> Result<(), FaultKind> {
    let (rows, model) = (&sweep.rows, sweep.model);
    // SAFETY: row p is ours.
    let material = model.material(unsafe { rows.body(p) } as u16);
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
    if model.embedding.stress_free {
        lateral = if material.history() == 0 {
            model.embedding.stress_free_stretch(material, &new, old_lateral).ok_or(FaultKind::NoThickness)?
        } else {
            let across = model.embedding.gradient(material.lame(), &gradient)[(2, 2)];
            if task.gradient_is_new { old_lateral / (1.0 - across) } else { old_lateral * (1.0 + across) }
        };
        // SAFETY: row p is ours, and there is a lateral stretch where the plane is stress-free.
        unsafe { rows.set_lateral(p, lateral) };
    }
    let f = embed(&new, lateral);
    let jacobian = f.determinant();
    // also false for NaN
    if !(jacobian > 0.0 && jacobian < f64::INFINITY) {
        return Err(FaultKind::of_jacobian(jacobian));
    }
    if model.domains == Some(true) {
        for a in 0..D {
            // SAFETY: row p is ours.
            let half = model.bodies[unsafe { rows.body(p) }].half[a] * new[a][a];
            if !model.axes[a].fits(half) {
                return Err(FaultKind::WideDomain(2.0 * half));
            }
        }
    }
    // SAFETY: row p is ours.
    unsafe { rows.set_tensor(&rows.deformation, p, new) };
    if material.history() > 0 {
        let at = if task.gradient_is_new { jacobian } else { embed(&old, old_lateral).determinant() };
        let increment = Increment { gradient: model.embedding.gradient(material.lame(), &gradient), jacobian: at };
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
        // SAFETY: row p is ours.
        let body = &model.bodies[unsafe { rows.body(p) }];
        let at_rest = material.lame().wave_modulus();
        report.stiffening = report.stiffening.max(material.wave_modulus(&f) / at_rest);
        report.speed = report.speed.max(velocity.iter().map(|v| v * v).sum::<f64>() * body.density / at_rest);
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

/// -V0 tau of `count` particles from `first` on, the first of which is number `at` of the chunk, times `scale`; zero where their stress is
/// integrated elsewhere.
///
/// # Safety
/// The rows are the caller's.
#[inline(never)]
pub(super) unsafe fn stress_of_some<const D: usize, N: Number>(
    sweep: &Sweep,
    scale: f64,
    relieved: &[bool],
    first: usize,
    at: usize,
    count: usize,
    fields: &mut Fields<N>,
) {
    for lane in 0..count {
        // SAFETY: the row is ours.
        unsafe { stress::<D, N>(sweep, scale, relieved, first + lane, at + lane, fields) };
    }
}

/// The same for particle `p`, number `at` of the chunk.
///
/// # Safety
/// The row is the caller's.
#[inline(always)]
unsafe fn stress<const D: usize, N: Number>(sweep: &Sweep, scale: f64, relieved: &[bool], p: usize, at: usize, fields: &mut Fields<N>) {
    let rows = &sweep.rows;
    // SAFETY: row p is ours.
    let (f, lateral, history) = unsafe { (rows.tensor::<D>(&rows.deformation, p), rows.lateral(p), rows.history(p)) };
    let is_relieved = !relieved.is_empty() && relieved[p];
    // SAFETY: row p is ours.
    let weight = if is_relieved { 0.0 } else { -scale * unsafe { *rows.volume(p) } };
    // SAFETY: row p is ours.
    let tau = sweep.model.material(unsafe { rows.body(p) } as u16).kirchhoff(&embed(&f, lateral), &history);
    for r in 0..D {
        for c in 0..D {
            fields.force[r][c].0[at] = N::of(weight * tau[(r, c)]);
        }
    }
}
