//! A scene that is wrong is refused with a message of its own: where it is wrong, what was found and what is allowed; by the
//! library and by the command, which exits with code 2 and writes no file.

#![expect(clippy::unwrap_used, reason = "a test may")]

use matpoint::scene::{Scene, SceneError};
use std::path::Path;
use std::process::{Command, Output};

const BEAM: &str = include_str!("bad_scenes/beam.toml");
const BAR: &str = include_str!("bad_scenes/bar.json");
const BAR_CSV: &str = include_str!("bad_scenes/bar.csv");

/// One change to a good scene: what it is, text to replace, text instead, and what the one fault must say after the file name.
type Case = (&'static str, &'static str, &'static str, &'static str);

/// Changes to `beam.toml`.
#[rustfmt::skip]
const BEAM_CASES: &[Case] = &[
    // structure
    ("missing key", "young = 1.0e6\n", "", ":10:11: material.rubber.young: is missing; must be a number"),
    ("missing table", "[time]\nend = 1.0\n", "", ":1:1: time: is missing; must be a table with the keys end, step, cfl"),
    ("unknown key", "density =", "densty =", ":14:1: material.rubber: unknown key `densty`; did you mean `density`?; allowed: law, young, poisson, density"),
    ("unknown key at the top", "[probe.tip]", "[probes.tip]", ":32:2: unknown key `probes`; did you mean `probe`?; allowed: title, dimension"),
    ("text for a number", "young = 1.0e6", "young = \"stiff\"", ":12:9: material.rubber.young: is the text \"stiff\"; must be a number"),
    ("number for text", "title = \"cantilever\"", "title = 7", ":2:9: title: is 7; must be text in quotes"),
    ("fraction for a whole number", "particles_per_cell = 2", "particles_per_cell = 2.5", ":19:22: body.beam.particles_per_cell: is 2.5; must be a whole number"),
    ("negative whole number", "dimension = 2", "dimension = -2", ":3:13: dimension: is -2; must be a whole number, not negative"),
    ("number for a list", "at = [8.0, 0.0]", "at = 8.0", ":33:6: probe.tip.at: is 8.0; must be a list of numbers"),
    ("text in a list", "origin = [0.0, -2.0]", "origin = [0.0, \"low\"]", ":6:16: grid.origin[1]: is the text \"low\"; must be a number"),
    ("list for a table", "[time]\nend = 1.0", "[[time]]\nend = 1.0", "time: is a list of 1; must be a table with the keys end, step, cfl"),
    ("date for a number", "end = 1.0", "end = 2024-01-01", ":39:7: time.end: is the date 2024-01-01; must be a number"),
    ("truth for a formula", "velocity = [0,", "velocity = [true,", ":20:13: body.beam.velocity[0]: is true; must be a number or a formula in quotes"),
    ("not a number", "young = 1.0e6", "young = nan", ":12:9: material.rubber.young: is NaN; must be a finite number"),
    ("infinite number", "end = 1.0", "end = inf", ":39:7: time.end: is inf; must be a finite number"),
    ("number too large to hold", "end = 1.0", "end = 1e999", ":39:7: time.end: is inf; must be a finite number"),
    ("unknown word", "law = \"neo_hookean\"", "law = \"neo_hokean\"", ":11:7: material.rubber.law: is \"neo_hokean\"; did you mean `neo_hookean`?; allowed: linear_elastic, hypo_elastic, neo_hookean, hencky"),
    ("unknown shape", "{ box =", "{ bx =", ":18:11: body.beam.shape: unknown kind `bx`; did you mean `box`?; allowed: box, disk, sphere, ring"),
    ("two shapes", "[8, 0.5] } }", "[8, 0.5] }, union = [] }", ":18:1: body.beam.shape: has the keys: box, union; must have exactly one of: box, disk"),
    ("no load", "gravity = [0, -9.81]\n", "", ":29:7: load.weight: has the keys: none; must have exactly one of: gravity, body_force, traction, pressure, point_force"),
    ("unknown signal", "gravity = [0, -9.81]", "gravity = \"externl\"", ":30:11: load.weight.gravity: is the text \"externl\"; must be a list of numbers or formulas in quotes, or a table with the keys time, value, or \"external\""),
    ("unknown axis", "fixed = [\"x\", \"y\"]", "fixed = [\"x\", \"w\"]", ":24:15: boundary.clamp.fixed[1]: is \"w\"; allowed: x, y, z"),
    ("unknown axis of a velocity", "fixed = [\"x\", \"y\"]", "velocity = { w = 1 }", ":24:14: boundary.clamp.velocity: unknown key `w`; allowed: x, y, z"),
    // TOML
    ("TOML: text without an end", "title = \"cantilever\"", "title = \"cantilever", ":2:20: is not TOML: invalid basic string"),
    ("TOML: a key twice", "dimension = 2", "dimension = 2\ndimension = 2", ":4:1: is not TOML: duplicate key"),
    ("TOML: no value", "cell = 0.5", "cell =", ":8:7: is not TOML: "),
    ("TOML: list without an end", "size = [10.0, 4.0]", "size = [10.0, 4.0", "is not TOML: "),
    // whole scene
    ("no dimension of this world", "dimension = 2", "dimension = 4", ":3:13: dimension: is 4; must be 1, 2 or 3"),
    ("name with a space", "[load.weight]", "[load.\"my weight\"]", ":29:7: load.my weight: the name \"my weight\" must be made of A-Z, a-z, 0-9, _ and -"),
    ("empty name", "[load.weight]", "[load.\"\"]", "the name \"\" must be made of"),
    // grid
    ("grid with too few components", "origin = [0.0, -2.0]", "origin = [0.0]", ":6:10: grid.origin: has 1 component; must have 2 in dimension 2"),
    ("grid of negative size", "size = [10.0, 4.0]", "size = [10.0, -4.0]", ":7:15: grid.size[1]: is -4; must be above 0"),
    ("cells of no size", "cell = 0.5", "cell = 0", ":8:8: grid.cell: is 0; must be above 0"),
    ("cells that do not fill the grid", "size = [10.0, 4.0]", "size = [10.2, 4.0]", ":7:9: grid.size[0]: is 10.2, which is 20.4 cells of 0.5; the nearest size that would do is 10"),
    ("grid of absurd size", "size = [10.0, 4.0]", "size = [1e12, 4.0]", ":7:9: grid.size[0]: makes 2e12 cells; must make at most 2^28"),
    // materials
    ("no stiffness", "young = 1.0e6", "young = 0", ":12:9: material.rubber.young: is 0; must be above 0"),
    ("negative density", "density = 1000.0", "density = -1000.0", ":14:11: material.rubber.density: is -1000; must be above 0"),
    ("incompressible", "poisson = 0.3", "poisson = 0.5", ":13:11: material.rubber.poisson: is 0.5; must be above -1 and below 0.5"),
    // bodies
    ("unknown material", "material = \"rubber\"", "material = \"ruber\"", ":17:12: body.beam.material: there is no material `ruber`; did you mean `rubber`?; allowed: rubber"),
    ("no particles in a cell", "particles_per_cell = 2", "particles_per_cell = 0", ":19:22: body.beam.particles_per_cell: is 0; must be 1 to 16"),
    ("too many particles in a cell", "particles_per_cell = 2", "particles_per_cell = [2, 17]", ":19:26: body.beam.particles_per_cell[1]: is 17; must be 1 to 16"),
    ("box upside down", "max = [8, 0.5]", "max = [8, -0.6]", ":18:46: body.beam.shape.box.max[1]: is -0.6; must be above min, which is -0.5"),
    ("body outside the grid", "max = [8, 0.5]", "max = [10.25, 0.5]", ":18:1: body.beam.shape: reaches 0.25 m outside the grid on side x+; the grid ends at 10"),
    ("velocity with too many components", "velocity = [0, \"0.1*x\"]", "velocity = [0, 0, 0]", ":20:12: body.beam.velocity: has 3 components; must have 2 in dimension 2"),
    ("velocity without a value", "\"0.1*x\"", "\"1/(x-4)\"", ":20:16: body.beam.velocity[1]: is inf at x = 4, y = 0, z = 0; must be finite"),
    // formulas
    ("formula with an unknown variable", "\"0.1*x\"", "\"0.1*t\"", ":20:16: body.beam.velocity[1]: is not a formula: \"0.1*t\": unknown variable `t`; allowed: x, y, z, PI, E, TAU"),
    ("formula with an unknown function", "sin(t)", "sine(t)", ":27:54: load.tip.traction.value[1]: is not a formula: \"-1e3*sine(t)\": unknown function `sine`; did you mean `sin`?"),
    ("formula without an end", "sin(t)", "sin(t", ") is wanted at the end"),
    ("formula with a number too large", "-1e3*", "-1e999*", "1e999 is too large for a number"),
    // boundaries
    ("boundary nowhere", "face = \"x-\"\n", "", ":22:11: boundary.clamp: has none of face, region and surface; must have one of them"),
    ("boundary in two ways", "face = \"x-\"\n", "face = \"x-\"\nregion = { disk = { center = [1, 0], radius = 1 } }\n", ":22:11: boundary.clamp: has face and region; must have one of"),
    ("boundary on no side", "face = \"x-\"", "face = \"left\"", ":23:8: boundary.clamp.face: is \"left\"; allowed: x-, x+, y-, y+"),
    ("boundary that holds nothing", "fixed = [\"x\", \"y\"]", "fixed = []", ":22:11: boundary.clamp: holds nothing; must have fixed or velocity"),
    ("boundary on an axis too many", "fixed = [\"x\", \"y\"]", "fixed = [\"z\"]", ":24:10: boundary.clamp.fixed[0]: is axis z; dimension 2 has x, y"),
    ("axis fixed and moved", "fixed = [\"x\", \"y\"]", "fixed = [\"x\"]\nvelocity = { x = \"t\" }", ":24:10: boundary.clamp.fixed[0]: fixes x, whose velocity is prescribed too"),
    ("boundary outside the grid", "face = \"x-\"", "region = { disk = { center = [-3, 0], radius = 1 } }", ":23:1: boundary.clamp.region: lies outside the grid"),
    // loads
    ("load on no body", "body = \"beam\"", "body = \"bean\"", ":27:21: load.tip.traction.body: there is no body `bean`; did you mean `beam`?; allowed: beam"),
    ("load on no face", "face = \"x+\"", "face = \"+x\"", ":27:36: load.tip.traction.face: body `beam` has no face `+x`; did you mean `x+`?; allowed: x-, x+, y-, y+"),
    ("load with too few components", "gravity = [0, -9.81]", "gravity = [-9.81]", ":30:11: load.weight.gravity: has 1 component; must have 2 in dimension 2"),
    ("table that goes back", "gravity = [0, -9.81]", "gravity = { time = [0, 2, 1], value = [[0, 1], [0, 2], [0, 3]] }", ":30:27: load.weight.gravity.time[2]: is 1 after 2; times must increase"),
    ("table with a row missing", "gravity = [0, -9.81]", "gravity = { time = [0, 1], value = [[0, 1]] }", ":30:36: load.weight.gravity.value: has 1 row for 2 times; must have as many"),
    ("empty table", "gravity = [0, -9.81]", "gravity = { time = [], value = [] }", ":30:20: load.weight.gravity.time: is empty; must have at least one row"),
    ("force on nothing", "gravity = [0, -9.81]", "point_force = { body = \"beam\", at = [4, 1.5], value = [0, 1] }", ":30:37: load.weight.point_force.at: is (4, 1.5), more than a cell outside body `beam`"),
    // probes, method, time, record, exact
    ("probe outside", "at = [8.0, 0.0]", "at = [9.0, 0.0]", ":33:6: probe.tip.at: is (9, 0), more than a cell outside body `beam`"),
    ("degree too high", "transfer = \"flip\"", "degree = 9", ":36:10: method.degree: is 9; must be 1 to 5"),
    ("degree of a linear basis", "transfer = \"flip\"", "basis = \"linear\"\ndegree = 2", ":37:10: method.degree: is for basis = \"bspline\" only"),
    ("share of another transfer", "transfer = \"flip\"", "transfer = \"apic\"\nflip_share = 0.9", ":37:14: method.flip_share: is for transfer = \"flip\" or \"asflip\" only"),
    ("separation of another transfer", "transfer = \"flip\"", "transfer = \"apic\"\nseparation = 0.9", ":37:14: method.separation: is for transfer = \"asflip\" only"),
    ("separation above one", "transfer = \"flip\"", "transfer = \"asflip\"\nintegrator = \"usl\"\nseparation = 1.5", "method.separation: is 1.5; must be 0 to 1"),
    ("separation after the kick", "transfer = \"flip\"", "transfer = \"asflip\"", "method.transfer: is \"asflip\": musl moves particles by what is projected after the kick"),
    ("separation with linear functions", "transfer = \"flip\"", "transfer = \"asflip\"\nintegrator = \"usl\"\nbasis = \"linear\"", "method.transfer: is \"asflip\": with linear functions"),
    ("separation with a full mass matrix", "transfer = \"flip\"", "transfer = \"asflip\"\nintegrator = \"usl\"\nmass = \"consistent\"", "method.transfer: is \"asflip\": it is made for the lumped mass"),
    ("share above one", "transfer = \"flip\"", "flip_share = 1.5", ":36:14: method.flip_share: is 1.5; must be 0 to 1"),
    ("domain of another basis", "transfer = \"flip\"", "domain = \"uniform\"", ":36:10: method.domain: is for basis = \"gimp\" only"),
    ("affine with elements", "transfer = \"flip\"", "transfer = \"apic\"\nbasis = \"lagrange\"", "method.transfer: is \"apic\": functions that are negative"),
    ("affine with a full mass matrix", "transfer = \"flip\"", "transfer = \"apic\"\nmass = \"consistent\"", "it is made for the lumped mass"),
    ("series without an order", "transfer = \"flip\"", "mass = \"fmpm\"", "method.fmpm_order: is missing; mass = \"fmpm\" needs it"),
    ("order without a series", "transfer = \"flip\"", "fmpm_order = 3", ":36:14: method.fmpm_order: is for mass = \"fmpm\" only"),
    ("order of one", "transfer = \"flip\"", "mass = \"fmpm\"\nfmpm_order = 1", "method.fmpm_order: is 1; must be 2 to 100"),
    ("series of negative masses", "transfer = \"flip\"", "mass = \"fmpm\"\nfmpm_order = 3\nbasis = \"serendipity\"", "is a series from the lumped mass"),
    ("solver of a lumped mass", "transfer = \"flip\"", "mass_solver = \"pcg\"", ":36:15: method.mass_solver: is for mass = \"consistent\" only"),
    ("residual too large", "transfer = \"flip\"", "mass = \"consistent\"\nmass_residual = 0.5", "method.mass_residual: is 0.5; must be above 0"),
    ("points of what", "transfer = \"flip\"", "quadrature_of = \"force\"", "method.quadrature_of: is for quadrature = \"splines\""),
    ("domains at points", "transfer = \"flip\"", "basis = \"gimp\"\nquadrature = \"splines\"", "method.quadrature: has points without a domain"),
    ("mass tolerance too high", "transfer = \"flip\"", "mass_tolerance = 1.5", ":36:18: method.mass_tolerance: is 1.5; must be 0 to 1"),
    ("single precision of the total formulation", "transfer = \"flip\"", "formulation = \"total\"\nprecision = \"single\"", ":37:13: method.precision: is \"single\", which is for formulation = \"updated\""),
    ("single precision of implicit steps", "transfer = \"flip\"\n\n[time]\nend = 1.0", "integrator = \"newmark\"\nprecision = \"single\"\n\n[time]\nend = 1.0\nstep = 1e-3", "method.precision: is \"single\", which does not go with integrator = \"newmark\""),
    ("single precision of a high degree", "transfer = \"flip\"", "degree = 4\nprecision = \"single\"", "method.precision: is \"single\", which is for linear functions and B-splines of degree up to 3"),
    ("single precision of elements", "transfer = \"flip\"", "basis = \"lagrange\"\nprecision = \"single\"", "method.precision: is \"single\", which is for linear functions and B-splines"),
    ("single precision of splines of forces", "transfer = \"flip\"", "quadrature = \"splines\"\nprecision = \"single\"", "method.precision: is \"single\", which is for quadrature = \"particles\""),
    ("single precision of a mass matrix", "transfer = \"flip\"", "mass = \"consistent\"\nprecision = \"single\"", "method.precision: is \"single\", which is for a lumped mass"),
    ("no such precision", "transfer = \"flip\"", "precision = \"half\"", ":36:13: method.precision: is \"half\""),
    ("run of no time", "end = 1.0", "end = 0", ":39:7: time.end: is 0; must be above 0"),
    ("negative step", "end = 1.0", "end = 1.0\nstep = -1e-3", ":40:8: time.step: is -0.001; must be above 0"),
    ("step and cfl", "end = 1.0", "end = 1.0\nstep = 1e-3\ncfl = 0.5", ":41:7: time.cfl: is given beside `step`; give one of the two"),
    ("cfl above one", "end = 1.0", "end = 1.0\ncfl = 1.5", ":40:7: time.cfl: is 1.5; must be above 0 and at most 1"),
    ("endless run", "end = 1.0", "end = 1.0\nstep = 1e-15", ":40:8: time.step: is 1e-15, which makes 1e15 steps; must make at most 1e12"),
    ("endless record", "[time]", "[record]\nevery = 1e-9\n[time]", ":39:9: record.every: is 1e-9, which makes 1e9 records; must make at most 1e7"),
    ("solution with too few components", "[time]", "[exact]\nvelocity = [1]\n[time]", ":39:12: exact.velocity: has 1 component; must have 2 in dimension 2"),
    ("solution with too many axes", "[time]", "[exact]\nstress = { xz = 1 }\n[time]", ":39:17: exact.stress.xz: is always zero in dimension 2"),
];

