"""Tables, generation and configurations."""

import json
import pickle
import re
import runpy
from pathlib import Path
from typing import Any

import pandas
import pytest

import raypath


def test_readme_table(root: Path) -> None:
    """Flip-flops and latency of the presets, as README states them; the registers of all steps add up to them."""
    rows = re.findall(r"^\| `(\w+)`[^|]*\|[^|]*\| ([\d,]+) \| (\d+) \|", (root / "README.md").read_text(), re.M)
    assert [name for name, _, _ in rows] == [row["preset"] for row in raypath.presets()]
    for name, flip_flops, latency in rows:
        datapath = raypath.Datapath(name)
        assert datapath.flip_flops == int(flip_flops.replace(",", ""))
        assert datapath.latency == int(latency)
        registers = pandas.DataFrame(datapath.registers())
        assert registers["flip_flops"].sum() == datapath.flip_flops
        assert (registers["data"] + registers["control"] + registers["state"] == registers["flip_flops"]).all()


def test_units_are_those_of_the_paper(datapath: raypath.Datapath) -> None:
    """Adders and multipliers of each stage: Table VIII of the paper."""
    units = pandas.DataFrame(datapath.units()).set_index("stage")
    adders = {"2": 24, "3": 0, "4": 8, "5": 0, "6": 4, "7": 0, "8": 2, "9": 2, "10": 1}
    multipliers = {"2": 0, "3": 24, "4": 0, "5": 6, "6": 0, "7": 3, "8": 0}
    assert {stage: units["add"][stage] for stage in adders} == adders
    assert {stage: units["mul"][stage] for stage in multipliers} == multipliers
    assert list(units["step"]) == list(range(12))


def test_schedule(datapath: raypath.Datapath) -> None:
    """A cell for each step and operation; no operation uses more units in a step than there are."""
    schedule = pandas.DataFrame(datapath.schedule())
    units = pandas.DataFrame(datapath.units()).set_index("step")
    table = schedule.pivot_table(index="step", columns="operation", values="work", aggfunc="first")
    assert table.shape == (12, 4)
    assert "every box bound - origin" in table["quadbox"][2]
    for kind in ["encode", "add", "sum", "mul", "compare", "decode"]:
        assert (schedule.groupby("step")[kind].max() <= units[kind]).all()


def test_picture(datapath: raypath.Datapath, root: Path) -> None:
    """The picture of a notebook is that of the documents."""
    assert datapath._repr_svg_() == (root / "docs/images/pipeline.svg").read_text()


def test_generate(datapath: raypath.Datapath, tmp_path: Path) -> None:
    """All files that the lists name are written."""
    count = datapath.generate(tmp_path / "new")
    files = [path for path in (tmp_path / "new").rglob("*") if path.is_file()]
    assert len(files) == count
    listed = (tmp_path / "new/raypath.f").read_text().split()
    assert len(listed) > 10
    assert all((tmp_path / "new" / name).exists() for name in listed)
    assert "module raypath " in (tmp_path / "new/raypath.sv").read_text()


def test_card(datapath: raypath.Datapath) -> None:
    """A card has the figures of the tables, is read again, and is refused in another version."""
    card = datapath.card()
    units = pandas.DataFrame(datapath.units())
    assert {kind.split("_")[0]: count for kind, count in card["units"].items()} == {
        kind: units[kind].sum() for kind in ["encode", "add", "mul", "compare", "decode"]
    }
    assert (card["latency_cycles"], card["register_bits"]) == (datapath.latency, datapath.flip_flops)
    assert card["measured"] is None
    assert "--liberty" in card["absent"]["measured"]
    assert raypath.read_card(json.dumps(card)) == card
    with pytest.raises(ValueError, match="card_version is 2, expected 1"):
        raypath.read_card(json.dumps({**card, "card_version": 2}))


def test_parameters_are_keywords(root: Path) -> None:
    """The keywords of the stub are the parameters, and the default of each makes the default datapath."""
    parameters = raypath.parameters()
    stub = (root / "crates/raypath-python/python/raypath/_raypath.pyi").read_text()
    constructor = stub.split("        with_: str")[1].split(") -> Datapath")[0]
    assert re.findall(r"^ {8}(\w+):", constructor, re.M) == [row["keyword"] for row in parameters]
    defaults: dict[str, Any] = {row["keyword"]: row["default"] for row in parameters}
    assert raypath.Datapath(**defaults).config == raypath.Datapath().config


def test_configurations(tmp_path: Path) -> None:
    """Flags, presets, text and files select the same datapaths."""
    text = 'preset = "graphics"\ncontrol = "credit"\n'
    (tmp_path / "small.toml").write_text(text)
    compact = raypath.Datapath("compact")
    for same in [
        raypath.Datapath("graphics", control="credit"),
        raypath.Datapath(lanes="none", control="credit"),
        raypath.Datapath(config=text),
        raypath.Datapath(config=tmp_path / "small.toml"),
        raypath.Datapath(config=str(tmp_path / "small.toml")),
        raypath.Datapath(config=compact.config),
    ]:
        assert same.config == compact.config
        assert same.flip_flops == compact.flip_flops == 7104
    assert raypath.Datapath(config=text, control="skid").config == raypath.Datapath("graphics").config
    assert raypath.Datapath(facing=True, unit_latency=2, tag=8).latency == 22


@pytest.mark.parametrize("with_", ["sphere,key_compare", ["sphere", "key_compare"]])
def test_added_operations(with_: "str | list[str]") -> None:
    """Operations by name, which a pickled datapath has too."""
    datapath = raypath.Datapath("graphics", with_=with_)
    assert datapath.operations == ["triangle", "quadbox", "sphere", "key_compare"]
    assert {"sphere", "key_compare"} <= {row["operation"] for row in raypath.operations()}
    copy = pickle.loads(pickle.dumps(datapath))
    assert repr(copy) == repr(datapath) == "<raypath.Datapath: lanes none, rules paper, with sphere, key_compare>"


def test_the_stub_has_the_docstrings(root: Path) -> None:
    """Editors show the docstrings of the module without running it. ``scripts/stub-docstrings.py`` writes them."""
    with_docstrings = runpy.run_path(str(root / "scripts/stub-docstrings.py"))["with_docstrings"]
    stub = (root / "crates/raypath-python/python/raypath/_raypath.pyi").read_text()
    assert with_docstrings(stub) == stub
