"""The discrete rod in numpy, by scipy's solve_ivp: what one writes on the first afternoon."""

import numpy as np
from scipy.integrate import solve_ivp

import rod
from case import TIMES

NAME = "scipy, Radau"


def settings(case):
    return [dict(nodes=32, tol=1e-4)]  # a finer mesh takes minutes


def prepare(case, nodes, tol, end=TIMES[-1]):
    f, y0 = rod.vectorised(case, nodes), rod.start(case, nodes)
    apart = np.abs(np.subtract.outer(np.arange(y0.size), np.arange(y0.size)))
    times = TIMES[TIMES <= end]

    def run():
        done = solve_ivp(f, (0, end), y0, "Radau", times, rtol=tol, atol=tol, jac_sparsity=apart <= rod.BELOW)
        return rod.tip(case, nodes, done.y.T)

    return run
