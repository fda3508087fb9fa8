"""The environment of Gymnasium."""

import time
import warnings

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium")
from gymnasium.utils.env_checker import check_env  # noqa: E402

from efam.gym import TipControl  # noqa: E402


def episode(environment, act, **options):
    seen, _ = environment.reset(seed=3, options=options)
    rewards, is_over = [], False
    while not is_over:
        seen, reward, is_broken, is_over, _ = environment.step(np.array([act(seen)]))
        assert not is_broken
        rewards.append(reward)
    return seen, np.array(rewards)


def test_it_is_an_environment(scenario):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(TipControl(scenario), skip_render_check=True)


def test_a_regulator_earns_more_than_the_final_pressure(scenario):
    environment = TipControl(scenario, steps=400)
    place = environment._scaled(2e5)
    # The pressure at which it rests, and with it one that rises with the tip, which brakes it.
    seen, held = episode(environment, lambda seen: place, target=2e5)
    _, braked = episode(environment, lambda seen: place + 0.3 * seen[3], target=2e5)
    assert np.array_equal(episode(environment, lambda seen: place, target=2e5)[1], held)
    assert braked[200:].mean() > 0.75 * held[200:].mean() and held.max() <= 0
    # The rest of the target is the one of that pressure: the tip swings about it.
    assert abs(seen[1] - seen[6]) < 0.1
    heavy, _ = episode(environment, lambda seen: place, target=2e5, payload="50 g")
    assert heavy[6] < seen[6] - 0.01


def test_many_step_at_once(scenario):
    many = gymnasium.vector.SyncVectorEnv([lambda: TipControl(scenario)] * 4)
    seen, _ = many.reset(seed=1)
    assert seen.shape == (4, 7) and len(set(seen[:, 6])) == 4
    begin = time.perf_counter()
    for _ in range(250):
        many.step(many.action_space.sample())
    print(f"{1000 / (time.perf_counter() - begin):.0f} steps a second on one core")
    many.close()
