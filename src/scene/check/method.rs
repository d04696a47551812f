//! Methods that make no sense, and those that are seldom wise.

use super::super::fault::plain;
use super::super::{Basis, Fault, Integrator, Law, LinearSolver, Mass, Method, Plane, Positions, Precision, Quadrature, Scene, Transfer};
use super::Check;
use crate::transfer::WIDEST_SINGLE;

/// Most terms of FMPM.
const MOST_TERMS: usize = 100;
/// Largest relative residual of a mass matrix that still is a solution.
const LARGEST_RESIDUAL: f64 = 1e-2;

impl Check<'_> {
    pub(super) fn method(&mut self) {
        let method = &self.scene.method;
        if let Some(error) = self.scene.time.error {
            self.positive("time.error", error);
        }
        if method.auto {
            // what is chosen is checked once it is
            let plain = *method == Method { auto: true, ..Method::default() };
            self.require(plain, "method", || "is automatic, and so leaves no choice; take away `auto`, or all else".into());
            return;
        }
        if let Some(degree) = method.degree {
            self.require(method.basis == Basis::Bspline, "method.degree", || "is for basis = \"bspline\" only; leave it out".into());
            self.require((1..=5).contains(&degree), "method.degree", || format!("is {degree}; must be 1 to 5"));
        }
        self.require(method.domain.is_none() || method.basis == Basis::Gimp, "method.domain", || {
            "is for basis = \"gimp\" only; leave it out".into()
        });
        if let Some(share) = method.flip_share {
            let flips = matches!(method.transfer, Transfer::Flip | Transfer::Asflip);
            self.require(flips, "method.flip_share", || "is for transfer = \"flip\" or \"asflip\" only; leave it out".into());
            self.require((0.0..=1.0).contains(&share), "method.flip_share", || format!("is {}; must be 0 to 1", plain(share)));
        }
        if let Some(share) = method.separation {
            let asflip = method.transfer == Transfer::Asflip;
            self.require(asflip, "method.separation", || "is for transfer = \"asflip\" only; leave it out".into());
            self.require((0.0..=1.0).contains(&share), "method.separation", || format!("is {}; must be 0 to 1", plain(share)));
        }
        let blends = method.transfer == Transfer::Flip && method.flip_share.is_some_and(|share| share > 0.0 && share < 1.0);
        self.require(!(blends && method.has_kinks() && method.integrator() == Integrator::Usl), "method.flip_share", || {
            "blends FLIP and PIC, which with linear functions and USL throws nearly empty nodes out; take musl or usf, or B-splines".into()
        });
        if let Some(tolerance) = method.mass_tolerance {
            self.require((0.0..=1.0).contains(&tolerance), "method.mass_tolerance", || format!("is {}; must be 0 to 1", plain(tolerance)));
        }
        self.integrator();
        self.formulation();
        self.precision();
        self.mass();
        if !method.is_total() {
            self.affine();
            self.quadrature();
            self.contact();
        }
    }

    fn integrator(&mut self) {
        let method = &self.scene.method;
        let (integrator, total) = (method.integrator(), method.is_total());
        let fits = integrator.is_implicit() || integrator.is_updated() != total;
        self.require(fits, "method.integrator", || {
            let name = word(&integrator);
            let explicit = if total { "verlet, symplectic4" } else { "usf, usl, musl" };
            let formulation = word(&method.formulation);
            format!(
                "is \"{name}\", which formulation = \"{formulation}\" does not have; allowed: {explicit}, quasi_static, newmark, \
                 generalized_alpha, energy_momentum"
            )
        });
        let only = |this: Integrator| integrator == this;
        for (path, value, has, least, most, of) in [
            ("method.newmark_beta", method.newmark_beta, only(Integrator::Newmark), 1e-3, 0.5, "newmark"),
            ("method.newmark_gamma", method.newmark_gamma, only(Integrator::Newmark), 0.5, 1.0, "newmark"),
            ("method.spectral_radius", method.spectral_radius, only(Integrator::GeneralizedAlpha), 0.0, 1.0, "generalized_alpha"),
            ("method.newton_residual", method.newton_residual, integrator.is_implicit(), 1e-14, 1e-2, ""),
        ] {
            let Some(value) = value else { continue };
            self.require(has, path, || match of {
                "" => "is for implicit integrators only; leave it out".into(),
                of => format!("is for integrator = \"{of}\" only; leave it out"),
            });
            self.require((least..=most).contains(&value), path, || {
                format!("is {}; must be {} to {}", plain(value), plain(least), plain(most))
            });
        }
        if let Some(iterations) = method.newton_iterations {
            self.require(integrator.is_implicit(), "method.newton_iterations", || "is for implicit integrators only; leave it out".into());
            self.require((1..=1000).contains(&iterations), "method.newton_iterations", || format!("is {iterations}; must be 1 to 1000"));
        }
        let symmetric = integrator != Integrator::EnergyMomentum && self.scene.material.values().all(|m| m.law != Law::HypoElastic);
        let iterates = total && integrator.is_implicit() && !method.mean_dilatation && symmetric;
        self.require(iterates || method.linear_solver != Some(LinearSolver::Iterative), "method.linear_solver", || {
            "is \"iterative\", which is for implicit steps of formulation = \"total\", without mean_dilatation, energy_momentum and hypo_elastic; \
             take direct".into()
        });
        self.require(integrator.is_implicit() || method.linear_solver.is_none(), "method.linear_solver", || {
            "is for implicit integrators only; leave it out".into()
        });
        if integrator.is_implicit() {
            let time = &self.scene.time;
            self.require(time.step.is_some() || time.error.is_some(), "time.step", || {
                "is missing; an implicit integrator has no stable step to go by: give it, or `error`".into()
            });
            self.require(time.cfl.is_none(), "time.cfl", || "is for explicit integrators only; give `step`".into());
        }
        if self.scene.time.error.is_some() {
            self.require(integrator.is_implicit(), "time.error", || "is for implicit integrators only; leave it out".into());
            self.require(integrator != Integrator::QuasiStatic, "time.error", || {
                "is for integrators with inertia: a balance of forces does not depend on the steps that led to it; give `step`".into()
            });
        }
        let rate = self.scene.material.iter().find(|(_, m)| m.law == Law::HypoElastic);
        if let (Some((name, _)), Integrator::EnergyMomentum) = (rate, integrator) {
            let message = "is \"energy_momentum\", but the law of material";
            self.fault("method.integrator", format!("{message} `{name}` has no stored energy; take another integrator or law"));
        }
    }

    /// What the total formulation and implicit steps do not have.
    fn formulation(&mut self) {
        let method = &self.scene.method;
        if method.mean_dilatation {
            self.mean_dilatation();
        }
        if !method.is_total() {
            if method.integrator().is_implicit() {
                self.implicit();
            }
            return;
        }
        let plain = Method::default();
        self.require(matches!(method.basis, Basis::Linear | Basis::Bspline), "method.basis", || {
            let name = word(&method.basis);
            format!("is \"{name}\"; formulation = \"total\" has linear, bspline")
        });
        self.require(method.quadrature == plain.quadrature, "method.quadrature", || {
            "is for formulation = \"updated\"; in \"total\" the particles stand at Gauss points themselves; leave it out".into()
        });
        self.require(method.transfer == plain.transfer && method.flip_share.is_none(), "method.transfer", || {
            "is for formulation = \"updated\"; in \"total\" velocity stays on the nodes; leave it out".into()
        });
        for (name, body) in &self.scene.body {
            let folded = crate::model::Quadrilateral::new(&body.shape).is_some_and(|map| !map.is_convex());
            self.require(!folded, &format!("body.{name}.shape"), || {
                "is a polygon of four corners that is not convex; formulation = \"total\" bends its grid to it, so it must be".into()
            });
        }
        for (path, given) in [
            ("method.quadrature_of", method.quadrature_of.is_some()),
            ("method.balance_mass", method.balance_mass.is_some()),
            ("method.mass_solver", method.mass_solver.is_some()),
            ("method.mass_residual", method.mass_residual.is_some()),
            ("method.mass_tolerance", method.mass_tolerance.is_some()),
        ] {
            self.require(!given, path, || "is for formulation = \"updated\"; leave it out".into());
        }
        self.require(method.mass() != Mass::Fmpm, "method.mass", || "is \"fmpm\"; formulation = \"total\" has lumped, consistent".into());
        self.require(self.scene.contact.is_none(), "contact", || {
            "is for formulation = \"updated\": each body has a grid of its own in \"total\", and bodies do not see each other".into()
        });
    }

    fn mean_dilatation(&mut self) {
        let scene = self.scene;
        let path = "method.mean_dilatation";
        let why = if !scene.method.is_total() {
            "is for formulation = \"total\" only"
        } else if self.dimension == 1 || scene.plane == Plane::Stress {
            "is for bodies that cannot change their volume freely: dimension 3, or 2 in plane strain"
        } else if scene.material.values().any(|m| matches!(m.law, Law::LinearElastic | Law::HypoElastic)) {
            "is for the laws neo_hookean and hencky"
        } else if scene.method.integrator() == Integrator::EnergyMomentum {
            "does not go with integrator = \"energy_momentum\""
        } else {
            return;
        };
        self.fault(path, format!("{why}; leave it out"));
    }

    /// What implicit steps of the updated formulation do not have.
    fn implicit(&mut self) {
        let method = &self.scene.method;
        let integrator = word(&method.integrator());
        let why = |what: &str| format!("{what} integrator = \"{integrator}\" does not have");
        self.require(matches!(method.basis, Basis::Linear | Basis::Bspline), "method.basis", || {
            format!("{}; take linear, bspline", why(&format!("is \"{}\", which", word(&method.basis))))
        });
        self.require(method.quadrature == Quadrature::Particles, "method.quadrature", || {
            format!("{}; take particles", why(&format!("is \"{}\", which", word(&method.quadrature))))
        });
        self.require(!method.transfer.is_affine(), "method.transfer", || {
            format!("{}; take flip, pic", why(&format!("is \"{}\", which", word(&method.transfer))))
        });
        let plain = |mass: Mass| mass != Mass::Fmpm;
        self.require(plain(method.mass()) && method.balance_mass.is_none(), "method.mass", || {
            format!("{}; take lumped, consistent, and no balance_mass", why("is one which"))
        });
        self.require(self.scene.contact.is_none(), "contact", || why("is what"));
    }

    /// What transfers in single precision do not have.
    fn precision(&mut self) {
        let method = &self.scene.method;
        let is_spline = matches!(method.basis, Basis::Linear | Basis::Bspline);
        let most = WIDEST_SINGLE - 1;
        let reason = if method.precision == Precision::Double {
            return;
        } else if method.is_total() {
            "is for formulation = \"updated\": in \"total\" nothing travels between particles and grid".into()
        } else if method.integrator().is_implicit() {
            format!("does not go with integrator = \"{}\", which balances forces to more digits than it has", word(&method.integrator()))
        } else if !is_spline || method.basis == Basis::Bspline && method.spline_degree() > most {
            format!("is for linear functions and B-splines of degree up to {most}")
        } else if method.quadrature != Quadrature::Particles {
            "is for quadrature = \"particles\"".into()
        } else if method.mass() != Mass::Lumped || method.mass_of_balance() != Mass::Lumped {
            "is for a lumped mass".into()
        } else {
            return;
        };
        self.fault("method.precision", format!("is \"single\", which {reason}; take it away"));
    }

    fn mass(&mut self) {
        let method = &self.scene.method;
        let masses = [("method.mass", method.mass()), ("method.balance_mass", method.mass_of_balance())];
        let uses = |mass: Mass| masses.iter().any(|(_, m)| *m == mass);
        match method.fmpm_order {
            None => self.require(!uses(Mass::Fmpm), "method.fmpm_order", || "is missing; mass = \"fmpm\" needs it, from 2 on".into()),
            Some(order) => {
                self.require(uses(Mass::Fmpm), "method.fmpm_order", || "is for mass = \"fmpm\" only; leave it out".into());
                self.require((2..=MOST_TERMS).contains(&order), "method.fmpm_order", || format!("is {order}; must be 2 to {MOST_TERMS}"))
            }
        };
        let solved = uses(Mass::Consistent);
        for (given, path) in
            [(method.mass_solver.is_some(), "method.mass_solver"), (method.mass_residual.is_some(), "method.mass_residual")]
        {
            self.require(solved || !given, path, || "is for mass = \"consistent\" only; leave it out".into());
        }
        if let Some(residual) = method.mass_residual {
            self.require(residual > 0.0 && residual <= LARGEST_RESIDUAL, "method.mass_residual", || {
                format!("is {}; must be above 0 and at most {}", plain(residual), plain(LARGEST_RESIDUAL))
            });
        }
        let direct = method.mass_solver == Some(super::super::MassSolver::Direct);
        self.require(!direct || method.quadrature_of_velocity(), "method.mass_solver", || {
            "is \"direct\", which is for a mass matrix that is integrated in cells; give quadrature_of = \"force_and_velocity\", or take pcg"
                .into()
        });
        let negative = matches!(method.basis, Basis::Lagrange | Basis::Serendipity);
        let series = uses(Mass::Fmpm) || method.mass_solver == Some(super::super::MassSolver::Richardson);
        self.require(!(negative && series), "method.mass", || {
            "is a series from the lumped mass, which Lagrange and serendipity elements can have negative; take mass_solver = \"pcg\"".into()
        });
    }

    /// APIC and ASFLIP sum momentum with arms, and divide by second moments.
    fn affine(&mut self) {
        let method = &self.scene.method;
        let asflip = method.transfer == Transfer::Asflip;
        let reason = if !method.transfer.is_affine() {
            return;
        } else if matches!(method.basis, Basis::Lagrange | Basis::Serendipity) {
            "functions that are negative have second moments that vanish; take another basis or transfer"
        } else if method.mass() != Mass::Lumped || method.mass_of_balance() != Mass::Lumped {
            "it is made for the lumped mass: a full matrix would count the affine part twice; take flip"
        } else if method.quadrature_of_velocity() {
            "the affine part lives at particles; take flip, or quadrature_of = \"force\""
        } else if asflip && method.has_kinks() {
            "with linear functions nearly empty nodes throw particles out that keep their own velocity; take another basis, or apic"
        } else if asflip && method.integrator() == Integrator::Musl {
            "musl moves particles by what is projected after the kick, when what the grid has not got of their velocity is gone; \
             take integrator = \"usl\" or \"usf\""
        } else {
            return;
        };
        self.fault("method.transfer", format!("is \"{}\": {reason}", word(&method.transfer)));
    }

    fn quadrature(&mut self) {
        let scene = self.scene;
        let method = &scene.method;
        let particles = method.quadrature == Quadrature::Particles;
        self.require(method.quadrature_of.is_none() || !particles, "method.quadrature_of", || {
            "is for quadrature = \"splines\" or \"least_squares\"; leave it out".into()
        });
        self.require(particles || method.basis != Basis::Gimp, "method.quadrature", || {
            "has points without a domain, which basis = \"gimp\" needs; take another basis".into()
        });
        for (name, body) in &scene.body {
            let path = format!("body.{name}.positions");
            let positions = scene.positions(body);
            // in one dimension any order of particles is a row
            let rows = positions == Positions::Uniform || self.dimension == 1 && positions == Positions::Jittered;
            self.require(method.quadrature != Quadrature::Splines || rows, &path, || {
                "must be \"uniform\": quadrature = \"splines\" needs even rows of particles; or take quadrature = \"least_squares\"".into()
            });
            self.require(method.basis != Basis::Gimp || positions != Positions::Gauss, &path, || {
                "is \"gauss\", but the domains of basis = \"gimp\" are equal parts of a cell; take \"uniform\"".into()
            });
        }
    }

    fn contact(&mut self) {
        let Some(contact) = &self.scene.contact else { return };
        let friction = contact.friction;
        self.require(friction >= 0.0 && friction.is_finite(), "contact.friction", || format!("is {}; must be 0 or more", plain(friction)));
        let bodies = self.scene.body.len();
        let negative = matches!(self.scene.method.basis, Basis::Lagrange | Basis::Serendipity);
        self.require(!negative, "contact", || {
            "exchanges momentum by nodal masses, which Lagrange and serendipity elements can have negative; take another basis".into()
        });
        self.require(bodies > 1, "contact", || format!("needs two bodies or more, and there is {bodies}; leave it out"));
    }

    /// Elements span two cells.
    pub(super) fn method_on_grid(&mut self) {
        let basis = self.scene.method.basis;
        self.require(basis != Basis::Serendipity || self.dimension > 1, "method.basis", || {
            "is \"serendipity\", which has no element in dimension 1; take \"lagrange\"".into()
        });
        let Some(cells) = self.cells.clone().filter(|_| matches!(basis, Basis::Lagrange | Basis::Serendipity)) else { return };
        for (axis, size) in self.scene.grid.size.iter().enumerate() {
            let count = (size / cells.size[axis]).round();
            self.require(count % 2.0 == 0.0, &format!("grid.size[{axis}]"), || {
                format!("makes {count} cells; Lagrange and serendipity elements span two, so it must be an even number")
            });
        }
    }
}

/// Methods that can be simulated but are seldom wise.
pub(super) fn warnings(scene: &Scene) -> Vec<Fault> {
    let method = &scene.method;
    let mut warnings = Vec::new();
    let full = method.mass() != Mass::Lumped || method.mass_of_balance() != Mass::Lumped;
    if full && !method.is_total() && !method.quadrature_of_velocity() {
        let mass = if method.mass() == Mass::Lumped { "method.balance_mass" } else { "method.mass" };
        warnings.push(Fault::new(
            mass,
            "is not lumped, but mass and momentum are summed at the particles: without the smoothing of the lumped mass the error of that \
             sum shows, and the solution stops to converge, its stress first; quadrature = \"splines\" (or \"least_squares\") with \
             quadrature_of = \"force_and_velocity\" integrates as well as the matrix",
        ));
    }
    warnings
}

/// How a choice is written in a scene.
fn word(choice: &impl serde::Serialize) -> String {
    serde_json::to_value(choice).ok().and_then(|value| value.as_str().map(str::to_owned)).unwrap_or_default()
}
