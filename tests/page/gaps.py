"""Least gaps of schedules, computed from the data of a page alone and independently of the verifier and of the page's script."""

import itertools
import math


def apart(one, other):
    """Distance between two disjoint bodies, each a list of corners in order: the least over all pairs of sides."""
    return min(sides_apart(a, b) for a in sides(one) for b in sides(other))


def sides(corners):
    return list(zip(corners, corners[1:] + corners[:1], strict=True))


def sides_apart(one, other):
    ends = [(point, other) for point in one] + [(point, one) for point in other]
    return min(point_apart(point, side) for point, side in ends)


def point_apart(point, side):
    start, end = side
    way = [b - a for a, b in zip(start, end, strict=True)]
    square = sum(value * value for value in way)
    share = sum((p - a) * w for p, a, w in zip(point, start, way, strict=True)) / square if square else 0
    share = min(1, max(0, share))
    return math.dist(point, [a + share * w for a, w in zip(start, way, strict=True)])


def solid(body):
    """The corners of an obstacle in the scene, and the radius around them, in um."""
    shape, pose = body["shape"], body["pose"]
    name = shape if isinstance(shape, str) else next(iter(shape))
    figures = {} if isinstance(shape, str) else shape[name]
    match name:
        case "point" | "disc":
            corners = [[0, 0]]
        case "capsule":
            corners = [[-figures["length_um"] / 2, 0], [figures["length_um"] / 2, 0]]
        case "box":
            a, b = (size / 2 for size in figures["size_um"])
            corners = [[-a, -b], [a, -b], [a, b], [-a, b]]
        case "polygon":
            corners = figures["points_um"]
    return [placed(pose, corner) for corner in corners], figures.get("radius_um", 0)


def placed(pose, place):
    if pose is None:
        return list(place)
    cos, sin = math.cos(pose["heading_rad"]), math.sin(pose["heading_rad"])
    return [pose["x_um"] + place[0] * cos - place[1] * sin, pose["y_um"] + place[0] * sin + place[1] * cos]


def of_tip(plan, order):
    """The least gap between the tip and each obstacle, in um, by obstacle name; None if several modules ever move at once."""
    states = plan["states"]
    ways = list(itertools.pairwise(states)) or [(states[0], states[0])]
    if any(bin(one["word"] ^ other["word"]).count("1") > 1 for one, other in ways):
        return None
    radius = order["facts"]["tip_radius_um"]
    gaps = {}
    for obstacle in order["obstacles"]:
        if "solid" in obstacle["body"]:
            corners, round_um = solid(obstacle["body"]["solid"])
            tips = ([placed(order.get("frame"), state["position_um"]) for state in way] for way in ways)
            gaps[obstacle["name"]] = min(apart(corners, tip) for tip in tips) - round_um - radius
    return gaps


def ways(runs, t_ns):
    """The moves of a tip around an instant: the current one, the one before and the one after, each as (start, end)."""
    [(plan, order)] = [(plan, order) for plan, order in runs if plan["start_ns"] <= t_ns <= plan["start_ns"] + plan["duration_ns"]][-1:]
    places = [placed(order.get("frame"), state["position_um"]) for state in plan["states"]]
    at = sum(state["t_ns"] <= t_ns for state in plan["states"])
    return [places[max(0, nth) : nth + 2] for nth in (at - 2, at - 1, at) if len(places[max(0, nth) : nth + 2]) == 2]


def of_parts(plan, order):
    """The least gap between two parts, in electrodes; None if parts merge, split or come in during the plan, which brings them together."""
    actions = [step["action"] for step in order["steps"]]
    works = [work for action in actions if not isinstance(action, str) for work in action.get("move", []) + action.get("assay", [])]
    if any(work.get("with") is not None or work.get("splits") or work.get("comes") for work in works):
        return None
    least = math.inf
    states = [state["parts"] for state in plan["states"]]
    for here, there in itertools.pairwise(states + states[-1:]):
        ways = [(place, there.get(name, place)) for name, place in here.items()]
        for one, other in itertools.combinations(ways, 2):
            least = min(least, max(ranges_apart(axis, one, other) for axis in (0, 1)))
    return least


def ranges_apart(axis, one, other):
    [low, high], [other_low, other_high] = (sorted(place[axis] for place in way) for way in (one, other))
    return max(0, other_low - high, low - other_high)


def of_fingers(schedule, device, facts):
    """The least gap between two tips of a hand, in um; tips move straight between the instants at which any axis starts or ends a move."""
    channels = [channel["name"] for channel in schedule["channels"]]
    lines = {name: [] for name in channels if name.startswith(f"{device}.f")}
    for actuation in schedule["actuations"]:
        name = channels[actuation["channel"]]
        if name in lines:
            lines[name].append(actuation)
    instants = sorted({t for own in lines.values() for line in own for t in (line["start_ns"], line["start_ns"] + line["duration_ns"])})
    tracks = {name: [value(own, t) for t in instants] for name, own in lines.items()}
    fingers = range(1, facts["fingers"] + 1)
    tips = {finger: list(zip(*(tracks[f"{device}.f{finger}.{axis}"] for axis in "xyz"), strict=True)) for finger in fingers}
    least = math.inf
    for one, other in itertools.combinations(fingers, 2):
        between = [[a - b for a, b in zip(p, q, strict=True)] for p, q in zip(tips[one], tips[other], strict=True)]
        for way in itertools.pairwise(between):
            least = min(least, point_apart([0, 0, 0], way))
    return least - 2 * facts["tip_radius_um"]


def value(lines, t_ns):
    for line in lines:
        if t_ns <= line["start_ns"] + line["duration_ns"]:
            share = max(0, t_ns - line["start_ns"]) / line["duration_ns"]
            return line["from"] + (line["to"] - line["from"]) * share
    return lines[-1]["to"]
