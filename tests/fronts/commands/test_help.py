"""Test `heatlens help WORD ...`: it finds options, keys and sections of the manual."""

import pytest

from heatlens.core.base.manual_search import (
    Passage,
    best_passages,
    manual_passages,
    page_of,
    passages_of,
)
from heatlens.fronts.commands.main import main

PROBES = {
    "overwrite": "--overwrite",
    "faster": "--proxy",
    "one frame": "--frame",
    "resume": "running it again",
    "media elsewhere": "--media",
    "black near": "--depth-convention",
    "unit of a table": "--table-unit",
    "OSC": "--lens-in",
    "alpha": "coverage of all surfaces",
    "brighter lamps": "--lift-highlights",
    "GPU": "--device",
    "log": "HEATLENS_LOG_DIR",
    "blades": "--blades",
    "hyperfocal": "Triangle",
    "clean plate": "--behind",
    "burn-in": "--burn-in",
    "double click": "--install-desktop",
    "anamorphic": "--squeeze",
}


@pytest.mark.parametrize("question", PROBES)
def test_answer_is_among_first_five_hits(question):
    hits = best_passages(manual_passages(has_references=True), question, 5)
    assert any(PROBES[question] in hit.text for hit in hits), [hit.text[:80] for hit in hits]


def test_help_prints_hits_with_their_sections(capsys):
    assert main(["help", "split", "diopter"]) == 0
    output = capsys.readouterr().out
    assert "--split-dioptres" in output and "Tilt and split diopter" in output
    assert all(len(line) <= 100 for line in output.splitlines())


def test_help_without_hits_is_refused_with_the_nearest_command(capsys):
    assert main(["help", "rendr"]) == 2
    assert "Did you mean render?" in capsys.readouterr().err
    assert main(["help", "xyzzy"]) == 2
    assert "Try other words" in capsys.readouterr().err


def test_rare_words_count_more_than_common_ones():
    passages = [Passage("", f"lens and number {i}") for i in range(20)] + [Passage("", "rare lens")]
    assert best_passages(passages, "the rare lens", 1) == [passages[-1]]
    assert best_passages(passages, "the", 5) == []


def test_passages_are_rows_items_and_paragraphs_below_their_headings():
    page = (
        "# A\n\nFirst [one](x.md).\n\n## B\n\n| a | b |\n| --- | --- |\n| `c` | d |\n\n- e\n- f\n"
    )
    found = [(it.place, it.text) for it in passages_of(page + "\n```\nno\n```\n")]
    assert found == [("A", "First one."), ("A > B", "c: d"), ("A > B", "e"), ("A > B", "f")]


def test_page_of_names_the_page_of_every_passage():
    for passage in manual_passages(has_references=True):
        assert passage.place.startswith(page_of(passage).read_text("utf-8")[2:].partition("\n")[0])
