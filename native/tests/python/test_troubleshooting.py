# SPDX-License-Identifier: GPL-3.0-or-later
"""What docs/troubleshooting.md says that Tug says, it says."""

import ast
import re
from pathlib import Path

import pytest

CHECKOUT = Path(__file__).resolve().parents[3]
PAGE = CHECKOUT / "docs" / "troubleshooting.md"
TITLES = re.findall(r"^### `(.*)`$", PAGE.read_text(), re.MULTILINE)
REST = "..."  # stands for whatever follows
FEWEST_LETTERS = 12  # of a text of the code, for it to tell anything
C_STRING = r'"((?:[^"\\\n]|\\.)*)"'
MESH_CHECK = CHECKOUT / "native" / "src" / "mesh" / "mesh_check.c"


def texts_of_python():
    """Every string of the add-on as a regular expression, with anything for what is put in."""
    for file in sorted((CHECKOUT / "addon").rglob("*.py")):
        for node in ast.walk(ast.parse(file.read_text())):
            if isinstance(node, ast.JoinedStr):
                parts = [
                    re.escape(part.value) if isinstance(part, ast.Constant) else ".+"
                    for part in node.values
                ]
                yield "".join(parts)
            elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                yield re.escape(node.value)


def texts_of_mesh_check():
    """Each problem of a mesh with what to do, as `"%s: %d, for example %s. %s"` puts it."""
    kinds = re.findall(rf"\{{{C_STRING}, \d,\s*{C_STRING}\}}", MESH_CHECK.read_text())
    assert kinds
    for problem, remedy in kinds:
        yield rf"{re.escape(problem)}: \d+, for example .+\. {re.escape(remedy)}"


TEXTS = [
    re.compile(text, re.DOTALL)
    for text in (*texts_of_python(), *texts_of_mesh_check())
    if len(re.sub(r"\.\+|[^A-Za-z]", "", text)) >= FEWEST_LETTERS
]


def is_said(title):
    if title.endswith(REST):
        start = title.removesuffix(REST).rstrip()
        return any(text.match(f"{start} \n and so on") for text in TEXTS)
    return any(text.fullmatch(title) for text in TEXTS)


def test_there_are_titles():
    assert len(TITLES) > 20


@pytest.mark.parametrize("title", TITLES)
def test_a_title_is_a_text_of_the_code(title):
    assert is_said(title)


def test_a_text_that_is_not_in_the_code_is_found_out():
    assert not is_said('"Fox" has no shape keys, sorry')
    assert not is_said("anything at all")
