"""The deck, run by ngspice; its node voltages against the schedule."""

import re
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy

from verdict import Skipped, demand

TOLERANCE_V = 1e-9
# The deck's sources rise from an edge on for 1 ns; printed times have 12 digits.
BEFORE_NS, AFTER_NS = 0.5, 1.5


def judge(path, schedule):
    ngspice = shutil.which("ngspice")
    if not ngspice:
        raise Skipped("ngspice is not installed")
    sources = path.with_suffix(".pwl.inc")
    with tempfile.TemporaryDirectory() as folder:
        for file in (path, sources):
            shutil.copy(file, folder)
        # The exit code of a batch run says little, so the data decide.
        run = subprocess.run([ngspice, "-b", path.name], cwd=folder, capture_output=True, text=True, timeout=600)
        output = Path(folder) / f"{path.stem}.ngspice.txt"
        demand(output.exists(), f"ngspice wrote no data: {run.stderr[-500:]}")
        with open(output, encoding="ascii") as file:
            header = file.readline().lower().split()
        table = numpy.loadtxt(output, skiprows=1, ndmin=2)
    return compare(header, table, nodes(sources), schedule)


def nodes(sources):
    """The node of each channel, as the comments of the sources say."""
    pattern = r"^\* (\S+) \[V\].*\nV(\S+) (\S+) 0 PWL\($"
    return {name: node.lower() for name, _, node in re.findall(pattern, sources.read_text(), re.MULTILINE)}


def compare(header, table, node_of, schedule):
    demand(header[0] == "time", f"the first column is {header[0]}")
    demand(list(node_of) == schedule.channels, "the sources are of other channels")
    t_ns = table[:, 0] * 1e9
    demand(t_ns[-1] >= schedule.duration_ns - 1, f"ngspice stopped at {t_ns[-1]} ns")
    worst, points = 0.0, 0
    for channel, node in node_of.items():
        volts = table[:, header.index(f"v({node})")]
        expected = numpy.zeros(len(t_ns))
        for start, end, first, last in schedule.pulses[channel]:
            inside = (t_ns >= start) & (t_ns < end)
            demand(inside.sum() > 1, f"no point within the pulse of {channel} at {start} ns")
            expected[inside] = first + (last - first) * (t_ns[inside] - start) / (end - start)
        clear = numpy.ones(len(t_ns), dtype=bool)
        for edge in schedule.edges(channel):
            clear &= (t_ns < edge - BEFORE_NS) | (t_ns > edge + AFTER_NS)
        error = numpy.abs(volts - expected)[clear]
        demand(error.size > 0, f"{channel} has no point away from its edges")
        demand(error.max() <= TOLERANCE_V, f"{channel} is off by {error.max()} V at {t_ns[clear][error.argmax()]} ns")
        worst, points = max(worst, error.max()), points + error.size
    return f"ngspice gives {len(node_of)} nodes at {points} points within {worst:.1e} V"
