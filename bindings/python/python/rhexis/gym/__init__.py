"""The capsulorhexis as a Gymnasium environment: `gymnasium.make("rhexis/Capsulorhexis-v0")`, after `import rhexis.gym`."""

try:
    import gymnasium
except ModuleNotFoundError as error:
    raise ModuleNotFoundError("rhexis.gym needs Gymnasium: pip install gymnasium") from error

from .env import ENV_ID, MAX_FRAMES, Capsulorhexis
from .policies import Expert, RandomPolicy, play

__all__ = ["ENV_ID", "Capsulorhexis", "Expert", "RandomPolicy", "play"]

if ENV_ID not in gymnasium.registry:
    gymnasium.register(id=ENV_ID, entry_point="rhexis.gym.env:Capsulorhexis", max_episode_steps=MAX_FRAMES)
