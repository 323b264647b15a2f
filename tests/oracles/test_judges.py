"""Tests of the judges themselves: each finds a fault that is put into a good file.

    TWEEZE_FIXTURES=DIR cargo test --lib emit::tests::write_fixtures -- --ignored
    TWEEZE_FIXTURES=DIR pytest tests/oracles
"""

import json
import os
import shutil
import struct
from pathlib import Path

import pytest

import daq_judge
import linuxcnc_judge
import run
import scpi_judge
from schedule import Schedule
from verdict import Skipped, Wrong

FIXTURES = Path(os.environ.get("TWEEZE_FIXTURES", "/nonexistent"))

pytestmark = pytest.mark.skipif(not FIXTURES.exists(), reason="TWEEZE_FIXTURES names no folder")


def verdict(folder, ending, stem="Pair"):
    """The verdict on the file with this ending; `sigrok` stands for the second judge of VCD."""
    ending, judge = (".vcd", "sigrok_judge") if ending == "sigrok" else (ending, run.JUDGES[ending])
    return run.judge(folder / f"{stem}{ending}", judge, Schedule(folder / f"{stem}.json"))


@pytest.fixture
def folder(tmp_path):
    for stem in ("Pair", "bed", "turn", "mixed"):
        for file in FIXTURES.glob(f"{stem}.*"):
            shutil.copy(file, tmp_path)
    return tmp_path


def replace(path, old, new):
    data = path.read_bytes()
    assert old in data
    path.write_bytes(data.replace(old, new, 1))


# Formats for instruments that these fixtures are not wired to.
PLAYED = (".daq", ".frames.py", ".microdrop", ".stages.py")


@pytest.mark.parametrize("stem,ending", [*(("Pair", ending) for ending in run.JUDGES if ending not in (".ngc", *PLAYED)), *(("turn", ending) for ending in run.JUDGES if ending not in PLAYED), *(("mixed", ending) for ending in run.JUDGES if ending not in (".ngc", *PLAYED))])
def test_a_good_file_is_right(folder, stem, ending):
    outcome, reason = verdict(folder, ending, stem)
    assert outcome in ("right", "SKIPPED"), reason


def test_slopes_are_right():
    outcomes = {name: outcome for name, outcome, _ in run.judge_folder(FIXTURES / "slopes")}
    expected = {"crowd.json": "right", "crowd.mcap": "right", "crowd.cir": "right", "crowd.svg": "right"}
    expected |= {"crowd.lichtblick.json": "right"}
    expected |= {"crowd.csv": "MISSING", "crowd.vcd": "MISSING", "crowd.gtkw": "MISSING"}
    assert outcomes == expected


def test_a_train_that_is_longer_than_its_deck_is_right():
    outcomes = {name: outcome for name, outcome, _ in run.judge_folder(FIXTURES / "trains")}
    expected = {f"long{ending}": "right" for ending in (".json", ".csv", ".vcd", ".gtkw", ".scpi", ".svg")}
    assert outcomes.pop("long.cir") in ("right", "SKIPPED")
    assert outcomes == expected | {"long.mcap": "MISSING", "long.lichtblick.json": "MISSING"}