/// Other methods and times in place of those of the beam.
#[rustfmt::skip]
const METHOD_CASES: &[(&str, &str, &str, &str)] = &[
    ("integrator of the other formulation", "formulation = \"total\"\nintegrator = \"usl\"", "", "method.integrator: is \"usl\", which formulation = \"total\" does not have; allowed: verlet, symplectic4, quasi_static"),
    ("and the other way round", "integrator = \"verlet\"", "", "method.integrator: is \"verlet\", which formulation = \"updated\" does not have; allowed: usf, usl, musl, quasi_static"),
    ("implicit without a step", "integrator = \"newmark\"", "", ":38:2: time.step: is missing; an implicit integrator has no stable step to go by"),
    ("implicit with a share", "integrator = \"newmark\"", "error = 1e-3\ncfl = 0.5", "time.cfl: is for explicit integrators only; give `step`"),
    ("error of explicit steps", "formulation = \"total\"", "error = 1e-3", "time.error: is for implicit integrators only; leave it out"),
    ("error of nothing", "integrator = \"newmark\"", "error = 0", "time.error: is 0; must be above 0"),
    ("error without inertia", "integrator = \"quasi_static\"", "error = 1e-3", "time.error: is for integrators with inertia"),
    ("basis without a grid of its own", "formulation = \"total\"\nbasis = \"gimp\"", "", "method.basis: is \"gimp\"; formulation = \"total\" has linear, bspline"),
    ("transfer without particles that move", "formulation = \"total\"\ntransfer = \"apic\"", "", "method.transfer: is for formulation = \"updated\""),
    ("series in the total formulation", "formulation = \"total\"\nmass = \"fmpm\"\nfmpm_order = 2", "", "method.mass: is \"fmpm\"; formulation = \"total\" has lumped, consistent"),
    ("beta of another scheme", "integrator = \"generalized_alpha\"\nnewmark_beta = 0.3", "step = 0.1", "method.newmark_beta: is for integrator = \"newmark\" only"),
    ("gamma that blows up", "integrator = \"newmark\"\nnewmark_gamma = 0.4", "step = 0.1", "method.newmark_gamma: is 0.4; must be 0.5 to 1"),
    ("radius above one", "integrator = \"generalized_alpha\"\nspectral_radius = 1.1", "step = 0.1", "method.spectral_radius: is 1.1; must be 0 to 1"),
    ("residual of no solver", "newton_residual = 1e-8", "", "method.newton_residual: is for implicit integrators only"),
    ("residual below round-off", "integrator = \"newmark\"\nnewton_residual = 1e-20", "step = 0.1", "method.newton_residual: is 1e-20; must be 1e-14 to 0.01"),
    ("no iterations", "integrator = \"newmark\"\nnewton_iterations = 0", "step = 0.1", "method.newton_iterations: is 0; must be 1 to 1000"),
    ("iterations where there is no box", "integrator = \"newmark\"\nlinear_solver = \"iterative\"", "step = 0.1", "method.linear_solver: is \"iterative\", which is for implicit steps of formulation = \"total\""),
    ("solver of nothing", "linear_solver = \"direct\"", "", "method.linear_solver: is for implicit integrators only"),
    ("mean dilatation of particles that move", "mean_dilatation = true", "", "method.mean_dilatation: is for formulation = \"total\" only"),
    ("affine and implicit", "integrator = \"newmark\"\ntransfer = \"apic\"", "step = 0.1", "method.transfer: is \"apic\", which integrator = \"newmark\" does not have; take flip, pic"),
    ("separable and implicit", "integrator = \"newmark\"\ntransfer = \"asflip\"", "step = 0.1", "method.transfer: is \"asflip\", which integrator = \"newmark\" does not have; take flip, pic"),
    ("points and implicit", "integrator = \"newmark\"\nquadrature = \"splines\"", "step = 0.1", "method.quadrature: is \"splines\", which integrator = \"newmark\" does not have; take particles"),
];

