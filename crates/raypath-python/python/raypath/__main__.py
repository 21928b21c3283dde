"""The command line: ``python -m raypath COMMAND …``, also installed as the program ``raypath``."""

import signal
import sys

from raypath import _raypath


def main() -> int:
    """Runs the command that ``sys.argv`` names and returns its exit code."""
    # Python's handler would only set a flag, which is read after the command has returned.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _raypath.main(["raypath", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
