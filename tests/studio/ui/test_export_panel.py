"""Exports from the window: real clicks, real processes, files as the command line writes them."""

import json
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from imgui_bundle import imgui
from PIL import Image

from deliver.farm.test_openjd import openjd
from heatlens.core.base.paths import data_dir, folder_to_write_in
from heatlens.core.model.boxes import Box
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.settings import DefocusSettings, Quality
from heatlens.core.model.view.guides import NO_GUIDES, Guides
from heatlens.core.model.view.view import DisplayOptions
from heatlens.deliver.export.job import read_job
from heatlens.deliver.export.options import ExportOptions
from heatlens.fronts.commands.main import main
from heatlens.media.plate.exr.exr_read import read_parts
from heatlens.media.plate.exr.exr_write import write_exr
from heatlens.render.gpu.textures import download
from heatlens.studio.session.exports.export_process import ExportState, _take
from heatlens.studio.session.exports.export_settings import (
    ExportSettings,
    frame_kinds,
    proposed_settings,
)
from heatlens.studio.session.messages import window_words
from heatlens.studio.session.settings.export_place import ExportPlace, Where
from support.dask_cluster import dask_cluster
from support.gui import Gui, gui_of
from support.plates import room

FRAMES = (1001, 1002, 1003)
TALL = (1280, 1500)  # the whole panel is seen
FOCUS = LensParameter.FOCUS_DISTANCE
WAIT_S = 90.0  # a bound for what must come


def written(folder: Path) -> Path:
    """Return three small plates; the pattern of their names."""
    color, depth = room(48, 32)
    box = Box(0, 0, 48, 32)
    for number, frame in enumerate(FRAMES):
        channels = {name: color[..., i] for i, name in enumerate("RGB")}
        path = folder / f"room.{frame}.exr"
        write_exr(path, channels | {"Z": depth * (1 + 0.1 * number)}, box, box)
    return folder / "room.####.exr"


@pytest.fixture
def gui(session_context, tmp_path: Path) -> Iterator[Gui]:
    draft = DefocusSettings(quality=Quality.DRAFT)
    with gui_of(session_context, written(tmp_path), defocus=draft, size=TALL) as window:
        window.do("Export...")
        yield window


def wait_for(gui: Gui, is_true: Callable[[], bool], told: Callable[[], object]) -> None:
    """Draw few frames, which leaves the processors to what is waited for."""
    end = time.monotonic() + WAIT_S
    while not is_true():
        assert time.monotonic() < end, told()
        gui.frame()
        time.sleep(0.05)


def ended(gui: Gui) -> ExportState:
    run = gui.session.files.exports.run
    wait_for(gui, lambda: not run.is_busy, lambda: run.state)
    gui.frame(2)
    assert run.state is not None
    return run.state


def pixels(path: Path) -> np.ndarray:
    ((_, channels),) = read_parts(path)
    return np.stack([channels[name] for name in "RGB"], axis=-1)


def test_frames_are_those_of_the_command_line(gui: Gui, tmp_path: Path, capsys) -> None:
    exporter = gui.session.files.exports
    assert (
        exporter.settings.folder == str(tmp_path / "room_dof") and exporter.settings.name == "room"
    )
    gui.click(gui.middle("Export"))
    state = ended(gui)
    assert (state.code, state.done, state.frames) == (0, 3, 3)
    assert gui.session.messages.text.startswith("Done")
    lens = gui.session.facts.lens
    words = ["--focal-length", lens.focal_length_mm, "--f-stop", lens.f_stop, "--quality", "draft"]
    words += ["--sensor-width", lens.sensor_width_mm, "--focus-distance", lens.focus_distance_m]
    for frame in FRAMES:
        out = tmp_path / f"alone.{frame}.exr"
        plate = tmp_path / f"room.{frame}.exr"
        assert main(["render", str(plate), "-o", str(out), *map(str, words)]) == 0
        assert np.array_equal(pixels(tmp_path / "room_dof" / f"room.{frame}.exr"), pixels(out))
    capsys.readouterr()


def test_what_a_tip_tells_leaves_the_button_under_it_free(gui: Gui) -> None:
    exporter = gui.session.files.exports
    exporter.settings = replace(exporter.settings, kind="PNG, as it looks")
    gui.frame(2)
    name = "guides and desqueeze of the window"
    gui.move(gui.middle(name))
    gui.frame(60)
    tips = [window for window in _open_windows() if window.name.startswith("##Tooltip")]
    assert [tip.pos.y + tip.size.y <= gui.rect(name)[1] + 1 for tip in tips] == [True]


