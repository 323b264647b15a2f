class TimeOver(Exception):
    """What was waited for has not come in time."""


def failure(what, work):
    """Does some work whatever comes of it, since more is to be done after it: what has failed, in a list of at most one."""
    try:
        work()
        return []
    except Exception as error:
        return [f"{what} ({error})"]


def ask(hold):
    """Asks the person, and waits for Enter."""
    replies = []
    print(f"{hold['prompt']} (then press Enter)", flush=True)
    reader = threading.Thread(target=lambda: replies.append(sys.stdin.readline()), daemon=True)
    reader.start()
    begin = time.monotonic()
    while reader.is_alive():
        reader.join(0.05)
        if hold["at_most_s"] is not None and reader.is_alive() and time.monotonic() - begin > hold["at_most_s"]:
            raise TimeOver(f"nobody answered in {hold['at_most_s']:g} s: {hold['prompt']}")
    if not replies[0]:
        raise TimeOver(f"nobody is there to answer: {hold['prompt']}")


def wait_for(hold, is_high):
    """Waits for the person, or until the input has its level; `is_high` reads it."""
    if "prompt" in hold:
        return ask(hold)
    print(f"waiting until {hold['input']} is {hold['level']}, for at most {hold['at_most_s']:g} s", flush=True)
    begin = time.monotonic()
    while bool(is_high()) != (hold["level"] == "high"):
        if time.monotonic() - begin > hold["at_most_s"]:
            raise TimeOver(f"{hold['input']} is not {hold['level']} after {hold['at_most_s']:g} s")
        time.sleep(0.002)
    print(f"{hold['input']} is {hold['level']} after {time.monotonic() - begin:.3f} s", flush=True)


def asked(commands, hold):
    """Reads an input by a command of yours, which ends with 0 while it is high."""
    return subprocess.run(commands[hold["input"]], shell=True, stdout=subprocess.DEVNULL).returncode == 0


def add_inputs(parser, needed):
    """The option for inputs that no instrument here reads."""
    shown = ", ".join(sorted({hold["input"] for hold in needed})) or "none here"
    parser.add_argument("--input", action="append", default=[], metavar="NAME=COMMAND", help=f"how to read an input: the command ends with 0 while it is high ({shown})")


def commands_of(parser, arguments, needed):
    """The command for each input; a missing one ends the program."""
    commands = dict(pair.split("=", 1) for pair in arguments.input if "=" in pair)
    missing = sorted({hold["input"] for hold in needed} - set(commands))
    if missing and not (arguments.list or arguments.dry_run):
        parser.error(f"no command for the input {', '.join(missing)}: --input '{missing[0]}=COMMAND'")
    return commands


def pairs_of(parser, pairs, names, noun):
    """What is given for each name, as NAME=VALUE; a name that the program does not have ends the sender."""
    unknown = [pair for pair in pairs if "=" not in pair or pair.split("=", 1)[0] not in names]
    if unknown:
        parser.error(f"not {noun} of the program: {', '.join(unknown)}")
    return dict(pair.split("=", 1) for pair in pairs)


def status_of(work, packages):
    """Does the work, with its error on standard error: the exit status of the sender."""
    try:
        work()
        return 0
    except KeyboardInterrupt:
        print("stopped", file=sys.stderr)
        return 130
    except ImportError as error:
        print(f"the package {error.name} is not installed: {packages}", file=sys.stderr)
        return 1
    except Exception as error:  # whatever an instrument, its library or its connection raises
        print(f"{type(error).__name__}: {error}", file=sys.stderr)
        return 1
