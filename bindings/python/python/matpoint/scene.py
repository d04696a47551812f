"""The parts of a scene as typed dicts: for completion in editors, and for type checkers.

Made by bindings/python/generate_scene.py from the types in src/scene; do not edit. All units are SI. A part is a dict:
`Grid(origin=[0.0], size=[1.0], cell=0.1)` is `{"origin": [0.0], "size": [1.0], "cell": 0.1}`, and either may be given to
`matpoint.Scene`, which checks it. Keys that are not Required may be left out.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal, Required, TypedDict, Union

import numpy as np
from numpy.typing import NDArray

Numbers = Union[Sequence[float], NDArray[np.floating[Any]], NDArray[np.integer[Any]]]


Plane = Literal["strain", "stress"]
"""What happens across the plane (dimension 2) or the axis (dimension 1). `strain`: No strain across. `stress`:
No stress across: the thickness changes freely."""


class Grid(TypedDict, total=False):
    """The background grid: a box of equal cells. B-splines have open knots at its ends, so a wall is best put
    there."""

    origin: Required[Numbers]
    """Lower corner [m]."""
    size: Required[Numbers]
    """Extent along each axis [m]: a whole number of cells."""
    cell: Required["OneOrEach"]
    """Cell size [m]: one number, or one an axis."""


OneOrEach = Union[float, Numbers]
"""One value for all axes, or one for each."""


class Material(TypedDict, total=False):
    """An isotropic elastic material."""

    law: Required["Law"]
    """The law."""
    young: Required[float]
    """Young's modulus [Pa]."""
    poisson: float
    """Poisson's ratio [-], above -1 and below 0.5."""
    density: Required[float]
    """Density before deformation [kg/m3]."""


Law = Literal["linear_elastic", "hypo_elastic", "neo_hookean", "hencky"]
"""The laws of elasticity on offer. `linear_elastic`: Small strain: the stress follows the sum of the strain
increments, volume changes are ignored. `hypo_elastic`: Jaumann rate of the Kirchhoff stress; in one dimension
sigma' = (E - sigma) eps', the law of Tielen (2016). `neo_hookean`: Compressible neo-Hookean: tau = mu (b - I)
+ lambda ln J I. `hencky`: Hencky: linear between the logarithmic strain and the Kirchhoff stress."""


class Body(TypedDict, total=False):
    """A deformable body, filled with particles."""

    material: Required[str]
    """Name of its material."""
    shape: Required["Shape"]
    """The region it fills at time 0."""
    particles_per_cell: Union["WholeOneOrEach", None]
    """Particles along each axis of a cell: one number, or one an axis. If left out: two, and one more than the
    degree for the total formulation."""
    positions: Union["Positions", None]
    """Where in a cell the particles sit: `uniform` if left out, `gauss` for the total formulation, and always
    where a body cuts cells in it."""
    seed: int
    """Seed of the jitter."""
    velocity: Union[Sequence["Expr"], NDArray[np.floating[Any]]]
    """Initial velocity [m/s], one number or formula of x, y, z (position at time 0) an axis. Zero if left out."""


class Box(TypedDict, total=False):
    """An axis-aligned box (an interval in dimension 1)."""

    min: Required[Numbers]
    """Lower corner [m]."""
    max: Required[Numbers]
    """Upper corner [m]."""


class ShapeBox(TypedDict, total=False):
    """An axis-aligned box (an interval in dimension 1)."""

    box: Required["Box"]


class Disk(TypedDict, total=False):
    """A disk (dimension 2)."""

    center: Required[Numbers]
    """Centre [m]."""
    radius: Required[float]
    """Radius [m]."""


class ShapeDisk(TypedDict, total=False):
    """A disk (dimension 2)."""

    disk: Required["Disk"]


class Sphere(TypedDict, total=False):
    """A ball (dimension 3)."""

    center: Required[Numbers]
    """Centre [m]."""
    radius: Required[float]
    """Radius [m]."""


