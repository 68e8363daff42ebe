"""The Python programs in the README and the docs run, and relative links resolve."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

import supple

ROOT = Path(__file__).parents[2]
PAGES = [page for page in sorted([ROOT / "README.md", *ROOT.glob("docs/**/*.md")]) if "```python" in page.read_text()]


def _program(page):
    """Returns the code blocks of a page as one program, each at its line in the page."""
    text = page.read_text()
    lines = [""] * (text.count("\n") + 1)
    for block in re.finditer(r"^```python\n(.*?)^```", text, re.MULTILINE | re.DOTALL):
        first = text[: block.start(1)].count("\n")
        code = block.group(1).splitlines()
        lines[first : first + len(code)] = code
    return "\n".join(lines)


def test_pages_with_programs_are_found():
    assert {page.name for page in PAGES} >= {"README.md", "python.md", "control.md", "runs.md", "display.md"}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_the_programs_of_a_page_run(page, tmp_path, monkeypatch, request):
    program = _program(page)
    if "matplotlib" in program:
        pytest.importorskip("matplotlib")
    if "polyscope" in program:
        request.getfixturevalue("polyscope")
    shutil.copytree(ROOT / "examples" / "scenes", tmp_path / "examples" / "scenes")
    monkeypatch.chdir(tmp_path)
    exec(compile(program, page, "exec"), {"__name__": "__main__"})


@pytest.mark.filterwarnings("ignore::supple.MaterialWarning")
def test_the_scenes_of_a_page_are_valid_but_for_files_and_names(tmp_path, monkeypatch):
    """Keys and values are right. A page may show a part of a scene, with files and bodies that are not there."""
    shutil.copytree(ROOT / "examples" / "scenes", tmp_path / "scenes")
    monkeypatch.chdir(tmp_path / "scenes")
    elsewhere = "cannot be read|No such file|selects nothing|has no map|no body has this name"
    read = 0
    for page in sorted([ROOT / "README.md", *ROOT.glob("docs/**/*.md")]):
        for block in re.findall(r"^```toml\n(.*?)^```", page.read_text(), re.MULTILINE | re.DOTALL):
            if "[dependencies]" in block:
                continue
            head = "" if "[simulation]" in block else "[simulation]\nframes = 2\n"
            head += "" if "[[body]]" in block else '[[body]]\nname = "one"\nmesh = "bust.obj"\n'
            scene = Path(f"{page.stem}.toml")  # errors name it
            scene.write_text(head + block)
            try:
                supple.load_scene(scene)
                read += 1
            except (supple.SceneError, FileNotFoundError) as error:
                if not re.search(elsewhere, str(error)):
                    raise
    assert read >= 10


@pytest.mark.skipif(shutil.which("git") is None, reason="needs git")
def test_the_stage_of_the_contributing_page_can_be_added():
    diff = re.search(r"^```diff\n(.*?)^```", (ROOT / "CONTRIBUTING.md").read_text(), re.MULTILINE | re.DOTALL).group(1)
    assert diff.count("diff --git") == 4, "its file, the list, one setting, its key in scenes"
    subprocess.run(["git", "apply", "--check"], input=diff, text=True, cwd=ROOT, check=True)


def test_relative_links_resolve():
    for page in [*ROOT.glob("*.md"), *ROOT.glob("docs/**/*.md"), *ROOT.glob("examples/**/*.md")]:
        for target in re.findall(r"\]\(([^)#:\s]+)[^):]*\)", page.read_text()):
            assert (page.parent / target).exists(), f"{page.name}: {target}"
