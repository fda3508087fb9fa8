"""The release at 15 psi, SI: what every contestant computes, and how its answer is judged."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

HERE = Path(__file__).parent
DURATION, RATE = 20.0, 100.0
TIMES = np.arange(int(DURATION * RATE) + 1) / RATE


@dataclass(frozen=True)
class Case:
    """A clamped rod, straight and level when it is let go, with a point mass rigidly ahead of its end."""

    name: str
    alpha: float  # force -alpha m v on every mass, 1/s
    beta: float  # moment beta EI and tension beta EA by rates of strain, s
    length: float = 0.202946
    mass: float = 0.02417537202  # of the rod in all
    bending_stiffness: float = 0.00709
    axial_stiffness: float = 132.3303990178038
    gravity: float = 9.81
    tip_mass: float = 0.05492
    tip_offset: float = 0.0168148  # of the mass beyond the rod's end; it is also the tip that is observed

    def reference(self):
        """The converged path of the tip, m, shape [samples, 2]: written by the twin of the tests, no contestant."""
        return np.loadtxt(HERE / f"reference-{self.name}.csv", delimiter=",", skiprows=1)[:, 1:]


CASES = {case.name: case for case in [Case("mass-damping", 1.0, 0.0), Case("both-dampings", 1.0, 0.01)]}


def rms_mm(path, other):
    """Distance of two paths, root of the mean square, mm; infinite where one went astray."""
    off = 1e3 * np.sqrt(np.mean(np.sum((path - other) ** 2, axis=1)))
    return float(off) if np.isfinite(off) else float("inf")