/// Shapes in place of the box of the beam, with the traction taken away: its face is not there any more.
#[rustfmt::skip]
const SHAPE_CASES: &[(&str, &str, &str)] = &[
    ("empty body", "intersection = [{ disk = { center = [2, 0], radius = 1 } }, { disk = { center = [8, 0], radius = 1 } }]", "body.beam.shape: is empty: its parts have no point in common"),
    ("body between the particles", "disk = { center = [4, 0], radius = 0.01 }", "body.beam.shape: holds no particle, which would stand 0.25 x 0.25 apart"),
    ("body cut away", "difference = [{ disk = { center = [4, 0], radius = 1 } }, { disk = { center = [4, 0], radius = 2 } }]", "body.beam.shape: holds no particle"),
    ("body without end", "half_space = { point = [4, 0], normal = [0, 1] }", "body.beam.shape: has no end, as a half_space alone has none; make it an intersection with a box"),
    ("plane without a normal", "half_space = { point = [4, 0], normal = [0, 0] }", "body.beam.shape.half_space.normal: is zero; must point somewhere"),
    ("sphere in the plane", "sphere = { center = [4, 0], radius = 1 }", "body.beam.shape.sphere: is for dimension 3; the scene has dimension 2, use a disk"),
    ("disk of no size", "disk = { center = [4, 0], radius = 0 }", "body.beam.shape.disk.radius: is 0; must be above 0"),
    ("ring inside out", "ring = { center = [4, 0], inner = 2, outer = 1 }", "body.beam.shape.ring.outer: is 1; must be above inner, which is 2"),
    ("polygon of two corners", "polygon = { points = [[0, 0], [1, 1]] }", "body.beam.shape.polygon.points: has 2 corners; must have 3 to 10000"),
    ("polygon without area", "polygon = { points = [[0, 0], [1, 1], [2, 2]] }", "body.beam.shape.polygon.points: has no area"),
    ("polygon that crosses itself", "polygon = { points = [[0, 0], [1, 1], [1, 0], [0, 1]] }", "body.beam.shape.polygon.points: crosses itself: edge1 meets edge3"),
    ("polygon that is closed twice", "polygon = { points = [[0, 0], [1, 0], [1, 1], [0, 0]] }", "body.beam.shape.polygon.points[3]: repeats the first corner; leave it out"),
    ("union of nothing", "union = []", "body.beam.shape.union: has 0 parts; must have at least 1"),
    ("difference of one", "difference = [{ disk = { center = [4, 0], radius = 1 } }]", "body.beam.shape.difference: has 1 part; must have at least 2"),
];

