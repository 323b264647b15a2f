"""Compares what stage controllers do with the positions of a schedule with the schedule.

The sender itself runs, on PI controllers simulated after their manual and on a stand-in for SmarAct's package. The commanded position of
each stage at each tick of the controller's own clock is then compared with the schedule.
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from gcs_controller import SERVO_CYCLE_S, GcsController
from verdict import demand

STAND_IN = Path(__file__).resolve().parent / "standins"
AT_ONCE, BY_TRIGGER = 1, 2
PM_OF_UM = 1_000_000


def run(program, arguments, **environment):
    """Runs a sender on the stand-in; returns its exit status, its output, and the log of all calls."""
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "calls.jsonl"
        environment = os.environ | {"PYTHONPATH": str(STAND_IN), "STANDIN_LOG": str(log)} | environment
        ended = subprocess.run(
            [sys.executable, str(program), *arguments], env=environment, capture_output=True, text=True, timeout=300, input="\n" * 99
        )
        calls = [json.loads(line) for line in log.read_text().splitlines()] if log.exists() else []
    return ended.returncode, ended.stdout + ended.stderr, calls


def judge(path, schedule):
    program = path if path.name.endswith(".stages.py") else path.with_suffix(".stages.py")
    known = schedule.instruments("stage_controller")
    boards = {name: GcsController(facts["axes"]) for name, facts in known.items() if facts["protocol"] == "gcs"}
    addresses = [f"{name}={boards[name].address if name in boards else 'network:sn:MCS2-1'}" for name in known]
    status, words, calls = run(program, addresses)
    demand(status == 0 and "stages hold where they are" in words, f"the sender ends with {status}: {words[-300:]}")
    counts, parts = [], schedule.parts()
    several = len(schedule.document["bench"]["instruments"]) > 1
    for name, facts in known.items():
        if name in boards:
            played = of_gcs(boards[name], facts, several)
            period_s = SERVO_CYCLE_S
        else:
            played = of_mcs2(calls)
            period_s = 1 / facts["rate_hz"]
        demand(len(played) == len(parts), f"{name} plays {len(played)} parts, not {len(parts)}")
        drives = schedule.drives(name).items()
        for axes, times in zip(played, parts):
            demand(len(axes) == len(drives), f"{name} moves {len(axes)} axes")
            for channel, (output, link) in drives:
                counts.append(compare(schedule, channel, link["axis"], axes[output.removeprefix("axis")], period_s * 1e9, times))
    return f"{sum(counts)} places are the schedule, as the controllers were told them"


def of_gcs(board, facts, several):
    """The positions of each axis in each part, in um; checks that the controller starts together with the others."""
    follows = facts["start"] == "trigger"
    demand(all(mode == (BY_TRIGGER if follows else AT_ONCE) for mode, _ in board.played), "it begins by another start")
    demand(board.pulse == ([("1", "1", "1")] if several and not follows else []), f"its pulse is {board.pulse}")
    demand(board.stops == 1 and all(board.servo[axis] for _, axes in board.played for axis in axes), "it is left without its servo")
    return [axes for _, axes in board.played]


def of_mcs2(calls):
    """The positions of each axis in each part, in um."""
    played = []
    for call in calls:
        if call[0] == "OpenStream":
            demand(call[1] == "DIRECT", f"a stream begins by {call[1]}")
            played.append({})
        elif call[0] == "StreamFrame":
            for channel, place in zip(call[1::2], call[2::2]):
                played[-1].setdefault(str(channel + 1), []).append(place / PM_OF_UM)
    demand([call[0] for call in calls].count("CloseStream") == len(played), "a stream was not closed")
    return played


def compare(schedule, channel, axis, places, period_ns, times):
    begin, end = times
    sign = {"forward": 1, "backward": -1}[axis["direction"]]
    # A table point lasts up to two servo cycles here; a position may be off by half of what the stage, at its fastest, moves in that time.
    bound_um = schedule.fastest(channel) * period_ns + 2e-6
    demand(begin + len(places) * period_ns >= end - 1, f"{channel} ends too early")
    demand(begin + (len(places) - 2) * period_ns <= end + period_ns, f"{channel} goes on after the end")
    for index, place in enumerate(places):
        demand(axis["least_um"] <= place <= axis["most_um"], f"{channel} leaves its travel")
        value = schedule.value(channel, min(round(begin + index * period_ns), end))
        expected = axis["origin_um"] + sign * value
        demand(abs(place - expected) <= bound_um, f"{channel} is at {place} um at {index * period_ns} ns, not at {expected} um")
    return len(places)
