"""MLS-MPM in warp, on the processor, where warp has one thread; neo-Hookean."""

import numpy as np
import warp as wp

import common


def make(work: common.Work):
    wp.config.quiet = True
    wp.config.kernel_cache_dir = "target/peers/warp"
    wp.init()
    wp.set_device("cpu")
    R = wp.float64 if work.double else wp.float32
    V = wp.types.vector(3, R)
    M = wp.types.matrix((3, 3), R)
    cells = wp.constant(work.cells)

    @wp.func
    def weights(fx: V) -> M:
        a = V(R(1.5), R(1.5), R(1.5)) - fx
        b = fx - V(R(1.0), R(1.0), R(1.0))
        c = fx - V(R(0.5), R(0.5), R(0.5))
        middle = V(R(0.75), R(0.75), R(0.75)) - wp.cw_mul(b, b)
        return wp.matrix_from_rows(wp.cw_mul(a, a) * R(0.5), middle, wp.cw_mul(c, c) * R(0.5))

    @wp.kernel
    def to_grid(
        x: wp.array(dtype=V), v: wp.array(dtype=V), affine: wp.array(dtype=M), f: wp.array(dtype=M), grid_v: wp.array3d(dtype=V),
        grid_m: wp.array3d(dtype=R), inv_dx: R, dx: R, dt: R, volume: R, mass: R, mu: R, lam: R,
    ):  # fmt: skip
        p = wp.tid()
        at = x[p] * inv_dx
        bx = int(at[0] - R(0.5))
        by = int(at[1] - R(0.5))
        bz = int(at[2] - R(0.5))
        fx = at - V(R(bx), R(by), R(bz))
        w = weights(fx)
        one = wp.identity(n=3, dtype=R)
        fp = f[p]
        tau = (fp * wp.transpose(fp) - one) * mu + one * (lam * wp.log(wp.determinant(fp)))
        moment = tau * (-dt * volume * R(4.0) * inv_dx * inv_dx) + affine[p] * mass
        momentum = v[p] * mass
        for i in range(3):
            for j in range(3):
                for k in range(3):
                    apart = (V(R(float(i)), R(float(j)), R(float(k))) - fx) * dx
                    weight = w[i, 0] * w[j, 1] * w[k, 2]
                    wp.atomic_add(grid_v, bx + i, by + j, bz + k, (momentum + moment * apart) * weight)
                    wp.atomic_add(grid_m, bx + i, by + j, bz + k, weight * mass)

    @wp.kernel
    def balance(grid_v: wp.array3d(dtype=V), grid_m: wp.array3d(dtype=R), dt: R, gravity: R):
        i, j, k = wp.tid()
        m = grid_m[i, j, k]
        if m > R(0.0):
            u = grid_v[i, j, k] / m - V(R(0.0), dt * gravity, R(0.0))
            ux = u[0]
            uy = u[1]
            uz = u[2]
            if (i < 3 and ux < R(0.0)) or (i > cells - 4 and ux > R(0.0)):
                ux = R(0.0)
            if (j < 3 and uy < R(0.0)) or (j > cells - 4 and uy > R(0.0)):
                uy = R(0.0)
            if (k < 3 and uz < R(0.0)) or (k > cells - 4 and uz > R(0.0)):
                uz = R(0.0)
            grid_v[i, j, k] = V(ux, uy, uz)

    @wp.kernel
    def to_particles(
        x: wp.array(dtype=V), v: wp.array(dtype=V), affine: wp.array(dtype=M), f: wp.array(dtype=M), grid_v: wp.array3d(dtype=V), inv_dx: R,
        dx: R, dt: R,
    ):  # fmt: skip
        p = wp.tid()
        at = x[p] * inv_dx
        bx = int(at[0] - R(0.5))
        by = int(at[1] - R(0.5))
        bz = int(at[2] - R(0.5))
        fx = at - V(R(bx), R(by), R(bz))
        w = weights(fx)
        new_v = V()
        new_c = M()
        for i in range(3):
            for j in range(3):
                for k in range(3):
                    apart = (V(R(float(i)), R(float(j)), R(float(k))) - fx) * dx
                    weight = w[i, 0] * w[j, 1] * w[k, 2]
                    g = grid_v[bx + i, by + j, bz + k]
                    new_v += g * weight
                    new_c += wp.outer(g, apart) * (weight * R(4.0) * inv_dx * inv_dx)
        v[p] = new_v
        affine[p] = new_c
        x[p] = x[p] + new_v * dt
        f[p] = f[p] + new_c * f[p] * dt

    n = len(work.x)
    x = wp.array(work.x.astype(work.number), dtype=V)
    v = wp.array(work.v.astype(work.number), dtype=V)
    affine = wp.zeros(n, dtype=M)
    f = wp.array(np.tile(np.eye(3, dtype=work.number), (n, 1, 1)), dtype=M)
    grid_v = wp.zeros((work.cells,) * 3, dtype=V)
    grid_m = wp.zeros((work.cells,) * 3, dtype=R)
    dx, dt = R(work.dx), R(work.dt)
    inv_dx = R(1 / work.dx)

    def step(count: int) -> None:
        for _ in range(count):
            grid_v.zero_()
            grid_m.zero_()
            given = [x, v, affine, f, grid_v, grid_m, inv_dx, dx, dt, R(work.volume), R(work.mass), R(common.MU), R(common.LAMBDA)]
            wp.launch(to_grid, dim=n, inputs=given)
            wp.launch(balance, dim=grid_m.shape, inputs=[grid_v, grid_m, dt, R(common.GRAVITY)])
            wp.launch(to_particles, dim=n, inputs=[x, v, affine, f, grid_v, inv_dx, dx, dt])
        wp.synchronize()

    return step, v.numpy


common.serve(make)
