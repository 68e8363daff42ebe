"""Many runs of one scene: how far a dropped bust is pressed together, for different stiffness.

python examples/python/04_sweep.py
"""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor

import supple


def main() -> None:
    """Runs all combinations, two at a time."""
    parameters = {"body.bust.frequency": [4.0, 8.0], "body.bust.half_width": [1, 2, 3]}
    with ThreadPoolExecutor(max_workers=2) as executor:
        results = supple.sweep("examples/scenes/drop.toml", parameters, executor, frames=30)
    print("  frequency   half-width   volume by shape matching after 1 s   as shown")
    for result in results:
        frequency, half_width = result.parameters.values()
        volume = result.report.bodies[0].volume
        before, after = volume.before / volume.rest, volume.after / volume.rest
        print(f"{frequency:8.1f} Hz {half_width:6d} cells {before:34.3f} {after:10.6f}")


if __name__ == "__main__":
    main()
