"""Frames rendered ahead: in their order, kept under what they are made of, played, and dropped."""

from types import SimpleNamespace

import numpy as np
import pytest

from heatlens.core.base.errors import HeatlensError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.view.view import Compare
from heatlens.core.model.view.view_geometry import Viewport
from heatlens.media.plate.read import read_plate
from heatlens.render.display.screen_pictures import ScreenPictures
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.textures import download
from heatlens.render.preview.shown import Shown
from heatlens.render.rendered_frames.kept_pictures import half_of
from heatlens.studio.session.pictures.picture_view import PictureView
from heatlens.studio.session.playing import pull_jobs, rendered_pull
from heatlens.studio.session.playing.kept_screen import KeptScreen
from heatlens.studio.session.session import Session
from heatlens.studio.session.settings.preferences import Preferences
from heatlens.studio.session.shot.start import Start
from support.evening import settled, turn, until
from support.sequences import FIRST, frame_file, sequence_files
from support.session_files import HEIGHT, QUICK, WIDTH
from support.tev_peers import wait_until

LAST = FIRST + 3
FRAMES = frozenset(range(FIRST, LAST + 1))


@pytest.fixture
def session(ctx, renderer: FrameRenderer, tmp_path):
    source = sequence_files(tmp_path, FIRST, LAST)
    session = Session(
        renderer,
        Start(source, defocus=QUICK),
        preferences=Preferences.load(tmp_path / "preferences"),
    )
    session.begin()
    settled(session)
    session.pictures.view.viewport = Viewport((0.0, 0.0), (float(WIDTH), float(HEIGHT)))
    yield session
    session.close()


@pytest.fixture
def pull(session):
    return session.time.pull


def filled(session, count=4):
    until(session, lambda: len(session.time.pull.progress.rendered) == count, f"{count} frames")
    session.time.pull.store.wait()
    turn(session)


def test_all_played_frames_are_rendered_and_are_the_pictures_of_the_renderer(
    session, pull, renderer, tmp_path
):
    assert pull.is_on and not pull.is_alone
    filled(session)
    assert pull.progress.rendered == FRAMES and pull.progress.runs == (FrameRange(FIRST, LAST),)
    assert pull.wanted == 4 == pull.frames_made and len(pull.progress.keys) == 4
    assert not pull.has_work and pull.seconds_until_needed() is None
    assert pull.picture_bytes == WIDTH * HEIGHT * 8 and pull.jobs.size == (WIDTH, HEIGHT)
    own = FrameRenderer(renderer.ctx)
    for frame in FRAMES:
        assert pull.has(frame) and pull.is_at_hand(frame)
        own.load(read_plate(tmp_path / f"shot.{frame}.exr"))
        kept = pull.store.memory.get(pull.jobs.of(frame).key)
        np.testing.assert_array_equal(kept.pixels, half_of(own.pixels(session.editing.shot, frame)))


def test_frames_begin_at_the_playhead_and_go_in_its_direction(session, pull):
    session.time.timeline.go(FIRST + 2)
    session.poll()
    assert pull._order.frames == (FIRST + 2, FIRST + 3, FIRST, FIRST + 1)
    session.time.timeline.go(FIRST + 1)
    session.poll()
    assert pull._order.frames[:2] == (FIRST + 1, FIRST)
    session.time.timeline.playback.play(1, FIRST + 1, session.time.timeline.played)
    pull._put_in_order()
    assert pull._order.frames[:2] == (FIRST + 1, FIRST)  # not while it plays
    session.time.timeline.playback.stop()
    session.time.timeline.go(FIRST)
    session.time.timeline.set_out()
    session.poll()
    assert not pull.is_on and pull.wanted == 0


def test_a_changed_lens_makes_other_frames_and_undo_brings_them_back(session, pull):
    filled(session)
    keys = pull.progress.keys
    session.lens.commands.focus(1.3)
    session.editing.settle()
    turn(session)
    assert pull.progress.rendered == frozenset() and not pull.progress.keys & keys
    session.editing.undo()
    turn(session)
    assert pull.progress.rendered == FRAMES and pull.progress.keys == keys


