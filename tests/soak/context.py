"""What all checks share: settings, folders of the cases, faults, and the figures of the table."""

from __future__ import annotations

import shlex
import shutil
import threading
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from .process import Ended, run

#: Limits of a run: processor time in seconds (of one thread, so that other processes do not delay it), and memory in
#: bytes without the input.
TIME_LIMIT = 10.0
MEMORY_LIMIT = 1 << 30

#: Number of runs at the same time. Each run has one thread.
WORKERS = 2


class FaultError(Exception):
    """A fault of the program. The message says how the run differs from a right one."""


@dataclass(frozen=True)
class Settings:
    """The arguments of the command line."""

    program: Path
    output: Path
    seed: int
    quick: bool

    def count(self, full: int, quick: int) -> int:
        """Return the number of cases of a check."""
        return quick if self.quick else full


@dataclass
class Check:
    """A check: its runs, their worst figures, and its faults."""

    name: str
    settings: Settings
    runs: int = 0
    faults: list[str] = field(default_factory=list)
    wall: float = 0.0
    processor: float = 0.0
    memory: int = 0
    lock: threading.Lock = field(default_factory=threading.Lock)

    def folder(self, name: str) -> Path:
        """Return a new empty folder."""
        folder = self.settings.output / "work" / self.name / name
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        return folder

    def random(self, *key: int) -> np.random.Generator:
        """Return the random numbers of a case, which depend only on the seed, the check and the key."""
        return np.random.default_rng([self.settings.seed, *self.name.encode(), *key])

    def count(self, ended: Ended, runs: int = 1) -> None:
        """Count a process, and the runs in it, in the table."""
        with self.lock:
            self.runs += runs
            self.wall = max(self.wall, ended.wall)
            self.processor = max(self.processor, ended.processor)
            self.memory = max(self.memory, ended.memory)

    def cases(self, count: int, case: Callable[[Case], None]) -> None:
        """Run cases 0 to `count - 1`, some at the same time, and keep the folders of those with a fault."""
        with ThreadPoolExecutor(WORKERS) as pool:
            list(pool.map(lambda index: Case(self, index).run(case), range(count)))


class Case:
    """A case of a check, with a folder for its files."""

    def __init__(self, check: Check, index: int) -> None:
        self.check = check
        self.index = index
        self.label = str(index)
        self.random = check.random(index)
        self.folder = check.folder(str(index))
        self.commands: list[Sequence[str | Path]] = []

    def run(self, case: Callable[[Case], None]) -> None:
        """Run the case. Removes its folder, or moves it to the faults."""
        try:
            case(self)
        except FaultError as fault:
            self.keep(str(fault))
        else:
            shutil.rmtree(self.folder)

    def supple(self, *arguments: str | Path, kill_after: float | None = None) -> Ended:
        """Run the program in the folder. A signal, a panic, or a run over the limits is a fault."""
        command = [self.check.settings.program, *arguments]
        self.commands.append(command)
        ended = run(command, self.folder, kill_after)
        self.check.count(ended)
        if ended.hangs:
            raise FaultError(f"still running after {ended.wall:.0f} s")
        if "panicked" in ended.output:
            raise FaultError(f"panic: {ended.output.strip()[:300]}")
        if ended.code < 0 and not ended.killed:
            raise FaultError(f"ended by signal {-ended.code}: {ended.last_line}")
        return ended

    def keep(self, message: str) -> None:
        """Move the folder to the faults, with a program that repeats the runs."""
        kept = self.check.settings.output / "faults" / f"{self.check.name}_{self.index}"
        shutil.rmtree(kept, ignore_errors=True)
        kept.parent.mkdir(parents=True, exist_ok=True)
        lines = ["#!/bin/sh", *(f"# {line}" for line in message.splitlines()), 'cd "$(dirname "$0")"']
        lines += [" ".join(shlex.quote(str(word)) for word in command) for command in self.commands]
        (self.folder / "command").write_text("\n".join(lines) + "\n")
        (self.folder / "command").chmod(0o755)
        self.folder.rename(kept)
        text = f"{self.check.name} {self.label}: {message}\n    {kept / 'command'}"
        with self.check.lock:
            self.check.faults.append(text)
        print(f"FAULT  {text}", flush=True)


def check_limits(ended: Ended, input_bytes: int = 0) -> None:
    """Raise a fault if a run took too much processor time, or too much memory besides its input."""
    if ended.processor > TIME_LIMIT:
        raise FaultError(
            f"{ended.processor:.1f} s of processor time, not at most {TIME_LIMIT:.0f} s: {ended.last_line}"
        )
    if ended.memory - input_bytes > MEMORY_LIMIT:
        raise FaultError(f"{ended.memory / 1e6:.0f} MB of memory for an input of {input_bytes / 1e6:.0f} MB")
