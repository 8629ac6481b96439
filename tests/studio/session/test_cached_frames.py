"""Frames rendered ahead: in their order, kept under what they are made of, played, and dropped."""

from types import SimpleNamespace

import numpy as np
import pytest

from heatlens.core.base.errors import HeatlensError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.view.picture_view import PictureView
from heatlens.core.model.view.view import Compare
from heatlens.core.model.view.view_geometry import Viewport
from heatlens.media.plate.read import read_plate
from heatlens.render.display.screen_pictures import ScreenPictures
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.textures import download
from heatlens.render.preview.shown import ShownPicture
from heatlens.render.rendered_frames.cached_pictures import to_half
from heatlens.studio.board.session import Session
from heatlens.studio.session.playing import ahead_jobs, frames_ahead
from heatlens.studio.session.playing.cached_screen import CachedScreen
from heatlens.studio.session.playing.render_scheduler import VisibleWork
from heatlens.studio.settings.preferences import Preferences
from heatlens.studio.settings.start import Start
from support.evening import run_loop_once, run_until, run_until_settled, wait_for_all_frames
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
    run_until_settled(session)
    session.pictures.view.viewport = Viewport((0.0, 0.0), (float(WIDTH), float(HEIGHT)))
    yield session
    session.close()


@pytest.fixture
def pull(session):
    return session.time.frames_ahead


def test_all_played_frames_are_rendered_ahead_as_by_the_renderer(session, pull, renderer, tmp_path):
    assert pull.is_on and not pull.plays_cached_frames
    wait_for_all_frames(session, 4)
    assert pull.progress.rendered_frames == FRAMES and pull.progress.runs == (
        FrameRange(FIRST, LAST),
    )
    assert pull.wanted_count == 4 == pull.frames_made and len(pull.progress.keys) == 4
    assert not pull.has_work and pull.seconds_until_needed() is None
    assert pull.picture_bytes == WIDTH * HEIGHT * 8 and pull.jobs.size == (WIDTH, HEIGHT)
    own_renderer = FrameRenderer(renderer.ctx)
    for frame in FRAMES:
        assert pull.is_rendered(frame) and pull.is_in_memory(frame)
        own_renderer.load(read_plate(tmp_path / f"shot.{frame}.exr"))
        cached_frame = pull.store.memory.get(pull.jobs.job_of(frame).key)
        np.testing.assert_array_equal(
            cached_frame.pixels, to_half(own_renderer.pixels(session.editing.shot, frame))
        )


def test_frames_ahead_are_ordered_from_playhead_in_its_direction(session, pull):
    session.time.timeline.go_to(FIRST + 2)
    session.poll()
    assert pull._order.frames == (FIRST + 2, FIRST + 3, FIRST, FIRST + 1)
    session.time.timeline.go_to(FIRST + 1)
    session.poll()
    assert pull._order.frames[:2] == (FIRST + 1, FIRST)
    session.time.timeline.playback.play(1, FIRST + 1, session.time.timeline.played)
    pull._order_frames()
    assert pull._order.frames[:2] == (FIRST + 1, FIRST)  # not while it plays
    session.time.timeline.playback.stop()
    session.time.timeline.go_to(FIRST)
    session.time.timeline.set_out()
    session.poll()
    assert not pull.is_on and pull.wanted_count == 0


def test_changed_focus_needs_new_frames_and_undo_restores_kept_ones(session, pull):
    wait_for_all_frames(session, 4)
    keys = pull.progress.keys
    session.lens.commands.focus(1.3)
    session.editing.settle()
    run_loop_once(session)
    assert pull.progress.rendered_frames == frozenset() and not pull.progress.keys & keys
    session.editing.undo()
    run_loop_once(session)
    assert pull.progress.rendered_frames == FRAMES and pull.progress.keys == keys


def test_new_focus_key_drops_only_frames_that_it_changes(session, pull):
    wait_for_all_frames(session, 4)
    focus = session.facts.lens.focus_distance_m
    shot = session.editing.shot
    for frame in (FIRST, FIRST + 1):
        shot = shot.with_key(frame, LensParameter.FOCUS_DISTANCE, focus)
    session.editing.do(shot.with_key(LAST, LensParameter.FOCUS_DISTANCE, 2 * focus))
    run_loop_once(session)
    assert pull.progress.rendered_frames == {FIRST, FIRST + 1}


