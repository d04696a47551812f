"""A convergence study: the error of a swinging bar against the known solution, over the cell size, for two methods.

The bar is fixed at both ends and swings in its first mode, so little that the small-strain solution is exact for all
that counts here.
"""

from __future__ import annotations

import numpy as np

from matpoint import Scene
from matpoint.scene import Body, Boundary, Exact, Grid, Material, Method, Shape, Time

CELLS = [8, 16, 32, 64]
METHODS = {
    "particles, lumped mass": Method(),
    "splines, consistent mass": Method(quadrature="splines", quadrature_of="force_and_velocity", mass="consistent"),
}
BAR: Shape = {"box": {"min": [0.0], "max": [1.0]}}
SPEED = "1e-6*sin(PI*x)"  # [m/s]
RATE = "(10*PI)"  # [rad/s], the wave speed sqrt(young / density) is 10 m/s


def scene(cells: int, method: Method) -> Scene:
    return Scene(
        title="a bar in its first mode",
        dimension=1,
        grid=Grid(origin=[0.0], size=[1.0], cell=1.0 / cells),
        material={"soft": Material(law="linear_elastic", young=100.0, density=1.0)},
        body={"bar": Body(material="soft", shape=BAR, particles_per_cell=4, velocity=[SPEED])},
        boundary={"left": Boundary(face="x-", fixed=["x"]), "right": Boundary(face="x+", fixed=["x"])},
        method=method,
        time=Time(end=0.04, step=4e-5),  # a fifth of the period, in steps whose error is far below that of the cells
        exact=Exact(displacement=[f"{SPEED}/{RATE}*sin({RATE}*t)"]),
    )


def error(cells: int, method: Method) -> float:
    """RMS error of the displacement over its largest value [-]."""
    sim = scene(cells, method).build()
    sim.run(progress=False)
    return float(sim["error/displacement"][0] / np.abs(sim["particle/displacement"]).max())


def main() -> None:
    finest = []
    for name, method in METHODS.items():
        errors = [error(cells, method) for cells in CELLS]
        orders = np.log2(np.divide(errors[:-1], errors[1:]))
        print(f"{name}: errors {' '.join(f'{value:.2e}' for value in errors)}, orders {orders.round(2)}")
        assert min(orders) > 1.9, "quadratic B-splines must be of second order"
        finest.append(errors[-1])
    assert finest[1] < finest[0] / 50.0, "splines and consistent mass must be worth their price"


if __name__ == "__main__":
    main()
