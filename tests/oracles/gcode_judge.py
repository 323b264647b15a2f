"""G-code of a hand, read by two readers: gcodeparser, whose lines are executed here against a clock, and pygcode's machine."""

import json
import re

import numpy
from gcodeparser import parse_gcode_lines
from mcap.reader import make_reader
from pygcode import Line, Machine

from verdict import demand

# Coordinates are whole nanometres.
TOLERANCE_UM = 1e-3
TOLERANCE_NS = 1.0


def judge(path, schedule):
    files = sorted(path.parent.glob(f"{path.stem}.*{path.suffix}"))
    letters, moves = [], 0
    for file in files:
        text = file.read_text(encoding="ascii")
        axes = dict(re.findall(r"^; ([A-Z]) is ([^\s,]+)", text, re.MULTILINE))
        letters += axes.values()
        times, places = played(text, axes, schedule)
        by_pygcode(text, axes, places)
        machine = machine_of(file, path, axes, schedule)
        for letter, channel in axes.items():
            compare(times, of_channel(1000 * places[letter], machine, letter, channel, schedule), channel, schedule)
        moves += len(times)
        rounding(text, path.with_suffix(".mcap"), axes.values(), machine, schedule)
    demand(sorted(letters) == sorted(schedule.channels), "some axis is in no file, or in two")
    return f"{len(files)} files, {moves} places of {len(letters)} axes are the schedule for gcodeparser and pygcode"


def played(text, axes, schedule):
    """Returns the instants at which lines end, in ns, and the position of each axis at them, in millimetres."""
    end_ns, holds = schedule.duration_ns, list(schedule.document.get("holds", []))
    # Labels and messages to the operator move nothing.
    text = re.sub(r"^(o\d+ .*|\(.*\))$", "", text, flags=re.MULTILINE)
    head, lines = [], iter(parse_gcode_lines(text))
    at, t_ns, times, places = {}, 0.0, [], {letter: [] for letter in axes}
    for line in lines:
        demand(line.command != ("G", 1), "it moves before it pauses")
        head.append(line.command)
        if line.command == ("G", 0):
            at = {letter: line.params[letter] for letter in axes}
        if line.command == ("M", 0):
            break
    demand({("G", 21), ("G", 90), ("G", 93), ("G", 64), ("G", 0)} <= set(head), f"it begins by {head}")
    for line in lines:
        tell(times, places, t_ns, at)
        match line.command:
            case ("G", 1):
                feed = line.params.pop("F")
                demand(line.params and set(line.params) <= set(axes), f"line {line.line_index + 1} moves other axes")
                at |= line.params
                t_ns += 60e9 / feed
            case ("G", 4):
                t_ns += line.params["P"] * 1e9
            case ("M", 0) | ("M", 66):
                hold = holds.pop(0)
                demand(abs(t_ns - hold["start_ns"]) <= TOLERANCE_NS, f"it waits at {t_ns} ns, not at {hold['start_ns']} ns")
                demand((line.command == ("M", 66)) == ("input" in hold["awaited"]), "it waits for something else")
                t_ns += hold["duration_ns"]
            case ("M", 2):
                demand(not holds, f"it does not wait for {holds}")
                demand(next(lines, None) is None, "it goes on after its end")
                demand(abs(t_ns - end_ns) <= TOLERANCE_NS, f"it lasts {t_ns} ns, not {end_ns} ns")
                return numpy.array(times), {letter: numpy.array(list_) for letter, list_ in places.items()}
            case other:
                demand(False, f"line {line.line_index + 1} is {other}")
    demand(False, "it has no end")


def machine_of(file, path, axes, schedule):
    """The machine that plays a file, or None if the program has no machines. The file must have exactly the axes wired to it."""
    machines = schedule.instruments("machine_controller")
    if not machines:
        return None
    name = file.name.removeprefix(f"{path.stem}.").removesuffix(path.suffix)
    demand(name in machines, f"{file.name} is of no machine of {list(machines)}")
    wired = {output: channel for channel, (output, _) in schedule.drives(name).items()}
    demand(axes == wired, f"it moves {axes}, wired are {wired}")
    return name


