"""Judges a folder of files that `tweeze build --emit mcap,json,csv,vcd,pwl,scpi,nidaqmx,frames,microdrop,stages,gcode,svg` wrote, by programs that are not Tweeze's.

    python tests/oracles/run.py DIR

Every `*.json` schedule in the folder is the measure for the files beside it. Exit status 0: all that was judged is right; 1:
something is wrong. A judge that is not installed is said aloud; with TWEEZE_REQUIRE_ORACLES=1 it counts as wrong, and so does a
format that is not there. G-code is asked for where all channels are stages, and the files of instruments where channels are wired to them.
"""

import importlib
import os
import re
import sys
from concurrent.futures import ProcessPoolExecutor
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parent))

from verdict import Skipped, Wrong  # noqa: E402

JUDGES = {
    ".json": "schedule",
    ".csv": "csv_judge",
    ".mcap": "mcap_judge",
    ".lichtblick.json": "layout_judge",
    ".vcd": "vcd_judge",
    ".gtkw": "gtkw_judge",
    ".cir": "spice_judge",
    ".scpi": "scpi_judge",
    ".daq": "daq_judge",
    ".frames.py": "frames_judge",
    ".microdrop": "microdrop_judge",
    ".stages.py": "stages_judge",
    ".ngc": "gcode_judge",
    ".svg": "svg_judge",
}

# Formats for instruments, with the instrument family that the program must have.
PLAYED_BY = {".scpi": "waveform_generator", ".daq": "data_acquisition", ".frames.py": "electrode_driver", ".microdrop": "electrode_driver", ".stages.py": "stage_controller"}

# Formats with a single clock, which cannot express a wait for an input or a person.
ONE_CLOCK = {".csv", ".vcd", ".gtkw", ".cir"}

# Additional judges for some formats.
SECOND = [(".vcd", "sigrok_judge"), (".mcap", "plot_judge"), (".mcap", "rerun_judge"), (".ngc", "linuxcnc_judge")]


def judge(path, module, schedule):
    """The verdict on one file: outcome and reason."""
    if not path.exists() and not any(path.parent.glob(f"{path.stem}.*{path.suffix}")) and not any(path.parent.glob(f"{path.stem}.*{path.suffix}.*")):
        return "MISSING", "was not written"
    try:
        return "right", importlib.import_module(module).judge(path, schedule)
    except ImportError as error:
        return "SKIPPED", f"{error}; see requirements.txt"
    except Skipped as error:
        return "SKIPPED", str(error)
    except Wrong as error:
        return "WRONG", str(error)
    except Exception as error:  # a reader that fails is a verdict too
        return "WRONG", f"{type(error).__name__}: {error}"


def is_of_microdrop(schedule):
    """Whether MicroDrop can play the schedule: it drives some boards, knows only electrodes, and only waits for people, without a limit."""
    drivers = schedule.instruments("electrode_driver")
    are_electrodes = all(re.search(r"\.e\d+_\d+$", channel) for name in drivers for channel in schedule.drives(name))
    are_prompts = all("person" in hold["awaited"] and not hold["is_bounded"] for hold in schedule.document.get("holds", []))
    return are_electrodes and are_prompts and any(facts["protocol"] != "purpledrop" for facts in drivers.values())


def verdicts_of(path):
    """All verdicts on a schedule and the files beside it, as (file name, outcome, reason)."""
    from schedule import Schedule

    try:
        schedule = Schedule(path)
    except Exception as error:
        return [(path.name, "WRONG", f"{type(error).__name__}: {error}")]
    verdicts = []
    for ending, module in (*JUDGES.items(), *SECOND):
        if ending == ".ngc" and not all(map(schedule.is_stage, schedule.channels)):
            continue
        if ending in PLAYED_BY and not schedule.instruments(PLAYED_BY[ending]):
            continue
        if ending == ".microdrop" and not is_of_microdrop(schedule):
            continue
        if ending in ONE_CLOCK and schedule.document.get("holds"):
            continue
        file = path.with_suffix(ending)
        verdicts.append((file.name, *judge(file, module, schedule)))
    return verdicts


def judge_folder(folder):
    """All verdicts, schedule by schedule; schedules are judged in parallel processes."""
    # Each program has a folder. Files whose names begin with a dot are Tweeze's own; layouts, OpenDrop and MicroDrop files are no schedules.
    paths = Path(folder).rglob("*.json")
    paths = sorted(path for path in paths if not path.name.startswith(".") and not path.name.endswith((".lichtblick.json", ".opendrop.json", ".microdrop.json")))
    if len(paths) < 2:
        return [verdict for path in paths for verdict in verdicts_of(path)]
    with ProcessPoolExecutor() as pool:
        return [verdict for verdicts in pool.map(verdicts_of, paths) for verdict in verdicts]


def main(arguments):
    if len(arguments) != 1:
        print(__doc__, file=sys.stderr)
        return 2
    required = os.environ.get("TWEEZE_REQUIRE_ORACLES") == "1"
    verdicts = judge_folder(arguments[0])
    for name, outcome, reason in verdicts:
        print(f"{outcome:>7}  {name}: {reason}")
    outcomes = [outcome for _, outcome, _ in verdicts]
    counts = ", ".join(f"{outcomes.count(word)} {word.lower()}" for word in ("right", "WRONG", "SKIPPED", "MISSING"))
    print(f"{len(outcomes)} files: {counts}")
    if "right" not in outcomes:
        print("nothing was judged", file=sys.stderr)
        return 1
    bad = {"WRONG", "SKIPPED", "MISSING"} if required else {"WRONG"}
    return 1 if bad & set(outcomes) else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
