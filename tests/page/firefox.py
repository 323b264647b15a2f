"""A headless Firefox, driven by WebDriver BiDi, which Firefox speaks without a separate driver."""

import itertools
import json
import os
import re
import shutil
import subprocess
import tempfile
import threading
from contextlib import ExitStack

from websockets.sync.client import connect

LIMIT_S = 60


class Firefox:
    def __init__(self):
        path = os.environ.get("FIREFOX") or shutil.which("firefox-esr") or shutil.which("firefox")
        assert path, "a Firefox is needed: name it by FIREFOX"
        self.profile = tempfile.mkdtemp(prefix="tweeze-firefox-")
        command = [path, "--headless", "--no-remote", "--profile", self.profile, "--remote-debugging-port", "0"]
        # Its own HOME keeps it from using the user's settings.
        self.process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, env={**os.environ, "HOME": self.profile})
        place = self.listening()
        # Later output must be read, or Firefox blocks when the pipe is full.
        threading.Thread(target=self.process.stderr.read, daemon=True).start()
        self.open_things = ExitStack()
        self.socket = self.open_things.enter_context(connect(f"{place}/session", max_size=None, open_timeout=LIMIT_S))
        self.numbers = itertools.count(1)
        self.logged = []
        self.ask("session.new", capabilities={})
        self.ask("session.subscribe", events=["log.entryAdded", "network.beforeRequestSent"])
        self.context = self.ask("browsingContext.getTree")["contexts"][0]["context"]

    def listening(self):
        for line in self.process.stderr:
            found = re.search(r"WebDriver BiDi listening on (ws://\S+)", line)
            if found:
                return found[1]
        raise AssertionError(f"Firefox ended with {self.process.wait()}")

    def ask(self, method, **params):
        number = next(self.numbers)
        self.socket.send(json.dumps({"id": number, "method": method, "params": params}))
        while True:
            answer = json.loads(self.socket.recv(timeout=LIMIT_S))
            if answer.get("id") == number:
                assert answer["type"] == "success", answer
                return answer["result"]
            self.hear(answer)

    def hear(self, event):
        """Logs errors and warnings of the page, and requests to anything but files and data URLs."""
        params = event["params"]
        if event["method"] == "log.entryAdded" and params["level"] in ("error", "warn"):
            self.logged.append(params["text"])
        if event["method"] == "network.beforeRequestSent" and not params["request"]["url"].startswith(("file:", "data:")):
            self.logged.append(params["request"]["url"])

    def resize(self, width, height):
        self.ask("browsingContext.setViewport", context=self.context, viewport={"width": width, "height": height}, devicePixelRatio=1)

    def open(self, url):
        self.logged.clear()
        self.ask("browsingContext.navigate", context=self.context, url=url, wait="complete")

    def evaluate(self, function, argument):
        """Calls a JavaScript function in the page; argument and result pass as JSON."""
        call = f"JSON.stringify(({function})({json.dumps(argument)}))"
        answer = self.ask("script.evaluate", expression=call, target={"context": self.context}, awaitPromise=True)
        assert answer["type"] == "success", answer
        return json.loads(answer["result"]["value"])

    def close(self):
        self.open_things.close()
        self.process.terminate()
        self.process.wait(LIMIT_S)
        shutil.rmtree(self.profile, ignore_errors=True)
