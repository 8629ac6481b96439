"""A kind of source is one record: one that a test makes up works everywhere, without other changes.

Its frames come from a formula. The record is all that heatlens learns of it: it opens in a session,
plays, is exported, and is refused in words for what it does not do.
"""

import inspect
from dataclasses import dataclass, fields

import numpy as np
import pytest

import heatlens
from heatlens.core.base.errors import InputError
from heatlens.core.base.extras import OnUse
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.plate_options import PlateOptions
from heatlens.core.model.shot.shot import Shot
from heatlens.media.camera.from_shot import camera_before_plates
from heatlens.media.plate.exr.exr_read import read_parts
from heatlens.media.plate.header.header_lens import start_lens
from heatlens.media.plate.of_arrays import plate_of_arrays
from heatlens.render.source import kinds
from heatlens.render.source.kinds import KINDS, SourceKind, kind_of, refused
from heatlens.render.source.opened import Opened
from heatlens.render.source.source import Origin
from heatlens.studio.session.files.start_choices import word_of
from heatlens.studio.session.opened.picture_feed import PictureFeed
from support.command_line import stderr_of_run
from support.evening import begun, settled, until

FORMULA = "formula:waves"
FRAMES = FrameRange(1, 4)
LENS = Lens(50.0, 2.0, 2.0, 36.0)
NOT_ALONE = "A formula has no files."


def plate_at(frame: int):
    """Return a plate in focus whose light is the number of its frame."""
    return plate_of_arrays(np.full((12, 16, 3), frame, np.float32), np.full((12, 16), 2.0))


@dataclass(frozen=True)
class Formula:
    """Renders any frame again. Implements `heatlens.render.source.source.Source`."""

    text: str
    files = first_file = None
    frames = FRAMES
    has_many_views = False

    def require(self):
        pass

    def span(self, shot):
        return FRAMES

    def frames_of(self, shot):
        return tuple(shot.played or FRAMES)

    def check(self, shot, frames, missing):
        pass

    def origin(self, shot, frame, missing):
        return Origin(frame)

    def loader(self, shot, origins, renderer, is_for_file=False):
        return FormulaLoader(renderer)


@dataclass(frozen=True)
class FormulaLoader:
    renderer: object

    def load(self, origin):
        self.renderer.load(plate_at(origin.frame))

    def close(self):
        pass


class OpenedFormula(Opened):
    """What a session asks of an open source; the rest is that of the base."""

    def __init__(self, opening):
        self._opening, self.frame, self.again = opening, FRAMES.first, Formula(opening.text)

    text = property(lambda self: self._opening.text)
    options = property(lambda self: self._opening.options)
    frames = property(lambda self: FRAMES)
    notes = ("It is a formula.",)

    def lens(self, given):
        own = {"focal_length_mm": 50.0, "f_stop": 2.0, "focus_distance_m": 2.0}
        return start_lens(plate_at(1), own | {"sensor_width_mm": 36.0} | dict(given))

    def shot(self, lens, defocus):
        return Shot(lens, defocus, self.text, self.options, frames=FRAMES)


class FormulaFeed(PictureFeed):
    """Loads the frame at the playhead."""

    def begin(self):
        self._load(FRAMES.first)

    def __init__(self, picture, opened):
        super().__init__(picture)

    def show(self, shot, playhead):
        if playhead.frame != self.picture.frame:
            self._load(playhead.frame)

    def _load(self, frame):
        self.picture.ask(frame)
        self.picture.load(plate_at(frame))
        self.picture.is_settled = True


def commands():
    from heatlens.fronts.commands.sources.source_commands import SourceCommands

    class FormulaCommands(SourceCommands):
        """Makes a shot for `export`; all else is refused by the base."""

        def shot(self, args):
            return Shot(LENS, source=args.shot, plate_options=PlateOptions())

    return FormulaCommands()


MADE_UP = SourceKind(
    word=lambda _text: "Formula",
    article_word="a formula",
    takes=lambda text: text.startswith("formula:"),
    has_camera=False,
    reads_plates=False,
    refusal=NOT_ALONE,
    again=lambda text, _options, _timing: Formula(text),
    alone=refused,
    opened=OpenedFormula,
    camera=camera_before_plates,
    feed=FormulaFeed,
    commands=commands,
    python=refused,
)


@pytest.fixture(autouse=True)
def made_up(monkeypatch):
    monkeypatch.setattr(kinds, "KINDS", [MADE_UP, *KINDS])


def test_it_opens_and_plays_in_a_session(tmp_path):
    session = begun(tmp_path / "preferences", FORMULA)
    try:
        settled(session)
        assert session.facts.shot.source == FORMULA and session.time.timeline.frames == FRAMES
        assert not session.facts.has_camera
        lights = set()

        def has_shown_all():
            lights.add(float(session.source.plate.color[0, 0, 0]))
            return lights == set(FRAMES)

        session.time.timeline.play(1)
        until(session, has_shown_all, "each frame")
        assert session.files.exports.why_not == "" and word_of(FORMULA) == "Formula"
    finally:
        session.close()


def test_its_frames_are_exported(tmp_path, capsys):
    stderr_of_run(capsys, 0, "export", FORMULA, "-o", tmp_path / "out.####.exr")
    for frame in FRAMES:
        ((_, channels),) = read_parts(tmp_path / f"out.{frame:04}.exr")
        np.testing.assert_allclose(channels["G"], frame, rtol=1e-3)


@pytest.mark.parametrize(
    "words",
    [
        ("info", FORMULA),
        ("render", FORMULA, "-o", "a.exr"),
        ("shot", "new", FORMULA, "-o", "a.heatlens.json"),
    ],
)
def test_what_it_cannot_do_is_refused_in_words(capsys, tmp_path, monkeypatch, words):
    monkeypatch.chdir(tmp_path)
    assert NOT_ALONE in stderr_of_run(capsys, 2, *words)
    assert list(tmp_path.iterdir()) == []


def test_options_of_other_kinds_are_refused_by_its_name(capsys, tmp_path):
    for option in (("--scene-camera", "left"), ("--depth-channel", "Z")):
        said = stderr_of_run(capsys, 2, "export", FORMULA, "-o", tmp_path / "o.####.exr", *option)
        assert f"{FORMULA} is a formula, but this option is for" in said and option[0] in said


def test_python_and_files_alone_are_refused_in_words():
    for asked in (lambda: heatlens.open(FORMULA), lambda: MADE_UP.alone(FORMULA, PlateOptions())):
        with pytest.raises((InputError, heatlens.HeatlensError), match=NOT_ALONE):
            asked()


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.article_word)
def test_whatever_a_record_imports_on_use_is_there(kind):
    """What is written as text cannot be checked by mypy: each name is found and can be called."""
    doors = [value for name in fields(kind) if isinstance(value := getattr(kind, name.name), OnUse)]
    assert doors
    for door in doors:
        assert callable(door.found) and inspect.signature(door.found), door


def test_every_name_is_of_some_kind():
    assert kind_of("anything at all") is KINDS[-1]
    assert kind_of(FORMULA) is MADE_UP
