"""Environments of Gymnasium: a regulator brings the tip of a muscle to a place and keeps it there.

>>> import efam.gym
>>> environment = efam.gym.TipControl("scenarios/release-15psi.toml")
>>> many = efam.gym.TipControls("scenarios/release-15psi.toml", 64)
"""

from __future__ import annotations

from typing import Any, Optional, Union

import numpy as np
from numpy.typing import NDArray

from ._answers import statics
from ._efam import SimulationError, Swing, step_many
from ._extras import optional
from ._run import Source, model_of

optional("gymnasium")
from gymnasium import Env, spaces  # noqa: E402
from gymnasium.vector import AutoresetMode, VectorEnv  # noqa: E402
from gymnasium.vector.utils import batch_space  # noqa: E402

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]


_LAG = "effects.pressure_line.time_constant"


class _Task:
    """What is to be done, for one rod or many."""

    def __init__(
        self,
        scenario: Source,
        lowest: float,
        highest: float,
        dt: float,
        steps: int,
        lag: float,
        accuracy: Optional[str],
    ) -> None:
        options: Any = {} if accuracy is None else {"run.accuracy": accuracy}
        model = model_of(scenario)
        if lag > 0 and _LAG not in model.parameters:
            options[_LAG] = lag
        self.model = model.replace(**options)
        self.lowest, self.highest, self.dt, self.steps = lowest, highest, dt, steps
        self.action_space = spaces.Box(-1.0, 1.0, (1,), np.float64)
        # Far more than a tip of a muscle can reach.
        most = np.array([10.0, 10.0, 1e3, 1e3, 1.0, 10.0, 10.0])
        self.observation_space = spaces.Box(-most, most, dtype=np.float64)

    def begin(self, random: np.random.Generator, options: Optional[dict[str, Any]]) -> tuple[Swing, Floats, float]:
        """A rod at its start, what is seen of it, and the pressure at whose rest the tip should be."""
        own = dict(options or {})
        drawn = float(random.uniform(self.lowest, self.highest))
        pressure = float(own.pop("target", drawn))
        model = self.model.replace(**own) if own else self.model
        rest = statics(model, pressure=pressure)["statics"][0]
        swing = model.start()
        target = [rest["tip_x_m"], rest["tip_z_m"]]
        return swing, np.concatenate([*swing.tip, [self.scaled(model["rod.pressure"])], target]), pressure

    def pressure(self, action: Floats) -> Floats:
        return self.lowest + (action + 1) / 2 * (self.highest - self.lowest)

    def scaled(self, pressure: float) -> float:
        return float(np.clip(2 * (pressure - self.lowest) / (self.highest - self.lowest) - 1, -1, 1))


class TipControl(Env[Floats, Floats]):
    """The action, from -1 to 1, is the commanded pressure, from the lowest to the highest; it is held for `dt`.

    A regulator follows the command with the time constant `lag`, s, if the scenario has no `pressure_line` of its own. With
    `lag=0` the pressure jumps, and with it the length of the rod: such a shock shakes it in a way that no mesh resolves.
    `accuracy` chooses mesh and tolerance, for the path of the tip; None keeps those of the scenario.

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
        lag: float = 0.05,
        accuracy: Optional[str] = "0.1 mm",
    ) -> None:
        self._task = _Task(scenario, lowest, highest, dt, steps, lag, accuracy)
        self.action_space = self._task.action_space
        self.observation_space = self._task.observation_space

    def reset(
        self, *, seed: Optional[int] = None, options: Optional[dict[str, Any]] = None
    ) -> tuple[Floats, dict[str, Any]]:
        """Begins an episode at the start of the scenario."""
        super().reset(seed=seed)
        self._swing, self._seen, pressure = self._task.begin(self.np_random, options)
        self._left = self._task.steps
        return self._seen.copy(), {"target_pressure_pa": pressure}

    def step(self, action: Floats) -> tuple[Floats, float, bool, bool, dict[str, Any]]:
        """Holds a pressure for `dt`. An episode whose simulation cannot go on is terminated."""
        self._seen[4] = np.clip(action[0], -1, 1)
        self._left -= 1
        is_broken = False
        try:
            self._swing.set(pressure=float(self._task.pressure(self._seen[4])))
            self._swing.step(self._task.dt)
        except SimulationError:
            is_broken = True
        self._seen[:4] = np.concatenate(self._swing.tip)
        distance = float(np.hypot(*(self._seen[:2] - self._seen[5:])))
        return self._seen.copy(), -1e3 * distance, is_broken, self._left <= 0, {}


class TipControls(VectorEnv[Floats, Floats, NDArray[Any]]):
    """Many of them, stepped on all cores in one call. After its end an episode begins anew in the next step."""

    metadata = {"autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(
        self,
        scenario: Source,
        count: int,
        *,
        lowest: float = 7e4,
        highest: float = 4e5,
        dt: float = 0.01,
        steps: int = 500,
        lag: float = 0.05,
        accuracy: Optional[str] = "0.1 mm",
    ) -> None:
        self._task = _Task(scenario, lowest, highest, dt, steps, lag, accuracy)
        self.num_envs = count
        self.single_action_space = self._task.action_space
        self.single_observation_space = self._task.observation_space
        self.action_space = batch_space(self.single_action_space, count)
        self.observation_space = batch_space(self.single_observation_space, count)

    def reset(
        self, *, seed: Optional[Union[int, list[Optional[int]]]] = None, options: Optional[dict[str, Any]] = None
    ) -> tuple[Floats, dict[str, Any]]:
        """Begins all episodes, with the options of `TipControl`."""
        super().reset(seed=seed if isinstance(seed, int) else None)
        begins = [self._task.begin(self.np_random, options) for _ in range(self.num_envs)]
        self._options = options
        self._swings = [swing for swing, _, _ in begins]
        self._seen = np.stack([seen for _, seen, _ in begins])
        self._left = np.full(self.num_envs, self._task.steps)
        self._is_over = np.zeros(self.num_envs, bool)
        return self._seen.copy(), {"target_pressure_pa": np.array([pressure for _, _, pressure in begins])}

    def step(self, actions: Floats) -> tuple[Floats, Floats, Flags, Flags, dict[str, Any]]:
        """Holds a pressure each for `dt`."""
        anew = np.flatnonzero(self._is_over)
        going = np.flatnonzero(~self._is_over)
        for k in anew:
            self._swings[k], self._seen[k], _ = self._task.begin(self.np_random, self._options)
            self._left[k] = self._task.steps
        action = np.clip(actions[going, 0], -1, 1)
        self._seen[going, 4] = action
        tips = step_many([self._swings[k] for k in going], self._task.pressure(action).tolist(), self._task.dt)
        is_broken = np.zeros(self.num_envs, bool)
        is_broken[going] = np.isnan(tips[:, 0])
        self._seen[going[~is_broken[going]], :4] = tips[~is_broken[going]]
        self._left[going] -= 1
        rewards = -1e3 * np.hypot(*(self._seen[:, :2] - self._seen[:, 5:]).T)
        rewards[anew] = 0.0
        self._is_over = is_broken | (self._left <= 0)
        return self._seen.copy(), rewards, is_broken, self._left <= 0, {}
