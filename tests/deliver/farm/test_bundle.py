"""`--submit openjd --bundle`: all files of a job, for machines on which they lie elsewhere."""

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
from support.exports import FRAMES, exported, files_in, refused, shot_of, write_plate, write_plates

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
QUICK = ("--chunk", "2", "--memory", "1")


def write_opening(path: Path, wide: int) -> Path:
    light = np.zeros((64, 64), np.uint8)
    light[:, 32 - wide : 32 + wide] = 255
    path.parent.mkdir(exist_ok=True)
    Image.fromarray(light).save(path)
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
    slit, wide = (write_opening(root / n / "iris.png", w) for n, w in (("a", 4), ("b", 20)))
    lens = replace(shot.lens, aperture_image=read_opening_image(slit))
    look = Look("wide", replace(shot.lens, aperture_image=read_opening_image(wide)))
    (root / "shots").mkdir()
    path = root / "shots" / "s.heatlens.json"
    write_shot(path, replace(shot, plate_options=options, lens=lens, looks=(look,)))
    return path


def bundled(capsys, folder: Path, *words: object) -> dict[str, str]:
    """Write a bundle into the folder; return the values of its parameters."""
    more = ("--submit", "openjd", "--bundle", str(folder), *QUICK)
    assert main(["export", *map(str, words), *more]) == 0
    capsys.readouterr()
    return json.loads((folder / "parameters.json").read_text())


def listed(folder: Path) -> AssetReferences:
    return AssetReferences.from_dict(
        read_yaml_or_json_object(str(folder), "asset_references", required=True)
    )


def elsewhere(bundle: Path, values: dict[str, str], worker: Path) -> dict[str, str]:
    """Copy the listed files, and nothing else, to other folders; return where they are there."""
    found = {name: worker / f"{name} of worker" for name in values}
    for name, value in values.items():
        if os.path.isfile(value):
            found[name] /= os.path.basename(value)
    for path in map(Path, listed(bundle).input_filenames):
        for name, value in values.items():
            if name != "Out" and (path == Path(value) or Path(value) in path.parents):
                target = found[name] / path.relative_to(value)
                target.parent.mkdir(parents=True, exist_ok=True)
                shutil.copy2(path, target)
    found["Out"].mkdir()
    return {name: str(path) for name, path in found.items()}


@pytest.mark.parametrize("output", ["n.####.exr", "m.mov"])
def test_a_machine_with_the_listed_files_alone_makes_the_same(capsys, tmp_path, output):
    """It has each folder at another place; the joined movie is that of one machine."""
    show = tmp_path / "my 'show' \"%d\" $x"
    shot = write_show(show)
    exported(capsys, shot, tmp_path / "whole" / output)
    values = bundled(capsys, tmp_path / "job", shot, "-o", show / "out" / output)
    assert not (show / "out").exists()
    (tmp_path / "worker").mkdir()
    there = elsewhere(tmp_path / "job", values, tmp_path / "worker")
    os.rename(show, tmp_path / "gone")
    given = [word for name, value in there.items() for word in ("-p", f"{name}={value}")]
    for step in ["Export", "Join"] if output == "m.mov" else ["Export"]:
        run = openjd("run", tmp_path / "job" / "template.yaml", "--step", step, *given)
        assert run.returncode == 0, run.stdout
    assert files_in(Path(there["Out"])) == files_in(tmp_path / "whole")


def test_deadline_reads_the_bundle(capsys, tmp_path):
    """Every file is listed by its name, with the first plate, which decides how all are read."""
    shot, show = write_show(tmp_path / "show"), tmp_path / "show"
    (tmp_path / "color").mkdir()
    config = cube_config(tmp_path / "color").source
    words = ("-o", show / "out" / "n.####.png", "--ocio", config, "--frames", "1002-1003")
    bundled(capsys, tmp_path / "job", shot, *words)
    told = {it["name"]: it["value"] for it in read_job_bundle_parameters(str(tmp_path / "job"))}
    assert told["Shot"] == str(shot) and told["Out"] == str(show / "out")
    assert told["Config"] == config and told["Plates"] == str(show / "plates")
    files = listed(tmp_path / "job")
    assert files.input_filenames == {
        *(str(show / "plates" / f"plate.{frame}.exr") for frame in (1001, 1002, 1003)),
        *(str(show / "back drop" / f"clean.{frame}.exr") for frame in (1001, 1002, 1003)),
        *(str(show / name / "iris.png") for name in "ab"),
        *(str(tmp_path / "color" / name) for name in ("studio.ocio", "film.cube", "curve.cube")),
        str(shot),
    }
    assert files.output_directories == {str(show / "out")}
    assert openjd("check", tmp_path / "job" / "template.yaml").returncode == 0


