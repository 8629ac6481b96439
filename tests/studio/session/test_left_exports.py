"""Exports of the window on a cluster: closing it leaves them, opening the shot follows them."""

import os
import signal

import pytest

from heatlens.deliver.farm.connection import connected, met
from heatlens.studio.session.exports.export_settings import ExportSettings
from heatlens.studio.session.settings.export_place import ExportPlace, Where
from heatlens.studio.session.settings.preferences import Preferences
from support.dask_cluster import children_of, dask_cluster, wait_for
from support.evening import begun, settled, until, write_plates
from support.exports import files_in

COUNT = 24


@pytest.fixture
def cluster(tmp_path):
    with dask_cluster(tmp_path / "cluster", workers=1) as found:
        wait_for(lambda: "works for" in found.said("worker 0"))
        yield found


@pytest.fixture
def walls(tmp_path):
    return write_plates(tmp_path)


def exporting(tmp_path, walls, cluster, is_agreed=True):
    """Return a session whose export is at a scheduler with a worker that stands still."""
    session = begun(tmp_path / "preferences", walls)
    settled(session)
    exports = session.files.exports
    exports.propose()
    session.preferences.change(cluster=met(cluster.address) if is_agreed else None)
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
def test_a_window_that_comes_back_follows_the_export_that_it_left(tmp_path, walls, cluster, made):
    session, worker = exporting(tmp_path, walls, cluster)
    state, out = session.files.exports.run.state, tmp_path / "out"
    session.close()
    assert state.code in (129, -signal.SIGKILL)  # of a machine too busy to end it in time
    assert state.said.startswith("Left to the cluster")
    assert set(files_in(out)) == {"walls.job.heatlens.json"}  # which the workers read
    if made == "all":
        os.kill(worker, signal.SIGCONT)
        wait_for(lambda: len(frames_of(out)) == COUNT)
    session = begun(tmp_path / "preferences", walls)
    run = session.files.exports.run
    until(session, lambda: run.is_busy, "the export")
    if made == "none":
        wait_for(lambda: "has under way" in run.state.said)  # and counted what is finished
        os.kill(worker, signal.SIGCONT)
    until(session, lambda: not run.is_busy, "its end")
    assert run.state.code == 0 and run.state.done == COUNT, run.state.said
    told = sum(run.state.made_by.values()), run.state.earlier
    assert told == ((0, COUNT) if made == "all" else (COUNT, 0))
    assert len(files_in(out)) == COUNT
    settled(session)
    session.files.documents.keep_preferences()
    session.close()
    assert not Preferences.load(tmp_path / "preferences").now.left_exports
    with connected(cluster.address) as client:
        assert client.list_datasets() == ()


def test_an_export_that_is_stopped_is_not_left(tmp_path, walls, cluster):
    session, _ = exporting(tmp_path, walls, cluster)
    run = session.files.exports.run
    assert run.can_be_left
    run.cancel()
    assert not run.can_be_left
    until(session, lambda: not run.is_busy, "its end")
    session.close()
    assert run.state.is_stopped and files_in(tmp_path / "out") == {}
    assert not Preferences.load(tmp_path / "preferences").now.left_exports
    with connected(cluster.address) as client:
        assert client.list_datasets() == ()


def test_another_shot_leaves_what_was_left_alone(tmp_path, walls, cluster):
    session, _ = exporting(tmp_path, walls, cluster)
    session.close()
    (tmp_path / "other").mkdir()
    session = begun(tmp_path / "preferences", write_plates(tmp_path / "other"))
    settled(session)
    assert not session.files.exports.run.is_busy
    session.close()
    assert len(Preferences.load(tmp_path / "preferences").now.left_exports) == 1


def test_a_scheduler_that_has_gone_meanwhile_is_told(tmp_path, walls, cluster):
    session, _ = exporting(tmp_path, walls, cluster)
    session.close()
    cluster.kill("scheduler")
    session = begun(tmp_path / "preferences", walls)
    run = session.files.exports.run
    until(session, lambda: run.state is not None and not run.is_busy, "its end")
    assert run.state.code == 2 and run.state.said.startswith("No Dask scheduler answers")
    session.close()


@pytest.mark.parametrize("case", ["another", "never agreed"])
def test_no_window_follows_an_export_to_a_scheduler_that_nobody_agreed_to(
    tmp_path, walls, cluster, case
):
    """It was started again meanwhile, or the user was never asked."""
    session, _ = exporting(tmp_path, walls, cluster, is_agreed=case == "another")
    session.close()
    cluster.kill("scheduler")
    cluster.schedule()
    session = begun(tmp_path / "preferences", walls)
    run = session.files.exports.run
    if case == "another":
        until(session, lambda: run.state is not None and not run.is_busy, "its end")
        assert run.state.code == 2 and "export again to use it" in run.state.said
    else:
        until(session, lambda: "export again to follow it" in session.messages.text, "the words")
        assert run.state is None
    session.close()
