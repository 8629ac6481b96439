"""--lens-kit and `heatlens kits`."""

import pytest
from PIL import Image

from heatlens.core.model.lens.lens_kit import KitLens, LensCharacter, LensKit
from heatlens.fronts.commands.main import main
from heatlens.media.documents.lens_kits import kit_text, read_kit
from heatlens.media.documents.shot_file import read_shot
from heatlens.media.plate.opening_picture import read_opening_image

SHOT = ("shot", "new", "nothing.####.exr", "--sensor-width", "36", "--focus-distance", "2")


@pytest.fixture
def made(tmp_path, capsys):
    def make(*options: str):
        path = tmp_path / "s.heatlens.json"
        code = main([*SHOT, "-o", str(path), "--overwrite", *options])
        return (read_shot(path) if code == 0 else code), capsys.readouterr().err

    return make


def test_a_lens_of_a_kit_has_its_length_and_its_limits(made):
    shot, _ = made("--lens-kit", "anamorphic-2x:50", "--f-stop", "2.8")
    assert shot.kit.name == "anamorphic-2x"
    assert (shot.lens.focal_length_mm, shot.lens.f_stop) == (50.0, 2.8)
    assert (shot.lens.squeeze, shot.lens.close_focus_m) == (2.0, 0.75)


def test_an_option_overrules_the_character_of_the_kit(made):
    shot, _ = made("--lens-kit", "anamorphic-2x:50", "--f-stop", "2.8", "--squeeze", "1.8")
    assert shot.lens.squeeze == 1.8


@pytest.mark.parametrize(
    ("options", "told"),
    [
        (("anamorphic-2x:50", "--f-stop", "1.4"), "opens to f/1.8, not to f/1.4"),
        (("anamorphic-2x:51", "--f-stop", "2"), "has no 51 mm"),
        (("anamorphic-2x", "--f-stop", "2", "--focal-length", "55"), "has no 55 mm"),
        (("anamorphic-2x:50", "--f-stop", "2", "--focal-length", "60"), "two focal lengths"),
        (("anamorphic", "--f-stop", "2"), "There is no lens kit"),
    ],
)
def test_what_the_kit_has_not_is_refused(made, options, told):
    code, said = made("--lens-kit", *options)
    assert code == 2
    assert told in said


def test_breathing_is_that_of_the_lens_or_as_it_is_told(made):
    shot, _ = made("--lens-kit", "vintage-primes:75", "--f-stop", "2.8")
    assert shot.lens.breathing == 1.0
    shot, said = made("--lens-kit", "vintage-primes:75", "--f-stop", "2.8", "--breathe")
    assert shot.lens.breathing == 0.91 and "breathes" in said
    told = ("--focal-length", "50", "--f-stop", "2.8", "--breathing", "0.9")
    shot, _ = made(*told)
    assert shot.lens.breathing == 0.9
    assert made(*told[:4], "--breathe")[0] == 2
    assert made(*told[:4], "--breathing", "3")[0] == 2


def test_a_focus_that_is_too_near_is_refused(made):
    code, said = made(
        *("--lens-kit", "modern-primes:135", "--f-stop", "2", "--focus-distance", "1"),
    )
    assert code == 2
    assert "1.3 m, not from 1" in said


def test_kits_are_listed_and_written_to_be_changed(capsys, tmp_path):
    assert main(["kits"]) == 0
    listed = capsys.readouterr().out
    assert "24-70 mm  opens to f/2.7 (T2.9), focuses from 0.8 m" in listed
    assert main(["kits", "macro", "--json"]) == 0
    path = tmp_path / "mine.json"
    path.write_text(capsys.readouterr().out)
    assert read_kit(path).name == "macro"
    assert main(["kits", "--check", str(path)]) == 0
    assert main(["kits", "nothing"]) == 2


def test_a_kit_with_an_image_is_listed_with_its_file(tmp_path, capsys):
    Image.new("L", (8, 8), 255).save(tmp_path / "star.png")
    lens = KitLens(50.0, 2.0, 0.5)
    image = read_opening_image(str(tmp_path / "star.png"))
    kit = LensKit("own", "stars", (lens,), LensCharacter(rim=0.25, aperture_image=image))
    (tmp_path / "own.json").write_text(kit_text(kit))
    assert main(["kits", "--check", str(tmp_path / "own.json")]) == 0
    told = capsys.readouterr().out
    assert "rim 0.25" in told and "star.png" in told
