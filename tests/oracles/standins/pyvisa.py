"""A stand-in for PyVISA with a waveform generator at every address, for tests of the sender.

It logs every message, byte for byte, to the file that STANDIN_LOG names. A message that begins with STANDIN_FAULT causes an error; one that
begins with STANDIN_INTERRUPT raises KeyboardInterrupt, like Ctrl-C.
"""

import json
import os


class Instrument:
    def __init__(self, address):
        self.address, self.errors = address, []

    def log(self, message):
        with open(os.environ["STANDIN_LOG"], "a", encoding="utf-8") as log:
            log.write(json.dumps([self.address, message.decode("latin-1")]) + "\n")
        if os.environ.get("STANDIN_INTERRUPT") and message.startswith(os.environ["STANDIN_INTERRUPT"].encode()):
            raise KeyboardInterrupt
        if os.environ.get("STANDIN_FAULT") and message.startswith(os.environ["STANDIN_FAULT"].encode()):
            self.errors.append('-222,"Data out of range"')

    def write_raw(self, message):
        assert message.endswith(b"\n")
        self.log(message[:-1])

    def write(self, message):
        self.log(message.encode("ascii"))

    def query(self, message):
        answers = {"*IDN?": "Stand-in,33522B,0,0", "*OPC?": "1"}
        if message == ":SYST:ERR?":
            return self.errors.pop(0) if self.errors else '+0,"No error"'
        return answers[message]

    def close(self):
        pass


class ResourceManager:
    def __init__(self, visa_library=""):
        pass

    def list_resources(self):
        return ("USB0::0x0957::0x2B07::MY0::INSTR",)

    def open_resource(self, address, timeout=None, read_termination=None, write_termination=None):
        assert timeout and read_termination == write_termination == "\n"
        return Instrument(address)
