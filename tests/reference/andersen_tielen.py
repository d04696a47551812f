"""Independent references for columns T4, T5 of Tielen (2016) and beams A1, A2 of Andersen & Andersen (2007).

usage: OMP_NUM_THREADS=1 python andersen_tielen.py     (numpy, scipy; about 40 s)   writes the CSV files beside it

Nothing here is a finite element or material-point method. Every answer is computed at two resolutions; the largest
difference between them is printed as the error estimate. The columns are also checked against a finite-volume scheme.

THE COLUMNS (T4, T5)
    sigma = E (1 - 1/lambda) with a constant cross-section is the isothermal gas in disguise. With c0 = sqrt(E/rho),
    w = ln lambda and V = v - g t (the freely falling frame), the momentum balance and compatibility become
        R = V - c0 w  constant along  dX/dt = +c0/lambda,        S = V + c0 w  constant along  dX/dt = -c0/lambda,
    with or without gravity. A mesh of these characteristics (`characteristics`) therefore carries R and S exactly along
    its lines; only the places and times of its nodes are approximate (trapezoidal rule, second order). Kinks run along
    mesh lines, so interpolation never crosses one.

T4  starts from (X = 0, t = 0) with the front X = c0 t. No shock forms before 0.5 s (the script checks that
    characteristics of one family never cross).
T5  P'' = -2 E/lambda^3 < 0: compression steepens, so the load enters as a shock. With lambda1 = 1/(1 - p0/E) = 1/1.1:
        front 1   down  lambda 1 -> 1/1.1      U1 = sqrt([P]/(rho [lambda])) = c0 1.1^0.5 = 10.4881 m/s, v = -0.953463 m/s
        front 2   up    lambda 1/1.1 -> 1/1.21 U2 = c0 1.1^1.5 = 11.5369 m/s, behind it rest and -21 kPa
    At t2 = H/U1 + H/U2 = 0.182025 s the column is at rest and uniform, and the top unloads it by a centred rarefaction.
    From there on a mesh of characteristics from (H, t2) again; the fan, reflected as compression from the loaded top,
    focuses into a shock only at 0.537 s (the script checks that none forms before 0.5 s). So this is the entropy
    solution, with sharp fronts. It dissipates at the two shocks; an inviscid scheme rings behind them and must be
    compared in the L1 norm.

THE BEAMS (A1, A2): linear elastodynamics, plane strain, per metre of thickness. Ritz with tensor Legendre polynomials
    (times x for the clamp), split by symmetry, generalised eigenproblem, every mode integrated exactly in time.
    Deflections are positive downwards. In A2 the body force on the corner particle is integrated over its square of
    1/6 m x 1/6 m. As nu = 0, the smallest exponent of the clamped corners is 1, so the stress stays bounded and
    convergence is quick though algebraic.

ERRORS
    T4  mesh of 1000 / 2000 lines, largest: 3.1e-9 m, 8.3e-8 m/s, 1.0e-3 Pa; mean: 1.4e-9 m, 2.0e-8 m/s, 2.3e-4 Pa.
        Finite volumes, 1000 -> 2000 cells, mean distance to it: 1.7e-7 -> 4.3e-8 m, 0.31 -> 0.094 Pa (second order).
    T5  mesh of 1000 / 2000 lines, largest: 1.1e-9 m, 1.8e-7 m/s, 1.9e-3 Pa; mean (L1 in time): 3.8e-10 m, 4.0e-9 m/s,
        4.2e-5 Pa. Finite volumes, 1000 -> 2000 cells, mean distance: 6.7e-6 -> 3.3e-6 m, 20 -> 8.3 Pa (first order).
    A2  degrees (80, 24) / (96, 32), largest: axis 7.8e-11 m static, 7.7e-11 m at 20 s (3e-8 of the tip), tip history
        8.2e-11 m, stress 1.6e-4 Pa of 15.8 Pa (beside the loaded square; 8.8e-5 Pa for x < 7), period 5e-9 s.
    A1  degrees (64, 24) / (96, 32), largest: 8.4e-8 J/m of 0.125 J/m; period 6e-14 s.
"""
import csv
import pathlib
import time

import numpy as np
from numpy.polynomial import legendre
from scipy.linalg import eigh

