"""Compares what an electrode driver does with its frames with the schedule.

The sender's own code reads the table and encodes the bytes or the call of each frame. They are decoded here as the board's firmware or
its server would, and compared with the schedule at each of its edges.
"""

import importlib.util
import json

from verdict import demand

# Frame layout of OpenDrop's firmware V4.2: column bytes, then control bytes, three of which are temperatures.
COLUMNS, CONTROLS = 16, 16


def sender(program):
    """Imports a sender as a module."""
    spec = importlib.util.spec_from_file_location("frames_sender", program)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def opendrop(data):
    """Decodes a frame as the firmware does: the channels, magnets and heaters (with temperatures) that are on. Feedback must be off."""
    demand(len(data) == COLUMNS + CONTROLS, f"a frame of {len(data)} bytes")
    control = data[COLUMNS:]
    demand(control[0] <= 3 and control[8] == 0 and min(control[10:13]) >= 25, f"control bytes {control.hex()}")
    magnets = {name for name, bit in (("magnet1", 1), ("magnet2", 0)) if control[0] >> bit & 1}
    heaters = {f"heater{number}={degrees}" for number, degrees in enumerate(control[10:13], 1) if degrees != 25}
    return {8 * x + y for x in range(COLUMNS) for y in range(8) if data[x] >> y & 1} | magnets | heaters


def number_of(output, facts):
    """The entry of a driver's output in the table: its number, the name of a magnet, or the name of a heater with its temperature."""
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
    """Whether the file for OpenDrop's own program, read as that program reads it, shows the frames for proportional times."""
    loaded = []
    for item in json.loads(file.read_text()):
        loaded.append({8 * column + row for row in range(8) for column, digit in enumerate(item[f"y{row}"]) if digit == "1"})
    demand(len(loaded) <= 200, f"{len(loaded)} frames")
    period = frames[-1][1] / len(loaded)
    shown = [set(channels) for start, end, channels in frames for _ in range(round((end - start) / period))]
    return shown == loaded