/// Changes to `bar.json`.
#[rustfmt::skip]
const BAR_CASES: &[Case] = &[
    ("JSON: comment", "{ \"steel\"", "/* hard */ { \"steel\"", ":5:15: is not JSON: Comments are not allowed"),
    ("JSON: trailing comma", "{ \"end\": 1 }", "{ \"end\": 1, }", ":9:21: is not JSON: Trailing commas are not allowed"),
    ("JSON: no end", "{ \"end\": 1 }\n}", "{ \"end\": 1 }", "is not JSON: Unterminated object"),
    ("JSON: a key twice", "\"density\": 1", "\"density\": 1, \"density\": 2", ":5:81: key `density` is given twice"),
    ("JSON: null", "\"density\": 1", "\"density\": null", ":5:78: material.steel.density: is null; must be a number"),
    ("JSON: unknown key", "\"young\"", "\"yuong\"", ":5:53: material.steel: unknown key `yuong`; did you mean `young`?"),
    ("no body", "{ \"bar\": { \"material\": \"steel\", \"shape\": { \"box\": { \"min\": [0], \"max\": [1] } } } }", "{}", ":6:3: body: is empty; must have at least one body"),
    ("absurd number of particles", "\"cell\": 0.1", "\"cell\": 1e-8", ":6:43: body.bar.shape: holds about 2e8 particles, at 300 bytes each about 60 GB; must be at most 2^27 a body"),
    ("reference that is not there", "bar.csv", "rod.csv", "rod.csv\" cannot be read: No such file"),
];

