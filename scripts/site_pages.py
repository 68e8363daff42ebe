"""Copies the pages of the docs, and the files that they link to, into the source folder of the site.

    python scripts/site_pages.py FOLDER

Begins at README.md and the pages of docs/ and follows all relative links. Pages and pictures keep their paths, so that
links between them stay as they are. Another text file becomes a page that shows it, and a folder a page that lists its
files; links to them are changed. A link to a file that does not exist, or that git ignores, is an error.
"""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path, PurePosixPath

ROOT = Path(__file__).resolve().parents[1]
COPIED = {".png", ".svg", ".webp", ".css"}
LANGUAGES = {".py": "python", ".rs": "rust", ".toml": "toml", ".sh": "sh"}
LINK = re.compile(r"(?<=\]\()([^)#:\s]+)(#[^)\s]*)?(?=\))")
CODE = re.compile(r"^```.*?^```|`[^`\n]+`", re.MULTILINE | re.DOTALL)
LARGEST = 100_000
"""Size in bytes above which a file is named, and not shown."""


def main(folder: Path) -> None:
    """Write the source of the site to a folder."""
    listed = subprocess.run(["git", "ls-files", "-co", "--exclude-standard"], cwd=ROOT, capture_output=True, check=True)
    known = {PurePosixPath(line) for line in listed.stdout.decode().splitlines() if (ROOT / line).is_file()}
    pages = sorted(path for path in known if path.suffix == ".md" and PurePosixPath("docs") in path.parents)
    waiting = [PurePosixPath("README.md"), PurePosixPath("docs/site.css"), *pages]
    written = set(waiting)
    while waiting:
        path = waiting.pop()
        for linked in write(path, known, folder):
            if linked not in written:
                written.add(linked)
                waiting.append(linked)
    print(f"{len(written)} files in {folder}")


def write(path: PurePosixPath, known: set[PurePosixPath], folder: Path) -> set[PurePosixPath]:
    """Write the file or folder of the repository to the source of the site, and return what it links to."""
    source, target = ROOT / path, folder / path
    target.parent.mkdir(parents=True, exist_ok=True)
    linked: set[PurePosixPath] = set()
    if source.is_dir():
        inside = sorted(file for file in known if path in file.parents)
        rows = [f"* [{file.relative_to(path)}]({file.relative_to(path.parent)})" for file in inside]
        text = f"# {path}\n\n" + "\n".join(rows) + "\n"
        page_of(target).write_text(with_links(text, path, known, linked), encoding="utf-8")
    elif path.suffix in COPIED:
        shutil.copyfile(source, target)
    elif path.suffix == ".md":
        text = nested_lists(source.read_text(encoding="utf-8"))
        target.write_text(with_links(text, path, known, linked), encoding="utf-8")
    else:
        page_of(target).write_text(shown(source, path), encoding="utf-8")
    return linked


def with_links(text: str, page: PurePosixPath, known: set[PurePosixPath], linked: set[PurePosixPath]) -> str:
    """Return the text of a page with links to the pages of the site, and add what they name to `linked`."""

    def change(match: re.Match[str]) -> str:
        target = normal(page.parent / match[1])
        if target not in known and (ROOT / target).is_dir() and any(target in file.parents for file in known):
            readme = target / "README.md"
            target, name = (readme, f"{match[1].rstrip('/')}/README.md") if readme in known else (target, match[1])
        elif target in known:
            name = match[1]
        else:
            raise SystemExit(f"{page} links to {match[1]}, which does not exist or is ignored by git")
        linked.add(target)
        if target.suffix not in {*COPIED, ".md"}:
            name = f"{name.rstrip('/')}.md"
        return name + (match[2] or "")

    pieces = CODE.split(text)
    codes = [*CODE.findall(text), ""]
    return "".join(LINK.sub(change, piece) + code for piece, code in zip(pieces, codes, strict=True))


def normal(path: PurePosixPath) -> PurePosixPath:
    """Return a path without `..`."""
    parts: list[str] = []
    for part in path.parts:
        if part == "..":
            parts.pop()
        else:
            parts.append(part)
    return PurePosixPath(*parts)


def nested_lists(text: str) -> str:
    """Return a page whose nested lists are indented by four columns per level, which the site needs, and not by two."""
    pieces = re.split(r"(^```.*?^```)", text, flags=re.MULTILINE | re.DOTALL)
    for index, piece in enumerate(pieces):
        if not piece.startswith("```"):
            pieces[index] = re.sub(r"^  (?=[*-] )", "    ", piece, flags=re.MULTILINE)
    return "".join(pieces)


def page_of(path: Path) -> Path:
    """Return the path of the page that shows a file."""
    return path.with_name(f"{path.name}.md")


def shown(source: Path, path: PurePosixPath) -> str:
    """Return a page that shows a file."""
    size = source.stat().st_size
    if size > LARGEST:
        return f"# {path}\n\nThis file has {size / 1000:.0f} kB; it is in the repository.\n"
    text = source.read_text(encoding="utf-8")
    fence = "`" * max([4, *(len(run) + 1 for run in re.findall("`+", text))])
    return f"# {path}\n\n{fence}{LANGUAGES.get(source.suffix, 'text')}\n{text.rstrip()}\n{fence}\n"


if __name__ == "__main__":
    main(Path(sys.argv[1]))
