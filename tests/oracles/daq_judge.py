"""Compares what the sender makes NI-DAQmx cards play with the schedule.

The sender itself runs, on a stand-in for National Instruments' package that implements its documented calls. The samples written to
each task are then compared with the schedule one by one.
"""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

from verdict import demand

STAND_IN = Path(__file__).resolve().parent / "standins"


def played(program, arguments=()):
    """Runs a sender on the stand-in; returns its exit status, its output, and the log of all calls."""
    with tempfile.TemporaryDirectory() as folder:
        log = Path(folder) / "calls.json"
        environment = os.environ | {"PYTHONPATH": str(STAND_IN), "STANDIN_LOG": str(log)}
        run = subprocess.run(
            [sys.executable, str(program), *arguments], env=environment, capture_output=True, text=True, timeout=300, input="\n" * 99
        )
        calls = [json.loads(line) for line in log.read_text().splitlines()] if log.exists() else []
    return run.returncode, run.stdout + run.stderr, calls


def judge(path, schedule):
    program = path.with_suffix(".nidaqmx.py")
    status, words, calls = played(program)
    demand(status == 0, f"the sender ends with {status}: {words[-300:]}")
    counts = []
    for name, facts in schedule.instruments("data_acquisition").items():
        tasks = [call for call in calls if call["device"] == name and call["clock"]]
        demand(tasks and all(task["started"] and task["waited"] and task["closed"] for task in tasks), f"{name} was not played")
        first = min(tasks, key=lambda task: task["order"])
        demand(("start" in first) == (facts["start"] == "trigger"), f"{name} waits for another start")
        given, begins = {}, schedule.parts()
        for task in tasks:
            rate_hz, samples = task["clock"]["rate"], task["clock"]["samps_per_chan"]
            limit = facts["digital_rate_hz"] if task["kind"] == "do" else facts["voltage"]["rate_hz"]
            demand(rate_hz <= limit, f"{name} plays {rate_hz} samples in a second")
            for output, levels in zip(task["channels"], task["levels"], strict=True):
                demand(len(levels) == samples, f"{output} has {len(levels)} samples, not {samples}")
                given.setdefault(output.removeprefix(f"{name}/").replace("/", "."), []).append((1e9 / rate_hz, levels))
        demand(all(len(all_parts) == len(begins) for all_parts in given.values()), f"{name} does not play {len(begins)} parts")
        drives = schedule.drives(name).items()
        counts += [compare(schedule, channel, link, *part, times) for channel, (output, link) in drives for part, times in zip(given[output], begins)]
        demand(len(given) == len(schedule.drives(name)), f"{name} drives more than is wired")
        rest = {output: level for call in calls if call["device"] == name and not call["clock"] for output, level in call["rest"].items()}
        for channel, (output, link) in schedule.drives(name).items():
            level = rest.get(f"{name}/{output.replace('.', '/')}")
            if schedule.is_stage(channel):
                demand(level is None, f"{output} is set to {level} V at once, and its stage with it")
            else:
                demand(level is not None and abs(level - schedule.output_v(link, schedule.rests_v[channel])) < 1e-9, f"{output} rests at {level}")
    return f"{sum(counts)} samples are the schedule, as the sender gave them to the driver"


def compare(schedule, channel, link, period, levels, times):
    begin, end = times
    period_ns = round(period)
    demand(abs(period - period_ns) < 1e-6 * period_ns, f"a sample lasts {period} ns")
    if not schedule.is_stage(channel):
        inner = [edge for edge in schedule.edges(channel) if begin <= edge <= end]
        demand(all((edge - begin) % period_ns == 0 for edge in inner), f"{channel} has an edge between samples")
    demand(begin + len(levels) * period_ns >= end, f"{channel} ends too early")
    for index, level in enumerate(levels):
        # Samples past the end of a part repeat the value that the wait there holds.
        value = schedule.value(channel, min(begin + index * period_ns, end))
        expected = schedule.output_v(link, value)
        demand(abs(level - expected) < 1e-9, f"{channel} is at {level} at {index * period_ns} ns, not {expected}")
    return len(levels)