def test_rewritten_plate_file_changes_the_key_of_its_frame(session, pull, tmp_path):
    wait_for_all_frames(session, 4)
    jobs = pull.jobs
    before = jobs.job_of(FIRST + 1).key
    frame_file(tmp_path, FIRST + 1, owner="another")
    assert ahead_jobs._CHECK_EVERY_S == 2.0
    jobs._next_check_s = 0.0  # so many seconds later
    run_until(
        session, lambda: jobs.job_of(FIRST + 1) and jobs.job_of(FIRST + 1).key != before, "the file"
    )
    assert jobs.job_of(FIRST).key in pull.progress.keys


def test_no_frame_is_rendered_ahead_during_plate_reading_or_full_store(session, pull, monkeypatch):
    wait_until(lambda: session.poll() or pull.has_work)
    with monkeypatch.context() as patch:
        patch.setattr(pull, "_filler", SimpleNamespace(is_reading=True))
        assert not pull.has_work
    with monkeypatch.context() as patch:
        patch.setattr(type(pull.store), "can_take_picture", False)
        assert not pull.has_work
    assert pull.has_work


def test_input_delays_frames_ahead_for_a_moment(session, pull, monkeypatch):
    clock_s = [100.0]
    pull._clock = lambda: clock_s[0]
    wait_until(lambda: session.poll() or pull.has_work)  # the files are looked up
    pull.note_input()
    assert pull.seconds_until_needed() == pytest.approx(0.3)
    frame_count = pull.frames_made
    for _ in range(3):
        pull.work()
    assert pull.frames_made == frame_count
    clock_s[0] += 0.31
    assert pull.seconds_until_needed() == 0.0
    run_until(
        session, lambda: session.poll() or pull.work() or pull.frames_made > frame_count, "a frame"
    )
    pull._is_turning = lambda: True
    session.poll()
    assert pull.seconds_until_needed() == pytest.approx(0.3)  # a ring counts as input


def test_no_frame_is_rendered_ahead_while_playing_busy_or_switched_off(session, pull, monkeypatch):
    wait_until(lambda: session.poll() or pull.has_work)
    with monkeypatch.context() as patch:
        # A visible picture that waits for programs: otherwise the loop would turn without a pause.
        patch.setattr(VisibleWork, "is_rendering", True)
        assert not pull.has_work and pull.seconds_until_needed() is None
    assert pull.has_work and pull.seconds_until_needed() is not None
    session.time.timeline.play(1)
    assert not pull.has_work
    session.time.timeline.play(1)
    pull.switch()
    assert not pull.is_on and not pull.has_work and not pull.preferences.keep_frames
    session.poll()
    assert pull.wanted_count == 0 and not pull.is_rendered(FIRST) and not pull.is_in_memory(FIRST)
    pull.switch()
    assert pull.is_on and pull.preferences.keep_frames


def test_cached_frames_play_alone_only_without_overlay_and_comparison(session, pull):
    wait_for_all_frames(session, 4)
    session.time.timeline.play(1)
    assert pull.plays_cached_frames
    view = session.pictures.commands
    for change in ({"overlay": "zones"}, {"compare": Compare.WIPE}, {"depth_of_field": False}):
        before = {name: getattr(session.facts.view, name) for name in change}
        view.change(**change)
        assert not pull.plays_cached_frames
        view.change(**before)
    assert pull.plays_cached_frames
    session.time.timeline.playback.stop()
    assert not pull.plays_cached_frames


def test_cleared_frames_ahead_are_rendered_again(session, pull):
    wait_for_all_frames(session, 4)
    pull.clear()
    assert not pull.store.known_keys()
    run_until(session, lambda: pull.frames_made == 8, "the same frames")


