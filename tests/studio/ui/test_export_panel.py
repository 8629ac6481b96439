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
from heatlens.core.base.messages import window_words
from heatlens.core.base.paths import data_dir, folder_to_write_in
from heatlens.core.model.boxes import Box
from heatlens.core.model.curves.frames import FrameRange
from heatlens.core.model.shot.lens_parameter import LensParameter
from heatlens.core.model.shot.settings import DefocusSettings, Quality
from heatlens.core.model.view.guides import NO_GUIDES, Guides
from heatlens.core.model.view.view import DisplayOptions
from heatlens.deliver.export.job import read_job
from heatlens.deliver.export.options import ExportOptions
from heatlens.deliver.farm.export_place import ExportPlace, Where
from heatlens.deliver.farm.export_process import ExportState, _read_event
from heatlens.fronts.commands.main import main
from heatlens.media.plate.exr.exr_read import read_parts
from heatlens.media.plate.exr.exr_write import write_exr
from heatlens.render.gpu.textures import download
from heatlens.studio.settings.export_settings import (
    ExportSettings,
    frame_kinds,
    proposed_settings,
)
from heatlens.studio.ui.panels.export_panel import difference_from_window
from support.dask_cluster import dask_cluster
from support.gui import Gui, gui_of
from support.patience import PATIENCE_S
from support.plates import room

FRAMES = (1001, 1002, 1003)
TALL = (1280, 1500)  # the whole panel is seen
FOCUS = LensParameter.FOCUS_DISTANCE


def write_plates(folder: Path) -> Path:
    """Write three small plates; return the pattern of their names."""
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
    with gui_of(session_context, write_plates(tmp_path), defocus=draft, size=TALL) as window:
        window.do("Export...")
        yield window


def wait_for(gui: Gui, is_true: Callable[[], bool], failure_note: Callable[[], object]) -> None:
    """Draw a frame every 0.05 s, which leaves the processors free, until `is_true()`."""
    end = time.monotonic() + PATIENCE_S
    while not is_true():
        assert time.monotonic() < end, failure_note()
        gui.frame()
        time.sleep(0.05)


def wait_for_end(gui: Gui) -> ExportState:
    """Wait until the export process has ended; return its state."""
    run = gui.session.files.exports.run
    wait_for(gui, lambda: not run.is_busy, lambda: run.state)
    gui.frame(2)
    assert run.state is not None
    return run.state


def pixels(path: Path) -> np.ndarray:
    ((_, channels),) = read_parts(path)
    return np.stack([channels[name] for name in "RGB"], axis=-1)


def test_exported_frames_equal_those_of_the_command_line(gui: Gui, tmp_path: Path, capsys) -> None:
    exporter = gui.session.files.exports
    assert (
        exporter.settings.folder == str(tmp_path / "room_dof") and exporter.settings.name == "room"
    )
    gui.click(gui.middle("Export"))
    state = wait_for_end(gui)
    assert (state.code, state.done_frames, state.frames) == (0, 3, 3)
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


def test_tooltip_of_export_option_does_not_cover_it(gui: Gui) -> None:
    exporter = gui.session.files.exports
    exporter.settings = replace(exporter.settings, kind="PNG (as displayed)")
    gui.frame(2)
    name = "guides and desqueeze of the window"
    gui.move(gui.middle(name))
    gui.frame(60)
    tips = [window for window in _open_windows() if window.name.startswith("##Tooltip")]
    assert [tip.pos.y + tip.size.y <= gui.rect(name)[1] + 1 for tip in tips] == [True]


def test_field_of_a_long_folder_shows_its_end(gui: Gui) -> None:
    gui.frame(3)
    x0, y0, x1, y1 = (round(it) for it in gui.rect("export folder"))
    exporter, seen = gui.session.files.exports, []
    for folder in ("a" * 99 + "/one", "a" * 99 + "/two", "b" + "a" * 98 + "/two"):
        exporter.settings = replace(exporter.settings, folder=folder)
        gui.frame(3)
        seen.append(gui.screenshot()[y0:y1, x0:x1].tobytes())
    assert seen[0] != seen[1] == seen[2]


def _open_windows() -> list[Any]:
    return [window for window in imgui.get_current_context().windows if window.active]


def test_burn_in_text_field_is_as_wide_as_the_panel(gui: Gui) -> None:
    exporter = gui.session.files.exports
    exporter.settings = replace(exporter.settings, kind="PNG (as displayed)", burn_in=True)
    gui.frame(2)
    x0, _, x1, _ = gui.rect("burn-in text")
    panel = imgui.internal.find_window_by_name("Export").content_region_rect
    assert x1 - x0 > 0.95 * (panel.max.x - panel.min.x)


