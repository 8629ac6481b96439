"""A process builds the programs of a session's pictures, which then needs no new one."""

from types import SimpleNamespace
from typing import Any, cast

import pytest

from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import DefocusSettings, Quality
from heatlens.core.model.shot.shot import Shot
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.known_programs import KnownPrograms
from heatlens.render.preview.build_programs import pictures_to_build
from heatlens.studio.board.session import Session
from heatlens.studio.session.pictures import program_builder
from heatlens.studio.session.pictures.program_builder import ProgramsFile
from heatlens.studio.settings.start import Start
from support.evening import run_until, run_until_settled
from support.session_files import room_file

DRAFT = DefocusSettings(quality=Quality.DRAFT, layers=2)


@pytest.fixture
def begin(ctx, tmp_path, monkeypatch):
    """Return a function that opens a source in a session that knows no programs."""
    monkeypatch.setattr(ctx, "known_programs", KnownPrograms())
    made = []

    def begun(source: str) -> Session:
        renderer, folder = FrameRenderer(ctx), tmp_path / "frames"
        made.append(Session(renderer, Start(source, defocus=DRAFT), frames_folder=folder))
        made[-1].begin()
        return made[-1]

    yield begun
    for session in made:
        session.close()


def refused_pictures(session: Session, monkeypatch) -> list[object]:
    """Return a list to which each request for the process will be added."""
    requests: list[object] = []
    request = session.pictures.builder.request
    monkeypatch.setattr(
        session.pictures.builder,
        "request",
        lambda shot, frame: (requests.append(shot), request(shot, frame)),
    )
    return requests


def test_whole_picture_comes_once_a_process_has_built_its_programs(
    begin, ctx, tmp_path, monkeypatch
):
    source = str(room_file(tmp_path / "room.exr"))
    session = begin(source)
    requests = refused_pictures(session, monkeypatch)
    run_until(session, lambda: session.pictures.live.output is not None, "a picture")
    assert not session.pictures.live.output.is_whole
    run_until(session, lambda: bool(session.pictures.builder.progress), "the process")
    run_until_settled(session)
    assert requests and session.pictures.live.output.is_whole
    session.close()
    monkeypatch.setattr(ctx, "known_programs", KnownPrograms())
    later = begin(source)
    later_requests = refused_pictures(later, monkeypatch)
    run_until_settled(later)
    assert not later_requests and later.pictures.live.output.is_whole


def test_session_builds_programs_itself_where_the_process_cannot_start(
    begin, tmp_path, monkeypatch
):
    monkeypatch.setenv("GLCONTEXT_DEVICE_INDEX", "99")
    session = begin(str(room_file(tmp_path / "room.exr")))
    requests = refused_pictures(session, monkeypatch)
    run_until_settled(session)
    assert requests and session.pictures.live.output.is_whole


def test_session_builds_programs_itself_where_the_process_takes_too_long(
    begin, tmp_path, monkeypatch
):
    monkeypatch.setattr(program_builder, "_PATIENCE_S", 0.0)
    session = begin(str(room_file(tmp_path / "room.exr")))
    requests = refused_pictures(session, monkeypatch)
    run_until_settled(session)
    assert requests and session.pictures.live.output.is_whole


def test_close_ends_the_process(begin, tmp_path, monkeypatch):
    session = begin(str(room_file(tmp_path / "room.exr")))
    run_until(session, lambda: bool(session.pictures.builder.progress), "the process")
    session.close()
    assert not session.pictures.builder.progress


def test_load_adds_what_was_saved_for_this_driver(ctx, tmp_path, monkeypatch):
    known = KnownPrograms()
    known.digests.add("a")
    monkeypatch.setattr(ctx, "known_programs", known)
    ProgramsFile(tmp_path / "new", ctx).save()
    later = KnownPrograms()
    monkeypatch.setattr(ctx, "known_programs", later)
    ProgramsFile(tmp_path / "none", ctx).load()
    assert not later.digests
    ProgramsFile(tmp_path / "new", ctx).load()
    assert later.digests == {"a"}


def test_save_in_a_folder_that_cannot_be_made_changes_nothing(ctx, tmp_path):
    (tmp_path / "file").write_bytes(b"")
    ProgramsFile(tmp_path / "file" / "below", ctx).save()
    assert (tmp_path / "file").read_bytes() == b""


@pytest.mark.parametrize("has_many_views", [False, True])
def test_quickest_pictures_are_built_before_the_whole_one(has_many_views):
    """A hand that drags waits for all pictures of the quickest level, at every focus distance."""
    renderer = SimpleNamespace(has_many_views=has_many_views, size=lambda _: (1280, 720))
    shot = Shot(Lens(50.0, 2.0, 3.0, 36.0))
    pictures = pictures_to_build(cast(Any, renderer), shot, 0)
    quickest = pictures[0].defocus
    last = max(i for i, picture in enumerate(pictures) if picture.defocus == quickest)
    assert pictures.index(shot) == last + 1 and len(set(pictures)) == len(pictures)
    assert {picture.lens.focus_distance_m for picture in pictures[: last + 1]} >= {3.0, 12.0}
