# %% [markdown]
# # Bananas, and a pose graph
#
# Where may a robot be after a hundred uncertain steps? Its region is an ellipsoid in the tangent, and a banana on the ground.

# %%
from __future__ import annotations

import numpy as np

import boxplus as bp

step = bp.Gaussian.from_sigmas(bp.SE2([0.1, 0.0], 0.0), [0.005, 0.005, 0.02])  # 10 cm ahead; metres, metres, radians
pose = step
for _ in range(99):
    pose = pose.compose(step, order=4)

# %% [markdown]
# The same by drawing: of ten thousand robots, 95 % end within the region of 95 %.

# %%
rng = np.random.default_rng(0)
robots = bp.SE2.identity(10_000)
for _ in range(100):
    robots = robots @ step.sample(rng, 10_000)
inside = np.mean(np.asarray(pose.mahalanobis_squared(robots)) < 7.815)  # χ² of three degrees of freedom
print(f"{100 * inside:.1f} % of the robots are within the region of 95 %")
assert abs(inside - 0.95) < 0.02

# %% [markdown]
# ## A pose graph
# A drive around a square, measured with noise; coming home closes the loop and straightens it.

# %%
side = bp.SE2([1.0, 0.0], 0.0)
corner = bp.SE2([1.0, 0.0], np.pi / 2)
steps = bp.SE2.stack([corner if k % 5 == 4 else side for k in range(20)])
sigmas = np.array([0.05, 0.02, 0.03])
measured = steps + sigmas * rng.normal(size=(20, 3))
graph = bp.PoseGraph()
graph.add_edges(np.arange(20), (np.arange(20) + 1) % 20, measured, sigmas=sigmas)
solution = graph.solve()
print(solution)
assert solution.converged and solution.held == ["SE2 0"]
