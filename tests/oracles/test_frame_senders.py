"""The sender of frames, on simulated boards: what reaches them, when, and in what state they are left.

The OpenDrop is a pseudo-terminal with a thread that handles its bytes as the board's firmware does; the PurpleDrop is a JSON-RPC server;
the DropBot is a stand-in for its package. The fixtures' times are stretched so that a busy machine can keep them.
"""

import csv
import http.server
import json
import os
import pty
import shutil
import signal
import subprocess
import sys
import threading
import time
import tty
from pathlib import Path

import pytest

import frames_judge

FIXTURES = Path(os.environ.get("TWEEZE_FIXTURES", "/nonexistent"))
STRETCH = 10

pytestmark = pytest.mark.skipif(not FIXTURES.exists(), reason="TWEEZE_FIXTURES names no folder")


class OpendropOnATerminal:
    """A board that reads frames of 32 bytes and answers each with 24 bytes, unless it is mute."""

    def __init__(self, mute_after=None):
        self.ours, theirs = pty.openpty()
        tty.setraw(self.ours)
        tty.setraw(theirs)
        self.address, self.frames, self.mute_after = os.ttyname(theirs), [], mute_after
        threading.Thread(target=self.run, daemon=True).start()

    def run(self):
        data = b""
        while True:
            try:
                data += os.read(self.ours, 256)
            except OSError:
                return
            while len(data) >= 32:
                self.frames.append((time.monotonic(), frames_judge.opendrop(data[:32])))
                data = data[32:]
                if self.mute_after is None or len(self.frames) <= self.mute_after:
                    os.write(self.ours, bytes(24))


class PurpledropServer:
    """A server that answers `set_electrode_pins`; a call with other parameters is an error, as with the real server."""

    def __init__(self, refuse=None):
        self.frames, outer = [], self

        class Handler(http.server.BaseHTTPRequestHandler):
            def do_POST(self):
                call = json.loads(self.rfile.read(int(self.headers["Content-Length"])))
                (pins,) = call["params"]
                is_right = self.path == "/rpc" and call["jsonrpc"] == "2.0" and call["method"] == "set_electrode_pins"
                is_right = is_right and all(isinstance(pin, int) and 0 <= pin < 128 for pin in pins)
                outer.frames.append((time.monotonic(), set(pins)))
                if is_right and len(outer.frames) != refuse:
                    answer = {"jsonrpc": "2.0", "result": None, "id": call["id"]}
                else:
                    answer = {"jsonrpc": "2.0", "error": {"code": -32000, "message": "not connected"}, "id": call["id"]}
                body = json.dumps(answer).encode()
                self.send_response(200)
                self.send_header("Content-Length", str(len(body)))
                self.end_headers()
                self.wfile.write(body)

            def log_message(self, *_):
                pass

        self.server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
        self.address = f"127.0.0.1:{self.server.server_address[1]}"
        threading.Thread(target=self.server.serve_forever, daemon=True).start()


def stretched(folder, stem):
    """Copies a fixture with longer frames; returns its sender and the times at which channels are due."""
    for file in (FIXTURES / "drivers").glob(f"{stem}.*"):
        shutil.copy(file, folder)
    table = folder / f"{stem}.driver.frames.csv"
    with open(table, newline="") as file:
        title, *rows = csv.reader(file)
    rows = [[row[0], str(float(row[1]) * STRETCH), str(float(row[2]) * STRETCH), *row[3:]] for row in rows]
    with open(table, "w", newline="") as file:
        csv.writer(file).writerows([title, *rows])
    program = folder / f"{stem}.frames.py"
    text = program.read_text()
    last = float(rows[-1][1]) + float(rows[-1][2])
    assert f'"duration_s": {last / STRETCH / 1e3:g}' in text
    program.write_text(text.replace(f'"duration_s": {last / STRETCH / 1e3:g}', f'"duration_s": {last / 1e3:g}'))
    accessories = [set(row[4].split()) if len(row) > 4 else set() for row in rows]
    return program, [(float(row[1]) / 1e3, {int(number) for number in row[3].split()} | more) for row, more in zip(rows, accessories)]


def run(program, *arguments):
    ended = subprocess.run([sys.executable, str(program), *arguments], capture_output=True, text=True, timeout=60)
    return ended.returncode, ended.stdout + ended.stderr


def boards():
    pytest.importorskip("serial")
    return [("od", OpendropOnATerminal), ("pd", PurpledropServer), ("lift", OpendropOnATerminal)]


@pytest.mark.parametrize("which", [0, 1, 2])
def test_each_frame_arrives_when_it_is_due_and_all_is_off_at_the_end(tmp_path, which):
    stem, make = boards()[which]
    board = make()
    program, due = stretched(tmp_path, stem)
    status, words = run(program, f"driver={board.address}")
    assert status == 0 and "all electrodes are off" in words, words
    assert [on for _, on in board.frames] == [set(), *(on for _, on in due), set()]
    begin = board.frames[1][0] - due[0][0]
    late = [at - begin - start for (at, _), (start, _) in zip(board.frames[1:-1], due, strict=True)]
    assert max(map(abs, late)) < 0.1, late


