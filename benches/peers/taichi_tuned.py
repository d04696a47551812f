"""MLS-MPM in taichi, tuned by hand for a processor: each thread adds to a grid of its own, so that no addition need be atomic; momentum and mass
of a node lie together. taichi makes `a[i] += b` atomic, and `a[i] = a[i] + b` not: without that a comparison would be about atomics."""

import os

os.environ["ENABLE_TAICHI_HEADER_PRINT"] = "0"
import taichi as ti

import common


def make(work: common.Work):
    real = ti.f64 if work.double else ti.f32
    ti.init(arch=ti.cpu, default_fp=real, cpu_max_num_threads=work.threads, offline_cache_file_path="target/peers/taichi", log_level=ti.ERROR)
    n, cells, dx, dt, volume, mass, threads = len(work.x), work.cells, work.dx, work.dt, work.volume, work.mass, work.threads
    inv_dx = 1 / dx
    x = ti.Vector.field(3, real, n)
    v = ti.Vector.field(3, real, n)
    affine = ti.Matrix.field(3, 3, real, n)
    f = ti.Matrix.field(3, 3, real, n)
    grid = ti.Vector.field(4, real, (threads, cells, cells, cells))
    one = ti.Matrix([[float(i == j) for j in range(3)] for i in range(3)])

    @ti.kernel
    def clear():
        for node in ti.grouped(grid):
            grid[node] = ti.zero(grid[node])

    @ti.func
    def add(p, t):
        at = x[p] * inv_dx
        base = ti.cast(at - 0.5, int)
        fx = at - base
        w = [0.5 * (1.5 - fx) ** 2, 0.75 - (fx - 1.0) ** 2, 0.5 * (fx - 0.5) ** 2]
        fp = f[p]
        tau = common.MU * (fp @ fp.transpose() - one) + one * (common.LAMBDA * ti.log(fp.determinant()))
        moment = (-dt * volume * 4 * inv_dx * inv_dx) * tau + mass * affine[p]
        momentum = mass * v[p]
        for offset in ti.static(ti.grouped(ti.ndrange(3, 3, 3))):
            apart = (offset - fx) * dx
            weight = w[offset[0]][0] * w[offset[1]][1] * w[offset[2]][2]
            share = weight * (momentum + moment @ apart)
            node = base + offset
            # not atomic, see above
            grid[t, node[0], node[1], node[2]] = grid[t, node[0], node[1], node[2]] + ti.Vector([share[0], share[1], share[2], weight * mass])

    @ti.kernel
    def to_grid():
        # taichi gives threads blocks of 512 turns of an outer loop: one of each block does the work of a thread
        for turn in range(512 * threads):
            if turn % 512 == 0:
                t = turn // 512
                for p in range(t * n // threads, (t + 1) * n // threads):
                    add(p, t)

    @ti.kernel
    def balance():
        for i, j, k in ti.ndrange(cells, cells, cells):
            sum = ti.Vector.zero(real, 4)
            for t in ti.static(range(threads)):
                sum += grid[t, i, j, k]
            if sum[3] > 0:
                for d in ti.static(range(3)):
                    sum[d] /= sum[3]
                sum[1] -= dt * common.GRAVITY
                node = ti.Vector([i, j, k])
                for d in ti.static(range(3)):
                    if node[d] < 3 and sum[d] < 0:
                        sum[d] = 0.0
                    if node[d] > cells - 4 and sum[d] > 0:
                        sum[d] = 0.0
            grid[0, i, j, k] = sum

    @ti.func
    def move(p):
        at = x[p] * inv_dx
        base = ti.cast(at - 0.5, int)
        fx = at - base
        w = [0.5 * (1.5 - fx) ** 2, 0.75 - (fx - 1.0) ** 2, 0.5 * (fx - 0.5) ** 2]
        new_v = ti.Vector.zero(real, 3)
        new_c = ti.Matrix.zero(real, 3, 3)
        for offset in ti.static(ti.grouped(ti.ndrange(3, 3, 3))):
            node = base + offset
            whole = grid[0, node[0], node[1], node[2]]
            g = ti.Vector([whole[0], whole[1], whole[2]])
            weight = w[offset[0]][0] * w[offset[1]][1] * w[offset[2]][2]
            new_v += weight * g
            new_c += (4 * weight * inv_dx) * g.outer_product(offset - fx)
        v[p] = new_v
        affine[p] = new_c
        x[p] += dt * new_v
        f[p] = (one + dt * new_c) @ f[p]

    @ti.kernel
    def to_particles_alone():
        ti.loop_config(serialize=True)
        for p in range(n):
            move(p)

    @ti.kernel
    def to_particles_shared():
        for p in range(n):
            move(p)

    @ti.kernel
    def rest():
        for p in range(n):
            f[p] = one

    to_particles = to_particles_alone if threads == 1 else to_particles_shared
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
