"""Run one scene with many parameters: the volume that a twisted bust loses without correction, as a table and a plot.

python examples/python/05_sweep.py [PICTURE.png]          (needs matplotlib)
"""

from __future__ import annotations

import sys
from concurrent.futures import ThreadPoolExecutor

import matplotlib

matplotlib.use("Agg")  # no window
import matplotlib.pyplot as plt

import supple


def main(picture: str = "sweep.png") -> None:
    """Run all combinations, two at a time. A process pool or a Dask cluster works in the same way."""
    frequencies, half_widths = [3.0, 6.0, 12.0], [1, 2, 3]
    parameters = {"body.bust.half_width": half_widths, "body.bust.frequency": frequencies}
    with ThreadPoolExecutor(max_workers=2) as executor:
        results = supple.sweep("examples/scenes/twist.toml", parameters, executor, frames=51)

    _, axes = plt.subplots(layout="constrained")
    print("  half-width   frequency   volume before correction, half turned   after")
    for half_width in half_widths:
        of_width = [result for result in results if result.parameters["body.bust.half_width"] == half_width]
        volumes = [result.report.bodies[0].volume for result in of_width]
        for frequency, volume in zip(frequencies, volumes, strict=True):
            before, after = volume.before / volume.rest, volume.after / volume.rest
            print(f"{half_width:6d} cells {frequency:8.1f} Hz {before:36.3f} {after:13.6f}")
        axes.plot(frequencies, [v.before / v.rest for v in volumes], marker="o", label=f"half-width {half_width}")
    axes.set(xlabel="frequency [Hz]", ylabel="volume without correction / at rest", xscale="log")
    axes.legend()
    plt.savefig(picture, dpi=120)
    print(f"{picture}: plot of the table")


if __name__ == "__main__":
    main(*sys.argv[1:])
