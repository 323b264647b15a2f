"""The sender of SCPI scripts, on a stand-in for PyVISA: what reaches the instruments, and in what state they are left."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import scpi_judge

FIXTURES = Path(os.environ.get("TWEEZE_FIXTURES", "/nonexistent"))
STAND_IN = Path(__file__).resolve().parent / "standins"

pytestmark = pytest.mark.skipif(not FIXTURES.exists(), reason="TWEEZE_FIXTURES names no folder")


def sent(tmp_path, arguments, **environment):
    """Runs the sender; returns its exit status, its output, and the messages that the instruments received."""
    log = tmp_path / "sent.jsonl"
    environment = os.environ | {"PYTHONPATH": str(STAND_IN), "STANDIN_LOG": str(log)} | environment
    command = [sys.executable, str(FIXTURES / "Pair.scpi.py"), *arguments]
    run = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=60)
    lines = [json.loads(line) for line in log.read_text().splitlines()] if log.exists() else []
    return run.returncode, run.stdout + run.stderr, [message.encode("latin-1") for _, message in lines]


def outputs():
    return len(json.loads((FIXTURES / "Pair.json").read_text())["channels"])


def switched_off(messages):
    return messages[-outputs():] == [f":OUTP{number} OFF".encode() for number in range(1, outputs() + 1)]


def test_every_message_arrives_and_all_is_off_at_the_end(tmp_path):
    status, words, messages = sent(tmp_path, ["awg=TCPIP0::a::INSTR"])
    assert status == 0 and "played" in words, words
    script = scpi_judge.messages((FIXTURES / "Pair.awg.scpi").read_bytes())
    assert messages[: -outputs()] == [message for message in script if not message.endswith(b"?")]
    assert switched_off(messages)


def test_a_dry_run_starts_nothing(tmp_path):
    status, words, messages = sent(tmp_path, ["awg=TCPIP0::a::INSTR", "--dry-run"])
    assert status == 0 and "nothing starts" in words and b"*TRG" not in messages and switched_off(messages), words


@pytest.mark.parametrize("fault", [":SOUR1:VOLT", ":SOUR3:DATA:ARB:DAC", "*TRG"])
def test_a_refused_message_ends_it_with_all_off(tmp_path, fault):
    status, words, messages = sent(tmp_path, ["awg=TCPIP0::a::INSTR"], STANDIN_FAULT=fault)
    assert status == 1 and "-222" in words and switched_off(messages), words
    assert fault == "*TRG" or b"*TRG" not in messages


def test_ctrl_c_switches_off(tmp_path):
    status, words, messages = sent(tmp_path, ["awg=TCPIP0::a::INSTR"], STANDIN_INTERRUPT="*TRG")
    assert status == 130 and switched_off(messages), words


def test_an_address_for_each_instrument_is_needed(tmp_path):
    assert sent(tmp_path, [])[0] == 2
    assert sent(tmp_path, ["agw=TCPIP0::a::INSTR"])[0] == 2
    status, words, _ = sent(tmp_path, ["--list"])
    assert status == 0 and "Pair.awg.scpi" in words and "USB0" in words, words
