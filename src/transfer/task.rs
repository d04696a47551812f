//! What a sweep over the particles is to do, and what came of it.

use super::Rows;
use super::functions::AxisTable;
use crate::basis::Family;
use crate::material::Material;
use crate::model::Model;

/// What a sweep does: the particles take from the grid, give to it, or first the one and then the other.
#[derive(Clone, Copy)]
pub(crate) struct Sweep<'a> {
    pub(crate) model: &'a Model,
    pub(crate) rows: Rows<'a>,
    pub(crate) gather: Option<GatherTask<'a>>,
    pub(crate) scatter: Option<ScatterTask<'a>>,
    /// Whether the particles of each bin are first sorted by cell.
    pub(crate) tidy: bool,
}

/// What the particles take from the grid.
#[derive(Clone, Copy)]
pub(crate) struct GatherTask<'a> {
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
    /// Whether somebody asks for the work of the loads.
    pub(crate) work: bool,
    /// Whether the next step depends on wave and particle speed.
    pub(crate) pace: bool,
    /// Whether velocities and affine matrices are written to the particles; without, the scatter of the same sweep alone sees them.
    pub(crate) keep: bool,
}

impl GatherTask<'_> {
    /// A task that changes nothing yet: pure FLIP, no loads.
    pub(crate) const NOTHING: Self = Self {
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
        work: false,
        pace: false,
        keep: true,
    };

    /// Whether the accelerations of the nodes are used.
    pub(crate) fn needs_force(&self) -> bool {
        self.kick.is_some() && self.increment
    }
}

/// What the particles give to the grid.
#[derive(Clone, Copy)]
pub(crate) struct ScatterTask<'a> {
    pub(crate) what: What,
    /// Body force (an acceleration) of each particle \[m/s2\] by axis; empty where all particles have the same.
    pub(crate) body_force: &'a [Vec<f64>],
    /// Particles whose stress is integrated elsewhere; empty where there are none.
    pub(crate) relieved: &'a [bool],
}

impl ScatterTask<'_> {
    /// Whether what goes by a slope is packed with mass and momentum: merged with them, or to be added to a field of its own, which may
    /// wait where there is no `affine` matrix in its place.
    #[inline(always)]
    pub(crate) fn packs_stress(&self, affine: bool) -> bool {
        match self.what {
            What::MassMomentum => false,
            What::MassMomentumForce => !affine,
            What::Kicked(_) => true,
        }
    }
}

/// What is summed on the grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum What {
    MassMomentum,
    /// Forces too, in a field of their own.
    MassMomentumForce,
    /// Mass, and momentum after a kick of this length \[s\] by the forces.
    Kicked(f64),
}

/// What came of a sweep.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SweepReport {
    /// First particle in memory that failed.
    pub(crate) fault: Option<Fault>,
    /// Work of gravity and body forces \[J\].
    pub(crate) work: f64,
    /// Largest ratio of the wave modulus of a particle to that at rest.
    pub(crate) stiffening: f64,
    /// Largest square of the ratio of the speed of a particle to its wave speed at rest.
    pub(crate) speed: f64,
    /// Longest way of a particle along an axis \[cells\].
    pub(crate) way: f64,
    /// Runs of particles in one cell, one after the other in memory.
    pub(crate) runs: u64,
}

impl SweepReport {
    /// A sweep that found nothing.
    pub(crate) const NOTHING: Self = Self { fault: None, work: 0.0, stiffening: 0.0, speed: 0.0, way: 0.0, runs: 0 };

    /// At most the smallest ratio of the wave speed at time 0 to wave plus particle speed now.
    pub(crate) fn pace(&self) -> f64 {
        1.0 / (self.stiffening.max(1.0).sqrt() + self.speed.sqrt())
    }

    /// Takes over what comes later in memory.
    pub(crate) fn join(&mut self, later: &Self) {
        self.fault = self.fault.or(later.fault);
        self.work += later.work;
        self.stiffening = self.stiffening.max(later.stiffening);
        self.speed = self.speed.max(later.speed);
        // a way that is no number is kept
        self.way = if later.way > self.way || later.way.is_nan() { later.way } else { self.way };
        self.runs += later.runs;
    }
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

    /// What is wrong with a volume ratio that is not a positive number.
    pub(crate) fn of_jacobian(jacobian: f64) -> Self {
        if jacobian.is_finite() { Self::Inverted(jacobian) } else { Self::NotFinite }
    }
}

/// What a sweep asks of its scene once.
#[derive(Clone, Copy)]
pub(super) struct Plan<const W: usize> {
    /// The axes.
    pub(super) tables: [AxisTable<W>; 3],
    /// Whether the functions of the grid are B-splines.
    pub(super) splines: bool,
    /// Whether particles have domains.
    pub(super) domains: bool,
    /// Whether the particles are updated eight at a time: all of one of the two laws that are written for it, and
    /// nothing that is worked out for one at a time.
    pub(super) update_in_lanes: bool,
    /// Whether stresses are.
    pub(super) stress_in_lanes: bool,
    /// Whether their law is the Jaumann rate.
    pub(super) by_rate: bool,
}

impl<const W: usize> Plan<W> {
    pub(super) fn new(sweep: &Sweep) -> Self {
        let model = sweep.model;
        // axes that are not there are like the last
        let of = |a: usize| AxisTable::new(&model.axes[a.min(model.dimension - 1)]);
        let by_rate = model.bodies.iter().all(|body| matches!(body.material, Material::Hypo(_)));
        let by_potential = model.bodies.iter().all(|body| matches!(body.material, Material::NeoHookean(_)));
        let plain = (by_rate || by_potential) && !model.embedding.stress_free;
        let one_by_one = |task: &GatherTask| task.separation > 0.0 || by_rate && task.pace && task.strain.is_some();
        let update_in_lanes = plain && !sweep.gather.as_ref().is_some_and(one_by_one);
        let splines = matches!(model.axes[0].family(), Family::OpenSpline(_) | Family::UniformCubic);
        let domains = model.domains.is_some();
        Self { tables: [of(0), of(1), of(2)], splines, domains, update_in_lanes, stress_in_lanes: plain, by_rate }
    }
}
