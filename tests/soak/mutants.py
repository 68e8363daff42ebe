"""Changed bytes and words of shipped scenes and models."""

from __future__ import annotations

import re
from collections.abc import Callable

import numpy as np

from . import scenes
from .context import Case, Check, Settings
from .outcome import run_or_refuse

#: Words of both languages, and numbers at the limits of types.
WORDS = [
    *[b"0", b"-1", b"1e999", b"-1e-999", b"nan", b"inf", b"1e38", b"3.5e38", b"1e308", b"4294967296"],
    *[b"9223372036854775807", b"-9223372036854775808", b"0x7f", b"1_0", b"\xff\xfe", b"\x00", b"\xe2\x80\xa8"],
    *[b"v", b"vn", b"vt", b"f", b"g", b"o", b"mtllib", b"usemtl", b"\\\n", b"#", b"1/1/1", b"1//1", b"-1//-1"],
    *[b"[", b"]", b"{", b"}", b"[[body]]", b"[[collider]]", b"[[body.pin]]", b"=", b'"', b"'''", b"true", b"\r", b","],
]

#: A word, a number or a sign.
_TOKEN = re.compile(rb"[A-Za-z_]+|-?[0-9][0-9.eE+-]*|[^\s]")


def check(settings: Settings) -> Check:
    """Change files."""
    result = Check("bytes", settings)
    corpus = [path for path in sorted(scenes.SHIPPED.iterdir()) if path.suffix in (".obj", ".toml")]
    corpus += sorted((scenes.ROOT / "tests" / "data").glob("*.obj"))
    texts = [path.read_bytes() for path in corpus]

    def case(case: Case) -> None:
        scenes.link_shipped(case.folder)
        # Scenes and models take turns, because a scene is short and has more keys than a model has statements.
        suffix = (".obj", ".toml")[case.index % 2]
        index = int(case.random.choice([i for i, path in enumerate(corpus) if path.suffix == suffix]))
        text = texts[index]
        names = []
        for _ in range(1 << case.random.integers(0, 4)):
            mutation = MUTATIONS[case.random.integers(len(MUTATIONS))]
            text = mutation(text, texts[case.random.integers(len(texts))], case.random)
            names.append(mutation.__name__.strip("_"))
        case.label = f"{case.index} ({corpus[index].name}: {', '.join(names)})"
        (case.folder / f"mutant{suffix}").write_bytes(text)
        run_or_refuse(case, f"mutant{suffix}")

    result.cases(settings.count(2000, 20), case)
    return result


def _at(text: bytes, random: np.random.Generator) -> int:
    return int(random.integers(len(text) + 1))


def _flip(text: bytes, _other: bytes, random: np.random.Generator) -> bytes:
    if not text:
        return text
    changed = bytearray(text)
    changed[random.integers(len(text))] ^= 1 << int(random.integers(8))
    return bytes(changed)


def _delete(text: bytes, _other: bytes, random: np.random.Generator) -> bytes:
    at = _at(text, random)
    return text[:at] + text[at + int(random.geometric(0.2)) :]


def _insert(text: bytes, _other: bytes, random: np.random.Generator) -> bytes:
    at = _at(text, random)
    return text[:at] + random.bytes(int(random.geometric(0.3))) + text[at:]


def _duplicate(text: bytes, _other: bytes, random: np.random.Generator) -> bytes:
    lines = text.splitlines(keepends=True)
    if not lines:
        return text
    first = int(random.integers(len(lines)))
    copied = lines[first : first + int(random.geometric(0.1))]
    at = int(random.integers(len(lines) + 1))
    return b"".join(lines[:at] + copied + lines[at:])


def _truncate(text: bytes, _other: bytes, random: np.random.Generator) -> bytes:
    return text[: _at(text, random)]


def _word(text: bytes, _other: bytes, random: np.random.Generator) -> bytes:
    """Replace a word by a word of the languages."""
    return _replace(text, WORDS[random.integers(len(WORDS))], random)


def _splice(text: bytes, other: bytes, random: np.random.Generator) -> bytes:
    """Replace a word by words of another file."""
    start = _at(other, random)
    found = _TOKEN.findall(other[start : start + 200])
    return _replace(text, b" ".join(found[: random.geometric(0.4)]), random)


def _digits(text: bytes, _other: bytes, random: np.random.Generator) -> bytes:
    """Change one of the numbers after a random place."""
    at = _at(text, random)
    match = re.compile(rb"-?[0-9]+(\.[0-9]+)?").search(text, at)
    if match is None:
        return text
    number = random.choice([b"0", b"-0.0", b"1e-30", b"1e30", b"-7", b"2.5", b"100000", match.group() * 2])
    return text[: match.start()] + bytes(number) + text[match.end() :]


def _replace(text: bytes, word: bytes, random: np.random.Generator) -> bytes:
    match = _TOKEN.search(text, _at(text, random))
    if match is None:
        return text + word
    return text[: match.start()] + word + text[match.end() :]


MUTATIONS: list[Callable[[bytes, bytes, np.random.Generator], bytes]] = [
    *[_flip, _delete, _insert, _duplicate, _truncate, _word, _splice, _digits]
]