/// What is no scene at all: name of the file, its bytes, what must be said.
#[rustfmt::skip]
fn files() -> Vec<(&'static str, Vec<u8>, &'static str)> {
    let text = |text: &str| text.as_bytes().to_vec();
    vec![
        ("empty.toml", text(""), "empty.toml:1:1: title: is missing; must be text in quotes"),
        ("empty.json", text(""), "empty.json:1:1: is not JSON: there is no value"),
        ("list.json", text("[1, 2]"), "list.json:1:1: is a list of 2; must be a table with the keys title, dimension"),
        ("garbage.toml", (0..=255).collect(), "garbage.toml: is not text: byte 129 is not UTF-8"),
        ("zeros.toml", vec![0; 64], "zeros.toml:1:65: is not TOML: key with no value"),
        ("deep.toml", text(&format!("a = {}{}", "[".repeat(70), "]".repeat(70))), "deep.toml:1:69: is nested deeper than 64 tables and lists"),
        ("deeper.toml", text(&format!("a = {}", "[".repeat(100_000))), "is nested deeper than 64 tables and lists"),
        ("deep_key.toml", text(&format!("{}a = 1", "a.".repeat(100_000))), "is nested deeper than 64 tables and lists"),
        ("deep.json", text(&"[".repeat(100_000)), "is nested deeper than 64 tables and lists"),
        ("large.toml", vec![b' '; (16 << 20) + 1], "large.toml: has more than 16777216 bytes; that is no scene"),
        ("scene.yaml", text(BEAM), "scene.yaml: the name of a scene file must end in .toml or .json"),
        ("scene", text(BEAM), "scene: the name of a scene file must end in .toml or .json"),
    ]
}

