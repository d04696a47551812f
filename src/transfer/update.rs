//! The update of the particles from what they took from the grid: eight at a time, where that is worth it.

use super::chunk::{Fields, load_eight, store_eight};
use super::task::{Fault, FaultKind, GatherTask, Plan, Sweep, SweepReport, What};
use super::{particle, rate};
use crate::lanes::{Batch, LANES, Mask, Real, Wide};
use crate::model::Body;

/// Largest of some numbers, lane by lane (see [`SweepReport`]).
pub(super) struct Extremes<E> {
    way: E,
    stiffening: E,
    speed: E,
    work: E,
}

impl<E: Wide> Extremes<E> {
    /// Of no particles.
    #[inline(always)]
    pub(super) fn none() -> Self {
        let zero = E::splat(0.0);
        Self { way: zero, stiffening: zero, speed: zero, work: zero }
    }

    /// Tells the report.
    #[inline(always)]
    pub(super) fn report(&self, report: &mut SweepReport) {
        let (mut way, mut stiffening, mut speed, mut work) = (Batch::default(), Batch::default(), Batch::default(), Batch::default());
        self.way.store_lanes(&mut way);
        self.stiffening.store_lanes(&mut stiffening);
        self.speed.store_lanes(&mut speed);
        self.work.store_lanes(&mut work);
        for lane in 0..LANES {
            report.work += work[lane];
            report.way = report.way.max(way[lane]);
            report.stiffening = report.stiffening.max(stiffening[lane]);
            report.speed = report.speed.max(speed[lane]);
        }
    }
}

/// What the kernels keep of eight particles while they work on them.
pub(super) struct Eight<E, const D: usize> {
    /// Position \[m\].
    pub(super) position: [E; D],
    /// Deformation gradient.
    deformation: [[E; D]; D],
}

impl<E: Wide, const D: usize> Eight<E, D> {
    /// `count` particles from row `first` on.
    ///
    /// # Safety
    /// The rows are the caller's; there are at most [`LANES`].
    #[inline(always)]
    pub(super) unsafe fn load(sweep: &Sweep, first: usize, count: usize) -> Self {
        let rows = &sweep.rows;
        let (mut position, mut deformation) = ([E::splat(0.0); D], [[E::splat(0.0); D]; D]);
        for a in 0..D {
            // SAFETY: the rows are the caller's.
            position[a] = unsafe { E::load_some(rows.position.at(a, first), count) };
            for k in 0..D {
                // SAFETY: as above.
                deformation[a][k] = unsafe { E::load_some(rows.deformation.at(D * a + k, first), count) };
            }
        }
        Self { position, deformation }
    }
}

