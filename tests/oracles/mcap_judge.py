"""MCAP, read by the `mcap` package with the descriptors in the file; all checksums are validated."""

import hashlib
import math
import re

from mcap.reader import make_reader
from mcap.stream_reader import StreamReader
from mcap_protobuf.decoder import DecoderFactory

import csv_judge
from schedule import held
from verdict import demand


# Log level of a beat: one simultaneous move of parts within a step.
DEBUG = 1

# Last part of a channel topic, by unit.
TOPICS = {"V": "voltages", "um": "positions"}


def judge(path, schedule):
    with open(path, "rb") as file:
        reader = make_reader(file, validate_crcs=True, decoder_factories=[DecoderFactory()])
        messages = [(channel, message.log_time, proto) for _, channel, message, proto in reader.iter_decoded_messages()]
        attachments = {attachment.name: attachment.data for attachment in reader.iter_attachments()}
        metadata = {record.name: record.metadata for record in reader.iter_metadata()}
    with open(path, "rb") as file:
        # Sequential read, which validates the checksum of the whole data section; the reader above skips it.
        records = sum(1 for _ in StreamReader(file, validate_crcs=True).records)
    demand(records >= len(messages), "the file is shorter than its index")
    topics = {}
    for channel, t_ns, proto in messages:
        topics.setdefault(channel.topic, (channel, []))[1].append((t_ns, proto))
    series = {(channel["device"], channel["unit"]) for channel in schedule.document["channels"]}
    csv_path = path.with_suffix(".csv")
    table = csv_judge.read(csv_path) if csv_path.exists() else None
    compared = sum(channels(*topics[f"/{device}/{TOPICS[unit]}"], device, unit, schedule, table) for device, unit in sorted(series))
    log_lines(topics.get("/log", (None, []))[1], schedule)
    motion(topics, schedule)
    provenance(attachments, metadata, schedule)
    return f"{compared} values, {len(messages)} messages on {len(topics)} topics, {len(attachments)} attachments agree"


def channels(channel, messages, device, unit, schedule, table):
    """Checks every value against the JSON and, where there is one, the CSV file; no edge may be missing.

    A channel with drive trains has two fields, for the lower and the higher level.
    """
    fields = columns(channel.metadata, device, unit, schedule)
    for t_ns, proto in messages:
        for path, (name, bound) in fields.items():
            found, wanted = field(proto, path), schedule.envelope(name, t_ns)[bound or 0]
            demand(abs(found - wanted) <= 1e-12 * max(abs(wanted), abs(wanted) if unit == "V" else 1.0), f"{name} as {path} is {found} {unit} at {t_ns} ns, not {wanted} {unit}")
            if table and unit == "V":
                in_csv = sorted(held(table[1], table[2][:, index], t_ns) for index in csv_columns(table[0], name, bound))[bound or 0]
                demand(found == in_csv, f"{name} is {found} V at {t_ns} ns, and {in_csv} V in the CSV file")
    times = {t_ns for t_ns, _ in messages}
    own = {t for name, _ in fields.values() for edge in schedule.ends(name) for t in (edge, edge - 1) if t >= 0}
    demand(own | {0, schedule.duration_ns} <= times, f"/{device}/{TOPICS[unit]} leaves out an edge")
    return len(messages) * len(fields)


def columns(metadata, device, unit, schedule):
    """Maps each field to its channel and the level of its drive trains: 0 for low, 1 for high, None without trains."""
    fields, kinds = {}, {"low": 0, "high": 1, None: None}
    for path, name in metadata.items():
        if path.endswith((".wire", ".bound", ".period_ns")):
            continue
        fields[path] = (name, kinds[metadata.get(f"{path}.bound")])
        demand(metadata.get(f"{path}.wire") == schedule.wires[name], f"the wire of {name} is another")
        periods = [int(period) for period in metadata.get(f"{path}.period_ns", "").split()]
        demand(periods == schedule.periods(name), f"the drive trains of {name} have other periods")
    expected = {entry["name"] for entry in schedule.document["channels"] if (entry["device"], entry["unit"]) == (device, unit)}
    wanted = {(name, bound) for name in expected for bound in ((0, 1) if schedule.periods(name) else (None,))}
    demand(set(fields.values()) == wanted, f"/{device}/{TOPICS[unit]} has other channels")
    return fields


def field(proto, path):
    name, _, index = path.partition("[")
    value = getattr(proto, name)
    return value[int(index.rstrip("]"))] if index else value


def csv_columns(header, name, bound):
    """Indices of the CSV columns with the voltage of a channel, or with the two levels of its drive trains."""
    starts = (f"{name} [",) if bound is None else (f"{name}.first [", f"{name}.second [")
    return [next(index for index, column in enumerate(header) if column.startswith(start)) for start in starts]


