"""The environment: what is seen, what is done, what it is worth."""

from __future__ import annotations

from importlib.resources import files
from typing import Any, ClassVar

import gymnasium
import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from .._rhexis import Entity, Error, World
from .picture import Ball, draw

ENV_ID = "rhexis/Capsulorhexis-v0"
FRAME = 100.0
"""Time of an action [ms]."""
MAX_FRAMES = 290
"""Actions of an episode: 29 s, as the scene of the catalog has."""
SPEED = 0.01
"""Speed of the jaws [mm/ms] at an action of 1 along one axis: ten times the pace of a tear."""
REACH = 0.5
"""How far the jaws find tissue [mm]."""
BOUND = np.array([6.0, 6.0, 3.0])
"""Half of the box that the jaws stay in [mm], about the pole."""
PARKED = np.array([2.2, 0.8, 0.8])
"""Where the jaws are at the beginning [mm]: above the flap."""
FORCE = 0.02
"""Force [N] that the observation has as 1 and beyond which the reward falls: twice that of experts."""

_Array = NDArray[np.float64]

SLIP = 0.05
"""Force [N] at which the tissue slips out of the jaws: five times that of experts."""
DIAMETER = 5.25
"""Diameter of the opening that is aimed at [mm], as in the scene of the catalog."""
PIXELS = 480
"""Width and height of a picture [pixels]."""
JAWS_COLOUR = {False: (176, 180, 186), True: (244, 190, 60)}
"""Colour of the jaws in a picture, by whether they hold tissue."""
TIP_COLOUR = (214, 36, 46)
MOST = 20.0
"""Bound of the observation: beyond it a number is cut off, as the force of jaws that are torn away is."""


