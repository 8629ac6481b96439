"""Test lens kits as files: shipped ones, the user's own, and damaged ones."""

import json

import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.lens.lens_kit import LensCharacter
from heatlens.core.model.shot.shot import Shot
from heatlens.media.documents.lens_kits import kit_shelf, kit_text, read_kit
from heatlens.media.documents.shot_file import read_shot, write_shot

SHIPPED = ["anamorphic-2x", "macro", "modern-primes", "vintage-primes", "zooms"]


def test_kit_shelf_contains_shipped_kits_with_plausible_lenses(tmp_path):
    shelf = kit_shelf(tmp_path)
    assert list(shelf.kits) == SHIPPED
    assert not shelf.problems and not shelf.own
    for kit in shelf.kits.values():
        assert kit.character != LensCharacter()
        for lens in kit.lenses:
            assert 0.4 < lens.f_stop <= lens.t_stop < 1.2 * lens.f_stop
            assert 0.7 <= lens.breathing <= 1.0
    assert shelf.kits["anamorphic-2x"].character.squeeze == 2.0


@pytest.mark.parametrize("name", SHIPPED)
def test_read_kit_returns_written_kit(name, tmp_path):
    kit = kit_shelf(tmp_path).kits[name]
    (tmp_path / "mine.json").write_text(kit_text(kit))
    assert read_kit(tmp_path / "mine.json") == kit


def test_kit_shelf_adds_own_kits_and_overrides_shipped_ones(tmp_path):
    entries = json.loads(kit_text(kit_shelf(tmp_path).kits["macro"]))
    for name in ("macro", "mine"):
        own_kit = entries | {"name": name, "words": "my own"}
        (tmp_path / f"{name}.json").write_text(json.dumps(own_kit))
    shelf = kit_shelf(tmp_path)
    assert shelf.own == {"macro", "mine"}
    assert shelf.kits["macro"].words == "my own"
    assert shelf.select_kit("mine:100mm") == (shelf.kits["mine"], 100.0)


@pytest.mark.parametrize(
    ("changed", "reason"),
    [
        ({"heatlens_lens_kit": 2}, "version 2"),
        ({"lense": []}, "did you mean 'lenses'"),
        ({"lenses": []}, "has no lenses"),
        ({"lenses": [{"focal_length_mm": 50}]}, r"lenses\[0\]: the entry 'f_stop' is missing"),
        ({"character": {"squeeze": 9}}, "squeeze"),
        ({"name": "a b"}, "one word"),
        ({"words": 3}, "text in quotation marks"),
    ],
)
def test_kit_shelf_reports_damaged_kit_and_keeps_the_others(changed, reason, tmp_path):
    entries = json.loads(kit_text(kit_shelf(tmp_path).kits["macro"])) | changed
    path = tmp_path / "mine.json"
    path.write_text(json.dumps(entries))
    with pytest.raises(InputError, match=reason):
        read_kit(path)
    shelf = kit_shelf(tmp_path)
    assert list(shelf.kits) == SHIPPED
    (problem,) = shelf.problems
    assert str(path) in problem and "\n" not in problem
    with pytest.raises(InputError, match=r"mine\.json"):
        shelf.select_kit("mine")


@pytest.mark.parametrize("text", ["", "nothing", "zooms:20", "zooms:x", "zooms:-5", "zooms:inf"])
def test_chosen_kit_of_unknown_name_or_focal_length_raises_input_error(text, tmp_path):
    with pytest.raises(InputError):
        kit_shelf(tmp_path).select_kit(text)


def test_shot_file_keeps_its_kit_without_the_kit_file(tmp_path):
    kit = kit_shelf(tmp_path).kits["vintage-primes"]
    shot = Shot(kit.limit_lens(Lens(50.0, 2.8, 2.0, 36.0)), kit=kit)
    write_shot(tmp_path / "s.heatlens.json", shot)
    assert read_shot(tmp_path / "s.heatlens.json") == shot
