"""The environment: its contract, its bits, an expert that closes and chance that does not."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium")

from gymnasium.utils.env_checker import check_env  # noqa: E402

import rhexis.gym  # noqa: E402
from rhexis.gym.env import JAWS_COLOUR, SPEED  # noqa: E402
from rhexis.gym.picture import BACK, FRONT, GROUND, draw, on_screen  # noqa: E402


@pytest.fixture(scope="module")
def env() -> rhexis.gym.Capsulorhexis:
    return rhexis.gym.Capsulorhexis()


def test_it_keeps_the_contract_of_gymnasium() -> None:
    check_env(gymnasium.make(rhexis.gym.ENV_ID).unwrapped)


def test_the_same_seed_and_actions_give_the_same_bits(env: rhexis.gym.Capsulorhexis) -> None:
    def run(seed: int) -> list[object]:
        observation, _ = env.reset(seed=seed, options={"grasped": True})
        trace: list[object] = [observation.tobytes()]
        actions = np.random.default_rng(seed).uniform(-1, 1, (8, 4)).astype(np.float32)
        for action in actions:
            observation, reward, *_ = env.step(action)
            trace += [observation.tobytes(), reward]
        return [*trace, env.world.hash()]

    first = run(3)
    assert run(4) != first and run(3) == first


def test_actions_move_the_jaws_in_their_own_frame(env: rhexis.gym.Capsulorhexis) -> None:
    env.reset(seed=1)
    for row in range(3):
        before = env.jaws.copy()
        outward, around = env.frame(before)
        action = np.zeros(4, dtype=np.float32)
        action[row], action[3] = 0.5, -1.0
        env.step(action)
        way = (env.jaws - before) / (SPEED * 100.0)
        np.testing.assert_allclose(way, 0.5 * np.array([outward, around, [0, 0, 1]])[row], atol=1e-9)
    for bad in (np.full(4, np.nan), np.full(4, np.inf), np.full(4, -1e30)):
        observation, reward, *_ = env.step(bad)
        assert np.isfinite(observation).all() and np.isfinite(reward)


def test_jaws_hold_the_flap_and_feel_it(env: rhexis.gym.Capsulorhexis) -> None:
    names = env.OBSERVATION
    observation, _ = env.reset(seed=1)
    assert observation[names.index("jaws closed: 1, else 0")] == 0.0
    observation, _ = env.reset(seed=1, options={"grasped": True})
    assert observation[names.index("jaws closed: 1, else 0")] == 1.0
    for _ in range(5):
        observation, *_ = env.step(np.array([0, 0.2, 0.2, 1], dtype=np.float32))
    assert np.linalg.norm(observation[names.index("force of the jaws: outwards") :][:3]) > 0.01
    env.step(np.array([0, 0, 0, -1], dtype=np.float32))
    assert not env.is_closed()


def test_the_expert_closes_the_rhexis(env: rhexis.gym.Capsulorhexis) -> None:
    """Its diameter is within 10 % of the 5.25 mm of the hand's circle, as the scene's is on its meshes (docs/capsulorhexis.md)."""
    total, info = rhexis.gym.play(env, rhexis.gym.Expert(env), seed=1)
    print(total, info)
    assert info["outcome"] == "closed" and info["completion_deg"] == pytest.approx(360.0)
    assert 4.7 < info["diameter_mm"] < 5.8 and info["circularity"] > 0.9
    assert 3 <= info["grasps"] <= 6
    # 330° gone round, 1 for closing, the circularity, less 0.24 for the diameter and what force beyond 20 mN costs.
    assert 2.3 < total < 2.9


def test_chance_does_not_close_it(env: rhexis.gym.Capsulorhexis) -> None:
    total, info = rhexis.gym.play(env, rhexis.gym.RandomPolicy(env, seed=1), seed=1, frames=120)
    print(total, info)
    assert info["outcome"] != "closed" and total < 0.5


def test_it_runs_beside_itself_in_processes() -> None:
    make = [lambda: gymnasium.make(rhexis.gym.ENV_ID)] * 2
    envs = gymnasium.vector.AsyncVectorEnv(make)
    alone = gymnasium.vector.SyncVectorEnv(make)
    try:
        for vector in (envs, alone):
            vector.reset(seed=[5, 6])
        actions = np.tile(np.array([0.1, 0.2, -0.3, -1.0], dtype=np.float32), (2, 1))
        for _ in range(3):
            seen, *_ = envs.step(actions)
            expected, *_ = alone.step(actions)
            np.testing.assert_array_equal(seen, expected)
        assert not np.array_equal(seen[0], seen[1])
    finally:
        envs.close()
        alone.close()


def picture_of(env: rhexis.gym.Capsulorhexis) -> np.ndarray:
    picture = env.render()
    assert picture is not None and picture.shape == (480, 480, 3) and picture.dtype == np.uint8
    return picture


def test_pictures_show_the_tissue_and_its_tear() -> None:
    env = gymnasium.make(rhexis.gym.ENV_ID, render_mode="rgb_array").unwrapped
    assert env.metadata["render_fps"] == 10
    check_env(env)
    env.reset(seed=1)
    start = picture_of(env)
    np.testing.assert_array_equal(start, picture_of(env))

    def share(picture: np.ndarray, colour: tuple[int, int, int]) -> float:
        """Part of the picture whose colours are a shade of this one."""
        shade = picture / np.maximum(np.linalg.norm(picture, axis=2, keepdims=True), 1.0)
        return float((shade @ (np.array(colour) / np.linalg.norm(colour)) > 0.999).mean())

    assert 0.4 < share(start, FRONT) < 0.7 and share(start, JAWS_COLOUR[False]) > 2e-4
    env.reset(seed=1, options={"grasped": True})
    grasped, torn = picture_of(env), env.world.course()["completion_deg"]
    assert share(grasped, JAWS_COLOUR[True]) > 2e-4 > share(grasped, JAWS_COLOUR[False])
    expert, hash_before = rhexis.gym.Expert(env), 0
    for _ in range(30):
        env.step(expert(None))
        hash_before = env.world.hash()
    assert env.world.course()["completion_deg"] > torn + 20.0
    later = picture_of(env)
    assert env.world.hash() == hash_before
    # The flap is folded over: its back is seen, and the ground where it was.
    assert share(later, BACK) > share(grasped, BACK) + 0.005
    assert share(later, FRONT) < share(grasped, FRONT) - 0.005


def test_the_nearest_surface_is_seen_whatever_the_order_of_triangles() -> None:
    upper = np.array([[-1, -1, 1], [1, -1, 1], [1, 1, 1], [-1, 1, 1]], dtype=float)
    positions = np.vstack([upper, 3.0 * upper - [0, 0, 3]])
    # The lower square shows its back.
    triangles = np.array([[0, 1, 2], [0, 2, 3], [4, 6, 5], [4, 7, 6]], dtype=np.uint32)
    picture = draw(positions, triangles, [], 64)
    np.testing.assert_array_equal(picture, draw(positions, triangles[::-1], [], 64))
    for place, colour in (([0, 0, 1], FRONT), ([2.5, 0, 0], BACK)):
        column, row, _ = on_screen(np.array(place, dtype=float), 64).astype(int)
        pixel = picture[row, column] / np.linalg.norm(picture[row, column])
        assert pixel @ np.array(colour) / np.linalg.norm(colour) > 0.999
    np.testing.assert_array_equal(picture[0, 0], GROUND)


def test_without_a_render_mode_nothing_is_drawn(env: rhexis.gym.Capsulorhexis) -> None:
    with pytest.warns(UserWarning, match="rgb_array"):
        assert env.render() is None


def test_it_refuses_what_it_cannot_draw() -> None:
    with pytest.raises(ValueError, match="to_pyvista"):
        rhexis.gym.Capsulorhexis(render_mode="human")
    with pytest.raises(TypeError, match="Capsulorhexis"):
        rhexis.gym.Expert(gymnasium.make("CartPole-v1"))


def test_the_agent_learns_what_is_rewarded(monkeypatch: pytest.MonkeyPatch) -> None:
    """By a stand-in for the episodes: weights near one. That the search climbs, and its sign, show here."""
    pytest.importorskip("cma")
    spec = importlib.util.spec_from_file_location("learn", Path(__file__).parents[1] / "examples/learn.py")
    assert spec is not None and spec.loader is not None
    learn = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(learn)

    class Serial:
        def map(self, call: Callable[[object], float], over: Sequence[object], chunksize: int = 1) -> list[float]:
            return [call(item) for item in over]

    drawn = learn.score(np.zeros(learn.SHAPE).ravel())
    assert np.isfinite(drawn) and drawn == learn.score(np.zeros(learn.SHAPE).ravel())
    monkeypatch.setattr(learn, "score", lambda weights: -float(np.square(weights - 1.0).sum()))
    scores, mean = learn.learn(Serial(), 60)
    assert len(scores) == 60 and len(scores[0]) == learn.POPULATION
    assert np.square(mean - 1.0).sum() < 0.2 * mean.size
