"""Pages that `--emit html` writes, in a real browser: they open from disk, play, and show the states of their schedules.

`TWEEZE_PAGES` names a folder of pages; `CHROMIUM` the browser, if it is not on the path.
"""

import json
import math
import re
from pathlib import Path

import pytest
from opened import PAGES, WINDOWS

INSTANTS = 25


def now(page):
    return page.evaluate("tweeze.t_ns")


def test_there_are_pages():
    assert PAGES, "TWEEZE_PAGES names a folder without pages"


def test_every_page_is_small():
    sizes = {path.name: path.stat().st_size for path in PAGES}
    assert max(sizes.values()) < 1_000_000, sizes


def shown(page, plan, instants):
    """What the page draws of a plan's device at each instant, as a flat list of numbers; None for a device placed by a frame."""
    return page.evaluate(
        """([name, instants]) => {
          const device = tweeze.model.devices.find((device) => device.name === name);
          return instants.map((t_ns) => {
            const run = runAt(device, t_ns);
            tweeze.seek(t_ns);
            switch (device.kind) {
              case "dimibot": return run.order.frame ? null : tipAt(device, t_ns);
              case "electrode_array": return Object.entries(partsAt(device, t_ns)).sort().flatMap(([, place]) => place);
              case "microrobots": return robotsAt(device, t_ns).flatMap(({ pose }) => pose.slice(0, 2));
              case "fingers": { const { place, turn } = partAt(device, t_ns); return [...place, ...turn]; }
            }
          });
        }""",
        [plan["device"], instants],
    )


def recorded(plan, state):
    match plan["kind"]:
        case "dimibot":
            return state["position_um"]
        case "electrode_array":
            return [number for _, place in sorted(state["parts"].items()) for number in place]
        case "microrobots":
            return None  # its order is that of the scene; see below
        case "fingers":
            return state["position_um"] + state["orientation"]


def test_the_page_shows_the_states_of_the_schedule(page):
    schedule = page.data["schedule"]
    for plan, job in zip(schedule["plans"], page.data["claims"]["jobs"], strict=True):
        states = [state for state in plan["states"] if plan["start_ns"] <= state["t_ns"]]
        last = {state["t_ns"]: state for state in states}
        following = [other["start_ns"] for other in schedule["plans"] if other["device"] == plan["device"]]
        # Instants at which another run of the device has begun are left out.
        instants = [t_ns for t_ns in sorted(last) if not any(plan["start_ns"] < start_ns <= t_ns for start_ns in following)]
        instants = instants[:: max(1, len(instants) // INSTANTS)]
        for t_ns, found in zip(instants, shown(page, plan, instants), strict=True):
            expected = recorded(plan, last[t_ns])
            if plan["kind"] == "microrobots":
                facts = job["order"]["microrobots"]
                names = [facts["facts"]["robots"][robot["row"]]["name"] for robot in facts["robots"]]
                expected = [last[t_ns]["poses"][name][key] for name in names for key in ("x_um", "y_um")]
            if found is None:
                continue  # placed by a frame, so drawn in the coordinates of the scene
            assert math.dist(found, expected) < 1e-6, (plan["task"], t_ns)


def test_between_states_things_move_to_the_next_one(page):
    """A nanosecond before a state, everything is at its position but for the motion of that nanosecond."""
    for plan in page.data["schedule"]["plans"]:
        if plan["kind"] == "microrobots":
            continue
        states = [state for state in plan["states"][1:INSTANTS] if state["t_ns"] > 0]
        for state, found in zip(states, shown(page, plan, [state["t_ns"] - 1 for state in states]), strict=True):
            expected = recorded(plan, state)
            if found is not None and len(found) == len(expected) and plan["start_ns"] < state["t_ns"]:
                assert math.dist(found, expected) < 1e-3 or plan["kind"] == "fingers", (plan["task"], state["t_ns"])


def test_lines_claims_links_and_keys_lead_to_their_instants(page):
    steps = page.data["schedule"]["steps"]
    page.evaluate("tweeze.seek(tweeze.model.duration_ns)")
    first = min(steps, key=lambda step: step["start_ns"])
    row = page.locator("ol.code:visible li.step").first
    if row.count():
        row.click()
        assert now(page) in {step["start_ns"] for step in steps}
    page.locator("#claims .jump").first.click()
    assert now(page) == min(plan["start_ns"] for plan in page.data["schedule"]["plans"][:1])
    page.keyboard.press("End")
    assert now(page) == page.data["schedule"]["duration_ns"]
    page.keyboard.press("Home")
    assert now(page) == 0 <= first["start_ns"]
    page.keyboard.press("ArrowRight")
    after = now(page)
    assert after > 0
    page.keyboard.press("ArrowLeft")
    assert now(page) == 0
    page.evaluate(f"location.hash = '#t={after / 1e9}'")
    page.wait_for_function(f"tweeze.t_ns === {after}")


def test_it_plays_and_stops(page):
    page.evaluate("tweeze.seek(0)")
    page.select_option("#speed", label=page.locator("#speed option").first.text_content())
    page.locator("#play").click()
    page.wait_for_function("tweeze.t_ns > 0")
    page.locator("#play").click()
    stopped = now(page)
    page.wait_for_timeout(60)
    assert now(page) == stopped


@pytest.mark.parametrize("size", WINDOWS, ids=lambda size: f"{size[0]}x{size[1]}")
def test_everything_fits_the_window(page, size):
    page.set_viewport_size({"width": size[0], "height": size[1]})
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    assert page.evaluate("document.documentElement.scrollHeight <= innerHeight")
    boxes = [page.locator(f"#{name}").bounding_box() for name in ("program", "stage", "claims", "controls", "timeline")]
    for index, one in enumerate(boxes):
        assert one["width"] > 100 and one["height"] > 20
        for other in boxes[index + 1 :]:
            apart_x = one["x"] + one["width"] <= other["x"] + 1 or other["x"] + other["width"] <= one["x"] + 1
            apart_y = one["y"] + one["height"] <= other["y"] + 1 or other["y"] + other["height"] <= one["y"] + 1
            assert apart_x or apart_y
    page.set_viewport_size({"width": WINDOWS[0][0], "height": WINDOWS[0][1]})


def test_every_channel_that_does_something_has_its_row(page):
    """The ladder counts as the row of a bed's only channel."""
    missing = page.evaluate(
        """tweeze.model.channels.filter(({ name, device, actuations }) => actuations.length && !tweeze.timeline.rows.some(
            (row) => (row.channel && row.channel.name === name) || (row.kind === "ladder" && row.device.name === device))).map(({ name }) => name)"""
    )
    assert missing == []


def test_dark_and_light(page):
    before = page.evaluate("getComputedStyle(document.body).backgroundColor")
    page.locator("#theme").click()
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") != before


def test_data_has_its_schema(page):
    import jsonschema

    schema = json.loads((Path(__file__).parents[2] / "schema" / "page.schema.json").read_text())
    jsonschema.Draft202012Validator(schema).validate(page.data)
    assert not re.search("<", page.locator("#data").inner_html())
