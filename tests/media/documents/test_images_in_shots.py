"""Test opening images in shots and kits: paths relative to the file, and digests."""

import json
from dataclasses import replace
from pathlib import Path

import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.lens.lens_kit import KitLens, LensCharacter, LensKit
from heatlens.core.model.shot.look import Look
from heatlens.core.model.shot.shot import Shot
from heatlens.media.documents.lens_kits import kit_text, read_kit
from heatlens.media.documents.shot_file import read_shot, write_shot
from heatlens.media.plate.opening_picture import read_opening_image
from support.command_line import stderr_of_run
from support.opening_images import heart_path


@pytest.fixture
def lens(tmp_path: Path) -> Lens:
    (tmp_path / "images").mkdir()
    path = tmp_path / "images" / "heart.png"
    path.write_bytes(heart_path().read_bytes())
    return Lens(50.0, 2.0, 3.0, 36.0, aperture_image=read_opening_image(path))


def shot_of(lens: Lens) -> Shot:
    kit = LensKit("own", "hearts", (KitLens(50.0, 2.0, 0.5),), LensCharacter(blades=5))
    kit = replace(kit, character=LensCharacter(aperture_image=lens.aperture_image))
    return Shot(lens, looks=(Look("A", lens),), kit=kit)


def test_shot_file_stores_image_of_lens_look_and_kit_by_relative_path(
    tmp_path: Path, lens: Lens
) -> None:
    shot, path = shot_of(lens), tmp_path / "s.heatlens.json"
    write_shot(path, shot)
    entries = json.loads(path.read_text())
    assert entries["lens"]["aperture_image"] == "images/heart.png"
    assert entries["looks"][0]["lens"]["aperture_image"] == "images/heart.png"
    assert entries["lens_kit"]["character"]["aperture_image"] == "images/heart.png"
    assert read_shot(path) == shot


def test_shot_file_finds_its_image_after_both_are_moved(tmp_path: Path, lens: Lens) -> None:
    write_shot(tmp_path / "s.heatlens.json", shot_of(lens))
    new_folder = tmp_path / "moved"
    (new_folder / "images").mkdir(parents=True)
    for name in ("s.heatlens.json", "images/heart.png"):
        (tmp_path / name).rename(new_folder / name)
    image = read_shot(new_folder / "s.heatlens.json").lens.aperture_image
    assert image is not None and lens.aperture_image is not None
    assert image.path == str(new_folder / "images" / "heart.png")
    assert image.digest == lens.aperture_image.digest


def test_read_shot_reports_missing_opening_image(tmp_path: Path, lens: Lens) -> None:
    path = tmp_path / "s.heatlens.json"
    write_shot(path, shot_of(lens))
    (tmp_path / "images" / "heart.png").unlink()
    with pytest.raises(InputError, match=r"s.heatlens.json: .*heart.png is not there") as error:
        read_shot(path)
    assert "\n" not in str(error.value)


def test_shot_file_without_opening_image_has_no_entry_for_it(tmp_path: Path, lens: Lens) -> None:
    """Earlier versions can still open such a file, and their own files have no entry."""
    path = tmp_path / "s.heatlens.json"
    write_shot(path, Shot(replace(lens, aperture_image=None)))
    assert "aperture_image" not in path.read_text()
    assert read_shot(path).lens.aperture_image is None


def test_lens_without_advice_depends_on_image_digest_not_path(tmp_path: Path, lens: Lens) -> None:
    assert lens.aperture_image is not None
    elsewhere = replace(lens.aperture_image, path="/elsewhere.png")
    other = replace(lens.aperture_image, digest="other")
    same, changed = (replace(lens, aperture_image=image) for image in (elsewhere, other))
    assert same.without_advice() == lens.without_advice() != changed.without_advice()


def test_read_kit_finds_opening_image_beside_the_kit(tmp_path: Path, lens: Lens) -> None:
    kit = shot_of(lens).kit
    assert kit is not None
    entries = json.loads(kit_text(kit))
    entries["character"]["aperture_image"] = "images/heart.png"
    path = tmp_path / "own.json"
    path.write_text(json.dumps(entries))
    assert read_kit(path) == kit
    assert kit.limit_lens(Lens(35.0, 2.0, 3.0, 36.0)).aperture_image == lens.aperture_image
    entries["character"]["aperture_image"] = "images/none.png"
    path.write_text(json.dumps(entries))
    with pytest.raises(InputError, match=r"own.json: .*none.png is not there"):
        read_kit(path)


@pytest.mark.parametrize("name", ["a\0b.png", "\ud800.png"])
def test_opening_image_with_impossible_file_name_is_rejected(
    tmp_path: Path, lens: Lens, name: str, capsys: pytest.CaptureFixture[str]
) -> None:
    shot, kit = tmp_path / "s.heatlens.json", tmp_path / "own.json"
    write_shot(shot, shot_of(lens))
    shot.write_text(shot.read_text().replace('"images/heart.png"', json.dumps(name)))
    entries = json.loads(kit_text(shot_of(lens).kit))
    entries["character"]["aperture_image"] = name
    kit.write_text(json.dumps(entries))
    assert "s.heatlens.json: " in stderr_of_run(capsys, 2, "shot", "show", shot)
    with pytest.raises(InputError, match=r"own.json: .* is not there"):
        read_kit(kit)
