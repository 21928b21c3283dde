"""Errors that end a run with a message and exit code 2."""


class ClusterError(Exception):
    """What was found, where, and what was expected."""
