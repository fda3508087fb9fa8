"""Simulation-based calibration: true values drawn from the priors have uniform ranks among the draws of `efam.sample`.

Source: Talts, Betancourt, Simpson, Vehtari and Gelman (2018), arXiv 1804.06788. `.ci/thorough` draws 200 experiments.
"""

import os
from typing import Dict, Tuple

import efam
import numpy as np
import pytest

from conftest import ROOT

EXPERIMENTS = int(os.environ.get("EFAM_EXPERIMENTS", "0"))
# Independent draws of each posterior, and bins of the ranks: ten ranks in each, 20 of 200 experiments.
DRAWS, BINS = 99, 10
NOISE = 3e-4
# Means and standard deviations: parameters as stated, nuisance parameters as an experiment has them without a word.
PARAMETERS: Dict[str, Tuple[float, float, str]] = {
    "rod.bending_stiffness": (0.0071, 0.0003, "N m^2"),
    "effects.rayleigh_mass.alpha": (0.8, 0.15, "1/s"),
    "effects.rayleigh_stiffness.beta": (3e-3, 6e-4, "s"),
}
NUISANCES: Dict[str, float] = {
    "release instant": 0.005,
    "offset of tip in x": 5e-4,
    "offset of tip in z": 5e-4,
}


def ranks_of(seed: int) -> Dict[str, int]:
    """Ranks of the true values of one drawn experiment, 0 to `DRAWS`."""
    random = np.random.default_rng([57, seed])
    truth = {name: random.normal(mean, deviation) for name, (mean, deviation, _) in PARAMETERS.items()}
    truth |= {name: random.normal(0.0, deviation) for name, deviation in NUISANCES.items()}
    ei, alpha, beta, instant, *offset = truth.values()
    model = efam.Model(
        ROOT / "scenarios" / "release-15psi.toml",
        run={"duration": "3 s", "rate": 4000},
        **{
            "rod.bending_stiffness": ei,
            "effects.rayleigh_mass.alpha": alpha,
            "effects.rayleigh_stiffness.beta": beta,
        },
    )
    run = efam.simulate(model, error_estimate=False)
    times = np.arange(0.0, 2.9, 0.01)
    # Held before it is released; a sample of the run is at most 0.125 ms away.
    tip = np.stack([np.interp(times - instant, run.t, own) for own in run.tip.T], axis=1)
    tip += random.normal(0.0, NOISE, tip.shape) + np.array(offset)
    recording = efam.Recording(times=times, markers={"tip": tip})
    experiment = efam.Experiment(
        muscle={"name": "garbulinski-2022"},
        effects={"rayleigh_mass": {"alpha": "0.8 1/s"}, "rayleigh_stiffness": {"beta": "3 ms"}},
        recording={"file": recording, "pressure": "15 psi", "tip": "tip", "up": "+z", "along": "+x", "angle": 0.0,
                   "offset": "none", "instants": ["0 s"], "noise": NOISE},
        calibrate={"hold_angle": "0 deg", "parameter": [
            {"path": path, "prior": f"{mean} {unit}", "deviation": f"{deviation} {unit}", "scale": "linear"}
            for path, (mean, deviation, unit) in PARAMETERS.items()
        ]},
    )
    found = efam.sample(experiment, chains=3, draws=4 * DRAWS // 3, seed=seed, progress=False)
    names = {own["name"]: own["name"] for own in found["parameters"] + found["nuisances"]}
    ranks = {}
    for name, value in truth.items():
        (full,) = [own for own in names if own.startswith(name)]
        # Neighbours in a chain are not independent.
        ranks[name] = int((found.draws[full][:, ::4] < value).sum())
    return ranks


@pytest.mark.skipif(EXPERIMENTS == 0, reason="long: EFAM_EXPERIMENTS=200 runs it")
def test_ranks_of_true_values_are_uniform(capsys):
    ranks = [ranks_of(seed) for seed in range(EXPERIMENTS)]
    due = EXPERIMENTS / BINS
    found = {}
    for name in ranks[0]:
        counts = np.bincount([own[name] * BINS // (DRAWS + 1) for own in ranks], minlength=BINS)
        found[name] = float(((counts - due) ** 2 / due).sum())
        with capsys.disabled():
            print(f"\n{name}: {counts.tolist()}, chi-squared {found[name]:.1f} of {BINS - 1}", end="")
    # Where all six are uniform, one run in a hundred is above: 0.01 / 6 of chi-squared with nine degrees of freedom.
    assert max(found.values()) < 26.6, found