FAULTS = [
    (".json", ".json", b'"unit": "V"', b'"unit": "A"'),
    (".csv", ".csv", b"\n15000000,", b"\n15000001,"),
    (".csv", ".csv", b"bot.bl0.set [V]", b"bot.bl0.set [mV]"),
    (".csv", ".csv", b"Dev1/port0/line0", b"Dev1/port0/line1"),
    (".csv", ".csv", b",20,", b",19.999999999,"),
    (".vcd", ".vcd", b"#150\n", b"#151\n"),
    (".vcd", ".vcd", b"1 stands for 20 V", b"1 stands for 19 V"),
    (".vcd", ".vcd", b"100 us", b"1 ms"),
    (".vcd", ".vcd", b"\n0a\n", b"\n"),
    (".vcd", ".vcd", b"Dev1/port0/line0 $end\n$var", b"Dev1/port0/line99 $end\n$var"),
    (".gtkw", ".gtkw", b"bot.bot_bl0_set", b"bot.bl0.set"),
    (".gtkw", ".gtkw", b"@28\n", b"@8420\n"),
    ("sigrok", ".vcd", b"#150\n", b"#151\n"),
    ("sigrok", ".vcd", b"100 us", b"10 us"),
    ("sigrok", ".vcd", b"\n1a\n", b"\n0a\n"),
    (".cir", ".cir", b"quit 0\n", b""),
    (".cir", ".pwl.inc", b"+ 0.015 20\n", b"+ 0.014 20\n"),
    (".cir", ".pwl.inc", b"+ 0.015 20\n", b"+ 0.015 20.00000001\n"),
    (".cir", ".pwl.inc", b"Vbot_bl0_set bot_bl0_set 0", b"Vbot_bl0_set bot_bl0_set 1"),
    (".cir", ".cir", b"0.1125\n", b"0.1\n"),
    (".scpi", ".awg.scpi", b":FUNC:ARB:SRAT 400\n", b":FUNC:ARB:SRAT 401\n"),
    (".scpi", ".awg.scpi", b":SOUR1:VOLT 0.4\n", b":SOUR1:VOLT 0.41\n"),
    (".scpi", ".awg.scpi", b":SOUR1:VOLT 0.4\n", b":SOUR1:VLT 0.4\n"),
    (".scpi", ".awg.scpi", b":SOUR1:VOLT:OFFS 0.2\n", b":SOUR1:VOLT:OFFS 0.21\n"),
    (".scpi", ".awg.scpi", b":OUTP1:LOAD INF\n", b""),
    (".scpi", ".awg.scpi", b":SOUR1:FUNC:ARB:FILT OFF\n", b":SOUR1:FUNC:ARB:FILT STEP\n"),
    (".scpi", ".awg.scpi", b",#294\x80\x01\x7f\xff", b",#294\x7f\xff\x7f\xff"),
    (".scpi", ".awg.scpi", b"\x7f\xff\x80\x01", b"\x80\x01\x80\x01"),
    (".scpi", ".json", b'"most_points": 1000000', b'"most_points": 40'),
    (".scpi", ".json", b'"least_points": 8', b'"least_points": 48'),
    (".scpi", ".json", b'"rate_hz": 62500000.0', b'"rate_hz": 300.0'),
    (".scpi", ".json", b'"peak_v": 10.0', b'"peak_v": 0.3'),
    (".scpi", ".json", b'"gain": 50.0', b'"gain": 49.0'),
    (".mcap", ".csv", b",20,", b",19.5,"),
    (".svg", ".svg", b"</svg>", b""),
    (".svg", ".svg", b"<title>", b"<script/><title>"),
    (".svg", ".svg", b"<title>", b'<g href="x"/><title>'),
    (".svg", ".svg", b'data-x-um="0"', b'data-x-um="0.01"'),
    (".svg", ".svg", b'data-scale="', b'data-scale="1'),
    (".svg", ".svg", b'data-device="Aid"', b'data-device="bot"'),
    (".svg", ".svg", b' stroke-width="0.35"', b' stroke-width="0.3"'),
    (".svg", ".svg", b'<text x="4"', b'<text x="-4"'),
]


@pytest.mark.parametrize("judged,broken,old,new", FAULTS)
def test_a_fault_is_found(folder, judged, broken, old, new):
    if verdict(folder, judged)[0] == "SKIPPED":
        pytest.skip("the judge is not here")
    replace(folder / f"Pair{broken}", old, new)
    outcome, reason = verdict(folder, judged)
    assert outcome == "WRONG", reason


