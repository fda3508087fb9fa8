"""DiSMech-Newton: discrete elastic rods in space by implicit midpoint and Gauss-Newton, in single precision.

The clamp is an edge behind the wall, the fitting a stiff edge. Curvature, strains and their damping are ours. Mass
damping has no place in it: velocities shrink between steps, which keeps the order two.
"""

import numpy as np
import warp

warp.config.log_level = warp.LOG_WARNING  # it would print among our lines
# The package annotates with `Struct | None`, which Warp refuses where Python reads annotations at once.
warp._src.codegen.Struct.__or__ = lambda one, other: object

import dismech_newton
import newton

from case import DURATION, RATE

NAME = "DiSMech-Newton"
STIFF = 100.0  # so much stiffer along is the fitting than an edge
ITERATIONS = 2  # a third moves the tip by 0.004 mm, rms over 3 s with stiffness damping


def settings(case):
    fine = (64, 2.5e-3) if case.beta > 0 else (80, 2.5e-3)
    # The last fails without stiffness damping: its matrix is singular.
    return [dict(nodes=n, step=h) for n, h in [(16, 5e-3), (32, 5e-3), (48, 5e-3), (64, 5e-3), fine, (128, 5e-3)]]


def built(case, nodes):
    edges = nodes - 1
    l = case.length / edges
    x = np.concatenate([[-l], l * np.arange(edges + 1), [case.length + case.tip_offset]])
    builder = newton.ModelBuilder(gravity=(0.0, 0.0, -case.gravity))
    rod = newton.Rod(np.stack([x, 0 * x, 0 * x], axis=1), radius=0.006)
    dismech_newton.fix_segment(builder, edge=dismech_newton.add_rod(builder, rod, proxies=False)[0])
    mass = np.full(nodes + 2, case.mass / edges)
    mass[-2] /= 2
    mass[-1] = case.tip_mass
    builder.particle_mass[:] = mass.tolist()
    model = builder.finalize(device="cpu")
    # Stiffness by a triplet's strains: of both edges, which neighbours share, of two curvatures, of the twist.
    along = case.axial_stiffness * np.diff(x) / 2
    along[-1] *= STIFF
    along[[0, -1]] *= 2  # no neighbour
    bend = np.full(edges + 1, case.bending_stiffness / l)
    bend[[0, -1]] *= 2  # half a Voronoi length
    stiffness = np.stack([along[:-1], along[1:], bend, bend, bend], axis=1)
    model.dismech.triplet_params.assign(np.hstack([stiffness, case.beta * stiffness]).astype(np.float32))
    return model


def prepare(case, nodes, step):
    model, every, kept = built(case, nodes), round(1 / RATE / step), np.float32(np.exp(-case.alpha * step))

    def run(duration=DURATION):
        solver = dismech_newton.DiSMechSolver(model, iterations=ITERATIONS, exact=True, theta=0.5, linesearch=1)
        now, then = model.state(), model.state()
        path = [now.particle_q.numpy()[-1, [0, 2]].copy()]
        for k in range(round(duration / step)):
            solver.step(now, then, None, None, step)
            now, then = then, now
            now.dismech.qd.numpy()[:] *= kept  # a view: all is on the processor
            if (k + 1) % every == 0:
                path.append(now.particle_q.numpy()[-1, [0, 2]].copy())
        return np.array(path)

    run(2 * step)  # compiles
    return run
