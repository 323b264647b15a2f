"""Puts each fault of faults.txt into Tweeze and runs the tests: whatever no test notices has no test.

    python3 tests/faults/run.py                 all faults
    python3 tests/faults/run.py --only 3,16     some of them
    python3 tests/faults/run.py --write         all faults; the tests that notice them are written into faults.txt

The source is copied to target/faults/tree. There each fault stands beside the right text, and the environment variable TWEEZE_FAULT
chooses one when a program runs, so that one build serves all. The test that faults.txt names on a line `* program test` is asked first;
where it does not notice the fault, the tests of the files near by, then all tests. Left out are the tests that need other programs or
look at the source itself: `judges`, `fuzz` and `tidy`.

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


SIGNS = {"- ": "old", "+ ": "new", "= ": "excuse", "* ": "killer"}


class Fault:
    def __init__(self, number, path, meaning):
        self.number, self.path, self.meaning = number, path, meaning
        self.old = self.new = self.excuse = self.killer = None


def stale(text):
    print(text, file=sys.stderr)
    sys.exit(2)


def read_faults():
    """Reads faults.txt; exits if a fault is malformed or its old text does not occur exactly once."""
    faults = []
    for line in (ROOT / "tests/faults/faults.txt").read_text().splitlines():
        head = re.fullmatch(r"(\d+) (\S+): (.+)", line)
        if head:
            faults.append(Fault(int(head[1]), head[2], head[3]))
        elif line[:2] in SIGNS:
            setattr(faults[-1], SIGNS[line[:2]], line[2:])
        elif line.strip() and not line.startswith("#"):
            stale(f"faults.txt: `{line}` is no line of a fault")
    for number, fault in enumerate(faults, 1):
        if fault.number != number:
            stale(f"faults.txt: fault {fault.number} should be {number}")
        if not fault.old or not fault.new or fault.old == fault.new:
            stale(f"fault {number} does not say what takes the place of what")
        found = len(places(fault, (ROOT / fault.path).read_text())) if (ROOT / fault.path).is_file() else 0
        if found != 1:
            stale(f"fault {number} is stale: its text stands {found} times in {fault.path}")
    return faults


def places(fault, text):
    """Offsets at which the old text occurs as whole words."""
    begin = r"\b" if re.match(r"\w", fault.old) else ""
    end = r"\b" if re.search(r"\w$", fault.old) else ""
    return [found.start() for found in re.finditer(begin + re.escape(fault.old) + end, text)]


def with_switch(text, fault):
    if fault.old.endswith(";"):
        both = f"if crate::fault_switch::on({fault.number}) {{ {fault.new} }} else {{ {fault.old} }}"
    else:
        both = f"(if crate::fault_switch::on({fault.number}) {{ {fault.new} }} else {{ {fault.old} }})"
    (at,) = places(fault, text)
    return text[:at] + both + text[at + len(fault.old) :]


def lay_out(tree, faults):
    """Copies the source with all faults in it; files that are already up to date are not rewritten, so that cargo does not rebuild them."""
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
    """Builds all tests; returns the paths of their executables by name."""
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


class Tests:
    """The test programs of the copy; their run without a fault is timed when first needed."""

    def __init__(self, tree, programs):
        self.tree, self.programs, self.lasts = tree, programs, {}

    def run(self, name, fault, limit_s, *words):
        """Runs a test program until its first failure; returns what failed, or None. `words` are passed on, as filters of test names."""
        environment = {
            **os.environ,
            "TWEEZE_FAULT": str(fault),
            "INSTA_UPDATE": "no",
            "INSTA_WORKSPACE_ROOT": str(self.tree),
            "CARGO_MANIFEST_DIR": str(self.tree),
            "PROPTEST_FAILURE_PERSISTENCE": "off",
        }
        child = subprocess.Popen(
            [self.programs[name], *words], cwd=self.tree, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
            text=True, errors="replace", start_new_session=True,
        )
        timer = None
        if limit_s is not None:
            timer = threading.Timer(limit_s, lambda: end(child))
            timer.start()
        failed = None
        for line in child.stdout:
            found = re.match(r"test (\S+)( - should panic)? \.\.\. FAILED", line)
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
        return None if status == 0 else f"(ended with {status}: crash, or no end in {limit_s} s)"

    def limit_s(self, name):
        """The time limit of a program. The first call runs it without a fault, to see that it passes and how long it takes."""
        if name not in self.lasts:
            begun = time.monotonic()
            failed = self.run(name, 0, None)
            self.lasts[name] = time.monotonic() - begun
            if failed:
                stale(f"without a fault, {name} fails: {failed}")
        return 60 + 10 * self.lasts[name]

    def known(self, fault):
        """The test that faults.txt names, if it notices the fault and passes without it."""
        name, _, test = (fault.killer or "").partition(" ")
        if name not in self.programs or not test:
            return None
        begun = time.monotonic()
        if self.run(name, 0, None, "--exact", test):
            stale(f"without a fault, {fault.killer} fails")
        limit_s = 60 + 10 * (time.monotonic() - begun)
        return f"{name} {test}" if self.run(name, fault.number, limit_s, "--exact", test) else None

    def killer(self, fault):
        """A test that notices a fault, or None; the tests nearest to the fault run first."""
        known = self.known(fault)
        if known:
            return known
        near = re.sub(r"(/mod)?\.rs$", "", fault.path).split("/")[1:]
        words = [near[-1], near[0]] if len(near) == 1 else [near[1], near[0]]
        for word in words:
            failed = self.run("library", fault.number, self.limit_s("library"), word)
            if failed:
                return f"library {failed}"
        for name in self.programs:
            self.limit_s(name)
        for name in sorted(self.programs, key=lambda name: self.lasts[name]):
            failed = self.run(name, fault.number, self.limit_s(name))
            if failed:
                return f"{name} {failed}"
        return None


def end(child):
    try:
        os.killpg(child.pid, signal.SIGKILL)
    except (ProcessLookupError, PermissionError):
        pass


def write_killers(killers):
    """Writes the test that notices each fault into faults.txt, after the line with the new text."""
    path, number, lines = ROOT / "tests/faults/faults.txt", 0, []
    for line in path.read_text().splitlines():
        head = re.match(r"(\d+) \S+: ", line)
        number = int(head[1]) if head else number
        if line.startswith("* ") and number in killers:
            continue
        lines.append(line)
        if line.startswith("+ ") and killers.get(number):
            lines.append(f"* {killers[number]}")
    path.write_text("\n".join(lines) + "\n")


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--only", help="numbers of faults, with commas")
    arguments.add_argument("--target", type=Path, default=ROOT / "target/faults", help="where to copy and build")
    arguments.add_argument("--keep", action="store_true", help="take the copy that is there, whatever has changed since")
    arguments.add_argument("--write", action="store_true", help="write the tests that notice the faults into faults.txt")
    given = arguments.parse_args()
    faults = read_faults()
    tree = given.target.resolve() / "tree"
    if not given.keep:
        lay_out(tree, faults)
    begun = time.monotonic()
    tests = Tests(tree, build(tree, given.target.resolve() / "build"))
    print(f"{len(faults)} faults, {len(tests.programs)} test programs, built in {time.monotonic() - begun:.0f} s", flush=True)
    begun = time.monotonic()
    only = {int(number) for number in given.only.split(",")} if given.only else None
    tried = [fault for fault in faults if only is None or fault.number in only]
    survived, wrong, killers = [], [], {}
    for fault in tried:
        killer = killers[fault.number] = tests.killer(fault)
        if killer is None:
            survived.append(fault)
        if (killer is None) != (fault.excuse is not None):
            wrong.append(fault)
        print(f"{'SURVIVES' if killer is None else 'killed  '} {fault.number:3} {fault.path}: {fault.meaning}", flush=True)
        print(f"             {killer or fault.excuse or 'no test notices, and no reason is given'}", flush=True)
    if given.write:
        write_killers({number: killer for number, killer in killers.items() if killer and "(" not in killer})
    took_s = time.monotonic() - begun
    print(f"{len(tried)} faults, {len(tried) - len(survived)} killed, {len(survived)} survive, in {took_s:.0f} s")
    too_many = only is None and len(survived) > MOST_SURVIVING * len(tried)
    sys.exit(1 if wrong or too_many else 0)


if __name__ == "__main__":
    main()