def log_lines(messages, schedule):
    """Checks `/log`: each step with its source line, text and reached values; the operations of an assay; and the beats of board steps.

    Reached values are compared with a relative tolerance of 1e-5 (1e-4 absolute), because they have at most six digits.
    """
    key = lambda line: line[:2] + line[3:]
    for t, m in messages:
        demand(m.message.startswith(f"{m.file}:{m.line} "), f"/log does not say where `{m.message}` stands")
    beats = [(t, m) for t, m in messages if m.level == DEBUG]
    found = [(t, m.name, m.message.removeprefix(f"{m.file}:{m.line} "), m.file, m.line) for t, m in messages if m.level != DEBUG]
    found = sorted(found, key=key)
    beats_of_boards(beats, schedule)
    steps = schedule.document["steps"]
    entries = [(s["start_ns"], s["task"], (headline(s), s.get("reached", [])), s["file"], s["line"]) for s in steps]
    for step in steps:
        for own in step.get("operations", []):
            words = f"{', '.join(own['parts'])}: {own['text']}"
            entries.append((own["start_ns"], step["task"], (words, []), step["file"], own["line"]))
    wanted = sorted(entries, key=key)
    demand([key(line) for line in found] == [key(line) for line in wanted], "/log is not the steps")
    for (_, _, message, _, _), (_, _, (text, reached), _, _) in zip(found, wanted):
        demand(message.startswith(text), f"/log says `{message}`, not `{text}`")
        lines = message[len(text):].split("; ")[1:]
        demand(len(lines) == len(reached), f"/log says {len(lines)} times what is reached, the schedule {len(reached)} times")
        for line, entry in zip(lines, reached):
            shown = [float(number) for number in re.findall(r"-?\d+\.?\d*(?:e-?\d+)?", line.removeprefix(entry.get("robot", "")))]
            near = all(abs(a - b) <= max(1e-4, 1e-5 * abs(b)) for a, b in zip(shown, numbers(entry)))
            demand(len(shown) == len(numbers(entry)) and near, f"/log says `{line}`, the schedule {entry}")


def headline(step):
    """The text of a step; where its operations have their own lines, the text before the brace and the number of operations."""
    operations = step.get("operations", [])
    return f"{step['text'].split(' {')[0]}, {len(operations)} operations" if operations else step["text"]


def beats_of_boards(beats, schedule):
    """Checks that each board step with several moves of parts has one beat per move, with its instant and target electrodes."""
    wanted = []
    for plan_index, plan in enumerate(schedule.document["plans"]):
        if plan["kind"] != "electrode_array":
            continue
        changes = [(a, b) for a, b in zip(plan["states"], plan["states"][1:]) if a["parts"] != b["parts"]]
        for step in schedule.document["steps"]:
            end = step["start_ns"] + step["duration_ns"]
            own = [(a, b) for a, b in changes if step["plan"] == plan_index and step["start_ns"] < b["t_ns"] <= end]
            for number, (a, b) in enumerate(own, 1) if len(own) > 1 else ():
                cells = sorted(tuple(cell) for name, cell in b["parts"].items() if a["parts"].get(name) != cell)
                wanted.append((step["file"], step["line"], f"beat {number} of {len(own)}", b["t_ns"], cells))
    demand(len(beats) == len(wanted), f"/log has {len(beats)} beats, the schedule {len(wanted)}")
    found = {}
    for t, m in beats:
        found.setdefault((m.file, m.line, m.message.split(" ", 1)[1].split(":")[0]), []).append((t, m.message))
    for file, line, beat, arrived, cells in wanted:
        # A line in a loop has several entries; the latest one before the arrival is meant.
        t, message = max((entry for entry in found.get((file, line, beat), []) if entry[0] < arrived), default=(arrived, "nothing"))
        named = sorted(tuple(map(int, cell)) for cell in re.findall(r" to \((\d+), (\d+)\)", message))
        demand(t < arrived and (named == cells or "more" in message), f"/log has `{message}` at {t} ns, not {cells}")


def numbers(reached):
    """The numbers of a reached value, in the order in which its line prints them."""
    if reached["of"] == "turn":
        return [reached["asked_deg"], reached["reached_deg"], abs(reached["off_deg"])]
    if reached["of"] == "orientation":
        return [reached["off_deg"]]
    if reached["of"] == "place":
        return [*reached["asked_um"], *reached["reached_um"], reached["off_um"]]
    asked, found = [*reached["asked_um"], reached["asked_deg"]], [*reached["reached_um"], reached["reached_deg"]]
    return [*asked, *found, reached["off_um"], abs(reached["off_deg"])]


