"""A log as Rerun shows it: its own reader converts the log to what its views draw, which must move as the log says.

Rerun does not draw `SceneUpdate`. Its 3D view shows point clouds in transform frames, so every frame that moves must have a cloud, and
not all instants may look the same.
"""

import numpy
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory
from rerun.chunk import McapReader

from verdict import demand

# Instants compared with the first.
LOOKS = 20
# Relative tolerance: Rerun may store positions in single precision.
ROUNDING = 1e-5


def judge(path, schedule):
    frames, clouds = drawn(path)
    told = transforms(path)
    demand(set(frames) == set(told), f"Rerun has the frames {sorted(frames)}, the log {sorted(told)}")
    moving = set()
    for frame, (times, places) in told.items():
        own_times, own_places = frames[frame]
        demand(numpy.array_equal(own_times, times), f"Rerun moves {frame} at other times")
        off = numpy.abs(own_places - places)
        demand((off <= ROUNDING * (1 + numpy.abs(places))).all(), f"Rerun has {frame} elsewhere, by {off.max()}")
        if len(numpy.unique(places, axis=0)) > 1:
            moving.add(frame)
    without = sorted(frame for frame in moving if not clouds.get(frame))
    demand(not without, f"{without} move, and Rerun draws nothing there")
    if not moving:
        return "nothing moves, for Rerun either"
    first = view(frames, 0)
    instants = numpy.linspace(0, schedule.duration_ns, LOOKS + 1)[1:]
    others = sum(not numpy.array_equal(view(frames, instant), first) for instant in instants)
    demand(others, "two instants look the same for Rerun")
    return f"{len(moving)} frames move with their clouds; {others} of {LOOKS} instants are unlike the first for Rerun"


def drawn(path):
    """Reads a log as Rerun does: the times and poses of each frame, and the most points of a cloud in each frame."""
    frames, clouds = {}, {}
    for chunk in McapReader(path, timeline_type="duration_ns").stream():
        batch = chunk.to_record_batch()
        names = set(batch.schema.names)
        if "Transform3D:translation" in names:
            times = batch.column("message_log_time").cast("int64").to_pylist()
            # Each row is an array with one component.
            columns = (batch.column(f"Transform3D:{name}").to_pylist() for name in ("child_frame", "translation", "quaternion"))
            for t_ns, child, place, turn in zip(times, *columns):
                if child and place and turn:
                    frames.setdefault(child[0], []).append((t_ns, (*place[0], *turn[0])))
        if "Points3D:positions" in names:
            for frame, points in zip(batch.column("CoordinateFrame:frame").to_pylist(), batch.column("Points3D:positions").to_pylist()):
                if frame and points:
                    clouds[frame[0]] = max(clouds.get(frame[0], 0), len(points))
    return {frame: in_order(rows) for frame, rows in frames.items()}, clouds


def in_order(rows):
    rows.sort(key=lambda row: row[0])
    return numpy.array([t_ns for t_ns, _ in rows]), numpy.array([place for _, place in rows], dtype=float)


def transforms(path):
    """The times and poses of each frame, by the reference MCAP reader."""
    frames = {}
    with open(path, "rb") as file:
        for _, channel, message, proto in make_reader(file, decoder_factories=[DecoderFactory()]).iter_decoded_messages(topics=["/tf"]):
            for one in proto.transforms:
                place, turn = one.translation, one.rotation
                pose = (place.x, place.y, place.z, turn.x, turn.y, turn.z, turn.w)
                frames.setdefault(one.child_frame_id, []).append((message.log_time, pose))
    return {frame: in_order(rows) for frame, rows in frames.items()}


def view(frames, t_ns):
    """The pose of every frame at an instant: the last one published by then, or the first."""
    latest = []
    for times, places in (frames[frame] for frame in sorted(frames)):
        latest.append(places[max(0, numpy.searchsorted(times, t_ns, side="right") - 1)])
    return numpy.array(latest)
