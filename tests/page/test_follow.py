"""A page that is open in a real browser while its program is rebuilt repeatedly.

`TWEEZE` names the program; `CHROMIUM` the browser, if it is not on the path.
"""

import os
import subprocess
from pathlib import Path

TWEEZE = Path(os.environ.get("TWEEZE", "target/debug/tweeze")).resolve()
GOOD = "use std.dimibot\ndevice bot : dimibot.femto_st\ntask go on bot { move to (1, 1) }\n"


def build(watched):
    """Reads the output lines of the next build."""
    lines = []
    for line in watched.stdout:
        lines.append(line)
        if "Watching" in line:
            return lines
    raise AssertionError(f"it has ended after {lines}")


def test_the_open_page_is_that_of_the_latest_build(browser, tmp_path):
    program = tmp_path / "bot.twz"
    program.write_text(GOOD)
    command = [TWEEZE, "view", program, "-o", tmp_path, "--no-open", "--watch"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as watched:
        try:
            build(watched)
            page = browser.new_page()
            page.goto((tmp_path / "go.html").as_uri())
            assert page.locator("#verdict").text_content() == "✓ verified"
            # An error: the page of the failure replaces it.
            program.write_text(GOOD.replace("(1, 1)", "(99, 1)"))
            build(watched)
            page.wait_for_url("**/bot.failed.html")
            page.locator("#claims .card.error").first.wait_for()
            # Fixed and changed: the page of the new schedule appears.
            program.write_text(GOOD.replace("(1, 1)", "(2, 3)"))
            build(watched)
            page.wait_for_url("**/go.html")
            page.locator("#program", has_text="(2, 3)").wait_for()
            # Another goal, the same page: it is reloaded.
            program.write_text(GOOD.replace("(1, 1)", "(4, 5)"))
            build(watched)
            page.locator("#program", has_text="(4, 5)").wait_for()
            # No change: the page is not reloaded.
            page.evaluate("window.stays = true")
            page.wait_for_timeout(1500)
            assert page.evaluate("window.stays")
            page.close()
        finally:
            watched.kill()
