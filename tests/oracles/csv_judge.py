"""CSV, read by numpy."""

import csv
import re

import numpy

from schedule import held
from verdict import demand


def read(path):
    """Names of the channels, instants, and a row of values for each."""
    with open(path, newline="", encoding="utf-8") as file:
        header = next(csv.reader(file))
    table = numpy.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)
    demand(header[0] == "time [ns]", f"the first column is {header[0]}")
    demand(table.shape[1] == len(header), "rows and header differ in length")
    return header[1:], [int(t) for t in table[:, 0]], table[:, 1:]


def judge(path, schedule):
    header, times, values = read(path)
    parts = [re.fullmatch(r"(\S+) \[(V|um)\](?: @ (.*))?", column) for column in header]
    demand(all(parts), "a column has no unit")
    demand([part[1] for part in parts] == schedule.channels, "the channels are others")
    demand([part[2] for part in parts] == list(schedule.units.values()), "the units are others")
    demand([part[3] for part in parts] == list(schedule.wires.values()), "the wires are others")
    demand(times == sorted(set(times)), "times do not rise")
    demand(times[0] == 0 and times[-1] == schedule.duration_ns, "it does not span the schedule")
    for column, channel in enumerate(schedule.channels):
        own = values[:, column]
        if schedule.is_stage(channel):
            positions(times, own, channel, schedule)
            continue
        for t_ns in schedule.instants():
            found, expected = held(times, own, t_ns), schedule.value(channel, t_ns)
            demand(found == expected, f"{channel} is {found} V at {t_ns} ns, not {expected} V")
    return f"{len(times)} rows of {len(header)} channels are the schedule"


def positions(times, own, channel, schedule):
    """Straight lines from row to row are where the stage is, at every bend and between."""
    bends = schedule.instants()
    asked = numpy.array(sorted({*bends, *(a + (b - a) // 2 for a, b in zip(bends, bends[1:]))}))
    found = numpy.interp(asked, times, own)
    expected = numpy.array([schedule.value(channel, int(t_ns)) for t_ns in asked])
    off = numpy.abs(found - expected)
    worst = off.argmax()
    demand(off[worst] <= 1e-9, f"{channel} is {found[worst]} um at {asked[worst]} ns, not {expected[worst]} um")
