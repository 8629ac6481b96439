"""Test that files, classes, functions and links named in the developer pages exist."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "app" / "heatlens"
PAGES = [
    path
    for folder in ("app", "app/manual", "tests", "shaders")
    for path in (ROOT / folder).glob("*.md")
]
PLACE = re.compile(r"`([\w/]+\.py): ([\w.]+)`")
FILE = re.compile(r"`([\w/]+\.(?:py|glsl|md))`")
LINK = re.compile(r"\]\(([^)#:]+)\)")
LINK_TO_SECTION = re.compile(r"\]\(([^)#:]*)#([^)]+)\)")
HEADING = re.compile(r"^#+ (.+)$", re.MULTILINE)


def names_in(path: Path) -> set[str]:
    """Return every name that a module defines, methods with their class: "Lens", "Lens.at"."""
    names: set[str] = set()
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            names.add(node.name)
        if isinstance(node, ast.ClassDef):
            methods = (m for m in node.body if isinstance(m, ast.FunctionDef))
            names |= {f"{node.name}.{method.name}" for method in methods}
        targets = node.targets if isinstance(node, ast.Assign) else []
        targets += [node.target] if isinstance(node, ast.AnnAssign) else []
        names |= {target.id for target in targets if isinstance(target, ast.Name)}
    return names


def page_id(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


@pytest.mark.parametrize("page", PAGES, ids=page_id)
def test_classes_and_functions_named_in_pages_exist(page):
    for file, name in PLACE.findall(page.read_text(encoding="utf-8")):
        assert (PACKAGE / file).is_file(), f"{page.name} names {file}"
        assert name in names_in(PACKAGE / file), f"{page.name} names {name} in {file}"


@pytest.mark.parametrize("page", PAGES, ids=page_id)
def test_files_named_in_pages_exist(page):
    roots = (PACKAGE, ROOT, page.parent)
    for file in FILE.findall(page.read_text(encoding="utf-8")):
        is_pattern = "NAME" in file
        assert is_pattern or any((root / file).is_file() for root in roots), file


@pytest.mark.parametrize("page", [*PAGES, ROOT / "README.md"], ids=page_id)
def test_links_in_pages_lead_to_files(page):
    for target in LINK.findall(page.read_text(encoding="utf-8")):
        assert (page.parent / target).exists(), f"{page.name} links to {target}"


def anchors_of(page: Path) -> set[str]:
    """Return the names of the sections of a page, as links to them name them."""
    headings = HEADING.findall(page.read_text(encoding="utf-8"))
    return {re.sub(r"[^\w -]", "", it.lower()).replace(" ", "-") for it in headings}


@pytest.mark.parametrize("page", [*PAGES, ROOT / "README.md"], ids=page_id)
def test_links_to_sections_lead_to_sections(page):
    for target, anchor in LINK_TO_SECTION.findall(page.read_text(encoding="utf-8")):
        assert anchor in anchors_of(page.parent / target if target else page), (target, anchor)


def test_app_readme_names_more_than_60_places():
    text = (ROOT / "app" / "README.md").read_text(encoding="utf-8")
    assert len(PLACE.findall(text)) > 60
