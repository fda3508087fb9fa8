"""MuJoCo: a chain of links with a hinge and a slide each, since its cable does not stretch.

Moments are linear in the angle of a hinge. Mass damping is put on before each step, from the velocities there.
"""

import mujoco
import numpy as np

from case import DURATION, RATE

NAME = "MuJoCo, chain"
TINY = 'diaginertia="1e-12 1e-12 1e-12"'  # of point masses: a body must have one


def settings(case):
    # Springs are explicit; dampers are not, and with stiffness damping they let steps be long.
    if case.beta > 0:
        pairs = [(16, 1e-3), (32, 1e-3), (32, 2e-4), (64, 1e-3), (64, 2e-4), (96, 1e-3), (128, 5e-4)]
    else:
        pairs = [(16, 2e-4), (32, 5e-5), (48, 2e-5)]
    return [dict(nodes=nodes, step=step) for nodes, step in pairs]


def described(case, nodes, step):
    n, l = nodes - 1, case.length / (nodes - 1)
    share = case.mass / n

    def joint(kind, stiffness, of):
        return f'<joint type="{kind}" {of} stiffness="{stiffness}" damping="{case.beta * stiffness}"/>'

    def hinge(voronoi, at):
        return joint("hinge", case.bending_stiffness / voronoi, f'axis="0 -1 0" pos="{at} 0 0"')

    text = (f'<mujoco><option timestep="{step}" integrator="implicitfast" gravity="0 0 {-case.gravity}">'
            '<flag contact="disable" constraint="disable"/></option><worldbody>')
    for j in range(n):
        # The body of an edge stands at its far node, where half of its mass and of its neighbour's is.
        slide = joint("slide", case.axial_stiffness / l, 'axis="1 0 0"')
        mass = share if j < n - 1 else share / 2
        text += (f'<body pos="{l} 0 0">' + hinge(l / 2 if j == 0 else l, -l) + slide
                 + f'<inertial pos="0 0 0" mass="{mass}" {TINY}/>')
    text += (f'<body>{hinge(l / 2, 0)}<inertial pos="{case.tip_offset} 0 0" mass="{case.tip_mass}" {TINY}/>'
             f'<site name="tip" pos="{case.tip_offset} 0 0"/></body>')
    return text + "</body>" * n + "</worldbody></mujoco>"


def prepare(case, nodes, step):
    return swing(case, mujoco.MjModel.from_xml_string(described(case, nodes, step)), step)


def swing(case, model, step):
    """The path of the site 0 of a model."""
    steps = round(1 / RATE / step)

    def run():
        data = mujoco.MjData(model)
        mujoco.mj_forward(model, data)
        path = [data.site_xpos[0][[0, 2]].copy()]
        momentum = np.zeros(model.nv)
        for _ in range(int(DURATION * RATE)):
            for _ in range(steps):
                mujoco.mj_step1(model, data)
                mujoco.mj_mulM(model, data, momentum, data.qvel)
                data.qfrc_applied[:] = -case.alpha * momentum
                mujoco.mj_step2(model, data)
            mujoco.mj_kinematics(model, data)
            path.append(data.site_xpos[0][[0, 2]].copy())
            if not np.isfinite(path[-1]).all() or data.warning[mujoco.mjtWarning.mjWARN_BADQACC].number:
                return np.full((int(DURATION * RATE) + 1, 2), np.nan)
        return np.array(path)

    return run