class ShapeSphere(TypedDict, total=False):
    """A ball (dimension 3)."""

    sphere: Required["Sphere"]


class Ring(TypedDict, total=False):
    """An annulus (dimension 2)."""

    center: Required[Numbers]
    """Centre [m]."""
    inner: Required[float]
    """Inner radius [m]."""
    outer: Required[float]
    """Outer radius [m]."""


class ShapeRing(TypedDict, total=False):
    """An annulus (dimension 2)."""

    ring: Required["Ring"]


class Polygon(TypedDict, total=False):
    """A simple polygon, convex or not (dimension 2)."""

    points: Required[Union[Sequence[Numbers], NDArray[np.floating[Any]]]]
    """Corners in order [m], either sense of rotation."""


class ShapePolygon(TypedDict, total=False):
    """A simple polygon, convex or not (dimension 2)."""

    polygon: Required["Polygon"]


class HalfSpace(TypedDict, total=False):
    """All points behind a plane: those with (x - point) . normal <= 0. Its face, as part of a composite shape,
    is `plane`."""

    point: Required[Numbers]
    """A point of the plane [m]."""
    normal: Required[Numbers]
    """Outward normal, any length."""


class ShapeHalfSpace(TypedDict, total=False):
    """All points behind a plane: those with (x - point) . normal <= 0. Its face, as part of a composite shape,
    is `plane`."""

    half_space: Required["HalfSpace"]


class ShapeUnion(TypedDict, total=False):
    """All points in one of the parts."""

    union: Required[Sequence["Shape"]]


class ShapeDifference(TypedDict, total=False):
    """The points of the first part that are in none of the others."""

    difference: Required[Sequence["Shape"]]


class ShapeIntersection(TypedDict, total=False):
    """The points that are in all parts."""

    intersection: Required[Sequence["Shape"]]


Shape = Union["ShapeBox", "ShapeDisk", "ShapeSphere", "ShapeRing", "ShapePolygon", "ShapeHalfSpace", "ShapeUnion", "ShapeDifference", "ShapeIntersection"]
"""A region of space. In TOML: `shape = { box = { min = [0, 0], max = [8, 1] } }`."""


WholeOneOrEach = Union[int, Sequence[int]]
"""One value for all axes, or one for each."""


Positions = Literal["uniform", "gauss", "jittered"]
"""Where in a cell the particles of a body sit. `uniform`: Centres of equal parts of the cell. `gauss`: Gauss-
Legendre points of the cell, each with its weight as volume. `jittered`: Uniform, then moved at random by up
to 40 % of the spacing; the same for the same seed."""


Expr = Union[float, str]
"""A number, or a formula such as `"0.1*sin(PI*x/25)"`."""


class Boundary(TypedDict, total=False):
    """Where velocity is fixed or prescribed. Give one of `face`, `region` and `surface`."""

    face: Union[str, None]
    """A whole end of the grid: `"x-"`, `"x+"`, `"y-"`, `"y+"`, `"z-"` or `"z+"`."""
    region: Union["Shape", None]
    """A region: every node (for B-splines: every Greville point) in it is held."""
    surface: Union["Surface", None]
    """A face of a body, wherever it lies in the grid: what sticks to a wall. For formulation = "total" in
    dimension 2 and 3, and for quadrature = "splines". In "total", where the face cuts cells it is held by
    Nitsche's method: for laws with a stored energy, without `mean_dilatation`; the work of its forces is not
    counted as stored energy."""
    fixed: Sequence["Axis"]
    """Axes along which the velocity is zero."""
    velocity: Mapping["Axis", "Expr"]
    """Prescribed velocity [m/s] along an axis: a number or a formula of t."""


class Surface(TypedDict, total=False):
    """A face of a body."""

    body: Required[str]
    """Name of the body."""
    face: Required[str]
    """Name of the face, as for a traction."""


