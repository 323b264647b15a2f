"""The schedule as its JSON file says it: what all other files are held against.

Values are computed here from the JSON alone, so a fault of the compiler's own arithmetic shows up in every judge.
"""

import bisect
import json
from pathlib import Path

from verdict import demand

SCHEMA = Path(__file__).resolve().parents[2] / "schema" / "schedule.schema.json"


class Schedule:
    """Channels as functions of integer nanoseconds."""

    def __init__(self, path):
        self.bytes = Path(path).read_bytes()
        self.document = json.loads(self.bytes)
        self.channels = [channel["name"] for channel in self.document["channels"]]
        self.wires = {channel["name"]: channel["wire"] for channel in self.document["channels"]}
        self.duration_ns = self.document["duration_ns"]
        self.pulses = {name: [] for name in self.channels}
        for act in self.document["actuations"]:
            self.pulses[self.channels[act["channel"]]].append(
                (act["start_ns"], act["start_ns"] + act["duration_ns"], act["from"], act["to"])
            )
        for name, pulses in self.pulses.items():
            pulses.sort()
            apart = all(a[1] <= b[0] for a, b in zip(pulses, pulses[1:]))
            demand(apart, f"{name} has two values at a time")

    def value(self, channel, t_ns):
        """The value at an instant, the new one where it jumps."""
        pulses = self.pulses[channel]
        index = bisect.bisect_right(pulses, t_ns, key=lambda pulse: pulse[0]) - 1
        if index < 0 or t_ns >= pulses[index][1]:
            return 0.0
        start, end, first, last = pulses[index]
        return first if first == last else first + (last - first) * (t_ns - start) / (end - start)

    def edges(self, channel):
        """Where the channel jumps or bends."""
        return sorted({t for start, end, _, _ in self.pulses[channel] for t in (start, end)})

    def instants(self):
        """Both sides of every edge of any channel, and the ends."""
        edges = {t for channel in self.channels for t in self.edges(channel)} | {0, self.duration_ns}
        return sorted(t for t in edges | {t - 1 for t in edges} if t >= 0)


def held(times, values, t_ns):
    """The value of a step function that is given by its changes."""
    index = bisect.bisect_right(times, t_ns) - 1
    return values[index] if index >= 0 else None


def judge(path, schedule):
    """Holds the JSON against its schema."""
    import jsonschema

    jsonschema.Draft202012Validator(json.loads(SCHEMA.read_text())).validate(schedule.document)
    return f"keeps to {SCHEMA.name}: {len(schedule.channels)} channels, {len(schedule.document['actuations'])} actuations"
