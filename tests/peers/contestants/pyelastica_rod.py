"""PyElastica: a Cosserat rod in space by position Verlet, the clamp an element behind the wall, the fitting a stiff one.

The rod shears, has rotary inertia, and bends the more easily the more it is stretched; no damping of it is
proportional to its stiffness.
"""

import elastica as ea
import numpy as np

from case import DURATION, RATE

NAME = "PyElastica"
# So much stiffer in shear than along, and so much stiffer the fitting than an edge. The rotary inertia is that of a
# solid rod: with a fifth of it the rod flies apart after a second, whatever the step.
SHEAR, STIFF = 10.0, 20.0


class System(ea.BaseSystemCollection, ea.Constraints, ea.Forcing, ea.Damping, ea.CallBacks):
    """What the rod is put into."""


class Tip(ea.CallBackBaseClass):
    """Keeps the path of the last node."""

    def __init__(self, every, path):
        super().__init__()
        self.every, self.path = every, path

    def make_callback(self, system, time, current_step):
        if current_step % self.every == 0:
            self.path.append(system.position_collection[[0, 2], -1].copy())


def settings(case):
    # Stiffness damping would have to be written anew: not taken part in.
    return [] if case.beta > 0 else [dict(nodes=n, step=h) for n, h in [(16, 4e-5), (32, 2e-5)]]


def prepare(case, nodes, step):
    edges, every = nodes - 1, round(1 / RATE / step)
    l = case.length / edges

    def built(path):
        x = np.concatenate([[-l], l * np.arange(edges + 1), [case.length + case.tip_offset]])
        position = np.stack([x, 0 * x, 0 * x])
        radius = np.sqrt(case.mass / case.length / 1000.0 / np.pi)
        rod = ea.CosseratRod.straight_rod(
            edges + 2, position[:, 0], np.array([1.0, 0.0, 0.0]), np.array([0.0, 0.0, 1.0]),
            x[-1] - x[0], radius, 1000.0, youngs_modulus=1e6, position=position)
        share = case.mass / edges
        rod.mass[:] = share
        rod.mass[-2], rod.mass[-1] = share / 2, case.tip_mass
        along = np.full(edges + 2, case.axial_stiffness)
        along[-1] *= STIFF * case.tip_offset / l
        across = SHEAR * along
        across[-1] = along[-1]
        rod.shear_matrix[:] = 0.0
        for k, values in enumerate([across, across, along]):
            rod.shear_matrix[k, k] = values
        # A bend's moment is stiffness by Voronoi length; at root and end half an edge counts.
        bend = np.full(edges + 1, case.bending_stiffness)
        bend[[0, -1]] *= rod.rest_voronoi_lengths[[0, -1]] / (l / 2)
        rod.bend_matrix[:] = 0.0
        for k in range(3):
            rod.bend_matrix[k, k] = bend
        inertia = share * radius**2 / 4
        inertia = np.full(edges + 2, inertia)
        inertia[-1] *= 20  # beside that of the mass ahead it is nothing, and the stiff element turns more slowly
        rod.mass_second_moment_of_inertia[:] = np.eye(3)[:, :, None] * inertia
        rod.inv_mass_second_moment_of_inertia[:] = np.eye(3)[:, :, None] / inertia
        system = System()
        system.append(rod)
        system.constrain(rod).using(ea.FixedConstraint, constrained_position_idx=(0, 1), constrained_director_idx=(0,))
        system.add_forcing_to(rod).using(ea.GravityForces, acc_gravity=np.array([0.0, 0.0, -case.gravity]))
        system.dampen(rod).using(ea.AnalyticalLinearDamper, uniform_damping_constant=case.alpha, time_step=step)
        system.collect_diagnostics(rod).using(Tip, every=every, path=path)
        system.finalize()
        return system

    def run():
        path = []
        system, stepper, time = built(path), ea.PositionVerlet(), np.float64(0.0)
        for _ in range(round(DURATION / step)):
            time = stepper.step(system, time, np.float64(step))
        return np.array(path)[:int(DURATION * RATE) + 1]

    return run