Axis = Literal["x", "y", "z"]
"""A coordinate axis. `x`: First axis. `y`: Second axis. `z`: Third axis."""


class LoadGravity(TypedDict, total=False):
    """Acceleration of everything [m/s2]."""

    gravity: Required["Signal"]


class LoadBodyForce(TypedDict, total=False):
    """Specific body force (an acceleration) on a body or a part of it."""

    body_force: Required["BodyForce"]


class LoadTraction(TypedDict, total=False):
    """Dead traction on a face of a body: force an undeformed area, direction fixed in space."""

    traction: Required["Traction"]


class LoadPressure(TypedDict, total=False):
    """Follower pressure on a face of a body: force a deformed area, against the deformed normal."""

    pressure: Required["Pressure"]


class LoadPointForce(TypedDict, total=False):
    """Force on the particle nearest to a point; in the total formulation at the point itself."""

    point_force: Required["PointForce"]


Load = Union["LoadGravity", "LoadBodyForce", "LoadTraction", "LoadPressure", "LoadPointForce"]
"""A load. Exactly one kind a name."""


Signal = Union[Union[Sequence["Expr"], NDArray[np.floating[Any]]], "Table", "External"]
"""A value in time: constants and formulas of t, a table, or set from outside."""


class Table(TypedDict, total=False):
    """A table of values in time."""

    time: Required[Numbers]
    """Times [s], increasing."""
    value: Required[Union[Sequence[Numbers], NDArray[np.floating[Any]]]]
    """One row of components a time."""


External = Literal["external"]
"""The word `external`. `external`: Set from outside while running; zero until set."""


class BodyForce(TypedDict, total=False):
    """Specific body force (an acceleration) on a body or a part of it."""

    body: Required[str]
    """Name of the body."""
    region: Union["Shape", None]
    """Part of the body that is loaded, at time 0; all of it if left out."""
    value: Required["Signal"]
    """Acceleration [m/s2]; its formulas may use x, y, z (position at time 0) and t."""


class Traction(TypedDict, total=False):
    """Dead traction on a face of a body."""

    body: Required[str]
    """Name of the body."""
    face: Required[str]
    """Name of the face: `x-` ... `z+` of a box, `outer` of a disk or sphere, `inner` or `outer` of a ring,
    `edge1` ... of a polygon, `plane` of a half-space; in a union, difference or intersection with the number
    of the part before it, as in `2/x+`."""
    value: Required["Signal"]
    """Force an undeformed area [Pa]; its formulas may use x, y, z (position at time 0) and t."""


class Pressure(TypedDict, total=False):
    """Follower pressure on a face of a body."""

    body: Required[str]
    """Name of the body."""
    face: Required[str]
    """Name of the face, as for a traction."""
    value: Required["Signal"]
    """Pressure [Pa], one component, positive when it pushes on the body; its formulas as for a traction."""


class PointForce(TypedDict, total=False):
    """Force on the particle nearest to a point; in the total formulation at the point itself."""

    body: Required[str]
    """Name of the body."""
    at: Required[Numbers]
    """The point at time 0 [m]."""
    value: Required["Signal"]
    """Force [N] (per metre of thickness in dimension 2, per square metre of section in dimension 1)."""


class Probe(TypedDict, total=False):
    """A material point that is watched."""

    body: Union[str, None]
    """Name of the body; needed only where there are several."""
    at: Required[Numbers]
    """The point at time 0 [m], in the body or at most one cell outside it. It moves with the nearest particle
    and its deformation."""


class Contact(TypedDict, total=False):
    """What happens where bodies meet: each has its own velocity field, corrected at the nodes that two bodies
    reach so that they do not come closer there, with Coulomb friction (Bardenhagen et al. 2001)."""

    friction: float
    """Coefficient of friction [-], 0 or more."""


Written = Union["Method", "Auto"]
"""A method as a scene file has it."""


