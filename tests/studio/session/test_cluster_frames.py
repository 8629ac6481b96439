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
from heatlens.deliver.farm import connection, frame_cluster, render_workers
from heatlens.deliver.farm.connection import identify_scheduler_safely
from heatlens.deliver.farm.export_place import ExportPlace, Where
from heatlens.deliver.farm.frame_worker import _render_frame
from heatlens.render.frame_renderer import FrameRenderer
from heatlens.render.gpu.textures import download
from heatlens.render.preview.speed import Speed
from heatlens.render.rendered_frames.frame_filler import FrameFiller
from heatlens.studio.board.session import Session
from heatlens.studio.settings.preferences import Preferences, PreferenceValues
from heatlens.studio.settings.start import Start
from support.dask_cluster import children_of, dask_cluster, wait_for
from support.evening import run_loop_once, run_until, run_until_settled, wait_for_all_frames
from support.sequences import FIRST, sequence_files
from support.session_files import HEIGHT, QUICK, WIDTH, room_file, scene_shot
from support.watched_calls import watch_calls

LAST = FIRST + 5
FRAMES = frozenset(range(FIRST, LAST + 1))


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    with dask_cluster(tmp_path_factory.mktemp("cluster"), workers=1) as found:
        yield found


@pytest.fixture(scope="module")
def lying_cluster(tmp_path_factory):
    """Start a cluster whose one worker sends false answers, for the tests of the file."""
    with dask_cluster(tmp_path_factory.mktemp("liars"), workers=0) as found:
        yield found


@pytest.fixture
def local_begin(tmp_path):
    """A cluster of its own, whose parts are killed."""
    with dask_cluster(tmp_path / "cluster", workers=1) as found:
        yield found


@pytest.fixture
def begin(ctx, renderer):
    """Return a function that opens a source at a place, and close what was opened."""
    made = []

    def begun(source, address="", is_agreed=True, **more):
        place = ExportPlace(Where.CLUSTER, scheduler=address, **more) if address else ExportPlace()
        cluster = find_agreed_scheduler(address) if is_agreed else None
        preferences = Preferences(PreferenceValues(export_place=place, cluster=cluster))
        made.append(Session(renderer, Start(str(source), defocus=QUICK), preferences=preferences))
        made[-1].begin()
        run_until_settled(made[-1])
        made[-1].pictures.view.viewport = Viewport((0.0, 0.0), (float(WIDTH), float(HEIGHT)))
        return made[-1]

    yield begun
    for session in made:
        session.close()


def find_agreed_scheduler(address):
    """Return the scheduler that answers there, as if the user had agreed to it."""
    try:
        return identify_scheduler_safely(address)
    except InputError:
        return None


def frames_of(session, count=6):
    """Run the session until `count` frames are rendered; return their pixels by frame key."""
    run_loop_once(session)
    wait_for_all_frames(session, count)
    pull = session.time.frames_ahead
    return {key: pull.store.memory.get(key).pixels for key in pull.progress.keys}


def wait_for_worker(session):
    """Run the session until a worker of the cluster is there."""
    run_until(session, lambda: session.time.frames_ahead.cluster.renders_ahead, "a worker")


def test_cluster_frames_equal_frames_rendered_here(begin, cluster, tmp_path):
    pattern = sequence_files(tmp_path, FIRST, LAST)
    local_frames = frames_of(begin(pattern))
    session = begin(pattern, cluster.address)
    session.time.frames_ahead._rest_from_s = np.inf  # nothing is rendered before a worker is there
    wait_for_worker(session)
    session.time.frames_ahead._rest_from_s = 0.0
    cluster_frames = frames_of(session)
    assert session.time.frames_ahead._filler is None
    assert local_frames.keys() == cluster_frames.keys() and len(local_frames) == len(FRAMES)
    for key, pixels in local_frames.items():
        np.testing.assert_array_equal(pixels, cluster_frames[key])


def test_cluster_renders_same_frames_of_moving_scene(begin, cluster, tmp_path):
    shot = scene_shot(tmp_path / "s.heatlens.json", 48, 27, in_out=FrameRange(2, 5))
    local_frames, session = frames_of(begin(shot), 4), begin(shot, cluster.address)
    session.time.frames_ahead.clear()
    session.time.frames_ahead._rest_from_s = np.inf
    wait_for_worker(session)
    session.time.frames_ahead._rest_from_s = 0.0
    cluster_frames = frames_of(session, 4)
    assert local_frames.keys() == cluster_frames.keys()
    assert all(np.array_equal(pixels, cluster_frames[key]) for key, pixels in local_frames.items())