def of_channel(places_um, machine, letter, channel, schedule):
    """Converts positions of an axis to positions of its channel, in um."""
    if machine is None:
        return places_um
    output, link = schedule.drives(machine)[channel]
    stage = link["axis"]
    demand(output == letter, f"{channel} is on {letter}, wired to {output}")
    demand(stage["least_um"] - TOLERANCE_UM <= min(places_um) and max(places_um) <= stage["most_um"] + TOLERANCE_UM, f"{letter} leaves its travel")
    return {"forward": 1, "backward": -1}[stage["direction"]] * (places_um - stage["origin_um"])


def cut_um(channel, period_ns, schedule):
    """How far the chord between two servo cycles cuts the sharpest corner of a channel, in um, with the corner midway between them."""
    lines = [(start, end, (last - first) / (end - start)) for start, end, first, last, _ in schedule.pulses[channel]]
    lines = [(0, 0, 0.0), *lines, (schedule.duration_ns, schedule.duration_ns, 0.0)]
    changes = [0.0]
    for (_, end, slope), (start, _, after) in zip(lines, lines[1:]):
        changes += [abs(after - slope)] if start == end else [abs(slope), abs(after)]
    return max(changes) * period_ns / 4


def rounding(text, log, channels, machine, schedule):
    """Checks that G64 rounds corners by half of the hand's tolerance less what servo cycles cut.

    The tolerance comes from the claims in the log beside the file; without a log, only the presence of G64 is checked.
    """
    found = re.findall(r"^G64 P(\S+)", text, re.MULTILINE)
    demand(len(found) == 1 and float(found[0]) > 0, f"it says G64 with {found}")
    if not log.exists():
        return
    with open(log, "rb") as file:
        claims = next(json.loads(a.data) for a in make_reader(file).iter_attachments() if a.name == "claims.json")
    period_ns = 1e9 / schedule.instruments("machine_controller")[machine]["rate_hz"] if machine else 0.0
    left = []
    for channel in channels:
        own = [job["order"]["fingers"]["facts"]["tolerance_um"] for job in claims["jobs"] if job["device"] == channel.split(".")[0]]
        left.append(min(own) / 2 - cut_um(channel, period_ns, schedule))
    spare_um = min(left) - float(found[0]) * 1e3
    demand(-1e-9 <= spare_um < 1e-3, f"corners are rounded by {found[0]} mm, {min(left)} um are left for it")


def tell(times, places, t_ns, at):
    times.append(t_ns)
    for letter, place in at.items():
        places[letter].append(place)


class Stages(Machine):
    """A pygcode machine with all axes of the dialect."""

    axes = set("XYZABCUVW")


def by_pygcode(text, axes, places):
    """Checks that pygcode's machine has the same positions after each line that moves or waits."""
    machine, found = Stages(), {letter: [] for letter in axes}
    for line in text.splitlines():
        # pygcode knows neither labels nor M66, which waits for a pin.
        if not line.startswith(("o", "(", "M66 ")):
            machine.process_block(Line(line).block)
        if line.startswith(("M0", "M66 ", "G1 ", "G4 ")):
            for letter in axes:
                found[letter].append(machine.pos.values[letter])
    mode = str(machine.mode).split()
    demand({"G21", "G90", "G93", "G64"} <= set(mode), f"pygcode ends in {mode}")
    for letter in axes:
        demand(numpy.array_equal(found[letter], places[letter]), f"pygcode has {letter} elsewhere")


def compare(times, found_um, channel, schedule):
    bends = schedule.instants()
    asked = numpy.array(sorted({*bends, *(a + (b - a) // 2 for a, b in zip(bends, bends[1:]))}))
    expected = numpy.array([schedule.value(channel, int(t_ns)) for t_ns in asked])
    off = numpy.abs(numpy.interp(asked, times, found_um) - expected)
    worst = off.argmax()
    demand(off[worst] <= TOLERANCE_UM, f"{channel} is {off[worst]} um off at {asked[worst]} ns")
