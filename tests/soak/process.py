"""Runs a program once and measures it."""

from __future__ import annotations

import os
import re
import resource
import signal
import subprocess
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

#: Wall time in seconds after which a run counts as hanging and is killed. Three times the limit of the processor
#: time, because other processes can delay a run.
HANG = 30.0

#: Address space of a run in bytes. Protects the machine; the limits of the checks are lower.
ADDRESS_SPACE = 8 << 30

#: Time between two looks at a running process, in seconds.
POLL = 0.002

#: Largest error in KiB of the counters of resident memory, which the kernel updates in batches.
COUNTER_ERROR = 16 << 10


@dataclass(frozen=True)
class Ended:
    """A run that has ended."""

    #: Exit code, or minus the number of the signal that ended the run.
    code: int
    #: Wall time and processor time in seconds.
    wall: float
    processor: float
    #: Peak of the resident memory in bytes; 0 if it is unknown, because it is below that of this process and the run
    #: ended within milliseconds.
    memory: int
    #: Standard output and standard error.
    output: str
    #: Whether the run was killed because it was still running after `HANG` seconds, or at the time asked for.
    hangs: bool
    killed: bool

    @property
    def last_line(self) -> str:
        """The last line of the output that is not empty, shortened."""
        lines = [line for line in self.output.splitlines() if line.strip()]
        return lines[-1][:300] if lines else "(no output)"


def run(command: Sequence[str | Path], folder: Path, kill_after: float | None = None) -> Ended:
    """Run a command in a folder. `kill_after`: seconds after which it is ended by SIGKILL."""
    # A file in place of a pipe, so that no output blocks the program.
    log = folder / ".log"
    with log.open("wb") as stream:
        start = time.monotonic()
        process = subprocess.Popen(
            list(map(str, command)), cwd=folder, stdin=subprocess.DEVNULL, stdout=stream, stderr=subprocess.STDOUT
        )
        resource.prlimit(process.pid, resource.RLIMIT_AS, (ADDRESS_SPACE, ADDRESS_SPACE))
        hangs = asked = False
        seen = 0
        while True:
            pid, status, usage = os.wait4(process.pid, os.WNOHANG)
            passed = time.monotonic() - start
            if pid:
                break
            seen = _peak_memory(process.pid) or seen
            hangs = passed > HANG
            asked = kill_after is not None and passed >= kill_after
            if hangs or asked:
                # Not `process.kill`, which waits for a process that has just ended, and takes its figures.
                os.kill(process.pid, signal.SIGKILL)
            time.sleep(POLL)
    process.returncode = os.waitstatus_to_exitcode(status)
    killed = asked and process.returncode == -signal.SIGKILL
    output = log.read_text(errors="replace")
    log.unlink()
    processor = usage.ru_utime + usage.ru_stime
    # `ru_maxrss` is at least the peak of this process, from which the run is forked, up to errors of the counters.
    own = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss + COUNTER_ERROR
    memory = usage.ru_maxrss if usage.ru_maxrss > own else seen
    return Ended(process.returncode, passed, processor, memory << 10, output, hangs, killed)


def _peak_memory(pid: int) -> int:
    """Return the peak of the resident memory of a running process in KiB, or 0 if it is unknown."""
    try:
        status = Path(f"/proc/{pid}/status").read_text()
    except OSError:
        return 0
    match = re.search(r"^VmHWM:\s*(\d+) kB", status, re.MULTILINE)
    return int(match.group(1)) if match else 0