def test_changed_lens_recalls_running_frames_and_stores_none_of_them(
    begin, cluster, tmp_path, monkeypatch
):
    session = begin(sequence_files(tmp_path, FIRST, LAST), cluster.address)
    pull, stored = session.time.frames_ahead, []
    monkeypatch.setattr(pull.store, "put", lambda key, _: stored.append((key, pull.progress.keys)))
    wait_for_worker(session)
    sent, request_frames = [], pull.cluster._cluster.frames.request_frames

    def record_and_request(wishes):
        sent.append([*wishes])
        return request_frames(sent[-1])

    monkeypatch.setattr(pull.cluster._cluster.frames, "request_frames", record_and_request)
    for step in range(12):
        session.lens.commands.step_f_stop(1 if step % 2 else -1)
        session.lens.commands.focus(1.5 + step / 10)
        pull.note_input()
        run_loop_once(session)
        assert not sent or not sent[-1]  # the hand moves: all is recalled, and nothing asked
        pull._rest_from_s = 0.0
        run_loop_once(session)
        run_until(session, lambda: sent and sent[-1], "the question")
        assert {wish.key for wish in sent[-1]} <= pull.progress.keys
    run_until(
        session,
        lambda: len({key for key, _ in stored} & pull.progress.keys) == len(FRAMES),
        "frames",
    )
    assert all(key in keys for key, keys in stored)


def test_worker_stops_recalled_frame_between_two_steps(begin, renderer, tmp_path):
    session = begin(sequence_files(tmp_path, FIRST, LAST))
    frames_of(session)
    states = {"frame": SimpleNamespace(state="executing")}
    worker = SimpleNamespace(
        get_current_task=lambda: "frame", state=SimpleNamespace(tasks=states), address="w"
    )
    filler, slices = FrameFiller(renderer.make_sibling()), []
    work = filler.work

    def worked(job, following, _):
        """Make the shortest slice; the scheduler recalls the frame during the third."""
        slices.append(work(job, following, 0.0))
        if len(slices) == 3:
            states["frame"].state = "cancelled"

    filler.work = worked
    job = session.time.frames_ahead.jobs.job_of(FIRST)
    assert _render_frame(job, filler, worker) is None
    assert len(slices) == 3 and slices == [None] * 3 and filler._steps is None


@pytest.mark.parametrize("lost", ["worker 0", "scheduler"])
def test_lost_cluster_leaves_missing_frames_to_this_machine(begin, local_begin, tmp_path, lost):
    pattern = sequence_files(tmp_path, FIRST, LAST)
    local_frames = frames_of(begin(pattern))
    session = begin(pattern, local_begin.address)
    wait_for_worker(session)
    local_begin.kill(lost)
    run_until(session, lambda: not session.time.frames_ahead.cluster.renders_ahead, "the loss")
    expected_start = "No worker is at" if lost == "worker 0" else "The scheduler at"
    run_until(session, lambda: session.messages.text.startswith(expected_start), "the sentence")
    assert session.messages.text.endswith("Frames are rendered on this machine.")
    session.time.frames_ahead.clear()
    cluster_frames = frames_of(session)
    assert all(np.array_equal(pixels, cluster_frames[key]) for key, pixels in local_frames.items())


@pytest.mark.parametrize("moment", range(3))
def test_killed_worker_loses_no_frame(begin, local_begin, tmp_path, moment):
    pattern = sequence_files(tmp_path, FIRST, LAST)
    local_frames = frames_of(begin(pattern))
    session = begin(pattern, local_begin.address)
    run_until(
        session,
        lambda: len(session.time.frames_ahead.progress.rendered_frames) >= moment,
        "some frames",
    )
    local_begin.kill("worker 0")
    cluster_frames = frames_of(session)
    assert local_frames.keys() == cluster_frames.keys()
    assert all(np.array_equal(pixels, cluster_frames[key]) for key, pixels in local_frames.items())


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "nonsense"])
def test_missing_scheduler_is_reported_once_and_frames_are_rendered_here(
    begin, tmp_path, monkeypatch, address
):
    monkeypatch.setattr(connection, "PATIENCE_S", 1)
    session = begin(sequence_files(tmp_path, FIRST, LAST), address)
    frames_of(session)
    run_until(session, lambda: "No Dask scheduler" in session.messages.text, "the sentence")
    session.messages.clear()
    run_loop_once(session)
    assert session.messages.text == ""


def test_frame_whose_plate_no_worker_can_read_is_rendered_here(
    begin, cluster, tmp_path, monkeypatch
):
    pattern = sequence_files(tmp_path, FIRST, LAST)
    real_sent = frame_cluster.job_to_send

    def elsewhere(job):
        """Return the job as it is on a machine where one plate is missing."""
        sent_job = real_sent(job)
        if job.frame != FIRST + 2:
            return sent_job
        files = tuple(
            replace(file, path=tmp_path / "no" / file.path.name) for file in sent_job.plate.files
        )
        return replace(sent_job, plate=replace(sent_job.plate, files=files))

    monkeypatch.setattr(frame_cluster, "job_to_send", elsewhere)
    session = begin(pattern, cluster.address)
    wait_for_worker(session)
    messages = []
    monkeypatch.setattr(session.time.frames_ahead.cluster, "_notify", messages.append)
    session.time.frames_ahead.clear()
    frames_of(session)
    assert len(messages) == 1 and "worker tcp://" in messages[0] and f"{FIRST + 2}" in messages[0]


