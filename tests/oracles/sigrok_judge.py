"""VCD, imported by sigrok-cli as PulseView does: the levels of all 1-bit wires against the schedule."""

import re
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy

from vcd_judge import COMMENT, UNIT_NS
from verdict import Skipped, demand


def judge(path, schedule):
    sigrok = shutil.which("sigrok-cli")
    if not sigrok:
        raise Skipped("sigrok-cli is not installed")
    text = path.read_text("ascii")
    names = re.findall(r"^\$var wire 1 \S+ (\S+) \$end$", text, re.MULTILINE)
    if not names:
        return "it has no wires, which is all that sigrok takes"
    magnitude, unit = re.search(r"^\$timescale (\d+) (\w+) \$end$", text, re.MULTILINE).groups()
    samples = imported(sigrok, path, names)
    unit_ns = int(magnitude) * UNIT_NS[unit]
    demand(len(samples) == schedule.duration_ns // unit_ns, f"sigrok makes {len(samples)} samples of {unit_ns} ns")
    instants = numpy.array([t for t in schedule.instants() if t < schedule.duration_ns])
    channels = channel_of(text, schedule)
    for index, name in enumerate(names):
        channel = channels[name]
        found = samples[instants // unit_ns, index // 8] >> (index % 8) & 1
        runs = bool(schedule.periods(channel))
        wanted = [int((schedule.drive(channel, int(t))[2] if runs else schedule.value(channel, int(t))) != 0) for t in instants]
        wrong = numpy.flatnonzero(found != wanted)
        demand(wrong.size == 0, f"sigrok has {name} at {found[wrong[:1]]} at {instants[wrong[:1]]} ns")
    return f"sigrok imports {len(names)} wires in {len(samples)} samples; they are the schedule at {len(instants)} instants"


def imported(sigrok, path, names):
    """The imported samples, a row of bytes each, whose bits are the wires in order (least significant bit first)."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "samples"
        run = [sigrok, "-l", "3", "-I", "vcd", "-i", str(path)]
        shown = subprocess.run([*run, "--show"], capture_output=True, text=True, timeout=300)
        found = re.findall(r"^- (\S+): logic$", shown.stdout, re.MULTILINE)
        # Later versions prefix names with their scope.
        demand([name.rpartition(".")[2] for name in found] == names, f"sigrok finds {len(found)} wires of {len(names)}: {shown.stderr[-300:]}")
        made = subprocess.run([*run, "-O", "binary", "-o", str(out)], capture_output=True, text=True, timeout=300)
        demand(made.returncode == 0 and out.exists(), f"sigrok imports nothing: {made.stderr[-300:]}")
        samples = re.sub(rb"^META samplerate: \d+\n", b"", out.read_bytes(), count=1)
        return numpy.frombuffer(samples, dtype=numpy.uint8).reshape(-1, (len(names) + 7) // 8)


def channel_of(text, schedule):
    """The channel of each 1-bit wire, by the wire's name."""
    channels = {}
    for variable, name, _, _, wire in COMMENT.findall(text):
        for start in (variable, re.sub(r"[.\[\]{}]", "_", wire)):
            channels |= {start: name, f"{start}_train": name}
    return channels
