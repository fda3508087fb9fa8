"""An environment of Gymnasium: a regulator brings the tip of a muscle to a place and keeps it there.

>>> import efam.gym, gymnasium
>>> environment = efam.gym.TipControl("scenarios/release-15psi.toml")
>>> many = gymnasium.vector.SyncVectorEnv([lambda: efam.gym.TipControl("scenarios/release-15psi.toml")] * 8)
"""

from __future__ import annotations

from typing import Any, Optional

import numpy as np
from numpy.typing import NDArray

from ._answers import statics
from ._efam import SimulationError
from ._extras import optional
from ._run import Source, model_of

optional("gymnasium")
from gymnasium import Env, spaces  # noqa: E402

Floats = NDArray[np.float64]


class TipControl(Env[Floats, Floats]):
    """The action, from -1 to 1, is the pressure, from the lowest to the highest; it is held for `dt`.

    Seen are the place of the tip in m, its velocity in m/s, the last action, and the place where it should be. That is the
    rest at a pressure which each episode draws; `reset(options={"target": 2e5})` says it, and all other options are those of
    the model, such as payload. The reward is less by the distance from there in mm. An episode has `steps` steps.
    """

    def __init__(
        self,
        scenario: Source,
        *,
        lowest: float = 7e4,
        highest: float = 4e5,
        dt: float = 0.01,
        steps: int = 500,
    ) -> None:
        self.model = model_of(scenario)
        self.lowest, self.highest, self.dt, self.steps = lowest, highest, dt, steps
        self.action_space = spaces.Box(-1.0, 1.0, (1,), np.float64)
        # Far more than a tip of a muscle can reach.
        most = np.array([10.0, 10.0, 1e3, 1e3, 1.0, 10.0, 10.0])
        self.observation_space = spaces.Box(-most, most, dtype=np.float64)

    def reset(
        self, *, seed: Optional[int] = None, options: Optional[dict[str, Any]] = None
    ) -> tuple[Floats, dict[str, Any]]:
        """Begins an episode at the start of the scenario."""
        super().reset(seed=seed)
        own = dict(options or {})
        drawn = float(self.np_random.uniform(self.lowest, self.highest))
        pressure = own.pop("target", drawn)
        model = self.model.replace(**own) if own else self.model
        rest = statics(model, pressure=pressure)["statics"][0]
        self._target = np.array([rest["tip_x_m"], rest["tip_z_m"]])
        self._swing = model.start()
        self._action = self._scaled(model["rod.pressure"])
        self._left = self.steps
        return self._seen(), {"target_pressure_pa": pressure}

    def step(self, action: Floats) -> tuple[Floats, float, bool, bool, dict[str, Any]]:
        """Holds a pressure for `dt`. An episode whose simulation cannot go on is terminated."""
        self._action = float(np.clip(action[0], -1, 1))
        self._left -= 1
        is_broken = False
        try:
            self._swing.set(pressure=self.lowest + (self._action + 1) / 2 * (self.highest - self.lowest))
            self._swing.step(self.dt)
        except SimulationError:
            is_broken = True
        seen = self._seen()
        distance = float(np.hypot(*(seen[:2] - self._target)))
        return seen, -1e3 * distance, is_broken, self._left <= 0, {}

    def _scaled(self, pressure: float) -> float:
        return float(np.clip(2 * (pressure - self.lowest) / (self.highest - self.lowest) - 1, -1, 1))

    def _seen(self) -> Floats:
        return np.concatenate([*self._swing.tip, [self._action], self._target])
