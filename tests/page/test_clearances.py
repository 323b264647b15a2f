"""The tightest clearances on pages: confirmed by independent geometry, drawn where they occur, and reached by a click.

`TWEEZE_PAGES` names a folder of pages; `CHROMIUM` the browser, if it is not on the path.
"""

import json
import math
import re
from pathlib import Path

import gaps
import pytest
from opened import PAGES, WINDOWS

SAMPLES = 400


def runs(page, device):
    pairs = zip(page.data["schedule"]["plans"], page.data["claims"]["jobs"], strict=True)
    return [(plan, job["order"][plan["kind"]]) for plan, job in pairs if plan["device"] == device]


def clearances(page, *codes):
    return [found for found in page.data["evidence"]["clearances"] if found["code"] in codes]


def test_points_are_as_far_apart_as_the_gap_says(page):
    for found in page.data["evidence"]["clearances"]:
        one, other = found["points"]
        if found["unit"] == "um":
            assert math.isclose(math.dist(one, other), found["gap"], rel_tol=1e-6, abs_tol=1e-6), found
        else:
            assert max(abs(a - b) for a, b in zip(one, other, strict=True)) == found["gap"], found
        # Pieces of a strict rule lie above the limit by more than nothing.
        assert found["gap"] >= found["needed"] - 1e-6 or found["code"] == "E0760", found


def test_each_device_has_its_least_gap(page):
    known = {(found["device"], found["code"]) for found in page.data["evidence"]["clearances"]}
    for device, kind in {(plan["device"], plan["kind"]) for plan in page.data["schedule"]["plans"]}:
        plans = runs(page, device)
        match kind:
            case "dimibot":
                has_solids = any("solid" in obstacle["body"] for _, order in plans for obstacle in order["obstacles"])
                assert ((device, "E0727") in known) == has_solids
            case "electrode_array":
                if any(len(state["parts"]) > 1 for plan, _ in plans for state in plan["states"]):
                    assert (device, "E0734") in known
            case "microrobots":
                assert (device, "E0747") in known or all(len(order["robots"]) < 2 for _, order in plans)
            case "fingers":
                assert (device, "E0760") in known


def test_nothing_comes_nearer(page):
    for found in clearances(page, "E0727"):
        by_name = [gaps.of_tip(plan, order) for plan, order in runs(page, found["device"])]
        if None not in by_name:
            least = min(gap for own in by_name for gap in own.values())
            assert math.isclose(found["gap"], least, rel_tol=1e-6, abs_tol=1e-6), found
            assert any(math.isclose(own[found["between"][1]], least, rel_tol=1e-6) for own in by_name)
    for found in clearances(page, "E0734"):
        own = [gaps.of_parts(plan, order) for plan, order in runs(page, found["device"])]
        is_with_stuck = found["between"][1] not in runs(page, found["device"])[0][0]["states"][0]["parts"]
        if None not in own and not is_with_stuck:
            assert found["gap"] == min(own), found
    for found in clearances(page, "E0760"):
        facts = runs(page, found["device"])[0][1]["facts"]
        least = gaps.of_fingers(page.data["schedule"], found["device"], facts)
        assert math.isclose(found["gap"], least, rel_tol=1e-6, abs_tol=1e-6), found


# For each instant, the corners of all robots of a bed, and whether each is driven then.
ROBOTS = """([name, instants]) => {
  const device = tweeze.model.devices.find((device) => device.name === name);
  return instants.map((t_ns) => robotsAt(device, t_ns).map(({ facts, pose, isDriven, isDocked }) =>
    ({ name: facts.name, corners: bodyPoints(facts, pose), isDriven: Boolean(isDriven) && !isDocked })));
}"""


