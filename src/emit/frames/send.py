#!/usr/bin/env python3
"""Plays the frames beside this file on drivers of electrode boards, all from one clock.

    python NAME.frames.py --list                 what is to be played
    python NAME.frames.py --dry-run              read and check the frames, send nothing
    python NAME.frames.py od=/dev/ttyACM0        the serial port of an OpenDrop; without it the one that is found on USB
    python NAME.frames.py pd=192.168.7.2:7000    the server of a PurpleDrop; without it 127.0.0.1:7000
    python NAME.frames.py db=/dev/ttyACM0        the serial port of a DropBot; without it the one that its package finds

An OpenDrop needs the package pyserial (`pip install pyserial`); a PurpleDrop needs its server `pdserver` only; a DropBot needs the
package `dropbot`. Set voltage and frequency on the device yourself; only a DropBot gets those of the program. Before the start, at the end, on an error and on Ctrl-C all electrodes are switched off; only outputs that rest high stay on. A frame that cannot be sent within its own
time is an error. Where the program waits, the frame that is on stays so; the frames after it are due from the end of the wait, and a wait
that is too long ends like an error. Reservoirs with electrodes of their own, as those of an OpenDrop, dispense in the frames; on other boards droplets are put there by
hand, each named when it is due, at the electrode of its outlet, which is on by then. Exit status: 0 played, 1 a driver refused or was late, 2 wrong usage, 130 Ctrl-C.
"""

import argparse
import csv
import json
import subprocess
import sys
import threading
import time
import urllib.request
from pathlib import Path

PLAYS = {}

# OpenDrop: columns of 8 electrodes, then control bytes. The first has a bit for each magnet, three are temperatures in degrees; 25 is
# what its own program sends.
COLUMNS, CONTROLS, TEMPERATURES, ROOM_DEGREES = 16, 16, (10, 11, 12), 25
MAGNETS = {"magnet1": 2, "magnet2": 1}
REPLY_BYTES, REPLY_S = 24, 0.5
USB_ID = (0x239A, 0x800B)
# PurpleDrop: how long a call may take, in seconds.
CALL_S = 5.0


# SHARED


