"""Test `heatlens study`: a complete page, the numbers of `compare`, and safe folders."""

import json
import sys
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

import numpy as np
import pytest
from PIL import Image

from heatlens.core.model.boxes import Box
from heatlens.fronts.commands.main import main
from heatlens.lab.measure.study import folder as folders
from heatlens.media.plate.exr.exr_write import write_exr
from support.command_line import CAMERA, start_heatlens
from support.exr_files import write_file
from support.patience import PATIENCE_S
from support.plates import room

WIDTH, HEIGHT = 48, 27
QUICK = ("--quality", "draft", "--runs", "1")
PLATE_METHODS = {"diffusion", "heat", "gather", "scatter", "pyramid"}
VOID = {"meta", "img", "br"}


class Page(HTMLParser):
    """A parser that checks that tags are closed in order, and collects texts, ids and links."""

    def __init__(self, path: Path) -> None:
        super().__init__()
        self.open: list[str] = []
        self.text, self.sources, self.ids, self.links = "", [], set(), set()
        self.feed(path.read_text(encoding="utf-8"))
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        attributes = dict(attrs)
        assert tag != "script" and not any(name.startswith("on") for name in attributes)
        self.sources += [attributes["src"]] if "src" in attributes else []
        self.links |= {attributes["href"]} if "href" in attributes else set()
        if "id" in attributes:
            assert attributes["id"] not in self.ids
            self.ids.add(attributes["id"])
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert tag in VOID or self.open.pop() == tag

    def handle_data(self, data):
        self.text += data


pytestmark = pytest.mark.usefixtures("ctx")


@pytest.fixture(scope="module")
def plate(tmp_path_factory) -> Path:
    """Return a plate of the room with the lens in its header."""
    color, depth = room(WIDTH, HEIGHT)
    channels = {name: color[..., i] for i, name in enumerate("RGB")} | {"Z": depth}
    return write_file(tmp_path_factory.mktemp("study") / "room.exr", channels, **CAMERA)


def run_study(plate, out, *words: object) -> dict:
    assert main(["study", str(plate), "-o", str(out), *QUICK, *map(str, words)]) == 0
    return json.loads((out / "study.json").read_text())


def message_of_refusal(capsys, *words: object) -> str:
    assert main(["study", *map(str, words)]) == 2
    captured = capsys.readouterr()
    assert captured.out == "" and len(captured.err.splitlines()) == 1
    return captured.err


# The page


def test_study_page_shows_and_measures_every_method(capsys, plate, tmp_path):
    out = tmp_path / "report"
    numbers = run_study(plate, out)
    assert capsys.readouterr().out == f"{out / 'index.html'}\n"
    assert {row["method"] for row in numbers["methods"]} == PLATE_METHODS
    page = Page(out / "index.html")
    assert {f"{m}{kind}.png" for m in PLATE_METHODS for kind in ("", "-difference", "-flip")} <= {
        *page.sources
    }
    assert all(row["seconds"] > 0 and row["runs"] == 1 for row in numbers["methods"])
    assert numbers["renderer"] in page.text


def test_study_page_links_only_to_files_beside_it(plate, tmp_path):
    out = tmp_path / "report"
    numbers = run_study(plate, out)
    page = Page(out / "index.html")
    file_names = {p.name for p in out.iterdir()}
    assert set(map(unquote, page.sources)) <= file_names == set(numbers["files"])
    internal_links = {link[1:] for link in page.links if link.startswith("#")}
    assert internal_links == page.ids
    assert page.links - {f"#{name}" for name in internal_links} == {"study.json"}
    assert "://" not in (out / "index.html").read_text() and "url(" not in page.text


def test_study_pictures_have_frame_size_and_crops_their_size(plate, tmp_path):
    out = tmp_path / "report"
    sides = {box[2] for box in run_study(plate, out, "--methods", "heat,gather")["crops"]}
    assert len(sides) == 1
    for path in out.glob("*.png"):
        with Image.open(path) as image:
            assert image.size == ((*sides, *sides) if "crop" in path.name else (WIDTH, HEIGHT))


def test_study_page_escapes_file_names(plate, tmp_path):
    odd = tmp_path / '<b id="x">&amp;.exr'
    odd.write_bytes(plate.read_bytes())
    run_study(odd, tmp_path / "report", "--methods", "heat")
    page = Page(tmp_path / "report" / "index.html")
    assert odd.name in page.text and "x" not in page.ids


# The numbers


def test_study_ranks_method_of_truth_first(capsys, plate, tmp_path):
    truth, out = tmp_path / "truth.exr", tmp_path / "report"
    render_words = ["render", plate, "-o", truth, "--method", "gather", "--float"]
    assert main([*map(str, render_words)]) == 0
    rows = run_study(plate, out, "--truth", truth)["methods"]
    assert rows[0]["method"] == "gather" and rows[0]["flip"] == 0 and rows[0]["psnr_db"] == 99
    flips = [row["flip"] for row in rows]
    assert flips == sorted(flips) and flips[1] > 0
    for name, is_same in (("gather", True), ("heat", False)):
        with Image.open(out / f"{name}-difference.png") as image:
            assert np.asarray(image).any() != is_same
    assert "truth: truth.exr" in capsys.readouterr().err


