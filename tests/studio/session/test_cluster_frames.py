"""Frames ahead that the workers of a cluster render: the same bits, recalled, and lost workers."""

import os
import signal
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.view.view_geometry import Viewport
from heatlens.deliver.farm import connection, frame_cluster
from heatlens.deliver.farm.connection import met
from heatlens.deliver.farm.frame_worker import _rendered
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.textures import download
from heatlens.render.rendered_frames.frame_filler import FrameFiller
from heatlens.studio.session.session import Session
from heatlens.studio.session.settings.export_place import ExportPlace, Where
from heatlens.studio.session.settings.preferences import Preferences, Remembered
from heatlens.studio.session.shot.start import Start
from heatlens.studio.session.speed import Speed
from support.dask_cluster import children_of, dask_cluster, wait_for
from support.evening import settled, turn, until
from support.sequences import FIRST, sequence_files
from support.session_files import HEIGHT, QUICK, WIDTH, room_file, scene_shot

LAST = FIRST + 5
FRAMES = frozenset(range(FIRST, LAST + 1))


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    with dask_cluster(tmp_path_factory.mktemp("cluster"), workers=1) as found:
        yield found


@pytest.fixture
def own(tmp_path):
    """A cluster of its own, whose parts are killed."""
    with dask_cluster(tmp_path / "cluster", workers=1) as found:
        yield found


@pytest.fixture
def begin(ctx, renderer):
    """Return a function that opens a source at a place, and close what was opened."""
    made = []

    def begun(source, address="", is_agreed=True, **more):
        place = ExportPlace(Where.CLUSTER, scheduler=address, **more) if address else ExportPlace()
        cluster = agreed_to(address) if is_agreed else None
        preferences = Preferences(Remembered(export_place=place, cluster=cluster))
        made.append(Session(renderer, Start(str(source), defocus=QUICK), preferences=preferences))
        made[-1].begin()
        settled(made[-1])
        made[-1].pictures.view.viewport = Viewport((0.0, 0.0), (float(WIDTH), float(HEIGHT)))
        return made[-1]

    yield begun
    for session in made:
        session.close()


def agreed_to(address):
    """Return the scheduler that answers there, as if the user had agreed to it."""
    try:
        return met(address)
    except InputError:
        return None


def filled(session, count=6):
    turn(session)
    until(session, lambda: len(session.time.pull.progress.rendered) == count, f"{count} frames")
    session.time.pull.store.wait()
    turn(session)
    pull = session.time.pull
    return {key: pull.store.memory.get(key).pixels for key in pull.progress.keys}


def at_work(session):
    until(session, lambda: session.time.pull.cluster.is_at_work, "a worker")


def test_frames_of_a_cluster_are_those_rendered_here(begin, cluster, tmp_path):
    pattern = sequence_files(tmp_path, FIRST, LAST)
    here = filled(begin(pattern))
    session = begin(pattern, cluster.address)
    session.time.pull._rests_at = np.inf  # nothing is rendered before a worker is there
    at_work(session)
    session.time.pull._rests_at = 0.0
    there = filled(session)
    assert session.time.pull._filler is None
    assert here.keys() == there.keys() and len(here) == len(FRAMES)
    for key, pixels in here.items():
        np.testing.assert_array_equal(pixels, there[key])


def test_frames_of_a_moving_scene_come_too(begin, cluster, tmp_path):
    shot = scene_shot(tmp_path / "s.heatlens.json", 48, 27, in_out=FrameRange(2, 5))
    here, session = filled(begin(shot), 4), begin(shot, cluster.address)
    session.time.pull.clear()
    session.time.pull._rests_at = np.inf
    at_work(session)
    session.time.pull._rests_at = 0.0
    there = filled(session, 4)
    assert here.keys() == there.keys()
    assert all(np.array_equal(pixels, there[key]) for key, pixels in here.items())