def test_write_camera_exports_the_lens(gui: Gui, tmp_path: Path) -> None:
    exporter = gui.session.files.exports
    exporter.settings = ExportSettings(str(tmp_path), "cam", camera_kind="JSON")
    gui.frame(2)
    gui.click(gui.middle("Write camera"))
    assert wait_for_end(gui).code == 0, gui.session.messages.text
    assert (
        str(gui.session.facts.lens.focal_length_mm).rstrip("0").rstrip(".")
        in (tmp_path / "cam.json").read_text()
    )
    json.loads((tmp_path / "cam.json").read_text())


def press_export_and_answer(gui: Gui, answer: str) -> None:
    """Press Export, where files are there already, and answer the question about them."""
    gui.click(gui.middle("Export"))
    gui.frame(3)
    assert gui.session.files.exports.existing_words.startswith("1 file of this name is in ")
    gui.click(gui.middle(f"existing {answer}"))
    assert not gui.session.files.exports.existing_words


def test_export_overwrites_files_of_other_programs_only_if_ticked(gui: Gui, tmp_path: Path) -> None:
    (tmp_path / "out").mkdir()
    theirs = tmp_path / "out" / "x.1002.exr"
    theirs.write_bytes((tmp_path / "room.1002.exr").read_bytes())
    gui.session.files.exports.settings = ExportSettings(str(tmp_path / "out"), "x", frames="1002")
    gui.frame(2)
    press_export_and_answer(gui, "Export over them")
    refused = wait_for_end(gui)
    assert refused.code == 2 and "overwrite" in refused.last_sentence
    assert theirs.read_bytes() == (tmp_path / "room.1002.exr").read_bytes()
    gui.click(gui.middle("overwrite files not made by heatlens"))
    press_export_and_answer(gui, "Cancel")
    gui.click(gui.middle("Export"))
    gui.frame(3)
    gui.key(imgui.Key.enter)  # replaces nothing
    assert not gui.session.files.exports.existing_words
    assert gui.session.files.exports.run.state is refused
    press_export_and_answer(gui, "Export over them")
    assert wait_for_end(gui).code == 0
    assert theirs.read_bytes() != (tmp_path / "room.1002.exr").read_bytes()


def test_failed_export_shows_its_message(gui: Gui, tmp_path: Path) -> None:
    exporter = gui.session.files.exports
    exporter.settings = ExportSettings(str(tmp_path / "out"), "x", frames="2001-2010")
    gui.frame(2)
    gui.click(gui.middle("Export"))
    state = wait_for_end(gui)
    assert state.code == 2 and "2001" in state.last_sentence
    assert gui.session.messages.text == window_words(state.last_sentence)


def test_shot_without_frames_is_exported_with_those_on_disk(
    gui: Gui, monkeypatch: pytest.MonkeyPatch
) -> None:
    session, exported_shots = gui.session, []
    session.editing.begin(replace(session.facts.shot, frames=None).with_key(1002, FOCUS, 2.0))
    gui.frame(2)
    assert session.files.exports.played == FrameRange(FRAMES[0], FRAMES[-1])
    assert session.files.exports.settings.output.endswith("room.####.exr")
    monkeypatch.setattr(
        session.files.exports.run, "export", lambda shot, *_: exported_shots.append(shot)
    )
    gui.click(gui.middle("Export"))
    assert (
        exported_shots[0].played_frames == session.files.exports.played
    )  # and not only the frames with keys


def test_export_name_of_a_still_has_a_number_once_it_has_keys(gui: Gui, tmp_path: Path) -> None:
    still = tmp_path / "room_alone.exr"
    still.write_bytes((tmp_path / f"room.{FRAMES[0]}.exr").read_bytes())
    gui.open(still)
    assert gui.session.files.exports.settings.output.endswith("room_alone.exr")
    keyed = gui.session.facts.shot.with_key(1, FOCUS, 2.0).with_key(5, FOCUS, 3.0)
    gui.session.editing.begin(keyed)
    gui.frame(2)
    assert gui.session.files.exports.settings.output.endswith("room_alone.####.exr")


def test_canceled_export_leaves_only_whole_files(gui: Gui, tmp_path: Path) -> None:
    exporter = gui.session.files.exports
    gui.click(gui.middle("Export"))
    exporter.run.cancel()
    state = wait_for_end(gui)
    assert state.code in (0, 128 + signal.SIGTERM, -signal.SIGTERM)
    paths = sorted((tmp_path / "room_dof").iterdir())
    assert all(path.suffix == ".exr" and pixels(path).shape == (32, 48, 3) for path in paths)