def motion(topics, schedule):
    """Checks poses, paths and scenes against the states of the plans."""
    for plan in schedule.document["plans"]:
        kinds = {"dimibot": robot, "electrode_array": board, "microrobots": bed, "fingers": hand}
        kinds[plan["kind"]](topics, plan, schedule)
    frames = {f.child_frame_id for _, m in topics["/tf"][1] for f in m.transforms}
    demand({plan["device"] for plan in schedule.document["plans"]} <= frames, "/tf lacks a device")


def robot(topics, plan, _):
    """Checks the pose, path and scene of a DiMiBot's end-effector."""
    device, states = plan["device"], plan["states"]
    poses = dict((t, m.pose.position) for t, m in topics[f"/{device}/pose"][1])
    for state in states:
        at = poses[state["t_ns"]]
        demand([at.x, at.y] == state["position_um"], f"/{device}/pose is elsewhere at {state['t_ns']} ns")
    paths = [[[p.position.x, p.position.y] for p in m.poses] for _, m in topics[f"/{device}/path"][1]]
    demand([s["position_um"] for s in states] in paths, f"/{device}/path is another")
    updates = [m for what in ("scene", "plan") for _, m in topics[f"/{device}/{what}"][1]]
    entities = {entity.id: entity for update in updates for entity in update.entities}
    ids = {f"{device}/{what}" for what in ("lattice", "path", "tip", "stops")}
    demand(ids <= entities.keys(), f"the pictures of {device} lack {ids - entities.keys()}")
    demand(entities[f"{device}/lattice"].frame_id == device, "the lattice stands in another frame")


def board(topics, plan, _):
    """Checks the positions of parts, including those that enter later; each has a frame and a body."""
    device, states = plan["device"], plan["states"]
    cells = topics[f"/{device}/cells"][1]
    pitches = set()
    names = sorted({name for state in states for name in state["parts"]})
    for name in names:
        poses = dict((t, (m.pose.position.x, m.pose.position.y)) for t, m in topics[f"/{device}/pose/{name}"][1])
        field = re.sub(r"\W", "_", name)
        for state in states:
            if name not in state["parts"]:
                continue
            column, row = state["parts"][name]
            # Poses are published only when a part moves.
            x, y = poses[max(t for t in poses if t <= state["t_ns"])]
            pitches |= {round(x / (column - 1), 6) for _ in "x" if column > 1} | {round(y / (row - 1), 6) for _ in "y" if row > 1}
            at = [m for t, m in cells if t <= state["t_ns"]][-1]
            demand([getattr(at, f"{field}_column"), getattr(at, f"{field}_row")] == [column, row], f"/{device}/cells has {name} elsewhere at {state['t_ns']} ns")
    demand(len(pitches) == 1, f"/{device}/pose has pitches of {sorted(pitches)[:4]} um")
    entities = {entity.id: entity for _, m in topics[f"/{device}/scene"][1] for entity in m.entities}
    frames = {f.child_frame_id for _, m in topics["/tf"][1] for f in m.transforms}
    for name in names:
        body = entities.get(f"{device}/part/{name}")
        demand(body is not None and body.frame_id == f"{device}/{name}", f"{device} draws no part {name}")
        demand(body.frame_id in frames, f"/tf lacks the part {name}")