HERE = pathlib.Path(__file__).parent
TIMES = np.linspace(0, 0.5, 201)


def write(name, header, *columns):
    with open(HERE / name, "w", newline="") as f:
        out = csv.writer(f)
        out.writerow(header.split())
        out.writerows([f"{x + 0.0:.12g}" for x in row] for row in zip(*columns))


# ---------------------------------------------------------------------------------------------------- the columns
def characteristics(n, fan, points, t_end, c0, height, g, near, far, w0, w_fan, t0):
    """Characteristic mesh of a uniform column at rest (stretch exp(w0)) disturbed at its end X = 0 from t0 on.

    near, far  condition at X = 0 and X = height: None holds the end, a number prescribes w there.
    n, fan     mesh lines in all / in the centred wave at (0, t0), where w goes from w0 to w_fan.
    Node (i, j): the outgoing line i (invariant R[i]) meets the incoming line j (S[j]). Line i comes back from the far
    end as incoming line i + n, and leaves the near end again as outgoing line i + n. Nodes with equal i + j form a
    level, on which d = j - i says where the node is; a node is found from its neighbours d - 1 and d + 1 a level below.
    Returns for each point the times at which mesh lines cross it, with V and w there (V = v - g (t - t0)).
    """
    levels = int(8 * n * (t_end - t0) * c0 / height) + 4 * n
    R, S = np.full(levels + 1, np.nan), np.full(levels + n + 1, np.nan)
    S[: n + 1] = c0 * w0
    R[: fan + 1] = S[0] - 2 * c0 * np.linspace(w0, w_fan, fan + 1)
    speed = lambda w: c0 * np.exp(-w)
    front = height * np.maximum(0, np.arange(n + 1) - fan) / (n - fan)
    X, t = front.copy(), t0 + front / speed(w0)
    w = np.full(n + 1, float(w0))
    marks = [[] for _ in points]
    ahead = t0 + np.zeros(n + 1)
    for level in range(1, levels):
        last = min(level, n)
        d = np.arange(level % 2, last + 1, 2)
        i, j = (level - d) // 2, (level + d) // 2
        old = X.copy(), t.copy(), w.copy()
        if d[0] == 0:                                               # near end
            k = i[0]
            if k > fan:
                wb = w[1]
                for _ in range(30):
                    tb = t[1] + 2 * X[1] / (speed(w[1]) + speed(wb))
                    V = -g * (tb - t0) if near is None else S[k] - c0 * near
                    wb = (S[k] - V) / c0
                R[k] = V - c0 * wb
            else:
                tb, wb = t0, (S[k] - R[k]) / (2 * c0)
            X[0], t[0], w[0] = 0, tb, wb
        if d[-1] == n and i[-1] > 0:                                # far end
            k = i[-1]
            wb = w[n - 1]
            for _ in range(30):
                tb = t[n - 1] + 2 * (height - X[n - 1]) / (speed(w[n - 1]) + speed(wb))
                V = -g * (tb - t0) if far is None else R[k] + c0 * far
                wb = (V - R[k]) / c0
            S[k + n] = V + c0 * wb
            X[n], t[n], w[n] = height, tb, wb
        m = d[(d > 0) & (d < n) & (i > 0)]
        if m.size:                                                  # inside
            a, b = m - 1, m + 1
            wm = (S[(level + m) // 2] - R[(level - m) // 2]) / (2 * c0)
            cm = speed(wm)
            ca, cb = 0.5 * (speed(old[2][a]) + cm), 0.5 * (speed(old[2][b]) + cm)
            tm = (old[0][b] - old[0][a] + ca * old[1][a] + cb * old[1][b]) / (ca + cb)
            X[m], t[m], w[m] = old[0][a] + ca * (tm - old[1][a]), tm, wm
            tiny = 1e-12
            assert (tm > old[1][a] - tiny).all() and (tm > old[1][b] - tiny).all(), "characteristics cross: shock"
        if d[0] == 0 and level > 2:
            assert t[0] >= ahead[0] - 1e-12, "characteristics cross at the near end: shock"
            ahead[0] = t[0]
        # where the edges that end on this level cross the points
        for p, mark in zip(points, marks):
            for step in (-1, +1):
                e = d[(d + step >= 0) & (d + step <= last)]
                lo, hi = (old[0][e - 1], X[e]) if step < 0 else (X[e], old[0][e + 1])
                for q in e[(lo <= p) & (p < hi)]:
                    s = q + step
                    f = (p - old[0][s]) / (X[q] - old[0][s])
                    iq, jq, is_, js = (level - q) // 2, (level + q) // 2, (level - 1 - s) // 2, (level - 1 + s) // 2
                    r = R[is_] + f * (R[iq] - R[is_])
                    l = S[js] + f * (S[jq] - S[js])
                    mark.append((old[1][s] + f * (t[q] - old[1][s]), 0.5 * (r + l), (l - r) / (2 * c0)))
        if level > n and t.min() > t_end:
            break
    else:
        raise RuntimeError("mesh ended early")
    return [np.array(sorted(m)).T for m in marks]


def sample(mark, times, t0, w0):
    """Integral of V from t0, V and w at the times, piecewise linear between the crossings of mesh lines."""
    t, V, w = np.c_[[t0, 0, w0], [mark[0][0], 0, w0], mark]
    U = np.r_[0, np.cumsum(0.5 * (V[1:] + V[:-1]) * np.diff(t))]
    k = np.clip(np.searchsorted(t, times, side="right") - 1, 0, len(t) - 2)
    v, ww = np.interp(times, t, V), np.interp(times, t, w)
    return U[k] + 0.5 * (V[k] + v) * (times - t[k]), v, ww


def column_weight(points, n, young=1e5, density=1e3, height=1.0, g=-9.81):
    marks = characteristics(n, 0, points, TIMES[-1], np.sqrt(young / density), height, g, None, 0.0, 0.0, 0.0, 0.0)
    for mark in marks:
        u, v, w = sample(mark, TIMES, 0.0, 0.0)
        yield u + 0.5 * g * TIMES**2, v + g * TIMES, young * (1 - np.exp(-w))


def fronts(young=1e5, density=1e3, p0=-1e4):
    """Stretch behind the first and the second front of T5 and their Rankine-Hugoniot speeds."""
    l1 = 1 / (1 - p0 / young)
    l2 = l1 * l1                                  # the rigid end doubles the jump of velocity, hence l2/l1 = l1/1
    P = lambda l: young * (1 - 1 / l)
    speed = lambda a, b: np.sqrt((P(b) - P(a)) / (b - a) / density)
    return l1, l2, speed(1, l1), speed(l1, l2)


def column_load(points, n, young=1e5, density=1e3, height=1.0, p0=-1e4):
    c0 = np.sqrt(young / density)
    l1, l2, U1, U2 = fronts(young, density, p0)
    v1 = -U1 * (1 - l1)
    t1 = height / U1
    t2 = t1 + height / U2
    # mirrored: the loaded end is the near end
    marks = characteristics(n, n // 4, [height - p for p in points], TIMES[-1], c0, height, 0.0, np.log(l1), None,
                            np.log(l2), np.log(l1), t2)
    for p, mark in zip(points, marks):
        a, b = (height - p) / U1, t1 + p / U2     # the two fronts pass
        U, V, w = sample(mark, np.maximum(TIMES, t2), t2, np.log(l2))
        stress = young * (1 - np.exp(-w))
        late = TIMES >= t2
        middle = (TIMES >= a) & (TIMES < b)
        early = TIMES < a
        v = np.where(late, -V, np.where(middle, v1, 0.0))
        u = np.clip(TIMES - a, 0, b - a) * v1 - np.where(late, U, 0)
        yield u, v, np.where(early, 0.0, np.where(middle, p0, stress))


def finite_volume(points, n, young=1e5, density=1e3, height=1.0, g=0.0, p0=0.0):
    """Check: conservative MUSCL (van Leer limiter, HLL flux, SSP Runge-Kutta 2) for stretch and velocity."""
    h, c0 = height / n, np.sqrt(young / density)
    P = lambda l: young * (1 - 1 / l)
    w_top = -np.log(1 - p0 / young)

    def rate(y):
        d = np.diff(y, axis=1)
        ab = d[:, 1:] * d[:, :-1]
        s = np.zeros_like(y)
        s[:, 1:-1] = np.where(ab > 0, ab / np.where(ab > 0, d[:, 1:] + d[:, :-1], 1), 0)      # half the limited slope
        (lL, vL), (lR, vR) = (y + s)[:, :-1], (y - s)[:, 1:]
        c = c0 / np.minimum(lL, lR)
        F = np.empty((2, n + 1))
        F[0, 1:-1] = -0.5 * (vL + vR) - 0.5 * c * (lR - lL)
        F[1, 1:-1] = -0.5 * (P(lL) + P(lR)) / density - 0.5 * c * (vR - vL)
        (l, v), (lt, vt) = (y - s)[:, 0], (y + s)[:, -1]
        F[:, 0] = 0, -P(np.exp(np.log(l) + v / c0)) / density
        F[:, -1] = -(vt + c0 * (w_top - np.log(lt))), -p0 / density
        r = -np.diff(F, axis=1) / h
        r[1] += g
        return r

    y = np.array([np.ones(n), np.zeros(n)])
    centres = (np.arange(n) + 0.5) * h
    inner = int(np.ceil(np.diff(TIMES)[0] / (0.4 * h / (1.3 * c0))))
    dt = np.diff(TIMES)[0] / inner
    u = np.zeros(n)
    rows = []
    for k in range(len(TIMES)):
        rows.append([(np.interp(p, centres, u), np.interp(p, centres, y[1]), np.interp(p, centres, P(y[0]))) for p in points])
        for _ in range(inner if k + 1 < len(TIMES) else 0):
            y1 = y + dt * rate(y)
            new = 0.5 * (y + y1 + dt * rate(y1))
            u = u + 0.5 * dt * (y[1] + new[1])
            y = new
    return [np.array(r).T for r in zip(*rows)]


def columns():
    header = "time_s X_m displacement_m velocity_m_s stress_Pa"
    units = ("m", "m/s", "Pa")
    l1, l2, U1, U2 = fronts()
    print(f"T5 Rankine-Hugoniot speeds {U1:.7f} m/s down (velocity behind it {-U1 * (1 - l1):.7f} m/s), {U2:.7f} m/s up "
          f"(stress behind it {1e5 * (1 - 1 / l2):.3f} Pa); the second one reaches the top at {1 / U1 + 1 / U2:.7f} s")
    cases = [("T4", "tielen_column_middle.csv", column_weight, [0.5 - 1 / 512], dict(g=-9.81)),
             ("T5", "tielen_column_top.csv", column_load, [0.5 - 1 / 2048, 0.5 - 0.5 / 3200], dict(p0=-1e4))]
    for case, name, solve, points, load in cases:
        coarse, fine = (np.array(list(solve(points, n))) for n in (1000, 2000))
        checks = [np.array(finite_volume(points, n, **load)) for n in (1000, 2000)]
        show = lambda e: ", ".join(f"{x:.1e} {unit}" for x, unit in zip(e, units))
        print(f"{case} mesh of 1000 / 2000 lines, largest difference: {show(abs(fine - coarse).max(axis=(0, 2)))}")
        print(f"{case} mesh of 1000 / 2000 lines, mean difference:    {show(abs(fine - coarse).mean(axis=(0, 2)))}")
        for n, check in zip((1000, 2000), checks):
            print(f"{case} against finite volumes, {n} cells, mean: {show(abs(fine - check).mean(axis=(0, 2)))}; "
                  f"largest: {show(abs(fine - check).max(axis=(0, 2)))}")
        write(name, header, np.tile(TIMES, len(points)), np.repeat(points, len(TIMES)),
              *np.concatenate(fine, axis=1))


# ------------------------------------------------------------------------------------------------------ the beams
class Line:
    """Polynomials up to degree n on [0, length]: normalised Legendre, or those that vanish at 0."""

    def __init__(self, n, length, clamped):
        self.length = length
        rows = np.eye(n + 1) * np.sqrt((2 * np.arange(n + 1) + 1) / length)[:, None]
        if clamped:
            rows = (np.eye(n + 1) + np.eye(n + 1, k=-1))[1:] * np.sqrt(np.arange(1, n + 1) / (2 * length))[:, None]
        self.rows = rows
        x, w = self.gauss(0, length, n + 2)
        f, g = self(x), self(x, 1)
        self.M, self.C, self.K = (f * w) @ f.T, (g * w) @ f.T, (g * w) @ g.T

    def gauss(self, a, b, n):
        x, w = legendre.leggauss(n)
        return a + (b - a) * (x + 1) / 2, w * (b - a) / 2

    def __call__(self, x, derivative=0):
        s = 2 * np.asarray(x) / self.length - 1
        rows = legendre.legder(self.rows.T, axis=0) * 2 / self.length if derivative else self.rows.T
        return legendre.legval(s, rows)

    def integral(self, f, a, b):
        x, w = self.gauss(a, b, self.rows.shape[1] + 20)
        return self(x) @ (w * f(x))


class Ritz:
    """Modes of a rectangular plane-strain beam, for one symmetry class: which products of X and Y make u, which v."""

    def __init__(self, X, Y, u_class, v_class, young, nu, density):
        i, j = (a.ravel() for a in np.indices((len(X.rows), len(Y.rows))))
        self.X, self.Y = X, Y
        self.u, self.v = ((i[c(i, j)], j[c(i, j)]) for c in (u_class, v_class))
        G = young / (2 * (1 + nu))
        D12 = young * nu / ((1 + nu) * (1 - 2 * nu))
        D11 = D12 + 2 * G
        pick = lambda A, B, p, q: A[np.ix_(p[0], q[0])] * B[np.ix_(p[1], q[1])]
        u, v = self.u, self.v
        uu = D11 * pick(X.K, Y.M, u, u) + G * pick(X.M, Y.K, u, u)
        vv = D11 * pick(X.M, Y.K, v, v) + G * pick(X.K, Y.M, v, v)
        uv = D12 * pick(X.C, Y.C.T, u, v) + G * pick(X.C.T, Y.C, u, v)
        zero = np.zeros_like(uv)
        K = np.block([[uu, uv], [uv.T, vv]])
        M = density * np.block([[pick(X.M, Y.M, u, u), zero], [zero.T, pick(X.M, Y.M, v, v)]])
        # M a = mu K a with a' K a = 1 and mu = 1/omega^2: the low modes get full relative accuracy
        self.mu, self.modes = eigh(M, K)
        self.mu = np.maximum(self.mu, 1e-30)
        self.omega = 1 / np.sqrt(self.mu)
        self.first_period = 2 * np.pi / self.omega[-1]

    def force(self, fu, fv):
        """Modal forces; fu and fv are None or the integrals (over x, over y) of a product load with X and Y."""
        f = [np.zeros(len(p[0])) if q is None else q[0][p[0]] * q[1][p[1]] for p, q in ((self.u, fu), (self.v, fv))]
        return self.modes.T @ np.r_[f[0], f[1]]

    def field(self, component, x, y, dx=0):
        """Rows: modes. Columns: u or v, or its x derivative, at the points."""
        p = getattr(self, component)
        part = self.modes[: len(self.u[0])] if component == "u" else self.modes[len(self.u[0]) :]
        return part.T @ (self.X(x, dx)[p[0]] * self.Y(y)[p[1]])


def odd(k):
    return k % 2 == 1


def even(k):
    return k % 2 == 0


def cantilever(nx, ny, x, y, times, length=8.0, height=1.0, young=3e5, density=1e3, force=100.0, end=20.0):
    """Static deflection of the axis at x, the same at `end`, tip history, sigma_xx at (x, y) at `end`, periods."""
    X, Y = Line(nx, length, True), Line(ny, height, False)
    a = 1 / 6
    P = force * a * a / (length * height)
    one = np.ones_like
    load = -P / a**2 * X.integral(one, length - a, length), Y.integral(one, height - a, height)
    axis = np.full_like(x, height / 2)
    out, periods = None, []
    for u_class, v_class in ((odd, even), (even, odd)):             # bending; stretching
        r = Ritz(X, Y, lambda i, j: u_class(j), lambda i, j: v_class(j), young, 0.0, density)
        f = r.force(None, load)
        ramp = lambda t: (t - np.sin(r.omega * t) / r.omega) / end
        down = -r.field("v", x, axis)
        tip = -r.field("v", np.array([length]), np.array([height / 2]))[:, 0]
        gx, gy = np.meshgrid(x, y, indexing="ij")
        stress = young * r.field("u", gx.ravel(), gy.ravel(), 1)
        parts = [f @ down, (f * ramp(end)) @ down, np.array([(f * ramp(t)) @ tip for t in times]),
                 (f * ramp(end)) @ stress, np.array([f @ tip])]
        out = parts if out is None else [p + q for p, q in zip(out, parts)]
        periods.append(r.first_period)
    return out, periods, P


def cantilevers(coarse=(80, 24), fine=(96, 32)):
    length, height, young = 8.0, 1.0, 3e5
    x, y = (np.arange(48) + 0.5) / 6, (np.arange(6) + 0.5) / 6
    times = np.arange(201) / 10
    (old, old_T, _), (new, T, P) = (cantilever(*n, x, y, times) for n in (coarse, fine))
    I = height**3 / 12
    s = length - x                                                  # the paper measures from the loaded end
    formula = P / (6 * young * I) * (s**3 - 3 * length**2 * s + 2 * length**3)
    static, dynamic, tip, stress, static_tip = new
    difference = [abs(p - q).max() for p, q in zip(old, new)]
    print(f"A2 P = {P:.7f} N/m, degrees {coarse} / {fine}; first bending period {T[0]:.6f} s ({T[0] - old_T[0]:+.1e}), "
          f"first axial period {T[1]:.6f} s")
    print(f"A2 static tip deflection {static_tip[0]:.9e} m (formula {P * length**3 / (3 * young * I):.9e}), largest "
          f"difference along the axis {difference[0]:.1e} m = {difference[0] / static_tip[0]:.1e} of the tip")
    print(f"A2 tip deflection at 20 s {tip[-1]:.9e} m = {tip[-1] / static_tip[0]:.6f} static; largest difference along "
          f"the axis {difference[1]:.1e} m = {difference[1] / tip[-1]:.1e} of the tip, over the history {difference[2]:.1e} m")
    error = abs(old[3] - stress).reshape(48, 6)
    print(f"A2 stress: extremes {stress.min():.4f}, {stress.max():.4f} Pa, rms {np.sqrt((stress**2).mean()):.4f} Pa; "
          f"largest difference {error.max():.1e} Pa at x, y = "
          f"{x[np.unravel_index(error.argmax(), error.shape)[0]]:.3f}, {y[np.unravel_index(error.argmax(), error.shape)[1]]:.3f}"
          f" (x < 7: {error[x < 7].max():.1e} Pa)")
    write("andersen_cantilever.csv", "x_m static_deflection_m dynamic_deflection_m formula_deflection_m",
          x, static, dynamic, formula)
    write("andersen_cantilever_tip.csv", "time_s tip_deflection_m", times, tip)
    gx, gy = np.meshgrid(x, y, indexing="ij")
    write("andersen_cantilever_stress.csv", "x_m y_m stress_Pa", gx.ravel(), gy.ravel(), stress)


def bar(nx, ny, times, length=5.0, height=1.0, young=1e4, nu=0.3, density=1e3, v0=0.01):
    X, Y = Line(nx, length, False), Line(ny, height, False)
    r = Ritz(X, Y, lambda i, j: odd(i) & even(j), lambda i, j: even(i) & odd(j), young, nu, density)
    start = v0 * density * X.integral(lambda x: np.cos(np.pi * x / length), 0, length), Y.integral(np.ones_like, 0, height)
    a = r.force(start, None)                                        # momentum of each mode
    energy = 0.5 * a**2 / r.mu
    wt = np.outer(times, r.omega)
    return np.cos(wt) ** 2 @ energy, np.sin(wt) ** 2 @ energy, r.first_period


def bars(coarse=(64, 24), fine=(96, 32)):
    times = np.arange(401) / 50
    (k0, s0, T0), (k, s, T) = (bar(*n, times) for n in (coarse, fine))
    print(f"A1 degrees {coarse} / {fine}; first period {T:.8f} s ({T - T0:+.1e}); energy {k[0]:.10f} J/m (exact 0.125); "
          f"largest difference of the energies {max(abs(k - k0).max(), abs(s - s0).max()):.1e} J/m, "
          f"mean {abs(s - s0).mean():.1e} J/m")
    write("andersen_bar.csv", "time_s kinetic_energy_J_m strain_energy_J_m", times, k, s)


if __name__ == "__main__":
    for part in (columns, cantilevers, bars):
        clock = time.perf_counter()
        part()
        print(f"   {time.perf_counter() - clock:.0f} s")
