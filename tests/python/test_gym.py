"""Environments: the rules of Gymnasium, episodes, seeds, copies, many at once."""

from __future__ import annotations

import copy
import importlib
import multiprocessing
import pickle
import sys
import warnings
from typing import Any

import gymnasium
import numpy as np
import pytest
from conftest import beam
from gymnasium.utils.env_checker import check_env
from gymnasium.vector import AsyncVectorEnv, SyncVectorEnv
from matplotlib.axes import Axes
from numpy.typing import NDArray

from matpoint import ComponentError, SceneError, Simulation, plot
from matpoint.gym import SceneEnv

TIP = "load/tip/traction"
Floats = NDArray[np.float64]


def reward(sim: Simulation) -> float:
    return -abs(float(sim["probe/tip/displacement"][1]))


def prepare(sim: Simulation, random: np.random.Generator) -> None:
    sim[TIP] = [0.0, random.uniform(-100.0, 100.0)]
    sim.step(0.05)


def settings(**changed: Any) -> dict[str, Any]:
    usual = dict(
        scene=beam(),
        actions={TIP: ([-10.0, -100.0], [10.0, 300.0])},
        observations=["energy/total", "probe/tip/displacement", "probe/tip/stress"],
        reward=reward,
        step=0.02,
        prepare=prepare,
    )
    return usual | changed


def make(**changed: Any) -> SceneEnv:
    return SceneEnv(**settings(**changed))


def play(env: gymnasium.Env[Any, Any], seed: int, steps: int = 10) -> tuple[Floats, Floats]:
    """Observations and rewards under random actions."""
    actions = np.random.default_rng(7).uniform(-1.0, 1.0, (steps, 2)).astype(np.float32)
    observation, _ = env.reset(seed=seed)
    observations, rewards = [observation], []
    for action in actions:
        observation, value, *_ = env.step(action)
        observations.append(observation)
        rewards.append(value)
    return np.array(observations), np.array(rewards)


@pytest.mark.parametrize("changed", [{}, {"render_mode": "rgb_array"}, {"prepare": None, "observations": [TIP]}])
def test_gymnasium_finds_nothing_wrong(changed: dict[str, Any]) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        # what a body does has no bounds that could be told
        warnings.filterwarnings("ignore", message=".*observation space m.*imum value is -?infinity")
        env = gymnasium.make("matpoint/Scene-v0", **settings(**changed))
        assert isinstance(env.unwrapped, SceneEnv)
        check_env(env.unwrapped)


def test_observations_are_the_variables_in_order() -> None:
    env = make()
    observation, info = env.reset(seed=1)
    assert observation.dtype == np.float64 and observation.shape == env.observation_space.shape == (12,)
    expected = [env.sim["energy/total"], *env.sim["probe/tip/displacement"], *env.sim["probe/tip/stress"].ravel()]
    assert observation.tolist() == [float(value) for value in expected]
    names = env.observation_names
    assert names[:3] == ("energy/total", "probe/tip/displacement[0]", "probe/tip/displacement[1]")
    assert names[3:6] == ("probe/tip/stress[0, 0]", "probe/tip/stress[0, 1]", "probe/tip/stress[0, 2]")
    assert info == {"time": 0.05, "action_names": (f"{TIP}[0]", f"{TIP}[1]"), "observation_names": names}
    kept = observation.copy()
    env.step(np.zeros(2, np.float32))
    assert np.array_equal(observation, kept), "an observation that was kept must not change later"


@pytest.mark.parametrize(
    ("action", "load"),
    [([-1, -1], [-10, -100]), ([1, 1], [10, 300]), ([0, 0.5], [0, 200]), ([-7, 9], [-10, 300])],
)
def test_actions_go_from_bound_to_bound(action: list[float], load: list[float]) -> None:
    env = make()
    assert env.action_space == gymnasium.spaces.Box(-1.0, 1.0, (2,), np.float32)
    env.reset(seed=1)
    _, value, *_ = env.step(np.array(action, np.float32))
    assert env.sim[TIP].tolist() == load
    assert value == reward(env.sim)


def test_one_bound_serves_all_components() -> None:
    env = make(actions={TIP: (-5.0, 5.0)})
    env.reset(seed=1)
    env.step(np.ones(2, np.float32))
    assert env.sim[TIP].tolist() == [5.0, 5.0]


def test_same_seed_same_episode_to_the_last_bit() -> None:
    env = make()
    first, rewards = play(env, seed=3)
    for other in (env, make()):
        again, rewards_again = play(other, seed=3)
        assert np.array_equal(first, again) and np.array_equal(rewards, rewards_again)
    different, _ = play(env, seed=4)
    assert not np.array_equal(first[0], different[0])
    start, _ = env.reset()
    assert not np.array_equal(start, different[0]), "without a seed the generator goes on"


def test_a_copy_goes_on_alike() -> None:
    env = make()
    play(env, seed=3)
    others = [copy.deepcopy(env), pickle.loads(pickle.dumps(env))]
    action = np.ones(2, np.float32)
    ours, start = env.step(action), env.reset()[0]
    for other in others:
        theirs = other.step(action)
        assert np.array_equal(ours[0], theirs[0]) and ours[1:] == theirs[1:]
        assert np.array_equal(start, other.reset()[0]), "the generator is copied too"