def test_changed_keys_recall_what_is_under_way_and_keep_no_frame_of_it(
    begin, cluster, tmp_path, monkeypatch
):
    session = begin(sequence_files(tmp_path, FIRST, LAST), cluster.address)
    pull, stored, sent = session.time.pull, [], []
    monkeypatch.setattr(pull.store, "put", lambda key, _: stored.append((key, pull.progress.keys)))
    at_work(session)
    ask = pull.cluster._cluster.ask
    monkeypatch.setattr(
        pull.cluster._cluster, "ask", lambda wishes: ask(sent.append([*wishes]) or sent[-1])
    )
    for step in range(12):
        session.lens.commands.step_f_stop(1 if step % 2 else -1)
        session.lens.commands.focus(1.5 + step / 10)
        pull.touched()
        turn(session)
        assert not sent or not sent[-1]  # the hand moves: all is recalled, and nothing asked
        pull._rests_at = 0.0
        turn(session)
        until(session, lambda: sent and sent[-1], "the question")
        assert {wish.key for wish in sent[-1]} <= pull.progress.keys
    until(
        session,
        lambda: len({key for key, _ in stored} & pull.progress.keys) == len(FRAMES),
        "frames",
    )
    assert all(key in keys for key, keys in stored)


def test_a_running_frame_that_is_recalled_is_given_up_between_two_steps(begin, renderer, tmp_path):
    session = begin(sequence_files(tmp_path, FIRST, LAST))
    filled(session)
    states = {"frame": SimpleNamespace(state="executing")}
    worker = SimpleNamespace(
        get_current_task=lambda: "frame", state=SimpleNamespace(tasks=states), address="w"
    )
    filler, slices = FrameFiller(renderer.beside()), []
    work = filler.work

    def worked(job, following, _):
        """Make the shortest slice; the scheduler recalls the frame during the third."""
        slices.append(work(job, following, 0.0))
        if len(slices) == 3:
            states["frame"].state = "cancelled"

    filler.work = worked
    job = session.time.pull.jobs.of(FIRST)
    assert _rendered(job, filler, worker) is None
    assert len(slices) == 3 and slices == [None] * 3 and filler._steps is None


@pytest.mark.parametrize("lost", ["worker 0", "scheduler"])
def test_the_window_renders_what_is_missing_once_the_cluster_has_gone(begin, own, tmp_path, lost):
    pattern = sequence_files(tmp_path, FIRST, LAST)
    here = filled(begin(pattern))
    session = begin(pattern, own.address)
    at_work(session)
    own.kill(lost)
    until(session, lambda: not session.time.pull.cluster.is_at_work, "the loss")
    said = "No worker is at" if lost == "worker 0" else "The scheduler at"
    until(session, lambda: session.messages.text.startswith(said), "the sentence")
    assert session.messages.text.endswith("Frames are rendered on this machine.")
    session.time.pull.clear()
    there = filled(session)
    assert all(np.array_equal(pixels, there[key]) for key, pixels in here.items())


@pytest.mark.parametrize("moment", range(3))
def test_a_worker_killed_in_the_middle_loses_no_frame(begin, own, tmp_path, moment):
    pattern = sequence_files(tmp_path, FIRST, LAST)
    here = filled(begin(pattern))
    session = begin(pattern, own.address)
    until(session, lambda: len(session.time.pull.progress.rendered) >= moment, "some frames")
    own.kill("worker 0")
    there = filled(session)
    assert here.keys() == there.keys()
    assert all(np.array_equal(pixels, there[key]) for key, pixels in here.items())


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "nonsense"])
def test_without_a_scheduler_the_window_says_so_once_and_renders(
    begin, tmp_path, monkeypatch, address
):
    monkeypatch.setattr(connection, "PATIENCE_S", 1)
    session = begin(sequence_files(tmp_path, FIRST, LAST), address)
    filled(session)
    until(session, lambda: "No Dask scheduler" in session.messages.text, "the sentence")
    session.messages.clear()
    turn(session)
    assert session.messages.text == ""


def test_a_plate_that_no_worker_can_read_is_rendered_here(begin, cluster, tmp_path, monkeypatch):
    pattern = sequence_files(tmp_path, FIRST, LAST)
    real = frame_cluster.sent

    def elsewhere(job):
        """Return the job as it is on a machine where one plate is missing."""
        sent = real(job)
        if job.frame != FIRST + 2:
            return sent
        files = tuple(replace(it, path=tmp_path / "no" / it.path.name) for it in sent.plate.files)
        return replace(sent, plate=replace(sent.plate, files=files))

    monkeypatch.setattr(frame_cluster, "sent", elsewhere)
    session = begin(pattern, cluster.address)
    at_work(session)
    said = []
    monkeypatch.setattr(session.time.pull.cluster, "_say", said.append)
    session.time.pull.clear()
    filled(session)
    assert len(said) == 1 and "worker tcp://" in said[0] and f"{FIRST + 2}" in said[0]


