"""A stand-in for National Instruments' package: the calls that senders use, as its documentation describes them.

Nothing is played. When closed, each task writes a line to the file that STANDIN_LOG names. The call that STANDIN_FAULT names raises each
time or, as in `write:3`, the third time; the call that STANDIN_INTERRUPT names raises KeyboardInterrupt. The channels of a clocked task are
reserved for it from its first write until it is closed. Digital inputs read low STANDIN_LOW times, then high.
"""

import json
import os

from . import constants, system  # noqa: F401

OPENED = 0
READ = 0


class DaqError(Exception):
    """Stands for the package's exception."""


CALLS = {}
RESERVED = {}


def attempt(call):
    CALLS[call] = CALLS.get(call, 0) + 1
    if os.environ.get("STANDIN_FAULT") in (call, f"{call}:{CALLS[call]}"):
        raise DaqError(f"{call} failed, as it was asked to")
    if os.environ.get("STANDIN_INTERRUPT") == call:
        raise KeyboardInterrupt


class Task:
    def __init__(self, new_task_name=""):
        global OPENED
        OPENED += 1
        self.record = {"order": OPENED, "device": None, "kind": None, "channels": [], "clock": {}, "levels": [], "rest": {},
                       "started": False, "waited": False, "closed": False}
        self.do_channels = self.ao_channels = self.di_channels = self.timing = self.export_signals = self
        self.triggers = self.start_trigger = self

    def add(self, kind, channel):
        device = channel.split("/")[0]
        assert self.record["kind"] in (None, kind) and self.record["device"] in (None, device), "one device and sort a task"
        self.record |= {"kind": kind, "device": device}
        self.record["channels"].append(channel)

    def add_do_chan(self, lines, name_to_assign_to_lines="", line_grouping=None):
        assert line_grouping is constants.LineGrouping.CHAN_PER_LINE, "a channel for each line"
        self.add("do", lines)

    def add_di_chan(self, lines, name_to_assign_to_lines="", line_grouping=None):
        assert line_grouping is constants.LineGrouping.CHAN_PER_LINE, "a channel for each line"
        self.add("di", lines)

    def read(self, number_of_samples_per_channel=None, timeout=10.0):
        global READ
        attempt("read")
        assert self.record["kind"] == "di" and len(self.record["channels"]) == 1
        READ += 1
        return READ > int(os.environ.get("STANDIN_LOW", "0"))

    def add_ao_voltage_chan(self, physical_channel, name_to_assign_to_channel="", min_val=-10.0, max_val=10.0):
        self.range = (min_val, max_val)
        self.add("ao", physical_channel)

    def cfg_samp_clk_timing(self, rate, source="", active_edge=None, sample_mode=None, samps_per_chan=1000):
        assert sample_mode is constants.AcquisitionType.FINITE and samps_per_chan >= 2
        self.record["clock"] = {"rate": rate, "source": source, "samps_per_chan": samps_per_chan}

    def cfg_dig_edge_start_trig(self, trigger_source, trigger_edge=None):
        self.record["start"] = trigger_source

    def export_signal(self, signal_id, output_terminal):
        assert signal_id is constants.Signal.START_TRIGGER
        self.record["leads"] = output_terminal

    def write(self, data, auto_start=False, timeout=10.0):
        alone = len(self.record["channels"]) == 1
        rows = [data] if alone else data
        assert len(rows) == len(self.record["channels"]), "a row for each channel"
        clocked = bool(self.record["clock"])
        if any(RESERVED.get(channel, self) is not self for channel in self.record["channels"]):
            raise DaqError("the specified resource is reserved")
        if clocked:
            RESERVED.update(dict.fromkeys(self.record["channels"], self))
        attempt("write")
        assert auto_start != clocked, "a clocked task is started on its own, one without a clock at once"
        for row in rows:
            for level in row if clocked else [row]:
                if self.record["kind"] == "do":
                    assert isinstance(level, bool), "lines are on or off"
                else:
                    assert isinstance(level, float) and self.range[0] - 1e-9 <= level <= self.range[1] + 1e-9, f"{level} V is out of range"
        if clocked:
            assert all(len(row) == self.record["clock"]["samps_per_chan"] for row in rows)
            self.record["levels"] = rows
        else:
            self.record["rest"] = dict(zip(self.record["channels"], rows))

    def start(self):
        attempt("start")
        assert self.record["levels"], "nothing was written"
        self.record["started"] = True

    def wait_until_done(self, timeout=10.0):
        attempt("wait_until_done")
        assert self.record["started"]
        self.record["waited"] = True

    def stop(self):
        pass

    def close(self):
        if not self.record["closed"]:
            self.record["closed"] = True
            for channel in [channel for channel, task in RESERVED.items() if task is self]:
                del RESERVED[channel]
            if os.environ.get("STANDIN_LOG"):
                with open(os.environ["STANDIN_LOG"], "a", encoding="utf-8") as log:
                    log.write(json.dumps(self.record) + "\n")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()