# Faults in drive trains; the deck is judged last because ngspice takes a while.
TRAIN_FAULTS = [
    (".json", ".json", b'"period_ns": 50000', b'"period_ns": 50001'),
    (".csv", ".csv", b",130,115,50000,2000000\n", b",129,115,50000,2000000\n"),
    (".csv", ".csv", b",130,115,50000,2000000\n", b",115,130,50000,2000000\n"),
    (".csv", ".csv", b",130,115,50000,2000000\n", b",130,115,50000,2025000\n"),
    (".csv", ".csv", b"2000000,130,115,50000,2000000\n", b""),
    (".csv", ".csv", b"m.bed.first [V]", b"m.bed.second [V]"),
    (".vcd", ".vcd", b"\n1a\n", b"\n"),
    (".vcd", ".vcd", b"\n#320\n", b"\n#330\n"),
    (".vcd", ".vcd", b"r50000 d\n", b"r50002 d\n"),
    (".vcd", ".vcd", b"r130 b\nr115 c\n", b"r115 b\nr130 c\n"),
    ("sigrok", ".vcd", b"\n1a\n", b"\n"),
    (".cir", ".cir", b"quit 0\n", b""),
    (".scpi", ".awg.scpi", b",150,repeat,", b",149,repeat,"),
    (".scpi", ".awg.scpi", b",150,repeat,", b",150,repeatInf,"),
    (".scpi", ".awg.scpi", b",1,onceWaitTrig,", b",1,once,"),
    (".scpi", ".awg.scpi", b":FUNC:ARB:SRAT 40000", b":FUNC:ARB:SRAT 40001"),
    (".scpi", ".awg.scpi", b"lowAtStart,4,", b"lowAtStart,6,"),
    (".cir", ".pwl.inc", b" 0.00005 600)", b" 0.00005 599)"),
    (".cir", ".pwl.inc", b"PULSE(0 15 ", b"PULSE(0 15.0001 "),
    (".cir", ".pwl.inc", b" 0.000024999 ", b" 0.000024 "),
]


@pytest.mark.parametrize("judged,broken,old,new", TRAIN_FAULTS)
def test_a_fault_of_a_train_is_found(folder, judged, broken, old, new):
    if verdict(folder, judged, "bed")[0] == "SKIPPED":
        pytest.skip("the judge is not here")
    replace(folder / f"bed{broken}", old, new)
    outcome, reason = verdict(folder, judged, "bed")
    assert outcome == "WRONG", reason


# Faults in stages.
POSITION_FAULTS = [
    (".json", ".json", b'"unit": "um"', b'"unit": "mm"'),
    (".json", ".json", b'"plane": "xy"', b'"plane": "yz"'),
    (".csv", ".csv", b"hand.f1.x [um]", b"hand.f1.x [V]"),
    (".csv", ".csv", b"\n107000000,18.5,", b"\n107000000,18.500001,"),
    (".csv", ".csv", b"\n107000000,", b"\n107000100,"),
    (".vcd", ".vcd", b"r28.45 a\n", b"r28.46 a\n"),
    (".vcd", ".vcd", b"r28.45 a\n", b"r28.454 a\n"),
    (".vcd", ".vcd", b"r28.45 a\n", b""),
    (".cir", ".pwl.inc", b"+ 0.107 18.5\n", b"+ 0.107 18.500001\n"),
    (".cir", ".pwl.inc", b"+ 0.107 18.5\n", b""),
    (".cir", ".pwl.inc", b", 1 V stands for 1 um", b""),
    (".scpi", ".awg.scpi", b":SOUR3:VOLT 0.5\n", b":SOUR3:VOLT 0.6\n"),
    (".ngc", ".hand.ngc", b"G1 X0.018500 F600\n", b"G1 X0.018503 F600\n"),
    (".ngc", ".hand.ngc", b"G1 X0.018500 F600\n", b"G1 X0.018500 F601\n"),
    (".ngc", ".hand.ngc", b"; X is hand.f1.x", b"; X is hand.f1.y"),
    (".svg", ".svg", b'data-finger="2"', b'data-finger="1"'),
    (".svg", ".svg", b'data-orientation="', b'data-orientation="0.1'),
    (".ngc", ".hand.ngc", b"G4 P0.007", b"G4 P0.008"),
    (".ngc", ".hand.ngc", b"G93\n", b"G94\n"),
    (".ngc", ".hand.ngc", b"G64 P0.000025", b"G61"),
    (".ngc", ".hand.ngc", b"G64 P0.000025", b"G64"),
    (".ngc", ".hand.ngc", b"G64 P0.000025", b"G64 P0.000026"),
    (".ngc", ".hand.ngc", b"G21\n", b"G20\n"),
    (".ngc", ".hand.ngc", b"\nM2\n", b"\n"),
]


