"""Random calls of the Python module, in child processes."""

from __future__ import annotations

import re
import sys

from .context import Case, Check, FaultError, Settings
from .process import run

#: Calls of one child process.
CALLS = 500


def check(settings: Settings) -> Check:
    """Make calls."""
    result = Check("calls", settings)
    calls = settings.count(CALLS, 150)

    def case(case: Case) -> None:
        seed = int(case.random.integers(2**32))
        command = [sys.executable, "-m", "soak.caller", str(seed), str(calls)]
        case.commands.append(command)
        ended = run(command, case.folder)
        made = len(re.findall(r"^\d+ \w+$", ended.output, re.MULTILINE))
        result.count(ended, made)
        faults = re.findall(r"^FAULT: (.*)", ended.output, re.MULTILINE)
        if faults:
            raise FaultError(f"seed {seed}: {len(faults)} faults: {faults[0][:600]}")
        if ended.code != 0 or made != calls:
            raise FaultError(f"seed {seed}: ends with code {ended.code} in call {made}: {ended.output[-2000:]}")

    result.cases(settings.count(60, 2), case)
    return result
