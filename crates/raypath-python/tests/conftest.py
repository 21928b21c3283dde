"""Fixtures of all tests."""

import signal
from pathlib import Path

import pytest

import raypath

# A shell without job control starts `./test.sh &` with Ctrl-C ignored, and so would be what the tests interrupt.
signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope="session")
def root() -> Path:
    """The root of the repository."""
    return Path(__file__).parents[3]


@pytest.fixture(scope="session")
def datapath() -> raypath.Datapath:
    """The preset ``paper``."""
    return raypath.Datapath()
