"""Test `--install-desktop`, `--uninstall-desktop`, and the icon of the program."""

import re
import shutil
import subprocess
from xml.etree import ElementTree

import numpy as np
import pytest

from heatlens.core.base.own_command import own_command
from heatlens.fronts.commands.main import main
from heatlens.studio.ui.icon import icon, icon_svg


@pytest.fixture
def data_home(tmp_path, monkeypatch):
    """The user's data folder, with a file of another program."""
    monkeypatch.setenv("XDG_DATA_HOME", str(tmp_path / "data"))
    foreign = tmp_path / "data" / "applications" / "other.desktop"
    foreign.parent.mkdir(parents=True)
    foreign.write_text("[Desktop Entry]\n")
    return tmp_path / "data"


def run(option: str) -> None:
    with pytest.raises(SystemExit) as end:
        main([option])
    assert end.value.code == 0


def exec_words(data_home) -> list[str]:
    """Return the words of the command in the desktop file, which are quoted as in a shell.

    The values of desktop files have escapes of their own around that.
    """
    text = (data_home / "applications" / "heatlens.desktop").read_text()
    (value,) = re.findall(r"^Exec=(.*)$", text, re.MULTILINE)
    line = value.replace(r"\\", "\\")
    shell = ["sh", "-c", f"printf '%s\\n' {line}"]
    return subprocess.run(shell, capture_output=True, text=True, check=True).stdout.splitlines()


@pytest.mark.parametrize("program", ["/usr/bin/python3", '/home/a b/50% "$x" `y` \\z/python'])
def test_desktop_file_starts_this_program(data_home, monkeypatch, program):
    monkeypatch.setattr("sys.executable", program)
    run("--install-desktop")
    words = [word.replace("%", "%%") for word in own_command("view")]
    assert exec_words(data_home) == [*words, "%f"]


def test_uninstall_removes_what_install_wrote(data_home):
    run("--install-desktop")
    ours = [path for path in data_home.rglob("heatlens.*") if path.is_file()]
    assert {path.suffix for path in ours} == {".desktop", ".svg", ".xml"}
    run("--uninstall-desktop")
    assert not [path for path in ours if path.exists()]
    assert (data_home / "applications" / "other.desktop").is_file()


def test_shots_and_reels_have_types_of_their_own(data_home):
    run("--install-desktop")
    root = ElementTree.parse(data_home / "mime" / "packages" / "heatlens.xml").getroot()
    patterns = {
        kind.attrib["type"]: glob.attrib["pattern"]
        for kind in root
        for glob in kind
        if glob.tag.endswith("glob")
    }
    assert set(patterns.values()) == {"*.heatlens.json", "*.heatreel.json"}
    desktop = (data_home / "applications" / "heatlens.desktop").read_text()
    assert all(kind in desktop for kind in patterns)
    if shutil.which("update-mime-database"):
        globs = (data_home / "mime" / "globs2").read_text()
        assert all(f"{kind}:{pattern}" in globs for kind, pattern in patterns.items())


def test_other_systems_are_refused_in_a_sentence(monkeypatch, capsys):
    monkeypatch.setattr("sys.platform", "win32")
    assert main(["--install-desktop"]) == 2
    assert "Desktop files are for Linux" in capsys.readouterr().err


@pytest.mark.parametrize("size_px", [64, 256])
def test_icon_has_colors_of_its_drawing_in_every_size(size_px):
    """Its corners are transparent, its ground dark, and the two circles of the lens are amber."""
    pixels = np.asarray(icon(size_px)).astype(int)
    assert pixels.shape == (size_px, size_px, 4)

    def at(x: float, y: float) -> list[int]:
        return list(pixels[round(y / 64 * size_px), round(x / 64 * size_px)])

    ground, amber = [0x16, 0x16, 0x17, 255], [0xF2, 0xA9, 0x3B, 255]
    assert pixels[0, 0, 3] < 60 and b"#f2a93b" in icon_svg()
    assert at(32, 8) == ground
    assert at(26.5, 31.5) == amber and at(10.2, 31.5)[0] > 150
    np.testing.assert_allclose(
        at(52, 32), [round(0.65 * a + 0.35 * b) for a, b in zip(ground, amber, strict=True)], atol=2
    )
