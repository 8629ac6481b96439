"""Test EDLs as editors write them: without a rate, and with speeds beside equal lengths."""

import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.shot.reel import EditOptions
from heatlens.media.documents.edit_file import read_edit

EVENT = "001  sh010    V     C        {} {} 01:00:00:00 {}\n"


def write_edl(folder, lines: str):
    path = folder / "cut.edl"
    path.write_text(f"TITLE: CUT\nFCM: NON-DROP FRAME\n\n{lines}* FROM CLIP NAME: sh010\n")
    return path


@pytest.mark.parametrize(("last", "advised"), [("24", 25), ("29", 30), ("49", 50)])
def test_read_edit_of_edl_asks_for_rate_if_frame_number_exceeds_it(tmp_path, last, advised):
    path = write_edl(tmp_path, EVENT.format("01:00:00:00", f"01:00:01:{last}", f"01:00:01:{last}"))
    with pytest.raises(InputError, match=rf"cut\.edl .*up to {last}.*--edit-fps {advised}"):
        read_edit(path, EditOptions())
    reel = read_edit(path, EditOptions(rate=float(advised)))
    assert reel.frames_per_second == advised and len(reel.shots) == 1


def test_read_edit_of_edl_rejects_frame_number_of_no_rate(tmp_path):
    path = write_edl(tmp_path, EVENT.format("01:00:00:00", "01:00:01:99", "01:00:01:99"))
    with pytest.raises(InputError, match="no rate has so many"):
        read_edit(path, EditOptions())


@pytest.mark.parametrize(
    ("source_end", "speed", "count"),
    [
        ("00:00:41:22", "048.0", 10),  # as Resolve writes it: source and record of one length
        ("00:00:42:03", "048.0", 10),  # as the standard has it: the source is twice as long
        ("00:00:41:22", "012.0", 3),
        ("00:00:41:22", "024.0", 5),
    ],
)
def test_read_edit_of_edl_uses_speed_over_lengths(tmp_path, source_end, speed, count):
    path = write_edl(
        tmp_path,
        EVENT.format("00:00:41:17", source_end, "01:00:00:05")
        + f"M2   sh010          {speed}                00:00:41:17\n",
    )
    (shot,) = read_edit(path, EditOptions()).shots
    assert shot.frames is not None and len(tuple(shot.frames)) == count
    shown = 5 if shot.retime is None else shot.retime.count
    assert shown == 5
