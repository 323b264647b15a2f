"""The pages in Firefox: they open from disk without an error, and show what they show in Chromium.

`TWEEZE_PAGES` names a folder of pages; `FIREFOX` and `CHROMIUM` the browsers, if they are not on the path.
"""

import math

import pytest
from firefox import Firefox
from opened import PAGES, name_of

SHARES = [0, 0.13, 0.5, 0.77]
SIZE = {"width": 1280, "height": 720}

# What the page shows at some instants, and as a whole.
SHOWN = """(shares) => {
  const moments = shares.map((share) => {
    const t_ns = Math.round(tweeze.model.duration_ns * share);
    tweeze.seek(t_ns, false);
    const states = tweeze.model.devices.map((device) => {
      switch (device.kind) {
        case "dimibot": return tipAt(device, t_ns);
        case "electrode_array": return Object.entries(partsAt(device, t_ns)).flat(2);
        case "microrobots": return robotsAt(device, t_ns).flatMap(({ name, pose, isDown, isDocked }) => [name, ...pose, isDown, isDocked]);
        case "fingers": { const { place, turn } = partAt(device, t_ns); return [...place, ...turn, ...tipsAt(device, t_ns).flatMap((tip) => tip.place)]; }
        default: throw new Error(device.kind);
      }
    });
    const now = [...document.querySelectorAll(".code li.now")].map((row) => row.textContent);
    const clock = document.getElementById("clock").textContent;
    // How much of each picture is not empty.
    const inked = [...document.querySelectorAll("canvas")].map((canvas) => {
      const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
      let count = 0;
      for (let at = 3; at < data.length; at += 4) count += data[at] > 0;
      return count / (data.length / 4);
    });
    return { states, now, clock, inked };
  });
  const fits = document.documentElement.scrollWidth <= innerWidth && document.documentElement.scrollHeight <= innerHeight;
  return { moments, fits, claims: document.getElementById("claims").textContent, title: document.title };
}"""


@pytest.fixture(scope="module")
def firefox():
    firefox = Firefox()
    firefox.resize(**SIZE)
    yield firefox
    firefox.close()


def flat(value):
    return [leaf for part in value for leaf in flat(part)] if isinstance(value, list) else [value]


def assert_same(one, other):
    """Compares with a tolerance, because the engines may round sines and cosines differently in the last digit."""
    for first, second in zip(flat(one), flat(other), strict=True):
        if isinstance(first, float) or isinstance(second, float):
            assert math.isclose(first, second, rel_tol=1e-9, abs_tol=1e-6)
        else:
            assert first == second


def test_there_are_pages():
    assert PAGES, "TWEEZE_PAGES names a folder without pages"


# All pages share one script, so every third page suffices.
@pytest.mark.parametrize("path", PAGES[::3], ids=name_of)
def test_it_is_the_same_page_as_in_chromium(firefox, browser, path):
    url = path.resolve().as_uri()
    page = browser.new_page(viewport=SIZE)
    page.goto(url)
    expected = page.evaluate(SHOWN, SHARES)
    page.close()
    firefox.open(url)
    found = firefox.evaluate(SHOWN, SHARES)
    assert firefox.logged == []
    for key in ("fits", "claims", "title"):
        assert found[key] == expected[key]
    for ours, theirs in zip(found["moments"], expected["moments"], strict=True):
        assert (ours["now"], ours["clock"]) == (theirs["now"], theirs["clock"])
        assert_same(ours["states"], theirs["states"])
        # Browsers render text differently.
        assert all(abs(one - other) < 0.02 for one, other in zip(ours["inked"], theirs["inked"], strict=True))
        assert max(ours["inked"]) > 0.01


def test_errors_are_heard(firefox, tmp_path):
    page = tmp_path / "broken.html"
    page.write_text("<!doctype html><script>console.error('one'); missing();</script>")
    firefox.open(page.as_uri())
    firefox.evaluate("() => 0", None)
    assert len(firefox.logged) == 2 and "one" in firefox.logged
