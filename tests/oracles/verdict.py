"""What a judge says of a file."""


class Wrong(Exception):
    """The file does not say what the schedule says."""


class Skipped(Exception):
    """The judge is not here."""


def demand(condition, what):
    """Raises Wrong with `what` unless the condition holds."""
    if not condition:
        raise Wrong(what)
