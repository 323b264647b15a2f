"""The constants that senders use."""

import enum


class AcquisitionType(enum.Enum):
    FINITE = 10178


class LineGrouping(enum.Enum):
    CHAN_PER_LINE = 0
    CHAN_FOR_ALL_LINES = 1


class Signal(enum.Enum):
    START_TRIGGER = 12491