class Method(TypedDict, total=False):
    """How the scene is solved: a point in the table basis x quadrature x mass x transfer x integrator."""

    formulation: "Formulation"
    """In which configuration the balance of momentum is written."""
    basis: "Basis"
    """Family of shape functions."""
    degree: Union[int, None]
    """Degree of the B-splines, 1 to 5; 1 is the same as the linear basis."""
    domain: Union["Domain", None]
    """Whether the particle domains of GIMP follow the deformation."""
    quadrature: "Quadrature"
    """Where the internal forces are integrated."""
    quadrature_of: Union["QuadratureOf", None]
    """What else is integrated there."""
    mass: Union["Mass", None]
    """Mass matrix of the projection of velocities and of the balance of momentum. Lumped for the updated
    formulation, consistent for the total one, if left out."""
    balance_mass: Union["Mass", None]
    """Mass matrix of the balance of momentum alone; as `mass` if left out."""
    fmpm_order: Union[int, None]
    """Order k of FMPM(k), 2 or more: terms of the series."""
    mass_solver: Union["MassSolver", None]
    """Solver of a consistent mass matrix."""
    mass_residual: Union[float, None]
    """Residual, over the right-hand side, at which the solver of a consistent mass matrix stops; 1e-9 if left
    out."""
    integrator: Union["Integrator", None]
    """How time goes on: `musl` for the updated formulation, `verlet` for the total one, if left out."""
    newmark_beta: Union[float, None]
    """Beta of Newmark's scheme, 0.25 if left out."""
    newmark_gamma: Union[float, None]
    """Gamma of Newmark's scheme, 0.5 if left out; more damps."""
    spectral_radius: Union[float, None]
    """Share of its amplitude that an oscillation far faster than the step keeps in a step of the generalised-
    alpha scheme, 0 to 1; 0.8 if left out."""
    newton_residual: Union[float, None]
    """Forces out of balance, over those in balance, at which Newton's method stops; 1e-10 if left out."""
    newton_iterations: Union[int, None]
    """Most iterations of Newton's method before a step is halved; 20 if left out."""
    linear_solver: Union["LinearSolver", None]
    """How the linear systems of Newton's method are solved; by their size if left out, and always by a factor
    where a body cuts cells."""
    precision: "Precision"
    """Numbers in which transfers between particles and grid are worked out; particles and nodes keep 64 bits
    either way."""
    mean_dilatation: bool
    """Whether the particles of a cell share its mean change of volume: keeps nearly incompressible bodies from
    locking. For the total formulation."""
    transfer: "Transfer"
    """How velocity travels between particles and grid."""
    flip_share: Union[float, None]
    """Share of FLIP, 0 to 1; the rest is PIC in a FLIP transfer (1 if left out), APIC in an ASFLIP transfer
    (0.99 if left out)."""
    separation: Union[float, None]
    """Share of its own velocity with which a particle moves in an ASFLIP transfer where it is neither compressed
    nor next to a boundary, 0 to 1; the rest, and all of it elsewhere, is the velocity of the grid. 1 if left
    out."""
    mass_tolerance: Union[float, None]
    """A node lighter than this share of the lightest particle, 0 to 1, is nearly empty. A consistent mass matrix
    is lumped there (1 if left out: less makes the stable step shrink as bodies move through the grid). With
    linear functions or Lagrange elements, lumped mass, and USL or APIC, the velocity of such a node, and so
    the velocity gradient, takes no part of its force; the particles do, so that momentum is conserved (0.1 if
    left out)."""


