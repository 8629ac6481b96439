"""The manual's section on licences names whatever heatlens installs that is not permissive."""

import importlib.metadata
import re
import tomllib
from itertools import chain
from pathlib import Path

import pytest

from support.manual import page

ROOT = Path(__file__).resolve().parents[2]
_, _, MANUAL_SECTION = page("start").partition("\n## Licences\n")
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
USED = [extra for name, extra in PROJECT["optional-dependencies"].items() if name != "test"]
NEEDED = sorted(
    {
        re.split(r"[<>=\[]", requirement)[0]
        for requirement in (*PROJECT["dependencies"], *chain(*USED))
    }
    - {"heatlens"}
)
PERMISSIVE = re.compile(
    "MIT|BSD|Apache|Zlib|CC0|PSF|Python Software Foundation|Matplotlib|unencumbered|OpenColorIO|"
    "Redistribution and use"
)
# Libraries in wheels that are GPL or LGPL themselves, whatever the metadata of the wheel say.
COPYLEFT = re.compile(r"lib(x264|x265|heif|de265)\b")


def licence_of(name: str) -> str:
    """Return the licence of a package: an expression, classifiers, or the licence text."""
    metadata = importlib.metadata.metadata(name)
    classifiers = [c for c in metadata.get_all("Classifier") or [] if c.startswith("License")]
    licence_text = metadata.get("License-Expression") or " ".join(
        [*classifiers, metadata.get("License") or ""]
    )
    texts = [f for f in importlib.metadata.files(name) or () if "licen" in str(f).lower()]
    return licence_text.strip() or " ".join(text.read_text() for text in texts)


@pytest.mark.parametrize("name", NEEDED)
def test_non_permissive_packages_are_named_in_manual(name):
    try:
        licence = licence_of(name)
    except importlib.metadata.PackageNotFoundError:
        pytest.skip(f"{name} is not installed")
    assert PERMISSIVE.search(licence) or f"`{name}`" in MANUAL_SECTION, licence
    files = map(str, importlib.metadata.files(name) or ())
    for library in {match[1] for match in map(COPYLEFT.search, files) if match}:
        assert f"`{name}`" in MANUAL_SECTION and library in MANUAL_SECTION
