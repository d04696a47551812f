//! `matpoint` simulates elastic solids with the material point method (MPM), made to be stepped by somebody else: loads in, `step(dt)`,
//! state out.
//!
//! ```
//! use matpoint::scene::Scene;
//!
//! let scene = Scene::from_toml(r#"
//!     title = "a bar behind a controller"
//!     dimension = 1
//!     grid = { origin = [0], size = [1.5], cell = 0.1 }
//!     material.rubber = { law = "neo_hookean", young = 1e5, density = 1e3 }
//!     body.bar = { material = "rubber", shape = { box = { min = [0], max = [1] } } }
//!     boundary.wall = { face = "x-", fixed = ["x"] }
//!     load.tip.traction = { body = "bar", face = "x+", value = "external" }
//!     probe.tip = { at = [1] }
//!     time = { end = 1 }
//! "#)?;
//! let mut sim = scene.build()?;
//! for _ in 0..20 {
//!     let stretch = sim.get("probe/tip/displacement")?[0];          // [m]
//!     sim.set("load/tip/traction", &[1e3 - 2e4 * stretch])?;        // held over the coming step [Pa]
//!     let report = sim.step(0.01)?;                                 // substeps inside; lands exactly on t + 0.01
//!     assert!(report.substeps >= 1);
//! }
//! assert!(sim.get("probe/tip/displacement")?[0] > 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # The rooms, in the order in which data passes through them
//!
//! | room | what |
//! |---|---|
//! | [`scene`] | 1 DESCRIBE: the user's words, read from TOML or JSON; every fault is found at once |
//! | `model` | 2 COMPILE: Scene -> Model, immutable tables, and what this scene needs (and so what it does not); loads |
//! | `state` | 3 EVOLVES: particles as structure of arrays, time, history: complete and sufficient for a restart |
//! | `grid` | the background grid: blocks that exist only where a body is, particles kept in the order of blocks |
//! | `basis` | shape functions along an axis, one file a family |
//! | `quadrature` | Gauss points with fields reconstructed from the particles: along rows by splines, in cells by least squares |
//! | `transfer` | particles to grid and back: the kernels, a sweep over the particles of a bin |
//! | `lanes`, `lines` | eight numbers at once: what kernels are made of, for AVX-512, AVX2 and any CPU; memory in whole lines of the cache |
//! | `material` | one file a law, always 3x3; plane strain, plane stress and one dimension are embeddings, in one place |
//! | `step` | ONE STEP of particles that move through a grid: one file a stage, named in running order; the stable step; measures |
//! | `total` | ONE STEP of bodies on grids of their own (total Lagrangian), explicit and implicit |
//! | `implicit` | what implicit steps share: schemes in time, Newton's method, sparse matrices, conjugate gradients |
//! | `solver` | the choice between them, made once |
//! | [`component`] | FROM OUTSIDE: [`Simulation`], the variable list, snapshots: all that an adapter may see |
//! | [`record`] | DATA OUT: Rerun, MCAP, ParaView, CSV, pictures; recordings read back, compared, repaired |
//! | [`messages`], `msgs` | the ROS 2 messages: what `.mcap` recordings hold and the node publishes, defined once |
//! | [`study`] | STUDIES: many runs beside the numbers and figures of the papers, and beside known answers |
//! | `bindings/python` | an adapter: `import matpoint`, built by maturin; its tests are in `tests/python` |
//! | `bindings/ros2` | an adapter: the ROS 2 node, pure Rust on DDS; its messages are in `msgs`, its tests in `tests/ros2` |
//! | `svg`, `color`, `draft`, [`text`] | what pictures and reports are made with |
//!
//! # Invariants
//!
//! 1. `Scene`, `Model`, `State`, loads and scratch are separate. `save -> restore -> step` gives the same bytes (`tests/determinism.rs`).
//! 2. The step reads like the algorithm box of the papers, and with lumped mass and particle quadrature it allocates nothing once its
//!    buffers have grown (in the updated formulation), but for what a sort needs, and a report a bin where threads share the work.
//! 3. A material is 3x3 in, 3x3 out.
//! 4. A choice becomes a type or a function pointer once, in `transfer::Kernels::new` and `total/rows/mod.rs`; inside a kernel dimension and width are constants.
//! 5. Adapters see only [`component`]; nothing sees them. Names, units, shapes and docs of variables live in one list.
//! 6. A failed step leaves the state as it was and says which particle, where and when. No silent reset, no clamp that hides a fault.
//! 7. Results are bitwise the same for any number of threads (on one kind of CPU), and for a run cut in two by a snapshot.
//! 8. What a scene does not need costs nothing: no affine matrix without APIC or ASFLIP, no history without rate laws, no empty blocks, no
//!    second velocity field without contact, no mass matrix and no quadrature points unless asked for.
//!
//! # Where this differs from the plan of the house, and why
//!
//! - `Model` and `State` carry their dimension as a value, not as a type: only kernels gain from a constant, and one `State` type is one
//!   snapshot format. A grid node always has four lanes (mass and three axes), which is one vector register.
//! - A step begins in the pass over the particles that ends the one before it, where nothing but particles gives to the grid (`Model::fuses`): each
//!   particle is then loaded once a step. The length of a step is decided one ahead for that.
//! - Particles of blocks of one colour are neighbours in memory (`grid/order.rs`), as a pass takes the blocks colour by colour. But no colour waits
//!   for the one before: a block waits for its neighbours (`grid/turns.rs`), which add to common nodes in one order whatever the threads.
//! - Loads hang on particles (`x = x_p + F_p d`) and act through the first-order expansion of the shape functions around their particle.
//!   Force and moment are exact, no node without mass is ever loaded, and surface points need no state.
//! - The stable step comes from the discrete operator of the scene by a few Lanczos steps (`step/limit.rs`), not from a Courant number:
//!   it knows basis, boundaries, free surfaces, integrator and transfer.
//! - All laws yield the Kirchhoff stress, so internal forces need only the volume at time 0.
//! - Serendipity elements need no list stencil: they are Lagrange elements whose inner nodes are tied to the others (`grid/tied.rs`).
//! - Contact has no second grid: blocks belong to a field, bodies have blocks of their own, and corrections run over blocks that two fields
//!   have (`step/contact.rs`). An impulse acts only between nodes that approached before the kick too; Bardenhagen's rule alone adds energy.
//! - An implicit step of the updated formulation is a step of the total one whose reference is the configuration at its start
//!   (`total/updated.rs`): one residual and one tangent for both, tested against differences for each law (`total/tests.rs`).
//! - What is inside a cell that a body in space cuts is integrated coordinate by coordinate (`quadrature/solid`), not by cones as in a plane:
//!   it takes fewer points, which are particles, and their weights are positive wherever holes are.
//! - Bodies that cut cells in the total formulation keep all functions in their fields; those with little support are tied to others where forces
//!   are summed and matrices assembled (`total/ties.rs`), so that kernels know nothing of it. Their held faces add an energy (`total/surface.rs`).
//! - In the total formulation velocity stays on the nodes, and the particles are quadrature points: nothing is projected, nothing is lost.
//! - Explicit steps of bodies that are boxes of whole cells move nodes only (`total/rows`): the same points in each cell, sums axis by axis, eight cells
//!   at once with AVX-512, AVX2 or what else there is. Their particles follow when somebody looks, and are not in snapshots.
//! - Formulas that differ from place to place run as lists of operations without repeats (`scene/formula/tape.rs`), where bodies have grids of their own.
//! - Mass matrices of the step through a grid are never assembled: rows of shape functions at the points where mass sits (`step/mass.rs`). Rows of nodes lighter than a
//!   particle are lumped, which keeps the stable step and cures what makes the papers' consistent mass fail at a free end.
//! - A plane body whose particles keep their neighbours is a sheet (`quadrature/sheet`): the image of a square by splines, integrated in the cells
//!   it fills and cuts (`quadrature/cut`), wherever it lies and however it bends. Its outer particles stand on its edge, so that nothing is
//!   extrapolated; edges that stick to walls do so at points of the edge (`step/edge.rs`), not at nodes.
//! - Taylor least squares do not fix cell means to the sums of the particles (`quadrature/least_squares.rs` has the measurement); sums are
//!   made good over the body.
//! - Values of variables are shared, not lent: what an adapter looks at is never written over (`Simulation::share`), so that a view without
//!   a copy is safe in Python whatever the simulation does next.
//! - A [`record::Recorder`] knows when sinks are due and is offered the simulation after each step: the loop may be anybody's.
//! - A recording is made by a thread of its own, which gets the values of variables shared, not copied ([`record::Recorder`], `record/background.rs`);
//!   the outline of a body comes from who was whose neighbour at time 0 (`record/lattice.rs`).
//! - Formulas are read by our own small parser (`scene/formula.rs`): the crates that were tried misread `-x^2` or `1e-3`, or are not kept.

mod basis;
mod color;
pub mod component;
mod draft;
mod grid;
mod implicit;
mod lanes;
mod lines;
mod material;
#[cfg(feature = "mcap")]
pub mod messages;
mod model;
mod quadrature;
pub mod record;
pub mod scene;
mod solver;
mod state;
mod step;
pub mod study;
mod svg;
pub mod text;
mod total;
mod transfer;

pub use component::Simulation;