def test_resize_sets_limits_of_kept_frames_in_megabytes(session, pull):
    pull.resize(64, 128)
    assert (pull.preferences.memory_mb, pull.preferences.disk_mb) == (64, 128)
    assert pull.store.memory.limit_bytes <= 64_000_000 * 1.05
    pull.store.memory.resize(2 * pull.picture_bytes)
    session.poll()
    assert pull.wanted_count == 2


def test_frame_that_cannot_be_rendered_is_skipped_until_another_source(
    session, pull, tmp_path, monkeypatch
):
    work, failed_frames = frames_ahead.FrameFiller.work, []

    def work_or_fail(filler, job, after, seconds):
        if job.frame == FIRST + 1:
            failed_frames.append(job.frame)
            raise HeatlensError("damaged")
        return work(filler, job, after, seconds)

    monkeypatch.setattr(frames_ahead.FrameFiller, "work", work_or_fail)
    wait_for_all_frames(session, 3)
    run_until(session, lambda: not pull.has_work, "rest")
    assert failed_frames == [FIRST + 1] and pull.progress.runs == (
        FrameRange(FIRST, FIRST), FrameRange(FIRST + 2, LAST),
    )  # fmt: skip
    pull.restart()
    assert pull.has_work  # tried again with another source


def test_scale_of_cached_pictures_follows_size_of_the_viewport(session, pull):
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
    cached_screen = CachedScreen(
        pull, session.source, session.editing, session.pictures.view, pictures
    )
    pull.screen = cached_screen
    yield cached_screen
    cached_screen.forget_frames()


def test_cached_screen_shows_frame_at_playhead_as_rendered(session, pull, screen):
    assert screen.frame_at_playhead() is None  # none is rendered
    wait_for_all_frames(session, 4)
    session.time.timeline.go_to(FIRST + 1)
    shown = screen.frame_at_playhead()
    assert (shown.frame, shown.shot, shown.is_whole) == (FIRST + 1, session.editing.shot, True)
    assert screen.frame_at_playhead() is shown and screen.upload(shown) is shown
    cached_frame = pull.store.memory.get(pull.jobs.job_of(FIRST + 1).key)
    np.testing.assert_array_equal(download(shown.texture), cached_frame.pixels.astype(np.float32))
    assert screen.windows(shown) == session.source.feed.kept_windows(cached_frame)
    session.time.timeline.go_to(FIRST + 2)
    later = screen.upload(screen.frame_at_playhead())
    assert later is not shown and later.texture is shown.texture
    cached_frame = pull.store.memory.get(pull.jobs.job_of(FIRST + 2).key)
    np.testing.assert_array_equal(download(later.texture), cached_frame.pixels.astype(np.float32))
    session.pictures.commands.toggle_overlay("zones")
    assert screen.frame_at_playhead() is None
    plain = ShownPicture(later.texture, later.shot, 1, later.shot.defocus, 0.0)
    assert screen.windows(plain) is None and screen.upload(plain) is plain


def test_cached_screen_prepares_one_texture_per_frame_at_rest(session, pull, screen):
    wait_for_all_frames(session, 4)
    run_until(session, lambda: not screen.has_work, "all frames")
    view = session.facts.view
    textures = set()
    for frame in FRAMES:
        session.time.timeline.go_to(frame)
        run_loop_once(session)
        textures.add(
            screen.texture(screen.frame_at_playhead(), view.with_transmission(session.editing.lens))
        )
    assert len(textures) == 4  # one each, made beforehand
    session.pictures.commands.expose(2)
    assert screen.has_work
    screen.prepare()
    run_until(session, lambda: not screen.has_work, "all frames again")
    screen.forget_frames()
    assert screen.has_work


def test_cached_screen_prepares_smaller_mipmap_level_when_zoomed_out(session, screen, monkeypatch):
    monkeypatch.setattr(PictureView, "zoom", 0.25)
    wait_for_all_frames(session, 4)
    run_until(session, lambda: not screen.has_work, "all frames")
    view = session.facts.view.with_transmission(session.editing.lens)
    texture = screen.texture(screen.frame_at_playhead(), view)
    small, whole = (np.frombuffer(texture.read(level=level), np.uint8) for level in (1, 0))
    assert small.size == whole.size // 4 and small.mean() == pytest.approx(whole.mean(), rel=0.02)
