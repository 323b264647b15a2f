"""The SPICE deck, run by ngspice; its node voltages are compared with the schedule."""

import re
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy

from verdict import Skipped, demand

TOLERANCE_V = 1e-9
# Window around an edge in which voltages are not compared: sources take 1 ns to change, and printed times have 12 digits.
BEFORE_NS, AFTER_NS = 0.5, 1.5
# Number of edges after which the deck may stop early, because ngspice computes some thirty points for each.
MANY_EDGES = 20_000
# Bound on edges times sources, because ngspice evaluates every source at each point.
MUCH_WORK = 5_000_000


def judge(path, schedule):
    ngspice = shutil.which("ngspice")
    if not ngspice:
        raise Skipped("ngspice is not installed")
    sources = path.with_suffix(".pwl.inc")
    with tempfile.TemporaryDirectory() as folder:
        for file in (path, sources):
            shutil.copy(file, folder)
        run = subprocess.run([ngspice, "-b", path.name], cwd=folder, capture_output=True, text=True, timeout=600)
        output = Path(folder) / f"{path.stem}.ngspice.txt"
        demand(run.returncode == 0, f"ngspice ends with status {run.returncode}: {run.stderr[-500:]}")
        demand(output.exists(), f"ngspice wrote no data: {run.stderr[-500:]}")
        with open(output, encoding="ascii") as file:
            header = file.readline().lower().split()
        table = numpy.loadtxt(output, skiprows=1, ndmin=2)
    return compare(header, table, nodes(sources), stop_ns(path, schedule), schedule)


def nodes(sources):
    """The node of each channel, from the comments in the sources."""
    pattern = r"^\* (\S+) (?:\[V\]|\[um\], 1 V stands for 1 um).*\nV(\S+) (\S+) \S+ PWL\($"
    return {name: node.lower() for name, _, node in re.findall(pattern, sources.read_text(), re.MULTILINE)}


def stop_ns(deck, schedule):
    """The instant at which the deck stops: the end of the schedule, or earlier if there are very many edges."""
    stop = re.search(r"^\.tran \S+ (\S+)$", deck.read_text(), re.MULTILINE)
    stop = min(round(float(stop[1]) * 1e9), schedule.duration_ns)
    passed = sum(edge <= stop for channel in schedule.channels for edge in schedule.edges(channel))
    trains = sum(half is not None for pulses in schedule.pulses.values() for *_, half in pulses)
    many = min(MANY_EDGES, MUCH_WORK // (len(schedule.channels) + trains))
    demand(stop == schedule.duration_ns or passed >= many, f"it stops at {stop} ns, after {passed} edges")
    return stop


def compare(header, table, node_of, stop, schedule):
    demand(header[0] == "time", f"the first column is {header[0]}")
    demand(list(node_of) == schedule.channels, "the sources are of other channels")
    t_ns = table[:, 0] * 1e9
    demand(t_ns[-1] >= stop - 1, f"ngspice stopped at {t_ns[-1]} ns")
    worst, points = 0.0, 0
    for channel, node in node_of.items():
        volts = table[:, header.index(f"v({node})")]
        edges = numpy.array(schedule.edges(channel) or [-1e9])
        error = numpy.abs(volts - expected(schedule, channel, t_ns, stop))[away(edges, t_ns)]
        demand(error.size > 0, f"{channel} has no point away from its edges")
        at = t_ns[away(edges, t_ns)][error.argmax()]
        # Times are printed with twelve digits, so positions on a slope are off accordingly.
        slope = schedule.fastest(channel) * t_ns[-1] * 1e-11 if schedule.is_stage(channel) else 0.0
        demand(error.max() <= TOLERANCE_V + slope, f"{channel} is off by {error.max()} V at {at} ns")
        worst, points = max(worst, error.max()), points + error.size
    return f"ngspice gives {len(node_of)} nodes at {points} points within {worst:.1e} V"


def expected(schedule, channel, t_ns, stop):
    """The scheduled values at these instants; checks that every pulse and stroke has points in it."""
    values = numpy.full(len(t_ns), schedule.rest(channel, -1))
    for start, end, first, last, half in schedule.pulses[channel]:
        inside = (t_ns >= start) & (t_ns < end)
        if schedule.is_stage(channel):
            values[t_ns >= end] = last
        demand(start >= stop or inside.sum() > 1, f"no point within the pulse of {channel} at {start} ns")
        passed = t_ns[inside] - start
        if half:
            values[inside] = numpy.where(passed // half % 2 == 0, first, last)
            reached = numpy.unique(passed // half).size
            demand(reached >= (min(end, stop) - start) // half - 1, f"{channel} leaves out strokes at {start} ns")
        else:
            values[inside] = first + (last - first) * passed / (end - start)
    return values


def away(edges, t_ns):
    """Mask of the instants outside the window around every edge."""
    before = numpy.searchsorted(edges, t_ns - AFTER_NS, side="left")
    near = edges[numpy.minimum(before, len(edges) - 1)]
    return (t_ns < near - BEFORE_NS) | (t_ns > near + AFTER_NS)
