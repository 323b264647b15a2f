"""CSV, read by numpy."""

import csv
import re

import numpy

from schedule import held, swung
from verdict import demand


def read(path):
    """Returns the column headers without the time column, the instants in ns, and the array of values, one row per instant."""
    with open(path, newline="", encoding="utf-8") as file:
        header = next(csv.reader(file))
    table = numpy.loadtxt(path, delimiter=",", skiprows=1, ndmin=2)
    demand(header[0] == "time [ns]", f"the first column is {header[0]}")
    demand(table.shape[1] == len(header), "rows and header differ in length")
    return header[1:], [int(t) for t in table[:, 0]], table[:, 1:]


def columns(schedule):
    """Yields the expected columns as (header, channel, part of the channel)."""
    for channel in schedule.channels:
        wire = f" @ {schedule.wires[channel]}" if schedule.wires[channel] else ""
        if schedule.periods(channel):
            yield f"{channel}.first [V]{wire}", channel, "first"
            yield f"{channel}.second [V]{wire}", channel, "second"
            yield f"{channel}.period [ns]", channel, "period"
            yield f"{channel}.start [ns]", channel, "start"
        else:
            yield f"{channel} [{schedule.units[channel]}]{wire}", channel, "value"


def judge(path, schedule):
    header, times, values = read(path)
    expected = list(columns(schedule))
    demand(header == [column for column, _, _ in expected], "the columns are others")
    demand(times == sorted(set(times)), "times do not rise")
    demand(times[0] == 0 and times[-1] == schedule.duration_ns, "it does not span the schedule")
    own = {(channel, part): values[:, index] for index, (_, channel, part) in enumerate(expected)}
    for channel in schedule.channels:
        if schedule.is_stage(channel):
            positions(times, own[channel, "value"], channel, schedule)
        elif schedule.periods(channel):
            train(times, *(own[channel, part] for part in ("first", "second", "period", "start")), channel, schedule)
        else:
            for t_ns in schedule.instants():
                found, wanted = held(times, own[channel, "value"], t_ns), schedule.value(channel, t_ns)
                demand(found == wanted, f"{channel} is {found} V at {t_ns} ns, not {wanted} V")
    return f"{len(times)} rows of {len(header)} columns are the schedule"


def train(times, first, second, period, start, channel, schedule):
    """Checks the voltages that the rows stand for at the ends and at edges of every drive train, and each row against its train."""
    for t_ns in schedule.instants():
        row = [int(held(times, column, t_ns)) for column in (period, start)]
        found = swung(t_ns, held(times, first, t_ns), held(times, second, t_ns), *row)
        wanted = schedule.value(channel, t_ns)
        demand(found == wanted, f"{channel} is {found} V at {t_ns} ns, not {wanted} V")
    for index, t_ns in enumerate(times):
        found = (first[index], second[index], int(period[index]), int(start[index]))
        wanted = schedule.drive(channel, t_ns)
        demand(found == wanted, f"{channel} is {found} at {t_ns} ns, not {wanted}")


def positions(times, own, channel, schedule):
    """Checks positions interpolated linearly between rows, at every bend and midway between bends."""
    bends = schedule.instants()
    asked = numpy.array(sorted({*bends, *(a + (b - a) // 2 for a, b in zip(bends, bends[1:]))}))
    found = numpy.interp(asked, times, own)
    expected = numpy.array([schedule.value(channel, int(t_ns)) for t_ns in asked])
    off = numpy.abs(found - expected)
    worst = off.argmax()
    demand(off[worst] <= 1e-9, f"{channel} is {found[worst]} um at {asked[worst]} ns, not {expected[worst]} um")
