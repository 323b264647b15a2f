"""What an electrode driver does with its frames, against the schedule.

The sender's own code reads the table and makes the bytes or the call of each frame; they are taken apart here by what the firmware of
the board, or its server, makes of them, and held against the schedule at each of its edges.
"""

import importlib.util
import json

from verdict import demand

# Of OpenDrop's firmware V4.2: bytes of columns, then control bytes; temperatures stand in three of these.
COLUMNS, CONTROLS = 16, 16


def sender(program):
    """A sender as a module."""
    spec = importlib.util.spec_from_file_location("frames_sender", program)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def opendrop(data):
    """What the firmware switches on by a frame: channels, magnets, and heaters with their degrees; feedback stays off."""
    demand(len(data) == COLUMNS + CONTROLS, f"a frame of {len(data)} bytes")
    control = data[COLUMNS:]
    demand(control[0] <= 3 and control[8] == 0 and min(control[10:13]) >= 25, f"control bytes {control.hex()}")
    magnets = {name for name, bit in (("magnet1", 1), ("magnet2", 0)) if control[0] >> bit & 1}
    heaters = {f"heater{number}={degrees}" for number, degrees in enumerate(control[10:13], 1) if degrees != 25}
    return {8 * x + y for x in range(COLUMNS) for y in range(8) if data[x] >> y & 1} | magnets | heaters


def number_of(output, facts):
    """What stands for an output of a driver in the table: its number, or the name of a magnet, or of a heater with its degrees."""
    if output.startswith("heater"):
        return f"{output}={facts['heaters_degc'][output.removeprefix('heater')]}"
    return output if output.startswith("magnet") else int(output.removeprefix("c"))


def judge(path, schedule):
    module = sender(path)
    plays = {driver["name"]: driver for driver in module.PLAYS["drivers"]}
    known = schedule.instruments("electrode_driver")
    demand(set(plays) == set(known), f"plays {sorted(plays)}, not {sorted(known)}")
    demand(abs(module.PLAYS["duration_s"] * 1e9 - schedule.duration_ns) < 1, "plays for another time")
    counts = []
    for name, facts in known.items():
        frames = module.read(plays[name], path.parent)
        drives = {channel: number_of(output, facts) for channel, (output, _) in schedule.drives(name).items()}
        on = {channel: link["switch"]["on_v"] for channel, (_, link) in schedule.drives(name).items()}
        edges = sorted({0, schedule.duration_ns}.union(*(edges_of(schedule, channel) for channel in drives if channel in schedule.channels)))
        starts = [round(start * 1e9) for start, _, _ in frames]
        demand(starts and starts[0] == 0 and round(frames[-1][1] * 1e9) == schedule.duration_ns, f"{name}: frames do not fill the schedule")
        demand(set(starts) <= set(edges), f"{name}: a frame begins where nothing changes")
        for start, end, channels in frames:
            demand(end - start >= facts["least_frame_ns"] / 1e9 - 1e-9, f"{name}: a frame of {end - start} s")
        for t_ns in edges[:-1]:
            index = max(index for index, start in enumerate(starts) if start <= t_ns)
            channels = frames[index][2]
            shown = opendrop(module.Opendrop.frame(channels)) if facts["protocol"] == "opendrop" else set(channels)
            expected = set()
            for channel, number in drives.items():
                value = schedule.value(channel, t_ns) if channel in schedule.channels else 0.0
                demand(value in (0.0, on[channel]), f"{channel} is at {value} V")
                if value:
                    expected.add(number)
            demand(shown == expected, f"{name} at {t_ns} ns: {sorted(shown, key=str)}, not {sorted(expected, key=str)}")
        file = path.with_name(f"{path.name.removesuffix('.frames.py')}.{name}.opendrop.json")
        if file.exists():
            demand(opendrop_file(file, frames), f"{file.name} shows other frames")
        counts.append(len(frames))
    return f"{sum(counts)} frames switch what the schedule says"


def edges_of(schedule, channel):
    return {edge for pulse in schedule.pulses[channel] for edge in pulse[:2]}


def opendrop_file(file, frames):
    """Whether the file of OpenDrop's own program, read as that reads it, has the frames for times in proportion."""
    loaded = []
    for item in json.loads(file.read_text()):
        loaded.append({8 * column + row for row in range(8) for column, digit in enumerate(item[f"y{row}"]) if digit == "1"})
    demand(len(loaded) <= 200, f"{len(loaded)} frames")
    period = frames[-1][1] / len(loaded)
    shown = [set(channels) for start, end, channels in frames for _ in range(round((end - start) / period))]
    return shown == loaded
