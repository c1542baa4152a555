#!/usr/bin/env python3
"""The measured impacts of cases/planar-impacts: consistency of the data, and fits of closed-form laws.

    verification/references/planar_impacts.py planar-impacts.csv

Prints the numbers of the case's README: the convention of signs, outliers, the scatter of nearly equal
states, the dependence of restitution and friction on the state; then Newton's, Poisson's, the energetic and
the compliant law with constants fitted to one half of the rows (by the least sum of residuals, a simplex
search) and judged on the other, and the misfit of the compliant law over its stiffness ratio. Shares nothing with the program: per unit of mass,

    u_N = v_y + n omega,  u_T = v_x + d omega,  D_NN = 1 + n^2/rho^2,  D_NT = n d/rho^2,  D_TT = 1 + d^2/rho^2,

Newton's law by its cases; Poisson's and the energetic law by Routh's piecewise linear path over the normal
impulse; the compliant law by the midpoint rule with the spring's force limited to friction.
Needs NumPy.
"""
import itertools
import sys

import numpy as np

RHO = 0.0192  # m, radius of gyration
WEIGHT = np.array([1, 1, RHO])

data = np.genfromtxt(sys.argv[1], delimiter=",", names=True)
state = lambda k: np.c_[data[f"vx{k}"], data[f"vy{k}"], data[f"omega{k}"]]


def best_impulse(before, after, n, d, rho=RHO):
    """What the best impulse at the contact leaves of the jump, m/s: the part along the normal of the plane of
    all possible jumps (v_x, v_y, rho omega)."""
    jump = after - before
    return (rho * jump[:, 2] - d / rho * jump[:, 0] - n / rho * jump[:, 1]) / np.sqrt(1 + (d * d + n * n) / rho**2)


print("residual of the best impulse, median (90 %), m/s, by what is reversed:")
n, d = data["n_theta"], data["d_theta"]
radii = (0.018, 0.0185, 0.019, 0.0192, 0.0195, 0.02, 0.0215)
print("reversed             " + "".join(f"{1e3 * r:>15.1f} mm" for r in radii))
for name, sx, sn in (("nothing", 1, 1), ("v_x (or d)", -1, 1), ("omega (or v_x and n)", -1, -1), ("n", 1, -1)):
    left = [np.abs(best_impulse(state(0) * [sx, 1, 1], state(1) * [sx, 1, 1], sn * n, d, r)) for r in radii]
    print(f"{name:<21}" + "".join(f"{np.median(x):>9.3f} ({np.percentile(x, 90):.3f})" for x in left))
others = []
for a, b in itertools.product(itertools.product((1, -1), repeat=3), repeat=2):
    if a[1] == 1 and a != b:
        others.append((np.median(np.abs(best_impulse(state(0) * a, state(1) * b, n, d))), a, b))
print("least of the 28 with different signs before and after: %.3f %s %s" % min(others))

before, after = state(0) * [-1, 1, 1], state(1) * [-1, 1, 1]
left = best_impulse(before, after, n, d)
deviation = 1.4826 * np.median(np.abs(left))
used = np.abs(left) < 0.406
print(f"standard deviation of this residual {deviation:.4f} m/s (from the median); beyond five: {np.sum(~used)} rows, "
      f"lines {', '.join(str(i + 2) for i in np.flatnonzero(~used))}")
before, after, n, d, left = before[used], after[used], n[used], d[used], left[used]
u_n, u_t = before[:, 1] + n * before[:, 2], before[:, 0] + d * before[:, 2]
nn, nt, tt = 1 + n * n / RHO**2, n * d / RHO**2, 1 + d * d / RHO**2
slip, incidence, lever = np.abs(u_t), np.abs(u_t / u_n), 1e3 * n * np.sign(u_t)
print(f"{len(n)} rows; jump {np.median(np.linalg.norm((after - before) * WEIGHT, axis=1)):.3f} m/s, best impulse "
      f"{np.median(np.abs(left)):.4f} m/s ({np.percentile(np.abs(left), 90):.3f})")

# Scatter of nearly equal states: the difference of two independent outcomes has sqrt(2) of the size of one.
place = np.c_[before * WEIGHT, 3 * n / RHO, 3 * d / RHO]  # m/s; an arm counts by the speed of 3 m/s
away = np.linalg.norm(place[:, None] - place[None], axis=2)
np.fill_diagonal(away, np.inf)
pair = np.argmin(away, axis=1)
apart = np.linalg.norm((after - after[pair]) * WEIGHT, axis=1) / np.sqrt(2)
for limit in (0.03, 0.05, 0.1, 0.2):
    near = away[np.arange(len(n)), pair] < limit
    print(f"nearest states closer than {limit} m/s: {near.sum()} rows, scatter {np.median(apart[near]):.3f} m/s "
          f"({np.percentile(apart[near], 90):.3f})")

