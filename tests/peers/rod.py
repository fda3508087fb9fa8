"""The discrete rod in the plane, as a student would write it down in numpy.

Nodes 1..N-1 have x, z; the rod's end and the point mass ahead of it are one rigid body with centre X, Z and angle.
A bend's integrated curvature is 2 tan(half its turning angle); root and end bends have half a Voronoi length.
The state interleaves coordinates and rates node by node, so that its Jacobian is banded.
"""

import numpy as np

# Half bandwidths of the Jacobian: the body behind the last node reaches farthest.
BELOW, ABOVE = 13, 12


def constants(case, nodes):
    """What the laws need, as one flat array."""
    edges = nodes - 1
    edge = case.length / edges
    share = case.mass / edges
    body = share / 2 + case.tip_mass
    center = case.tip_offset * case.tip_mass / body
    inertia = share / 2 * case.tip_mass / body * case.tip_offset**2
    return np.array([edges, edge, share, body, center, inertia, case.bending_stiffness, case.axial_stiffness,
                     case.gravity, case.alpha, case.beta])


def start(case, nodes):
    """Straight, level, at rest."""
    c = constants(case, nodes)
    edges, edge, center = int(c[0]), c[1], c[4]
    y = np.zeros(4 * (edges - 1) + 6)
    y[0:4 * (edges - 1):4] = edge * np.arange(1, edges)
    y[4 * (edges - 1)] = case.length + center
    return y


def tip(case, nodes, states):
    """Path of the point mass, shape [samples, 2]."""
    ahead = case.tip_offset - constants(case, nodes)[4]
    x, z, angle = states[:, -6], states[:, -4], states[:, -2]
    return np.stack([x + ahead * np.cos(angle), z + ahead * np.sin(angle)], axis=1)


def vectorised(case, nodes):
    """Right-hand side in numpy."""
    n, l, share, body, center, inertia, EI, EA, g, alpha, beta = constants(case, nodes)
    n = int(n)
    voronoi = np.full(n + 1, l)
    voronoi[[0, -1]] = l / 2

    def rhs(t, y):
        inner = y[:4 * (n - 1)].reshape(-1, 4)
        X, VX, Z, VZ, a, w = y[4 * (n - 1):]
        axis = np.array([np.cos(a), np.sin(a)])
        normal = np.array([-axis[1], axis[0]])
        p = np.vstack([[0.0, 0.0], inner[:, [0, 2]], np.array([X, Z]) - center * axis])
        v = np.vstack([[0.0, 0.0], inner[:, [1, 3]], np.array([VX, VZ]) - center * w * normal])
        e, de = np.diff(p, axis=0), np.diff(v, axis=0)
        length = np.hypot(e[:, 0], e[:, 1])
        t_ = e / length[:, None]
        n_ = np.stack([-t_[:, 1], t_[:, 0]], axis=1)
        tension = EA * ((length / l - 1) + beta * np.sum(de * t_, axis=1) / l)
        turning = np.sum(de * n_, axis=1) / length
        # Directions on both sides of each bend: clamp, edges, body.
        d = np.vstack([[1.0, 0.0], t_, axis])
        rate = np.diff(np.concatenate([[0.0], turning, [w]]))
        cross = d[:-1, 0] * d[1:, 1] - d[:-1, 1] * d[1:, 0]
        kappa = 2 * cross / (1 + np.sum(d[:-1] * d[1:], axis=1))
        slope = 1 + kappa**2 / 4
        moment = EI / voronoi * (kappa + beta * slope * rate) * slope
        # What an edge does to its far node: it pulls back, and turns by the moments at its ends.
        end = -tension[:, None] * t_ + ((moment[1:] - moment[:-1]) / length)[:, None] * n_
        force = np.zeros_like(p)
        force[1:] += end
        force[:-1] -= end
        out = np.empty_like(y)
        rows = out[:4 * (n - 1)].reshape(-1, 4)
        rows[:, [0, 2]] = inner[:, [1, 3]]
        rows[:, [1, 3]] = force[1:-1] / share - alpha * inner[:, [1, 3]]
        rows[:, 3] -= g
        torque = -moment[-1] - center * (axis[0] * force[-1, 1] - axis[1] * force[-1, 0])
        out[-6:] = [VX, force[-1, 0] / body - alpha * VX, VZ, force[-1, 1] / body - alpha * VZ - g,
                    w, torque / inertia - alpha * w]
        return out

    return rhs