/// Replaces the one place where `from` stands.
fn change(text: &str, from: &str, to: &str) -> String {
    assert_eq!(text.matches(from).count(), 1, "{from:?} must stand in the good scene once");
    text.replacen(from, to, 1)
}

/// What the library says of a file, which must be wrong.
fn refusal(file: &Path) -> SceneError {
    Scene::load(file).err().unwrap_or_else(|| panic!("{} must be refused", file.display()))
}

/// Writes a scene beside its reference, checks that it has just the one fault that is expected, and that the command says so.
fn refused(case: &str, name: &str, text: &str, says: &str) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join(name);
    std::fs::write(&file, text).unwrap();
    std::fs::write(folder.path().join("bar.csv"), BAR_CSV).unwrap();
    let error = refusal(&file);
    assert_eq!(error.faults().len(), 1, "{case}: {error}");
    assert!(error.to_string().contains(says), "{case}: {error}\nmust contain {says}");
    command_refuses(&file, says);
}

/// Both ways to give the command a file end with code 2, the fault on stderr and no file.
fn command_refuses(file: &Path, says: &str) {
    let out = tempfile::tempdir().unwrap();
    let matpoint = || Command::new(env!("CARGO_BIN_EXE_matpoint"));
    let check = matpoint().arg("check").arg(file).output().unwrap();
    let run = matpoint()
        .arg("run")
        .arg(file)
        .args(["--record".as_ref(), out.path().join("x.svg").as_os_str(), "--csv".as_ref(), out.path().as_os_str()])
        .output()
        .unwrap();
    for Output { status, stderr, .. } in [check, run] {
        let stderr = String::from_utf8(stderr).unwrap();
        assert_eq!(status.code(), Some(2), "{}: {stderr}", file.display());
        assert!(stderr.contains(says), "{stderr}\nmust contain {says}");
    }
    assert_eq!(std::fs::read_dir(out.path()).unwrap().count(), 0, "{}: a refused scene must leave no file", file.display());
}

