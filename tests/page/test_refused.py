"""Pages of logs, in a real browser.

The page of a refused log shows each violation with its instant, and the scene at the first of them. The page of any other log shows what
only the log says.

`TWEEZE` names the program; `CHROMIUM` the browser, if it is not on the path.
"""

import json
import os
import subprocess
from pathlib import Path

import pytest
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer

TWEEZE = Path(os.environ.get("TWEEZE", "target/debug/tweeze")).resolve()
ROOT = Path(__file__).parents[2]
REFUSED = 3


def altered(log, out, edit):
    """Copies a log with its attached schedule changed by `edit`."""
    with log.open("rb") as source, out.open("wb") as target:
        reader = make_reader(source)
        header, summary = reader.get_header(), reader.get_summary()
        writer = Writer(target, compression=CompressionType.NONE, enable_data_crcs=True)
        writer.start(profile=header.profile, library=header.library)
        schemas = {own.id: writer.register_schema(own.name, own.encoding, own.data) for own in summary.schemas.values()}
        channels = {
            own.id: writer.register_channel(own.topic, own.message_encoding, schemas.get(own.schema_id, 0), own.metadata)
            for own in summary.channels.values()
        }
        for _, channel, message in reader.iter_messages():
            writer.add_message(channels[channel.id], message.log_time, message.data, message.publish_time, message.sequence)
        for own in reader.iter_attachments():
            data = own.data
            if own.name == "schedule.json":
                schedule = json.loads(data)
                edit(schedule)
                data = json.dumps(schedule).encode()
            writer.add_attachment(own.create_time, own.log_time, own.name, own.media_type, data)
        for own in reader.iter_metadata():
            writer.add_metadata(own.name, own.metadata)
        writer.finish()


def stronger(schedule):
    """Raises the value of one actuation in the middle."""
    actuation = schedule["actuations"][len(schedule["actuations"]) // 2]
    actuation["from"] = actuation["to"] = actuation["to"] + 1


def elsewhere(schedule):
    """Changes the last state of the first plan to one that no replay reaches."""
    state = schedule["plans"][0]["states"][-1]
    if "parts" in state:
        name = sorted(state["parts"])[0]
        state["parts"][name] = [place + 1 for place in state["parts"][name]]
    elif "poses" in state:
        name = sorted(state["poses"])[0]
        state["poses"][name]["x_um"] += 5
    else:
        state["position_um"] = [place + 0.5 for place in state["position_um"]]


def other_way(schedule):
    """Swaps set and reset of a pulse in the middle, so that it drives its module to where it already is."""
    actuation = schedule["actuations"][len(schedule["actuations"]) // 2]
    name = schedule["channels"][actuation["channel"]]["name"]
    other = name.replace(".set", ".reset") if ".set" in name else name.replace(".reset", ".set")
    actuation["channel"] = [channel["name"] for channel in schedule["channels"]].index(other)


EDITS = {
    "dimibot_fetch": (other_way, "E0724"),
    "electrode_array_swap": (stronger, "E0729"),
    "electrode_array_droplets": (elsewhere, "E0714"),
    "microrobots_drive": (elsewhere, "E0714"),
    "fingers_ellipsoid": (elsewhere, "E0714"),
}


def view(log, folder):
    ended = subprocess.run([TWEEZE, "view", log, "-o", folder, "--no-open"], capture_output=True, text=True, check=False)
    assert ended.returncode == REFUSED, ended.stderr
    page = folder / f"{log.stem}.failed.html"
    assert page.name in ended.stdout
    return page, ended.stderr


def opened(browser, page):
    tab = browser.new_page(viewport={"width": 1280, "height": 720})
    tab.faults = []
    tab.on("console", lambda message: tab.faults.append(message.text) if message.type in ("error", "warning") else None)
    tab.on("pageerror", lambda error: tab.faults.append(str(error)))
    tab.goto(page.as_uri())
    tab.data = json.loads(tab.locator("#data").text_content())
    return tab


def built(example, folder):
    subprocess.run([TWEEZE, "build", ROOT / f"examples/{example}.twz", "-o", folder, "-q"], check=True)
    return sorted(folder.glob("*.mcap"))[0]


def check_schema(data):
    import jsonschema

    schema = json.loads((ROOT / "schema" / "page.schema.json").read_text())
    jsonschema.Draft202012Validator(schema).validate(data)


@pytest.mark.parametrize("example", EDITS)
def test_a_refused_log_is_shown_at_its_first_violation(browser, tmp_path, example):
    edit, code = EDITS[example]
    log = tmp_path / "altered.mcap"
    altered(built(example, tmp_path / "whole"), log, edit)
    page, told = view(log, tmp_path)
    assert code in told
    tab = opened(browser, page)
    check_schema(tab.data)
    findings = tab.data["failure"]["findings"]
    # Violations of what takes place come before those of what the schedule says about it.
    assert tab.data["failure"]["is_refused"] and findings[0]["code"] == code
    assert tab.locator("#verdict").text_content().startswith("✗ refused: ")
    assert tab.evaluate("window.tweeze.t_ns") == min(findings[0]["t_ns"], tab.data["schedule"]["duration_ns"])
    # The page of a refused log makes no claims; each violation leads to its instant.
    assert "proven" not in tab.locator("#claims").text_content()
    jumps = tab.locator("#claims .card.error .instant")
    assert jumps.count() == len(findings)
    tab.keyboard.press("Home")
    jumps.last.click()
    assert tab.evaluate("window.tweeze.t_ns") == min(findings[-1]["t_ns"], tab.data["schedule"]["duration_ns"])
    assert tab.faults == []
    tab.close()


def test_parts_that_do_not_fit_are_not_shown(browser, tmp_path):
    log = tmp_path / "altered.mcap"
    # The value exceeds what the wired output can give, so channels and wires do not fit.
    altered(built("dimibot_fetch", tmp_path / "whole"), log, stronger)
    page, told = view(log, tmp_path)
    assert "E0706" in told
    tab = opened(browser, page)
    check_schema(tab.data)
    assert tab.data["schedule"] is None
    assert "E0706" in tab.locator("#claims .card.error").first.text_content()
    assert tab.faults == []
    tab.close()


def test_the_page_of_a_log_says_what_only_the_log_does(browser, tmp_path):
    log = built("dimibot_fetch", tmp_path / "whole")
    subprocess.run([TWEEZE, "view", log, "-o", tmp_path, "--no-open"], capture_output=True, check=True)
    tab = opened(browser, tmp_path / f"{log.stem}.html")
    check_schema(tab.data)
    assert tab.data["recorded"] is True
    claims = tab.locator("#claims").text_content()
    assert "proven, says the log" in claims and "does not derive them again" in claims
    tab.close()
    subprocess.run([TWEEZE, "build", ROOT / "examples/dimibot_fetch.twz", "--emit", "html", "-o", tmp_path / "own", "-q"], check=True)
    tab = opened(browser, tmp_path / "own" / f"{log.stem}.html")
    claims = tab.locator("#claims").text_content()
    assert "recorded" not in tab.data and "proven" in claims and "says the log" not in claims
    tab.close()
