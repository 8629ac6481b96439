"""Test that a network named by a shot runs only after the user has named or allowed it."""

import numpy as np
import pytest
from PIL import Image

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.shot import Shot
from heatlens.fronts.commands.main import main
from heatlens.media.documents.shot_file import write_shot
from heatlens.media.plate.estimate import trusted
from heatlens.media.plate.read import read_plate
from support.networks import write_network

ENDS = ("--near", "1", "--far", "9")


@pytest.fixture
def strangers(tmp_path, monkeypatch):
    """Return a shot, its picture and its network, as they come from somebody else."""
    monkeypatch.setenv("HEATLENS_CONFIG_DIR", str(tmp_path / "preferences"))
    monkeypatch.setenv("HEATLENS_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setenv(trusted._RUN_ALL_VARIABLE, "0")
    monkeypatch.setattr(trusted, "_question_callbacks", [])
    picture, network = tmp_path / "p.png", write_network(tmp_path / "n.onnx")
    Image.fromarray(np.full((24, 32, 3), 90, np.uint8)).save(picture)
    options = PlateOptions(depth_model=str(network), near_m=1.0, far_m=9.0)
    shot = tmp_path / "s.heatlens.json"
    write_shot(shot, Shot(Lens(50.0, 2.0, 3.0, 36.0), source=str(picture), plate_options=options))
    return shot, picture, network


def export(shot, *more) -> int:
    return main(["export", str(shot), "-o", str(shot.with_name("o.png")), *more])


def test_export_refuses_network_of_shot_and_names_option(strangers, capsys):
    shot, _, network = strangers
    assert export(shot) == 2
    stderr = capsys.readouterr().err
    assert str(network) in stderr and "--run-networks" in stderr and "--depth-model" in stderr
    assert not shot.with_name("o.png").exists()
    assert export(shot, "--run-networks") == 0


def test_network_given_once_is_trusted_until_its_content_changes(strangers, capsys):
    shot, picture, network = strangers
    out = str(picture.with_name("r.png"))
    words = ["render", str(picture), "-o", out, "--depth-model", str(network), *ENDS]
    assert main([*words, "--f-stop", "2", "--focus-distance", "3", "--focal-length", "50"]) == 0
    assert export(shot) == 0
    write_network(network, bias=0.25)
    assert export(shot, "--overwrite") == 2
    assert "which runs like a program" in capsys.readouterr().err


@pytest.mark.parametrize("answer", [True, False])
def test_trusted_network_is_asked_for_and_remembered(strangers, answer):
    _, picture, network = strangers
    questions: list[str] = []

    def answer_question(question: str) -> bool:
        questions.append(question)
        return answer

    trusted.set_question(answer_question)
    options = PlateOptions(depth_model=str(network), near_m=1.0, far_m=9.0)
    for _ in range(2):
        if answer:
            read_plate(picture, options)
        else:
            with pytest.raises(InputError, match="like a program"):
                read_plate(picture, options)
    assert len(questions) == (1 if answer else 2) and str(network) in questions[0]


@pytest.mark.parametrize("content", ["", "{", "[[[", '"x"', "[3, null]"])
def test_damaged_trust_file_trusts_no_network(strangers, content):
    shot, _, _ = strangers
    file = trusted._remembered_file()
    file.parent.mkdir()
    file.write_text(content)
    assert export(shot) == 2
