"""VCD, read by two readers, vcdvcd and pyvcd. The voltages of a channel are reconstructed from its variables."""

import re

from vcd.reader import TokenKind, tokenize
from vcdvcd import VCDVCD

from schedule import held, swung
from verdict import demand

# Resolution of a position.
COUNT_UM = 0.01
UNIT_NS = {"ns": 1, "us": 10**3, "ms": 10**6, "s": 10**9}
COMMENT = re.compile(r"^\$comment (\S+) is (\S+) \[(V|um)\](.*), wire: (.*) \$end$", re.MULTILINE)


def judge(path, schedule):
    said = {name: (variable, unit, form, wire) for variable, name, unit, form, wire in COMMENT.findall(path.read_text("ascii"))}
    demand(list(said) == schedule.channels, "the comments are of other channels")
    wires = 0
    for reader in (by_vcdvcd, by_pyvcd):
        unit_ns, types, changes = reader(path)
        one_scale(unit_ns, schedule)
        for entry in schedule.document["channels"]:
            variable, unit, form, wire = said[entry["name"]]
            demand((unit, wire) == (entry["unit"], entry["wire"] or "none"), f"the comment of {variable} is another")
            names = [f"{entry['device']}.{variable}"]
            if entry["wire"]:
                names.append("wires." + re.sub(r"[.\[\]{}]", "_", entry["wire"]))
                wires += 1
            for name in names:
                compare(types, changes, unit_ns, name, form, entry["name"], schedule)
    return f"{len(schedule.channels)} channels and {wires // 2} wires are the schedule for vcdvcd and pyvcd"


def one_scale(unit_ns, schedule):
    """Checks that every instant is a whole number of units and, unless a unit is a second or a stage moves, that ten units would not do."""
    instants = {t for channel in schedule.channels for t in schedule.ends(channel)} | {schedule.duration_ns}
    demand(all(t % unit_ns == 0 for t in instants), f"a unit of {unit_ns} ns does not divide all instants")
    is_longest = unit_ns == 10**9 or any(map(schedule.is_stage, schedule.channels)) or any(t % (10 * unit_ns) for t in instants)
    demand(is_longest or not schedule.duration_ns, f"a unit of {10 * unit_ns} ns would do")


def compare(types, changes, unit_ns, name, form, channel, schedule):
    """Compares a channel, under one of its names, with the schedule."""

    def of(suffix, kind):
        demand(name + suffix in changes, f"{name}{suffix} is not there")
        demand(types[name + suffix] in (None, kind), f"{name}{suffix} is {types[name + suffix]}, not {kind}")
        own = changes[name + suffix]
        return [t * unit_ns for t, _ in own], [v for _, v in own]

    if schedule.is_stage(channel):
        demand("nearest multiple of 0.01 um" in form, f"the comment of {name} says{form}")
        counts(*of("", "real"), name, channel, schedule)
        return
    if schedule.periods(channel):
        value = train([of("_train", "wire"), *(of(suffix, "real") for suffix in ("_first", "_second", "_period_ns"))])
    else:
        levels = {last for _, _, _, last, _ in schedule.pulses[channel]} | {schedule.rests_v[channel]}
        levels -= {0.0}
        volts = re.fullmatch(", 1 stands for (.*) V", form)
        demand(len(levels) == 1 if volts else not levels or form == "", f"the comment of {name} says{form}")
        demand(len(levels) < 2 or form == "", f"the comment of {name} says{form}")
        one = float(volts[1]) if volts else 1.0
        times, values = of("", "wire" if len(levels) < 2 else "real")
        value = lambda t_ns: one * held(times, values, t_ns)  # noqa: E731
    for t_ns in schedule.instants():
        found, expected = value(t_ns), schedule.value(channel, t_ns)
        demand(found == expected, f"{name} is {found} at {t_ns} ns, not {expected}")


def train(series):
    """The voltage as a function of time, from a train's bit, its two levels and its period; a train begins where one of them changes."""
    starts = sorted({t for times, values in series for (t, v), last in zip(zip(times, values), [None, *values]) if v != last})

    def value(t_ns):
        runs, first, second, period_ns = (held(times, values, t_ns) for times, values in series)
        demand(bool(runs) == bool(period_ns) and (runs or first == second), f"a train has a period of {period_ns} ns at {t_ns} ns")
        return swung(t_ns, first, second, int(period_ns), held(starts, starts, t_ns))

    return value


def counts(times, values, name, channel, schedule):
    """Checks that positions are the nearest multiple of 0.01 um, on both sides of every change, at every bend, and at the end."""
    instants = {*schedule.edges(channel), *times, *(t - 1 for t in times), 0, schedule.duration_ns}
    for t_ns in sorted(t for t in instants if t >= 0):
        found, expected = held(times, values, t_ns), schedule.value(channel, t_ns)
        demand(abs(found - expected) <= COUNT_UM / 2 + 1e-6, f"{name} is {found} um at {t_ns} ns, not {expected} um")
        demand(abs(found - round(found / COUNT_UM) * COUNT_UM) < 1e-9, f"{name} is {found} um, which is no count")


def by_vcdvcd(path):
    file = VCDVCD(str(path))
    demand(file.endtime is not None, "there is no end")
    unit_ns = round(file.timescale["timescale"] * 10**9)
    kinds = {name: file[name].var_type for name in file.signals}
    return unit_ns, kinds, {name: [(t, float(v)) for t, v in file[name].tv] for name in file.signals}


def by_pyvcd(path):
    scopes, names, types, changes, now, unit_ns = [], {}, {}, {}, 0, None
    with open(path, "rb") as file:
        for token in tokenize(file):
            match token.kind:
                case TokenKind.TIMESCALE:
                    unit_ns = token.timescale.magnitude * UNIT_NS[token.timescale.unit.value]
                case TokenKind.SCOPE:
                    scopes.append(token.scope.ident)
                case TokenKind.UPSCOPE:
                    scopes.pop()
                case TokenKind.VAR:
                    kind = token.var.type_.value
                    demand((kind, token.var.size) in (("real", 64), ("wire", 1)), f"a variable is {kind} of {token.var.size} bits")
                    name = ".".join([*scopes, token.var.reference])
                    names.setdefault(token.var.id_code, []).append(name)
                    changes[name], types[name] = [], kind
                case TokenKind.CHANGE_TIME:
                    demand(token.time_change >= now, "time goes back")
                    now = token.time_change
                case TokenKind.CHANGE_REAL | TokenKind.CHANGE_SCALAR:
                    change = token.data
                    for name in names[change.id_code]:
                        changes[name].append((now, float(change.value)))
    return unit_ns, types, changes
