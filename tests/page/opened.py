"""Pages in a browser, opened from disk."""

import json
import os
from contextlib import contextmanager
from pathlib import Path

PAGES = sorted(Path(os.environ.get("TWEEZE_PAGES", "out/pages")).glob("**/*.html"))
WINDOWS = [(1280, 720), (1920, 1080)]


def name_of(path):
    """The test ID of a page; it includes the folder because programs of different examples may share a name."""
    return f"{path.parent.name}/{path.stem}"


@contextmanager
def opened(browser, path, size):
    """Opens a page and parses its `data`. It must request nothing but files and log no error or warning to its console."""
    page = browser.new_page(viewport={"width": size[0], "height": size[1]})
    errors = []
    page.on("console", lambda message: errors.append(message.text) if message.type in ("error", "warning") else None)
    page.on("pageerror", lambda error: errors.append(str(error)))
    page.on("request", lambda sent: errors.append(sent.url) if not sent.url.startswith("file:") else None)
    page.goto(path.resolve().as_uri())
    page.data = json.loads(page.locator("#data").text_content())
    yield page
    assert errors == []
    page.close()
