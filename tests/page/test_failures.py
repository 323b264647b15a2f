"""Pages of programs that cannot be built, in a real browser: each error at its line, and at its place in the scene.

`TWEEZE_FAILURES` names a folder of pages; `CHROMIUM` the browser, if it is not on the path.
"""

import json
import os
import re
from pathlib import Path

import pytest
from opened import opened

PAGES = sorted(Path(os.environ.get("TWEEZE_FAILURES", "out/failures")).glob("**/*.failed.html"))
WINDOWS = [(1280, 720), (1920, 1080), (800, 900)]


@pytest.fixture(scope="module", params=PAGES, ids=lambda path: path.name.removesuffix(".failed.html"))
def page(browser, request):
    with opened(browser, request.param, WINDOWS[0]) as page:
        yield page


def findings(page, severity):
    return [finding for finding in page.data["failure"]["findings"] if finding["severity"] == severity]


def test_there_are_enough_pages():
    assert len(PAGES) >= 10, "TWEEZE_FAILURES names a folder of pages of failed builds"


def test_data_has_its_schema(page):
    import jsonschema

    schema = json.loads((Path(__file__).parents[2] / "schema" / "page.schema.json").read_text())
    jsonschema.Draft202012Validator(schema).validate(page.data)


def test_it_says_at_once_that_nothing_was_built(page):
    errors = len(findings(page, "error"))
    assert errors > 0
    assert page.locator("#verdict").text_content() == f"✗ not built: {errors} error{'' if errors == 1 else 's'}"
    assert page.locator("#claims .card.error").count() == errors
    first = page.locator("#claims .card").first.text_content()
    assert findings(page, "error")[0]["code"] in first and findings(page, "error")[0]["title"] in first


def test_each_finding_stands_at_its_line(page):
    names = [source["name"] for source in page.data["sources"]]
    for finding in page.data["failure"]["findings"]:
        for nth, label in enumerate(finding["labels"]):
            if label["file"] not in names:
                continue
            row = page.locator("ol.code").nth(names.index(label["file"])).locator("li").nth(label["line"] - 1)
            assert (finding["severity"] if nth == 0 else "related") in row.get_attribute("class").split()
            assert (label["text"] or finding["title"]) in row.locator(".note").all_text_contents()


def test_marks_leave_the_text_of_the_program_as_it_is(page):
    texts = page.evaluate(
        """() => [...document.querySelectorAll("ol.code")].map((code) => [...code.children].map((row) => {
          const bare = row.cloneNode(true);
          bare.querySelectorAll(".note").forEach((note) => note.remove());
          return bare.textContent;
        }))"""
    )
    for text, source in zip(texts, page.data["sources"], strict=True):
        assert text == source["text"].removesuffix("\n").replace("\r\n", "\n").split("\n")


def test_what_is_underlined_is_what_the_error_points_to(page):
    for finding in findings(page, "error"):
        for label in finding["labels"][:1]:
            source = next((one for one in page.data["sources"] if one["name"] == label["file"]), None)
            if source is None or label["line"] != label["end_line"]:
                continue
            line = source["text"].split("\n")[label["line"] - 1]
            wanted = line[label["column"] - 1 : label["end_column"] - 1].strip()
            row = page.locator("ol.code").nth(page.data["sources"].index(source)).locator("li").nth(label["line"] - 1)
            assert wanted in "".join(row.locator(".fault").all_text_contents()), line


def test_places_are_marked_in_the_window(page):
    marked = page.evaluate(
        """() => tweeze.views.flatMap((view) => view.faults.map(({ at, words }) => {
          const [x, y] = view.pen.at(at);
          return { words, isInside: x > 0 && y > 0 && x < view.canvas.clientWidth && y < view.canvas.clientHeight };
        }))"""
    )
    assert all(mark["isInside"] for mark in marked), marked
    kinds = {plan["kind"] for plan in (page.data["schedule"] or {"plans": []})["plans"]}
    if any(place["device"] is None for place in page.data["failure"]["places"]) and kinds and kinds != {"fingers"}:
        assert marked


