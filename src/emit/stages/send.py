#!/usr/bin/env python3
"""Plays the places beside this file on controllers of stages, each on its own clock, all from one start.

    python NAME.stages.py --list                     what is to be played
    python NAME.stages.py --dry-run                  read and check the places, connect to nothing
    python NAME.stages.py pi=192.168.0.10            a controller of PI by TCP/IP, port 50000 unless `pi=192.168.0.10:50001` says another one
    python NAME.stages.py pi=/dev/ttyUSB0            the same by a serial line, with the package pyserial
    python NAME.stages.py mcs=network:sn:MCS2-00001  an MCS2 of SmarAct, by the locator of the maker's package `smaract.ctl`

Stages must be referenced before. Closed loop is switched on, and every stage goes to the first place, at its controller's own speed:
see that the way is free. At the end, on an error and on Ctrl-C stages are stopped and hold where they are. A controller that waits for a
trigger begins with a pulse at its input; the one that the sender starts gives one at output 1. Of the wave tables of a controller of PI those with
the numbers of the axes are overwritten. A program that waits for inputs or people is played in parts; a wait that is too long ends like an
error. Exit status: 0 played, 1 a controller refused something or a wait was too long, 2 wrong usage, 130 Ctrl-C.
"""

import argparse
import csv
import json
import socket
import subprocess
import sys
import threading
import time
from pathlib import Path

PLAYS = {}

# How long a stage may take to its first place, a controller to an answer, and a movement beyond its own time, in seconds.
SETTLE_S, ANSWER_S, MARGIN_S = 30.0, 5.0, 5.0
# PI: its port, the speed of a serial line, the parameter with the time of a servo cycle, and how a wave generator begins.
PORT, BAUD, SERVO_CYCLE, AT_ONCE, BY_TRIGGER = 50000, 115200, "0x0E000200", 1, 2
STOP_ALL, IS_GENERATING = b"\x18", b"\x09"
# SmarAct: how a stage goes to the first place, in picometres a second and a second squared.
APPROACH_PM_S, APPROACH_PM_S2 = 100_000_000, 1_000_000_000
PM_OF_UM = 1_000_000


# SHARED


class Gcs:
    """PI, General Command Set 2: lines of text. Each axis has a wave table of straight segments and its own wave generator."""

    def __init__(self, controller, address):
        self.controller, self.address, self.rest = controller, address, b""
        self.axes = controller["axes"]
        if address.startswith(("/", "COM")):
            import serial

            port = serial.Serial(address, BAUD, timeout=ANSWER_S, write_timeout=ANSWER_S)
            self.write, self.read, self.close = port.write, lambda: port.read(max(1, port.in_waiting)), port.close
        else:
            host, _, number = address.partition(":")
            line = socket.create_connection((host, int(number or PORT)), ANSWER_S)
            self.write, self.read, self.close = line.sendall, lambda: line.recv(4096), line.close
        self.ask("ERR?")

    def answer(self):
        """An answer: all lines but the last end with a blank."""
        lines = []
        while not lines or lines[-1].endswith(" "):
            while b"\n" not in self.rest:
                more = self.read()
                if not more:
                    raise RuntimeError(f"{self.address}: no answer")
                self.rest += more
            line, _, self.rest = self.rest.partition(b"\n")
            lines.append(line.decode("ascii").rstrip("\r"))
        return [line.strip() for line in lines]

    def ask(self, question):
        self.write(question.encode("ascii") + b"\n")
        return self.answer()

    def tell(self, command):
        """A command, and the error that it has raised."""
        self.write(command.encode("ascii") + b"\n")
        (error,) = self.ask("ERR?")
        if int(error):
            raise RuntimeError(f"{self.address}: error {error} after `{command}`")

    def of_axes(self, question):
        """A number for each axis."""
        answers = dict(line.split("=") for line in self.ask(f"{question} {' '.join(map(str, self.axes))}"))
        return [float(answers[str(axis)]) for axis in self.axes]

    def each(self, command, values):
        """One command with a value for each axis, wave table or generator."""
        self.tell(" ".join([command, *(f"{axis} {value}" for axis, value in zip(self.axes, values))]))

    def load(self, controller, rows):
        cycle_s = float(self.ask(f"SPA? {self.axes[0]} {SERVO_CYCLE}")[0].split("=")[1])
        if abs(cycle_s * controller["rate_hz"] - 1) > 1e-6:
            raise RuntimeError(f"{self.address}: its servo cycle is {cycle_s} s, the program has a rate of {controller['rate_hz']} Hz")
        for axis, least, most, places in zip(self.axes, self.of_axes("TMN?"), self.of_axes("TMX?"), zip(*(places for _, places in rows))):
            if min(places) < least or max(places) > most:
                raise RuntimeError(f"{self.address}: axis {axis} goes from {least} um to {most} um, the program from {min(places)} um to {max(places)} um")
        self.each("SVO", [1] * len(self.axes))
        self.go(rows[0][1])
        for index, axis in enumerate(self.axes):
            how = "X"
            for length, start, way in segments(rows, index):
                self.tell(f"WAV {axis} {how} LIN {length} {way:.6f} {start:.6f} {length} 0 0")
                how = "&"
        self.each("WSL", self.axes)
        self.each("WGC", [1] * len(self.axes))
        for axis in self.axes:
            self.tell(f"WTR {axis} {controller['every']} 1")
        if controller["leads"]:
            for command in ("TWC", "CTO 1 3 4", "TWS 1 1 1"):
                self.tell(command)
        self.last, self.waits = rows[-1][1], controller["waits_for_trigger"]

    def go(self, places):
        """To some places, and until all axes are there."""
        self.each("MOV", [f"{place:.6f}" for place in places])
        begin = time.monotonic()
        while not all(self.of_axes("ONT?")):
            if time.monotonic() - begin > SETTLE_S:
                raise RuntimeError(f"{self.address}: not at {places} um after {SETTLE_S:g} s")
            time.sleep(0.01)

    def start(self):
        self.each("WGO", [BY_TRIGGER if self.waits else AT_ONCE] * len(self.axes))

    def wait(self, duration_s):
        begin = time.monotonic()
        mask = sum(1 << axis - 1 for axis in self.axes)
        while True:
            self.write(IS_GENERATING)
            if not int(self.answer()[0], 16) & mask:
                break
            if time.monotonic() - begin > duration_s + MARGIN_S:
                raise RuntimeError(f"{self.address}: it still moves {MARGIN_S:g} s after its time")
            time.sleep(0.01)
        # The last place of the table may lie a point before the end.
        self.go(self.last)

    def stop(self):
        """Whatever moves stops; what the controller says of that is no error."""
        self.write(STOP_ALL)
        self.ask("ERR?")