def test_workers_with_another_driver_have_frame_keys_of_their_own(
    begin, local_begin, tmp_path, monkeypatch
):
    """All frames of a shot come from one driver; frames rendered here are not replaced."""
    pattern = sequence_files(tmp_path, FIRST, LAST)
    local_frames = frames_of(begin(pattern))
    session = begin(pattern)
    monkeypatch.setattr(
        type(session.time.frames_ahead.jobs), "driver", ("another driver", "4.6", "sweep")
    )
    place = ExportPlace(Where.CLUSTER, scheduler=local_begin.address)
    session.preferences.change(
        export_place=place, cluster=find_agreed_scheduler(local_begin.address)
    )
    wait_for_worker(session)
    run_until(session, lambda: session.time.frames_ahead.jobs.program, "the program of the worker")
    cluster_frames = frames_of(session)
    assert not local_frames.keys() & cluster_frames.keys()
    local_begin.kill("worker 0")
    run_until(session, lambda: not session.time.frames_ahead.jobs.program, "the loss")
    assert frames_of(session).keys() == local_frames.keys()


def test_worker_that_dies_with_its_answer_is_not_waited_for(
    begin, local_begin, tmp_path, monkeypatch
):
    """The scheduler would wait for it for ever; the frames are rendered here."""
    learn = render_workers.RenderWorkers._learn_programs

    def worker_dies_first(service):
        if "worker 0" in local_begin._running and any(
            program_state.status == "finished" for program_state in service._programs.values()
        ):
            local_begin.kill("worker 0")
            wait_for(lambda: "Lost all workers" in local_begin.said("scheduler"))
        learn(service)

    monkeypatch.setattr(connection, "PATIENCE_S", 1)
    monkeypatch.setattr(render_workers.RenderWorkers, "_learn_programs", worker_dies_first)
    session = begin(sequence_files(tmp_path, FIRST, LAST), local_begin.address)
    run_until(
        session, lambda: "No worker" in session.time.frames_ahead.cluster.status_text, "the loss"
    )
    frames_of(session)


@pytest.fixture
def uploaded(monkeypatch):
    """Count the whole pictures that came from a worker; the first answers are small ones."""
    monkeypatch.setattr(Speed, "budget_s", 1e-9)
    return watch_calls(monkeypatch, FrameRenderer, "upload_steps")


def write_large_still(folder):
    return room_file(folder / "room.exr", 480, 320)


def write_large_sequence(folder):
    for frame in (FIRST, FIRST + 1):
        room_file(folder / f"room.{frame}.exr", 480, 320)
    return folder / "room.####.exr"


def begin_with_pictures_from_workers(begin, source, cluster):
    """Return a session whose whole pictures come from workers, and none of its frames."""
    session = begin(source, cluster.address, ahead=False, at_rest=True)
    run_until(session, lambda: session.time.frames_ahead.cluster.has_workers, "a worker")
    return session


def download_whole_picture(session, focus_m):
    """Focus at `focus_m`, wait for the whole picture and return its pixels."""
    session.lens.commands.focus(focus_m)
    session.editing.settle()
    run_loop_once(session)
    run_until_settled(session)
    assert session.pictures.live.output.is_whole
    assert session.pictures.live.output.shot == session.facts.shot
    return download(session.pictures.live.output.texture)


@pytest.mark.parametrize("kind", ["still", "sequence", "scene"])
def test_whole_picture_from_worker_equals_that_of_this_machine(
    begin, cluster, tmp_path, uploaded, kind
):
    source_of = {
        "still": lambda name: write_large_still(tmp_path),
        "sequence": lambda name: write_large_sequence(tmp_path),
        "scene": lambda name: scene_shot(
            tmp_path / f"{name}.heatlens.json", 480, 320, in_out=FrameRange(1, 2)
        ),
    }[kind]
    first = begin(source_of("here"))
    local_frames = [download_whole_picture(first, focus_m) for focus_m in (1.3, 2.7)]
    assert not uploaded
    session = begin_with_pictures_from_workers(begin, source_of("there"), cluster)
    for number, focus_m in enumerate((1.3, 2.7)):
        np.testing.assert_array_equal(
            local_frames[number], download_whole_picture(session, focus_m)
        )
        assert len(uploaded) > number
    assert not session.time.frames_ahead.cluster.renders_ahead  # its frames are rendered here


