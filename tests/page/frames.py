"""Measures the work per frame of pages, in milliseconds: `python frames.py PAGE...`. Not a test, because times depend on the machine."""

import os
import shutil
import statistics
import sys
from pathlib import Path

from playwright.sync_api import sync_playwright

FRAMES = 200

DRAW = """(frames) => {
  const times = [];
  for (let frame = 0; frame < frames; frame += 1) {
    const before = performance.now();
    tweeze.t_ns = (tweeze.model.duration_ns * frame) / frames;
    tweeze.draw();
    tweeze.stage.querySelectorAll("canvas").forEach((canvas) => canvas.getContext("2d").getImageData(0, 0, 1, 1));
    times.push(performance.now() - before);
  }
  return times;
}"""

with sync_playwright() as playwright:
    path = os.environ.get("CHROMIUM") or shutil.which("chromium")
    browser = playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])
    for name in sys.argv[1:]:
        page = browser.new_page(viewport={"width": 1920, "height": 1080})
        page.goto(Path(name).resolve().as_uri())
        times = sorted(page.evaluate(DRAW, FRAMES))
        actuations = page.evaluate("tweeze.model.schedule.actuations.length")
        print(f"{Path(name).stem}: {actuations} actuations, median {statistics.median(times):.1f} ms, p95 {times[int(0.95 * FRAMES)]:.1f} ms")
    browser.close()
