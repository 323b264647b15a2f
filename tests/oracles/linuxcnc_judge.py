"""G-code as LinuxCNC's own interpreter reads it: the target of each axis, and the duration of each line from the derived feed.

The interpreter is the module `gcode` of the package linuxcnc-uspace, which `.ci/run` unpacks into the folder `linuxcnc` beside the judges'
Python; the package itself, with its desktop, is not installed.
"""

import json
import math
import os
import re
import subprocess
import sys
from pathlib import Path

import numpy

from gcode_judge import compare, machine_of, of_channel
from verdict import Skipped, demand

FOLDER = Path(os.environ.get("TWEEZE_LINUXCNC", Path(sys.prefix) / "linuxcnc"))
READER = Path(__file__).resolve().parent / "linuxcnc_reader.py"
# Axes in the order of the interpreter's arguments. Lengths are in inches there, but A, B and C are in degrees.
AXES = "XYZABCUVW"
MM_OF_INCH = 25.4
# Rounding error that a program's lines may accumulate, because their feeds are doubles.
DRIFT_NS = 50.0


def calls(program):
    """The calls that the interpreter makes for a program, each as name and arguments."""
    if not any(FOLDER.glob("usr/lib/python3/dist-packages/gcode.*.so")):
        raise Skipped(f"LinuxCNC's interpreter is not in {FOLDER}")
    libraries = [str(FOLDER / "usr/lib"), *map(str, FOLDER.glob("usr/lib/*-linux-gnu"))]
    environment = os.environ | {"LD_LIBRARY_PATH": ":".join(libraries)}
    run = subprocess.run([sys.executable, READER, FOLDER, program], env=environment, capture_output=True, text=True, timeout=300)
    demand(run.returncode == 0, f"the interpreter ends with {run.returncode}: {run.stderr[-300:]}")
    read = json.loads(run.stdout)
    demand(read["error"] is None, f"line {read['line']}: {read['error']}")
    return read["calls"]


def in_mm(places):
    return {axis: place if axis in "ABC" else place * MM_OF_INCH for axis, place in zip(AXES, places)}


def line_ns(before, after, feed):
    """Duration of a straight line. The feed applies to the first group of axes that moves, and is in inches even for A, B and C."""
    ways = {axis: after[axis] - before[axis] for axis in AXES}
    lengths = [math.hypot(*(ways[axis] for axis in group)) for group in ("XYZ", "UVW", "ABC")]
    moving = [index for index, length in enumerate(lengths) if length > 0]
    demand(moving, "a line that moves nothing")
    return lengths[moving[0]] / (feed * MM_OF_INCH) * 60e9


def played(program):
    """Returns the instants at which lines end, in ns, and the positions of all axes at them, in millimetres (A, B and C as read)."""
    at, t_ns, feed, times, places = None, 0.0, None, [], []
    for name, *arguments in calls(program):
        match name:
            case "straight_traverse":
                demand(at is None, "it goes somewhere at its own speed, later than at the beginning")
                at = in_mm(arguments)
            case "set_feed_rate":
                (feed,) = arguments
                continue
            case "straight_feed":
                after = in_mm(arguments)
                t_ns += line_ns(at, after, feed)
                at = after
            case "dwell":
                t_ns += arguments[0] * 1e9
            case _:
                # Offsets, comments and tool calls move nothing.
                continue
        times.append(t_ns)
        places.append(at)
    return times, places


def judge(path, schedule):
    if schedule.document.get("holds"):
        return "it waits for inputs or people, which this interpreter passes by"
    files, moves = sorted(path.parent.glob(f"{path.stem}.*{path.suffix}")), 0
    for file in files:
        axes = dict(re.findall(r"^; ([A-Z]) is ([^\s,]+)", file.read_text(encoding="ascii"), re.MULTILINE))
        times, places = played(file)
        demand(abs(times[-1] - schedule.duration_ns) <= DRIFT_NS, f"it lasts {times[-1]} ns, not {schedule.duration_ns} ns")
        machine = machine_of(file, path, axes, schedule)
        for axis, channel in axes.items():
            places_um = of_channel(numpy.array([1000 * place[axis] for place in places]), machine, axis, channel, schedule)
            compare(numpy.array(times), places_um, channel, schedule)
        moves += len(times)
    return f"{moves} places of {len(schedule.channels)} axes are the schedule for LinuxCNC's interpreter, which takes its time for them"