/// Velocity, position and deformation of `count` particles from `first` on, the first of which is number `at` of the fields.
///
/// # Safety
/// The rows are the caller's; there are at most [`LANES`].
#[inline(always)]
pub(super) unsafe fn update<const D: usize, const W: usize, V: Real<Wide = E>, E: Wide>(
    sweep: &Sweep,
    task: &GatherTask,
    plan: &Plan<W>,
    first: usize,
    at: usize,
    count: usize,
    fields: &mut Fields<V::Number>,
    extremes: &mut Extremes<E>,
    report: &mut SweepReport,
) -> Eight<E, D> {
    if !plan.update_in_lanes {
        // SAFETY: the rows are ours.
        return unsafe {
            particle::update_some::<D, V::Number>(sweep, task, first, at, count, fields, report);
            Eight::load(sweep, first, count)
        };
    }
    let rows = &sweep.rows;
    // SAFETY: the rows are ours.
    let mut eight = unsafe { Eight::<E, D>::load(sweep, first, count) };
    let all = ((1u32 << count) - 1) as Mask;
    let mut velocity = [E::splat(0.0); D];
    for a in 0..D {
        velocity[a] = load_eight::<V>(&fields.velocity[a], at);
    }
    let grid_velocity = velocity;
    if let Some(kick) = task.kick {
        if task.increment {
            for a in 0..D {
                let change = E::splat(kick) * load_eight::<V>(&fields.acceleration[1 + a], at);
                // SAFETY: the rows are ours.
                let flip = unsafe { E::load_some(rows.velocity.at(a, first), count) } + change;
                // a pure FLIP must not touch the PIC velocity: 0 times it may lose the last bit
                velocity[a] = if task.flip_share == 1.0 {
                    flip
                } else if task.flip_share == 0.0 {
                    velocity[a] + change
                } else {
                    E::splat(task.flip_share) * flip + E::splat(1.0 - task.flip_share) * velocity[a]
                };
            }
        }
        for a in 0..D {
            store_eight::<V>(&mut fields.velocity[a], at, velocity[a]);
            if task.keep {
                // SAFETY: the rows are ours.
                unsafe { velocity[a].store_some(rows.velocity.at(a, first), count) };
            }
            if task.affine && task.keep {
                for k in 0..D {
                    // SAFETY: the rows are ours, and there is an affine matrix.
                    unsafe { load_eight::<V>(&fields.affine[a][k], at).store_some(rows.affine.at(D * a + k, first), count) };
                }
            }
        }
    }
    let mut faulty = 0;
    if let Some(dt) = task.drift {
        let (mut work, mut way) = (E::splat(0.0), E::splat(0.0));
        let (mut new, mut inside) = ([E::splat(0.0); D], all);
        for a in 0..D {
            let motion = E::splat(dt) * grid_velocity[a];
            new[a] = eight.position[a] + motion;
            let axis = &plan.tables[a];
            way = way.max((motion * E::splat(axis.inverse)).abs().select(all, E::splat(0.0)));
            let s = axis.place(new[a]);
            let (low, high) = axis.ends;
            // also outside where the position is no number
            inside &= E::splat(low).at_most(s) & s.at_most(E::splat(high));
            if task.work {
                let mut body_force = E::splat(task.gravity[a]);
                if let Some(own) = task.body_force.get(a) {
                    // SAFETY: a number a particle.
                    body_force = body_force + unsafe { E::load_some(own.as_ptr().add(first), count) };
                }
                work = body_force.fma(motion, work);
            }
        }
        extremes.way = extremes.way.max(way);
        faulty |= all & !inside;
        if faulty != 0 {
            let mut places = [Batch::default(); 3];
            for a in 0..D {
                new[a].store_lanes(&mut places[a]);
            }
            let lane = faulty.trailing_zeros() as usize;
            let place = [places[0][lane], places[1][lane], places[2][lane]];
            note(report, Fault { row: first + lane, kind: FaultKind::of_position(place) });
        }
        for a in 0..D {
            // where it left the grid the old position stays, for the error to tell
            eight.position[a] = new[a].select(inside, eight.position[a]);
            // SAFETY: the rows are ours.
            unsafe { eight.position[a].store_some(rows.position.at(a, first), count) };
        }
        if task.work {
            // SAFETY: a number a particle.
            let work = work * unsafe { E::load_some(rows.mass(first), count) };
            extremes.work = extremes.work + work.select(all, E::splat(0.0));
        }
    }
    let Some(dt) = task.strain else { return eight };
    let (old, mut f) = (eight.deformation, eight.deformation);
    for r in 0..D {
        for c in 0..D {
            let mut rate = load_eight::<V>(&fields.gradient[r][0], at) * old[0][c];
            for k in 1..D {
                rate = load_eight::<V>(&fields.gradient[r][k], at).fma(old[k][c], rate);
            }
            f[r][c] = E::splat(dt).fma(rate, old[r][c]);
        }
    }
    if task.gradient_is_new {
        let mut back = [[E::splat(0.0); D]; D];
        for r in 0..D {
            for c in 0..D {
                let identity = if r == c { 1.0 } else { 0.0 };
                back[r][c] = E::splat(dt).fnma(load_eight::<V>(&fields.gradient[r][c], at), E::splat(identity));
            }
        }
        f = solved(&back, &old);
    }
    if sweep.model.domains == Some(true) {
        // SAFETY: the rows are ours.
        unsafe { keep_narrow::<D, W, E>(sweep, plan, first, count, &old, &mut f, report) };
    }
    eight.deformation = f;
    let jacobian = determinant(&f);
    // also not sound where it is no number
    let sound = E::splat(0.0).below(jacobian) & jacobian.below(E::splat(f64::INFINITY));
    let inverted = all & !sound & !faulty;
    if inverted != 0 {
        let mut of = Batch::default();
        jacobian.store_lanes(&mut of);
        let lane = inverted.trailing_zeros() as usize;
        note(report, Fault { row: first + lane, kind: FaultKind::of_jacobian(of[lane]) });
    }
    for r in 0..D {
        for c in 0..D {
            // SAFETY: the rows are ours.
            unsafe { f[r][c].store_some(rows.deformation.at(D * r + c, first), count) };
        }
    }
    if plan.by_rate {
        // the law is about the volume ratio at the positions that the gradient refers to
        let volume = if task.gradient_is_new { jacobian } else { determinant(&old) };
        // SAFETY: the rows are ours.
        unsafe { rate::update::<D, V, E>(sweep, dt, &fields.gradient, volume, first, at, count) };
    }
    if task.pace {
        // SAFETY: the rows are ours.
        let velocity = if task.kick.is_some() { velocity } else { unsafe { velocities::<D, E>(sweep, first, count) } };
        pace::<D, E>(sweep, first, count, &f, jacobian, &velocity, extremes);
    }
    eight
}