def test_the_bundle_runs_here_as_it_is(capsys, tmp_path):
    shot = write_show(tmp_path / "show")
    bundled(capsys, tmp_path / "job", shot, "-o", tmp_path / "out" / "m.mov")
    values = f"file://{tmp_path / 'job' / 'parameters.json'}"
    run = openjd("run", tmp_path / "job" / "template.yaml", "-p", values)
    assert run.returncode == 0, run.stdout
    exported(capsys, shot, tmp_path / "whole.mov")
    assert (tmp_path / "out" / "m.mov").read_bytes() == (tmp_path / "whole.mov").read_bytes()
    assert list(files_in(tmp_path / "out")) == ["m.mov"]


def test_options_name_files_too(capsys, tmp_path):
    """Without a shot file the command line names them, and so it does on the other machine."""
    source = write_plates(tmp_path / "plates")
    image = write_opening(tmp_path / "a" / "iris.png", 6)
    lens = ("--focus-distance", 2, "--f-stop", 2, "--aperture-image", image, "--frames", 1001)
    words = ("--quality", "draft", *lens)
    exported(capsys, source, tmp_path / "whole" / "n.####.exr", *words)
    values = bundled(capsys, tmp_path / "job", source, "-o", tmp_path / "o" / "n.####.exr", *words)
    (tmp_path / "worker").mkdir()
    check_elsewhere(tmp_path, values, tmp_path / "plates", tmp_path / "a")


def test_frames_with_neighbours_are_those_of_the_whole_sequence(capsys, tmp_path):
    """Which frames tell of each other is chosen from all plates, so a machine needs them."""
    source = write_plates(tmp_path / "plates")
    shot = tmp_path / "s.heatlens.json"
    made = shot_of(source)
    write_shot(shot, replace(made, plate_options=replace(made.plate_options, neighbours=1)))
    words = ("--frames", "1003")
    exported(capsys, shot, tmp_path / "whole" / "n.####.exr", *words)
    values = bundled(capsys, tmp_path / "job", shot, "-o", tmp_path / "o" / "n.####.exr", *words)
    assert len(listed(tmp_path / "job").input_filenames) == 1 + len(FRAMES)
    (tmp_path / "worker").mkdir()
    check_elsewhere(tmp_path, values, tmp_path / "plates")


def test_a_scene_comes_with_what_it_refers_to(capsys, tmp_path):
    """Its files name each other by relative paths, so they keep their places to each other."""
    lib, sets = tmp_path / "show" / "lib", tmp_path / "show" / "sets"
    lib.mkdir(parents=True)
    sets.mkdir()
    (lib / "card.usda").write_text(CARD)
    (sets / "stage.usda").write_text(STAGE)
    words = ("--frames", "1", "--size", "32x18", "--f-stop", "2", "--focus-distance", "3")
    exported(capsys, sets / "stage.usda", tmp_path / "whole" / "n.####.exr", *words)
    out = tmp_path / "o" / "n.####.exr"
    values = bundled(capsys, tmp_path / "job", sets / "stage.usda", "-o", out, *words)
    assert set(values) == {"Plates", "Out"}
    (tmp_path / "worker").mkdir()
    check_elsewhere(tmp_path, values, tmp_path / "show")


def check_elsewhere(folder: Path, values: dict[str, str], *gone: Path) -> None:
    """Run the bundle with its listed files alone, and compare with `whole`."""
    there = elsewhere(folder / "job", values, folder / "worker")
    for path in gone:
        os.rename(path, folder / f"gone {path.name}")
    given = [word for name, value in there.items() for word in ("-p", f"{name}={value}")]
    run = openjd("run", folder / "job" / "template.yaml", *given)
    assert run.returncode == 0, run.stdout
    assert files_in(Path(there["Out"])) == files_in(folder / "whole")


def test_the_config_of_the_environment_is_an_input(capsys, tmp_path, monkeypatch):
    """Another machine may have none, or another one."""
    monkeypatch.setenv("OCIO", cube_config(tmp_path).source)
    source = write_plates(tmp_path / "plates")
    words = ("--focus-distance", 2, "--f-stop", 2, "-o", tmp_path / "o" / "n.####.png")
    values = bundled(capsys, tmp_path / "job", source, *words)
    assert values["Config"] == str(tmp_path / "studio.ocio")
    assert "--ocio={{Param.Config}}" in (tmp_path / "job" / "template.yaml").read_text()


def test_a_kit_of_this_machine_alone_is_refused(capsys, tmp_path, monkeypatch):
    kit = next(iter(kit_shelf().kits.values()))
    monkeypatch.setattr("heatlens.media.documents.lens_kits.kits_dir", lambda: tmp_path)
    (tmp_path / "mine.json").write_text(kit_text(replace(kit, name="mine")))
    lens = ("--lens-kit", f"mine:{kit.lenses[0].focal_length_mm:g}", "--focus-distance", 3)
    lens += ("--f-stop", 5.6, "--submit", "openjd", *QUICK)
    said = refused(capsys, write_plates(tmp_path / "plates"), tmp_path / "n.####.exr", *lens)
    assert "--lens-kit" in said and "shot new" in said