@pytest.mark.parametrize("judged,broken,old,new", POSITION_FAULTS)
def test_a_fault_of_positions_is_found(folder, judged, broken, old, new):
    if verdict(folder, judged, "turn")[0] == "SKIPPED":
        pytest.skip("the judge is not here")
    replace(folder / f"turn{broken}", old, new)
    outcome, reason = verdict(folder, judged, "turn")
    assert outcome == "WRONG", reason


def test_gcode_is_asked_for_where_all_channels_are_stages(folder):
    (folder / "turn.hand.ngc").unlink()
    judged = {name: outcome for name, outcome, _ in run.judge_folder(folder)}
    assert judged["turn.ngc"] == "MISSING" and "Pair.ngc" not in judged


def test_damage_of_a_log_is_found(folder):
    path = folder / "Pair.mcap"
    data = path.read_bytes()
    # The footer gives the start of the summary, whose checksum this reader does not validate.
    (summary,) = struct.unpack("<Q", data[-28:-20])
    for at in range(8, summary - 13, summary // 12):
        broken = bytearray(data)
        broken[at] ^= 4
        path.write_bytes(broken)
        assert verdict(folder, ".mcap")[0] == "WRONG", f"byte {at}"


@pytest.mark.parametrize("change", [{"to": 114.0, "swing": {"period_ns": 50_000, "levels": [130.0, 114.0]}}, {"swing": {"period_ns": 25_000, "levels": [130.0, 115.0]}}])
def test_a_log_of_another_train_is_found(folder, change):
    other = folder / "other.json"
    document = json.loads((folder / "bed.json").read_bytes())
    document["actuations"][2].update(change)
    other.write_text(json.dumps(document))
    outcome, reason = run.judge(folder / "bed.mcap", "mcap_judge", Schedule(other))
    assert outcome == "WRONG" and ("bed_low" in reason or "periods" in reason), reason


def turned(states):
    states[1]["poses"]["D1"]["heading_deg"] += 1e-4


def moved(states):
    states[2]["poses"]["D2"]["x_um"] += 1e-4


def lowered(states):
    states[3]["arms"][2] = 1


def controlled(states):
    states[4]["control"] = 1


@pytest.mark.parametrize("change", [turned, moved, lowered, controlled])
def test_a_log_of_other_robots_is_found(folder, change):
    other = folder / "other.json"
    document = json.loads((folder / "bed.json").read_bytes())
    change(document["plans"][0]["states"])
    other.write_text(json.dumps(document))
    outcome, reason = run.judge(folder / "bed.mcap", "mcap_judge", Schedule(other))
    assert outcome == "WRONG" and " at " in reason, reason


def carried(document):
    document["plans"][0]["states"][-1]["position_um"][2] += 1e-4


def rolled(document):
    document["plans"][0]["states"][2]["orientation"][3] += 1e-6


def grasped(document):
    document["plans"][0]["states"][3]["grasp"][2] = 58


def placed(document):
    document["actuations"][0]["to"] += 1e-4


@pytest.mark.parametrize("change", [carried, rolled, grasped, placed])
def test_a_log_of_another_hand_is_found(folder, change):
    other = folder / "other.json"
    document = json.loads((folder / "turn.json").read_bytes())
    change(document)
    other.write_text(json.dumps(document))
    outcome, reason = run.judge(folder / "turn.mcap", "mcap_judge", Schedule(other))
    assert outcome == "WRONG" and "attached" not in reason, reason


@pytest.mark.parametrize("change", [{"from": 21.0, "to": 21.0}, {"start_ns": 1}, {"duration_ns": 14_999_999}])
def test_a_log_of_another_schedule_is_found(folder, change):
    other = folder / "other.json"
    document = json.loads((folder / "Pair.json").read_bytes())
    document["actuations"][0].update(change)
    other.write_text(json.dumps(document))
    (folder / "Pair.csv").unlink()
    outcome, reason = run.judge(folder / "Pair.mcap", "mcap_judge", Schedule(other))
    assert outcome == "WRONG" and "bot.bl0.set" in reason, reason


def test_a_missing_file_is_said_and_counts_where_all_is_required(folder, capsys, monkeypatch):
    monkeypatch.delenv("TWEEZE_REQUIRE_ORACLES", raising=False)
    (folder / "Pair.vcd").unlink()
    assert run.main([str(folder)]) == 0
    assert "MISSING  Pair.vcd: was not written" in capsys.readouterr().out
    monkeypatch.setenv("TWEEZE_REQUIRE_ORACLES", "1")
    assert run.main([str(folder)]) == 1


def test_a_missing_judge_is_said_and_counts_where_all_is_required(folder, capsys, monkeypatch):
    monkeypatch.delenv("TWEEZE_REQUIRE_ORACLES", raising=False)
    monkeypatch.setattr("shutil.which", lambda name: None)
    assert run.main([str(folder)]) == 0
    assert "SKIPPED  Pair.cir: ngspice is not installed" in capsys.readouterr().out
    monkeypatch.setenv("TWEEZE_REQUIRE_ORACLES", "1")
    assert run.main([str(folder)]) == 1


def test_an_empty_folder_is_no_success(tmp_path):
    assert run.main([str(tmp_path)]) == 1


def test_blocks_may_hold_line_feeds():
    assert scpi_judge.messages(b"*CLS\nA B,#14\n\n\n\n\n*TRG\n") == [b"*CLS", b"A B,#14\n\n\n\n", b"*TRG"]
    assert scpi_judge.as_text(b"A B,#14\x00\x0a\xff\xff") == "A B,10 -1"


# Faults in digital lines and outputs of cards.
CARD_FAULTS = [
    ("fetch", ".card.daq", b"\n1\t0x00000001", b"\n2\t0x00000001"),
    ("fetch", ".card.daq", b"0x00000001", b"0x00000002"),
    ("fetch", ".nidaqmx.py", b'"rate_hz": 66.', b'"rate_hz": 67.'),
    ("fetch", ".nidaqmx.py", b'"port0/line0"', b'"port0/line1"'),
    ("fetch", ".json", b'"digital_rate_hz": 1000000.0', b'"digital_rate_hz": 10.0'),
    ("fetch", ".json", b'"output": "port0.line0"', b'"output": "port0.line30"'),
    ("turn", ".card.daq", b"\t2.85", b"\t2.86"),
    ("turn", ".json", b'"scale_v_per_um": 0.1', b'"scale_v_per_um": 0.2'),
]


@pytest.mark.parametrize("stem", ["fetch", "turn"])
def test_a_card_plays_the_schedule(stem):
    outcome, reason = verdict(FIXTURES / "cards", ".daq", stem)
    assert outcome == "right", reason


@pytest.mark.parametrize("stem,broken,old,new", CARD_FAULTS)
def test_a_fault_of_a_card_is_found(tmp_path, stem, broken, old, new):
    for file in (FIXTURES / "cards").glob(f"{stem}.*"):
        shutil.copy(file, tmp_path)
    replace(tmp_path / f"{stem}{broken}", old, new)
    outcome, reason = verdict(tmp_path, ".daq", stem)
    assert outcome == "WRONG", reason


@pytest.mark.parametrize("environment,status", [({"STANDIN_FAULT": "start"}, 1), ({"STANDIN_FAULT": "wait_until_done"}, 1), ({"STANDIN_INTERRUPT": "wait_until_done"}, 130)])
def test_lines_are_off_after_an_error_and_after_ctrl_c(monkeypatch, environment, status):
    for name, value in environment.items():
        monkeypatch.setenv(name, value)
    ended, words, calls = daq_judge.played(FIXTURES / "cards" / "fetch.nidaqmx.py")
    assert ended == status, words
    rest = [call["rest"] for call in calls if call["rest"]]
    assert rest and not any(level for call in rest for level in call.values()), words


# Digital lines are written once, at rest, before anything is loaded; stages are not.
@pytest.mark.parametrize("sender,nth", [("fetch.nidaqmx.py", 2), ("turn.nidaqmx.py", 1)])
def test_what_was_loaded_is_closed_where_loading_fails(monkeypatch, sender, nth):
    monkeypatch.setenv("STANDIN_FAULT", f"write:{nth}")
    ended, words, calls = daq_judge.played(FIXTURES / "cards" / sender)
    assert ended == 1 and "write failed, as it was asked to" in words and "may still be on" not in words, words
    assert any(call["clock"] for call in calls) and all(call["closed"] for call in calls), calls


def test_a_sender_says_what_it_would_do(tmp_path):
    sender = FIXTURES / "cards" / "fetch.nidaqmx.py"
    status, words, calls = daq_judge.played(sender, ["card=Dev7", "--dry-run"])
    assert status == 0 and "nothing starts" in words and not any(call["started"] for call in calls), words
    assert {call["device"] for call in calls} == {"Dev7"}
    assert daq_judge.played(sender, ["crad=Dev7"])[0] == 2
    status, words, _ = daq_judge.played(sender, ["--list"])
    assert status == 0 and "Dev1" in words and "fetch.card.daq" in words, words

# Faults in frames of electrode drivers.
FRAME_FAULTS = [
    ("od", ".driver.frames.csv", b",8\n", b",9\n"),
    ("od", ".driver.frames.csv", b"\n2,15,", b"\n2,16,"),
    ("pd", ".driver.frames.csv", b",8\n", b",8 11\n"),
    ("pd", ".driver.frames.csv", b"\n1,0,15,8\n", b"\n1,0,15,\n"),
    ("od", ".frames.py", b"1 << what % 8", b"128 >> what % 8"),
    ("lift", ".frames.py", b'"magnet1": 2', b'"magnet1": 1'),
    ("lift", ".frames.py", b"TEMPERATURES[int(heater", b"TEMPERATURES[-int(heater"),
    ("lift", ".driver.frames.csv", b"heater2=60\n", b"heater2=61\n"),
    ("od", ".frames.py", b"data[COLUMNS + place] = ROOM_DEGREES", b"data[COLUMNS + place] = 90"),
    ("od", ".json", b'"output": "c8"', b'"output": "c80"'),
    ("pd", ".json", b'"least_frame_ns": 1', b'"least_frame_ns": 50000000'),
    ("db", ".driver.frames.csv", b",8 35\n", b",8 36\n"),
]


@pytest.mark.parametrize("stem", ["od", "pd", "db", "ob", "lift"])
def test_a_driver_switches_what_the_schedule_says(stem):
    outcome, reason = verdict(FIXTURES / "drivers", ".frames.py", stem)
    assert outcome == "right", reason


@pytest.mark.parametrize("stem,broken,old,new", FRAME_FAULTS)
def test_a_fault_of_frames_is_found(tmp_path, stem, broken, old, new):
    for file in (FIXTURES / "drivers").glob(f"{stem}.*"):
        shutil.copy(file, tmp_path)
    replace(tmp_path / f"{stem}{broken}", old, new)
    outcome, reason = verdict(tmp_path, ".frames.py", stem)
    assert outcome == "WRONG", reason

# Faults in the files for MicroDrop.
MICRODROP_FAULTS = [
    ("db", ".driver.microdrop.json", b"0.006,", b"0.0061,"),
    ("db", ".driver.microdrop.json", b'["electrode008"', b'["electrode009"'),
    ("db", ".driver.microdrop.json", b'"electrode008":8', b'"electrode008":9'),
    ("db", ".driver.microdrop.json", b",100,10000]", b",101,10000]"),
    ("db", ".driver.microdrop.json", b",100,10000]", b",100,1000]"),
    ("db", ".driver.microdrop.json", b'"uuid","type"', b'"type","uuid"'),
    ("ob", ".driver.microdrop.json", b"duration_column", b"durations_column"),
    ("ob", ".driver.microdrop.svg", b'data-channels="12"', b'data-channels="13"'),
    ("ob", ".driver.microdrop.svg", b'id="electrode012"', b'id="electrode112"'),
    ("ob", ".driver.microdrop.svg", b'"M 0', b'"M 1'),
    ("ob", ".driver.microdrop.svg", b"    <line", b"    <rect"),
    ("ob", ".driver.microdrop.svg", b'label="Device"', b'label="device layer"'),
    ("ob", ".driver.microdrop.svg", b' xmlns=""', b""),
    ("ask", ".driver.microdrop.json", b'"fill the board"', b'""'),
    ("ask", ".driver.microdrop.json", b"done?", b"done"),
    ("ask", ".driver.microdrop.json", b",0.001,", b",0.002,"),
]


@pytest.mark.parametrize("stem", ["db", "ob", "ask"])
def test_microdrop_switches_what_the_schedule_says(stem):
    outcome, reason = verdict(FIXTURES / "drivers", ".microdrop", stem)
    assert outcome == "right", reason


@pytest.mark.parametrize("stem,broken,old,new", MICRODROP_FAULTS)
def test_a_fault_for_microdrop_is_found(tmp_path, stem, broken, old, new):
    for file in (FIXTURES / "drivers").glob(f"{stem}.*"):
        shutil.copy(file, tmp_path)
    replace(tmp_path / f"{stem}{broken}", old, new)
    outcome, reason = verdict(tmp_path, ".microdrop", stem)
    assert outcome == "WRONG", reason


# Faults in positions of stages, with controllers of PI and SmarAct.
STAGE_FAULTS = [
    ("pi", ".pi1.stages.csv", b"\n0,78.5", b"\n0,79.5"),
    ("pi", ".pi2.stages.csv", b"point,axis1 [um],axis2 [um]", b"point,axis2 [um],axis1 [um]"),
    ("pi", ".stages.py", b"{controller['every']} 1", b"1 1"),
    ("pi", ".stages.py", b"BY_TRIGGER if self.waits else AT_ONCE", b"AT_ONCE"),
    ("pi", ".stages.py", b'"TWS 1 1 1"', b'"TWS 1 2 1"'),
    ("pi", ".stages.py", b"self.go(rows[0][1])", b"self.each(\"MOV\", [0] * len(self.axes))"),
    ("pi", ".stages.py", b"[1] * len(self.axes))\n        self.go", b"[0] * len(self.axes))\n        self.go"),
    ("pi", ".json", b'"origin_um": 50', b'"origin_um": 51'),
    ("smaract", ".json", b'"direction": "backward"', b'"direction": "forward"'),
    ("smaract", ".stages.py", b"self.ctl.CloseStream(self.handle, self.stream)", b"pass"),
    ("smaract", ".stages.py", b"PM_OF_UM = 1_000_000", b"PM_OF_UM = 1_000"),
    ("smaract", ".stages.py", b"[axis - 1 for axis", b"[axis for axis"),
    ("smaract", ".stages.py", b"SensorPowerMode.ENABLED", b"SensorPowerMode.POWER_SAVE"),
]


@pytest.mark.parametrize("stem", ["pi", "smaract"])
def test_a_controller_moves_stages_as_the_schedule_says(stem):
    outcome, reason = verdict(FIXTURES / "controllers", ".stages.py", stem)
    assert outcome == "right", reason


@pytest.mark.parametrize("stem,broken,old,new", STAGE_FAULTS)
def test_a_fault_of_stages_is_found(tmp_path, stem, broken, old, new):
    for file in (FIXTURES / "controllers").glob(f"{stem}.*"):
        shutil.copy(file, tmp_path)
    replace(tmp_path / f"{stem}{broken}", old, new)
    outcome, reason = verdict(tmp_path, ".stages.py", stem)
    assert outcome == "WRONG", reason


MACHINE_FAULTS = [
    (".mill.ngc", b"G1 C0.518500 F600\n", b"G1 C0.518503 F600\n"),
    (".mill.ngc", b"; C is hand.f1.x", b"; C is hand.f1.y"),
    (".mill.ngc", b"G64 P0.000020", b"G64 P0.000025"),
    (".json", b'"origin_um": 500', b'"origin_um": 501'),
    (".json", b'"direction": "backward"', b'"direction": "forward"'),
    (".json", b'"most_um": 1000', b'"most_um": 510'),
]


@pytest.mark.parametrize("judge", ["gcode_judge", "linuxcnc_judge"])
@pytest.mark.parametrize("broken,old,new", [("", b"", b""), *MACHINE_FAULTS])
def test_a_machine_moves_stages_as_their_wires_say(tmp_path, judge, broken, old, new):
    for file in (FIXTURES / "controllers").glob("mill.*"):
        shutil.copy(file, tmp_path)
    if broken:
        replace(tmp_path / f"mill{broken}", old, new)
    outcome, reason = run.judge(tmp_path / "mill.ngc", judge, Schedule(tmp_path / "mill.json"))
    if outcome == "SKIPPED":
        pytest.skip(reason)
    # The interpreter does not judge how far corners may be rounded.
    is_good = not broken or (judge == "linuxcnc_judge" and old.startswith(b"G64"))
    assert outcome == ("right" if is_good else "WRONG"), reason


@pytest.mark.parametrize("old,new", [(b"G1 X0.018500 F600\n", b"G1 X0.018503 F600\n"), (b"G1 X0.018500 F600\n", b"G1 X0.018500 F601\n"), (b"G4 P0.007", b"G4 P0.008"), (b"G93\n", b"G94\n"), (b"G21\n", b"G20\n"), (b"G1 X0.018500 F600\n", b"G1 X0.018500 F600\nG1 X0.018501 F50\nG1 X0.018500 F50\n")])
def test_linuxcnc_finds_a_fault_of_positions(folder, old, new):
    path, schedule = folder / "turn.ngc", Schedule(folder / "turn.json")
    outcome, reason = run.judge(path, "linuxcnc_judge", schedule)
    if outcome == "SKIPPED":
        pytest.skip(reason)
    assert outcome == "right", reason
    replace(folder / "turn.hand.ngc", old, new)
    outcome, reason = run.judge(path, "linuxcnc_judge", schedule)
    assert outcome == "WRONG", reason


def test_linuxcnc_knows_the_words_of_waits(tmp_path):
    """The G-code for a wait for an input is accepted; the lines after it abort the program if the wait timed out."""
    program = tmp_path / "wait.ngc"
    wait = "M66 P3 L3 Q5.000000000 ; motion.digital-in-03 high\no1 if [#5399 LT 0]\n(ABORT, it has not come)\no1 endif\n"
    program.write_text(f"G21\nG90\nG93\nG0 X0\n{wait}G1 X0.001 F600\nM2\n")
    try:
        assert [call[0] for call in linuxcnc_judge.calls(program)].count("straight_feed") == 1
    except Skipped as error:
        pytest.skip(str(error))
    program.write_text(f"G21\nG90\nG93\nG0 X0\n#5399 = -1\n{wait[wait.index('o1'):]}G1 X0.001 F600\nM2\n")
    with pytest.raises(Wrong, match="it has not come"):
        linuxcnc_judge.calls(program)
