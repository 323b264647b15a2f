"""SCPI, sent to a simulated instrument; what it then holds against the schedule.

The simulation speaks text only, so blocks are taken apart by pyvisa, put together again by it, and sent as numbers.
"""

import re
import tempfile
from pathlib import Path

import pyvisa
from pyvisa import util

import instrument
from verdict import demand

NO_ERROR = '0,"No error"'
FULL_SCALE = 32767
# Of a sequence in the 33500 series.
MOST_STEPS = 512
MOST_REPEATS = 1_000_000
# The most that a stage moves between two samples, unless there are as many as the memory takes.
SAMPLE_UM = 0.05
FEW_POINTS = 500_000


def messages(data):
    """The messages of a script: up to a line feed that is not inside a block."""
    found, start, at = [], 0, 0
    while at < len(data):
        if data[at : at + 1] == b"#" and data[at + 1 : at + 2].isdigit():
            offset, length = util.parse_ieee_block_header(data[at:])
            at += offset + length
        elif data[at : at + 1] == b"\n":
            found.append(data[start:at])
            start = at = at + 1
        else:
            at += 1
    demand(start == len(data), "the last message has no end")
    return found


def as_text(message):
    """A message whose block, if it has one, is written as numbers."""
    at = message.find(b",#")
    if at < 0:
        return message.decode("ascii")
    block = message[at + 1 :]
    codes = util.from_ieee_block(block, "h", is_big_endian=True)
    demand(util.to_ieee_block(codes, "h", is_big_endian=True) == block, "a block is not what pyvisa would write")
    return message[:at].decode("ascii") + "," + " ".join(map(str, codes))


def judge(path, schedule):
    sent = messages(path.read_bytes())
    with tempfile.TemporaryDirectory() as folder:
        rack = Rack(Path(folder) / "rack.yaml", max(len(schedule.channels), 1))
        try:
            for message in sent:
                rack.send(as_text(message))
            points = [compare(rack, output, channel, schedule) for output, channel in enumerate(schedule.channels, 1)]
        finally:
            rack.close()
    asked = sent.count(b":SYST:ERR?")
    demand(asked == len(schedule.channels) + 1, f"errors are asked for {asked} times")
    demand(sent[-1] == b"*TRG", "it does not end with the trigger")
    return f"{len(sent)} messages taken without error, {sum(points)} samples of {len(points)} outputs are the schedule"


class Rack:
    """Instruments whose outputs are counted through: what names an output goes to its instrument, all else to every one."""

    def __init__(self, description, outputs):
        addresses = instrument.write(description, outputs)
        self.manager = pyvisa.ResourceManager(f"{description}@sim")
        open_one = lambda address: self.manager.open_resource(address, read_termination="\n", write_termination="\n")
        self.instruments = [open_one(address) for address in addresses]
        # The simulation remembers the last segment of an output only, so each is asked back as soon as it is there.
        self.segments = {}

    def close(self):
        for one in self.instruments:
            one.close()
        self.manager.close()

    def meant(self, text):
        """The instruments that a message is for."""
        found = re.match(r":[A-Z]+(\d+)", text)
        if not found:
            return self.instruments
        index = (int(found.group(1)) - 1) // instrument.OUTPUTS
        demand(index < len(self.instruments), f"no instrument has the output of {text[:80]}")
        return [self.instruments[index]]

    def send(self, text):
        for one in self.meant(text):
            send(one, text)
        header = text.partition(" ")[0]
        if header.endswith(":DATA:ARB:DAC"):
            name, _, codes = self.query(header + "?").partition(",")
            self.segments.setdefault(header, {})[name] = [int(code) for code in codes.split(" ")]

    def query(self, text):
        return self.meant(text)[0].query(text)


def send(awg, text):
    if text.endswith("?"):
        demand(awg.query(text) == NO_ERROR, f"{text} tells of an error")
        return
    awg.write(text)
    error = awg.query(":SYST:ERR?")
    demand(error == NO_ERROR, f"{error} after {text[:80]}")