Formulation = Literal["updated", "total"]
"""Configurations in which the balance of momentum is written. `updated`: That of now: particles move through a
grid, which forgets after each step. Bodies may touch, and deform without bounds. `total`: That of time 0:
each body has a grid of its own that deforms with it, so that shape functions are computed once. For bodies
that do not touch: far more accurate, and cheaper. The grid is fitted to boxes and convex polygons of four
corners. The edge of disks, rings, other polygons, in dimension 3 the surface of spheres and of intersections
of boxes and half-spaces, and those of differences of them whose holes are wholly inside and apart, cut cells
of the grid of the scene: particles are the points of a quadrature of what is inside, functions with little of
the body follow others (extended B-splines), and the order is that of a fitted grid, wherever the body lies.
Such bodies are held by `boundary.NAME.surface`: regions hold functions, of which none is alone at an edge.
With lumped mass no function follows another: from degree 2 on the stable step does not suffer, but order is
lost. Any other shape has the grid of the box around it, and its edge is known to a particle only."""


Basis = Literal["linear", "bspline", "lagrange", "serendipity", "cubic", "gimp"]
"""Families of shape functions. `linear`: Piecewise linear (bilinear, trilinear). `bspline`: B-splines with open
knots at the ends of the grid. `lagrange`: Quadratic Lagrange elements over two cells along each axis: 3, 9 or
27 nodes. Their functions are negative in part of the element; with lumped mass a step stops where a nodal
mass turns negative. `serendipity`: Serendipity elements over two cells along each axis: 8 nodes in dimension
2, 20 in dimension 3. With lumped mass their corners have negative mass (Andersen 2007). `cubic`: Uniform
cubic splines with a row of nodes outside the grid (Andersen 2007). A held face holds the nodes on it and
outside. `gimp`: Linear functions averaged over particle domains (Bardenhagen and Kober 2004)."""


Domain = Literal["uniform", "contiguous"]
"""Particle domains of GIMP. `uniform`: Domains keep their size. `contiguous`: Domains stretch with the
deformation gradient along each axis, so that they stay next to each other."""


Quadrature = Literal["particles", "splines", "least_squares"]
"""Where the internal forces are integrated. `particles`: At the particles, with their volumes as weights.
`splines`: At Gauss points in cells, from cubic splines through the particles (Tielen 2016, chapter 7).
Particles stand in rows that stay rows. In dimension 2 each body is a box, a ring or a convex polygon with
four corners, anywhere in the grid, with particles on its edges too; cells that its edge cuts are integrated
exactly, and with quadrature_of = "force_and_velocity" the functions at the edge are extended from inside
(Hollig 2001). In dimensions 1 and 3 it is a box, in dimension 3 with particles on its faces too, and its ends
must stay upright: where they lean, integrals are off (0.8 % at 0.1 rad). `least_squares`: At Gauss points of
full cells, from a least-squares fit in each (Wobbes et al. 2019); at the particles of other cells."""


QuadratureOf = Literal["force", "force_and_velocity"]
"""What is integrated at the quadrature points. `force`: Internal forces; mass and momentum come from the
particles, which conserves momentum. `force_and_velocity`: Internal forces, and mass and momentum in the
projection of velocities."""


Mass = Literal["lumped", "consistent", "fmpm"]
"""Mass matrices. `lumped`: Row sums on the diagonal. `consistent`: The full matrix, solved in each step. The
stable step is about a sixth of that with lumped mass. `fmpm`: The first `fmpm_order` terms of the series of
its inverse (Nairn and Hammerquist 2021). With `balance_mass = "lumped"` and `transfer = "pic"` particles take
the velocity of XPIC(m), m terms (Hammerquist and Nairn 2017), and move with it; the paper moves them with
what a lumped mass makes of their velocity, and half its change."""


MassSolver = Literal["pcg", "direct", "richardson"]
"""Solvers of a consistent mass matrix. `pcg`: Conjugate gradients, preconditioned by the diagonal. `direct`:
Conjugate gradients from a sparse factor of the matrix, which are at their end after an iteration or a few;
for quadrature_of = "force_and_velocity". The choice for bodies that cut cells. `richardson`: Richardson
iteration from the lumped solution (Tielen 2016, section 7.2)."""