def test_workers_that_draw_otherwise_have_keys_of_their_own(begin, own, tmp_path, monkeypatch):
    """All frames of a shot come from one driver; what was rendered here is not replaced."""
    pattern = sequence_files(tmp_path, FIRST, LAST)
    here = filled(begin(pattern))
    session = begin(pattern)
    monkeypatch.setattr(type(session.time.pull.jobs), "driver", ("another driver", "4.6", "sweep"))
    place = ExportPlace(Where.CLUSTER, scheduler=own.address)
    session.preferences.change(export_place=place, cluster=agreed_to(own.address))
    at_work(session)
    until(session, lambda: session.time.pull.jobs.program, "the program of the worker")
    there = filled(session)
    assert not here.keys() & there.keys()
    own.kill("worker 0")
    until(session, lambda: not session.time.pull.jobs.program, "the loss")
    assert filled(session).keys() == here.keys()


def test_a_worker_that_dies_with_its_answer_is_not_awaited(begin, own, tmp_path, monkeypatch):
    """The scheduler would wait for it for ever; the frames are rendered here."""
    choose = frame_cluster._Service._choose

    def worker_dies_first(service):
        if "worker 0" in own._running and any(
            told.status == "finished" for told in service._programs.values()
        ):
            own.kill("worker 0")
            wait_for(lambda: "Lost all workers" in own.said("scheduler"))
        choose(service)

    monkeypatch.setattr(connection, "PATIENCE_S", 1)
    monkeypatch.setattr(frame_cluster._Service, "_choose", worker_dies_first)
    session = begin(sequence_files(tmp_path, FIRST, LAST), own.address)
    until(session, lambda: "No worker" in session.time.pull.cluster.told, "the loss")
    filled(session)


@pytest.fixture
def uploaded(monkeypatch):
    """Count the whole pictures that came from a worker; the first answers are small ones."""
    found, upload = [], FrameRenderer.uploading
    monkeypatch.setattr(
        FrameRenderer, "uploading", lambda self, *of: found.append(of) or upload(self, *of)
    )
    monkeypatch.setattr(Speed, "budget_s", 1e-9)
    return found


def large(folder):
    return room_file(folder / "room.exr", 480, 320)


def large_sequence(folder):
    for frame in (FIRST, FIRST + 1):
        room_file(folder / f"room.{frame}.exr", 480, 320)
    return folder / "room.####.exr"


def resting(begin, source, cluster):
    """Return a session whose whole pictures come from workers, and none of its frames."""
    session = begin(source, cluster.address, ahead=False, at_rest=True)
    until(session, lambda: session.time.pull.cluster.has_workers, "a worker")
    return session


def whole(session, focus_m):
    session.lens.commands.focus(focus_m)
    session.editing.settle()
    turn(session)
    settled(session)
    assert session.pictures.live.shown.is_whole
    assert session.pictures.live.shown.shot == session.facts.shot
    return download(session.pictures.live.shown.texture)


@pytest.mark.parametrize("kind", ["still", "sequence", "scene"])
def test_a_whole_picture_of_a_worker_is_that_of_this_machine(
    begin, cluster, tmp_path, uploaded, kind
):
    source_of = {
        "still": lambda name: large(tmp_path),
        "sequence": lambda name: large_sequence(tmp_path),
        "scene": lambda name: scene_shot(
            tmp_path / f"{name}.heatlens.json", 480, 320, in_out=FrameRange(1, 2)
        ),
    }[kind]
    first = begin(source_of("here"))
    here = [whole(first, focus_m) for focus_m in (1.3, 2.7)]
    assert not uploaded
    session = resting(begin, source_of("there"), cluster)
    for number, focus_m in enumerate((1.3, 2.7)):
        np.testing.assert_array_equal(here[number], whole(session, focus_m))
        assert len(uploaded) > number
    assert not session.time.pull.cluster.is_at_work  # its frames are rendered here


