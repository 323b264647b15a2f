"""Writes the description of a simulated arbitrary-waveform generator for pyvisa-sim.

It accepts the messages below and nothing else; every setting can be queried.
"""

import yaml

# Outputs of one instrument. The simulation tries every message on every output, so schedules with hundreds of outputs use a rack.
OUTPUTS = 32

NUMBER = {"min": 0, "max": 1000, "type": "float"}


def properties():
    """The settings of one output: header, default, and accepted values."""
    settings = {
        "segment": (":SOUR{ch_id}:FUNC:ARB", "NONE", None),
        "rate": (":SOUR{ch_id}:FUNC:ARB:SRAT", "40000", {"min": 1e-6, "max": 1e9, "type": "float"}),
        "filter": (":SOUR{ch_id}:FUNC:ARB:FILT", "NORM", {"valid": ["NORM", "STEP", "OFF"], "type": "str"}),
        "sequence": (":SOUR{ch_id}:DATA:SEQ", "none", None),
        "load": (":OUTP{ch_id}:LOAD", "50", {"valid": ["INF", "50"], "type": "str"}),
        "span": (":SOUR{ch_id}:VOLT", "0.1", NUMBER),
        "offset": (":SOUR{ch_id}:VOLT:OFFS", "0", {"min": -1000, "max": 1000, "type": "float"}),
        "function": (":SOUR{ch_id}:FUNC", "SIN", {"valid": ["SIN", "DC", "ARB"], "type": "str"}),
        "burst_mode": (":SOUR{ch_id}:BURS:MODE", "GAT", {"valid": ["TRIG", "GAT"], "type": "str"}),
        "cycles": (":SOUR{ch_id}:BURS:NCYC", "5", {"min": 1, "max": 100000, "type": "int"}),
        "trigger": (":TRIG{ch_id}:SOUR", "IMM", {"valid": ["IMM", "EXT", "BUS"], "type": "str"}),
        "burst": (":SOUR{ch_id}:BURS:STAT", "OFF", {"valid": ["ON", "OFF"], "type": "str"}),
        "output": (":OUTP{ch_id}", "OFF", {"valid": ["ON", "OFF"], "type": "str"}),
        "data": (":SOUR{ch_id}:DATA:ARB:DAC", "none", None),
    }
    described = {}
    for name, (header, default, specs) in settings.items():
        described[name] = {
            "default": default,
            "getter": {"q": f"{header}?", "r": "{}"},
            "setter": {"q": f"{header} {{}}"},
        }
        if specs:
            described[name]["specs"] = specs
    return described


def address(index):
    """The resource name of an instrument of the rack; instrument 0 has outputs 1 to OUTPUTS."""
    return f"TCPIP::awg{index}::INSTR"


def write(path, outputs):
    """Writes the description of a rack with `outputs` consecutively numbered outputs, to be opened as `<path>@sim`.

    Returns the resource names of its instruments.
    """
    starts = range(1, outputs + 1, OUTPUTS)
    devices = {f"awg{index}": device(range(start, start + OUTPUTS)) for index, start in enumerate(starts)}
    resources = {address(index): {"device": f"awg{index}"} for index in range(len(starts))}
    path.write_text(yaml.safe_dump({"spec": "1.1", "devices": devices, "resources": resources}))
    return list(resources)


def device(outputs):
    """The description of one instrument with these outputs."""
    silent = ["*RST", "*CLS", ":FORM:BORD NORM", ":OUTP:TRIG:SLOP POS", ":OUTP:TRIG ON", "*TRG"]
    return {
        "eom": {"TCPIP INSTR": {"q": "\n", "r": "\n"}},
        "error": {
            "status_register": [{"q": "*ESR?", "command_error": 32, "query_error": 4}],
            "error_queue": [
                {
                    "q": ":SYST:ERR?",
                    "default": '0,"No error"',
                    "command_error": '-100,"Command error"',
                    "query_error": '-400,"Query error"',
                }
            ],
        },
        "dialogues": [{"q": message} for message in silent],
        "channels": {
            "output": {
                "ids": list(outputs),
                "can_select": True,
                "dialogues": [{"q": ":SOUR{ch_id}:DATA:VOL:CLE"}],
                "properties": properties(),
            }
        },
    }
