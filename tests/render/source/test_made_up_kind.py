"""A new kind of source, declared in one SourceKind record, works in all parts of the program.

Its frames come from a formula. The record is all that heatlens knows of it: it opens in a session,
plays and is exported, and is refused with a message for what it cannot do.
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
from heatlens.render.source.kinds import KINDS, SourceKind, kind_of, refuse_source
from heatlens.render.source.opened import Opened
from heatlens.render.source.source import Origin
from heatlens.studio.session.opened.picture_feed import PictureFeed
from heatlens.studio.settings.cards import word_of
from support.command_line import stderr_of_run
from support.evening import begin_session, run_until, run_until_settled

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
        return tuple(shot.played_frames or FRAMES)

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
    """The open formula in a session; overrides only what the base class cannot know."""

    def __init__(self, opening):
        self._opening, self.frame, self.render_source = opening, FRAMES.first, Formula(opening.text)

    text = property(lambda self: self._opening.text)
    options = property(lambda self: self._opening.options)
    frames = property(lambda self: FRAMES)
    notes = ("It is a formula.",)

    def lens(self, given_fields):
        lens_fields = {"focal_length_mm": 50.0, "f_stop": 2.0, "focus_distance_m": 2.0}
        return start_lens(plate_at(1), lens_fields | {"sensor_width_mm": 36.0} | dict(given_fields))

    def shot(self, lens, defocus):
        return Shot(lens, defocus, source=self.text, plate_options=self.options, frames=FRAMES)


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
        self.picture.request(frame)
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
    matches=lambda text: text.startswith("formula:"),
    has_camera=False,
    reads_plates=False,
    refusal=NOT_ALONE,
    make_source=lambda text, _options, _timing: Formula(text),
    make_single_source=refuse_source,
    open_source=OpenedFormula,
    camera=camera_before_plates,
    feed=FormulaFeed,
    commands=commands,
    python=refuse_source,
)


@pytest.fixture(autouse=True)
def made_up(monkeypatch):
    monkeypatch.setattr(kinds, "KINDS", [MADE_UP, *KINDS])


def test_session_opens_and_plays_added_kind(tmp_path):
    session = begin_session(tmp_path / "preferences", FORMULA)
    try:
        run_until_settled(session)
        assert session.facts.shot.source == FORMULA and session.time.timeline.frames == FRAMES
        assert not session.facts.has_camera
        lights = set()

        def has_shown_all():
            lights.add(float(session.source.plate.color[0, 0, 0]))
            return lights == set(FRAMES)

        session.time.timeline.play(1)
        run_until(session, has_shown_all, "each frame")
        assert session.files.exports.why_not == "" and word_of(FORMULA) == "Formula"
    finally:
        session.close()


def test_export_writes_frames_of_added_kind(tmp_path, capsys):
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
def test_commands_refuse_added_kind_with_its_message(capsys, tmp_path, monkeypatch, words):
    monkeypatch.chdir(tmp_path)
    assert NOT_ALONE in stderr_of_run(capsys, 2, *words)
    assert list(tmp_path.iterdir()) == []


def test_export_refuses_options_of_other_kinds_by_article_word(capsys, tmp_path):
    for option in (("--scene-camera", "left"), ("--depth-channel", "Z")):
        message = stderr_of_run(
            capsys, 2, "export", FORMULA, "-o", tmp_path / "o.####.exr", *option
        )
        assert f"{FORMULA} is a formula, but this option is for" in message and option[0] in message


def test_python_api_refuses_added_kind_with_its_message():
    for open_formula in (
        lambda: heatlens.open(FORMULA),
        lambda: MADE_UP.make_single_source(FORMULA, PlateOptions()),
    ):
        with pytest.raises((InputError, heatlens.HeatlensError), match=NOT_ALONE):
            open_formula()


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.article_word)
def test_lazy_imports_of_source_kinds_resolve(kind):
    """Check that each `OnUse` name, written as text that mypy cannot check, is a callable."""
    lazy_imports = [
        value for name in fields(kind) if isinstance(value := getattr(kind, name.name), OnUse)
    ]
    assert lazy_imports
    for lazy_import in lazy_imports:
        assert callable(lazy_import.target) and inspect.signature(lazy_import.target), lazy_import


def test_kind_of_falls_back_to_last_kind():
    assert kind_of("anything at all") is KINDS[-1]
    assert kind_of(FORMULA) is MADE_UP
