"""Writes the docstrings of the module raypath into its stub, for editors that show them without running it.

    target/python/venv/bin/python scripts/stub-docstrings.py
"""

from __future__ import annotations

import ast
import inspect
import textwrap
from pathlib import Path

from raypath import _raypath

STUB = Path(__file__).parents[1] / "crates/raypath-python/python/raypath/_raypath.pyi"


def with_docstrings(text: str) -> str:
    """The text of a stub with the docstrings of the objects that it declares."""
    lines = text.splitlines(keepends=True)
    declarations = [(node, _raypath) for node in ast.parse(text).body]
    declarations += [
        (member, getattr(_raypath, node.name))
        for node, _ in declarations
        if isinstance(node, ast.ClassDef) and hasattr(_raypath, node.name)
        for member in node.body
    ]
    for node, owner in sorted(declarations, key=lambda item: -item[0].lineno):
        if not isinstance(node, (ast.ClassDef, ast.FunctionDef)) or node.name.startswith("_"):
            continue
        first = node.body[0]
        assert isinstance(first, (ast.Expr, ast.FunctionDef))
        indent = " " * (node.col_offset + 4)
        documentation = textwrap.indent(f'"""{inspect.getdoc(getattr(owner, node.name))}"""', indent) + "\n"
        is_old = isinstance(first, ast.Expr)
        if is_old:
            assert first.end_lineno is not None
            before = lines[first.lineno - 1][: first.col_offset].rstrip()
            lines[first.lineno - 1 : first.end_lineno] = [before + "\n"] if before else []
            lines.insert(first.lineno if before else first.lineno - 1, documentation)
        else:
            lines.insert(min([first.lineno, *(it.lineno for it in first.decorator_list)]) - 1, documentation)
    return "".join(lines)


if __name__ == "__main__":
    STUB.write_text(with_docstrings(STUB.read_text()))
