"""The schedule as its JSON file says it: what all other files are held against.

Values are computed here from the JSON alone, so a fault of the compiler's own arithmetic shows up in every judge.
"""

import bisect
import json
from pathlib import Path

from verdict import demand

# Edges of each drive train at which a channel is looked at.
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
        """The value at an instant, the new one where it jumps."""
        pulses = self.pulses[channel]
        index = bisect.bisect_right(pulses, t_ns, key=lambda pulse: pulse[0]) - 1
        if index < 0 or t_ns >= pulses[index][1]:
            return self.rest(channel, index)
        start, end, first, last, half = pulses[index]
        if half:
            return (first, last)[(t_ns - start) // half % 2]
        return first if first == last else first + (last - first) * (t_ns - start) / (end - start)

    def rest(self, channel, index):
        """The value after a pulse, -1 for before the first: a voltage is at rest, a stage stays where it is."""
        pulses = self.pulses[channel]
        if self.units[channel] == "V":
            return self.rests_v[channel]
        if not pulses:
            return 0.0
        return pulses[index][3] if index >= 0 else pulses[0][2]

    def parts(self):
        """When each part begins and ends that is played without a wait: where a wait begins, the value there is held. Nothing comes after one at the end."""
        holds = self.document.get("holds", [])
        starts = [0, *(hold["start_ns"] + hold["duration_ns"] for hold in holds)]
        parts = list(zip(starts, [*(hold["start_ns"] for hold in holds), self.duration_ns]))
        return parts if not holds or parts[-1][0] < parts[-1][1] else parts[:-1]

    def instruments(self, family):
        """The facts of the program's instruments of a family, by their names."""
        known = self.document.get("bench", {}).get("instruments", {})
        return {name: one["facts"][family] for name, one in known.items() if family in one["facts"]}

    def drives(self, instrument):
        """The channels that an instrument plays, each with its output and what stands behind that."""
        known = self.document.get("bench", {}).get("drives", {})
        return {name: (drive["output"], drive["link"]) for name, drive in known.items() if drive["instrument"] == instrument}

    def output_v(self, link, value):
        """The voltage of an output, or the level of a line, at a value of its channel."""
        ((sort, facts),) = link.items()
        if sort == "amplifier":
            return value / facts["gain"]
        if sort == "stage_driver":
            return facts["zero_v"] + facts["scale_v_per_um"] * value
        demand(sort == "switch" and value in (0, facts["on_v"]), f"{value} V behind {link}")
        return float(value != 0)

    def is_stage(self, channel):
        """Whether its numbers are positions."""
        return self.units[channel] == "um"

    def fastest(self, channel):
        """The greatest speed of a stage, in um/ns."""
        return max((abs(last - first) / (end - start) for start, end, first, last, _ in self.pulses[channel]), default=0.0)

    def envelope(self, channel, t_ns):
        """The lowest and the highest value of the drive train that an instant lies in, else twice the value."""
        pulses = self.pulses[channel]
        index = bisect.bisect_right(pulses, t_ns, key=lambda pulse: pulse[0]) - 1
        if index >= 0 and t_ns < pulses[index][1] and pulses[index][4]:
            return tuple(sorted(pulses[index][2:4]))
        return (self.value(channel, t_ns),) * 2

    def drive(self, channel, t_ns):
        """First and second level, period and start of the drive train at an instant; else the value twice, 0 and 0."""
        pulses = self.pulses[channel]
        index = bisect.bisect_right(pulses, t_ns, key=lambda pulse: pulse[0]) - 1
        if index >= 0 and t_ns < pulses[index][1] and pulses[index][4]:
            start, _, first, second, half = pulses[index]
            return first, second, 2 * half, start
        return self.value(channel, t_ns), self.value(channel, t_ns), 0, 0

    def periods(self, channel):
        """The periods of its drive trains."""
        return sorted({2 * half for *_, half in self.pulses[channel] if half})

    def ends(self, channel):
        """Where its pulses and drive trains begin and end."""
        return sorted({t for start, end, *_ in self.pulses[channel] for t in (start, end)})

    def edges(self, channel):
        """Where the channel jumps or bends, within drive trains too."""
        inner = (range(start, end, half) for start, end, _, _, half in self.pulses[channel] if half)
        return sorted({t for edges in inner for t in edges} | set(self.ends(channel)))

    def instants(self):
        """Both sides of every edge of any channel, and the ends; of a drive train only some edges, from its start to its end."""
        edges = {t for channel in self.channels for t in (*self.ends(channel), *self.strokes(channel))} | {0, self.duration_ns}
        return sorted(t for t in edges | {t - 1 for t in edges} if t >= 0)

    def strokes(self, channel):
        """Edges within its drive trains: the first ones, the last ones, and STROKES spread between."""
        for start, end, _, _, half in self.pulses[channel]:
            if half:
                edges = range(start, end, half)
                yield from (*edges[:8], *edges[-8:], *edges[:: len(edges) // STROKES + 1])


def held(times, values, t_ns):
    """The value of a step function that is given by its changes."""
    index = bisect.bisect_right(times, t_ns) - 1
    return values[index] if index >= 0 else None


def swung(t_ns, first, second, period_ns, start_ns):
    """The value in a drive train that began at `start_ns`; without one the period is 0."""
    return (first, second)[(t_ns - start_ns) // (period_ns // 2) % 2] if period_ns else first


def judge(path, schedule):
    """Holds the JSON against its schema."""
    import jsonschema

    jsonschema.Draft202012Validator(json.loads(SCHEMA.read_text())).validate(schedule.document)
    return f"keeps to {SCHEMA.name}: {len(schedule.channels)} channels, {len(schedule.document['actuations'])} actuations"
