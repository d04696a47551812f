//! The method of a scene in words.

use crate::model::{MassRule, Model};
use crate::scene::{Basis, Domain, Integrator, MassSolver, Method, Precision, Quadrature, Scene, Transfer};

pub(super) fn basis(scene: &Scene) -> String {
    let method = &scene.method;
    let nodes = |of: [usize; 3]| of[scene.dimension - 1];
    match method.basis {
        Basis::Bspline if method.spline_degree() > 1 => format!("B-splines of degree {}, open knots", method.spline_degree()),
        Basis::Linear | Basis::Bspline => "linear".into(),
        Basis::Lagrange => format!("quadratic Lagrange elements of {} nodes over two cells an axis", nodes([3, 9, 27])),
        Basis::Serendipity => format!("serendipity elements of {} nodes over two cells an axis", nodes([3, 8, 20])),
        Basis::Cubic => "uniform cubic splines, a row of nodes outside the grid".into(),
        Basis::Gimp if method.domain == Some(Domain::Uniform) => "GIMP, domains that keep their size".into(),
        Basis::Gimp => "GIMP, contiguous domains".into(),
    }
}

pub(super) fn quadrature(method: &Method) -> String {
    let place = match method.quadrature {
        Quadrature::Particles => return "particles".into(),
        Quadrature::Splines => "Gauss points, cubic splines through rows of particles",
        Quadrature::LeastSquares => "Gauss points of full cells, least-squares fits",
    };
    let what = if method.quadrature_of_velocity() { "forces and velocity projection" } else { "forces" };
    format!("{place} ({what})")
}

pub(super) fn transfer(model: &Model) -> String {
    let name = match model.transfer {
        _ if model.total => "none: velocity stays on the nodes".into(),
        Transfer::Pic => "PIC".into(),
        Transfer::Apic => "APIC".into(),
        Transfer::Asflip => {
            format!("ASFLIP, {} % of its own velocity, moves with {} % of it", 100.0 * model.flip_share, 100.0 * model.separation)
        }
        Transfer::Flip if model.flip_share == 1.0 => "FLIP".into(),
        Transfer::Flip => format!("FLIP {} %, PIC the rest", 100.0 * model.flip_share),
    };
    if model.precision == Precision::Single { name + ", in single precision" } else { name }
}

pub(super) fn integrator(integrator: Integrator) -> &'static str {
    match integrator {
        Integrator::Usf => "update stress first, leapfrog",
        Integrator::Usl => "update stress last, leapfrog",
        Integrator::Musl => "modified update stress last, leapfrog",
        Integrator::Verlet => "velocity Verlet",
        Integrator::Symplectic4 => "symplectic, of fourth order",
        Integrator::QuasiStatic => "quasi-static",
        Integrator::Newmark => "implicit, Newmark",
        Integrator::GeneralizedAlpha => "implicit, generalised alpha",
        Integrator::EnergyMomentum => "implicit, energy and momentum conserving",
    }
}

pub(super) fn mass(model: &Model) -> String {
    if model.total || model.implicit.is_some() {
        return if model.projection.is_lumped() { "lumped" } else { "consistent, factorised" }.into();
    }
    let rule = |rule: MassRule| match rule {
        MassRule::Lumped => "lumped".to_owned(),
        MassRule::Series(terms) => format!("FMPM({terms})"),
        MassRule::Solved { solver, residual } => {
            let solver = match solver {
                MassSolver::Pcg => "conjugate gradients",
                MassSolver::Direct => "conjugate gradients from a sparse factor",
                MassSolver::Richardson => "Richardson iteration",
            };
            format!("consistent, {solver} to {residual:e}")
        }
    };
    let (projection, balance) = (rule(model.projection), rule(model.balance));
    let matrices = if projection == balance { projection } else { format!("{projection}; in the balance of momentum {balance}") };
    let light = if model.needs.mass_matrix && model.lump_below > 0.0 {
        format!("; lumped at nodes below {:.3e} kg", model.lump_below)
    } else {
        String::new()
    };
    matrices + &light
}
