"""Ours: the release of the library, by the example `release` of sim."""

import io
import os
import resource
import subprocess

import numpy as np

from case import HERE

NAME = "efam"
SCENARIO = HERE / "../../scenarios/release-15psi.toml"
BATCHES, REPEATS = 4, 5


def settings(case):
    fine = [dict(nodes=n, tol=t) for n in (8, 9, 10, 11, 12, 14, 16, 20, 24, 32) for t in (3e-4, 1e-4, 5e-5, 3e-5, 2e-5, 1e-5)]
    return fine + [dict(nodes=64, tol=1e-4), dict(nodes=128, tol=1e-4), dict(nodes=64, tol=1e-6), dict(nodes=128, tol=1e-7)]


def measure(case, nodes, tol):
    """Path, shortest wall time of a run, its processor time, and its steps.

    A run is too short for the clock of processor time, so that of the best batch counts, less that of none.
    """
    program = os.environ.get("EFAM_RELEASE", str(HERE / "../../target/release/examples/release"))
    # The case is a rod and a point mass: without the air in the muscle, and without the fitting's own inertia.
    sets = ["effects.enclosed_air.inner_diameter=0 mm", "effects.end_fitting.rotary_inertia=0 kg m^2",
            f"rod.nodes={nodes}", f"integrator.tolerance={tol}",
            f"effects.rayleigh_mass.alpha={case.alpha} 1/s", f"effects.rayleigh_stiffness.beta={case.beta} s"]

    def spent(repeats):
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        said = subprocess.run([program, str(SCENARIO), str(repeats), *sets], check=True, capture_output=True, text=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, said.stdout

    idle = min(spent(0)[0] for _ in range(BATCHES))
    batches = [spent(REPEATS) for _ in range(BATCHES)]
    heads = [said.split("\n", 1)[0].split(",") for _, said in batches]
    path = np.loadtxt(io.StringIO(batches[0][1].split("\n", 1)[1]), delimiter=",")
    cpu = (min(busy for busy, _ in batches) - idle) / REPEATS
    return path, min(float(wall) for wall, _ in heads), cpu, int(heads[0][1])
