"""Compares what MicroDrop does with its protocol and its device with the schedule.

Both files are read by the rules of MicroDrop 1.9: steps by the names of its columns, electrodes from the layer `Device` of an SVG
whose unit is the pixel, neighbours from the layer `Connections`. The steps are then replayed, with the waits of the schedule at their
prompts, and the electrodes that are on are compared with the schedule at each of its edges.
"""

import json
import re
import xml.etree.ElementTree as ET

from verdict import demand

SVG = "{http://www.w3.org/2000/svg}"
MM_PER_PX = 25.4 / 96

# Columns by MicroDrop's names, each with the suffix of its class name and the type of its values.
COLUMNS = {
    "duration_s": ("builtins.duration_column.DurationColumnModel", float),
    "electrodes": ("builtins.electrodes_column.ElectrodesColumnModel", list),
    "message_prompt": ("builtins.message_prompt_column.MsgPromptColumnModel", str),
    "voltage": ("protocol_columns.voltage_column.VoltageColumnModel", int),
    "frequency": ("protocol_columns.frequency_column.FrequencyColumnModel", int),
}


def layer(root, label):
    """The children of a layer. Any attribute may name the layer; case is ignored."""
    found = [child for child in root if label in (value.casefold() for value in child.attrib.values())]
    demand(len(found) == 1 and not found[0].get("transform"), f"{len(found)} layers `{label}`")
    return list(found[0])


def corners(text):
    """The points of an SVG path of straight lines, in pixels."""
    words = re.findall(r"[MLHVZmlhvz]|[-+]?[\d.]+(?:e[-+]?\d+)?", text)
    points, at, word = [], [0.0, 0.0], None
    while words:
        if words[0].isalpha():
            word = words.pop(0)
            demand(word in "MLHVZ", f"path word {word}")
            if word == "Z":
                continue
        if word in "ML":
            at = [float(words.pop(0)), float(words.pop(0))]
        elif word == "H":
            at = [float(words.pop(0)), at[1]]
        else:
            at = [at[0], float(words.pop(0))]
        points.append(tuple(at))
    return points


def device(path):
    """Reads a device; returns its electrodes (channel and bounds) and their centres in millimetres, and the pairs of neighbours."""
    root = ET.parse(path).getroot()
    demand(root.tag == f"{SVG}svg", f"the root is {root.tag}")
    demand(all(re.fullmatch(r"[\d.]+", root.get(side, "")) for side in ("width", "height")), "sizes have units")
    scale = root.find(f"{SVG}metadata").find("scale")
    demand(scale is not None and float(scale.text) == 1.0, "no scale of 1")
    size = [float(root.get(side)) * MM_PER_PX for side in ("width", "height")]
    electrodes = {}
    for element in layer(root, "device"):
        name, points = element.get("id"), [[x * MM_PER_PX, y * MM_PER_PX] for x, y in corners(element.get("d"))]
        demand(name not in electrodes, f"two of {name}")
        bounds = [min(x for x, _ in points), min(y for _, y in points), max(x for x, _ in points), max(y for _, y in points)]
        demand(min(bounds) >= 0 and bounds[2] <= size[0] and bounds[3] <= size[1], f"{name} lies outside the picture")
        electrodes[name] = (int(element.get("data-channels")), bounds)
    middle = {name: ((b[0] + b[2]) / 2, (b[1] + b[3]) / 2) for name, (_, b) in electrodes.items()}
    pairs = set()
    for element in layer(root, "connections"):
        demand(element.tag == f"{SVG}line", f"{element.tag} joins no electrodes")
        ends = [[float(element.get(f"{axis}{end}")) * MM_PER_PX for axis in "xy"] for end in "12"]
        names = [[name for name, at in middle.items() if abs(at[0] - x) < 1e-4 and abs(at[1] - y) < 1e-4] for x, y in ends]
        demand(all(len(one) == 1 for one in names), f"{element.get('id')} joins no electrodes")
        pairs.add(frozenset(one[0] for one in names))
    return electrodes, middle, pairs


def cells(schedule, driver):
    """The (device, column, row) of each channel of a driver; a pad gets a column far from all others."""
    found = {}
    for channel, (output, _) in schedule.drives(driver).items():
        board, column, row = re.fullmatch(r"(.*)\.(?:e(\d+)_|pad)(\d+)", channel).groups()
        # A pad has no column, and no neighbours.
        found[int(output.removeprefix("c"))] = (board, int(column) if column else -10 * int(row), int(row))
    return found