def _open_windows() -> list[Any]:
    return [window for window in imgui.get_current_context().windows if window.active]


def test_the_text_of_the_burn_in_has_the_width_of_the_panel(gui: Gui) -> None:
    exporter = gui.session.files.exports
    exporter.settings = replace(exporter.settings, kind="PNG, as it looks", burn_in=True)
    gui.frame(2)
    x0, _, x1, _ = gui.rect("burn-in text")
    panel = imgui.internal.find_window_by_name("Export").content_region_rect
    assert x1 - x0 > 0.95 * (panel.max.x - panel.min.x)


def test_the_lens_goes_out_as_a_camera(gui: Gui, tmp_path: Path) -> None:
    exporter = gui.session.files.exports
    exporter.settings = ExportSettings(str(tmp_path), "cam", camera_kind="JSON")
    gui.frame(2)
    gui.click(gui.middle("Write camera"))
    assert ended(gui).code == 0, gui.session.messages.text
    assert (
        str(gui.session.facts.lens.focal_length_mm).rstrip("0").rstrip(".")
        in (tmp_path / "cam.json").read_text()
    )
    json.loads((tmp_path / "cam.json").read_text())


def test_files_of_other_programs_are_replaced_if_that_is_ticked(gui: Gui, tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    theirs = tmp_path / "out" / "x.1002.exr"
    theirs.write_bytes((tmp_path / "room.1002.exr").read_bytes())
    gui.session.files.exports.settings = ExportSettings(str(tmp_path / "out"), "x", frames="1002")
    gui.frame(2)
    gui.click(gui.middle("Export"))
    refused = ended(gui)
    assert refused.code == 2 and "overwrite" in refused.said
    assert theirs.read_bytes() == (tmp_path / "room.1002.exr").read_bytes()
    gui.click(gui.middle("overwrite files of other programs"))
    gui.click(gui.middle("Export"))
    assert ended(gui).code == 0
    assert theirs.read_bytes() != (tmp_path / "room.1002.exr").read_bytes()


def test_what_cannot_be_exported_is_said_in_red(gui: Gui, tmp_path: Path) -> None:
    exporter = gui.session.files.exports
    exporter.settings = ExportSettings(str(tmp_path / "out"), "x", frames="2001-2010")
    gui.frame(2)
    gui.click(gui.middle("Export"))
    state = ended(gui)
    assert state.code == 2 and "2001" in state.said
    assert gui.session.messages.text == window_words(state.said)


def test_a_shot_that_tells_no_frames_is_exported_with_those_on_disk(
    gui: Gui, monkeypatch: pytest.MonkeyPatch
) -> None:
    session, sent = gui.session, []
    session.editing.begin(replace(session.facts.shot, frames=None).with_key(1002, FOCUS, 2.0))
    gui.frame(2)
    assert session.files.exports.played == FrameRange(FRAMES[0], FRAMES[-1])
    assert session.files.exports.settings.output.endswith("room.####.exr")
    monkeypatch.setattr(session.files.exports.run, "export", lambda shot, *_: sent.append(shot))
    gui.click(gui.middle("Export"))
    assert sent[0].played == session.files.exports.played  # and not only the frames with keys


def test_a_still_needs_a_number_once_it_has_keys(gui: Gui, tmp_path: Path) -> None:
    still = tmp_path / "room_alone.exr"
    still.write_bytes((tmp_path / f"room.{FRAMES[0]}.exr").read_bytes())
    gui.open(still)
    assert gui.session.files.exports.settings.output.endswith("room_alone.exr")
    keyed = gui.session.facts.shot.with_key(1, FOCUS, 2.0).with_key(5, FOCUS, 3.0)
    gui.session.editing.begin(keyed)
    gui.frame(2)
    assert gui.session.files.exports.settings.output.endswith("room_alone.####.exr")


def test_a_stopped_export_leaves_whole_files(gui: Gui, tmp_path: Path) -> None:
    exporter = gui.session.files.exports
    gui.click(gui.middle("Export"))
    exporter.run.cancel()
    state = ended(gui)
    assert state.code in (0, 128 + signal.SIGTERM, -signal.SIGTERM)
    found = sorted((tmp_path / "room_dof").iterdir())
    assert all(path.suffix == ".exr" and pixels(path).shape == (32, 48, 3) for path in found)


@pytest.mark.parametrize("look", [{"gamma": 1.5}, {"input_space": "ACEScg"}, {}])
def test_an_exported_picture_looks_as_it_does_here(gui: Gui, tmp_path: Path, look: dict) -> None:
    gui.session.pictures.view.state = replace(gui.session.facts.view, **look)
    gui.settled()
    exporter = gui.session.files.exports
    exporter.settings = ExportSettings(
        str(tmp_path / "out"), "x", "PNG, as it looks", frames="1001"
    )
    gui.frame(2)
    gui.click(gui.middle("Export"))
    assert ended(gui).code == 0, gui.session.messages.text
    light = download(gui.session.pictures.live.shown.texture)[..., :3]
    stops = gui.session.facts.view.exposure_stops + gui.session.facts.lens.transmission_stops
    seen = gui.session.pictures.color.transform.apply_cpu(
        light, stops, gui.session.facts.view.gamma
    )
    file = np.asarray(Image.open(tmp_path / "out" / "x.1001.png"), float)
    assert np.abs(file - 255 * np.clip(seen, 0, 1)).max() <= 1.0


def test_a_wish_is_a_job_for_the_command(tmp_path) -> None:
    def told(wish: ExportSettings, guides: Guides = NO_GUIDES) -> tuple:
        (tmp_path / "job.json").write_text(wish.job(seen, guides))
        return read_job(tmp_path / "job.json")

    wish = proposed_settings(tmp_path / "bar.v2.1001.exr")
    seen = DisplayOptions(display="sRGB", view="ACES", exposure_stops=0.5)
    assert wish.output == str(tmp_path / "bar_dof" / "bar.####.exr")
    assert told(wish) == (ExportOptions(),)
    single = replace(proposed_settings(tmp_path / "still.exr"), is_single=True)
    assert single.output == str(tmp_path / "still_dof" / "still.exr")
    several = replace(single, frames="1-3")
    assert several.output == str(tmp_path / "still_dof" / "still.####.exr")
    for kind, suffix in frame_kinds().items():
        assert ExportSettings("/a", "b", kind).output.endswith(suffix)
    look = ExportSettings("/a", "b", "ProRes movie", "film", frames="1-5", burn_in=True)
    assert look.output == "/a/b.mov"
    options = ExportOptions(frames="1-5", burn_in=True)
    assert told(look) == (options, seen, Guides())
    guides = Guides(aspect=2.39, thirds=True, desqueeze=2.0)
    assert told(replace(look, with_guides=True), guides) == (options, seen, guides)
    assert told(look, guides) == (options, seen, Guides())
    faint = Guides(opacity=0.5, centre=True)  # without a matte there is nothing faint
    drawn = told(replace(look, with_guides=True), faint)[2]
    assert drawn == Guides(centre=True)
    linear = ExportSettings("/a", "b", with_guides=True, with_depth=True, burn_in=True)
    assert told(linear, guides) == (ExportOptions(with_depth=True),)


def test_news_of_the_process_are_taken_and_other_lines_left() -> None:
    state = ExportState("export")
    for line in (
        '{"event": "begin", "output": "x", "frames": 7}\n',
        "out/x.exr\n",
        '{"event": "frame", "frame": 3, "done": 2, "frames": 7, "pace": "slow"}\n',
        '{"event": "frame", "frame": 4, "done": 3, "frames": 7, "seconds_left": 3.5}\n',
    ):
        _take(line, state)
    assert (state.done, state.frames, state.left_s, state.pace) == (3, 7, 3.5, "slow")


def test_what_comes_with_the_program_is_exported_to_the_users_pictures(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_PICTURES_DIR", str(tmp_path))
    own = proposed_settings(data_dir("assets") / "still_life.exr")
    assert Path(own.folder) == tmp_path / "still_life_dof"
    assert folder_to_write_in(data_dir("assets") / "still_life.exr") == tmp_path
    beside = proposed_settings(tmp_path / "room.exr")
    assert Path(beside.folder) == tmp_path / "room_dof"


def test_frames_by_several_processes_are_those_of_one(gui: Gui, tmp_path: Path) -> None:
    exporter = gui.session.files.exports
    gui.click(gui.middle("Export"))
    assert ended(gui).code == 0
    place = ExportPlace(processes=2)
    there = str(tmp_path / "two")
    exporter.settings = replace(exporter.settings, folder=there, place=place)
    gui.frame(2)
    gui.click(gui.middle("Export"))
    assert ended(gui).code == 0
    for frame in FRAMES:
        name = f"room.{frame}.exr"
        one, two = (tmp_path / folder / name for folder in ("room_dof", "two"))
        assert one.read_bytes() == two.read_bytes()


@pytest.mark.parametrize("where", [Where.SLURM, Where.BUNDLE])
def test_a_job_is_saved_with_its_shot_and_can_be_run_without_the_window(
    gui: Gui, tmp_path: Path, where: Where
) -> None:
    """What it says is a sentence for the farm; the frames are made when it runs."""
    exporter = gui.session.files.exports
    exporter.settings = replace(exporter.settings, place=ExportPlace(where), with_depth=True)
    gui.frame(2)
    gui.click(gui.middle("Export"))
    state = ended(gui)
    assert state.code == 0 and "3 frames in 1 task." in gui.session.messages.text, state.said
    out = tmp_path / "room_dof"
    named = {path.name for path in out.iterdir()}
    job = "room.job.sh" if where is Where.SLURM else "room.job"
    assert named == {"room.job.heatlens.json", job}
    if where is Where.SLURM:
        subprocess.run(["sh", "-n", out / job], check=True)
        assert "--with-depth" in (out / job).read_text()
        return
    values = json.loads((out / job / "parameters.json").read_text())
    assert values["Shot"] == str(out / "room.job.heatlens.json")
    run = openjd("run", out / job / "template.yaml", "-p", f"file://{out / job}/parameters.json")
    assert run.returncode == 0, run.stdout
    assert len(list(out.glob("room.*.exr"))) == 3


def test_a_cluster_makes_the_frames_and_its_workers_are_counted(gui: Gui, tmp_path: Path) -> None:
    exporter = gui.session.files.exports
    with dask_cluster(tmp_path / "cluster", workers=1) as cluster:
        place = ExportPlace(Where.CLUSTER, scheduler=cluster.address)
        exporter.settings = replace(exporter.settings, place=place)
        gui.frame(2)
        gui.click(gui.middle("Export"))
        state = ended(gui)
    assert (state.code, state.done) == (0, 3), state.said
    ((worker, count),) = state.made_by.items()
    assert worker.startswith("tcp://127.0.0.1") and count == 3
    assert len(list((tmp_path / "room_dof").glob("*.exr"))) == 3


def test_what_was_chosen_last_stays(gui: Gui) -> None:
    """It is there for another plate, and in the preferences of the next evening."""
    exporter = gui.session.files.exports
    place = ExportPlace(Where.CLUSTER, scheduler="nonsense")
    exporter.settings = replace(exporter.settings, place=place)
    gui.frame(2)
    gui.click(gui.middle("Export"))
    assert ended(gui).code == 2 and "No Dask scheduler" in gui.session.messages.text
    exporter._of = "another plate"
    gui.frame(2)
    assert exporter.settings.place == place
    assert gui.session.preferences.now.export_place == place


def test_a_cluster_that_is_chosen_renders_the_frames_ahead(gui: Gui, tmp_path: Path) -> None:
    """The address counts once it is typed; the tab tells how many workers are there."""
    exporter, pull = gui.session.files.exports, gui.session.time.pull
    with dask_cluster(tmp_path / "cluster", workers=1) as cluster:
        exporter.change(replace(exporter.settings, place=ExportPlace(Where.CLUSTER)))
        gui.frame(2)
        assert pull.cluster._cluster.address == ExportPlace().scheduler
        gui.click(gui.middle("export scheduler"))
        gui.key(imgui.Key.a, ctrl=True)
        gui.type(cluster.address)
        gui.key(imgui.Key.enter)
        assert gui.session.preferences.now.export_place.scheduler == cluster.address
        wait_for(gui, lambda: "agree" in gui.drawn, lambda: pull.cluster.told)
        assert "agree to it in the Export tab" in pull.cluster.told and not pull.progress.rendered
        gui.click(gui.middle("agree"))
        wait_for(
            gui,
            lambda: (
                pull.cluster.told == "1 worker ready" and len(pull.progress.rendered) == len(FRAMES)
            ),
            lambda: pull.cluster.told,
        )
        gui.click(gui.middle("frames ahead (the blue bar)"))
        gui.frame(2)
        assert pull.cluster._cluster is None and pull.cluster.told == ""
