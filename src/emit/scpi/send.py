#!/usr/bin/env python3
"""Sends the scripts beside this file to waveform generators, starts them, and switches their outputs off when all is played.

    python NAME.scpi.py --list                              what is to be sent, and the resources that VISA finds
    python NAME.scpi.py awg=TCPIP0::192.168.1.5::INSTR      an address for each instrument of the program
    python NAME.scpi.py awg=... --dry-run                   everything but the last message: nothing starts

Needs PyVISA and a VISA library (`pip install pyvisa pyvisa-py`). After each message the error queue is read; on an error, on Ctrl-C
and at the end all outputs are switched off, but for those of stages, which keep their voltage, and those that rest at a voltage, which go there. Where the program waits, outputs hold their
voltage until the next trigger, which the sender gives; a wait that is too long ends like an error. Exit status: 0 played, 1 an instrument refused something or was lost, 2 wrong usage, 130 Ctrl-C.
"""

import argparse
import json
import subprocess
import sys
import threading
import time
from pathlib import Path

PLAYS = {}

# Beyond the schedule's own duration, before outputs are switched off, in seconds.
MARGIN_S = 0.1


# SHARED


class Refused(Exception):
    """An instrument reported an error."""


def messages(data):
    """The messages of a script: up to a line feed that is not inside a definite-length block."""
    found, start, at = [], 0, 0
    while at < len(data):
        digits = data[at + 1 : at + 2]
        if data[at : at + 1] == b"#" and digits.isdigit() and digits != b"0":
            count = int(digits)
            at += 2 + count + int(data[at + 2 : at + 2 + count])
        elif data[at : at + 1] == b"\n":
            found.append(data[start:at])
            start = at = at + 1
        else:
            at += 1
    if start != len(data):
        raise Refused("the script ends within a message")
    return found


def check(device, name, message):
    """Reads the error queue until it is empty."""
    errors = []
    while True:
        answer = device.query(":SYST:ERR?").strip()
        if answer.split(",")[0].lstrip("+") == "0":
            break
        errors.append(answer)
    if errors:
        raise Refused(f"{name} refused {message[:60]!r}: {'; '.join(errors)}")


def send(device, name, script, says):
    """Sends all messages but the one that begins, and returns that one, if there is one."""
    begin = None
    for message in messages(script):
        if message == b"*TRG":
            begin = message
        elif not message.endswith(b"?"):
            says(f"{name} <- {message[:60].decode('ascii', 'replace')}{' ...' if len(message) > 60 else ''}")
            device.write_raw(message + b"\n")
            check(device, name, message)
    if device.query("*OPC?").strip().lstrip("+") != "1":
        raise Refused(f"{name} does not end its work")
    return begin


def switch_off(open_ones, says):
    """Switches every output off or to its rest, but those of stages, whatever happens on the way."""
    lost = []
    for one, device in open_ones:
        for output in (output for output in one["outputs"] if output not in one["stay_on"]):
            rest_v = one["rest_v"].get(str(output))
            off = f":OUTP{output} OFF" if rest_v is None else f":SOUR{output}:APPL:DC DEF,DEF,{rest_v}"
            lost += failure(f"{one['name']}: output {output} may still be on", lambda: device.write(off))
        stay = f", {one['stay_on']} stay on for their stages" if one["stay_on"] else ""
        rest = ", ".join(f"{output} rests at {volts} V" for output, volts in one["rest_v"].items())
        says(f"{one['name']}: outputs off{stay}" + (f", {rest}" if rest else ""))
    if lost:
        raise Refused("; ".join(lost))


def play(manager, addresses, arguments, says):
    """Uploads, begins, waits, switches off."""
    # Those that wait for a trigger come first, the one that starts them all last.
    instruments = sorted(PLAYS["instruments"], key=lambda one: one["starts"])
    open_ones = []
    try:
        starters = []
        for one in instruments:
            device = manager.open_resource(addresses[one["name"]], timeout=30_000, read_termination="\n", write_termination="\n")
            open_ones.append((one, device))
            says(f"{one['name']}: {device.query('*IDN?').strip()}")
            script = (Path(__file__).resolve().parent / one["file"]).read_bytes()
            begin = send(device, one["name"], script, says)
            if begin:
                starters.append((one, device, begin))
        if arguments.dry_run:
            says("dry run: all is uploaded, nothing starts")
            return
        for one, device, begin in starters:
            device.write_raw(begin + b"\n")
            says(f"{one['name']}: started")
        if not starters:
            says("waiting for your trigger; end with Ctrl-C when all is played")
        played = 0.0
        for hold in PLAYS["holds"]:
            start, end = hold["times_s"]
            time.sleep(start - played + MARGIN_S)
            for one, device in open_ones:
                check(device, one["name"], b"the schedule")
            wait_for(hold, lambda: asked(arguments.commands, hold))
            for one, device, begin in starters:
                device.write_raw(begin + b"\n")
                says(f"{one['name']}: goes on")
            played = end
        deadline = time.monotonic() + PLAYS["duration_s"] - played + MARGIN_S
        while not starters or time.monotonic() < deadline:
            time.sleep(min(0.2, max(deadline - time.monotonic(), 0.01)) if starters else 0.2)
        for one, device in open_ones:
            check(device, one["name"], b"the schedule")
        says(f"{PLAYS['name']}: played" + ("" if PLAYS["holds"] else f", {PLAYS['duration_s']} s"))
    finally:
        try:
            switch_off(open_ones, says)
        finally:
            for one, device in open_ones:
                failure(f"{one['name']} is not closed", device.close)


def connect(addresses, arguments):
    """Plays the instruments by VISA, or lists them."""
    import pyvisa

    says = lambda text: print(text, flush=True) if arguments.verbose or "<-" not in text else None
    manager = pyvisa.ResourceManager(arguments.visa)
    if not arguments.list:
        play(manager, addresses, arguments, says)
        return
    for one in PLAYS["instruments"]:
        print(f"{one['name']}: {one['file']}, {one['model']}, outputs {one['outputs']}")
    print("resources:", ", ".join(manager.list_resources()) or "none")


def main(given):
    names = [one["name"] for one in PLAYS.get("instruments", [])]
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("addresses", nargs="*", metavar="NAME=RESOURCE", help=f"for each of: {', '.join(names)}")
    parser.add_argument("--list", action="store_true", help="show what is to be sent and the resources that VISA finds")
    parser.add_argument("--dry-run", action="store_true", help="upload and check, but start nothing")
    parser.add_argument("--visa", default="", help="the VISA library, as `@py` or `description.yaml@sim`")
    parser.add_argument("--verbose", action="store_true", help="show every message")
    named = [hold for hold in PLAYS.get("holds", []) if "input" in hold]
    add_inputs(parser, named)
    arguments = parser.parse_args(given)
    arguments.commands = commands_of(parser, arguments, named)
    addresses = pairs_of(parser, arguments.addresses, names, "an instrument")
    missing = [name for name in names if name not in addresses]
    if missing and not arguments.list:
        parser.error(f"no address for {', '.join(missing)}")
    return status_of(lambda: connect(addresses, arguments), "pip install pyvisa pyvisa-py")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