class Mcs2:
    """SmarAct: a stream of places, which the maker's package sends as fast as the controller takes them."""

    def __init__(self, controller, address):
        import smaract.ctl as ctl

        self.ctl, self.controller, self.address, self.stream = ctl, controller, address, None
        self.channels = [axis - 1 for axis in controller["axes"]]
        self.handle = ctl.Open(address)

    def set_32(self, channel, name, value):
        self.ctl.SetProperty_i32(self.handle, channel, getattr(self.ctl.Property, name), value)

    def any_in(self, state):
        """Whether some channel is in a state."""
        key, bit = self.ctl.Property.CHANNEL_STATE, getattr(self.ctl.ChannelState, state)
        return any(self.ctl.GetProperty_i32(self.handle, channel, key) & bit for channel in self.channels)

    def load(self, controller, rows):
        ctl = self.ctl
        for channel, place in zip(self.channels, rows[0][1]):
            self.set_32(channel, "SENSOR_POWER_MODE", ctl.SensorPowerMode.ENABLED)
            self.set_32(channel, "AMPLIFIER_ENABLED", ctl.TRUE)
            self.set_32(channel, "MOVE_MODE", ctl.MoveMode.CL_ABSOLUTE)
            ctl.SetProperty_i64(self.handle, channel, ctl.Property.MOVE_VELOCITY, APPROACH_PM_S)
            ctl.SetProperty_i64(self.handle, channel, ctl.Property.MOVE_ACCELERATION, APPROACH_PM_S2)
            ctl.Move(self.handle, channel, round(place * PM_OF_UM), 0)
        begin = time.monotonic()
        while self.any_in("ACTIVELY_MOVING"):
            if time.monotonic() - begin > SETTLE_S:
                raise RuntimeError(f"{self.address}: not at {rows[0][1]} um after {SETTLE_S:g} s")
            time.sleep(0.01)
        if self.any_in("MOVEMENT_FAILED"):
            raise RuntimeError(f"{self.address}: a stage has not come to its first place")
        self.set_32(0, "STREAM_BASE_RATE", round(controller["rate_hz"]))
        self.rows = rows

    def start(self):
        """Sends all places; it takes about as long as they are played."""
        self.stream = self.ctl.OpenStream(self.handle, self.ctl.StreamTriggerMode.DIRECT)
        for places in each_point(self.rows):
            frame = [number for channel, place in zip(self.channels, places) for number in (channel, round(place * PM_OF_UM))]
            self.ctl.StreamFrame(self.handle, self.stream, frame)
        self.ctl.CloseStream(self.handle, self.stream)
        self.stream = None

    def wait(self, duration_s):
        begin = time.monotonic()
        while self.any_in("IS_STREAMING"):
            if time.monotonic() - begin > duration_s + MARGIN_S:
                raise RuntimeError(f"{self.address}: it still moves {MARGIN_S:g} s after its time")
            time.sleep(0.01)
        if self.any_in("MOVEMENT_FAILED"):
            raise RuntimeError(f"{self.address}: a stage has left its way")

    def stop(self):
        lost = []
        if self.stream is not None:
            stream, self.stream = self.stream, None
            lost += failure("the stream", lambda: self.ctl.AbortStream(self.handle, stream))
        for channel in self.channels:
            lost += failure(f"channel {channel}", lambda: self.ctl.Stop(self.handle, channel, 0))
        if lost:
            raise RuntimeError("; ".join(lost))

    def close(self):
        self.ctl.Close(self.handle)


