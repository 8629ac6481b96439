"""Compare refusals of the command line, word for word, with a golden list of messages.

    pytest --update-golden tests/fronts/commands/test_messages.py    # read before you commit

Other tests assert only the file, number, option or key word that matters to them.
"""

import json
import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from heatlens.fronts.commands.main import main
from support.command_line import CAMERA, channels
from support.exr_files import rgb, write_file

GOLDEN = Path(__file__).parent / "golden" / "messages.json"
LENS = "--focal-length 50 --sensor-width 36 --f-stop 2 --focus-distance 3"
SITUATIONS = [
    "render",
    "rendr plate.exr",
    "render missing.exr -o o.exr",
    "render empty.exr -o o.exr",
    "render text.exr -o o.exr",
    "render cut.exr -o o.exr",
    "render folder -o o.exr",
    "render flat.exr -o o.exr",
    "render bare.exr -o o.exr",
    "render plate.exr -o o.xyz",
    "render plate.exr -o no/where/o.exr",
    "render plate.exr -o plate.exr",
    "render plate.exr -o o.exr --f-stop wide",
    "render plate.exr -o o.exr --f-stop 0",
    "render plate.exr -o o.exr --focal-length 50m",
    "render plate.exr -o o.exr --focus-distance 3miles",
    "render plate.exr -o o.exr --focus-distance 0.01",
    "render plate.exr -o o.exr --focus-at 960",
    "render plate.exr -o o.exr --focus-at 99,99",
    "render plate.exr -o o.exr --aperture 2",
    "render plate.exr -o o.exr --filmback Super36",
    "render plate.exr -o o.exr --lens-kit none:50",
    "render plate.exr -o o.exr --breathe",
    "render plate.exr -o o.exr --aperture-image black.png",
    "render plate.exr -o o.exr --depth-channel W",
    "render plate.exr -o o.exr --color-layer diffuse",
    "render plate.exr -o o.exr --eye left",
    "render plate.exr -o o.exr --depth-convention normalized",
    "render plate.exr -o o.exr --method accumulation",
    "render plate.exr -o o.exr --method gather --bokeh disc",
    "render plate.exr -o o.exr --layers 9",
    "render plate.exr -o o.exr --size 8x8",
    "render plate.exr -o o.exr --view Raw",
    "render plate.exr -o o.png --compression zip",
    "render plate.exr -o o.exr --keep-channels albedo",
    "render demo -o o.exr --scene-camera none",
    "render demo -o o.exr --frame 999",
    "render demo -o o.exr --up-axis y",
    "render s.heatlens.json -o o.exr",
    "export s.heatlens.json -o o.exr",
    "export s.heatlens.json -o o.####.gif",
    "export s.heatlens.json -o o.####.exr --frames 12-",
    "export s.heatlens.json -o o.####.exr --chunk 2",
    "export s.heatlens.json -o o.####.png --start-timecode ten",
    "export s.heatlens.json -o o.####.exr --matte-opacity 0.5",
    "shot new plate.exr -o s.json",
    "shot new plate.exr -o s.heatlens.json",
    f"shot new plate.exr -o n.heatlens.json {LENS} --key focus=3",
    "shot show plate.exr",
    "camera plate.exr",
    "camera s.heatlens.json -o cam.abc",
    "camera s.heatlens.json --send udp://x",
    "compare plate.exr missing.exr",
    "compare plate.exr plate.exr --min-ssim 7",
    "kits none",
    "view --demo plate.exr",
]


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Return the current folder of all situations, with good and damaged files."""
    monkeypatch.chdir(tmp_path)
    path = write_file(tmp_path / "plate.exr", channels(), **CAMERA)
    write_file(tmp_path / "bare.exr", channels())
    write_file(tmp_path / "flat.exr", rgb())
    (tmp_path / "cut.exr").write_bytes(path.read_bytes()[:-20])
    (tmp_path / "empty.exr").touch()
    (tmp_path / "text.exr").write_text("no picture")
    (tmp_path / "folder").mkdir()
    Image.fromarray(np.zeros((8, 8), np.uint8)).save(tmp_path / "black.png")
    words = f"shot new plate.exr -o s.heatlens.json {LENS} --frames 1-3"
    assert main(shlex.split(words)) == 0
    return tmp_path


def message_of(capsys, folder: Path, situation: str) -> str:
    """Return the stderr of a refused command line, joined to one line and without the folder."""
    capsys.readouterr()
    try:
        code = main(shlex.split(situation))
    except SystemExit as exit_error:
        code = exit_error.code
    captured = capsys.readouterr()
    assert code == 2 and not captured.out
    words = " ".join(captured.err.split()).replace(f"{folder}/", "")
    return re.sub(r"(?<=your own kits into )\S+", "FOLDER", words)


@pytest.mark.parametrize("situation", SITUATIONS)
def test_refusal_message_equals_golden_one(capsys, folder, situation, request):
    message = message_of(capsys, folder, situation)
    golden = json.loads(GOLDEN.read_text(encoding="utf-8")) if GOLDEN.exists() else {}
    if request.config.getoption("--update-golden"):
        golden[situation] = message
        in_order = {words: golden[words] for words in SITUATIONS if words in golden}
        GOLDEN.parent.mkdir(exist_ok=True)
        GOLDEN.write_text(json.dumps(in_order, indent=1, ensure_ascii=False) + "\n", "utf-8")
    assert message == golden[situation]


def test_golden_messages_match_situations():
    golden = json.loads(GOLDEN.read_text(encoding="utf-8"))
    assert list(golden) == SITUATIONS
    assert all(
        message.startswith("heatlens: ") and len(message) < 700 for message in golden.values()
    )