/// Notes a particle whose domain does not fit the stencil after the deformation `f`, and gives it its old one, so that the sweep may end.
///
/// # Safety
/// The rows are the caller's.
#[inline(always)]
unsafe fn keep_narrow<const D: usize, const W: usize, E: Wide>(
    sweep: &Sweep,
    plan: &Plan<W>,
    first: usize,
    count: usize,
    old: &[[E; D]; D],
    f: &mut [[E; D]; D],
    report: &mut SweepReport,
) {
    for a in 0..D {
        // SAFETY: the rows are ours.
        let half = unsafe { by_body::<E>(sweep, first, count, |body| body.half[a]) } * f[a][a];
        let (low, high) = (E::splat(0.0), E::splat(plan.tables[a].widest));
        // also too wide where it is no number
        let wide = ((1u32 << count) - 1) as Mask & !(low.below(half) & half.at_most(high));
        if wide != 0 {
            let mut halves = Batch::default();
            half.store_lanes(&mut halves);
            let lane = wide.trailing_zeros() as usize;
            note(report, Fault { row: first + lane, kind: FaultKind::WideDomain(2.0 * halves[lane]) });
            for r in 0..D {
                for c in 0..D {
                    f[r][c] = old[r][c].select(wide, f[r][c]);
                }
            }
        }
    }
}

/// A^-1 B.
#[inline(always)]
fn solved<const D: usize, E: Wide>(a: &[[E; D]; D], b: &[[E; D]; D]) -> [[E; D]; D] {
    let inverse = E::splat(1.0) / determinant(a);
    let mut solved = [[E::splat(0.0); D]; D];
    for r in 0..D {
        for k in 0..D {
            // cofactor of row k, column r
            let cofactor = match D {
                1 => E::splat(1.0),
                2 if r == k => a[1 - k][1 - r],
                2 => -a[1 - k][1 - r],
                _ => {
                    let (i, j, m, n) = ((k + 1) % 3, (k + 2) % 3, (r + 1) % 3, (r + 2) % 3);
                    a[i][n].fnma(a[j][m], a[i][m] * a[j][n])
                }
            };
            for c in 0..D {
                solved[r][c] = cofactor.fma(b[k][c], solved[r][c]);
            }
        }
        for c in 0..D {
            solved[r][c] = solved[r][c] * inverse;
        }
    }
    solved
}

/// Velocities of the particles from `first` on.
///
/// # Safety
/// The rows are the caller's.
#[inline(always)]
unsafe fn velocities<const D: usize, E: Wide>(sweep: &Sweep, first: usize, count: usize) -> [E; D] {
    let mut velocity = [E::splat(0.0); D];
    for a in 0..D {
        // SAFETY: the rows are ours.
        velocity[a] = unsafe { E::load_some(sweep.rows.velocity.at(a, first), count) };
    }
    velocity
}

/// Keeps the first fault in memory.
#[cold]
fn note(report: &mut SweepReport, fault: Fault) {
    if report.fault.is_none_or(|known| fault.row < known.row) {
        report.fault = Some(fault);
    }
}

/// Stiffness and speed of neo-Hookean particles (see `neo_hookean::wave_modulus`).
#[inline(always)]
fn pace<const D: usize, E: Wide>(
    sweep: &Sweep,
    first: usize,
    count: usize,
    f: &[[E; D]; D],
    jacobian: E,
    velocity: &[E; D],
    extremes: &mut Extremes<E>,
) {
    let (one, two) = (E::splat(1.0), E::splat(2.0));
    let mut stretch = one;
    for i in 0..D {
        let mut row = dot(&f[i], &f[0]).abs();
        for j in 1..D {
            row = row + dot(&f[i], &f[j]).abs();
        }
        stretch = stretch.max(row);
    }
    let compression = (-jacobian.ln()).max(E::splat(0.0));
    let (lambda, mu) = lame::<E>(sweep, first, count);
    let at_rest = two.fma(mu, lambda);
    let stiffening = (two * mu).fma(stretch, lambda.fma(compression, lambda)) / at_rest;
    // SAFETY: the rows are ours.
    let density = unsafe { by_body::<E>(sweep, first, count, |body| body.density) };
    let speed = dot(velocity, velocity) * density / at_rest;
    // lanes without a particle say nothing
    let all = ((1u32 << count) - 1) as Mask;
    extremes.stiffening = extremes.stiffening.max(stiffening.select(all, one));
    extremes.speed = extremes.speed.max(speed.select(all, E::splat(0.0)));
}

