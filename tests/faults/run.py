"""Puts each fault of faults.txt into Tweeze and runs the tests: whatever no test notices has no test.

    python3 tests/faults/run.py                 all faults
    python3 tests/faults/run.py --only 3,16     some of them

The source is copied to target/faults/tree. There each fault stands beside the right text, and the environment variable TWEEZE_FAULT
chooses one when a program runs, so that one build serves all. Left out are the tests that need other programs or look at the source
itself: `judges`, `fuzz` and `tidy`.

Exit status: 0 if all faults are killed but for at most 2 % that are explained in faults.txt, each on a line `= why nothing can tell`;
1 if not; 2 if a fault is stale or the tests fail without one.

Needs the Rust toolchain and Python 3.9 or later, nothing else. CARGO names another cargo.
"""

import argparse
import json
import os
import re
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LEFT_OUT = {"judges", "fuzz", "tidy"}
MOST_SURVIVING = 0.02

SWITCH = """//! Which fault is on: not a part of Tweeze.

pub fn on(number: u32) -> bool {
    static FAULT: std::sync::OnceLock<u32> = std::sync::OnceLock::new();
    let read = || std::env::var("TWEEZE_FAULT").ok().and_then(|text| text.parse().ok()).unwrap_or(0);
    *FAULT.get_or_init(read) == number
}
"""


class Fault:
    def __init__(self, number, path, meaning):
        self.number, self.path, self.meaning = number, path, meaning
        self.old = self.new = self.excuse = None


def stale(text):
    print(text, file=sys.stderr)
    sys.exit(2)


def read_faults():
    """The faults of faults.txt; ends the program where one is not well-formed or its old text is not there exactly once."""
    faults = []
    for line in (ROOT / "tests/faults/faults.txt").read_text().splitlines():
        head = re.fullmatch(r"(\d+) (\S+): (.+)", line)
        if head:
            faults.append(Fault(int(head[1]), head[2], head[3]))
        elif line[:2] in ("- ", "+ ", "= "):
            setattr(faults[-1], {"-": "old", "+": "new", "=": "excuse"}[line[0]], line[2:])
        elif line.strip() and not line.startswith("#"):
            stale(f"faults.txt: `{line}` is no line of a fault")
    for number, fault in enumerate(faults, 1):
        if fault.number != number:
            stale(f"faults.txt: fault {fault.number} should be {number}")
        if not fault.old or not fault.new or fault.old == fault.new:
            stale(f"fault {number} does not say what takes the place of what")
        found = (ROOT / fault.path).read_text().count(fault.old) if (ROOT / fault.path).is_file() else 0
        if found != 1:
            stale(f"fault {number} is stale: its text stands {found} times in {fault.path}")
    return faults


def with_switch(text, fault):
    if fault.old.endswith(";"):
        both = f"if crate::fault_switch::on({fault.number}) {{ {fault.new} }} else {{ {fault.old} }}"
    else:
        both = f"(if crate::fault_switch::on({fault.number}) {{ {fault.new} }} else {{ {fault.old} }})"
    return text.replace(fault.old, both)


def lay_out(tree, faults):
    """Copies the source with all faults in it; files that are there already as they must be are left alone, for cargo's sake."""
    wanted = {}
    for top in ["Cargo.toml", "Cargo.lock", "README.md", "CHANGELOG.md"]:
        wanted[Path(top)] = (ROOT / top).read_bytes()
    for folder in ["src", "tests", "benches", "stdlib", "grammar", "schema", "examples", "docs"]:
        for path in sorted((ROOT / folder).rglob("*")):
            if path.is_file() and "__pycache__" not in path.parts:
                wanted[path.relative_to(ROOT)] = path.read_bytes()
    for fault in faults:
        path = Path(fault.path)
        wanted[path] = with_switch(wanted[path].decode(), fault).encode()
    wanted[Path("src/fault_switch.rs")] = SWITCH.encode()
    wanted[Path("src/lib.rs")] += b"\n#[allow(missing_docs)]\npub mod fault_switch;\n"
    for path in sorted(tree.rglob("*")) if tree.exists() else []:
        if path.is_file() and path.relative_to(tree) not in wanted:
            path.unlink()
    for path, data in wanted.items():
        to = tree / path
        if not to.is_file() or to.read_bytes() != data:
            to.parent.mkdir(parents=True, exist_ok=True)
            to.write_bytes(data)


