"""The discrete rod in loops that numba compiles, by scipy's LSODA with a banded Jacobian."""

import numba
import numpy as np
from scipy.integrate import odeint

import rod
from case import TIMES

NAME = "numba, LSODA"


def settings(case):
    # Orders above 2 are not stable along the imaginary axis: without stiffness damping they take a million steps.
    order = 2 if case.beta == 0 else 5
    fine = [dict(nodes=n, order=order, tol=tol) for n in (32, 48, 56, 64, 72, 80, 96) for tol in (3e-4, 1e-4, 3e-5, 1e-5)]
    return fine + [dict(nodes=n, order=order, tol=1e-4) for n in (16, 128)]


def prepare(case, nodes, order, tol):
    c, y0 = rod.constants(case, nodes), rod.start(case, nodes)
    out = np.empty_like(y0)

    def f(y, t):
        loops(y, c, out)
        return out

    f(y0, 0.0)

    def run():
        states = odeint(f, y0, TIMES, ml=rod.BELOW, mu=rod.ABOVE, rtol=tol, atol=tol, mxstep=10**7, mxords=order)
        return rod.tip(case, nodes, states)

    return run


@numba.njit(cache=True)
def loops(y, c, out):
    """The right-hand side of rod.py in loops, into `out`."""
    n = int(c[0])
    l, share, body, center, inertia, EI, EA, g, alpha, beta = c[1:11]
    k = 4 * (n - 1)
    a, w = y[k + 4], y[k + 5]
    ax, az = np.cos(a), np.sin(a)
    px = pz = pvx = pvz = 0.0  # the node before
    dx, dz, turning = 1.0, 0.0, 0.0  # the direction before
    fx = fz = 0.0  # what the edge before does to the node before
    tx = tz = length = before = tension = 0.0
    for j in range(n + 1):
        # Direction j stands behind bend j: edge j, or the body.
        if j < n:
            if j < n - 1:
                x, vx, z, vz = y[4 * j], y[4 * j + 1], y[4 * j + 2], y[4 * j + 3]
            else:
                x, z = y[k] - center * ax, y[k + 2] - center * az
                vx, vz = y[k + 1] + center * w * az, y[k + 3] - center * w * ax
            ex, ez, ux, uz = x - px, z - pz, vx - pvx, vz - pvz
            long = np.sqrt(ex * ex + ez * ez)
            nx, nz = ex / long, ez / long
            next_turning = (nx * uz - nz * ux) / long
        else:
            nx, nz, next_turning, long = ax, az, w, 1.0
            x = z = vx = vz = ux = uz = 0.0
        voronoi = l / 2 if j == 0 or j == n else l
        kappa = 2 * (dx * nz - dz * nx) / (1 + dx * nx + dz * nz)
        slope = 1 + kappa * kappa / 4
        moment = EI / voronoi * (kappa + beta * slope * (next_turning - turning)) * slope
        if j > 0:
            # Edge j-1 is done: both its moments are known.
            q = (moment - before) / length
            gx, gz = -tension * tx - q * tz, -tension * tz + q * tx
            i = j - 1  # its first node
            if i > 0:
                r = 4 * (i - 1)
                out[r] = y[r + 1]
                out[r + 1] = (fx - gx) / share - alpha * y[r + 1]
                out[r + 2] = y[r + 3]
                out[r + 3] = (fz - gz) / share - alpha * y[r + 3] - g
            fx, fz = gx, gz
        if j < n:
            tension = EA * ((long / l - 1) + beta * (nx * ux + nz * uz) / l)
            tx, tz, length = nx, nz, long
            px, pz, pvx, pvz = x, z, vx, vz
        before = moment
        dx, dz, turning = nx, nz, next_turning
    out[k] = y[k + 1]
    out[k + 1] = fx / body - alpha * y[k + 1]
    out[k + 2] = y[k + 3]
    out[k + 3] = fz / body - alpha * y[k + 3] - g
    out[k + 4] = w
    out[k + 5] = (-before - center * (ax * fz - az * fx)) / inertia - alpha * w
