"""MLS-MPM in taichi as its example mpm3d has it: a loop over particles with atomic additions to a grid, momentum and mass apart; neo-Hookean."""

import os

os.environ["ENABLE_TAICHI_HEADER_PRINT"] = "0"
import taichi as ti

import common


def make(work: common.Work):
    real = ti.f64 if work.double else ti.f32
    ti.init(arch=ti.cpu, default_fp=real, cpu_max_num_threads=work.threads, offline_cache_file_path="target/peers/taichi", log_level=ti.ERROR)
    n, cells, dx, dt, volume, mass = len(work.x), work.cells, work.dx, work.dt, work.volume, work.mass
    inv_dx = 1 / dx
    x = ti.Vector.field(3, real, n)
    v = ti.Vector.field(3, real, n)
    affine = ti.Matrix.field(3, 3, real, n)
    f = ti.Matrix.field(3, 3, real, n)
    grid_v = ti.Vector.field(3, real, (cells, cells, cells))
    grid_m = ti.field(real, (cells, cells, cells))
    one = ti.Matrix([[float(i == j) for j in range(3)] for i in range(3)])

    @ti.kernel
    def clear():
        for node in ti.grouped(grid_m):
            grid_v[node] = ti.zero(grid_v[node])
            grid_m[node] = 0.0

    @ti.kernel
    def to_grid():
        for p in x:
            at = x[p] * inv_dx
            base = ti.cast(at - 0.5, int)
            fx = at - base
            w = [0.5 * (1.5 - fx) ** 2, 0.75 - (fx - 1.0) ** 2, 0.5 * (fx - 0.5) ** 2]
            fp = f[p]
            tau = common.MU * (fp @ fp.transpose() - one) + one * (common.LAMBDA * ti.log(fp.determinant()))
            moment = (-dt * volume * 4 * inv_dx * inv_dx) * tau + mass * affine[p]
            for offset in ti.static(ti.grouped(ti.ndrange(3, 3, 3))):
                apart = (offset - fx) * dx
                weight = w[offset[0]][0] * w[offset[1]][1] * w[offset[2]][2]
                grid_v[base + offset] += weight * (mass * v[p] + moment @ apart)
                grid_m[base + offset] += weight * mass

    @ti.kernel
    def balance():
        for node in ti.grouped(grid_m):
            if grid_m[node] > 0:
                grid_v[node] /= grid_m[node]
                grid_v[node][1] -= dt * common.GRAVITY
                for d in ti.static(range(3)):
                    if node[d] < 3 and grid_v[node][d] < 0:
                        grid_v[node][d] = 0.0
                    if node[d] > cells - 4 and grid_v[node][d] > 0:
                        grid_v[node][d] = 0.0

    @ti.kernel
    def to_particles():
        for p in x:
            at = x[p] * inv_dx
            base = ti.cast(at - 0.5, int)
            fx = at - base
            w = [0.5 * (1.5 - fx) ** 2, 0.75 - (fx - 1.0) ** 2, 0.5 * (fx - 0.5) ** 2]
            new_v = ti.Vector.zero(real, 3)
            new_c = ti.Matrix.zero(real, 3, 3)
            for offset in ti.static(ti.grouped(ti.ndrange(3, 3, 3))):
                weight = w[offset[0]][0] * w[offset[1]][1] * w[offset[2]][2]
                g = grid_v[base + offset]
                new_v += weight * g
                new_c += (4 * inv_dx * weight) * g.outer_product(offset - fx)
            v[p] = new_v
            affine[p] = new_c
            x[p] += dt * new_v
            f[p] = (one + dt * new_c) @ f[p]

    @ti.kernel
    def rest():
        for p in x:
            f[p] = one

    x.from_numpy(work.x.astype(work.number))
    v.from_numpy(work.v.astype(work.number))
    rest()

    def step(count: int) -> None:
        for _ in range(count):
            clear()
            to_grid()
            balance()
            to_particles()
        ti.sync()

    return step, v.to_numpy


common.serve(make)