def test_robots_come_no_nearer_to_obstacles(page):
    duration_ns = page.data["schedule"]["duration_ns"]
    for found in clearances(page, "E0746"):
        obstacles = runs(page, found["device"])[0][1]["obstacles"]
        solids = {obstacle["name"]: gaps.solid(obstacle) for obstacle in obstacles}
        instants = [duration_ns * part // SAMPLES for part in range(SAMPLES)]
        *moments, shown = page.evaluate(ROBOTS, [found["device"], [*instants, found["t_ns"]]])
        for robots in moments:
            for robot in robots:
                if robot["isDriven"]:
                    least = min(gaps.apart(robot["corners"], corners) - radius for corners, radius in solids.values())
                    assert least >= found["gap"] - found["within"] - 1e-3, found
        near = next(robot for robot in shown if robot["name"] == found["between"][0])
        corners, radius = solids[found["between"][1]]
        assert abs(gaps.apart(near["corners"], corners) - radius - found["gap"]) < 0.01, found


def test_two_robots_are_as_near_as_it_says(page):
    for found in clearances(page, "E0747"):
        [robots] = page.evaluate(ROBOTS, [found["device"], [found["t_ns"]]])
        corners = {robot["name"]: robot["corners"] for robot in robots}
        assert abs(gaps.apart(*(corners[name] for name in found["between"])) - found["gap"]) < 0.01, found


def test_two_tips_of_a_scene_are_as_near_as_it_says(page):
    for found in clearances(page, "E0770"):
        one, other = (point[:2] for point in found["points"])
        for name, point, beyond in zip(found["between"], (one, other), (other, one), strict=True):
            radius = runs(page, name)[0][1]["facts"]["tip_radius_um"]
            centre = [a + (a - b) * radius / found["gap"] for a, b in zip(point, beyond, strict=True)]
            # Where both tips move, each may be anywhere along its move during the pulse: to its next position or from its last one.
            near = [gaps.point_apart(centre, way) for way in gaps.ways(runs(page, name), found["t_ns"])]
            assert min(near) < 1e-6, found


@pytest.mark.parametrize("size", WINDOWS, ids=lambda size: f"{size[0]}x{size[1]}")
def test_a_click_draws_the_ruler_there(page, size):
    page.set_viewport_size({"width": size[0], "height": size[1]})
    buttons = page.locator(".clearances .jump")
    assert buttons.count() == len(page.data["evidence"]["clearances"])
    for at, found in enumerate(page.data["evidence"]["clearances"]):
        page.evaluate("tweeze.seek(0)")
        buttons.nth(at).click()
        assert page.evaluate("tweeze.t_ns") == found["t_ns"]
        texts = page.evaluate(
            """(found) => tweeze.views.filter((view) => view.devices.some(({ name }) => name === found.device)).map((view) => {
              const { ruled } = view;
              const boxes = ruled.texts.map((text) => [text.words, ...boxOfText(ruled.g, text)]);
              const marks = found.points.map((point) => ruled.at(view.seen ? view.seen(point) : point));
              const { x, y, width, height } = ruled.box;
              return { boxes, marks, box: [x, y, x + width, y + height] };
            })""",
            found,
        )
        [view] = texts
        words, left, top, right, bottom = view["boxes"][-1]
        assert words == page.evaluate("(found) => gapText(found.gap, found.unit)", found)
        west, north, east, south = view["box"]
        assert west <= left and right <= east and north <= top and bottom <= south, found
        assert all(west <= x <= east and north <= y <= south for x, y in view["marks"]), found
        # Names clipped by a loupe do not matter; only those inside it must not overlap the label.
        for other, *corners in view["boxes"][:-1]:
            is_inside = west <= corners[0] and corners[2] <= east and north <= corners[1] and corners[3] <= south
            is_apart = right <= corners[0] or corners[2] <= left or bottom <= corners[1] or corners[3] <= top
            assert is_apart or not is_inside, (words, other)
        if found["code"] == "E0760":
            # The view of a hand is turned so that the gap is seen in its full length.
            seen = page.evaluate("({ points }) => points.map((point) => tweeze.views.find((view) => view.face).seen(point))", found)
            assert math.isclose(math.dist(*(place[:2] for place in seen)), found["gap"], rel_tol=1e-6), found
        # The ruler is gone at another instant.
        page.keyboard.press("End" if found["t_ns"] == 0 else "Home")
        assert page.evaluate("tweeze.views.every(({ ruled }) => ruled === null)")
    page.set_viewport_size({"width": WINDOWS[0][0], "height": WINDOWS[0][1]})


def test_together_the_pages_ask_every_rule():
    """Except the rules for recordings, which no page shows; a rule that no page checks would be missing here."""
    text = (Path(__file__).parents[2] / "src" / "verify" / "catalogue.rs").read_text()
    rules = set(re.findall(r'^    \w+ (E07\d\d) "', text, re.MULTILINE))
    pages = (re.search(r'id="data">(.*?)</script>', path.read_text(), re.DOTALL)[1] for path in PAGES)
    asked = {rule["code"] for page in pages for rule in json.loads(page)["evidence"]["rules"]}
    assert len(rules) > 60 and rules - asked == {"E0763", "E0764", "E0765"}


def test_forces_are_such_as_friction_and_adhesion_bear(page):
    forces = page.evaluate(
        """() => tweeze.views.filter((view) => view.turnable).flatMap((view) => view.devices[0].runs.flatMap((run) =>
          run.plan.states.flatMap(({ t_ns, plane }) => {
            const [device] = view.devices;
            if (runAt(device, t_ns) !== run) return [];
            const { order } = run;
            const section = order.part[plane].outline;
            const points = outlinePoints(section, 2000).map(([u, v]) => (plane === "xy" ? [u, v, 0] : [u, 0, v]));
            const cones = conesOf(order, partAt(device, t_ns), { plane, points }, tipsAt(device, t_ns));
            const forces = forcesAt(device, t_ns);
            return forces ? cones.map(([finger, [apex, left, right]]) => {
              const axis = apex.map((value, at) => (left[at] + right[at]) / 2 - value);
              const dot = axis.reduce((sum, value, at) => sum + value * forces[finger][at], 0);
              const force = Math.hypot(...forces[finger]);
              const normal = dot / Math.hypot(...axis);
              const { adhesion, pull_off_un, friction, max_force_un } = order.facts;
              return { normal, along: Math.sqrt(Math.max(0, force * force - normal * normal)), sticking: adhesion === "sticking" ? pull_off_un : 0, friction, most: max_force_un };
            }) : [];
          })))"""
    )
    kinds = {plan["kind"] for plan in page.data["schedule"]["plans"]}
    assert bool(forces) == ("fingers" in kinds)
    for force in forces:
        # Where a tip sticks, friction counts from the pull-off force. The drawn outline is a polygon, hence the tolerance.
        pressed = force["normal"] + force["sticking"]
        assert -0.01 <= pressed <= force["most"] + force["sticking"] + 0.01, force
        assert force["along"] <= force["friction"] * pressed + 0.02 * (1 + force["normal"]), force


def test_rules_and_their_counts(page):
    rules = page.data["evidence"]["rules"]
    assert page.locator("details.rules .claim.rule").count() == len(rules) > 15
    first = page.locator("details.rules .claim.rule").first.text_content()
    assert first == rules[0]["says"] + f"{rules[0]['times']:,}"
    times = {rule["code"]: rule["times"] for rule in rules}
    schedule = page.data["schedule"]
    assert times["E0701"] == 2 * len(schedule["actuations"]) + len(schedule["steps"])
    assert times["E0704"] == len(schedule["actuations"])
    assert times["E0714"] == sum(len(plan["states"]) for plan in schedule["plans"])