Integrator = Literal["usf", "usl", "musl", "verlet", "symplectic4", "quasi_static", "newmark", "generalized_alpha", "energy_momentum"]
"""How time goes on. The first three are for the updated formulation and tell when the stress is updated within a
step. `usf`: Update stress first: from the velocity projected at the new positions. Keeps the energy. `usl`:
Update stress last: from the updated nodal velocity. Cheapest; dissipates. `musl`: Modified update stress
last: stress and positions from the velocity projected again (Sulsky 1994, Tielen 2016, section 3.2). Keeps
the energy; quieter than USF, for particles and their deformation move with the same field. `verlet`: Velocity
Verlet, of second order and symplectic; for the total formulation. `symplectic4`: Symplectic Runge-Kutta-
Nystroem scheme of fourth order with six forces a step (Blanes and Moan 2002); for the total formulation.
`quasi_static`: Loads applied without inertia, in steps: the balance of forces at the end of each. Nothing has
a velocity. `newmark`: Newmark's implicit scheme, `newmark_beta` and `newmark_gamma`; by default the
trapezoidal rule. `generalized_alpha`: Implicit, of second order, damps what is faster than the step (Chung
and Hulbert 1993); `spectral_radius` says how much. `energy_momentum`: Implicit, of second order: conserves
energy and momenta (Gonzalez 2000)."""


LinearSolver = Literal["direct", "iterative"]
"""How the linear systems of implicit steps are solved. `direct`: A sparse factor: Cholesky, or elimination where
that fails or the system is not symmetric. `iterative`: Conjugate gradients without a matrix, from the inverse
of the stiffness of a box at rest; direct where the system is not symmetric and positive."""


Precision = Literal["double", "single"]
"""Numbers of a transfer between particles and grid. `double`: 64 bits. `single`: 32 bits, sums of them on the
nodes in 64: faster, with a round-off of 6e-8 of a step in what travels. For explicit steps of the updated
formulation with a lumped mass, quadrature at the particles, and linear functions or B-splines of degree up to
3."""


Transfer = Literal["pic", "flip", "apic", "asflip"]
"""How velocity travels between particles and grid. `pic`: Particles take the interpolated velocity: very
dissipative with lumped mass, where it is XPIC(1) too. XPIC(m) is PIC with `mass = "fmpm"`, `fmpm_order` = m,
`balance_mass = "lumped"`. `flip`: Particles take the interpolated increment; `flip_share` blends with PIC.
`apic`: Affine particle-in-cell: keeps linear and angular momentum, filters noise. `asflip`: Affine separable
FLIP (Fei et al. 2021), for USF and USL: APIC, to which particles add the share `flip_share` of their own
velocity that the grid has not got, and with which they move where they are neither compressed nor next to a
boundary (`separation`). Bodies that share a velocity field part more easily; less of a vibration is lost.
Angular momentum is kept less well than by APIC, and deformation is no longer exactly the gradient of the
motion."""


Auto = Literal["auto"]
"""The word `auto`. `auto`: Chosen by what the scene holds."""


class Time(TypedDict, total=False):
    """How long, and in what steps. For explicit integrators give either `step` or `cfl`; with neither, `cfl` is
    0.4, or 0.8 in the total formulation. For implicit ones give `step`, or `error`."""

    end: Required[float]
    """End of a run [s]."""
    step: Union[float, None]
    """Fixed step [s]; refused where it is above the stable one. Beside `error`: the longest."""
    cfl: Union[float, None]
    """Share of the stable step, above 0 and up to 1. The stable step is that of the particles where they are at
    time 0: leave room for other places in their cells."""
    error: Union[float, None]
    """Largest error of the displacement that an implicit step may make [m], root of the mean square over the
    mass: steps are as long as an estimate of it allows, up to `step`, or a hundredth of the run if that is
    left out."""


