"""Looks: lenses that are kept, come back to, compared with, undone and written to the shot file."""

from dataclasses import replace

import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.marks.mark import free_letter
from heatlens.core.model.shot.framing import Framing
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.look import Look
from heatlens.core.model.shot.shot import Shot
from heatlens.core.model.view.picture_view import PictureView
from heatlens.core.model.view.view import Against, Compare
from heatlens.media.documents.shot_file import read_shot, write_shot
from heatlens.render.preview.level_choice import fastest_settings
from heatlens.render.preview.shown import PictureKey
from heatlens.studio.session.pictures.look_commands import LookCommands
from heatlens.studio.session.pictures.look_pictures import _Tile
from heatlens.studio.session.shot.editing import Editing
from support.shared import shared_of

LENS = Lens(50.0, 2.0, 3.0, 36.0)


@pytest.fixture
def looks(messages) -> LookCommands:
    return LookCommands(
        shared_of(Editing(Shot(LENS), messages.append), messages.append), PictureView()
    )


def test_look_commands_keep_go_delete_and_undo(looks, messages):
    editing = looks._editing
    looks.keep()
    assert looks.looks == (Look(name="A", lens=LENS, frame=0),) and "Ctrl+1" in messages[-1]
    wide = replace(LENS, focal_length_mm=24.0, f_stop=8.0)
    editing.edit_lens(wide)
    editing.settle()
    looks.keep()
    looks.use_number(0)
    assert editing.lens == LENS
    editing.undo()
    assert editing.lens == wide
    looks.use_number(1)
    looks.delete(looks.looks[0])
    assert [look.name for look in looks.looks] == ["B"]
    editing.undo()
    assert [look.name for look in looks.looks] == ["A", "B"]
    looks.use_number(7)
    assert "2 looks" in messages[-1]


def test_kept_looks_get_free_letters_and_rename_refuses_duplicates(looks, messages):
    for _ in range(3):
        looks.keep()
    looks.rename(looks.looks[1], "wide open")
    assert [look.name for look in looks.looks] == ["A", "wide open", "C"]
    assert free_letter(look.name for look in looks.looks) == "B"
    for name in ("A", "", " ", "a\nb"):
        before = looks.looks
        looks.rename(before[1], name)
        assert looks.looks == before and "look" in messages[-1].lower()


def test_shot_file_keeps_looks_and_omits_them_when_there_are_none(tmp_path):
    path = tmp_path / "a.heatlens.json"
    shot = Shot(LENS, looks=(Look("A", LENS, 7), Look("B", replace(LENS, f_stop=8.0), 9)))
    write_shot(path, shot)
    assert read_shot(path) == shot
    write_shot(path, Shot(LENS))
    assert "looks" not in path.read_text()
    with pytest.raises(InputError, match="Two looks"):
        Shot(LENS, looks=(Look("A", LENS), Look("A", LENS)))


def test_compare_shows_the_frame_through_a_look_as_b(looks):
    looks.keep()
    looks.compare(looks.looks[0])
    state = looks._view.state
    assert (state.against, state.b_look, state.compare) == (Against.LOOK, "A", Compare.WIPE)
    keyed = Shot(LENS).with_key(1, LensParameter.FOCUS_DISTANCE, 9.0)
    assert keyed.with_look(Look("A", LENS)).lens_at(1) == LENS


def test_quick_picture_of_a_look_is_a_quarter_size_but_never_empty():
    for framing, size in ((Framing(96, 54), (24, 14)), (None, None), (Framing(1, 1), (1, 1))):
        shot = Shot(LENS, framing=framing)
        quick = _Tile(PictureKey(plate=1, frame=7, shot=shot, settings=shot.defocus)).quick_key
        whole = (framing or Framing()).size
        assert quick.shot.framing.size == (size or tuple(round(side / 4) for side in whole))
        assert quick.frame == 7 and quick.settings == quick.shot.defocus == fastest_settings(
            shot.defocus
        )
