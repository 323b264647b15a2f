"""SVG, read by Python's XML parser: a self-contained picture whose marks are where the schedule has them."""

import re
from xml.etree import ElementTree

from verdict import demand

SVG = "{http://www.w3.org/2000/svg}"
ALLOWED = {"svg", "title", "g", "path", "rect", "circle", "text", "clipPath"}

# Least width of a letter and height above the baseline, as fractions of the font size.
NARROW, HIGH = 0.28, 0.7

WITHIN_UM = 1e-3
WITHIN_PT = 2e-3


def judge(path, schedule):
    root = ElementTree.fromstring(path.read_bytes())
    demand(root.tag == f"{SVG}svg", "the root is no svg")
    demand(int(root.get("data-duration-ns")) == schedule.duration_ns, "the duration is another")
    stands_alone(root)
    texts = fits(root)
    marks = [mark for scene in root.iter(f"{SVG}g") if scene.get("class") == "scene" for mark in marks_of(scene)]
    plans = {}
    for plan in schedule.document["plans"]:
        plans.setdefault(plan["device"], []).append(plan)
    for device, own in plans.items():
        own.sort(key=lambda plan: plan["start_ns"])
        moved = [mark for mark in marks if mark[2].get("data-device") == device]
        demand(moved, f"{device} is not drawn")
        for scene, t_ns, mark in moved:
            held_against(own, schedule, scene, t_ns, mark)
        ends(own, [t_ns for _, t_ns, _ in moved])
    return f"{len(marks)} marks are where the schedule has them, {texts} texts inside"


def stands_alone(root):
    for element in root.iter():
        name = element.tag.removeprefix(SVG)
        demand(name in ALLOWED, f"it has a <{name}>")
        for key, value in element.attrib.items():
            demand("href" not in key and not key.startswith("on"), f"it has an attribute {key}")
            if not key.startswith("data-"):
                demand(re.fullmatch(r"url\(#clip\d+\)", value) or "url" not in value, f"{key} refers to {value}")
        width = element.get("stroke-width")
        demand(width is None or float(width) >= 0.35, f"a line is {width} pt thin")


def fits(root):
    """Checks that every text lies within the picture, given the least width that it can have; returns the number of texts."""
    left, top, width, height = map(float, root.get("viewBox").split())
    demand(left == top == 0 and root.get("width") in ("85mm", "175mm"), "the picture fits no column")
    demand(abs(width / 72 * 25.4 - float(root.get("width")[:-2])) < 1e-2, "a unit is no point")
    texts = list(root.iter(f"{SVG}text"))
    for text in texts:
        x, y, size = (float(text.get(key)) for key in ("x", "y", "font-size"))
        demand(7 <= size <= 9, f"a text of {size} pt")
        least = NARROW * size * len(text.text)
        start = {"middle": x - least / 2, "end": x - least}.get(text.get("text-anchor"), x)
        demand(0 <= start and start + least <= width, f"`{text.text}` leaves the picture")
        demand(0 <= y - HIGH * size and y <= height, f"`{text.text}` leaves the picture")
    return len(texts)


def marks_of(scene):
    """Yields the marks of a scene that show a state, as (scene, instant in ns, mark)."""
    for mark in scene.iter():
        for t_ns in (mark.get("data-t-ns") or "").split():
            yield scene, int(t_ns), mark


def state_at(plans, t_ns):
    begun = [plan for plan in plans if plan["start_ns"] <= t_ns] or plans[:1]
    states = begun[-1]["states"]
    return ([state for state in states if state["t_ns"] <= t_ns] or states[:1])[-1]


def near(found, expected, what):
    demand(len(found) == len(expected), f"{what} has {len(found)} numbers")
    off = max(abs(a - b) for a, b in zip(found, expected))
    demand(off <= WITHIN_UM, f"{what} is drawn at {found}, not {expected}")


def numbers(mark, *names):
    return [float(mark.get(f"data-{name}")) for name in names]


