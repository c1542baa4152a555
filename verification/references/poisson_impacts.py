#!/usr/bin/env python3
"""Poisson's law of a single impact with Coulomb friction along it, for the tables of loose_guide.hpp
and impact_tables.hpp.

In fractions, by Routh's graphical method: in the plane of impulses (P_T, P_N) the point goes up the
line of friction until it meets the line of sticking (u_T = 0), and then along that or along the line
of reversed sliding; it has compressed when it meets the line u_N = 0, and has ended at (1 + e) of the
height it had there. Nothing of this is shared with formulations/.
"""
from fractions import Fraction as Q
from math import cos, pi, sin


def end_of_impact(mu, e, ut, un, Dnn, Dnt, Dtt):
    mu, e, ut, un, Dnn, Dnt, Dtt = map(Q, (mu, e, ut, un, Dnn, Dnt, Dtt))
    # The path as corners (P_T, P_N) and the direction dP_T/dP_N
    # in which it leaves the last of them.
    sign = (ut > 0) - (ut < 0)
    corners, way = [(Q(0), Q(0))], -sign * mu
    slope = Dnt + way * Dtt  # of u_T against P_N
    if sign == 0 or slope * sign < 0:
        if sign:
            stop = -ut / slope
            corners.append((way * stop, stop))
        stick = -Dnt / Dtt
        way = stick if abs(stick) <= mu else (mu if stick > 0 else -mu)
    points = corners + [None]
    compressed = None
    for k, (pt, pn) in enumerate(corners):
        w = way if k == len(corners) - 1 else (corners[k + 1][0] - pt) / (corners[k + 1][1] - pn)
        rate = un + Dnt * pt + Dnn * pn
        height = pn - rate / (Dnn + w * Dnt) if Dnn + w * Dnt > 0 else None
        last = points[k + 1] is None
        if height is not None and height >= pn and (last or height <= corners[k + 1][1]):
            compressed = height
            break
    height = (1 + e) * compressed
    for k, (pt, pn) in reversed(list(enumerate(corners))):
        if height >= pn:
            w = way if k == len(corners) - 1 else (corners[k + 1][0] - pt) / (corners[k + 1][1] - pn)
            return height, pt + w * (height - pn)


def kane_levinson(e, mu=0.5, l=1.0, inertia=1 / 12):
    """Two uniform bars of 1 m and 1 kg; angles from the vertical 20 and 30 degrees, rates -0.1 and
    -0.2 rad/s."""
    a, b, ra, rb = pi / 9, pi / 6, -0.1, -0.2
    m11, m12, m22 = inertia + 0.25 * l * l + l * l, 0.5 * l * l * cos(a - b), inertia + 0.25 * l * l
    det = m11 * m22 - m12 * m12
    inv = [[m22 / det, -m12 / det], [-m12 / det, m11 / det]]
    # of the tip: height above the floor and to the right
    up, along = [l * sin(a), l * sin(b)], [l * cos(a), l * cos(b)]
    form = lambda x, y: sum(x[i] * inv[i][j] * y[j] for i in range(2) for j in range(2))
    rates = [ra, rb]
    un, ut = sum(x * y for x, y in zip(up, rates)), sum(x * y for x, y in zip(along, rates))
    pn, pt = map(float, end_of_impact(mu, e, ut, un, form(up, up), form(up, along), form(along, along)))
    push = [pn * u + pt * v for u, v in zip(up, along)]
    after = [rates[i] + sum(inv[i][j] * push[j] for j in range(2)) for i in range(2)]
    energy = lambda r: 0.5 * (m11 * r[0] ** 2 + 2 * m12 * r[0] * r[1] + m22 * r[1] ** 2)
    return energy(after) / energy(rates)


if __name__ == "__main__":
    for row in [(0.3, 0.7, -0.4, -1, 2.5, 1.5, 2.5), (0.2, 0.6, -0.5, -1, 1.75, 1.299038105676658, 3.25),
                (0.2, 0.6, -1.5, -1, 1.75, 1.299038105676658, 3.25),
                (0.1, 0.9, -0.2, -1, 1.200961894323342, 0.75, 3.799038105676658),
                (1, 0.8, 0.3, -1, 1.75, 1.299038105676658, 3.25),
                (2.5, 0.8, 3, -0.2, 1.535818585470191, 1.149066664678467, 3.464181414529809)]:
        print(row, *("%.14g" % float(p) for p in end_of_impact(*row)))
    for e in (0.7, 0.5):
        print(e, "%.16g" % kane_levinson(e))
