"""Pictures that `--emit svg` writes, in a real browser: they open from disk, and no text overlaps another or leaves the picture.

`TWEEZE_PICTURES` names a folder of pictures; `CHROMIUM` the browser, if it is not on the path.
"""

import os
from pathlib import Path

import pytest

PICTURES = sorted(Path(os.environ.get("TWEEZE_PICTURES", "out/pictures")).glob("**/*.svg"))

# Each text with the bounding box that the browser gives it.
TEXTS = """() => [...document.querySelectorAll("text")].map((text) => {
  const { x, y, width, height } = text.getBBox();
  return [text.textContent, x, y, x + width, y + height];
})"""


def test_there_are_pictures():
    assert PICTURES, "TWEEZE_PICTURES names a folder without pictures"


def test_every_picture_is_small():
    sizes = {path.name: path.stat().st_size for path in PICTURES}
    assert max(sizes.values()) < 2_000_000, sizes


@pytest.mark.parametrize("path", PICTURES, ids=lambda path: f"{path.parent.name}/{path.stem}")
def test_texts_are_apart_and_inside(browser, path):
    page = browser.new_page()
    asked = []
    page.on("request", lambda sent: asked.append(sent.url))
    page.goto(path.resolve().as_uri())
    assert asked == [path.resolve().as_uri()]
    width, height = page.evaluate("[document.documentElement.viewBox.baseVal.width, document.documentElement.viewBox.baseVal.height]")
    texts = page.evaluate(TEXTS)
    page.close()
    assert texts
    for index, (one, left, top, right, bottom) in enumerate(texts):
        assert 0 <= left and right <= width and 0 <= top and bottom <= height, one
        for other, left_of, top_of, right_of, bottom_of in texts[index + 1 :]:
            apart = right <= left_of or right_of <= left or bottom <= top_of or bottom_of <= top
            assert apart, (one, other)
