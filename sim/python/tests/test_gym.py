"""The environment of Gymnasium."""

import os
import time
import warnings

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium")
from gymnasium.utils.env_checker import check_env  # noqa: E402

import efam  # noqa: E402
from efam._efam import step_many  # noqa: E402
from efam.gym import TipControl, TipControls  # noqa: E402


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
    place = environment._task.scaled(2e5)
    # The pressure at which it rests, and with it one that rises with the tip, which brakes it.
    seen, held = episode(environment, lambda seen: place, target=2e5)
    _, braked = episode(environment, lambda seen: place + 0.6 * seen[3], target=2e5)
    assert np.array_equal(episode(environment, lambda seen: place, target=2e5)[1], held)
    assert braked[200:].mean() > 0.75 * held[200:].mean() and held.max() <= 0
    # The rest of the target is the one of that pressure: the tip swings about it.
    assert abs(seen[1] - seen[6]) < 0.1
    heavy, _ = episode(environment, lambda seen: place, target=2e5, payload="50 g")
    assert heavy[6] < seen[6] - 0.01


def test_what_is_set_for_many_stays_set(scenario):
    """What is set after that is set beside the pressure, not over it."""
    swing = efam.Model(scenario).start()
    step_many([swing], [2e5], 0.01)
    swing.set(**{"effects.rayleigh_mass.alpha": 0.7})
    assert swing["rod.pressure"] == pytest.approx(2e5) and swing["effects.rayleigh_mass.alpha"] == 0.7


def test_many_step_at_once(scenario):
    """Each is what it is alone, and begins anew in the step after its end."""
    many = TipControls(scenario, 3, steps=20)
    seen, info = many.reset(seed=1)
    assert seen.shape == (3, 7) and len(set(info["target_pressure_pa"])) == 3
    alone = [TipControl(scenario, steps=20) for _ in range(3)]
    for environment, pressure in zip(alone, info["target_pressure_pa"]):
        environment.reset(options={"target": pressure})
    for k in range(20):
        action = np.array([[-0.5], [0.1 * k % 1], [0.9]])
        seen, rewards, is_broken, is_over, _ = many.step(action)
        for own, reward, environment, act in zip(seen, rewards, alone, action):
            due, earned, *_ = environment.step(act)
            assert np.array_equal(own, due) and reward == pytest.approx(earned)
        assert not is_broken.any() and is_over.all() == (k == 19)
    begun, rewards, *_, is_over, _ = many.step(many.action_space.sample())
    assert np.all(rewards == 0) and not is_over.any() and np.all(begun[:, 3] == 0)
    assert not np.array_equal(begun[:, 5:], seen[:, 5:])


def test_a_regulator_stands_between_action_and_rod(scenario):
    """A lag of the scenario is kept, and accuracy chooses the mesh: tips beside those of a fine one, in a second of actions."""
    own = efam.Model(scenario, **{"effects.pressure_line.time_constant": 0.2})
    assert TipControl(own)._task.model["effects.pressure_line.time_constant"] == 0.2
    bare = TipControl(scenario, lag=0, accuracy=None)._task.model
    assert "effects.pressure_line.time_constant" not in bare.parameters
    actions = np.repeat(np.random.default_rng(1).uniform(-0.6, 0.6, 5), 20)

    def tips(**options):
        environment = TipControl(scenario, **options)
        environment.reset(seed=1)
        return np.array([environment.step(np.array([action]))[0][:2] for action in actions])

    found, fine = tips(), tips(accuracy="0.002 mm")
    error = np.hypot(*(found - fine).T)
    # Measured 0.07 mm for twenty rods in a second; the swing is 200 mm.
    assert 0 < np.sqrt((error**2).mean()) < 2e-4, error.max()


def test_gymnasium_steps_many_as_well(scenario):
    many = gymnasium.vector.SyncVectorEnv([lambda: TipControl(scenario)] * 4)
    seen, _ = many.reset(seed=1)
    assert seen.shape == (4, 7) and len(set(seen[:, 6])) == 4
    many.close()


def test_steps_a_second(scenario, capsys):
    """Printed alone: other work shares the cores. EFAM_BATCH=1000 gives the figure of the guide."""
    count = int(os.environ.get("EFAM_BATCH", 16))
    many = TipControls(scenario, count)
    many.reset(seed=1)
    many.action_space.seed(1)
    begin = time.perf_counter()
    for _ in range(50):
        many.step(many.action_space.sample())
    with capsys.disabled():
        print(f"\n{50 * count / (time.perf_counter() - begin):.0f} steps a second, {count} rods, {os.cpu_count()} cores")