def stopped(cluster):
    """Stop a worker, so that its pictures do not come; return its process."""
    (worker,) = children_of(cluster.process("worker 0"))
    os.kill(worker, signal.SIGSTOP)
    return worker


def test_a_hand_that_moves_recalls_the_whole_picture(begin, cluster, tmp_path, uploaded):
    session = resting(begin, large(tmp_path), cluster)
    settled(session)
    worker, there = stopped(cluster), session.time.pull.cluster._cluster
    live, before = session.pictures.live, len(uploaded)
    for step in range(4):
        session.lens.commands.focus(1.3 + step)
        session.editing.settle()
        turn(session)
        assert not there.wanted() and not live.elsewhere.is_waiting  # the hand moves
        assert live.shown.shot == session.facts.shot and not live.shown.is_whole
        until(session, lambda: live.elsewhere.is_waiting, "rest")
        assert [it.is_kept for it in there.wanted()] == [False]
        assert not live.wants_work()  # the loop may sleep
    os.kill(worker, signal.SIGCONT)
    settled(session)
    assert live.shown.is_whole and len(uploaded) == before + 1


def test_a_worker_that_dies_leaves_the_whole_picture_to_this_machine(
    begin, own, tmp_path, uploaded
):
    here = whole(begin(large(tmp_path)), 1.3)
    session = resting(begin, tmp_path / "room.exr", own)
    settled(session)
    stopped(own)
    before = len(uploaded)
    session.lens.commands.focus(1.3)
    until(session, lambda: session.pictures.live.elsewhere.is_waiting, "rest")
    own.kill("worker 0")
    np.testing.assert_array_equal(here, whole(session, 1.3))
    assert len(uploaded) == before


def test_no_turn_of_the_loop_waits_for_the_network(begin, cluster, tmp_path):
    """The scheduler stands still; a turn that asked it would never end."""
    session = begin(sequence_files(tmp_path, FIRST, LAST), cluster.address, at_rest=True)
    at_work(session)
    os.kill(cluster.process("scheduler"), signal.SIGSTOP)
    try:
        for step in range(8):
            session.lens.commands.focus(1.3 + step / 10)
            session.editing.settle()
            session.time.pull._rests_at = 0.0
            turn(session)
        session.preferences.change(export_place=ExportPlace())
        filled(session)
    finally:
        os.kill(cluster.process("scheduler"), signal.SIGCONT)


def test_a_scheduler_is_used_once_the_user_agrees_to_it(begin, own, tmp_path):
    """Not one that is new, nor another at the same address, nor the same in another network."""
    session = begin(sequence_files(tmp_path, FIRST, LAST), own.address, is_agreed=False)
    cluster = session.time.pull.cluster
    until(session, lambda: cluster.asks, "the question")
    assert "is new to this window: agree to it" in cluster.told and not cluster.has_workers
    cluster.agree()
    until(session, lambda: cluster.has_workers and not cluster.asks, "a worker")
    known = session.preferences.now.cluster
    assert known == met(own.address)
    own.kill("worker 0")
    own.kill("scheduler")
    own.schedule()
    own.work("worker 0")
    cluster.close()
    until(session, lambda: cluster.asks, "the question")
    assert "another than before" in cluster.told and not cluster.has_workers
    elsewhere = replace(met(own.address), own_host="192.0.2.1")
    session.preferences.change(cluster=elsewhere)
    cluster.close()
    until(session, lambda: "192.0.2.1" in cluster.told, "the question")
    assert cluster.asks and not cluster.has_workers
    cluster.agree()
    until(session, lambda: cluster.has_workers, "a worker")


@pytest.mark.parametrize("how", ["runs", "fails and runs", "a text", "no answer", "deep"])
def test_no_answer_of_a_worker_runs_code_in_the_window(begin, own, tmp_path, how):
    own.kill("worker 0")
    own.lie("liar", how, RAN=str(tmp_path / "ran"))
    session = begin(sequence_files(tmp_path, FIRST, LAST), own.address)
    until(session, lambda: "same version" in session.time.pull.cluster.told, "the sentence")
    filled(session)
    assert not (tmp_path / f"ran.{os.getpid()}").exists()