class Opendrop:
    """Frames of 32 bytes; each is answered by 24."""

    def __init__(self, address):
        import serial
        import serial.tools.list_ports

        if not address:
            found = [port.device for port in serial.tools.list_ports.comports() if (port.vid, port.pid) == USB_ID]
            if len(found) != 1:
                raise RuntimeError(f"{len(found)} OpenDrops on USB: name the port, as `od=/dev/ttyACM0`")
            address = found[0]
        self.port = serial.Serial(address, 115200, timeout=REPLY_S, write_timeout=REPLY_S)
        self.address = address

    @staticmethod
    def frame(on):
        data = bytearray(COLUMNS + CONTROLS)
        for place in TEMPERATURES:
            data[COLUMNS + place] = ROOM_DEGREES
        for what in on:
            if isinstance(what, int):
                data[what // 8] |= 1 << what % 8
            elif what in MAGNETS:
                data[COLUMNS] |= MAGNETS[what]
            else:
                heater, degrees = what.split("=")
                data[COLUMNS + TEMPERATURES[int(heater.removeprefix("heater")) - 1]] = int(degrees)
        return bytes(data)

    def send(self, on):
        self.port.reset_input_buffer()
        self.port.write(self.frame(on))
        reply = self.port.read(REPLY_BYTES)
        if len(reply) < REPLY_BYTES:
            raise RuntimeError(f"{self.address}: answered {len(reply)} of {REPLY_BYTES} bytes")

    def close(self):
        self.port.close()


class Purpledrop:
    """A call of `set_electrode_pins` with the pins that are on; all others are switched off by it."""

    def __init__(self, address):
        address = address or "127.0.0.1:7000"
        self.address = address if "://" in address else f"http://{address}"
        self.calls = 0

    def send(self, on):
        self.calls += 1
        call = {"jsonrpc": "2.0", "method": "set_electrode_pins", "params": [sorted(on)], "id": self.calls}
        request = urllib.request.Request(
            f"{self.address}/rpc", json.dumps(call).encode(), {"Content-Type": "application/json"}
        )
        with urllib.request.urlopen(request, timeout=CALL_S) as reply:
            answer = json.load(reply)
        if "result" not in answer:
            raise RuntimeError(f"{self.address}: {answer.get('error', answer)}")

    def close(self):
        pass


class Dropbot:
    """States of all channels, an array of 0 and 1; its high voltage is on from the start to the end."""

    made = 0

    def __init__(self, address):
        try:
            import dropbot
        except ImportError as error:
            raise RuntimeError(f"the package `dropbot` is not installed ({error})") from error
        # Boards are made in the order of the drivers.
        driver = [driver for driver in PLAYS["drivers"] if driver["protocol"] == "dropbot"][Dropbot.made]
        Dropbot.made += 1
        self.rest = driver["rest"]
        self.proxy = dropbot.SerialProxy(**({"port": address} if address else {}))
        self.address = address or "DropBot"
        try:
            self.channels = self.proxy.number_of_channels
            self.send([])
            self.proxy.voltage = driver["voltage_v"]
            if driver["frequency_hz"]:
                self.proxy.frequency = driver["frequency_hz"]
            self.proxy.hv_output_selected = True
            self.proxy.hv_output_enabled = True
        except BaseException:
            self.proxy.hv_output_enabled = False
            raise

    def send(self, on):
        import numpy

        states = numpy.zeros(self.channels, dtype=int)
        states[sorted(on)] = 1
        self.proxy.state_of_channels = states

    def close(self):
        try:
            if not self.rest:
                self.proxy.hv_output_enabled = False
        finally:
            self.proxy.terminate()


PROTOCOLS = {"opendrop": Opendrop, "purpledrop": Purpledrop, "dropbot": Dropbot}


def read(driver, folder):
    """The frames: when each begins and ends, in seconds, and what is on: numbers of channels, and names of magnets and heaters."""
    frames, end = [], 0.0
    with open(folder / driver["file"], encoding="utf-8", newline="") as file:
        for row in csv.DictReader(file):
            start, lasts = (float(row[title]) / 1e3 for title in ("start [ms]", "duration [ms]"))
            if abs(start - end) > 1e-6:
                raise RuntimeError(f"{driver['file']}: frame {row['frame']} begins at {start} s, the one before ends at {end} s")
            end = start + lasts
            on = [int(number) for number in row["on"].split()] + row.get("accessories", "").split()
            frames.append((start, end, on))
    if len(frames) != driver["frames"]:
        raise RuntimeError(f"{driver['file']}: {len(frames)} frames instead of {driver['frames']}")
    return frames


def dues():
    """Droplets that a reservoir dispenses, in the order in which they are due."""
    for one in PLAYS.get("dispensed", []):
        column, row = one["outlet"]
        yield one["at_s"], f"{one['at_s']:g} s: droplet {one['droplet']} is due at ({column}, {row})"


def resting(driver):
    """What a driver has on before and after."""
    return driver["rest"] + driver.get("resting_accessories", [])


def passed(hold, begin, commands):
    """Waits, and returns the instant 0 of a schedule in which the wait ends now."""
    start, end = hold["times_s"]
    time.sleep(max(0.0, begin + start - time.monotonic()))
    wait_for(hold, lambda: asked(commands, hold))
    return time.monotonic() - end


def play(addresses, folder, commands):
    """All frames of all drivers, each when it is due."""
    due, holds = list(dues()), list(PLAYS["holds"])
    frames = [(frame, index) for index, driver in enumerate(PLAYS["drivers"]) for frame in read(driver, folder)]
    frames.sort(key=lambda due: (due[0][0], due[1]))
    boards, latest = [], 0.0
    try:
        for driver in PLAYS["drivers"]:
            board = PROTOCOLS[driver["protocol"]](addresses.get(driver["name"]))
            boards.append(board)
            board.send(resting(driver))
        begin = time.monotonic()
        print("started", flush=True)
        for (start, end, on), index in frames:
            while holds and holds[0]["times_s"][0] < start:
                begin = passed(holds.pop(0), begin, commands)
            time.sleep(max(0.0, begin + start - time.monotonic()))
            boards[index].send(on)
            while due and due[0][0] <= start:
                print(due.pop(0)[1], flush=True)
            now = time.monotonic() - begin
            latest = max(latest, now - start)
            if now >= end:
                raise RuntimeError(f"a frame of {end - start:g} s was sent {now - start:.3f} s after it was due")
        while holds:
            begin = passed(holds.pop(0), begin, commands)
        time.sleep(max(0.0, begin + PLAYS["duration_s"] - time.monotonic()))
        lasted = "" if PLAYS["holds"] else f" in {PLAYS['duration_s']:g} s"
        print(f"{PLAYS['name']}: played {len(frames)} frames{lasted}, at most {latest * 1e3:.1f} ms late")
    finally:
        lost = []
        for board, driver in zip(boards, PLAYS["drivers"]):
            on = f"{board.address} may still be on"
            sent = failure(on, lambda: board.send(resting(driver)))
            lost += failure(on, board.close)[: 0 if sent else 1] + sent
        stay = [f"{f'c{what}' if isinstance(what, int) else what} of {driver['name']}" for driver in PLAYS["drivers"] for what in resting(driver)]
        print("; ".join(lost) or "all electrodes are off" + (f", {', '.join(stay)} on" if stay else ""), flush=True)


def show(folder):
    for driver in PLAYS["drivers"]:
        frames = read(driver, folder)
        print(f"{driver['name']}: {driver['file']}, {driver['model']}, {len(frames)} frames, {len(driver['electrodes'])} electrodes")
    for _, text in dues():
        print(text)


def main(given):
    names = [driver["name"] for driver in PLAYS.get("drivers", [])]
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("addresses", nargs="*", metavar="NAME=ADDRESS", help=f"port or server of: {', '.join(names)}")
    parser.add_argument("--list", action="store_true", help="show what is to be played")
    parser.add_argument("--dry-run", action="store_true", help="read and check the frames, send nothing")
    named = [hold for hold in PLAYS.get("holds", []) if "input" in hold]
    add_inputs(parser, named)
    arguments = parser.parse_args(given)
    commands = commands_of(parser, arguments, named)
    addresses = pairs_of(parser, arguments.addresses, names, "a driver")
    folder = Path(__file__).resolve().parent
    work = (lambda: show(folder)) if arguments.list or arguments.dry_run else (lambda: play(addresses, folder, commands))
    return status_of(work, "pip install pyserial")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