def build(tree, target):
    """Builds all tests; their programs by name."""
    cargo = os.environ.get("CARGO", "cargo")
    environment = {**os.environ, "CARGO_TARGET_DIR": str(target)}
    command = [cargo, "test", "--no-run", "--message-format=json-render-diagnostics"]
    done = subprocess.run(command, cwd=tree, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if done.returncode != 0:
        stale(f"{done.stderr}the faults do not compile: see above")
    programs = {}
    for line in done.stdout.splitlines():
        message = json.loads(line) if line.startswith("{") else {}
        if message.get("executable") and message["profile"]["test"] and message["target"]["kind"] != ["bin"]:
            programs["library" if message["target"]["kind"] == ["lib"] else message["target"]["name"]] = message["executable"]
    return {name: path for name, path in programs.items() if name not in LEFT_OUT}


def run(tree, program, fault, limit_s, words=()):
    """What of a test program failed, or None; ends it at the first failure. With words, only tests whose names hold one of them."""
    environment = {
        **os.environ,
        "TWEEZE_FAULT": str(fault),
        "INSTA_UPDATE": "no",
        "INSTA_WORKSPACE_ROOT": str(tree),
        "CARGO_MANIFEST_DIR": str(tree),
        "PROPTEST_FAILURE_PERSISTENCE": "off",
    }
    child = subprocess.Popen(
        [program, *words], cwd=tree, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
        errors="replace", start_new_session=True,
    )
    timer = None
    if limit_s is not None:
        timer = threading.Timer(limit_s, lambda: end(child))
        timer.start()
    failed = None
    for line in child.stdout:
        found = re.match(r"test (.+) \.\.\. FAILED", line)
        if found:
            failed = found[1]
            break
    if failed:
        end(child)
    status = child.wait()
    if timer:
        timer.cancel()
    if failed:
        return failed
    return None if status == 0 else f"ended with {status}: crash, or no end in {limit_s} s"


def end(child):
    try:
        os.killpg(child.pid, signal.SIGKILL)
    except (ProcessLookupError, PermissionError):
        pass


def killer_of(fault, tree, programs, order, lasts):
    """The first test that notices a fault, the nearest ones asked first."""
    near = re.sub(r"(/mod)?\.rs$", "", fault.path).split("/")[1:]
    places = [near[-1], near[0]] if len(near) == 1 else [near[1], near[0]]
    for words in places:
        failed = run(tree, programs["library"], fault.number, 60 + 10 * lasts["library"], [words])
        if failed:
            return f"library: {failed}"
    for name in order:
        failed = run(tree, programs[name], fault.number, 60 + 10 * lasts[name])
        if failed:
            return f"{name}: {failed}"
    return None


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--only", help="numbers of faults, with commas")
    arguments.add_argument("--target", type=Path, default=ROOT / "target/faults", help="where to copy and build")
    arguments.add_argument("--keep", action="store_true", help="take the copy that is there, whatever has changed since")
    given = arguments.parse_args()
    faults = read_faults()
    tree = given.target.resolve() / "tree"
    if not given.keep:
        lay_out(tree, faults)
    programs = build(tree, given.target.resolve() / "build")
    print(f"{len(faults)} faults, {len(programs)} test programs", flush=True)
    lasts = {}
    for name, program in programs.items():
        begun = time.monotonic()
        failed = run(tree, program, 0, None)
        lasts[name] = time.monotonic() - begun
        if failed:
            stale(f"without a fault, {name} fails: {failed}")
    print(f"without a fault all pass, in {sum(lasts.values()):.0f} s", flush=True)
    order = sorted(programs, key=lambda name: lasts[name])
    only = {int(number) for number in given.only.split(",")} if given.only else None
    tried = [fault for fault in faults if only is None or fault.number in only]
    survived, wrong = [], []
    for fault in tried:
        killer = killer_of(fault, tree, programs, order, lasts)
        if killer is None:
            survived.append(fault)
        if (killer is None) != (fault.excuse is not None):
            wrong.append(fault)
        print(f"{'SURVIVES' if killer is None else 'killed  '} {fault.number:3} {fault.path}: {fault.meaning}", flush=True)
        print(f"             {killer or fault.excuse or 'no test notices, and no reason is given'}", flush=True)
    print(f"{len(tried)} faults, {len(tried) - len(survived)} killed, {len(survived)} survive")
    too_many = only is None and len(survived) > MOST_SURVIVING * len(tried)
    sys.exit(1 if wrong or too_many else 0)


if __name__ == "__main__":
    main()