class Record(TypedDict, total=False):
    """How often `run` records, in simulated seconds."""

    every: Union[float, None]
    """Time between particle frames [s]; a hundredth of the run if left out, or `time.step` where that is longer."""
    every_steps: Union[int, None]
    """Substeps between particle frames, instead of `every`."""
    history: Union[float, None]
    """Time between rows of energies and probes [s]; with the frames if left out."""


class Stress(TypedDict, total=False):
    """Cauchy stress [Pa] by component: `xx`, `yy`, `zz`, `yz`, `xz`, `xy`."""

    xx: "Expr"
    xy: "Expr"
    xz: "Expr"
    yy: "Expr"
    yz: "Expr"
    zz: "Expr"


class Exact(TypedDict, total=False):
    """The known solution of a scene. Its formulas may use x, y, z (position at time 0) and t."""

    displacement: Union[Sequence["Expr"], NDArray[np.floating[Any]]]
    """Displacement [m], one an axis."""
    velocity: Union[Sequence["Expr"], NDArray[np.floating[Any]]]
    """Velocity [m/s], one an axis."""
    stress: "Stress"
    """Cauchy stress [Pa] by component: `xx`, `yy`, `zz`, `yz`, `xz`, `xy`."""
    reference: Union[str, None]
    """CSV file with the columns `time_s, X_m, displacement_m, velocity_m_s, stress_Pa` (dimension 1), beside the
    scene file."""


class Keys(TypedDict, total=False):
    """The keys of a scene, as `matpoint.Scene` takes them."""

    title: Required[str]
    """What the scene shows, in one line."""
    dimension: Required[int]
    """Number of space dimensions: 1, 2 or 3."""
    plane: "Plane"
    """What happens across the plane (dimension 2) or the axis (dimension 1); no meaning in dimension 3."""
    grid: Required["Grid"]
    """The background grid."""
    material: Required[Mapping[str, "Material"]]
    """Materials by name."""
    body: Required[Mapping[str, "Body"]]
    """Bodies by name."""
    boundary: Mapping[str, "Boundary"]
    """Where the velocity of the grid is fixed or prescribed, by name. A later boundary overrides an earlier one."""
    load: Mapping[str, "Load"]
    """Loads by name."""
    probe: Mapping[str, "Probe"]
    """Material points that are watched, by name."""
    contact: Union["Contact", None]
    """What happens where bodies meet; without it they share one velocity field, and stick."""
    method: "Written"
    """How the scene is solved: a point in the table formulation x basis x quadrature x mass x transfer x
    integrator, or the word `"auto"`."""
    time: Required["Time"]
    """How long, and in what steps."""
    record: "Record"
    """How often `run` records."""
    exact: Union["Exact", None]
    """The known solution, for scenes that have one."""


__all__ = [
    "Auto",
    "Axis",
    "Basis",
    "Body",
    "BodyForce",
    "Boundary",
    "Box",
    "Contact",
    "Disk",
    "Domain",
    "Exact",
    "Expr",
    "External",
    "Formulation",
    "Grid",
    "HalfSpace",
    "Integrator",
    "Keys",
    "Law",
    "LinearSolver",
    "Load",
    "LoadBodyForce",
    "LoadGravity",
    "LoadPointForce",
    "LoadPressure",
    "LoadTraction",
    "Mass",
    "MassSolver",
    "Material",
    "Method",
    "Numbers",
    "OneOrEach",
    "Plane",
    "PointForce",
    "Polygon",
    "Positions",
    "Precision",
    "Pressure",
    "Probe",
    "Quadrature",
    "QuadratureOf",
    "Record",
    "Ring",
    "Shape",
    "ShapeBox",
    "ShapeDifference",
    "ShapeDisk",
    "ShapeHalfSpace",
    "ShapeIntersection",
    "ShapePolygon",
    "ShapeRing",
    "ShapeSphere",
    "ShapeUnion",
    "Signal",
    "Sphere",
    "Stress",
    "Surface",
    "Table",
    "Time",
    "Traction",
    "Transfer",
    "WholeOneOrEach",
    "Written",
]