def test_what_a_proof_has_reached_is_shaded(page):
    errors_first = sorted(page.data["failure"]["findings"], key=lambda finding: finding["severity"] == "warning")
    reaches = [reach for finding in errors_first for reach in finding.get("reaches", [])]
    shown = page.locator("#claims .reached").all_text_contents()
    assert shown == [reach_text(reach) for reach in reaches]
    # Each run of reached cells is drawn, within the view of its device.
    for reach in (reach for reach in reaches if "runs" in reach):
        drawn = page.evaluate(
            """(name) => {
              const view = tweeze.views.find((view) => view.devices.some((device) => device.name === name));
              if (!view) return null;
              const device = view.devices.find((device) => device.name === name);
              return device.reaches.filter(({ runs }) => runs).map(({ runs, edges }) => ({ runs, edges: edges.length,
                seen: runs.every(([row, first]) => { const [x, y] = view.pen.at(view.spot({ unit: "cells", at: [first, row], device: name })); return x >= 0 && y >= 0 && x <= view.canvas.clientWidth && y <= view.canvas.clientHeight; }) }));
            }""",
            reach["device"],
        )
        if drawn is None:
            continue  # the page does not show the device's schedule
        assert reach["runs"] in [one["runs"] for one in drawn]
        assert all(one["edges"] >= 4 and one["seen"] for one in drawn)


def data_of(path):
    return json.loads(re.search(r'<script[^>]*id="data"[^>]*>(.*?)</script>', path.read_text(), re.DOTALL)[1])


def reach_text(reach):
    what = reach["what"]
    if "runs" in reach:
        cells = sum(last - first + 1 for _, first, last in reach["runs"])
        return f"reached by {what}: {cells} cell{'' if cells == 1 else 's'}"
    if "plane" in reach:
        axis = {"xy": "z", "xz": "y"}[reach["plane"]]
        return f"{what} turns {reach['reached_deg']:g} of {reach['asked_deg']:g} deg about {axis}"
    x, y, _ = reach["pose"]
    return f"{what} comes to ({x:g}, {y:g}) um"


@pytest.mark.parametrize("extent, least", [("runs", 5), ("plane", 1), ("pose", 1)])
def test_some_failures_say_how_far_the_search_came(extent, least):
    failures = [data_of(path)["failure"] for path in PAGES]
    reaches = [reach for failure in failures for finding in failure["findings"] for reach in finding.get("reaches", [])]
    assert sum(extent in reach for reach in reaches) >= least


def test_parts_that_block_each_other_have_their_own_colours(page):
    shared = page.evaluate("tweeze.model.devices.flatMap((device) => device.reaches.filter(({ isShared }) => isShared).map(({ what }) => what))")
    swatches = page.evaluate("[...document.querySelectorAll('#claims .reached .swatch')].map((swatch) => getComputedStyle(swatch).borderTopColor)")
    assert not shared or len(set(swatches)) >= len(set(shared))


def test_nothing_in_a_card_is_cut_off(page):
    wide = page.evaluate("[...document.querySelectorAll('#claims .card')].filter((card) => card.scrollWidth > card.clientWidth).map((card) => card.textContent)")
    assert wide == []


def test_a_click_on_a_finding_leads_to_its_line(page):
    for at in range(page.locator("#claims .card .jump").count()):
        page.locator("#claims .card .jump").nth(at).click()
    assert page.locator("ol.code:visible").count() == 1


@pytest.mark.parametrize("size", WINDOWS, ids=lambda size: f"{size[0]}x{size[1]}")
def test_everything_fits_the_window(page, size):
    page.set_viewport_size({"width": size[0], "height": size[1]})
    assert page.evaluate("document.documentElement.scrollWidth <= innerWidth")
    is_still = page.evaluate("tweeze.model.duration_ns === 0")
    assert page.locator("#controls").is_visible() != is_still
    page.set_viewport_size({"width": WINDOWS[0][0], "height": WINDOWS[0][1]})


def test_a_list_of_many_findings_leaves_the_scene_its_room(page):
    stage, head = page.locator("#stage").bounding_box(), page.locator("header").bounding_box()
    assert stage["width"] > 500 and stage["height"] > 250 and stage["y"] >= head["height"] - 1
