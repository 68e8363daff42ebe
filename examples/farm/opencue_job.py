"""A job of OpenCue: one layer with a task per material. See docs/farms.md.

python opencue_job.py ../scenes/drop.toml frames
"""

import os
import sys

import outline
import outline.cuerun
from outline.modules.shell import ShellSequence

MATERIALS = ["jelly", "flesh", "rubber"]


def command(scene: str, output: str, material: str) -> list[str]:
    """Return the command of a task. All frames of a run are one task, because each one starts from the one before."""
    output = os.path.abspath(os.path.join(output, material))
    scene_of_material = [os.path.abspath(scene), "--set", f"body.bust.material={material}"]
    return ["supple", "run", *scene_of_material, "--output", output, "--resume=auto", "--progress", "openjd"]


def main(scene: str, output: str) -> None:
    """Submit the job."""
    job = outline.Outline("supple", shot="shot", show="testing", user=os.environ.get("USER", "user"))
    commands = [command(scene, output, material) for material in MATERIALS]
    job.add_layer(ShellSequence("simulate", commands=commands, threads=2, memory="1g"))
    outline.cuerun.launch(job, use_pycuerun=False)


if __name__ == "__main__":
    main(*sys.argv[1:])