def test_a_key_changes_the_frames_that_it_reaches(session, pull):
    filled(session)
    focus = session.facts.lens.focus_distance_m
    shot = session.editing.shot
    for frame in (FIRST, FIRST + 1):
        shot = shot.with_key(frame, LensParameter.FOCUS_DISTANCE, focus)
    session.editing.do(shot.with_key(LAST, LensParameter.FOCUS_DISTANCE, 2 * focus))
    turn(session)
    assert pull.progress.rendered == {FIRST, FIRST + 1}


def test_another_file_makes_its_frame_anew(session, pull, tmp_path):
    filled(session)
    jobs = pull.jobs
    before = jobs.of(FIRST + 1).key
    frame_file(tmp_path, FIRST + 1, owner="another")
    assert pull_jobs._EVERY_S == 2.0
    jobs._look_at = 0.0  # so many seconds later
    until(session, lambda: jobs.of(FIRST + 1) and jobs.of(FIRST + 1).key != before, "the file")
    assert jobs.of(FIRST).key in pull.progress.keys


def test_nothing_is_rendered_while_a_plate_is_read_or_without_room(session, pull, monkeypatch):
    wait_until(lambda: session.poll() or pull.has_work)
    with monkeypatch.context() as patch:
        patch.setattr(pull, "_filler", SimpleNamespace(is_reading=True))
        assert not pull.has_work
    with monkeypatch.context() as patch:
        patch.setattr(type(pull.store), "has_room", False)
        assert not pull.has_work
    assert pull.has_work


def test_input_makes_it_wait_for_a_moment(session, pull, monkeypatch):
    now = [100.0]
    pull._clock = lambda: now[0]
    wait_until(lambda: session.poll() or pull.has_work)  # the files are looked up
    pull.touched()
    assert pull.seconds_until_needed() == pytest.approx(0.3)
    made = pull.frames_made
    for _ in range(3):
        pull.work()
    assert pull.frames_made == made
    now[0] += 0.31
    assert pull.seconds_until_needed() == 0.0
    until(session, lambda: session.poll() or pull.work() or pull.frames_made > made, "a frame")
    pull._is_turning = lambda: True
    session.poll()
    assert pull.seconds_until_needed() == pytest.approx(0.3)  # a ring counts as input


def test_nothing_is_rendered_ahead_while_it_plays_or_others_work(session, pull):
    wait_until(lambda: session.poll() or pull.has_work)
    pull._is_busy = lambda: True
    assert not pull.has_work and pull.seconds_until_needed() is None
    pull._is_busy = lambda: False
    session.time.timeline.play(1)
    assert not pull.has_work
    session.time.timeline.play(1)
    pull.switch()
    assert not pull.is_on and not pull.has_work and not pull.kept.keep_frames
    session.poll()
    assert pull.wanted == 0 and not pull.has(FIRST) and not pull.is_at_hand(FIRST)
    pull.switch()
    assert pull.is_on and pull.kept.keep_frames


def test_kept_frames_play_alone_where_nothing_else_is_shown(session, pull):
    filled(session)
    session.time.timeline.play(1)
    assert pull.is_alone
    view = session.pictures.commands
    for change in (
        {"overlay": "zones"},
        {"compare": Compare.WIPE},
        {"depth_of_field": False},
    ):
        before = {name: getattr(session.facts.view, name) for name in change}
        view.change(**change)
        assert not pull.is_alone
        view.change(**before)
    assert pull.is_alone
    session.time.timeline.playback.stop()
    assert not pull.is_alone


def test_cleared_frames_are_rendered_again(session, pull):
    filled(session)
    pull.clear()
    assert not pull.store.known()
    until(session, lambda: pull.frames_made == 8, "the same frames")


def test_limits_count_in_megabytes(session, pull):
    pull.resize(64, 128)
    assert (pull.kept.memory_mb, pull.kept.disk_mb) == (64, 128)
    assert pull.store.memory.limit_bytes <= 64_000_000 * 1.05
    pull.store.memory.resize(2 * pull.picture_bytes)
    session.poll()
    assert pull.wanted == 2


