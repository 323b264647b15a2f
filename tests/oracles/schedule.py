"""The schedule as read from its JSON file: the reference for all other files.

Values are computed here from the JSON alone, so a fault in the compiler's own arithmetic shows up in every judge.
"""

import bisect
import json
from pathlib import Path

from verdict import demand

# Approximate number of edges checked within each drive train.
STROKES = 200

SCHEMA = Path(__file__).resolve().parents[2] / "schema" / "schedule.schema.json"


class Schedule:
    """Channels as functions of integer nanoseconds."""

    def __init__(self, path):
        self.bytes = Path(path).read_bytes()
        self.document = json.loads(self.bytes)
        self.channels = [channel["name"] for channel in self.document["channels"]]
        self.units = {channel["name"]: channel["unit"] for channel in self.document["channels"]}
        self.rests_v = {channel["name"]: channel.get("rest_v", 0.0) for channel in self.document["channels"]}
        self.wires = {channel["name"]: channel["wire"] for channel in self.document["channels"]}
        self.duration_ns = self.document["duration_ns"]
        self.pulses = {name: [] for name in self.channels}
        for act in self.document["actuations"]:
            half = act["swing"]["period_ns"] // 2 if "swing" in act else None
            self.pulses[self.channels[act["channel"]]].append(
                (act["start_ns"], act["start_ns"] + act["duration_ns"], act["from"], act["to"], half)
            )
        for name, pulses in self.pulses.items():
            pulses.sort(key=lambda pulse: pulse[0])
            apart = all(a[1] <= b[0] for a, b in zip(pulses, pulses[1:]))
            demand(apart, f"{name} has two values at a time")

    def value(self, channel, t_ns):
        """The value at an instant; at a jump, the new one."""
        pulses = self.pulses[channel]
        index = bisect.bisect_right(pulses, t_ns, key=lambda pulse: pulse[0]) - 1
        if index < 0 or t_ns >= pulses[index][1]:
            return self.rest(channel, index)
        start, end, first, last, half = pulses[index]
        if half:
            return (first, last)[(t_ns - start) // half % 2]
        return first if first == last else first + (last - first) * (t_ns - start) / (end - start)

    def rest(self, channel, index):
        """The value after the pulse `index`, or before the first one for -1: a voltage is at rest, a stage stays where it is."""
        pulses = self.pulses[channel]
        if self.units[channel] == "V":
            return self.rests_v[channel]
        if not pulses:
            return 0.0
        return pulses[index][3] if index >= 0 else pulses[0][2]

    def parts(self):
        """Start and end in ns of each part played between waits; a wait holds the value at its start. No part follows a wait at the end."""
        holds = self.document.get("holds", [])
        starts = [0, *(hold["start_ns"] + hold["duration_ns"] for hold in holds)]
        parts = list(zip(starts, [*(hold["start_ns"] for hold in holds), self.duration_ns]))
        return parts if not holds or parts[-1][0] < parts[-1][1] else parts[:-1]

    def instruments(self, family):
        """The facts of the program's instruments of a family, by instrument name."""
        known = self.document.get("bench", {}).get("instruments", {})
        return {name: one["facts"][family] for name, one in known.items() if family in one["facts"]}

    def drives(self, instrument):
        """The channels that an instrument plays, each with its output and the link behind it (amplifier, stage driver, switch or axis)."""
        known = self.document.get("bench", {}).get("drives", {})
        return {name: (drive["output"], drive["link"]) for name, drive in known.items() if drive["instrument"] == instrument}

    def output_v(self, link, value):
        """The voltage of an output, or the level of a digital line, for a value of its channel."""
        ((sort, facts),) = link.items()
        if sort == "amplifier":
            return value / facts["gain"]
        if sort == "stage_driver":
            return facts["zero_v"] + facts["scale_v_per_um"] * value
        demand(sort == "switch" and value in (0, facts["on_v"]), f"{value} V behind {link}")
        return float(value != 0)

    def is_stage(self, channel):
        """Whether the values of the channel are positions."""
        return self.units[channel] == "um"

    def fastest(self, channel):
        """The greatest speed of a stage, in um/ns."""
        return max((abs(last - first) / (end - start) for start, end, first, last, _ in self.pulses[channel]), default=0.0)

    def envelope(self, channel, t_ns):
        """The lower and the higher level of the drive train at an instant; without a train, the value twice."""
        pulses = self.pulses[channel]
        index = bisect.bisect_right(pulses, t_ns, key=lambda pulse: pulse[0]) - 1
        if index >= 0 and t_ns < pulses[index][1] and pulses[index][4]:
            return tuple(sorted(pulses[index][2:4]))
        return (self.value(channel, t_ns),) * 2

    def drive(self, channel, t_ns):
        """First and second level, period and start of the drive train at an instant; without a train, the value twice, 0 and 0."""
        pulses = self.pulses[channel]
        index = bisect.bisect_right(pulses, t_ns, key=lambda pulse: pulse[0]) - 1
        if index >= 0 and t_ns < pulses[index][1] and pulses[index][4]:
            start, _, first, second, half = pulses[index]
            return first, second, 2 * half, start
        return self.value(channel, t_ns), self.value(channel, t_ns), 0, 0

    def periods(self, channel):
        """The periods of the channel's drive trains, in ns, sorted."""
        return sorted({2 * half for *_, half in self.pulses[channel] if half})

    def ends(self, channel):
        """The instants at which the channel's pulses and drive trains begin and end, sorted."""
        return sorted({t for start, end, *_ in self.pulses[channel] for t in (start, end)})

    def edges(self, channel):
        """The instants at which the channel jumps or bends, including those within drive trains, sorted."""
        inner = (range(start, end, half) for start, end, _, _, half in self.pulses[channel] if half)
        return sorted({t for edges in inner for t in edges} | set(self.ends(channel)))

    def instants(self):
        """Both sides of every edge of every channel and of the schedule's ends; within a drive train, of some edges only."""
        edges = {t for channel in self.channels for t in (*self.ends(channel), *self.strokes(channel))} | {0, self.duration_ns}
        return sorted(t for t in edges | {t - 1 for t in edges} if t >= 0)

    def strokes(self, channel):
        """Edges within the channel's drive trains: the first and last eight of each, and about STROKES spread between."""
        for start, end, _, _, half in self.pulses[channel]:
            if half:
                edges = range(start, end, half)
                yield from (*edges[:8], *edges[-8:], *edges[:: len(edges) // STROKES + 1])


def held(times, values, t_ns):
    """The value of a step function given by its changes; None before the first."""
    index = bisect.bisect_right(times, t_ns) - 1
    return values[index] if index >= 0 else None


def swung(t_ns, first, second, period_ns, start_ns):
    """The value in a drive train that began at `start_ns`; a period of 0 means no train."""
    return (first, second)[(t_ns - start_ns) // (period_ns // 2) % 2] if period_ns else first


def judge(path, schedule):
    """Validates the JSON against its schema."""
    import jsonschema

    jsonschema.Draft202012Validator(json.loads(SCHEMA.read_text())).validate(schedule.document)
    return f"keeps to {SCHEMA.name}: {len(schedule.channels)} channels, {len(schedule.document['actuations'])} actuations"
