"""Reads a program with LinuxCNC's interpreter and prints its calls as JSON.

It runs in its own process so that LinuxCNC's libraries can be loaded.

    python linuxcnc_reader.py FOLDER PROGRAM      FOLDER holds the unpacked package
"""

import json
import sys
import tempfile
from pathlib import Path


class Canon:
    """Records the calls of the interpreter."""

    def __init__(self, parameter_file):
        self.parameter_file, self.calls = parameter_file, []

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        return lambda *arguments: self.calls.append([name, *(one for one in arguments if isinstance(one, (int, float, str)))])

    def get_tool(self, *_):
        return (0, *[0.0] * 12, 0)

    def get_external_length_units(self):
        return 1.0

    def get_external_angular_units(self):
        return 1.0

    def get_axis_mask(self):
        return 511

    def get_block_delete(self):
        return False

    def check_abort(self):
        return False


def main(folder, program):
    sys.path.append(str(Path(folder) / "usr/lib/python3/dist-packages"))
    import gcode

    with tempfile.TemporaryDirectory() as scratch:
        parameters = Path(scratch) / "parameters"
        parameters.touch()
        canon = Canon(str(parameters))
        status, line = gcode.parse(program, canon, "G21", "")
    error = gcode.strerror(status) if status > gcode.MIN_ERROR else None
    json.dump({"error": error, "line": line, "calls": canon.calls}, sys.stdout)


if __name__ == "__main__":
    main(*sys.argv[1:])
