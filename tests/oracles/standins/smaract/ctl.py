"""A stand-in for SmarAct's package: the MCS2 calls that the sender uses, as SmarAct's examples and header file have them.

Each call is logged as a line of JSON to the file that STANDIN_LOG names. The calls that STANDIN_FAULT names (separated by commas) raise an
error; the call that STANDIN_INTERRUPT names raises KeyboardInterrupt, like Ctrl-C.
"""

import json
import os
from enum import IntEnum

TRUE, FALSE = 1, 0
Property = IntEnum("Property", "CHANNEL_STATE POSITION SENSOR_POWER_MODE AMPLIFIER_ENABLED MOVE_MODE MOVE_VELOCITY MOVE_ACCELERATION STREAM_BASE_RATE")
MoveMode = IntEnum("MoveMode", "CL_ABSOLUTE CL_RELATIVE STEP", start=0)
SensorPowerMode = IntEnum("SensorPowerMode", "DISABLED ENABLED POWER_SAVE", start=0)
StreamTriggerMode = IntEnum("StreamTriggerMode", "DIRECT EXTERNAL_ONCE EXTERNAL_SYNC EXTERNAL", start=0)


class ChannelState(IntEnum):
    ACTIVELY_MOVING = 0x1
    MOVEMENT_FAILED = 0x800
    IS_STREAMING = 0x1000


class Error(Exception):
    """Stands for the package's exception."""


PROPERTIES, PLACES, STREAM = {}, {}, {}


def called(name, *arguments):
    if os.environ.get("STANDIN_LOG"):
        with open(os.environ["STANDIN_LOG"], "a", encoding="utf-8") as log:
            log.write(json.dumps([name, *arguments]) + "\n")
    if name in os.environ.get("STANDIN_FAULT", "").split(","):
        raise Error(f"{name} failed, as it was asked to")
    if os.environ.get("STANDIN_INTERRUPT") == name:
        raise KeyboardInterrupt


def Open(locator, config=""):
    called("Open", locator)
    return 1


def Close(handle):
    called("Close")


def SetProperty_i32(handle, channel, key, value):
    called("SetProperty_i32", channel, key.name, int(value))
    if key is Property.STREAM_BASE_RATE:
        assert channel == 0 and isinstance(value, int) and 10 <= value <= 1000
    PROPERTIES[channel, key] = value


def SetProperty_i64(handle, channel, key, value):
    called("SetProperty_i64", channel, key.name, value)
    assert isinstance(value, int)
    PROPERTIES[channel, key] = value


def GetProperty_i32(handle, channel, key):
    assert key is Property.CHANNEL_STATE
    return 0


def Move(handle, channel, value, transmit=0):
    called("Move", channel, value)
    assert isinstance(value, int) and PROPERTIES[channel, Property.MOVE_MODE] is MoveMode.CL_ABSOLUTE
    assert PROPERTIES[channel, Property.AMPLIFIER_ENABLED] and PROPERTIES[channel, Property.MOVE_VELOCITY] > 0
    PLACES[channel] = value


def Stop(handle, channel, transmit=0):
    called("Stop", channel)


def OpenStream(handle, mode):
    called("OpenStream", mode.name)
    # SmarAct's package refuses to stream while sensors are in power-save mode.
    assert all(PROPERTIES[channel, Property.SENSOR_POWER_MODE] is SensorPowerMode.ENABLED for channel in PLACES)
    STREAM["frames"] = 0
    return 7


def StreamFrame(handle, stream, frame):
    channels, places = frame[::2], frame[1::2]
    called("StreamFrame", *frame)
    assert stream == 7 and channels == sorted(set(channels)) and all(isinstance(number, int) for number in frame)
    if STREAM["frames"] == 0:
        assert all(PLACES[channel] == place for channel, place in zip(channels, places)), "the stages are elsewhere when the stream begins"
    STREAM["frames"] += 1


def CloseStream(handle, stream):
    called("CloseStream")


def AbortStream(handle, stream):
    called("AbortStream")