def stop_worker(cluster):
    """Stop a worker, so that its pictures do not come; return its process."""
    (worker,) = children_of(cluster.process("worker 0"))
    os.kill(worker, signal.SIGSTOP)
    return worker


def test_focus_change_recalls_whole_picture_from_worker(begin, cluster, tmp_path, uploaded):
    session = begin_with_pictures_from_workers(begin, write_large_still(tmp_path), cluster)
    run_until_settled(session)
    worker, cluster_frames = stop_worker(cluster), session.time.frames_ahead.cluster._cluster
    live, before = session.pictures.live, len(uploaded)
    for step in range(4):
        session.lens.commands.focus(1.3 + step)
        session.editing.settle()
        run_loop_once(session)
        assert (
            not cluster_frames.frames.open_requests() and not live.remote.is_waiting
        )  # the hand moves
        assert live.output.shot == session.facts.shot and not live.output.is_whole
        run_until(session, lambda: live.remote.is_waiting, "rest")
        assert [it.is_kept for it in cluster_frames.frames.open_requests()] == [False]
        assert not live.has_work()  # the loop may sleep
    os.kill(worker, signal.SIGCONT)
    run_until_settled(session)
    assert live.output.is_whole and len(uploaded) == before + 1


def test_killed_worker_leaves_whole_picture_to_this_machine(begin, local_begin, tmp_path, uploaded):
    local_frames = download_whole_picture(begin(write_large_still(tmp_path)), 1.3)
    session = begin_with_pictures_from_workers(begin, tmp_path / "room.exr", local_begin)
    run_until_settled(session)
    stop_worker(local_begin)
    before = len(uploaded)
    session.lens.commands.focus(1.3)
    run_until(session, lambda: session.pictures.live.remote.is_waiting, "rest")
    local_begin.kill("worker 0")
    np.testing.assert_array_equal(local_frames, download_whole_picture(session, 1.3))
    assert len(uploaded) == before


def test_session_loop_never_waits_for_stopped_scheduler(begin, cluster, tmp_path):
    """The scheduler stands still; a turn that asked it would never end."""
    session = begin(sequence_files(tmp_path, FIRST, LAST), cluster.address, at_rest=True)
    wait_for_worker(session)
    os.kill(cluster.process("scheduler"), signal.SIGSTOP)
    try:
        for step in range(8):
            session.lens.commands.focus(1.3 + step / 10)
            session.editing.settle()
            session.time.frames_ahead._rest_from_s = 0.0
            run_loop_once(session)
        session.preferences.change(export_place=ExportPlace())
        frames_of(session)
    finally:
        os.kill(cluster.process("scheduler"), signal.SIGCONT)


def test_scheduler_is_used_only_after_user_agrees_to_it(begin, local_begin, tmp_path):
    """A new scheduler, another one at the same address and one in another network all ask first."""
    session = begin(sequence_files(tmp_path, FIRST, LAST), local_begin.address, is_agreed=False)
    cluster = session.time.frames_ahead.cluster
    run_until(session, lambda: cluster.awaits_consent, "the question")
    assert "is new to this window: if it is yours, choose Use this scheduler" in cluster.status_text
    assert not cluster.has_workers
    cluster.agree()
    run_until(session, lambda: cluster.has_workers and not cluster.awaits_consent, "a worker")
    known = session.preferences.values.cluster
    assert known == identify_scheduler_safely(local_begin.address)
    local_begin.kill("worker 0")
    local_begin.kill("scheduler")
    local_begin.schedule()
    local_begin.work("worker 0")
    cluster.close()
    run_until(session, lambda: cluster.awaits_consent, "the question")
    assert "another than before" in cluster.status_text and not cluster.has_workers
    elsewhere = replace(identify_scheduler_safely(local_begin.address), own_host="192.0.2.1")
    session.preferences.change(cluster=elsewhere)
    cluster.close()
    run_until(session, lambda: "192.0.2.1" in cluster.status_text, "the question")
    assert cluster.awaits_consent and not cluster.has_workers
    cluster.agree()
    run_until(session, lambda: cluster.has_workers, "a worker")


@pytest.mark.parametrize("how", ["runs", "fails and runs", "a text", "no answer", "deep"])
def test_answers_of_lying_worker_run_no_code_in_the_window(begin, lying_cluster, tmp_path, how):
    lying_cluster.lie("liar", how, tmp_path / "ran")
    session = begin(sequence_files(tmp_path, FIRST, LAST), lying_cluster.address)
    run_until(
        session,
        lambda: "same version" in session.time.frames_ahead.cluster.status_text,
        "the sentence",
    )
    frames_of(session)
    assert not (tmp_path / f"ran.{os.getpid()}").exists()
