"""Run one scene with many parameters, and show the volume of a twisted bust before and after the correction.

python examples/python/05_sweep.py [PLOT.png]          (needs matplotlib)
"""

from __future__ import annotations

import sys
from concurrent.futures import ThreadPoolExecutor

import matplotlib

matplotlib.use("Agg")  # no window
import matplotlib.pyplot as plt

import supple


def main(plot: str = "sweep.png") -> None:
    """Run all combinations, two at a time. A process pool or a Dask cluster works in the same way."""
    # Frame 51 is at 1.7 s, when the crown has turned by 180 degrees.
    frequencies, half_widths = [3.0, 6.0, 12.0], [1, 2, 3]
    parameters = {"body.bust.half_width": half_widths, "body.bust.frequency": frequencies}
    with ThreadPoolExecutor(max_workers=2) as executor:
        results = supple.sweep("examples/scenes/twist.toml", parameters, executor, frames=51)

    _, axes = plt.subplots(layout="constrained")
    print("  half-width   frequency   relative volume before correction   after")
    for half_width in half_widths:
        selected = [result for result in results if result.parameters["body.bust.half_width"] == half_width]
        volumes = [result.report.bodies[0].volume for result in selected]
        for frequency, volume in zip(frequencies, volumes, strict=True):
            before, after = volume.before / volume.rest, volume.after / volume.rest
            print(f"{half_width:6d} cells {frequency:8.1f} Hz {before:32.3f} {after:13.6f}")
        axes.plot(frequencies, [v.before / v.rest for v in volumes], marker="o", label=f"half-width {half_width}")
    axes.set(xlabel="frequency [Hz]", ylabel="volume before correction / at rest", xscale="log")
    axes.legend()
    plt.savefig(plot, dpi=120)
    print(f"{plot}: plot of the table")


if __name__ == "__main__":
    main(*sys.argv[1:])
