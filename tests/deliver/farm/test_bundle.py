"""Test `--submit openjd --bundle`: a job with all its files, for machines with other folders."""

import json
import os
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from deadline.client.job_bundle.loader import read_yaml_or_json_object
from deadline.client.job_bundle.parameters import read_job_bundle_parameters
from deadline.client.job_bundle.submission import AssetReferences
from PIL import Image

from deliver.farm.test_openjd import openjd
from heatlens.core.model.shot.look import Look
from heatlens.fronts.commands.main import main
from heatlens.media.documents.lens_kits import kit_shelf, kit_text
from heatlens.media.documents.shot_file import write_shot
from heatlens.media.plate.opening_picture import read_opening_image
from support.cube_config import cube_config
from support.exports import (
    FRAMES,
    export_shot,
    files_in,
    refused_export_message,
    shot_of,
    write_plate,
    write_plates,
)

CARD = """#usda 1.0
( defaultPrim = "Card" )
def Mesh "Card" {
    int[] faceVertexCounts = [4]
    int[] faceVertexIndices = [0, 1, 2, 3]
    point3f[] points = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
}
"""
STAGE = """#usda 1.0
( metersPerUnit = 1 )
def "Card" ( references = @../lib/card.usda@ ) {}
def Camera "shot" {
    float focalLength = 0.5
    float horizontalAperture = 0.36
    double3 xformOp:translate = (0, 0, 3)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
"""
QUICK = ("--chunk", "3", "--memory", "1")  # two tasks of three frames


def write_opening(path: Path, wide: int) -> Path:
    image = np.zeros((64, 64), np.uint8)
    image[:, 32 - wide : 32 + wide] = 255
    path.parent.mkdir(exist_ok=True)
    Image.fromarray(image).save(path)
    return path


def write_show(root: Path) -> Path:
    """Write a shot whose files lie in folders of their own, and return it."""
    root.mkdir()
    source = write_plates(root / "plates")
    (root / "back drop").mkdir()
    for frame in FRAMES:
        write_plate(root / "back drop" / f"clean.{frame}.exr", 2 * frame)
    shot = shot_of(source)
    options = replace(shot.plate_options, behind=(str(root / "back drop" / "clean.####.exr"),))
    narrow_image, wide_image = (
        write_opening(root / n / "iris.png", w) for n, w in (("a", 4), ("b", 20))
    )
    lens = replace(shot.lens, aperture_image=read_opening_image(narrow_image))
    look = Look("wide", replace(shot.lens, aperture_image=read_opening_image(wide_image)))
    (root / "shots").mkdir()
    path = root / "shots" / "s.heatlens.json"
    write_shot(path, replace(shot, plate_options=options, lens=lens, looks=(look,)))
    return path


def write_bundle(capsys, folder: Path, *words: object) -> dict[str, str]:
    """Write a bundle into the folder; return the values of its parameters."""
    submit_options = ("--submit", "openjd", "--bundle", str(folder), *QUICK)
    assert main(["export", *map(str, words), *submit_options]) == 0
    capsys.readouterr()
    return json.loads((folder / "parameters.json").read_text())


def asset_references(folder: Path) -> AssetReferences:
    return AssetReferences.from_dict(
        read_yaml_or_json_object(str(folder), "asset_references", required=True)
    )


def copy_listed_files(bundle: Path, values: dict[str, str], worker: Path) -> dict[str, str]:
    """Copy only the listed files to folders of `worker`. Return the new path of each parameter."""
    new_paths = {name: worker / f"{name} of worker" for name in values}
    for name, value in values.items():
        if os.path.isfile(value):
            new_paths[name] /= os.path.basename(value)
    for path in map(Path, asset_references(bundle).input_filenames):
        for name, value in values.items():
            if name != "Out" and (path == Path(value) or Path(value) in path.parents):
                target = new_paths[name] / path.relative_to(value)
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(path, target)
    new_paths["Out"].mkdir()
    return {name: str(path) for name, path in new_paths.items()}