@pytest.mark.parametrize(
    ("changed", "steps"), [({"step": 0.05}, 19), ({"prepare": None}, 50), ({"duration": 0.1}, 5), ({"step": 0.3}, 3)]
)
def test_episodes_are_truncated_at_the_end(changed: dict[str, Any], steps: int) -> None:
    env = make(**changed)
    for _ in range(2):
        env.reset(seed=1)
        ends = [env.step(np.zeros(2, np.float32))[2:4] for _ in range(steps)]
        assert ends == [(False, False)] * (steps - 1) + [(False, True)]


def test_the_caller_says_when_an_episode_is_over() -> None:
    env = make(prepare=None, terminated=lambda sim: np.bool_(sim.time > 0.05))
    env.reset()
    assert [env.step(np.zeros(2, np.float32))[2] for _ in range(3)] == [False, False, True]


def test_a_step_that_fails_ends_the_episode() -> None:
    scene = beam(load={"weight": {"gravity": "external"}}, boundary={})
    env = make(scene=scene, actions={"load/weight/body_force": (0.0, 1e3)}, prepare=None, step=0.05)
    env.reset()
    for _ in range(10):
        before = env.sim.save()
        observation, value, terminated, truncated, info = env.step(np.ones(2, np.float32))
        if terminated:
            break
    assert terminated and not truncated and "left the grid" in info["error"] and info["time"] == env.sim.time
    env.sim.restore(before)
    assert value == reward(env.sim) and observation[0] == env.sim["energy/total"]
    assert env.reset()[1]["time"] == 0.0 and "error" not in env.step(-np.ones(2, np.float32))[4]


@pytest.mark.parametrize("kind", ["sync", *multiprocessing.get_all_start_methods()])
def test_many_at_once_do_what_one_does(kind: str) -> None:
    makers = [make] * 2
    many = SyncVectorEnv(makers) if kind == "sync" else AsyncVectorEnv(makers, context=kind)
    observations, info = many.reset(seed=[3, 4])
    rows, rewards = [observations.copy()], []
    for action in np.random.default_rng(7).uniform(-1.0, 1.0, (10, 2)).astype(np.float32):
        observations, values, *_, info = many.step(np.array([action, action]))
        rows.append(observations.copy())
        rewards.append(values)
    many.close()
    assert info["time"].tolist() == pytest.approx([0.25, 0.25])
    for index, seed in enumerate((3, 4)):
        alone, alone_rewards = play(make(), seed)
        assert np.array_equal(np.array(rows)[:, index], alone)
        assert np.array_equal(np.array(rewards)[:, index], alone_rewards)


def test_pictures_of_one_part_of_space(monkeypatch: pytest.MonkeyPatch) -> None:
    assert make().render() is None
    env = make(render_mode="rgb_array")
    assert env.metadata["render_fps"] == 50
    drawn: list[Axes] = []
    draw = plot.particles
    monkeypatch.setattr(plot, "particles", lambda sim, ax: drawn.append(draw(sim, ax=ax)))
    env.reset(seed=1)
    first = env.render()
    env.step(np.ones(2, np.float32))
    second = env.render()
    assert first is not None and second is not None and not np.array_equal(first, second)
    assert first.shape == second.shape == (480, 640, 3) and first.dtype == np.uint8
    for ax in drawn:
        assert ax.get_xlim() == (0.0, 5.0) and ax.get_ylim() == (-2.0, 2.0)
        assert ax.get_position().bounds == drawn[0].get_position().bounds, "the frame must stand still"


@pytest.mark.parametrize(
    ("changed", "error", "message"),
    [
        ({"scene": "none.toml"}, SceneError, "cannot be read"),
        ({"actions": {"load/tip/tractio": (0.0, 1.0)}}, ComponentError, "did you mean `load/tip/traction`"),
        ({"actions": {"energy/total": (0.0, 1.0)}}, ComponentError, "energy/total"),
        ({"actions": {TIP: (0.0, np.inf)}}, ComponentError, "inf"),
        ({"actions": {TIP: ([0.0, 2.0], 1.0)}}, ValueError, "lower bound of `load/tip/traction` is above the upper"),
        ({"actions": {TIP: ([0.0, 0.0, 0.0], 1.0)}}, ValueError, "shape"),
        ({"actions": {}}, ValueError, "needs an action"),
        ({"observations": ["energy/totl"]}, ComponentError, "did you mean"),
        ({"observations": []}, ValueError, "needs an action"),
        ({"step": 0.0}, ValueError, "must be above 0"),
        ({"step": float("nan")}, ValueError, "must be above 0"),
        ({"render_mode": "human"}, ValueError, "may be None or 'rgb_array'"),
    ],
)
def test_what_makes_no_sense_is_refused(changed: dict[str, Any], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        make(**changed)


@pytest.mark.parametrize("action", [[np.nan, 0.0], [0.0, 0.0, 0.0], [0.0]])
def test_actions_that_are_none_are_refused(action: list[float]) -> None:
    env = make()
    env.reset(seed=1)
    with pytest.raises((ComponentError, ValueError)):
        env.step(np.array(action, np.float32))


def test_without_gymnasium_it_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, "matpoint.gym")
    monkeypatch.setitem(sys.modules, "gymnasium", None)
    with pytest.raises(ImportError, match=r"pip install matpoint\[gym\]"):
        importlib.import_module("matpoint.gym")
