"""Independent references for the large-deformation problems of Tielen (2016), chapters 4 and 8.

The thesis integrates sigma' = (E - sigma) eps' with a volume that grows by (1 + eps'). In one dimension that
integrates exactly to  sigma = E (1 - 1/lambda), with lambda the stretch and the cross-section constant, so the
problem is the nonlinear wave equation  rho0 u_tt = d/dX [E (1 - 1/(1 + u_X))] + rho0 g.

bar      Fourier pseudospectral in X, DOP853 in t (rtol 1e-12): 13 digits, N = 64, 128, 256 agree.
column   4000 linear elements, velocity Verlet: displacements agree to 1e-7 m between 2000 and 4000 elements,
         velocities to 1e-4 m/s, stresses to 1 Pa.
shock    finite volumes (MUSCL, HLL) for the column under a top load, whose wave front is a shock: finite elements
         without dissipation ring behind it and do not tend to the solution with growing entropy.

usage: python generate.py   (numpy, scipy)   writes the CSV files beside it
"""
import csv
import pathlib

import numpy as np
from scipy.fft import dct, dst, idst
from scipy.integrate import solve_ivp

HERE = pathlib.Path(__file__).parent


def bar(times, points, young=50.0, density=25.0, length=1.0, v0=0.1, n=256):
    k = np.arange(1, n)

    def gradient(u):
        c = np.zeros(n + 1)
        c[1:n] = 0.5 * dst(u, type=1) / n * k * np.pi / length
        return dct(c, type=1)

    def rhs(_, y):
        u, v = y[: n - 1], y[n - 1 :]
        stress = young * (1 - 1 / (1 + gradient(u)))
        b = dct(stress, type=1) / n
        return np.r_[v, idst(-b[1:n] * k * np.pi / length * n, type=1) / density]

    x = np.arange(1, n) * length / n
    y0 = np.r_[0 * x, v0 * np.sin(np.pi * x / length)]
    y = solve_ivp(rhs, (0, max(times)), y0, method="DOP853", rtol=1e-12, atol=1e-14, t_eval=times).y
    for i, t in enumerate(times):
        a, b = dst(y[: n - 1, i], type=1) / n, dst(y[n - 1 :, i], type=1) / n
        for X in points:
            s, c = np.sin(k * np.pi * X / length), np.cos(k * np.pi * X / length)
            stress = young * (1 - 1 / (1 + c @ (a * k * np.pi / length)))
            yield t, X, s @ a, s @ b, stress


def column(times, points, young=1e5, density=1e3, gravity=-9.81, height=1.0, n=4000):
    h = height / n
    X = np.linspace(0, height, n + 1)
    mass = np.full(n + 1, density * h)
    mass[[0, -1]] *= 0.5
    u, v = np.zeros(n + 1), np.zeros(n + 1)

    def accelerate(u):
        stress = young * (1 - 1 / (1 + np.diff(u) / h))
        f = mass * gravity
        f[1:] -= stress
        f[:-1] += stress
        a = f / mass
        a[0] = 0
        return a, stress

    # steps of equal length between the times asked for, which lie equally far apart
    between = times[1] - times[0] if len(times) > 1 else times[0]
    each = int(np.ceil(between / (0.4 * h / np.sqrt(young / density))))
    dt = between / each
    wanted = {round(t / dt): t for t in times}
    a, stress = accelerate(u)
    if 0 in wanted:
        for p in points:
            yield 0.0, p, 0.0, 0.0, 0.0
    for step in range(1, max(wanted) + 1):
        v += 0.5 * dt * a
        u += dt * v
        a, stress = accelerate(u)
        v += 0.5 * dt * a
        if step in wanted:
            for p in points:
                yield wanted[step], p, np.interp(p, X, u), np.interp(p, X, v), np.interp(p, X[1:] - h / 2, stress)


def shock(times, points, young=1e5, density=1e3, top=-1e4, height=1.0, n=4000):
    h = height / n
    X = (np.arange(n) + 0.5) * h
    stretch, v, u = np.ones(n), np.zeros(n), np.zeros(n)
    stress_of = lambda s: young * (1 - 1 / s)
    speed_of = lambda s: np.sqrt(young / density) / s

    def slope(q, low, high):
        d = np.diff(np.r_[low, q, high])
        a, b = d[:-1], d[1:]
        return np.where(a * b > 0, 2 * a * b / np.where(a * b > 0, a + b, 1), 0)  # van Leer

    def rates(stretch, v):
        # ghosts: at rest below (the velocity is mirrored), loaded above
        top_stretch = 1 / (1 - top / young)
        ds = slope(stretch, stretch[0], 2 * top_stretch - stretch[-1])
        dv = slope(v, -v[0], v[-1])
        sl, sr = (stretch + 0.5 * ds)[:-1], (stretch - 0.5 * ds)[1:]
        vl, vr = (v + 0.5 * dv)[:-1], (v - 0.5 * dv)[1:]
        c = np.maximum(speed_of(sl), speed_of(sr))
        # HLL: stretch_t = v_X, density v_t = stress_X
        face_v = 0.5 * (vl + vr) + 0.5 * c * (sr - sl)
        face_p = 0.5 * (stress_of(sl) + stress_of(sr)) + 0.5 * density * c * (vr - vl)
        # ends: the wall does not move, the top carries its load; the other value follows along the characteristic that leaves
        wall_p = stress_of(stretch[0]) + density * speed_of(stretch[0]) * v[0]
        top_v = v[-1] + (top - stress_of(stretch[-1])) / (density * speed_of(stretch[-1]))
        face_v = np.r_[0, face_v, top_v]
        face_p = np.r_[wall_p, face_p, top]
        return np.diff(face_v) / h, np.diff(face_p) / h / density

    between = times[1] - times[0] if len(times) > 1 else times[0]
    each = int(np.ceil(between / (0.4 * h / (1.3 * np.sqrt(young / density)))))
    dt = between / each
    wanted = {round(t / dt): t for t in times}
    for step in range(max(wanted) + 1):
        if step in wanted:
            for p in points:
                # displacement by summing the stretch from the wall
                u = np.r_[0, np.cumsum((stretch - 1) * h)]
                yield (wanted[step], p, np.interp(p, np.linspace(0, height, n + 1), u), np.interp(p, X, v),
                       np.interp(p, X, stress_of(stretch)))
        a, b = rates(stretch, v)
        s1, v1 = stretch + dt * a, v + dt * b
        a, b = rates(s1, v1)
        stretch, v = 0.5 * (stretch + s1 + dt * a), 0.5 * (v + v1 + dt * b)


def write(name, rows):
    with open(HERE / name, "w", newline="") as f:
        out = csv.writer(f, lineterminator="\n")
        out.writerow(["time_s", "X_m", "displacement_m", "velocity_m_s", "stress_Pa"])
        out.writerows([f"{x:.14g}" for x in row] for row in rows)


if __name__ == "__main__":
    profile, curve = [0.1, 0.2, 0.3, 0.4, 0.5], np.linspace(0, 0.5, 251)
    write("tielen_bar_large.csv", bar(profile, np.linspace(0, 1, 65)))
    write("tielen_bar_middle.csv", bar(curve, [0.49609375]))
    write("tielen_column_large.csv", column(profile, np.linspace(0, 1, 33)))
    write("tielen_column_middle.csv", column(curve, [0.498046875]))
    write("tielen_column_top.csv", shock(curve, [0.5]))
