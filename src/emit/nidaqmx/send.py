#!/usr/bin/env python3
"""Plays the files beside this one on cards of National Instruments, each on its own sample clock, all from one start.

    python NAME.nidaqmx.py --list                 what is to be played, and the devices that the driver finds
    python NAME.nidaqmx.py card=Dev1              the device of each card of the program
    python NAME.nidaqmx.py card=Dev1 --dry-run    everything but the start

Needs the NI-DAQmx driver and its package (`pip install nidaqmx`). Before the start, at the end, on an error and on Ctrl-C lines are off
and voltages at rest, or what the program has as their rest; an output that places a stage keeps its voltage, and goes to the first position at the start.
A program that waits for inputs or people is played in parts: between them all outputs keep what they have, and a line that is waited
for is read all the time; a wait that is too long ends like an error. Exit status: 0 played, 1 the driver refused something or a wait was too long,
2 wrong usage, 130 Ctrl-C.
"""

import argparse
import json
import subprocess
import sys
import threading
import time
from pathlib import Path

PLAYS = {}

# Beyond the schedule's own duration, before a card that does not end counts as lost, in seconds.
MARGIN_S = 5.0


# SHARED


def read(path):
    """Titles, and the stretches: how many samples, words of ports, volts."""
    rows = [line.rstrip("\n").split("\t") for line in open(path, encoding="utf-8") if not line.startswith("#")]
    titles = [title.split(" ")[0] for title in rows[0]]
    number = lambda title, cell: float(cell) if title.startswith("ao") else int(cell, 0)
    return titles, [[number(title, cell) for title, cell in zip(titles, row, strict=True)] for row in rows[1:]]


def samples(card, folder):
    """The level of every line and the volts of every output, a list of samples for each."""
    titles, stretches = read(folder / card["file"])
    column = {title: index for index, title in enumerate(titles)}
    lines, analog = [], []
    for line in card["lines"]:
        port, number = line.split("/line")
        place, bit = column[port], 1 << int(number)
        lines.append([bool(row[place] & bit) for row in stretches for _ in range(row[0])])
    for output in card["analog"]:
        place = column[output["output"]]
        analog.append([float(row[place]) for row in stretches for _ in range(row[0])])
    return lines, analog


class Resting:
    """A card that plays nothing."""

    def __init__(self, ni, card, device):
        self.ni, self.card, self.device = ni, card, device

    def add_lines(self, task, lines):
        for line in lines:
            task.do_channels.add_do_chan(f"{self.device}/{line}", line_grouping=self.ni.constants.LineGrouping.CHAN_PER_LINE)

    def add_analog(self, task, outputs):
        peak = self.card["peak_v"]
        for output in outputs:
            task.ao_channels.add_ao_voltage_chan(f"{self.device}/{output['output']}", min_val=-peak, max_val=peak)

    def rest(self):
        """Lines and voltages at rest; stages stay where they are."""
        volts = [output for output in self.card["analog"] if output["rest_v"] is not None]
        for levels, add, outputs in (
            ([output["rest_v"] for output in volts], self.add_analog, volts),
            (self.card["line_rests"], self.add_lines, self.card["lines"]),
        ):
            if levels:
                with self.ni.Task() as task:
                    add(task, outputs)
                    task.write(levels if len(levels) > 1 else levels[0], auto_start=True)


class Player(Resting):
    """The tasks of a card: analog outputs lead the sample clock where there are some, lines follow it."""

    def __init__(self, ni, card, device, folder, terminals, duration_s):
        super().__init__(ni, card, device)
        self.lines, self.analog = samples(card, folder)
        self.tasks, self.terminals, self.duration_s = [], terminals, duration_s

    def load(self):
        """Makes the tasks; those that are made are closed by `close`, also where a later one fails."""
        ni, card, device = self.ni, self.card, self.device
        start, lead = self.terminals
        clock = None
        for levels, add, outputs in (
            (self.analog, self.add_analog, card["analog"]),
            (self.lines, self.add_lines, card["lines"]),
        ):
            if not levels:
                continue
            task = ni.Task()
            self.tasks.append(task)
            add(task, outputs)
            timing = {"sample_mode": ni.constants.AcquisitionType.FINITE, "samps_per_chan": card["samples"]}
            if clock:
                timing["source"] = clock
            task.timing.cfg_samp_clk_timing(card["rate_hz"], **timing)
            if not clock:
                if card["waits_for_trigger"]:
                    task.triggers.start_trigger.cfg_dig_edge_start_trig(f"/{device}/{start}")
                if card["leads"]:
                    task.export_signals.export_signal(ni.constants.Signal.START_TRIGGER, f"/{device}/{lead}")
                clock = f"/{device}/ao/SampleClock"
            task.write(levels if len(levels) > 1 else levels[0], auto_start=False)

    def start(self):
        """The task that has the clock starts last, so that the others wait for it."""
        for task in reversed(self.tasks):
            task.start()

    def wait(self):
        for task in self.tasks:
            task.wait_until_done(timeout=self.duration_s + MARGIN_S)

    def close(self):
        tasks, self.tasks = self.tasks, []
        lost = []
        for task in tasks:
            lost += failure("a task is not stopped", task.stop) + failure("a task is not closed", task.close)
        if lost:
            raise RuntimeError("; ".join(lost))