@pytest.mark.parametrize("which,fault", [(0, {"mute_after": 3}), (1, {"refuse": 3})])
def test_a_board_that_does_not_answer_ends_it(tmp_path, which, fault):
    stem, make = boards()[which]
    board = make(**fault)
    program, due = stretched(tmp_path, stem)
    status, words = run(program, f"driver={board.address}")
    assert status == 1 and ("answered 0 of 24 bytes" in words or "not connected" in words), words
    assert board.frames[-1][1] == set() and len(board.frames) < len(due), "the last that is tried is to switch off"


def test_ctrl_c_switches_off(tmp_path):
    board = PurpledropServer()
    program, due = stretched(tmp_path, "pd")
    process = subprocess.Popen(
        [sys.executable, str(program), f"driver={board.address}"],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        # A script that runs these tests in the background ignores the signal, and child processes inherit that.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    while len(board.frames) < 3:
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    words, _ = process.communicate(timeout=30)
    assert process.returncode == 130 and "all electrodes are off" in words, words
    assert board.frames[-1][1] == set() and len(board.frames) < len(due) + 2


def test_a_sender_of_frames_says_what_it_would_do(tmp_path):
    program, due = stretched(tmp_path, "od")
    for option in ("--list", "--dry-run"):
        status, words = run(program, option)
        assert status == 0 and f"{len(due)} frames" in words and "od.driver.frames.csv" in words, words
    assert run(program, "drivre=/dev/null")[0] == 2
    status, words = run(program, "driver=/dev/tweeze-is-not-there")
    assert status == 1 and "Traceback" not in words, words


STAND_IN = Path(__file__).resolve().parent / "standins"


def run_dropbot(program, log, *arguments, **environment):
    environment = {**os.environ, "PYTHONPATH": str(STAND_IN), "STANDIN_LOG": str(log), **environment}
    ended = subprocess.run([sys.executable, str(program), *arguments], capture_output=True, text=True, timeout=60, env=environment)
    calls = [json.loads(line) for line in log.read_text().splitlines()] if log.exists() else []
    return ended.returncode, ended.stdout + ended.stderr, calls


def test_a_dropbot_is_set_and_shows_each_frame_when_it_is_due(tmp_path):
    pytest.importorskip("numpy")
    program, due = stretched(tmp_path, "db")
    status, words, calls = run_dropbot(program, tmp_path / "log", "driver=/dev/board")
    assert status == 0 and "all electrodes are off" in words, words
    names = [name for _, name, _ in calls]
    assert calls[0][1:] == ["port", "/dev/board"] and names[-1] == "terminate" and calls[-2][1:] == ["hv_output_enabled", False]
    # All electrodes are off when the voltage is switched on.
    first = names.index("hv_output_enabled")
    assert [call[1:] for call in calls[1:first + 1]] == [
        ["state_of_channels", []], ["voltage", 100.0], ["frequency", 10000.0], ["hv_output_selected", True], ["hv_output_enabled", True],
    ]
    shown = [(at, set(on)) for at, name, on in calls[first:] if name == "state_of_channels"]
    assert [on for _, on in shown] == [set(), *(on for _, on in due), set()]
    late = [at - shown[1][0] + due[0][0] - start for (at, _), (start, _) in zip(shown[1:-1], due, strict=True)]
    assert max(map(abs, late)) < 0.1, late


def test_a_dropbot_that_does_not_answer_is_switched_off(tmp_path):
    pytest.importorskip("numpy")
    program, _ = stretched(tmp_path, "db")
    status, words, calls = run_dropbot(program, tmp_path / "log", STANDIN_FAULT="4")
    assert status == 1 and "does not answer" in words and "Traceback" not in words, words
    assert calls[0][2] is None, "its package looks for the port"
    assert [call[1:] for call in calls[-3:]] == [["state_of_channels", []], ["hv_output_enabled", False], ["terminate", None]]


def test_a_board_that_is_lost_leaves_none_of_the_others_on(tmp_path):
    pytest.importorskip("numpy")
    program, _ = stretched(tmp_path, "db")
    head, plays = program.read_text().split("PLAYS = json.loads(r'''", 1)
    plays, tail = plays.split("''')", 1)
    plays = json.loads(plays)
    plays["drivers"].append(plays["drivers"][0] | {"name": "second"})
    program.write_text(f"{head}PLAYS = json.loads(r'''{json.dumps(plays)}'''){tail}")
    status, words, _ = run_dropbot(program, tmp_path / "log", "driver=/dev/one", "second=/dev/two", STANDIN_LOST="4")
    assert status == 1 and "/dev/one may still be on (the board is lost)" in words and "Traceback" not in words, words
    calls = [json.loads(line)[1:] for line in (tmp_path / "log.2").read_text().splitlines()]
    assert calls[-3:] == [["state_of_channels", []], ["hv_output_enabled", False], ["terminate", None]]


def test_without_the_package_of_the_dropbot_the_sender_says_so(tmp_path):
    program, _ = stretched(tmp_path, "db")
    status, words = run(program)
    assert status == 1 and "`dropbot` is not installed" in words and "Traceback" not in words, words