@pytest.mark.parametrize("look", [{"gamma": 1.5}, {"input_space": "ACEScg"}, {}])
def test_exported_png_equals_the_displayed_picture(gui: Gui, tmp_path: Path, look: dict) -> None:
    gui.session.pictures.view.state = replace(gui.session.facts.view, **look)
    gui.settled()
    exporter = gui.session.files.exports
    exporter.settings = ExportSettings(
        str(tmp_path / "out"), "x", "PNG (as displayed)", frames="1001"
    )
    gui.frame(2)
    gui.click(gui.middle("Export"))
    assert wait_for_end(gui).code == 0, gui.session.messages.text
    light = download(gui.session.pictures.live.output.texture)[..., :3]
    stops = gui.session.facts.view.exposure_stops + gui.session.facts.lens.transmission_stops
    displayed = gui.session.pictures.color.transform.apply_cpu(
        light, stops, gui.session.facts.view.gamma
    )
    file = np.asarray(Image.open(tmp_path / "out" / "x.1001.png"), float)
    assert np.abs(file - 255 * np.clip(displayed, 0, 1)).max() <= 1.0


def test_export_settings_write_the_job_for_the_command(tmp_path) -> None:
    def job_of(settings: ExportSettings, guides: Guides = NO_GUIDES) -> tuple:
        (tmp_path / "job.json").write_text(settings.job(display, guides))
        return read_job(tmp_path / "job.json")

    settings = proposed_settings(tmp_path / "bar.v2.1001.exr")
    display = DisplayOptions(display="sRGB", view="ACES", exposure_stops=0.5)
    assert settings.output == str(tmp_path / "bar_dof" / "bar.####.exr")
    assert job_of(settings) == (ExportOptions(),)
    single = replace(proposed_settings(tmp_path / "still.exr"), is_single=True)
    assert single.output == str(tmp_path / "still_dof" / "still.exr")
    several = replace(single, frames="1-3")
    assert several.output == str(tmp_path / "still_dof" / "still.####.exr")
    for kind, suffix in frame_kinds().items():
        assert ExportSettings("/a", "b", kind).output.endswith(suffix)
    look = ExportSettings("/a", "b", "ProRes movie", "film", frames="1-5", burn_in=True)
    assert look.output == "/a/b.mov"
    options = ExportOptions(frames="1-5", burn_in=True)
    assert job_of(look) == (options, display, Guides())
    guides = Guides(aspect=2.39, thirds=True, desqueeze=2.0)
    assert job_of(replace(look, with_guides=True), guides) == (options, display, guides)
    assert job_of(look, guides) == (options, display, Guides())
    faint = Guides(opacity=0.5, centre=True)  # without a matte there is nothing faint
    drawn = job_of(replace(look, with_guides=True), faint)[2]
    assert drawn == Guides(centre=True)
    linear = ExportSettings("/a", "b", with_guides=True, with_depth=True, burn_in=True)
    assert job_of(linear, guides) == (ExportOptions(with_depth=True),)


def test_export_state_takes_events_and_ignores_other_lines() -> None:
    state = ExportState("export")
    for line in (
        '{"event": "begin", "output": "x", "frames": 7}\n',
        "out/x.exr\n",
        '{"event": "frame", "frame": 3, "done": 2, "frames": 7, "pace": "slow"}\n',
        '{"event": "frame", "frame": 4, "done": 3, "frames": 7, "seconds_left": 3.5}\n',
    ):
        _read_event(line, state)
    assert (state.done_frames, state.frames, state.remaining_s, state.pace) == (3, 7, 3.5, "slow")


