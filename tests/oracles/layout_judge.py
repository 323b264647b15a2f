"""The layout beside a log: every topic, field and frame that it names is in the log, and its cameras see the scenes."""

import json
import math
import struct

from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

from verdict import Skipped, demand


def judge(path, schedule):
    log = path.with_name(path.name.removesuffix(".lichtblick.json") + ".mcap")
    if not log.exists():
        raise Skipped(f"{log.name} is not there")
    layout = json.loads(path.read_text("utf-8"))
    topics = {}
    with open(log, "rb") as file:
        for _, channel, _, proto in make_reader(file, decoder_factories=[DecoderFactory()]).iter_decoded_messages():
            topics.setdefault(channel.topic, []).append(proto)
    frames = {f.child_frame_id for proto in topics["/tf"] for f in proto.transforms}
    panels = layout["configById"]
    placed = set(leaves(layout["layout"]))
    demand(placed == set(panels), f"these are no panels, or are not placed: {sorted(placed ^ set(panels))}")
    lines = 0
    for name, panel in panels.items():
        match name.split("!")[0]:
            case "3D":
                demand(panel["topics"] and set(panel["topics"]) <= topics.keys(), f"{name} shows {sorted(panel['topics'])}")
                demand(panel["followTf"] in frames, f"{name} follows {panel['followTf']}")
                sees(name, panel, topics)
            case "Plot":
                for line in panel["paths"]:
                    topic, _, field = line["value"].partition(".")
                    value = topics[topic][0]
                    demand(topic in topics and isinstance(number(value, field), float), f"{line['value']} is no number")
                lines += len(panel["paths"])
            case "RosOut":
                demand(panel["topicToRender"] in topics, "the log is not there")
            case other:
                demand(False, f"a panel is of the kind {other}")
    devices = {plan["device"] for plan in schedule.document["plans"]}
    followed = {panel.get("followTf") for panel in panels.values()}
    demand(len(devices) > 4 or devices <= followed, f"no panel shows {devices - followed}")
    return f"{len(panels)} panels with {lines} lines find their topics in {log.name}, and see the scenes"


def leaves(tree):
    if isinstance(tree, str):
        return [tree]
    return leaves(tree["first"]) + leaves(tree["second"])


def number(proto, field):
    name, _, index = field.partition("[")
    value = getattr(proto, name)
    return value[int(index.rstrip("]"))] if index else value


def sees(name, panel, topics):
    """Checks that the camera, looking down, sees every point of the scene and the plan that is given in the device's frame."""
    camera, frame = panel["cameraState"], panel["followTf"]
    half = camera["distance"] * math.tan(math.radians(camera["fovy"] / 2))
    for topic in (f"/{frame}/scene/points", f"/{frame}/plan/points"):
        for cloud in topics.get(topic, []):
            if cloud.frame_id != frame:
                continue
            for x, y, _ in struct.iter_unpack("<fff4x", cloud.data):
                off = max(abs(x - camera["targetOffset"][0]), abs(y - camera["targetOffset"][1]))
                demand(off <= half, f"{name} does not see ({x}, {y}), but {half} from {camera['targetOffset']}")
    demand(camera["near"] < camera["distance"] < camera["far"], f"{name} looks past its scene")