class Capsulorhexis(gymnasium.Env[NDArray[np.float32], NDArray[np.float32]]):
    """A round opening is torn into a lens capsule by forceps that the agent moves, opens and closes.

    Action, 4 numbers in [-1, 1]: velocity of the jaws outwards from the axis, counter-clockwise round it, and upwards, in units
    of 10 mm/s; the jaws close where the fourth is above 0 and open otherwise. It holds for a frame of 100 ms. Jaws that are pulled harder than with
    50 mN let go.

    Observation, 16 numbers, see `OBSERVATION`. Lengths are in mm over 5, forces in units of 20 mN; directions are outwards,
    counter-clockwise, upwards at the jaws.

    Reward: turns that the tear has gone round in the frame; less a tenth of the force beyond 20 mN, in units of 20 mN; when it
    closes, 1 and the circularity of the opening, less how far its diameter is from 5.25 mm [mm]; -1 when it runs out to the rim or
    the flap tears off.

    An episode ends when the tear has ended, or when a step has failed; it is cut off after 290 frames, 29 s.

    Options of `reset`: `"grasped": True` begins with the flap between the jaws, lifted by 0.5 mm.

    Render mode `"rgb_array"`: `render` gives a picture of 480 by 480 pixels, seen from above and from -y. The back of the flap is blue, tips
    are red, jaws grey or, with tissue between them, yellow.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"], "render_fps": round(1000.0 / FRAME)}

    OBSERVATION: ClassVar[tuple[str, ...]] = (
        "radius of the jaws",
        "height of the jaws above the rest plane of the pole",
        "jaws ahead of the tip: sine of the angle about the axis",
        "jaws ahead of the tip: cosine",
        "radius of the tip",
        "tip seen from the jaws: outwards",
        "tip seen from the jaws: counter-clockwise",
        "tip seen from the jaws: upwards",
        "direction of the tear: outwards at the tip",
        "direction of the tear: counter-clockwise at the tip",
        "turns gone round",
        "jaws closed: 1, else 0",
        "force of the jaws: outwards",
        "force of the jaws: counter-clockwise",
        "force of the jaws: upwards",
        "part of the time that has passed",
    )

    def __init__(self, changes: dict[str, Any] | None = None, spread: float = 0.1, render_mode: str | None = None) -> None:
        """Makes the capsule once; `reset` goes back to it.

        `changes` are those of `World.from_scene`; `spread` is how far the jaws may begin beside their place [mm].
        """
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise ValueError(f"there is no render mode {render_mode!r}: take 'rgb_array', or draw with rhexis.to_pyvista")
        text = files("rhexis.gym").joinpath("capsule.toml").read_text(encoding="utf-8")
        # One thread: environments run beside each other, and the bits are the same for any number.
        world = World.from_scene(text, "capsule.toml", {"run.threads": 1, **(changes or {})})
        self.world = world
        self.body: Entity = world.bodies[0]
        self.forceps: Entity = world.spawn_forceps("forceps", PARKED, radius=0.2, stiffness=0.2, force_limit=SLIP)
        world.follow_course()
        self._start = world.snapshot()
        self._steps = round(FRAME / world.scene["dt"])
        self._dt = FRAME / self._steps
        self._spread = spread
        self.render_mode = render_mode
        self.observation_space = spaces.Box(-MOST, MOST, (len(self.OBSERVATION),), np.float32)
        self.action_space = spaces.Box(-1.0, 1.0, (4,), np.float32)
        self.jaws = PARKED.copy()
        self._tip, self._tip_at, self._tip_way = 0, np.zeros(3), np.array([0.0, 1.0, 0.0])
        self._frames = 0

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[NDArray[np.float32], dict[str, Any]]:
        super().reset(seed=seed)
        self.world.restore(self._start)
        self._frames = 0
        tips = self.world.tips()
        # The outer end of the puncture leads; the inner one is the flap's root.
        leading = int(np.argmax(np.hypot(*tips["rest_positions"][:, :2].T)))
        self._tip = int(tips["keys"][leading])
        self._see_tip()
        self.jaws = PARKED + self.np_random.uniform(-self._spread, self._spread, 3)
        if (options or {}).get("grasped", False):
            self._take_flap()
        self.world.move_forceps(self.forceps, self.jaws, within=0.0)
        return self._observation(), self._info()

    def step(
        self, action: NDArray[np.float32]
    ) -> tuple[NDArray[np.float32], float, bool, bool, dict[str, Any]]:
        action = np.clip(np.nan_to_num(np.asarray(action, dtype=float)), -1.0, 1.0)
        before = self.world.course()["completion_deg"]
        self._use_jaws(bool(action[3] > 0.0))
        outward, around = self.frame(self.jaws)
        way = SPEED * FRAME * (action[0] * outward + action[1] * around + action[2] * np.array([0.0, 0.0, 1.0]))
        has_failed = self._lead(np.clip(self.jaws + way, -BOUND, BOUND))
        self._frames += 1
        self._see_tip()
        course = self.world.course()
        reward = (course["completion_deg"] - before) / 360.0
        reward -= 0.1 * max(float(np.linalg.norm(self.force())) / FORCE - 1.0, 0.0)
        if course["outcome"] == "closed":
            reward += 1.0 + (course["circularity"] or 0.0) - abs((course["diameter_mm"] or 0.0) - DIAMETER)
        elif course["outcome"] != "unfinished":
            reward -= 1.0
        has_ended = course["outcome"] != "unfinished" or has_failed
        return self._observation(), reward, has_ended, self._frames >= MAX_FRAMES, self._info()

    def render(self) -> NDArray[np.uint8] | None:
        """The picture of the state, (480, 480, 3); nothing without a render mode."""
        if self.render_mode is None:
            gymnasium.logger.warn('render() draws with gymnasium.make(..., render_mode="rgb_array")')
            return None
        tips = [Ball(place, 0.09, TIP_COLOUR) for place in self.world.tips()["positions"]]
        jaws = Ball(self.jaws, 0.2, JAWS_COLOUR[self.is_closed()])
        return draw(self.world.positions(copy=False), self.world.indices(copy=False), [*tips, jaws], PIXELS)

    def frame(self, at: _Array) -> tuple[_Array, _Array]:
        """Unit vectors outwards from the axis and counter-clockwise round it at a place; x and y on the axis."""
        radius = float(np.hypot(at[0], at[1]))
        x, y = (at[0] / radius, at[1] / radius) if radius > 1e-9 else (1.0, 0.0)
        return np.array([x, y, 0.0]), np.array([-y, x, 0.0])

    def force(self) -> _Array:
        """Force of the jaws on the tissue [N]."""
        return self.world.forceps(self.forceps)["force"]

    def is_closed(self) -> bool:
        """Whether the jaws hold tissue."""
        return self.world.forceps(self.forceps)["body"] is not None

    def tip(self) -> tuple[_Array, _Array]:
        """Place and direction of the leading tip in the rest shape [mm]; the last that it had where it is gone."""
        return self._tip_at, self._tip_way

    def _see_tip(self) -> None:
        tips = self.world.tips()
        keys = tips["keys"]
        if len(keys) == 0:
            return
        row = np.flatnonzero(keys == self._tip)
        places = tips["rest_positions"]
        # A tip that has ended and been renewed goes on nearby.
        leading = int(row[0]) if len(row) else int(np.argmin(np.linalg.norm(places - self._tip_at, axis=1)))
        self._tip = int(keys[leading])
        self._tip_at, self._tip_way = places[leading], tips["directions"][leading]

    def _use_jaws(self, is_to_close: bool) -> None:
        is_closed = self.is_closed()
        if is_closed and not is_to_close:
            self.world.open_forceps(self.forceps)
        elif is_to_close and not is_closed:
            try:
                self.world.close_forceps(self.forceps, self.body, nearest=REACH)
            except Error as error:
                # Jaws that close on nothing hold nothing.
                if error.kind != "nothing_done":
                    raise

    def _lead(self, to: _Array) -> bool:
        """Moves the jaws to a place within the frame; whether a step has failed."""
        way = (to - self.jaws) / self._steps
        for step in range(1, self._steps + 1):
            self.world.move_forceps(self.forceps, self.jaws + step * way, within=self._dt)
            has_failed = self.world.advance().has_failed
            if has_failed or self.world.is_finished:
                break
        self.jaws = self.world.forceps(self.forceps)["position"]
        self.world.events()
        return has_failed

    def _take_flap(self) -> None:
        place, way = self.tip()
        hit = self.world.current(place + beside(way))
        if hit is None:
            return
        self.jaws = hit["position"]
        self.world.move_forceps(self.forceps, self.jaws, within=0.0)
        self._use_jaws(True)
        for _ in range(5):
            self._lead(self.jaws + np.array([0.0, 0.0, 0.1]))

    def _observation(self) -> NDArray[np.float32]:
        here = self.world.current(self._tip_at)
        tip = self._tip_at if here is None else here["position"]
        outward, around = self.frame(self.jaws)
        at_tip = self.frame(self._tip_at)
        up = np.array([0.0, 0.0, 1.0])
        jaws, seen, force = self.jaws, (tip - self.jaws) / 5.0, self.force() / FORCE
        axes = np.array([outward, around, up])
        numbers = [
            np.hypot(jaws[0], jaws[1]) / 5.0,
            jaws[2] / 5.0,
            float(outward @ at_tip[1]),
            float(outward @ at_tip[0]),
            np.hypot(self._tip_at[0], self._tip_at[1]) / 5.0,
            *(axes @ seen),
            float(self._tip_way @ at_tip[0]),
            float(self._tip_way @ at_tip[1]),
            self.world.course()["completion_deg"] / 360.0,
            float(self.is_closed()),
            *(axes @ force),
            self._frames / MAX_FRAMES,
        ]
        return np.clip(np.array(numbers, dtype=np.float32), -MOST, MOST)

    def _info(self) -> dict[str, Any]:
        course = self.world.course()
        return {
            name: course[name]
            for name in ("outcome", "completion_deg", "diameter_mm", "circularity", "grasps", "force_rms_n")
        }


def beside(way: _Array, behind: float = 0.35, left: float = 0.35) -> _Array:
    """From a tip to the flap beside it [mm, rest shape]: behind it, and left of its direction, as the scene's grasps take it."""
    level = np.array([way[0], way[1], 0.0])
    level /= max(float(np.linalg.norm(level)), 1e-9)
    return left * np.array([-level[1], level[0], 0.0]) - behind * level