def test_assets_are_exported_to_the_users_pictures_folder(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_PICTURES_DIR", str(tmp_path))
    for_asset = proposed_settings(data_dir("assets") / "still_life.exr")
    assert Path(for_asset.folder) == tmp_path / "still_life_dof"
    assert folder_to_write_in(data_dir("assets") / "still_life.exr") == tmp_path
    for_own_plate = proposed_settings(tmp_path / "room.exr")
    assert Path(for_own_plate.folder) == tmp_path / "room_dof"


def test_frames_exported_by_two_processes_equal_those_of_one(gui: Gui, tmp_path: Path) -> None:
    exporter = gui.session.files.exports
    gui.click(gui.middle("Export"))
    assert wait_for_end(gui).code == 0
    place = ExportPlace(processes=2)
    folder = str(tmp_path / "two")
    exporter.settings = replace(exporter.settings, folder=folder, place=place)
    gui.frame(2)
    gui.click(gui.middle("Export"))
    assert wait_for_end(gui).code == 0
    for frame in FRAMES:
        name = f"room.{frame}.exr"
        alone, by_two = (tmp_path / sub / name for sub in ("room_dof", "two"))
        assert alone.read_bytes() == by_two.read_bytes()


@pytest.mark.parametrize("where", [Where.SLURM, Where.BUNDLE])
def test_export_to_a_farm_saves_a_job_that_runs_without_the_window(
    gui: Gui, tmp_path: Path, where: Where
) -> None:
    """The export writes only the job and its shot; the job renders the frames when it runs."""
    exporter = gui.session.files.exports
    exporter.settings = replace(exporter.settings, place=ExportPlace(where), with_depth=True)
    gui.frame(2)
    gui.click(gui.middle("Export"))
    state = wait_for_end(gui)
    assert state.code == 0 and "3 frames in 1 task." in gui.session.messages.text, (
        state.last_sentence
    )
    out = tmp_path / "room_dof"
    file_names = {path.name for path in out.iterdir()}
    job = "room.job.sh" if where is Where.SLURM else "room.job"
    assert file_names == {"room.job.heatlens.json", job}
    if where is Where.SLURM:
        subprocess.run(["sh", "-n", out / job], check=True)
        assert "--with-depth" in (out / job).read_text()
        return
    values = json.loads((out / job / "parameters.json").read_text())
    assert values["Shot"] == str(out / "room.job.heatlens.json")
    run = openjd("run", out / job / "template.yaml", "-p", f"file://{out / job}/parameters.json")
    assert run.returncode == 0, run.stdout
    assert len(list(out.glob("room.*.exr"))) == 3


def test_export_on_a_cluster_counts_frames_by_worker(gui: Gui, tmp_path: Path) -> None:
    exporter = gui.session.files.exports
    with dask_cluster(tmp_path / "cluster", workers=1) as cluster:
        place = ExportPlace(Where.CLUSTER, scheduler=cluster.address)
        exporter.settings = replace(exporter.settings, place=place)
        gui.frame(2)
        gui.click(gui.middle("Export"))
        state = wait_for_end(gui)
    assert (state.code, state.done_frames) == (0, 3), state.last_sentence
    ((worker, count),) = state.frames_by_worker.items()
    assert worker.startswith("tcp://127.0.0.1") and count == 3
    assert len(list((tmp_path / "room_dof").glob("*.exr"))) == 3


def test_export_place_is_kept_for_other_plates_and_in_preferences(gui: Gui) -> None:
    """The place of export is used for another plate and saved in the preferences."""
    exporter = gui.session.files.exports
    place = ExportPlace(Where.CLUSTER, scheduler="nonsense")
    exporter.settings = replace(exporter.settings, place=place)
    gui.frame(2)
    gui.click(gui.middle("Export"))
    assert wait_for_end(gui).code == 2 and "No Dask scheduler" in gui.session.messages.text
    exporter._proposed_source = "another plate"
    gui.frame(2)
    assert exporter.settings.place == place
    assert gui.session.preferences.values.export_place == place


def test_chosen_cluster_renders_frames_ahead_after_agreement(gui: Gui, tmp_path: Path) -> None:
    """The typed address is used after Enter and the answer; the tab shows the number of workers."""
    exporter, pull = gui.session.files.exports, gui.session.time.frames_ahead
    with dask_cluster(tmp_path / "cluster", workers=1) as cluster:
        exporter.change(replace(exporter.settings, place=ExportPlace(Where.CLUSTER)))
        gui.frame(2)
        assert pull.cluster._cluster.address == ExportPlace().scheduler
        gui.click(gui.middle("export scheduler"))
        gui.key(imgui.Key.a, ctrl=True)
        gui.type(cluster.address)
        gui.key(imgui.Key.enter)
        assert gui.session.preferences.values.export_place.scheduler == cluster.address
        wait_for(
            gui, lambda: "notice Use this scheduler" in gui.drawn, lambda: pull.cluster.status_text
        )
        assert (
            "if it is yours, choose Use this scheduler" in pull.cluster.status_text
            and not pull.progress.rendered_frames
        )
        gui.click(gui.middle("notice Use this scheduler"))
        wait_for(
            gui,
            lambda: (
                pull.cluster.status_text == "1 worker ready"
                and len(pull.progress.rendered_frames) == len(FRAMES)
            ),
            lambda: pull.cluster.status_text,
        )
        gui.click(gui.middle("frames ahead (the blue bar)"))
        gui.frame(2)
        assert pull.cluster._cluster is None and pull.cluster.status_text == ""


def test_export_panel_says_which_quality_the_window_shows_if_the_export_has_another() -> None:
    for exported in Quality:
        for shown in Quality:
            words = difference_from_window(exported, shown)
            assert (words == "") == (exported is shown)
            assert not words or str(shown) in words