#[test]
fn the_scenes_that_the_cases_change_are_good() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/bad_scenes");
    for name in ["beam.toml", "bar.json"] {
        Scene::load(folder.join(name)).unwrap_or_else(|error| panic!("{error}"));
    }
}

#[test]
fn each_fault_has_its_own_message_and_place() {
    for (case, from, to, says) in BEAM_CASES {
        refused(case, "beam.toml", &change(BEAM, from, to), &placed("beam.toml", says));
    }
    for (case, from, to, says) in BAR_CASES {
        refused(case, "bar.json", &change(BAR, from, to), &placed("bar.json", says));
    }
}

/// Puts the name of the file before a place.
fn placed(name: &str, says: &str) -> String {
    if says.starts_with(':') { format!("{name}{says}") } else { says.to_string() }
}

#[test]
fn methods_that_make_no_sense_are_refused() {
    for (case, method, time, says) in METHOD_CASES {
        let text = change(BEAM, "transfer = \"flip\"\n\n[time]\nend = 1.0", &format!("{method}\n\n[time]\nend = 1.0\n{time}"));
        refused(case, "beam.toml", &text, &says.replace(":38:", &format!(":{}:", 37 + method.lines().count())));
    }
    let word = change(BEAM, "[method]\ntransfer = \"flip\"\n", "");
    refused(
        "automatic",
        "beam.toml",
        &format!("method = \"automatic\"\n{word}"),
        ":1:10: method: is the text \"automatic\"; must be a table",
    );
}

#[test]
fn shapes_that_make_no_sense_are_refused() {
    let beam = change(BEAM, "traction = { body = \"beam\", face = \"x+\", value = [0, \"-1e3*sin(t)\"] }", "gravity = \"external\"");
    let beam = change(&beam, "[probe.tip]\nat = [8.0, 0.0]\n", "");
    for (case, shape, says) in SHAPE_CASES {
        let text = change(&beam, "box = { min = [0, -0.5], max = [8, 0.5] }", shape);
        refused(case, "beam.toml", &text, says);
    }
}

