"""Tests that the judge that reads logs as Rerun does finds what Rerun would not show."""

import os
import shutil
from pathlib import Path

import pytest

FIXTURES = Path(os.environ.get("TWEEZE_FIXTURES", "/nonexistent"))

pytestmark = pytest.mark.skipif(not FIXTURES.exists(), reason="TWEEZE_FIXTURES names no folder")
pytest.importorskip("rerun")

from mcap.reader import make_reader  # noqa: E402
from mcap.writer import Writer  # noqa: E402

import rerun_judge  # noqa: E402
from schedule import Schedule  # noqa: E402
from verdict import Wrong  # noqa: E402


def copied(source, target, keep):
    """Copies the messages of a log for which `keep(topic, log_time)` holds."""
    with open(source, "rb") as read, open(target, "wb") as written:
        writer = Writer(written)
        writer.start()
        schemas, channels = {}, {}
        for schema, channel, message in make_reader(read).iter_messages():
            if not keep(channel.topic, message.log_time):
                continue
            if schema.id not in schemas:
                schemas[schema.id] = writer.register_schema(schema.name, schema.encoding, schema.data)
            if channel.id not in channels:
                channels[channel.id] = writer.register_channel(channel.topic, channel.message_encoding, schemas[schema.id], channel.metadata)
            writer.add_message(channels[channel.id], message.log_time, message.data, message.publish_time, message.sequence)
        writer.finish()


@pytest.mark.parametrize("stem", ["Pair", "turn", "bed"])
def test_a_copy_of_a_log_is_right_and_one_without_its_clouds_is_not(tmp_path, stem):
    schedule = Schedule(FIXTURES / f"{stem}.json")
    log = tmp_path / f"{stem}.mcap"
    copied(FIXTURES / log.name, log, lambda topic, t_ns: True)
    said = rerun_judge.judge(log, schedule)
    if said.startswith("nothing moves"):
        return
    copied(FIXTURES / log.name, log, lambda topic, t_ns: not topic.endswith("/points"))
    with pytest.raises(Wrong, match="Rerun draws nothing there"):
        rerun_judge.judge(log, schedule)


def test_instants_that_look_the_same_are_found(tmp_path):
    """With all motion put at instant 0, all later instants look like the first."""
    log = tmp_path / "Pair.mcap"
    shutil.copy(FIXTURES / "Pair.mcap", log)
    frames, clouds = rerun_judge.drawn(log)
    moving = {frame for frame, (_, places) in frames.items() if (places != places[0]).any()}
    assert moving and all(clouds[frame] for frame in moving)
    early = {frame: (times * 0, places) for frame, (times, places) in frames.items()}
    looks = [rerun_judge.view(early, t_ns) for t_ns in (0, 10**6, 10**9)]
    assert all((look == looks[0]).all() for look in looks)
    late = [rerun_judge.view(frames, t_ns) for t_ns in (0, 10**9)]
    assert (late[0] != late[1]).any()
