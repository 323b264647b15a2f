"""VCD, read by two readers: vcdvcd and pyvcd."""

from vcd.reader import TokenKind, tokenize
from vcdvcd import VCDVCD

from schedule import held
from verdict import demand

# What a count of a position stands for.
COUNT_UM = 0.01


def judge(path, schedule):
    wires = {f"wires.{wire}": name for name, wire in schedule.wires.items() if wire}
    for reader in (by_vcdvcd, by_pyvcd):
        changes = reader(path)
        for channel in schedule.channels:
            compare(changes, channel, channel, schedule)
        for wire, channel in wires.items():
            compare(changes, wire, channel, schedule)
    return f"{len(schedule.channels)} channels and {len(wires)} wires are the schedule for vcdvcd and pyvcd"


def compare(changes, name, channel, schedule):
    demand(name in changes, f"{name} is not there")
    times = [t for t, _ in changes[name]]
    values = [v for _, v in changes[name]]
    if schedule.is_stage(channel):
        counts(times, values, name, channel, schedule)
        return
    for t_ns in schedule.instants():
        found, expected = held(times, values, t_ns), schedule.value(channel, t_ns)
        demand(found == expected, f"{name} is {found} at {t_ns} ns, not {expected}")


def counts(times, values, name, channel, schedule):
    """A position is the nearest multiple of 0.01 um, on both sides of every change, at every bend, and at the end."""
    instants = {*schedule.edges(channel), *times, *(t - 1 for t in times), 0, schedule.duration_ns}
    for t_ns in sorted(t for t in instants if t >= 0):
        found, expected = held(times, values, t_ns), schedule.value(channel, t_ns)
        demand(abs(found - expected) <= COUNT_UM / 2 + 1e-6, f"{name} is {found} um at {t_ns} ns, not {expected} um")
        demand(abs(found - round(found / COUNT_UM) * COUNT_UM) < 1e-9, f"{name} is {found} um, which is no count")


def by_vcdvcd(path):
    file = VCDVCD(str(path))
    demand(file.timescale["timescale"] * 10**9 == 1, f"the timescale is {file.timescale}")
    demand(file.endtime is not None, "there is no end")
    return {name: [(t, float(v)) for t, v in file[name].tv] for name in file.signals}


def by_pyvcd(path):
    scopes, names, changes, now = [], {}, {}, 0
    with open(path, "rb") as file:
        for token in tokenize(file):
            match token.kind:
                case TokenKind.TIMESCALE:
                    demand(str(token.timescale) == "1 ns", f"the timescale is {token.timescale}")
                case TokenKind.SCOPE:
                    scopes.append(token.scope.ident)
                case TokenKind.UPSCOPE:
                    scopes.pop()
                case TokenKind.VAR:
                    demand(token.var.type_.value == "real", "a variable is not real")
                    name = ".".join([*scopes, token.var.reference])
                    names.setdefault(token.var.id_code, []).append(name)
                    changes[name] = []
                case TokenKind.CHANGE_TIME:
                    demand(token.time_change >= now, "time goes back")
                    now = token.time_change
                case TokenKind.CHANGE_REAL:
                    for name in names[token.real_change.id_code]:
                        changes[name].append((now, token.real_change.value))
    return changes