def bed(topics, plan, _):
    """Checks the poses of robots and the state of their arms; each robot has a frame, a body and a path."""
    device, states = plan["device"], plan["states"]
    channel, messages = topics[f"/{device}/poses"]
    names = channel.metadata["robots"].split()
    poses = {t: dict(zip(names, m.poses, strict=True)) for t, m in messages}
    arms_channel, messages = topics[f"/{device}/arms"]
    rows = [field for field in messages[0][1].DESCRIPTOR.fields_by_name if field != "control"]
    demand(all(field in arms_channel.metadata for field in rows), f"/{device}/arms does not say which arm is which")
    arms = dict(messages)
    for index, state in enumerate(states):
        t_ns = state["t_ns"]
        if any(later["t_ns"] == t_ns for later in states[index + 1 :]):
            continue
        said = poses[max(t for t in poses if t <= t_ns)]
        for name, pose in state["poses"].items():
            x, y, heading = pose["x_um"], pose["y_um"], math.radians(pose["heading_deg"])
            at, turn = said[name].position, said[name].orientation
            off = math.hypot(at.x - x, at.y - y)
            demand(off < 1e-5, f"{name} is {off} um from its place at {t_ns} ns")
            off = math.sin(math.atan2(turn.z, turn.w) - heading / 2)
            demand(turn.x == turn.y == 0 and abs(off) < 1e-8, f"{name} is turned otherwise at {t_ns} ns")
        demand(arms[t_ns].control == state["control"], f"/{device}/arms has another control state at {t_ns} ns")
        found = [getattr(arms[t_ns], row) for row in rows]
        demand(found == state["arms"], f"/{device}/arms is {found} at {t_ns} ns, not {state['arms']}")
    entities = {entity.id: entity for _, m in topics[f"/{device}/scene"][1] for entity in m.entities}
    frames = {f.child_frame_id for _, m in topics["/tf"][1] for f in m.transforms}
    for name in states[0]["poses"]:
        body = entities.get(f"{device}/robot/{name}")
        demand(body is not None and body.frame_id == f"{device}/{name}", f"{device} draws no robot {name}")
        demand(body.frame_id in frames, f"/tf lacks the robot {name}")
        way = dict(topics[f"/{device}/path/{name}"][1])[plan["start_ns"]].poses
        for pose, state in zip((way[0], way[-1]), (states[0], states[-1])):
            at, due = pose.position, state["poses"][name]
            demand(math.hypot(at.x - due["x_um"], at.y - due["y_um"]) < 1e-5, f"the way of {name} is another")
    demand(topics[f"/{device}/plan"][1] and topics[f"/{device}/state"][1], f"{device} shows no goals or no arms")


def hand(topics, plan, schedule):
    """Checks the pose of the part, the frames of the tips against the stages, and the grasp of each state."""
    device, states = plan["device"], plan["states"]
    poses = {t: m.pose for t, m in topics[f"/{device}/pose"][1]}
    frames = [(t, {f.child_frame_id: f for f in m.transforms}) for t, m in topics["/tf"][1]]
    scene = {entity.id: entity for _, m in topics[f"/{device}/scene"][1] for entity in m.entities}
    (body,) = (entity for name, entity in scene.items() if name.startswith(f"{device}/part/"))
    demand(len(body.lines) in (1, 2) and all(len(line.points) > 60 for line in body.lines), f"{device} shows no sections")
    for state in states:
        pose = poses[max(t for t in poses if t <= state["t_ns"])]
        place = [pose.position.x, pose.position.y, pose.position.z]
        turn = [pose.orientation.w, pose.orientation.x, pose.orientation.y, pose.orientation.z]
        demand(math.dist(place, state["position_um"]) < 1e-5, f"{device} has its part elsewhere at {state['t_ns']} ns")
        demand(math.dist(turn, state["orientation"]) < 1e-7, f"{device} has turned its part otherwise at {state['t_ns']} ns")
    bends = {t for channel in schedule.channels if channel.startswith(f"{device}.") for t in schedule.ends(channel)}
    for t_ns, transforms in frames:
        demand(body.frame_id in transforms, f"/tf lacks the part of {device}")
        for finger in range(len(states[0]["grasp"])):
            name = f"{device}/finger/f{finger + 1}"
            at = transforms[name].translation
            demand(scene[name].frame_id == name and len(scene[name].spheres) == 1, f"{device} draws no tip {name}")
            for axis in "xyz":
                off = abs(getattr(at, axis) - schedule.value(f"{device}.f{finger + 1}.{axis}", t_ns))
                demand(off < 1e-5 or t_ns not in bends, f"{name} is {off} um off along {axis} at {t_ns} ns")
    grasps = topics[f"/{device}/state"][1]
    for state in states:
        words = {e.texts[0].text for t, m in grasps if t == state["t_ns"] for e in m.entities if e.id == f"{device}/grasp"}
        wanted = f"grasp ({', '.join(map(str, state['grasp']))}) in {state['plane']} at angle {state['angle_index']}"
        demand(wanted in words, f"/{device}/state says {words} at {state['t_ns']} ns")
    demand(topics[f"/{device}/plan"][1] and topics[f"/{device}/scene/points"][1], f"{device} shows no ways or no points")


def provenance(attachments, metadata, schedule):
    demand(attachments["schedule.json"] == schedule.bytes, "the attached schedule is not the JSON file")
    demand("claims.json" in attachments, "the claims are not attached")
    source = schedule.document["source"]
    text = attachments.get(f"source/{source['file']}")
    demand(text is not None, "the program's source is not attached")
    demand(hashlib.sha256(text).hexdigest() == source["sha256"], "the attached source is another")
    demand(metadata["tweeze"].keys() >= {"version", "schema", "program", "settings", "scale"}, "the metadata lack an entry")
    demand(metadata["tweeze"]["program"] == schedule.document["name"], "the metadata name another program")