def judge_device(path, wanted):
    """Checks electrode positions against their cells: one pitch per board, rows upwards, squares that do not overlap.

    Returns the channel of each electrode by name.
    """
    electrodes, middle, pairs = device(path)
    numbers = {channel: name for name, (channel, _) in electrodes.items()}
    demand(set(numbers) == set(wanted) and len(numbers) == len(electrodes), f"electrodes {sorted(numbers)}, not {sorted(wanted)}")
    for name, (channel, (left, top, right, bottom)) in electrodes.items():
        demand(name == f"electrode{channel:03}", f"{name} is of channel {channel}")
        demand(abs((right - left) - (bottom - top)) < 1e-4, f"{name} is no square")
        for other, (_, (l, t, r, b)) in electrodes.items():
            demand(other == name or left >= r or right <= l or top >= b or bottom <= t, f"{name} lies on {other}")
    expected, pitches = set(), {}
    for one, (board, column, row) in wanted.items():
        for other, (of, next_column, next_row) in wanted.items():
            if board == of and (next_column - column, next_row - row) in ((1, 0), (0, 1)):
                expected.add(frozenset({numbers[one], numbers[other]}))
                (x, y), (u, v) = middle[numbers[one]], middle[numbers[other]]
                right, up = (u - x, y - v) if next_column > column else (y - v, u - x)
                demand(abs(up) < 1e-4 and right > 0, f"{numbers[other]} is not beside {numbers[one]}")
                demand(abs(right - pitches.setdefault(board, right)) < 1e-4, f"{board} has two pitches")
    demand(pairs == expected, f"connections {sorted(map(sorted, pairs ^ expected))} are missing or too many")
    return {name: channel for name, (channel, _) in electrodes.items()}


def steps(path, channels):
    """The steps of a protocol as dictionaries; checks what MicroDrop requires of the file."""
    document = json.loads(path.read_text())
    demand(document["schema_version"] == 1 and document["row_flags"] == {}, "another form of protocol")
    demand(document["protocol_metadata"] == {"electrode_to_channel": channels}, "other channels than the device")
    columns = [column["id"] for column in document["columns"]]
    for column in document["columns"]:
        demand(column["cls"].endswith(COLUMNS[column["id"]][0]), f"class {column['cls']}")
    demand(document["fields"] == ["depth", "uuid", "type", "name", *columns], f"fields {document['fields']}")
    rows = document["rows"]
    demand(len({row[1] for row in rows}) == len(rows), "two steps of one name")
    for row in rows:
        demand(row[0] == 0 and row[2] == "step" and isinstance(row[3], str) and len(row) == 4 + len(columns), f"row {row}")
        demand(all(isinstance(value, COLUMNS[name][1]) for name, value in zip(columns, row[4:])), f"row {row}")
    return [dict(zip(columns, row[4:])) for row in rows]


def replay(rows, schedule, channels):
    """The channels that are on, as (start ns, end ns, channels) in schedule time, including the waits that hold them."""
    holds = [(hold["start_ns"], hold["start_ns"] + hold["duration_ns"], hold["awaited"]) for hold in schedule.document.get("holds", [])]
    shown, t_ns, before = [], 0, set()
    for row in rows:
        if row.get("message_prompt"):
            demand(holds, f"prompt `{row['message_prompt']}` without a wait")
            start, end, awaited = holds.pop(0)
            demand(awaited == {"person": {"prompt": row["message_prompt"]}}, f"{awaited} is not what is asked")
            demand(start == t_ns, f"asked at {t_ns} ns, not at {start} ns")
            shown.append((start, end, before))
            t_ns = end
        before = {channels[name] for name in row["electrodes"]}
        end_ns = t_ns + round(row["duration_s"] * 1e9)
        shown.append((t_ns, end_ns, before))
        t_ns = end_ns
    demand(not holds and t_ns == schedule.duration_ns, f"ends at {t_ns} ns, with {len(holds)} waits left")
    return shown


def judge_driver(schedule, name, facts, files):
    """Checks the two files of a driver; returns the number of steps."""
    wanted = cells(schedule, name)
    channels = judge_device(files[1], wanted)
    rows = steps(files[0], channels)
    shown = replay(rows, schedule, channels)
    links = {link["switch"]["on_v"] for _, link in schedule.drives(name).values()}
    if facts["protocol"] == "dropbot":
        demand(all({row["voltage"]} == links for row in rows), f"voltages other than {links}")
        demand(all(row.get("frequency") == facts.get("frequency_hz") for row in rows), "another frequency")
    else:
        demand(not any({"voltage", "frequency"} & set(row) for row in rows), "settings that an OpenDrop does not take")
    drives = {channel: int(output.removeprefix("c")) for channel, (output, _) in schedule.drives(name).items()}
    played = [channel for channel in drives if channel in schedule.channels]
    edges = sorted({0, schedule.duration_ns - 1}.union(*(schedule.edges(channel) for channel in played)))
    for t_ns in edges:
        expected = {drives[channel] for channel in played if t_ns < schedule.duration_ns and schedule.value(channel, t_ns)}
        on = [channels for start, end, channels in shown if start <= t_ns < end]
        demand(t_ns >= schedule.duration_ns or on == [expected], f"{name} at {t_ns} ns: {on}, not {sorted(expected)}")
    return len(rows)


def judge(path, schedule):
    counts = []
    for name, facts in schedule.instruments("electrode_driver").items():
        files = [path.with_name(f"{path.stem}.{name}.microdrop.{ending}") for ending in ("json", "svg")]
        if facts["protocol"] == "purpledrop":
            demand(not any(file.exists() for file in files), f"{name} is not driven by MicroDrop")
            continue
        counts.append(judge_driver(schedule, name, facts, files))
    return f"{sum(counts)} steps of MicroDrop switch what the schedule says"
