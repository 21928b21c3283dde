"""The command line: ``python -m raypath.cluster``."""

import sys

from raypath.cluster.cli import main

if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