PROTOCOLS = {"gcs": Gcs, "mcs2": Mcs2}


def segments(rows, index):
    """The straight segments of an axis: how many points, where it begins, and how far it goes; standing still is one."""
    found = []
    for (point, before), (later, after) in zip(rows, rows[1:]):
        way = after[index] - before[index]
        if found and way == 0 == found[-1][2]:
            found[-1][0] += later - point
        else:
            found.append([later - point, before[index], way])
    return found


def each_point(rows):
    """The places at every point, on straight lines between the rows."""
    for (point, before), (later, after) in zip(rows, rows[1:]):
        for index in range(later - point):
            yield [a + (b - a) * index / (later - point) for a, b in zip(before, after)]
    yield rows[-1][1]


def read(controller, folder):
    """The rows: the number of a point, and the place of each axis in micrometres."""
    with open(folder / controller["file"], encoding="utf-8", newline="") as file:
        titles, *rows = csv.reader(line for line in file if not line.startswith("#"))
    wanted = ["point", *(f"axis{axis} [um]" for axis in controller["axes"])]
    if titles != wanted:
        raise RuntimeError(f"{controller['file']}: its columns are {titles}, not {wanted}")
    rows = [(int(row[0]), [float(place) for place in row[1:]]) for row in rows]
    points = [point for point, _ in rows]
    if points != sorted(set(points)) or points[0] != 0 or points[-1] != controller["points"]:
        raise RuntimeError(f"{controller['file']}: its points do not run from 0 to {controller['points']}")
    for axis, (least, most), places in zip(controller["axes"], controller["travels_um"], zip(*(places for _, places in rows))):
        if min(places) < least or max(places) > most:
            raise RuntimeError(f"{controller['file']}: axis {axis} leaves its travel from {least} um to {most} um")
    return rows


def controllers():
    return PLAYS["parts"][0]["controllers"] if PLAYS else []


def play(addresses, folder, commands):
    """Connects, and plays part after part: loads all controllers, starts those that wait for a trigger, then the one that leads."""
    players = []
    try:
        for controller in controllers():
            players.append(PROTOCOLS[controller["protocol"]](controller, addresses[controller["name"]]))
        for index, part in enumerate(PLAYS["parts"]):
            if index:
                hold = PLAYS["holds"][index - 1]
                wait_for(hold, lambda: asked(commands, hold))
            for player, controller in zip(players, part["controllers"]):
                player.load(controller, read(controller, folder))
            print("started", flush=True)
            for player, _ in sorted(zip(players, part["controllers"]), key=lambda pair: not pair[1]["waits_for_trigger"]):
                player.start()
            for player in players:
                player.wait(part["duration_s"])
        for hold in PLAYS["holds"][len(PLAYS["parts"]) - 1 :]:
            wait_for(hold, lambda: asked(commands, hold))
        print(f"{PLAYS['name']}: played, {sum(part['duration_s'] for part in PLAYS['parts']):g} s")
    finally:
        lost = []
        for player in players:
            lost += failure(f"{player.address} may still move", player.stop)
            lost += failure(f"{player.address} is not closed", player.close)
        print("; ".join(lost) or "stages hold where they are", flush=True)


def show(folder):
    for part in PLAYS["parts"]:
        for controller in part["controllers"]:
            rows = read(controller, folder)
            period_s = controller["every"] / controller["rate_hz"]
            axes = ", ".join(f"axis{axis}" for axis in controller["axes"])
            print(f"{controller['name']}: {controller['file']}, {controller['model']}, {axes}, {len(rows)} rows, {controller['points']} points of {period_s:g} s")


def main(given):
    names = [controller["name"] for controller in controllers()]
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("addresses", nargs="*", metavar="NAME=ADDRESS", help=f"where each is: {', '.join(names)}")
    parser.add_argument("--list", action="store_true", help="show what is to be played")
    parser.add_argument("--dry-run", action="store_true", help="read and check the places, connect to nothing")
    named = [hold for hold in PLAYS.get("holds", []) if "input" in hold]
    add_inputs(parser, named)
    arguments = parser.parse_args(given)
    commands = commands_of(parser, arguments, named)
    addresses = pairs_of(parser, arguments.addresses, names, "a controller")
    missing = [name for name in names if name not in addresses]
    if missing and not (arguments.list or arguments.dry_run):
        parser.error(f"no address of {', '.join(missing)}: `{missing[0]}=192.168.0.10`")
    folder = Path(__file__).resolve().parent
    work = (lambda: show(folder)) if arguments.list or arguments.dry_run else (lambda: play(addresses, folder, commands))
    return status_of(work, "pyserial for serial lines, the maker's `smaract.ctl` for an MCS2")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