def test_study_scores_equal_scores_of_compare(capsys, plate, tmp_path):
    """The scores also agree for a truth that holds only a part of the frame."""
    part = Box(5, 3, 40, 25)
    grey = np.full(part.shape, 0.3, np.float32)
    display = Box(0, 0, WIDTH, HEIGHT)
    write_exr(tmp_path / "t.exr", dict.fromkeys("RGB", grey), part, display, half=False)
    words = ("--truth", tmp_path / "t.exr", "--methods", "pyramid")
    numbers = run_study(plate, tmp_path / "report", *words)
    picture = tmp_path / "p.exr"
    assert main(["render", str(plate), "-o", str(picture), "--method", "pyramid", "--float"]) == 0
    capsys.readouterr()
    assert main(["compare", str(picture), str(tmp_path / "t.exr"), "--json"]) == 0
    for name, value in json.loads(capsys.readouterr().out).items():
        assert numbers["methods"][0][name] == pytest.approx(value, rel=1e-5), name
    assert numbers["size"] == [part.width, part.height]


def test_study_without_truth_says_so(capsys, plate, tmp_path):
    numbers = run_study(plate, tmp_path / "report", "--quality", "film")
    assert "no truth was given" in capsys.readouterr().err
    page = Page(tmp_path / "report" / "index.html").text
    assert "There is no truth here" in page and "Nearest to diffusion, film: diffusion" not in page
    assert not numbers["reference_is_truth"]
    assert numbers["methods"][0]["method"] == "diffusion" and numbers["methods"][0]["flip"] == 0


# Refusals before the long work


def test_study_of_plate_rejects_scene_methods(capsys, plate, tmp_path):
    words = (plate, "-o", tmp_path / "report", "--methods", "heat,raytraced")
    assert "raytraced needs a 3D scene" in last_line_of_refusal(capsys, *words)
    assert not (tmp_path / "report").exists()


def last_line_of_refusal(capsys, *words: object) -> str:
    assert main(["study", *map(str, words)]) == 2
    return capsys.readouterr().err.splitlines()[-1]


def test_study_rejects_truth_of_other_size(capsys, plate, tmp_path):
    window = Box(0, 0, 12, 12)
    grey = np.ones((12, 12), np.float32)
    write_exr(tmp_path / "t.exr", dict.fromkeys("RGB", grey), window, window, half=False)
    words = (plate, "-o", tmp_path / "report", "--truth", tmp_path / "t.exr")
    assert "one pixel grid" in last_line_of_refusal(capsys, *words)
    assert [p.name for p in tmp_path.iterdir()] == ["t.exr"]


@pytest.mark.parametrize(
    ("option", "value", "words"),
    [("--methods", "heat,blur", "'blur'"), ("--runs", "0", "'0'"), ("--gain", "nan", "'nan'")],
)
def test_study_rejects_wrong_options(capsys, plate, option, value, words):
    with pytest.raises(SystemExit) as exit_error:
        main(["study", str(plate), "-o", "report", option, value])
    assert exit_error.value.code == 2 and words in capsys.readouterr().err


@pytest.mark.parametrize("package", ["matplotlib", "flip_evaluator"])
def test_study_without_package_names_pip_install(capsys, plate, tmp_path, monkeypatch, package):
    monkeypatch.setitem(sys.modules, package, None)
    message = message_of_refusal(capsys, plate, "-o", tmp_path / "report")
    assert "pip install 'heatlens[study]'" in message and package in message
    assert not (tmp_path / "report").exists()


def test_study_refuses_foreign_folder(capsys, plate, tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    assert "notes.txt" in message_of_refusal(capsys, plate, "-o", tmp_path)
    assert "is a file" in message_of_refusal(capsys, plate, "-o", tmp_path / "notes.txt")
    assert "there is no folder" in message_of_refusal(capsys, plate, "-o", tmp_path / "a" / "b")
    assert [p.name for p in tmp_path.iterdir()] == ["notes.txt"]


def test_study_replaces_old_report_completely(plate, tmp_path):
    out = tmp_path / "report"
    run_study(plate, out)
    run_study(plate, out, "--methods", "heat")
    assert not (out / "gather.png").exists() and (out / "heat.png").exists()
    assert [p.name for p in tmp_path.iterdir()] == ["report"]


def test_interrupted_study_keeps_old_report(capsys, plate, tmp_path, monkeypatch):
    out = tmp_path / "report"
    run_study(plate, out, "--methods", "heat")
    files_before = {p.name: p.read_bytes() for p in out.iterdir()}

    def stopped(*_):
        raise KeyboardInterrupt

    monkeypatch.setattr("heatlens.lab.measure.study.folder.write_numbers", stopped)
    assert main(["study", str(plate), "-o", str(out), *QUICK, "--methods", "gather"]) == 130
    assert [p.name for p in tmp_path.iterdir()] == ["report"]
    assert {p.name: p.read_bytes() for p in out.iterdir()} == files_before
    assert folders.check_target(out) == out.resolve()


def test_study_help_has_examples():
    process = start_heatlens("study", "--help")
    help_text, _ = process.communicate(timeout=PATIENCE_S)
    assert process.returncode == 0 and "examples:" in help_text and "--truth" in help_text
