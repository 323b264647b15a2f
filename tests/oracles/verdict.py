"""Verdicts of judges."""


class Wrong(Exception):
    """The file disagrees with the schedule."""


class Skipped(Exception):
    """The judge, or a file that it needs, is not available."""


def demand(condition, what):
    """Raises Wrong with `what` unless the condition holds."""
    if not condition:
        raise Wrong(what)
