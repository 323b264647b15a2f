"""The GTKWave save file: it shows every variable of the VCD file beside it once, under a name that GTKWave finds."""

import re

from vcd_judge import UNIT_NS, by_pyvcd
from verdict import Skipped, demand


def judge(path, schedule):
    vcd = path.with_suffix(".vcd")
    if not vcd.exists():
        raise Skipped(f"{vcd.name} is not there")
    text = path.read_text("ascii")
    demand(f'[dumpfile] "{vcd.name}"\n' in text and f'[savefile] "{path.name}"\n' in text, "it is for another file")
    _, types, _ = by_pyvcd(vcd)
    rows = re.findall(r"^@(28|8420)\n([^-\n].*)$", text, re.MULTILINE)
    shown = {name: flags for flags, name in rows}
    wanted = {name: "28" if kind == "wire" else "8420" for name, kind in types.items() if not name.startswith("wires.")}
    demand(len(rows) == len(shown) and shown == wanted, f"these differ: {sorted(shown.items() ^ wanted.items())[:4]}")
    groups = re.findall(r"^@(800200|1000200)\n-(\S+)$", text, re.MULTILINE)
    devices = list(dict.fromkeys(channel["device"] for channel in schedule.document["channels"]))
    demand(groups == [(flag, device) for device in devices for flag in ("800200", "1000200")], "the groups are others")
    # At zoom 0 a window shows at least 4 units; GTKWave counts timescales of 10 us and 100 us in us.
    unit = re.search(r"^\$timescale \d+ (\w+) \$end$", vcd.read_text("ascii"), re.MULTILINE)[1]
    zoom = int(re.search(r"^\*-(\d+)\.", text, re.MULTILINE)[1])
    wanted = schedule.duration_ns / UNIT_NS[unit] / 4
    demand(2**zoom >= wanted and (2 ** (zoom - 1) < wanted or not zoom), f"zoom {zoom} does not fit {4 * wanted} {unit}")
    inner = [name for name in shown if name.count(".") != 1]
    demand(not inner, f"GTKWave would not find {inner[:3]}")
    return f"{len(shown)} rows in {len(devices)} groups are the variables of {vcd.name}"
