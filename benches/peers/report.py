"""Writes results.csv, the tables and the plot from the results in a folder; see run.py.

With --write, rows of the page that have no result in the folder stay, so that it can be measured in parts.

python benches/peers/report.py target/peers [--write docs/measured/peers.md]
"""

from __future__ import annotations

import argparse
import csv
import datetime
import json
import os
import platform
import subprocess
from dataclasses import asdict
from pathlib import Path

from worker import Measurements

HERE = Path(__file__).parent
ORDER = ("box-1000", "bust-1000", "box-10000", "bust-10000", "box-100000", "bust-100000", "pile", "fold")
SECTIONS = ("machine", "settings", "not installed", *ORDER)
SPEED_TIMES = ("3", "4", "6")
BEGIN, END = "<!-- begin {} -->", "<!-- end {} -->"
HEADER = (
    "| program | steps | ms a frame: median | 90 % | set-up, s | memory, MB | volume, stretched | volume, rest "
    "| shape, rest | speed, 3 s | 4 s | 6 s | in planes, mm | in bodies, mm | failed |"
)


def main() -> None:
    """Write all files."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("--write", type=Path, metavar="FILE")
    arguments = parser.parse_args()
    results = [Measurements(**json.loads(path.read_text())) for path in sorted(arguments.folder.glob("runs/*.json"))]
    machines = [machine(results)]
    if arguments.write:
        page = read_page(arguments.write)
        kept = kept_rows(page, results)
        machines += older_machines(page, kept)
        results += kept
    results.sort(key=lambda result: (ORDER.index(result.task), result.ms_median or 1e9))
    write_csv(results, arguments.folder / "results.csv")
    plot(results, arguments.folder / "peers.svg")
    sections = {
        "machine": machines,
        "settings": settings(results),
        "not installed": not_installed(arguments.folder / "not-installed.txt"),
    }
    for task in ORDER:
        rows = [result for result in results if result.task == task]
        sections[task] = task_table(rows) if rows else ["Not measured."]
    if arguments.write:
        write_page(arguments.write, sections)
        image = arguments.write.parent.parent / "images/peers.svg"
        image.write_text((arguments.folder / "peers.svg").read_text())
    else:
        for name, lines in sections.items():
            print(f"\n{name}\n", *lines, sep="\n")


def write_csv(results: list[Measurements], path: Path) -> None:
    """Write one row per run."""
    rows = [asdict(result) for result in results]
    for row in rows:
        row |= {f"speed_{time}": speed for time, speed in row.pop("speeds").items()}
    names = list(dict.fromkeys(name for row in rows for name in row))
    with path.open("w", newline="") as file:
        writer = csv.DictWriter(file, names)
        writer.writeheader()
        writer.writerows(rows)


def task_table(results: list[Measurements]) -> list[str]:
    """Return the table of a task, as Markdown."""
    lines = [HEADER, "|---" * HEADER.count(" |") + "|"]
    for run in results:
        cells = [
            run.peer,
            number(run.steps_per_frame, "d"),
            number(run.ms_median, ".3g"),
            number(run.ms_90, ".3g"),
            number(run.setup_s, ".2g"),
            number(run.memory_mb, ".0f"),
            number(run.volume_error_stretched, "+.1e"),
            number(run.volume_error_rest, "+.1e"),
            number(run.shape_error_rest, ".2%"),
            *(number(run.speeds.get(time), ".1e") for time in SPEED_TIMES),
            number(run.depth_plane_m and 1e3 * run.depth_plane_m, ".1f"),
            number(run.depth_body_m and 1e3 * run.depth_body_m, ".1f"),
            run.failed.replace("|", "/") or "-",
        ]
        lines.append(f"| {' | '.join(cells)} |")
    return lines


def number(value: float | None, form: str) -> str:
    """Return a number as text, a dash if there is none."""
    return "-" if value is None else format(value, form)


def machine(results: list[Measurements]) -> str:
    """Return the programs that were measured, the date, the machine and the versions."""
    with open("/proc/cpuinfo") as file:
        names = [line.split(":")[1].strip() for line in file if line.startswith("model name")]
    commit = subprocess.run(
        ["git", "rev-parse", "--short", "HEAD"], cwd=HERE, capture_output=True, text=True, check=False
    ).stdout.strip()
    versions = sorted({f"{run.package} {run.version}" for run in results if run.package})
    load = os.getloadavg()[2]
    return (
        f"* {', '.join(sorted({run.peer for run in results}))}: {datetime.date.today()}; commit {commit or 'unknown'}; "
        f"Python {platform.python_version()}; {(names or [platform.processor()])[0]}, {os.cpu_count()} processors, "
        f"{platform.system()}; mean load over the 15 minutes before {load:.1f}; {', '.join(versions)}."
    )


def older_machines(page: str, kept: list[Measurements]) -> list[str]:
    """Return the lines of the page about programs of which rows are kept."""
    peers = {run.peer for run in kept}
    lines = []
    for line in section(page, "machine"):
        programs, rest = line.removeprefix("* ").split(": ", 1)
        remaining = [program for program in programs.split(", ") if program in peers]
        if remaining:
            lines.append(f"* {', '.join(remaining)}: {rest}")
    return lines


def kept_rows(page: str, results: list[Measurements]) -> list[Measurements]:
    """Return the rows of the page that have no result. A program with results has the settings of these."""
    new = {(run.peer, run.task) for run in results}
    texts = dict(line.removeprefix("* **").split("**: ", 1) for line in section(page, "settings"))
    texts |= {run.peer: run.settings for run in results if run.settings}
    rows = []
    for task in ORDER:
        for line in section(page, task)[2:]:
            peer, *cells = [cell.strip() for cell in line.strip("| ").split(" | ")]
            if (peer, task) not in new:
                rows.append(row_of(peer, task, texts.get(peer, ""), cells))
    return rows


def row_of(peer: str, task: str, settings: str, cells: list[str]) -> Measurements:
    """Return a row of a table, to the digits that it has."""
    *numbers, failed = cells

    def value(text: str, factor: float = 1.0) -> float | None:
        return None if text == "-" else factor * float(text)

    steps, median, slow, setup, memory, stretched, rest, shape, *speeds, plane, body = numbers
    found = {time: value(speed) for time, speed in zip(SPEED_TIMES, speeds, strict=True)}
    return Measurements(
        peer=peer,
        task=task,
        settings=settings,
        steps_per_frame=None if steps == "-" else int(steps),
        ms_median=value(median),
        ms_90=value(slow),
        setup_s=value(setup),
        memory_mb=value(memory),
        volume_error_stretched=value(stretched),
        volume_error_rest=value(rest),
        shape_error_rest=value(shape.rstrip("%"), 0.01),
        speeds={time: speed for time, speed in found.items() if speed is not None},
        depth_plane_m=value(plane, 1e-3),
        depth_body_m=value(body, 1e-3),
        failed="" if failed == "-" else failed,
    )


def section(page: str, name: str) -> list[str]:
    """Return the lines of a marked section of a page that are not empty."""
    return [line for line in around(page, name)[1].splitlines() if line]


def around(page: str, name: str) -> tuple[str, str, str]:
    """Return the text up to the mark that begins a section, the text in it, and the text from its end mark on."""
    begin, end = BEGIN.format(name), END.format(name)
    head, rest = page.split(begin, 1)
    inner, tail = rest.split(end, 1)
    return head + begin, inner, end + tail


def settings(results: list[Measurements]) -> list[str]:
    """Return the settings of each program."""
    texts = {run.peer: run.settings for run in results if run.settings}
    return [f"* **{peer}**: {text}" for peer, text in sorted(texts.items())]


def not_installed(path: Path) -> list[str]:
    """Return the packages that could not be installed, with the reasons."""
    lines = path.read_text().splitlines() if path.exists() else []
    return [f"* {line}" for line in lines] or ["All packages were installed."]


def read_page(path: Path) -> str:
    """Return the text of a page, if it has all marks."""
    page = path.read_text()
    for name in SECTIONS:
        begin, end = BEGIN.format(name), END.format(name)
        if end not in page.partition(begin)[2]:
            raise SystemExit(f"{path} lacks the lines {begin} and {end}")
    return page


def write_page(path: Path, sections: dict[str, list[str]]) -> None:
    """Replace the marked sections of a page."""
    page = read_page(path)
    for name, lines in sections.items():
        head, _, tail = around(page, name)
        page = "\n".join([head, "", *lines, "", tail])
    path.write_text(page)


def plot(results: list[Measurements], path: Path) -> None:
    """Plot the errors of the stretched boxes and busts against the time of a frame."""
    import matplotlib as mpl

    mpl.use("svg")
    mpl.rcParams["svg.hashsalt"] = "peers"
    import matplotlib.pyplot as plt

    runs = [run for run in results if run.task.startswith(("box", "bust")) and run.ms_median]
    figure, panels = plt.subplots(1, 2, figsize=(12, 5), layout="constrained")
    colors = {peer: f"C{index}" for index, peer in enumerate(sorted({run.peer for run in results}))}
    measures = (
        ("volume_error_stretched", "volume error at full stretch"),
        ("shape_error_rest", "shape error at rest, rms over size"),
    )
    for panel, (name, label) in zip(panels, measures, strict=True):
        for run in runs:
            error = getattr(run, name)
            if error is not None:
                marker = "s" if run.task.startswith("box") else "o"
                size = {1000: 30, 10_000: 80, 100_000: 200}[int(run.task.split("-")[1])]
                panel.scatter(run.ms_median, abs(error), size, colors[run.peer], marker=marker, alpha=0.7)
        panel.set(xscale="log", yscale="log", xlabel="ms a frame of 1/60 s, median", ylabel=label)
        panel.axvline(1000 / 60, color="0.7", linewidth=0.8)
        panel.grid(alpha=0.3)
    for peer, color in colors.items():
        panels[0].scatter([], [], 30, color, label=peer)
    panels[0].legend(fontsize=8)
    figure.suptitle("Squares: box, circles: bust; small, medium, large: 1,000, 10,000, 100,000 points; line: real time")
    figure.savefig(path, metadata={"Date": None})


if __name__ == "__main__":
    main()