@pytest.mark.parametrize("output", ["n.####.exr", "m.mov"])
def test_bundle_renders_same_files_from_listed_files_alone(capsys, tmp_path, output):
    """The worker has each folder at another path; the joined movie equals that of one machine."""
    show = tmp_path / "my 'show' \"%d\" $x"
    shot = write_show(show)
    export_shot(capsys, shot, tmp_path / "whole" / output)
    values = write_bundle(capsys, tmp_path / "job", shot, "-o", show / "out" / output)
    assert not (show / "out").exists()
    (tmp_path / "worker").mkdir()
    worker_paths = copy_listed_files(tmp_path / "job", values, tmp_path / "worker")
    os.rename(show, tmp_path / "gone")
    path_options = [
        word for name, value in worker_paths.items() for word in ("-p", f"{name}={value}")
    ]
    for step in ["Export", "Join"] if output == "m.mov" else ["Export"]:
        run = openjd("run", tmp_path / "job" / "template.yaml", "--step", step, *path_options)
        assert run.returncode == 0, run.stdout
    assert files_in(Path(worker_paths["Out"])) == files_in(tmp_path / "whole")


def test_bundle_lists_all_files_and_deadline_can_read_it(capsys, tmp_path):
    """Every file is listed by name, also the first plate, which decides how all plates are read."""
    shot, show = write_show(tmp_path / "show"), tmp_path / "show"
    (tmp_path / "color").mkdir()
    config = cube_config(tmp_path / "color").source
    words = ("-o", show / "out" / "n.####.png", "--ocio", config, "--frames", "1002-1003")
    write_bundle(capsys, tmp_path / "job", shot, *words)
    parameters = {
        it["name"]: it["value"] for it in read_job_bundle_parameters(str(tmp_path / "job"))
    }
    assert parameters["Shot"] == str(shot) and parameters["Out"] == str(show / "out")
    assert parameters["Config"] == config and parameters["Plates"] == str(show / "plates")
    files = asset_references(tmp_path / "job")
    assert files.input_filenames == {
        *(str(show / "plates" / f"plate.{frame}.exr") for frame in (1001, 1002, 1003)),
        *(str(show / "back drop" / f"clean.{frame}.exr") for frame in (1001, 1002, 1003)),
        *(str(show / name / "iris.png") for name in "ab"),
        *(str(tmp_path / "color" / name) for name in ("studio.ocio", "film.cube", "curve.cube")),
        str(shot),
    }
    assert files.output_directories == {str(show / "out")}
    assert openjd("check", tmp_path / "job" / "template.yaml").returncode == 0


def test_bundle_runs_on_same_machine_unchanged(capsys, tmp_path):
    shot = write_show(tmp_path / "show")
    write_bundle(capsys, tmp_path / "job", shot, "-o", tmp_path / "out" / "m.mov")
    values = f"file://{tmp_path / 'job' / 'parameters.json'}"
    run = openjd("run", tmp_path / "job" / "template.yaml", "-p", values)
    assert run.returncode == 0, run.stdout
    export_shot(capsys, shot, tmp_path / "whole.mov")
    assert (tmp_path / "out" / "m.mov").read_bytes() == (tmp_path / "whole.mov").read_bytes()
    assert list(files_in(tmp_path / "out")) == ["m.mov"]


def test_bundle_includes_files_named_by_options(capsys, tmp_path):
    """Without a shot file, options of the command line name the files on both machines."""
    source = write_plates(tmp_path / "plates")
    image = write_opening(tmp_path / "a" / "iris.png", 6)
    lens = ("--focus-distance", 2, "--f-stop", 2, "--aperture-image", image, "--frames", 1001)
    words = ("--quality", "draft", *lens)
    export_shot(capsys, source, tmp_path / "whole" / "n.####.exr", *words)
    values = write_bundle(
        capsys, tmp_path / "job", source, "-o", tmp_path / "o" / "n.####.exr", *words
    )
    (tmp_path / "worker").mkdir()
    check_elsewhere(tmp_path, values, tmp_path / "plates", tmp_path / "a")


