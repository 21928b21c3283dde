"""Fixtures of all tests."""

from pathlib import Path

import pytest

import raypath


@pytest.fixture(scope="session")
def root() -> Path:
    """The root of the repository."""
    return Path(__file__).parents[3]


@pytest.fixture(scope="session")
def datapath() -> raypath.Datapath:
    """The preset ``paper``."""
    return raypath.Datapath()
