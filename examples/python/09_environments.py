"""Step 64 Gymnasium environments at once: soft dice that a force pushes to a goal on the ground (needs gymnasium).

python examples/python/09_environments.py
"""

from __future__ import annotations

from time import perf_counter
from typing import Any

import gymnasium
import numpy as np
from gymnasium import spaces
from gymnasium.vector.utils import batch_space

import supple

COUNT, STEPS, LAST = 64, 4, 60
"""Number of environments, simulation steps per action, and actions per episode."""


class PushDice(gymnasium.vector.VectorEnv):
    """A vector of environments, one simulation each: `supple.step_all` steps all of them, each on one thread."""

    def __init__(self, count: int) -> None:
        """Build the dice, which lie on a ground."""
        self.num_envs = count
        # Goal relative to the die, and its velocity; horizontal force as a multiple of a third of the weight.
        self.single_observation_space = spaces.Box(-np.inf, np.inf, (5,), np.float32)
        self.single_action_space = spaces.Box(-1, 1, (2,), np.float32)
        self.observation_space = batch_space(self.single_observation_space, count)
        self.action_space = batch_space(self.single_action_space, count)
        lattice = supple.Lattice.from_cells(np.ones((3, 3, 3), bool), cell_size=0.1, origin=(-0.15, 0, -0.15))
        ground = supple.Plane((0, 0, 0), (0, 1, 0), friction=0.05)
        dice = [supple.Body(lattice, material="jelly") for _ in range(count)]
        self.sims = [supple.Simulation([die], dt=1 / 120, colliders=ground, sleep=False) for die in dice]
        self.dice = dice
        self.goals = np.zeros((count, 2))
        self.actions = 0

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        """Put all dice back, and draw new goals."""
        super().reset(seed=seed)
        for sim in self.sims:
            sim.reset()
        self.goals = self.np_random.uniform(-1, 1, (self.num_envs, 2))
        self.actions = 0
        return self._observations(), {}

    def step(self, actions: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, dict[str, Any]]:
        """Push each die for some steps."""
        for die, (x, z) in zip(self.dice, actions, strict=True):
            die.apply_force((9.81 / 3 * die.mass * float(x), 0, 9.81 / 3 * die.mass * float(z)))
        supple.step_all(self.sims, STEPS)
        self.actions += 1
        observations = self._observations()
        distances = np.linalg.norm(observations[:, :2], axis=1)
        at_end = np.full(self.num_envs, self.actions == LAST)
        return observations, -distances, np.zeros(self.num_envs, bool), at_end, {}

    def _observations(self) -> np.ndarray:
        centers = np.array([die.center_of_mass for die in self.dice])
        speeds = np.array([die.linear_momentum / die.mass for die in self.dice])
        return np.hstack([self.goals - centers[:, [0, 2]], speeds]).astype(np.float32)


def main() -> None:
    """Compare random pushes with pushes towards the goal, and print the mean distances at the end."""
    environments = PushDice(COUNT)
    start, distances = perf_counter(), []
    for policy in ("random", "towards the goal"):
        observations, _ = environments.reset(seed=1)
        environments.action_space.seed(1)
        is_over = False
        while not is_over:
            actions = environments.action_space.sample()
            if policy != "random":
                # A spring to the goal, with damping.
                actions = np.clip(2 * observations[:, :2] - observations[:, [2, 4]], -1, 1)
            observations, rewards, _, at_end, _ = environments.step(actions)
            is_over = bool(at_end.all())
        distances.append(-rewards.mean())
        print(f"{policy}: {COUNT} dice end {distances[-1]:.3f} from their goals on average")
    steps = 2 * LAST * STEPS * COUNT
    print(f"{steps / (perf_counter() - start):,.0f} steps per second in all")
    assert distances[1] < 0.5 * distances[0], distances


if __name__ == "__main__":
    main()
