"""The plots that viewers draw of a log: its voltages and positions still show the schedule when decimated as viewers decimate.

A plot of 1,000 pixels is drawn from a few points per pixel, or from a thousand points in all. Wherever a channel holds its value for
several pixels, the drawn line must be within 1 % of the channel's range.
"""

import numpy
from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

from mcap_judge import TOPICS, columns, field
from verdict import demand

PIXELS = 1000
# Tolerance of the drawn line, as a fraction of the channel's range.
SHARE = 0.01
# Pixels on either side of a checked pixel in which the value must hold too, by decimation method.
MARGIN = {"pixel": 1, "triangle": 4}


def judge(path, schedule):
    with open(path, "rb") as file:
        topics = {}
        for _, channel, message, proto in make_reader(file, decoder_factories=[DecoderFactory()]).iter_decoded_messages():
            topics.setdefault(channel.topic, (channel, []))[1].append((message.log_time, proto))
    looked, curves = 0, 0
    if not schedule.duration_ns:
        return "it has no duration"
    for device, unit in sorted({(channel["device"], channel["unit"]) for channel in schedule.document["channels"]}):
        channel, messages = topics[f"/{device}/{TOPICS[unit]}"]
        times = numpy.array([t for t, _ in messages], dtype=float)
        fields = columns(channel.metadata, device, unit, schedule)
        # With very many channels, only some pixels of each are checked.
        stride = 1 + len(fields) // 20
        for path_, (name, bound) in fields.items():
            values = numpy.array([field(proto, path_) for _, proto in messages])
            if numpy.ptp(values) == 0:
                continue
            for way, thin in (("pixel", by_pixel), ("triangle", by_triangle)):
                looked += drawn(name, bound, way, *thin(times, values, schedule.duration_ns), schedule, numpy.ptp(values), stride)
            curves += 1
    return f"{curves} curves, thinned in two ways, are the schedule at {looked} pixels"


def by_pixel(times, values, duration_ns):
    """Keeps the first, least, greatest and last point of each pixel; like Lichtblick, drops the last if it equals the first."""
    pixel = numpy.minimum((times / duration_ns * PIXELS).astype(int), PIXELS - 1)
    keep = []
    for start, end in zip(*(lambda cuts: (cuts[:-1], cuts[1:]))(numpy.searchsorted(pixel, numpy.arange(PIXELS + 1)))):
        if end > start:
            own = values[start:end]
            chosen = {start, start + int(own.argmin()), start + int(own.argmax())}
            if own[-1] != own[0]:
                chosen.add(end - 1)
            keep += sorted(chosen)
    return times[keep], values[keep]


def by_triangle(times, values, _):
    """Decimates to one point per pixel by largest triangle three buckets (LTTB, Steinarsson's thesis of 2013)."""
    count = len(times)
    if count <= PIXELS:
        return times, values
    every = (count - 2) / (PIXELS - 2)
    keep, last = [0], 0
    for bucket in range(PIXELS - 2):
        start, end = int(bucket * every) + 1, int((bucket + 1) * every) + 1
        after = slice(end, max(end + 1, min(int((bucket + 2) * every) + 1, count)))
        x, y = times[after].mean(), values[after].mean()
        own = slice(start, end)
        area = abs((times[last] - x) * (values[own] - values[last]) - (times[last] - times[own]) * (y - values[last]))
        last = start + int(area.argmax())
        keep.append(last)
    keep.append(count - 1)
    return times[keep], values[keep]


def drawn(name, bound, way, times, values, schedule, range_, stride):
    """Checks the line through these points against the schedule; returns the number of pixels checked."""
    if schedule.is_stage(name):
        return 0
    middles = (numpy.arange(PIXELS) + 0.5) * schedule.duration_ns / PIXELS
    line = numpy.interp(middles, times, values)
    ends = numpy.array(schedule.ends(name))
    width = schedule.duration_ns / PIXELS * (MARGIN[way] + 0.5)
    near = numpy.searchsorted(ends, middles - width) != numpy.searchsorted(ends, middles + width)
    looked = 0
    for pixel in numpy.flatnonzero(~near)[::stride]:
        wanted = schedule.envelope(name, int(middles[pixel]))[bound or 0]
        looked += 1
        demand(abs(line[pixel] - wanted) <= SHARE * range_, f"{name} is drawn at {line[pixel]} by {way} at {middles[pixel]} ns, not {wanted}")
    return looked
