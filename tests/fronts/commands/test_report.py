"""Test `heatlens report`: one zip of text for a bug report, without pixels."""

import zipfile

from heatlens.core.base.log import FILE_VARIABLE
from heatlens.fronts.commands.main import main
from support.command_line import CAMERA, channels, stderr_of_run
from support.exr_files import write_file


def test_report_packs_header_faults_and_log(capsys, tmp_path, monkeypatch):
    plate = write_file(tmp_path / "plate.exr", channels(), **CAMERA)
    faults = tmp_path / "faults"
    faults.mkdir()
    for day in range(1, 6):
        (faults / f"fault-2026010{day}-120000-x.log").write_text(f"day {day}")
    monkeypatch.setenv("HEATLENS_LOG_DIR", str(faults))
    monkeypatch.setenv(FILE_VARIABLE, str(tmp_path / "a.log"))
    out = tmp_path / "report.zip"
    words = ["report", "-o", str(out), str(plate), str(tmp_path / "none.exr"), "--no-doctor"]
    assert main(words) == 0
    assert f"{out}: text alone" in capsys.readouterr().out
    with zipfile.ZipFile(out) as archive:
        texts = {name: archive.read(name).decode() for name in archive.namelist()}
    days = [f"fault-2026010{day}-120000-x.log" for day in (3, 4, 5)]
    assert list(texts) == ["info_1.txt", "info_2.txt", *days, "log.txt"]
    assert "focal length" in texts["info_1.txt"] and texts["info_1.txt"].endswith("code 0\n")
    assert "is not there" in texts["info_2.txt"] and texts["info_2.txt"].endswith("code 2\n")
    assert "command: " in texts["log.txt"]


def test_report_refuses_a_name_that_is_no_zip(capsys, tmp_path):
    assert "ends in .zip" in stderr_of_run(capsys, 2, "report", "-o", tmp_path / "a.txt")