# Restitution and ratio of impulses of each row, from its best impulse.
plane = np.zeros((len(n), 3, 2))
plane[:, 0, 1] = plane[:, 1, 0] = 1
plane[:, 2, 0], plane[:, 2, 1] = n / RHO, d / RHO
jump = (after - before) * WEIGHT
p_n, p_t = np.linalg.solve(np.einsum("nij,nik->njk", plane, plane), np.einsum("nij,ni->nj", plane, jump)).T
e, ratio = -(u_n + nn * p_n + nt * p_t) / u_n, -p_t / p_n * np.sign(u_t)
slides = (u_t + nt * p_n + tt * p_t) * np.sign(u_t) > 0.1
print("e, quartiles:", np.round(np.percentile(e, [25, 50, 75]), 3))
X = np.c_[np.ones(len(n)), np.log(-u_n), slip]
fit = np.linalg.lstsq(X, np.log(e), rcond=None)[0]
error = np.sqrt(np.diag(np.linalg.inv(X.T @ X)) * np.var(np.log(e) - X @ fit))
print(f"ln e = {fit[0]:.2f} {fit[1]:+.2f} ln u_N {fit[2]:+.3f} u_T, standard errors {error[1]:.2f}, {error[2]:.3f}")
for low, high in ((0, 0.3), (0.3, 0.5), (0.5, 0.65), (0.65, 0.8), (0.8, 9)):
    k = (slip >= low) & (slip < high)
    print(f"slip {low} to {high} m/s: {k.sum()} rows, e {np.median(e[k]):.3f}; {np.sum(k & slides)} slide on, "
          f"ratio of impulses {np.median(ratio[k & slides]):.3f}")


def moved(p_n, p_t):
    return before + np.c_[p_t, p_n, (n * p_n + d * p_t) / RHO**2]


def newton(e, mu, e_t=0.0):
    a, b, det = -(1 + e) * u_n, -(1 + e_t) * u_t, nn * tt - nt**2
    p_n, p_t = (tt * a - nt * b) / det, (nn * b - nt * a) / det
    done = np.abs(p_t) <= mu * p_n
    for s in (1, -1):
        q = a / (nn - s * mu * nt)
        valid = ~done & (s * (u_t * (1 + e_t) + nt * q - s * mu * tt * q) >= 0)
        p_n, p_t, done = np.where(valid, q, p_n), np.where(valid, -s * mu * q, p_t), done | valid
    return moved(p_n, p_t)


def routh(e, mu, energetic):
    s = np.sign(u_t)
    first = -mu * s
    slope = nt + first * tt
    with np.errstate(divide="ignore", invalid="ignore"):
        end = np.where(slope * s < 0, -u_t / slope, np.inf)  # of the first slip
    second = np.where(np.abs(nt / tt) <= mu, -nt / tt, -mu * np.sign(nt))
    a, b = nn + first * nt, nn + second * nt
    part = lambda p: (np.minimum(p, end), np.maximum(p - end, 0))
    rate = lambda p: u_n + a * part(p)[0] + b * part(p)[1]
    finite = np.where(np.isfinite(end), end, 0)
    pressed = np.where((u_n + a * finite >= 0) | ~np.isfinite(end), -u_n / a, finite - (u_n + a * finite) / b)
    if not energetic:
        p = (1 + e) * pressed
    else:
        work = lambda p: u_n * part(p)[0] + a * part(p)[0]**2 / 2 + (u_n + a * part(p)[0]) * part(p)[1] + b * part(p)[1]**2 / 2
        need = -e * e * work(pressed)
        within = pressed + np.sqrt(2 * need / a)
        at_end = np.where(np.isfinite(end) & (pressed < end), rate(finite), 0)
        rest = np.where(pressed < end, need - np.where(np.isfinite(end), work(finite) - work(pressed), 0), need)
        beyond = np.where(pressed < end, finite, pressed) + (-at_end + np.sqrt(np.maximum(at_end**2 + 2 * b * rest, 0))) / b
        p = np.where((pressed < end) & (within <= end), within, beyond)
    one, two = part(p)
    return moved(p, first * one + second * two)