def compare(rack, output, channel, schedule):
    """What an output would play: samples times scale, at their times."""
    ask = lambda header: rack.query(header.replace("{}", str(output)) + "?")
    wanted = {":OUTP{}": "ON", ":SOUR{}:FUNC": "ARB", ":TRIG{}:SOUR": "BUS", ":OUTP{}:LOAD": "INF"}
    for header, value in wanted.items():
        demand(ask(header) == value, f"output {output}: {header} is {ask(header)}")
    segments = rack.segments[f":SOUR{output}:DATA:ARB:DAC"]
    steps = ask(":SOUR{}:DATA:SEQ")
    played = waveform if steps == "none" else sequence
    waits, codes, period_ns = played(ask, segments, steps)
    demand(abs(period_ns - round(period_ns)) < 1e-6 * period_ns, f"a sample lasts {period_ns} ns")
    period_ns = round(period_ns)
    scale = float(ask(":SOUR{}:VOLT")) / 2 / FULL_SCALE
    if schedule.is_stage(channel):
        step_um = schedule.fastest(channel) * period_ns
        demand(step_um <= SAMPLE_UM + 1e-9 or len(codes) >= FEW_POINTS, f"{channel} moves {step_um} um from sample to sample")
    else:
        for edge in schedule.edges(channel):
            demand(edge % period_ns == 0, f"{channel} has an edge at {edge} ns, between samples")
    demand(len(codes) * period_ns >= schedule.duration_ns, f"output {output} ends too early")
    at = lambda t_ns: schedule.value(channel, min(t_ns, schedule.duration_ns))
    waits_at = [at(0), at(schedule.duration_ns)] if schedule.is_stage(channel) else [0, 0]
    for code, expected in zip(waits, waits_at, strict=True):
        demand(abs(code * scale - expected) <= scale / 2 + 1e-12, f"{channel} waits or rests at {code * scale} V, not {expected} V")
    for index, code in enumerate(codes):
        found, expected = code * scale, at(index * period_ns)
        demand(abs(found - expected) <= scale / 2 + 1e-12, f"{channel} is {found} V at {index * period_ns} ns, not {expected} V")
    return len(codes)


def waveform(ask, segments, _):
    """What one segment in a burst waits at and rests at, its samples from the trigger on, and how long each lasts."""
    demand(ask(":SOUR{}:BURS:STAT") == "ON" and ask(":SOUR{}:BURS:NCYC") == "1", "the waveform is not played once")
    name = ask(":SOUR{}:FUNC:ARB")
    demand(name in segments, f"{name} is no segment")
    codes = segments[name]
    return [codes[0], codes[-1]], codes[1:], float(ask(":SOUR{}:FUNC:ARB:PER")) * 1e9 / len(codes)


def sequence(ask, segments, block):
    """What a sequence waits at and rests at, its samples from the trigger on, and how long each lasts.

    As the 33500 series plays it: a name, then for each step a segment, how many times, how it goes on, and a marker."""
    offset, length = util.parse_ieee_block_header(block.encode("ascii"))
    demand(offset + length == len(block), "the block of a sequence has another length")
    name, *rest = block[offset:].split(",")
    demand(name.strip('"') == ask(":SOUR{}:FUNC:ARB"), "another sequence is chosen")
    demand(ask(":SOUR{}:BURS:STAT") == "OFF", "a sequence is no burst")
    demand(ask(":SOUR{}:FUNC:ARB:FILT") == "STEP", "the filter rings at edges")
    steps = [rest[at : at + 5] for at in range(0, len(rest), 5)]
    demand(all(len(step) == 5 for step in steps) and len(steps) <= MOST_STEPS, "a step has too little, or too many are there")
    codes, waits = [], []
    for number, (quoted, times, control, marker, point) in enumerate(steps):
        segment = segments.get(quoted.strip('"'))
        demand(segment is not None and 8 <= len(segment), f"{quoted} is no segment")
        demand(marker == "lowAtStart" and 4 <= int(point) <= len(segment) - 3, f"the marker of step {number} is off")
        demand(1 <= int(times) <= MOST_REPEATS, f"step {number} repeats {times} times")
        if control in ("onceWaitTrig", "repeatInf"):
            demand(number in (0, len(steps) - 1) and len(set(segment)) == 1, f"step {number} stops, or swings")
            waits.append(segment[0])
        else:
            demand(control == "repeat" or (control, times) == ("once", "1"), f"step {number} goes on by {control}")
            codes += segment * int(times)
    ends = [step[2] for step in (steps[0], steps[-1])]
    demand(ends == ["onceWaitTrig", "repeatInf"], f"it waits and rests by {ends}")
    return waits, codes, 1e9 / float(ask(":SOUR{}:FUNC:ARB:SRAT"))
