"""A simulated PI controller that answers lines of the General Command Set as the manual of the E-727 describes.

It has wave tables of straight segments, wave generators with a table rate, servo, targets, and the error of the last command. Time is not
simulated: a wave is complete as soon as it is started, and the commanded positions of each axis are recorded, one per servo cycle.
"""

import socket
import threading

SERVO_CYCLE_S = 50e-6
TRAVEL_UM = (-20.0, 120.0)
# Error codes of the command set: unknown command, syntax error, parameter out of range, move without servo, stopped by command.
UNKNOWN, SYNTAX, OUT_OF_RANGE, SERVO_OFF, STOPPED = 2, 1, 17, 5, 10


class GcsController:
    """Listens at `address` for one sender after another.

    A command that begins with `refuse` raises an error. A controller that `is_busy` moves until it is stopped.
    """

    def __init__(self, axes=3, refuse=None, table_points=1 << 20, is_busy=False):
        self.axes = [str(axis) for axis in range(1, axes + 1)]
        self.refuse, self.table_points, self.is_busy = refuse, table_points, is_busy
        self.error, self.lines = 0, []
        self.tables, self.connected, self.rates = {}, {}, dict.fromkeys(self.axes, 1)
        self.servo, self.target = dict.fromkeys(self.axes, False), dict.fromkeys(self.axes, 0.0)
        # Waves played: for each start, its mode and the positions of each axis.
        self.played, self.stops, self.pulse = [], 0, []
        self.server = socket.create_server(("127.0.0.1", 0))
        self.address = "127.0.0.1:%d" % self.server.getsockname()[1]
        threading.Thread(target=self.serve, daemon=True).start()

    def serve(self):
        while True:
            try:
                line, _ = self.server.accept()
            except OSError:
                return
            with line:
                self.talk(line)

    def talk(self, line):
        data = b""
        while True:
            # Single-byte commands (stop all, wave generator status) are accepted at any time.
            while data and (data[:1] in b"\x18\x09" or b"\n" in data):
                if data[:1] == b"\x18":
                    self.error, self.stops, data = STOPPED, self.stops + 1, data[1:]
                elif data[:1] == b"\x09":
                    data = data[1:]
                    line.sendall(b"7\n" if self.is_busy and not self.stops else b"0\n")
                else:
                    command, _, data = data.partition(b"\n")
                    answer = self.obey(command.decode("ascii"))
                    if answer is not None:
                        line.sendall(" \n".join(answer).encode("ascii") + b"\n")
            try:
                more = line.recv(1 << 16)
            except OSError:
                return
            if not more:
                return
            data += more

    def obey(self, command):
        """Executes a line; returns the lines of the answer, or None for a command without one."""
        self.lines.append(command)
        word, *words = command.split()
        if word == "ERR?":
            error, self.error = self.error, 0
            return [str(error)]
        if self.refuse and command.startswith(self.refuse):
            self.error = OUT_OF_RANGE
            return ["?"] if word.endswith("?") else None
        try:
            return getattr(self, {"?": "ask_"}.get(word[-1], "do_") + word.rstrip("?").lower())(*words)
        except AttributeError:
            self.error = UNKNOWN
        except (ValueError, KeyError, TypeError, AssertionError):
            self.error = SYNTAX
        return None

    def pairs(self, words):
        assert len(words) % 2 == 0
        return [(words[index], words[index + 1]) for index in range(0, len(words), 2)]

    def ask_spa(self, item, parameter):
        assert item in self.axes and parameter == "0x0E000200"
        return [f"{item} {parameter}={SERVO_CYCLE_S:e}"]

    def ask_tmn(self, *axes):
        return [f"{axis}={TRAVEL_UM[0]}" for axis in axes]

    def ask_tmx(self, *axes):
        return [f"{axis}={TRAVEL_UM[1]}" for axis in axes]

    def ask_ont(self, *axes):
        return [f"{axis}={int(self.servo[axis])}" for axis in axes]

    def do_svo(self, *words):
        for axis, state in self.pairs(words):
            self.servo[axis] = state == "1"

    def do_mov(self, *words):
        for axis, place in self.pairs(words):
            if not self.servo[axis]:
                self.error = SERVO_OFF
            elif not TRAVEL_UM[0] <= float(place) <= TRAVEL_UM[1]:
                self.error = OUT_OF_RANGE
            else:
                self.target[axis] = float(place)

    def do_wav(self, table, append, sort, *numbers):
        """Writes or appends a straight segment to a wave table.

        `numbers` are the segment length in points, amplitude, offset, curve length in points, start point, and acceleration points.
        """
        assert sort == "LIN" and append in "X&" and len(numbers) == 6, "no more than ten words"
        length, way, start, line, first, speeding = (float(number) for number in numbers)
        assert line == length >= 1 and first == speeding == 0 and length == int(length)
        if append == "X":
            self.tables[table] = []
        points = self.tables[table]
        points += [start + way * index / length for index in range(int(length))]
        if len(points) > self.table_points or min(points[-int(length):]) < TRAVEL_UM[0] or max(points[-int(length):]) > TRAVEL_UM[1]:
            self.error = OUT_OF_RANGE

    def do_wsl(self, *words):
        for generator, table in self.pairs(words):
            assert table in self.tables
            self.connected[generator] = table

    def do_wgc(self, *words):
        assert all(cycles == "1" for _, cycles in self.pairs(words))

    def do_wtr(self, generator, rate, interpolation):
        assert interpolation == "1" and int(rate) >= 1
        self.rates[generator] = int(rate)

    def do_twc(self):
        self.pulse = []

    def do_cto(self, output, parameter, value):
        assert (output, parameter, value) == ("1", "3", "4"), "the pulses of the wave generator"

    def do_tws(self, output, point, level):
        self.pulse.append((output, point, level))

    def do_wgo(self, *words):
        modes = dict(self.pairs(words))
        assert len(set(modes.values())) == 1
        played = {}
        for generator in modes:
            table, rate = self.tables[self.connected[generator]], self.rates[generator]
            assert abs(self.target[generator] - table[0]) < 1e-5, "it would jump to the beginning of its table"
            # Linear interpolation between points, one position per servo cycle.
            later = [*table[1:], table[-1]]
            played[generator] = [a + (b - a) * cycle / rate for a, b in zip(table, later) for cycle in range(rate)]
            self.target[generator] = played[generator][-1]
        self.played.append((int(next(iter(modes.values()))), played))