def test_bundle_with_neighbors_lists_whole_sequence(capsys, tmp_path):
    """The neighbors of a frame are chosen among all plates, so the worker needs all of them."""
    source = write_plates(tmp_path / "plates")
    shot = tmp_path / "s.heatlens.json"
    plain_shot = shot_of(source)
    write_shot(
        shot, replace(plain_shot, plate_options=replace(plain_shot.plate_options, neighbours=1))
    )
    words = ("--frames", "1003")
    export_shot(capsys, shot, tmp_path / "whole" / "n.####.exr", *words)
    values = write_bundle(
        capsys, tmp_path / "job", shot, "-o", tmp_path / "o" / "n.####.exr", *words
    )
    assert len(asset_references(tmp_path / "job").input_filenames) == 1 + len(FRAMES)
    (tmp_path / "worker").mkdir()
    check_elsewhere(tmp_path, values, tmp_path / "plates")


def test_bundle_of_scene_includes_referenced_files(capsys, tmp_path):
    """The scene files refer to each other by relative paths, which the bundle preserves."""
    lib, sets = tmp_path / "show" / "lib", tmp_path / "show" / "sets"
    lib.mkdir(parents=True)
    sets.mkdir()
    (lib / "card.usda").write_text(CARD)
    (sets / "stage.usda").write_text(STAGE)
    words = ("--frames", "1", "--size", "32x18", "--f-stop", "2", "--focus-distance", "3")
    export_shot(capsys, sets / "stage.usda", tmp_path / "whole" / "n.####.exr", *words)
    out = tmp_path / "o" / "n.####.exr"
    values = write_bundle(capsys, tmp_path / "job", sets / "stage.usda", "-o", out, *words)
    assert set(values) == {"Plates", "Out"}
    (tmp_path / "worker").mkdir()
    check_elsewhere(tmp_path, values, tmp_path / "show")


def check_elsewhere(folder: Path, values: dict[str, str], *removed_paths: Path) -> None:
    """Run the bundle with only its listed files, and compare the result with `whole`."""
    worker_paths = copy_listed_files(folder / "job", values, folder / "worker")
    for path in removed_paths:
        os.rename(path, folder / f"gone {path.name}")
    path_options = [
        word for name, value in worker_paths.items() for word in ("-p", f"{name}={value}")
    ]
    run = openjd("run", folder / "job" / "template.yaml", *path_options)
    assert run.returncode == 0, run.stdout
    assert files_in(Path(worker_paths["Out"])) == files_in(folder / "whole")


def test_bundle_includes_ocio_config_of_environment(capsys, tmp_path, monkeypatch):
    """Another machine may have no OCIO config or a different one."""
    monkeypatch.setenv("OCIO", cube_config(tmp_path).source)
    source = write_plates(tmp_path / "plates")
    words = ("--focus-distance", 2, "--f-stop", 2, "-o", tmp_path / "o" / "n.####.png")
    values = write_bundle(capsys, tmp_path / "job", source, *words)
    assert values["Config"] == str(tmp_path / "studio.ocio")
    assert "--ocio={{Param.Config}}" in (tmp_path / "job" / "template.yaml").read_text()


def test_submit_refuses_lens_kit_known_to_this_machine_only(capsys, tmp_path, monkeypatch):
    kit = next(iter(kit_shelf().kits.values()))
    monkeypatch.setattr("heatlens.media.documents.lens_kits.kits_dir", lambda: tmp_path)
    (tmp_path / "mine.json").write_text(kit_text(replace(kit, name="mine")))
    lens = ("--lens-kit", f"mine:{kit.lenses[0].focal_length_mm:g}", "--focus-distance", 3)
    lens += ("--f-stop", 5.6, "--submit", "openjd", *QUICK)
    message = refused_export_message(
        capsys, write_plates(tmp_path / "plates"), tmp_path / "n.####.exr", *lens
    )
    assert "--lens-kit" in message and "shot new" in message