def held_against(plans, schedule, scene, t_ns, mark):
    state, device = state_at(plans, t_ns), plans[0]["device"]
    what = f"{device} at {t_ns} ns"
    match plans[0]["kind"]:
        case "dimibot":
            place = numbers(mark, "x-um", "y-um")
            near(place, on_its_way(plans, state, t_ns, place), what)
            on_paper(scene, mark, placed(place, mark.get("data-frame")), what)
        case "electrode_array":
            cell = numbers(mark, "column", "row")
            near(cell, state["parts"][mark.get("data-part")], what)
            on_paper(scene, mark, [number - 1 for number in cell], what)
        case "microrobots":
            pose = state["poses"][mark.get("data-robot")]
            x, y = pose["x_um"], pose["y_um"]
            near(numbers(mark, "x-um", "y-um"), [x, y], what)
            turn = numbers(mark, "heading-deg")[0] - pose["heading_deg"]
            demand(abs((turn + 180) % 360 - 180) < WITHIN_UM, f"{what} is turned by {turn} deg more")
            on_paper(scene, mark, [x, y], what)
        case "fingers":
            found = numbers(mark, "x-um", "y-um", "z-um")
            if finger := mark.get("data-finger"):
                near(found, [schedule.value(f"{device}.f{finger}.{axis}", t_ns) for axis in "xyz"], what)
            else:
                near(found, state["position_um"], what)
                near([float(part) for part in mark.get("data-orientation").split()], state["orientation"], what)


def on_its_way(plans, state, t_ns, place):
    """The expected position: that of the state or, at an instant between two states, the point nearest to `place` on the way to the next.

    A robot is drawn between two of its states where another robot has a state.
    """
    states = [state for plan in plans for state in plan["states"]]
    following = [other for other in states if other["t_ns"] > t_ns]
    here = state["position_um"]
    if not following or any(other["t_ns"] == t_ns for other in states):
        return here
    way = [to - of for to, of in zip(following[0]["position_um"], here)]
    length = sum(part * part for part in way)
    share = sum(part * (of - start) for part, of, start in zip(way, place, here)) / length if length else 0.0
    return [start + part * min(1.0, max(0.0, share)) for start, part in zip(here, way)]


def placed(place, frame):
    """Converts a position from a robot's own frame to the scene."""
    if not frame:
        return place
    from math import cos, sin

    x, y, heading = map(float, frame.split())
    return [x + place[0] * cos(heading) - place[1] * sin(heading), y + place[0] * sin(heading) + place[1] * cos(heading)]


def on_paper(scene, mark, place, what):
    """Checks that the centre of a mark is where the scale of its scene puts the position."""
    scale, left, base = numbers(scene, "scale", "left", "base")
    expected = [left + scale * place[0], base - scale * place[1]]
    if mark.tag == f"{SVG}circle":
        found = [float(mark.get("cx")), float(mark.get("cy"))]
    elif mark.tag == f"{SVG}rect":
        x, y, width, height = (float(mark.get(key)) for key in ("x", "y", "width", "height"))
        found = [x + width / 2, y + height / 2]
    else:
        corners = [float(number) for number in re.findall(r"-?[\d.]+", mark.get("d"))]
        found = [sum(corners[axis::2]) / len(corners[axis::2]) for axis in (0, 1)]
    off = max(abs(a - b) for a, b in zip(found, expected))
    demand(off <= WITHIN_PT, f"{what} is drawn at {found} pt, not {expected} pt")


def ends(plans, drawn_ns):
    """Checks that the first and the last state are drawn, at their own instant or at another one with an equal state."""
    for t_ns in (plans[0]["states"][0]["t_ns"], plans[-1]["states"][-1]["t_ns"]):
        without_time = {key: value for key, value in state_at(plans, t_ns).items() if key in KEPT}
        if without_time.get("parts") == {}:
            # All parts have left the board.
            continue
        seen = any({key: value for key, value in state_at(plans, other).items() if key in KEPT} == without_time for other in drawn_ns)
        demand(seen, f"the state at {t_ns} ns is not drawn")


# Visible fields of a state.
KEPT = ("position_um", "parts", "poses", "orientation")
