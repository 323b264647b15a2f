"""The browser shared by all tests of pages and pictures; `CHROMIUM` names it if it is not on the path."""

import os
import shutil

import pytest
from opened import PAGES, WINDOWS, name_of, opened
from playwright.sync_api import sync_playwright


@pytest.fixture(scope="session")
def browser():
    path = os.environ.get("CHROMIUM") or shutil.which("chromium") or shutil.which("google-chrome")
    assert path, "a Chromium is needed: name it by CHROMIUM"
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])
        yield browser
        browser.close()


# Each page is opened once for all tests, so each test must leave the window as it was.
@pytest.fixture(scope="session", params=PAGES, ids=name_of)
def page(browser, request):
    with opened(browser, request.param, WINDOWS[0]) as page:
        yield page