def test_a_frame_that_cannot_be_rendered_is_left_and_the_others_go_on(
    session, pull, tmp_path, monkeypatch
):
    work, refused = rendered_pull.FrameFiller.work, []

    def failing(filler, job, after, seconds):
        if job.frame == FIRST + 1:
            refused.append(job.frame)
            raise HeatlensError("damaged")
        return work(filler, job, after, seconds)

    monkeypatch.setattr(rendered_pull.FrameFiller, "work", failing)
    filled(session, 3)
    until(session, lambda: not pull.has_work, "rest")
    assert refused == [FIRST + 1] and pull.progress.runs == (
        FrameRange(FIRST, FIRST), FrameRange(FIRST + 2, LAST),
    )  # fmt: skip
    pull.begin()
    assert pull.has_work  # tried again with another source


def test_the_scale_of_kept_pictures_is_about_that_of_the_window(session, pull):
    view = session.pictures.view
    for size, scale in ((WIDTH, 1.0), (3 * WIDTH, 1.0), (WIDTH / 2, 0.5), (WIDTH / 32, 1 / 16)):
        view.viewport = Viewport((0.0, 0.0), (size, float(HEIGHT)))
        assert pull.jobs._scale == scale
    view.viewport = Viewport((0.0, 0.0), (WIDTH * (0.5 + 0.2 / 16), float(HEIGHT)))
    assert pull.jobs._scale == 0.5  # a little larger changes nothing
    view.viewport = Viewport((0.0, 0.0), (WIDTH / 2, float(HEIGHT)))
    session.poll()
    assert pull.jobs.size == (WIDTH // 2, HEIGHT // 2)


# On the screen


@pytest.fixture
def screen(session, pull):
    pictures = ScreenPictures(session.pictures.renderer.ctx)
    pictures.display.set_transform(session.pictures.color.transform)
    made = KeptScreen(pull, session.source, session.editing, session.pictures.view, pictures)
    pull.screen = made
    yield made
    made.begin()


def test_the_frame_at_the_playhead_is_shown_as_it_was_rendered(session, pull, screen):
    assert screen.shown() is None  # none is rendered
    filled(session)
    session.time.timeline.go(FIRST + 1)
    shown = screen.shown()
    assert (shown.frame, shown.shot, shown.is_whole) == (FIRST + 1, session.editing.shot, True)
    assert screen.shown() is shown and screen.uploaded(shown) is shown
    kept = pull.store.memory.get(pull.jobs.of(FIRST + 1).key)
    np.testing.assert_array_equal(download(shown.texture), kept.pixels.astype(np.float32))
    assert screen.windows(shown) == session.source.feed.kept_windows(kept)
    session.time.timeline.go(FIRST + 2)
    later = screen.uploaded(screen.shown())
    assert later is not shown and later.texture is shown.texture
    kept = pull.store.memory.get(pull.jobs.of(FIRST + 2).key)
    np.testing.assert_array_equal(download(later.texture), kept.pixels.astype(np.float32))
    session.pictures.commands.toggle_overlay("zones")
    assert screen.shown() is None
    plain = Shown(later.texture, later.shot, 1, later.shot.defocus, 0.0)
    assert screen.windows(plain) is None and screen.uploaded(plain) is plain


def test_slow_machines_prepare_frames_for_the_screen_while_they_rest(session, pull, screen):
    filled(session)
    until(session, lambda: not screen.has_work, "all frames")
    view = session.facts.view
    textures = set()
    for frame in FRAMES:
        session.time.timeline.go(frame)
        turn(session)
        textures.add(screen.texture(screen.shown(), view.exposed_through(session.editing.lens)))
    assert len(textures) == 4  # one each, made beforehand
    session.pictures.commands.expose(2)
    assert screen.has_work
    screen.prepare()
    until(session, lambda: not screen.has_work, "all frames again")
    screen.begin()
    assert screen.has_work


def test_a_frame_that_is_seen_small_is_prepared_with_its_smaller_levels(
    session, screen, monkeypatch
):
    monkeypatch.setattr(PictureView, "zoom", 0.25)
    filled(session)
    until(session, lambda: not screen.has_work, "all frames")
    view = session.facts.view.exposed_through(session.editing.lens)
    made = screen.texture(screen.shown(), view)
    small, whole = (np.frombuffer(made.read(level=level), np.uint8) for level in (1, 0))
    assert small.size == whole.size // 4 and small.mean() == pytest.approx(whole.mean(), rel=0.02)