#[test]
fn what_is_no_scene_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes, says) in files() {
        let file = folder.path().join(name);
        std::fs::write(&file, bytes).unwrap();
        let error = refusal(&file).to_string();
        assert!(error.contains(says), "{name}: {error}\nmust contain {says}");
        command_refuses(&file, says);
    }
    let missing = folder.path().join("missing.toml");
    let directory = folder.path().join("folder.toml");
    std::fs::create_dir(&directory).unwrap();
    for (file, says) in
        [(missing, "missing.toml: cannot be read: No such file"), (directory, "folder.toml: cannot be read: Is a directory")]
    {
        assert!(matches!(refusal(&file), SceneError::Read { .. }));
        assert!(refusal(&file).to_string().contains(says));
        command_refuses(&file, says);
    }
}

#[test]
fn a_reference_is_read_and_checked() {
    let cases = [
        ("", "has the first line \"\"; must be \"time_s,X_m,displacement_m,velocity_m_s,stress_Pa\""),
        ("t,X\n0,0\n", "has the first line \"t,X\"; must be"),
        ("time_s,X_m,displacement_m,velocity_m_s,stress_Pa\n", "has no rows"),
        ("time_s,X_m,displacement_m,velocity_m_s,stress_Pa\n0,0,0,0\n", "has \"0,0,0,0\" on line 2; must be 5 finite numbers"),
        ("time_s,X_m,displacement_m,velocity_m_s,stress_Pa\n0,0,0,0,nan\n", "has \"0,0,0,0,nan\" on line 2; must be 5 finite numbers"),
    ];
    for (csv, says) in cases {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("bar.json"), BAR).unwrap();
        std::fs::write(folder.path().join("bar.csv"), csv).unwrap();
        let error = refusal(&folder.path().join("bar.json")).to_string();
        assert!(error.contains("bar.json:8:69: exact.reference: ") && error.contains(says), "{error}\nmust contain {says}");
    }
}

#[test]
fn all_faults_are_reported_at_once_and_in_order() {
    let structure = change(&change(BEAM, "law = \"neo_hookean\"", "law = 3"), "[time]\nend = 1.0", "[time]\nend = \"late\"\nstop = 2");
    let meaning =
        change(&change(&change(BEAM, "young = 1.0e6", "young = -1"), "cell = 0.5", "cell = 0.3"), "face = \"x-\"", "face = \"z-\"");
    let dimension = change(BEAM, "dimension = 2", "dimension = 3\nplane = \"stress\"");
    let cases: [(&str, &[&str]); 3] = [
        (&structure, &["11:7: material.rubber.law: is 3", "39:7: time.end: is the text \"late\"", "40:1: time: unknown key `stop`"]),
        (
            &meaning,
            &[
                "7:9: grid.size[0]: is 10, which is 33.3333 cells of 0.3; the nearest size that would do is 9.9",
                "7:15: grid.size[1]",
                "12:9: material.rubber.young",
                "23:8: boundary.clamp.face: is \"z-\"",
            ],
        ),
        (
            &dimension,
            &[
                "4:9: plane: is \"stress\", which has no meaning in dimension 3",
                "7:10: grid.origin: has 2 components; must have 3",
                "8:8: grid.size: has 2 components",
                "19:25: body.beam.shape.box.min: has 2 components",
                "19:42: body.beam.shape.box.max: has 2 components",
                "21:12: body.beam.velocity: has 2 components",
                "28:50: load.tip.traction.value: has 2 components",
                "31:11: load.weight.gravity: has 2 components",
                "34:6: probe.tip.at: has 2 components",
            ],
        ),
    ];
    for (text, wanted) in cases {
        let error = Scene::from_toml(text).unwrap_err();
        let found: Vec<String> = error.to_string().lines().map(String::from).collect();
        assert_eq!(found.len(), wanted.len(), "{error}");
        for (line, start) in found.iter().zip(wanted) {
            assert!(line.starts_with(start), "{line}\nmust start with {start}");
        }
    }
}

#[test]
fn scenes_built_in_code_are_checked_too() {
    let mut scene = Scene::from_toml(BEAM).unwrap();
    scene.grid.origin[1] = f64::NAN;
    scene.material["rubber"].density = f64::INFINITY;
    let error = scene.check().unwrap_err().to_string();
    assert!(error.contains("material.rubber.density: is inf; must be above 0 and finite"), "{error}");
    assert!(error.contains("grid.origin: has NaN as component 1; must be finite numbers"), "{error}");
}
