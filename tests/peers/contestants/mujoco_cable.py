"""MuJoCo's cable: rigid links at ball joints, bent by its elasticity plugin, which 3.17 is the last to have.

It does not stretch, and its links keep half a cell between the clamp and the first joint, and behind the last.
"""

import math

import mujoco

from case import DURATION, RATE
from contestants.mujoco_chain import swing

NAME = "MuJoCo, cable"
RADIUS = 0.01  # of the section, m; Young's modulus makes up for it


def settings(case):
    # Bending is explicit, dampers of the joints are not.
    if case.beta > 0:
        pairs = [(16, 1e-3), (32, 2e-3), (32, 1e-3), (64, 5e-4)]
    else:
        pairs = [(16, 2e-4), (24, 5e-5)]
    return [dict(nodes=nodes, step=step) for nodes, step in pairs]


def described(case, nodes, step):
    n, l = nodes - 1, case.length / (nodes - 1)
    modulus = case.bending_stiffness / (math.pi * RADIUS**4 / 4)
    joint = f'<joint type="ball" damping="{case.beta * case.bending_stiffness / l}"/>'
    geom = f'<geom type="cylinder" size="{RADIUS}" fromto="0 0 0 {l} 0 0"/><plugin instance="cable"/>'

    def inertial(mass, at, about):
        return f'<inertial pos="{at} 0 0" mass="{mass}" diaginertia="{about} {about} {about}"/>'

    link = case.mass / n
    text = ('<mujoco><extension><plugin plugin="mujoco.elasticity.cable"><instance name="cable">'
            f'<config key="bend" value="{modulus}"/><config key="twist" value="{modulus}"/></instance></plugin></extension>'
            f'<option timestep="{step}" integrator="implicitfast" gravity="0 0 {-case.gravity}">'
            '<flag contact="disable" constraint="disable"/></option><worldbody>'
            f'<body pos="{-l / 2} 0 0">{geom}{inertial(link, l / 2, link * l**2 / 12)}')
    for _ in range(n - 1):
        text += f'<body pos="{l} 0 0">{joint}{geom}{inertial(link, l / 2, link * l**2 / 12)}'
    # The last holds half a link and the payload.
    half, reach = link / 2, l / 2 + case.tip_offset
    mass = half + case.tip_mass
    center = (half * l / 4 + case.tip_mass * reach) / mass
    about = half * (l**2 / 48 + (center - l / 4) ** 2) + case.tip_mass * (reach - center) ** 2
    text += (f'<body pos="{l} 0 0">{joint}{geom}{inertial(mass, center, about)}'
             f'<site name="tip" pos="{reach} 0 0"/>')
    return text + "</body>" * (n + 1) + "</worldbody></mujoco>"


def prepare(case, nodes, step):
    return swing(case, mujoco.MjModel.from_xml_string(described(case, nodes, step)), step)
