"""The sender of stage positions, on simulated controllers: what it sends and prints, and that stages are stopped whatever happens."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

import gcs_controller
import stages_judge

FIXTURES = Path(os.environ.get("TWEEZE_FIXTURES", "/nonexistent")) / "controllers"

pytestmark = pytest.mark.skipif(not FIXTURES.exists(), reason="TWEEZE_FIXTURES names no folder")


def controllers(**facts):
    """Three controllers, and the arguments that give their addresses to the sender."""
    boards = [gcs_controller.GcsController(**facts) for _ in range(3)]
    return boards, [f"pi{number}={board.address}" for number, board in enumerate(boards, 1)]


def moves(board):
    return any(line.startswith("WGO") for line in board.lines)


def test_every_command_asks_for_its_error_and_nothing_moves_before_all_is_loaded():
    boards, addresses = controllers()
    status, words, _ = stages_judge.run(FIXTURES / "pi.stages.py", addresses)
    assert status == 0 and "played" in words, words
    for board in boards:
        commands = [line for line in board.lines if not line.split()[0].endswith("?")]
        asked = [after for line, after in zip(board.lines, board.lines[1:]) if line in commands]
        assert commands and set(asked) == {"ERR?"}
        assert max(len(line.split()) for line in board.lines) <= 12, "a line of more than ten arguments"


@pytest.mark.parametrize("refuse", ["SVO", "MOV", "WAV 2", "WSL", "WTR", "WGO"])
def test_what_a_controller_refuses_ends_it_and_all_are_stopped(refuse):
    boards, addresses = controllers(refuse=refuse)
    status, words, _ = stages_judge.run(FIXTURES / "pi.stages.py", addresses)
    assert status == 1 and f"error 17 after `{refuse}" in words and "stages hold where they are" in words, words
    assert all(board.stops == 1 for board in boards)


def test_tables_that_are_too_short_are_noticed():
    boards, addresses = controllers(table_points=50)
    status, words, _ = stages_judge.run(FIXTURES / "pi.stages.py", addresses)
    assert status == 1 and "error 17 after `WAV" in words, words
    assert not any(moves(board) for board in boards)


def test_another_travel_or_servo_cycle_is_noticed_before_anything_moves(monkeypatch):
    for name, value, said in [("TRAVEL_UM", (0.0, 10.0), "axis 1 goes from 0.0 um to 10.0 um"), ("SERVO_CYCLE_S", 1e-4, "servo cycle is 0.0001 s")]:
        with monkeypatch.context() as patched:
            patched.setattr(gcs_controller, name, value)
            boards, addresses = controllers()
            status, words, _ = stages_judge.run(FIXTURES / "pi.stages.py", addresses)
            assert status == 1 and said in words, words
            assert not any(line.startswith(("SVO", "MOV")) for board in boards for line in board.lines)


def test_ctrl_c_stops_every_stage():
    boards, addresses = controllers(is_busy=True)
    process = subprocess.Popen(
        [sys.executable, str(FIXTURES / "pi.stages.py"), *addresses],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        # A script that runs these tests in the background ignores the signal, and child processes inherit that.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    while not all(moves(board) for board in boards):
        time.sleep(0.01)
    time.sleep(0.1)
    process.send_signal(signal.SIGINT)
    words, _ = process.communicate(timeout=30)
    assert process.returncode == 130 and "stages hold where they are" in words, words
    assert all(board.stops == 1 for board in boards)


@pytest.mark.parametrize("fault", [{"STANDIN_FAULT": "StreamFrame"}, {"STANDIN_INTERRUPT": "StreamFrame"}, {"STANDIN_FAULT": "Move"}])
def test_a_stream_that_breaks_is_aborted_and_every_channel_stopped(fault):
    status, words, calls = stages_judge.run(FIXTURES / "smaract.stages.py", ["pi1=network:sn:MCS2-1"], **fault)
    assert status == (130 if "STANDIN_INTERRUPT" in fault else 1) and "stages hold where they are" in words, words
    names = [call[0] for call in calls]
    assert ("AbortStream" in names) == ("OpenStream" in names)
    assert sorted(call[1] for call in calls if call[0] == "Stop") == list(range(9))
    assert names[-1] == "Close"


def test_every_channel_is_stopped_even_if_the_stream_cannot_be_aborted():
    fault = {"STANDIN_FAULT": "StreamFrame,AbortStream"}
    status, words, calls = stages_judge.run(FIXTURES / "smaract.stages.py", ["pi1=network:sn:MCS2-1"], **fault)
    assert status == 1 and "network:sn:MCS2-1 may still move (the stream (AbortStream failed" in words, words
    assert sorted(call[1] for call in calls if call[0] == "Stop") == list(range(9))
    assert calls[-1][0] == "Close"


def test_a_sender_of_places_says_what_it_would_do():
    for option in ("--list", "--dry-run"):
        status, words, calls = stages_judge.run(FIXTURES / "smaract.stages.py", [option])
        assert status == 0 and "points of 0.001 s" in words and not calls, words
    assert stages_judge.run(FIXTURES / "pi.stages.py", [])[0] == 2
    assert stages_judge.run(FIXTURES / "pi.stages.py", ["ip1=127.0.0.1"])[0] == 2
    status, words, _ = stages_judge.run(FIXTURES / "pi.stages.py", [f"pi{number}=127.0.0.1:1" for number in (1, 2, 3)])
    assert status == 1 and "Traceback" not in words, words
