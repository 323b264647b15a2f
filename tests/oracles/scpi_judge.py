"""SCPI, sent to a simulated instrument, whose resulting settings are compared with the schedule.

The simulation accepts text only, so pyvisa decodes each block, re-encodes it to check the round trip, and the block is sent as numbers.
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
# Most repetitions of a step in the 33500 series.
MOST_REPEATS = 1_000_000
# Most that a stage may move between two samples, in um, unless the samples fill the memory.
SAMPLE_UM = 0.05


def messages(data):
    """Splits a script into messages, each of which ends at a line feed outside any block."""
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
    """A message as text, with its block, if it has one, written as numbers."""
    at = message.find(b",#")
    if at < 0:
        return message.decode("ascii")
    block = message[at + 1 :]
    codes = util.from_ieee_block(block, "h", is_big_endian=True)
    demand(util.to_ieee_block(codes, "h", is_big_endian=True) == block, "a block is not what pyvisa would write")
    return message[:at].decode("ascii") + "," + " ".join(map(str, codes))


def judge(path, schedule):
    """Judges every script of a schedule, as its instrument would play it."""
    verdicts = []
    for name, facts in schedule.instruments("waveform_generator").items():
        verdicts.append(f"{name}: " + judge_one(path.with_suffix(f".{name}.scpi"), name, facts, schedule))
    demand(path.with_suffix(".scpi.py").exists(), "there is no sender")
    return "; ".join(verdicts)


def judge_one(path, name, facts, schedule):
    sent = messages(path.read_bytes())
    drives = schedule.drives(name)
    demand(0 < len(drives) <= facts["outputs"], f"{len(drives)} channels on {facts['outputs']} outputs")
    numbers = [int(output.removeprefix("ch")) for output, _ in drives.values()]
    with tempfile.TemporaryDirectory() as folder:
        rack = Rack(Path(folder) / "rack.yaml", max(numbers))
        try:
            for message in sent:
                rack.send(as_text(message))
            points = [compare(rack, facts, channel, *drive, schedule) for channel, drive in drives.items()]
        finally:
            rack.close()
    asked = sent.count(b":SYST:ERR?")
    demand(asked == len(drives) + 1, f"errors are asked for {asked} times")
    demand((sent[-1] == b"*TRG") == (facts["start"] == "sender"), "it does not end with the trigger, or does")
    return f"{len(sent)} messages taken without error, {sum(points)} samples of {len(points)} outputs are the schedule"


class Rack:
    """Instruments with consecutively numbered outputs: a message that names an output goes to its instrument, others go to all."""

    def __init__(self, description, outputs):
        addresses = instrument.write(description, outputs)
        self.manager = pyvisa.ResourceManager(f"{description}@sim")
        open_one = lambda address: self.manager.open_resource(address, read_termination="\n", write_termination="\n")
        self.instruments = [open_one(address) for address in addresses]
        # The simulation keeps only the last segment of each output, so each segment is queried as soon as it is loaded.
        self.segments = {}

    def close(self):
        for one in self.instruments:
            one.close()
        self.manager.close()

    def meant(self, text):
        """The instruments that a message is addressed to."""
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


def compare(rack, facts, channel, output, link, schedule):
    """Compares the scaled samples of an output, before the amplifier or driver behind it, with the schedule; returns their number."""
    number = output.removeprefix("ch")
    ask = lambda header: rack.query(header.replace("{}", number) + "?")
    demand(ask(":OUTP{}") == "ON" and ask(":OUTP{}:LOAD") == "INF", f"{output} is not on, or not into an open circuit")
    low, high = (float(ask(":SOUR{}:VOLT:OFFS")) + side * float(ask(":SOUR{}:VOLT")) / 2 for side in (-1, 1))
    wanted = lambda t_ns: schedule.output_v(link, schedule.value(channel, min(t_ns, schedule.duration_ns)))
    if ask(":SOUR{}:FUNC") == "DC":
        steady = float(ask(":SOUR{}:VOLT:OFFS"))
        levels = {wanted(t_ns) for edge in schedule.edges(channel) for t_ns in (edge, max(edge - 1, 0))} | {wanted(0)}
        demand(all(abs(level - steady) < 1e-9 for level in levels), f"{channel} is not {steady} V all the time")
        return 0
    peak_v = facts["voltage"]["peak_v"]
    demand(-peak_v - 1e-9 <= low < high <= peak_v + 1e-9, f"{output} gives {low} V to {high} V, its instrument {peak_v} V to either side")
    demand(ask(":SOUR{}:FUNC") == "ARB", f"{output} does not play a waveform")
    demand(ask(":SOUR{}:FUNC:ARB:FILT") == "OFF", f"the filter of {output} rounds its edges")
    demand(ask(":TRIG{}:SOUR") == {"sender": "BUS", "trigger": "EXT"}[facts["start"]], f"{output} has another trigger")
    segments = rack.segments[f":SOUR{number}:DATA:ARB:DAC"]
    demand(sum(map(len, segments.values())) <= facts["most_points"], f"the memory of {output} is too small")
    demand(all(len(segment) >= facts["least_points"] for segment in segments.values()), f"{output} has too short a segment")
    codes = [code for segment in segments.values() for code in segment]
    # According to the manual, only waveforms that use the whole range of the converter reach the full amplitude.
    demand((min(codes), max(codes)) == (-FULL_SCALE, FULL_SCALE), f"{output} uses codes {min(codes)} to {max(codes)} only")
    steps = ask(":SOUR{}:DATA:SEQ")
    waits, codes = waveform(ask, segments) if steps == "none" else sequence(ask, facts, segments, steps)
    rate_hz = float(ask(":SOUR{}:FUNC:ARB:SRAT"))
    demand(rate_hz <= facts["voltage"]["rate_hz"], f"{output} plays {rate_hz} samples in a second")
    period_ns = round(1e9 / rate_hz)
    demand(abs(1e9 / rate_hz - period_ns) < 1e-6 * period_ns, f"a sample lasts {1e9 / rate_hz} ns")
    lsb = (high - low) / 2 / FULL_SCALE
    volts = lambda code: (low + high) / 2 + code * lsb
    near = lambda code, level: abs(volts(code) - level) <= lsb / 2 + 1e-9
    if schedule.is_stage(channel):
        step_um = schedule.fastest(channel) * period_ns
        few = sum(map(len, codes)) < facts["most_points"] / 2
        demand(step_um <= SAMPLE_UM + 1e-9 or not few, f"{channel} moves {step_um} um from sample to sample")
    parts = schedule.parts()
    holds = schedule.document.get("holds", [])
    demand(len(codes) == len(holds) + 1 and not any(codes[len(parts):]), f"{output} plays {len(codes)} parts, not {len(parts)}")
    for (begin, end), part in zip(parts, codes):
        inner = [] if schedule.is_stage(channel) else [edge for edge in schedule.edges(channel) if begin <= edge <= end]
        for edge in inner:
            demand((edge - begin) % period_ns == 0, f"{channel} has an edge at {edge} ns, between samples")
        demand(begin + len(part) * period_ns >= end, f"{output} ends too early")
    rest = schedule.output_v(link, schedule.rests_v[channel])
    ends = [wanted(0), wanted(schedule.duration_ns)] if schedule.is_stage(channel) else [rest, rest]
    waits_at = [ends[0], *(wanted(hold["start_ns"]) for hold in holds), ends[1]]
    for code, level in zip(waits, waits_at, strict=True):
        demand(near(code, level), f"{channel} waits or rests at {volts(code)} V, not {level} V")
    for (begin, end), part in zip(parts, codes):
        for index, code in enumerate(part):
            t_ns = begin + index * period_ns
            # Samples past the end of a part repeat the value that the wait there holds.
            level = wanted(t_ns if end == schedule.duration_ns and len(parts) > len(holds) else min(t_ns, end))
            demand(near(code, level), f"{output} gives {volts(code)} V at {t_ns} ns, not {level} V")
    return sum(map(len, codes))


def waveform(ask, segments):
    """For one segment in a burst: the codes at which it waits and rests, and its samples from the second on, where the schedule begins."""
    demand(ask(":SOUR{}:BURS:STAT") == "ON" and ask(":SOUR{}:BURS:NCYC") == "1", "the waveform is not played once")
    name = ask(":SOUR{}:FUNC:ARB")
    demand(name in segments, f"{name} is no segment")
    codes = segments[name]
    return [codes[0], codes[-1]], [codes[1:]]


def sequence(ask, facts, segments, block):
    """For a sequence: the codes at which it waits and rests, and its samples from each trigger on.

    Format of the 33500 series: a name, then for each step a segment, repetitions, play control, marker mode and marker point.
    """
    offset, length = util.parse_ieee_block_header(block.encode("ascii"))
    demand(offset + length == len(block), "the block of a sequence has another length")
    name, *rest = block[offset:].split(",")
    demand(name.strip('"') == ask(":SOUR{}:FUNC:ARB"), "another sequence is chosen")
    demand(ask(":SOUR{}:BURS:STAT") == "OFF", "a sequence is no burst")
    steps = [rest[at : at + 5] for at in range(0, len(rest), 5)]
    demand(all(len(step) == 5 for step in steps) and len(steps) <= facts["most_steps"], "a step has too little, or too many are there")
    parts, waits = [], []
    for number, (quoted, times, control, marker, point) in enumerate(steps):
        segment = segments.get(quoted.strip('"'))
        demand(segment is not None, f"{quoted} is no segment")
        demand(marker == "lowAtStart" and 4 <= int(point) <= len(segment) - 3, f"the marker of step {number} is off")
        demand(1 <= int(times) <= MOST_REPEATS, f"step {number} repeats {times} times")
        if control in ("onceWaitTrig", "repeatInf"):
            demand((control == "onceWaitTrig") == (number < len(steps) - 1) and len(set(segment)) == 1, f"step {number} stops, or swings")
            waits.append(segment[0])
            if control == "onceWaitTrig":
                parts.append([])
        else:
            demand(control == "repeat" or (control, times) == ("once", "1"), f"step {number} goes on by {control}")
            demand(parts, f"step {number} comes before the trigger")
            parts[-1] += segment * int(times)
    ends = [step[2] for step in (steps[0], steps[-1])]
    demand(ends == ["onceWaitTrig", "repeatInf"], f"it waits and rests by {ends}")
    return waits, parts