def compliant(e, mu, kappa, steps=600):
    un, ut, force, q = u_n.copy(), u_t.copy(), 0 * n, 0 * n
    p_n, p_t, most, on = 0 * n, 0 * n, 0 * n, np.ones(len(n), bool)
    h = 2.2 * np.pi / np.sqrt(nn.min()) / steps
    for _ in range(steps):
        k = np.where((force >= most - 1e-15) & (un < 0), 1.0, 1 / e**2)
        f = np.maximum(force - k * un * h / 2, 0)
        t = -kappa * np.clip(q + ut * h / 2, -mu * f / kappa, mu * f / kappa)
        p_n, p_t = p_n + on * f * h, p_t + on * t * h
        n_mid, t_mid = un + (nn * f + nt * t) * h / 2, ut + (nt * f + tt * t) * h / 2
        un, ut = un + on * (nn * f + nt * t) * h, ut + on * (nt * f + tt * t) * h
        following = force - k * n_mid * h
        ends = on & (following <= 0) & (un > 0)
        force = np.where(on, np.maximum(following, 0), force)
        most = np.maximum(most, force)
        q = np.where(on, np.clip(q + t_mid * h, -mu * force / kappa, mu * force / kappa), q)
        on &= ~ends
        if not on.any():
            break
    return moved(p_n, p_t)


def simplex(f, x, size=0.1, most=400):
    """Nelder and Mead, Computer Journal 7 (1965) 308."""
    points = [(f(x), x)] + [(f(y), y) for y in (x + size * row for row in np.eye(len(x)))]
    for _ in range(most):
        points.sort(key=lambda p: p[0])
        if max(np.abs(points[-1][1] - points[0][1])) < 1e-5:
            break
        middle = np.mean([p[1] for p in points[:-1]], axis=0)
        tried = lambda c: (lambda y: (f(y), y))(middle + c * (middle - points[-1][1]))
        one = tried(1)
        if one[0] < points[0][0]:
            points[-1] = min(one, tried(2), key=lambda p: p[0])
        elif one[0] < points[-2][0]:
            points[-1] = one
        else:
            inner = tried(0.5 if one[0] < points[-1][0] else -0.5)
            if inner[0] < min(one[0], points[-1][0]):
                points[-1] = inner
            else:
                points = [points[0]] + [(f(y), y) for y in (points[0][1] + (p[1] - points[0][1]) / 2 for p in points[1:])]
    return points[0][1]


laws = {
    "newton": (newton, ("e", "mu"), (0.58, 0.19)),
    "tangential": (newton, ("e", "mu", "e_T"), (0.58, 0.19, 0.2)),
    "poisson": (lambda e, mu: routh(e, mu, False), ("e", "mu"), (0.58, 0.19)),
    "energetic": (lambda e, mu: routh(e, mu, True), ("e", "mu"), (0.58, 0.19)),
    "energetic-speed": (lambda v, mu: routh(np.minimum(1, (-u_n / abs(v))**-0.25), mu, True), ("v_y", "mu"), (0.31, 0.19)),
    "compliant": (lambda e, mu, kappa: compliant(e, mu, np.exp(kappa)), ("e", "mu", "ln kappa"), (0.59, 0.19, 1.0)),
}
classes = (("incidence", incidence, (0.1, 0.2, 0.3, 0.4)), ("slip", slip, (0.3, 0.5, 0.65, 0.8)),
           ("approach", -u_n, (2.4, 2.55, 2.7)), ("lever", lever, (-6, -2, 2, 6)))
half = np.arange(len(n)) % 2


def sum_without(law, part):
    """The sum of residuals of the rows of the other part, over the constants."""
    def total(x):
        with np.errstate(all="ignore"):
            r = np.linalg.norm((law(*np.r_[np.clip(x[:2], 0.01, 1), np.clip(x[2:], -3, 4)]) - after) * WEIGHT, axis=1)
        r = r[half != part].sum()
        return r if np.isfinite(r) else np.inf
    return total


for name, (law, names, start) in laws.items():
    residual = np.empty(len(n))
    for part in (0, 1):
        x = simplex(sum_without(law, part), np.array(start))
        predicted = np.linalg.norm((law(*x) - after) * WEIGHT, axis=1)
        residual[half == part] = predicted[half == part]
        print(f"{name} without part {part}: " + ", ".join(f"{a} = {b:.4f}" for a, b in zip(names, x)))
    print(f"  predicted: median {np.median(residual):.4f}, 90 % {np.percentile(residual, 90):.4f}")
    for label, value, edges in classes:
        k = np.searchsorted(edges, value, side="right")
        print(f"  {label}: " + "; ".join(f"{np.median(residual[k == i]):.3f} ({np.percentile(residual[k == i], 90):.3f}, {np.sum(k == i)})" for i in range(len(edges) + 1) if np.sum(k == i) >= 10))

print("compliant, least sum of residuals with a given kappa, fitted to odd rows; to even rows, m/s:")
for kappa in (1, 2, 3, 4, 5, 6.5, 7.5, 8.6, 10, 11.6, 13, 15, 20, 30):
    least = []
    for part in (0, 1):
        total = sum_without(laws["compliant"][0], part)
        least.append(total(np.r_[simplex(lambda x: total(np.r_[x, np.log(kappa)]), np.array((0.59, 0.19)), 0.01), np.log(kappa)]))
    print(f"  kappa {kappa}: {least[0]:.2f}; {least[1]:.2f}")
