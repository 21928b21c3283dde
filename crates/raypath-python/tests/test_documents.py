"""All examples: those of docstrings, of the document and of the notebook."""

import dataclasses
import doctest
import inspect
import os
import re
from pathlib import Path
from typing import Any

import nbclient
import nbformat
import numpy as np
import pytest

import raypath
from raypath import _raypath


def documented() -> dict[str, str]:
    """The docstrings of the package, of its public objects and of their public attributes, by name."""
    found = {"raypath": raypath.__doc__ or ""}
    for name in [*raypath.__all__, "main", "rust_seconds"]:
        item = getattr(raypath, name, None) or getattr(_raypath, name)
        if inspect.isclass(item) or inspect.isbuiltin(item):
            found[name] = item.__doc__ or ""
        if inspect.isclass(item):
            # Those of a dataclass are the arguments of its docstring.
            fields = [field.name for field in dataclasses.fields(item)] if dataclasses.is_dataclass(item) else []
            attributes = (key for key in vars(item) if not key.startswith("_") and key not in fields)
            found |= {f"{name}.{attribute}": getattr(item, attribute).__doc__ or "" for attribute in attributes}
    return found


def test_everything_is_documented() -> None:
    """Every public object has a docstring; one with arguments states their errors."""
    docstrings = documented()
    assert len(docstrings) > 60
    assert [name for name, text in docstrings.items() if not text] == []


@pytest.mark.parametrize("name", [name for name, text in documented().items() if ">>>" in text])
def test_docstring(name: str) -> None:
    """The examples of a docstring print what it states."""
    test = doctest.DocTestParser().get_doctest(documented()[name], {}, name, None, 0)
    report: list[str] = []
    result = doctest.DocTestRunner().run(test, out=report.append)
    assert result.attempted > 0
    assert result.failed == 0, "".join(report)


def test_document(root: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The blocks of the document run one after another."""
    monkeypatch.chdir(tmp_path)
    text = (root / "docs/integration/python.md").read_text()
    blocks = re.findall(r"```python\n(.*?)```", text, re.S)
    assert len(blocks) == 8
    names: dict[str, Any] = {}
    for block in blocks:
        exec(block, names)
    assert names["hits"].is_intersect.shape == (1000, 4)
    np.testing.assert_array_equal(names["d"] > 0, np.ones(1000, bool))
    assert os.path.exists("build/raypath.sv")
    assert names["outputs"].hit["t"] == names["traced"].t[0]
    assert os.path.exists("build/unit/raypath_unit.sv")


def test_notebook(root: Path) -> None:
    """The notebook runs in a kernel of its own, and its last cell draws a plot."""
    notebook = nbformat.read(root / "examples/explore.ipynb", as_version=4)
    assert all(not cell.get("outputs") for cell in notebook.cells), "the notebook is stored without outputs"
    nbclient.NotebookClient(notebook, timeout=120, kernel_name="python3").execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    kinds = {kind for output in outputs for kind in output.get("data", {})}
    assert {"image/png", "image/svg+xml", "text/html"} <= kinds
