"""A stand-in for the DropBot package, for tests of the sender: a proxy with the attributes that its documentation shows.

Each channel state that takes effect, and each setting, is logged with its time to the file that STANDIN_LOG names. STANDIN_FAULT is the
number of the state at which the connection breaks once, STANDIN_LOST that at which the first board is lost for good. A second board has
its own file, whose name ends in .2.
"""

import json
import os
import time

CHANNELS = 120


class SerialProxy:
    number_of_channels = CHANNELS
    made = 0

    def __init__(self, port=None):
        SerialProxy.made += 1
        self.number, self.states = SerialProxy.made, 0
        self.log("port", port)

    def log(self, name, value):
        ending = "" if self.number == 1 else f".{self.number}"
        with open(os.environ["STANDIN_LOG"] + ending, "a", encoding="utf-8") as log:
            log.write(json.dumps([time.monotonic(), name, value]) + "\n")

    def is_lost(self):
        return self.number == 1 and self.states >= int(os.environ.get("STANDIN_LOST", "1000000"))

    def __setattr__(self, name, value):
        if name not in ("number", "states") and self.is_lost():
            raise OSError("the board is lost")
        if name in ("voltage", "frequency", "hv_output_enabled", "hv_output_selected"):
            self.log(name, value)
        elif name == "state_of_channels":
            self.states += 1
            if self.is_lost() or os.environ.get("STANDIN_FAULT") == str(self.states):
                raise OSError("the board does not answer")
            # The property takes an array with one state per channel, not a list of channel numbers.
            assert value.shape == (CHANNELS,) and set(value.tolist()) <= {0, 1}
            self.log(name, [number for number, state in enumerate(value.tolist()) if state])
        super().__setattr__(name, value)

    def terminate(self):
        if self.is_lost():
            raise OSError("the board is lost")
        self.log("terminate", None)