#[inline(always)]
fn dot<const D: usize, E: Wide>(a: &[E; D], b: &[E; D]) -> E {
    let mut sum = a[0] * b[0];
    for k in 1..D {
        sum = a[k].fma(b[k], sum);
    }
    sum
}

/// Determinant of the deformation gradient; 1 across what is not there.
#[inline(always)]
pub(super) fn determinant<const D: usize, E: Wide>(f: &[[E; D]; D]) -> E {
    match D {
        1 => f[0][0],
        2 => f[0][1].fnma(f[1][0], f[0][0] * f[1][1]),
        _ => {
            let m0 = f[1][2].fnma(f[2][1], f[1][1] * f[2][2]);
            let m1 = f[1][2].fnma(f[2][0], f[1][0] * f[2][2]);
            let m2 = f[1][1].fnma(f[2][0], f[1][0] * f[2][1]);
            f[0][2].fma(m2, f[0][1].fnma(m1, f[0][0] * m0))
        }
    }
}

/// -V0 tau of `count` particles from `first` on, the first of which is number `at` of the chunk, times the kick where forces are merged with
/// momenta. It is symmetric: one half is enough.
///
/// # Safety
/// The rows are the caller's; there are at most [`LANES`].
#[inline(always)]
pub(super) unsafe fn stress<const D: usize, const W: usize, V: Real<Wide = E>, E: Wide>(
    sweep: &Sweep,
    plan: &Plan<W>,
    eight: &Eight<E, D>,
    first: usize,
    at: usize,
    count: usize,
    fields: &mut Fields<V::Number>,
) {
    let Some(task) = &sweep.scatter else { return };
    let scale = if let What::Kicked(kick) = task.what { kick } else { 1.0 };
    if !plan.stress_in_lanes || !task.relieved.is_empty() {
        // SAFETY: the rows are ours.
        unsafe { particle::stress_of_some::<D, V::Number>(sweep, scale, task.relieved, first, at, count, fields) };
        return;
    }
    // SAFETY: a number a particle.
    let weight = E::splat(-scale) * unsafe { E::load_some(sweep.rows.volume(first), count) };
    if plan.by_rate {
        for r in 0..D {
            for c in r..D {
                // SAFETY: the rows are ours.
                let tau = unsafe { E::load_some(sweep.rows.history.at(rate::COMPONENT[r][c], first), count) };
                store_eight::<V>(&mut fields.force[r][c], at, weight * tau);
            }
        }
        return;
    }
    let f = &eight.deformation;
    let (lambda, mu) = lame::<E>(sweep, first, count);
    let pressure = lambda.fma(determinant(f).ln(), -mu);
    for r in 0..D {
        for c in r..D {
            let b = dot(&f[r], &f[c]);
            let tau = if r == c { mu.fma(b, pressure) } else { mu * b };
            store_eight::<V>(&mut fields.force[r][c], at, weight * tau);
        }
    }
}

/// Lamé constants of the particles from `first` on.
#[inline(always)]
pub(super) fn lame<E: Wide>(sweep: &Sweep, first: usize, count: usize) -> (E, E) {
    let (lambda, mu) = (|body: &Body| body.material.lame().lambda, |body: &Body| body.material.lame().mu);
    // SAFETY: the rows are ours.
    unsafe { (by_body(sweep, first, count, lambda), by_body(sweep, first, count, mu)) }
}

/// A number that is known of bodies, for the particles from `first` on; lanes beyond `count` are those of the first body.
///
/// # Safety
/// The rows are the caller's.
#[inline(always)]
pub(super) unsafe fn by_body<E: Wide>(sweep: &Sweep, first: usize, count: usize, of: impl Fn(&Body) -> f64) -> E {
    let bodies = &sweep.model.bodies;
    let mut numbers = [of(&bodies[0]); LANES];
    if bodies.len() == 1 {
        return E::splat(numbers[0]);
    }
    for lane in 0..count {
        // SAFETY: the caller's promise.
        numbers[lane] = of(&bodies[unsafe { sweep.rows.body(first + lane) }]);
    }
    E::load_eight(&numbers)
}