def at_rest():
    """What the outputs do once all is over."""
    cards = PLAYS["parts"][0]["cards"]
    analog = [output for card in cards for output in card["analog"]]
    lines = "lines at rest" if any(any(card["line_rests"]) for card in cards) else "lines off"
    ends = [
        (lines, any(card["lines"] for card in cards)),
        ("voltages at rest", any(output["rest_v"] is not None for output in analog)),
        ("stages keep their last voltage", any(output["rest_v"] is None for output in analog)),
    ]
    return ", ".join(words for words, are_there in ends if are_there)


def read_line(ni, channel):
    """Whether a digital line is high."""
    with ni.Task() as task:
        task.di_channels.add_di_chan(channel, line_grouping=ni.constants.LineGrouping.CHAN_PER_LINE)
        return task.read()


def level_of(ni, devices, arguments, hold):
    """Whether an input is high: by your own command, by the line of a card, or by the name of a line that the program has in quotes."""
    if hold["input"] in arguments.commands:
        return asked(arguments.commands, hold)
    own = hold["instrument"]
    return read_line(ni, hold["input"] if own is None else f"{devices.get(own, own)}/{hold['line']}")


def load(ni, devices, arguments, part, players):
    """Loads a part into all cards: those that wait for a trigger first."""
    folder = Path(__file__).resolve().parent
    terminals = (arguments.start_terminal, arguments.lead_terminal)
    for card in sorted(part["cards"], key=lambda card: not card["waits_for_trigger"]):
        player = Player(ni, card, devices[card["name"]], folder, terminals, part["duration_s"])
        players.append(player)
        player.load()
        print(f"{card['name']}: {card['samples']} samples at {card['rate_hz']} Hz on {player.device}", flush=True)


def play(ni, devices, arguments):
    """Loads all cards, starts those that wait for a trigger, then the one that leads, and waits; so for each part."""
    players = []
    try:
        for index, part in enumerate(PLAYS["parts"]):
            if index:
                # What the cards give stays while nothing is loaded.
                for player in players:
                    player.close()
                hold = PLAYS["holds"][index - 1]
                wait_for(hold, lambda: level_of(ni, devices, arguments, hold))
                players.clear()
            else:
                for card in part["cards"]:
                    Resting(ni, card, devices[card["name"]]).rest()
            load(ni, devices, arguments, part, players)
            if arguments.dry_run:
                print("dry run: all is loaded, nothing starts")
                return
            for player in players:
                player.start()
            print("started", flush=True)
            for player in players:
                player.wait()
        for hold in PLAYS["holds"][len(PLAYS["parts"]) - 1 :]:
            wait_for(hold, lambda: level_of(ni, devices, arguments, hold))
        print(f"{PLAYS['name']}: played, {sum(part['duration_s'] for part in PLAYS['parts']):g} s")
    finally:
        lost = []
        for player in players:
            lost += failure(f"{player.card['name']} may still be on", player.close)
        for card in PLAYS["parts"][0]["cards"]:
            lost += failure(f"{card['name']} may still be on", Resting(ni, card, devices[card["name"]]).rest)
        print("; ".join(lost) or at_rest(), flush=True)


def connect(devices, arguments):
    """Plays the cards with the maker's package, or lists them."""
    import nidaqmx as ni
    import nidaqmx.constants
    import nidaqmx.system

    if not arguments.list:
        play(ni, devices, arguments)
        return
    for card in (card for part in PLAYS["parts"] for card in part["cards"]):
        print(f"{card['name']}: {card['file']}, {card['model']}, {', '.join(card['lines'] + [output['output'] for output in card['analog']])}")
    found = [device.name for device in ni.system.System.local().devices]
    print("devices:", ", ".join(found) or "none")


def main(given):
    names = [card["name"] for card in PLAYS["parts"][0]["cards"]] if PLAYS else []
    named = [hold for hold in PLAYS.get("holds", []) if "input" in hold]
    readers = {hold["instrument"] for hold in named if hold["instrument"]}
    names += sorted(readers - set(names))
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("devices", nargs="*", metavar="NAME=DEVICE", help=f"for each of: {', '.join(names)}; else the name itself")
    parser.add_argument("--list", action="store_true", help="show what is to be played and the devices that the driver finds")
    parser.add_argument("--dry-run", action="store_true", help="load and check, but start nothing")
    parser.add_argument("--start-terminal", default="PFI0", help="where the trigger comes in (PFI0)")
    parser.add_argument("--lead-terminal", default="PFI1", help="where the start goes out to other instruments (PFI1)")
    add_inputs(parser, named)
    arguments = parser.parse_args(given)
    arguments.commands = commands_of(parser, arguments, [])
    devices = {name: name for name in names} | pairs_of(parser, arguments.devices, names, "a card")
    return status_of(lambda: connect(devices, arguments), "pip install nidaqmx")


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
