"""Test the option `--lens-kit` and the command `heatlens kits`."""

import pytest
from PIL import Image

from heatlens.core.model.lens.lens_kit import KitLens, LensCharacter, LensKit
from heatlens.fronts.commands.main import main
from heatlens.media.documents.lens_kits import kit_text, read_kit
from heatlens.media.documents.shot_file import read_shot
from heatlens.media.plate.opening_picture import read_opening_image

SHOT = ("shot", "new", "nothing.####.exr", "--sensor-width", "36", "--focus-distance", "2")


@pytest.fixture
def make_shot(tmp_path, capsys):
    def make(*options: str):
        path = tmp_path / "s.heatlens.json"
        code = main([*SHOT, "-o", str(path), "--overwrite", *options])
        return (read_shot(path) if code == 0 else code), capsys.readouterr().err

    return make


def test_lens_kit_option_sets_focal_length_and_limits(make_shot):
    shot, _ = make_shot("--lens-kit", "anamorphic-2x:50", "--f-stop", "2.8")
    assert shot.kit.name == "anamorphic-2x"
    assert (shot.lens.focal_length_mm, shot.lens.f_stop) == (50.0, 2.8)
    assert (shot.lens.squeeze, shot.lens.close_focus_m) == (2.0, 0.75)


def test_squeeze_option_overrides_character_of_kit(make_shot):
    shot, _ = make_shot("--lens-kit", "anamorphic-2x:50", "--f-stop", "2.8", "--squeeze", "1.8")
    assert shot.lens.squeeze == 1.8


@pytest.mark.parametrize(
    ("options", "expected"),
    [
        (("anamorphic-2x:50", "--f-stop", "1.4"), "opens to f/1.8, not to f/1.4"),
        (("anamorphic-2x:51", "--f-stop", "2"), "has no 51 mm"),
        (("anamorphic-2x", "--f-stop", "2", "--focal-length", "55"), "has no 55 mm"),
        (("anamorphic-2x:50", "--f-stop", "2", "--focal-length", "60"), "two focal lengths"),
        (("anamorphic", "--f-stop", "2"), "There is no lens kit"),
    ],
)
def test_lens_kit_option_rejects_values_outside_kit(make_shot, options, expected):
    code, message = make_shot("--lens-kit", *options)
    assert code == 2
    assert expected in message


def test_breathe_option_uses_breathing_of_kit_or_given_ratio(make_shot):
    shot, _ = make_shot("--lens-kit", "vintage-primes:75", "--f-stop", "2.8")
    assert shot.lens.breathing == 1.0
    shot, message = make_shot("--lens-kit", "vintage-primes:75", "--f-stop", "2.8", "--breathe")
    assert shot.lens.breathing == 0.91 and "breathes" in message
    options = ("--focal-length", "50", "--f-stop", "2.8", "--breathing", "0.9")
    shot, _ = make_shot(*options)
    assert shot.lens.breathing == 0.9
    assert make_shot(*options[:4], "--breathe")[0] == 2
    assert make_shot(*options[:4], "--breathing", "3")[0] == 2


def test_lens_kit_option_rejects_focus_nearer_than_close_focus(make_shot):
    code, message = make_shot(
        *("--lens-kit", "modern-primes:135", "--f-stop", "2", "--focus-distance", "1")
    )
    assert code == 2
    assert "1.3 m, not from 1" in message


def test_kits_command_lists_prints_and_checks_kits(capsys, tmp_path):
    assert main(["kits"]) == 0
    text = capsys.readouterr().out
    assert "24-70 mm  opens to f/2.7 (T2.9), focuses from 0.8 m" in text
    assert main(["kits", "macro", "--json"]) == 0
    path = tmp_path / "mine.json"
    path.write_text(capsys.readouterr().out)
    assert read_kit(path).name == "macro"
    assert main(["kits", "--check", str(path)]) == 0
    assert main(["kits", "nothing"]) == 2


def test_kits_check_names_aperture_image_of_kit(tmp_path, capsys):
    Image.new("L", (8, 8), 255).save(tmp_path / "star.png")
    lens = KitLens(focal_length_mm=50.0, f_stop=2.0, close_focus_m=0.5)
    image = read_opening_image(str(tmp_path / "star.png"))
    kit = LensKit("own", "stars", (lens,), LensCharacter(rim=0.25, aperture_image=image))
    (tmp_path / "own.json").write_text(kit_text(kit))
    assert main(["kits", "--check", str(tmp_path / "own.json")]) == 0
    text = capsys.readouterr().out
    assert "rim 0.25" in text and "star.png" in text
