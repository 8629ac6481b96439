"""Exports of the window on a cluster: closing it leaves them, opening the shot follows them."""

import os
import signal

import pytest

from heatlens.deliver.farm.connection import connected, identify_scheduler_safely
from heatlens.deliver.farm.export_place import ExportPlace, Where
from heatlens.studio.settings.export_settings import ExportSettings
from heatlens.studio.settings.preferences import Preferences
from support.dask_cluster import children_of, dask_cluster, wait_for
from support.evening import begin_session, run_until, run_until_settled, write_plates
from support.exports import files_in

COUNT = 24


@pytest.fixture
def cluster(tmp_path):
    with dask_cluster(tmp_path / "cluster", workers=1) as found:
        wait_for(lambda: "works for" in found.said("worker 0"))
        yield found


@pytest.fixture
def plates(tmp_path):
    return write_plates(tmp_path)


def begin_stalled_export(tmp_path, plates, cluster, is_agreed=True):
    """Begin an export on the cluster; return its session and the process of the stopped worker."""
    session = begin_session(tmp_path / "preferences", plates)
    run_until_settled(session)
    exports = session.files.exports
    exports.propose()
    session.preferences.change(
        cluster=identify_scheduler_safely(cluster.address) if is_agreed else None
    )
    place = ExportPlace(Where.CLUSTER, scheduler=cluster.address)
    exports.settings = ExportSettings(str(tmp_path / "out"), "walls", place=place)
    (worker,) = children_of(cluster.process("worker 0"))
    os.kill(worker, signal.SIGSTOP)
    exports.export()
    with connected(cluster.address) as client:
        wait_for(client.list_datasets)
    return session, worker


def frames_of(folder):
    return [name for name in files_in(folder) if name.endswith(".exr")]


@pytest.mark.parametrize("made", ["none", "all"])
def test_reopened_shot_follows_the_export_left_to_the_cluster(tmp_path, plates, cluster, made):
    session, worker = begin_stalled_export(tmp_path, plates, cluster)
    state, out = session.files.exports.run.state, tmp_path / "out"
    session.close()
    assert state.code in (129, -signal.SIGKILL)  # of a machine too busy to end it in time
    assert state.last_sentence.startswith("Left to the cluster")
    assert set(files_in(out)) == {"walls.job.heatlens.json"}  # which the workers read
    if made == "all":
        os.kill(worker, signal.SIGCONT)
        wait_for(lambda: len(frames_of(out)) == COUNT)
    session = begin_session(tmp_path / "preferences", plates)
    run = session.files.exports.run
    run_until(session, lambda: run.is_busy, "the export")
    if made == "none":
        wait_for(lambda: "has under way" in run.state.last_sentence)  # and counted what is finished
        os.kill(worker, signal.SIGCONT)
    run_until(session, lambda: not run.is_busy, "its end")
    assert run.state.code == 0 and run.state.done_frames == COUNT, run.state.last_sentence
    frame_counts = sum(run.state.frames_by_worker.values()), run.state.earlier_frames
    assert frame_counts == ((0, COUNT) if made == "all" else (COUNT, 0))
    assert len(files_in(out)) == COUNT
    run_until_settled(session)
    session.files.documents.write_preferences()
    session.close()
    assert not Preferences.load(tmp_path / "preferences").values.left_exports
    with connected(cluster.address) as client:
        assert client.list_datasets() == ()


def test_canceled_export_is_not_left_to_the_cluster(tmp_path, plates, cluster):
    session, _ = begin_stalled_export(tmp_path, plates, cluster)
    run = session.files.exports.run
    assert run.can_be_left
    run.cancel()
    assert not run.can_be_left
    run_until(session, lambda: not run.is_busy, "its end")
    session.close()
    assert run.state.is_stopped and files_in(tmp_path / "out") == {}
    assert not Preferences.load(tmp_path / "preferences").values.left_exports
    with connected(cluster.address) as client:
        assert client.list_datasets() == ()


def test_opening_another_shot_does_not_follow_the_left_export(tmp_path, plates, cluster):
    session, _ = begin_stalled_export(tmp_path, plates, cluster)
    session.close()
    (tmp_path / "other").mkdir()
    session = begin_session(tmp_path / "preferences", write_plates(tmp_path / "other"))
    run_until_settled(session)
    assert not session.files.exports.run.is_busy
    session.close()
    assert len(Preferences.load(tmp_path / "preferences").values.left_exports) == 1


def test_left_export_reports_a_scheduler_that_has_gone(tmp_path, plates, cluster):
    session, _ = begin_stalled_export(tmp_path, plates, cluster)
    session.close()
    cluster.kill("scheduler")
    session = begin_session(tmp_path / "preferences", plates)
    run = session.files.exports.run
    run_until(session, lambda: run.state is not None and not run.is_busy, "its end")
    assert run.state.code == 2 and run.state.last_sentence.startswith("No Dask scheduler answers")
    session.close()


@pytest.mark.parametrize("case", ["another", "never agreed"])
def test_left_export_is_not_followed_to_scheduler_without_agreement(
    tmp_path, plates, cluster, case
):
    """The scheduler was started again meanwhile, or the user never agreed to it."""
    session, _ = begin_stalled_export(tmp_path, plates, cluster, is_agreed=case == "another")
    session.close()
    cluster.kill("scheduler")
    cluster.schedule()
    session = begin_session(tmp_path / "preferences", plates)
    run = session.files.exports.run
    if case == "another":
        run_until(session, lambda: run.state is not None and not run.is_busy, "its end")
        assert run.state.code == 2 and "export again to use it" in run.state.last_sentence
    else:
        run_until(
            session, lambda: "export again to follow it" in session.messages.text, "the words"
        )
        assert run.state is None
    session.close()
