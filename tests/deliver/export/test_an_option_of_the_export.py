"""Check that an option added to `ExportOptions` reaches help, jobs, panel and fingerprints.

Each test runs in a process of its own, in which `ExportOptions` has two more options before
anything else is imported: a tick for EXR, and a choice for pictures.
"""

import json
import subprocess
import sys
import textwrap
from pathlib import Path

import pytest

from heatlens.core.base.errors import InputError
from heatlens.core.model.view.guides import Guides
from heatlens.core.model.view.view import DisplayOptions
from heatlens.deliver.export.job import job_text, read_job
from heatlens.deliver.export.options import ExportOptions
from heatlens.fronts.commands.main import main
from support.other_values import with_all_fields_other

_BEGIN = """
from dataclasses import dataclass
from typing import Literal
from heatlens.deliver.export import options
from heatlens.core.model.option import option_field

@dataclass(frozen=True, kw_only=True)
class MoreOptions(options.ExportOptions):
    with_normals: bool = option_field(
        False, "with normals", "N beside the colour", group=options.EXR, label="normals beside it"
    )
    grain: Literal["none", "fine", "coarse"] = option_field(
        "none", "grain", "of the film", group=options.LOOK
    )

options.ExportOptions = MoreOptions

import sys
from pathlib import Path
folder = Path(sys.argv[1])
"""


def run_with_two_new_options(folder: Path, program: str) -> str:
    """Run `program` in a new process with the two added options. Return its standard output."""
    text = _BEGIN + textwrap.dedent(program)
    process = subprocess.run(
        [sys.executable, "-c", text, str(folder)], capture_output=True, text=True, check=False
    )
    assert process.returncode == 0, process.stderr
    return process.stdout


def test_help_and_job_include_new_export_options(tmp_path):
    out = run_with_two_new_options(
        tmp_path,
        """
        import argparse
        from heatlens.fronts.commands.export_options import add_export_options, make_export_job
        parser = argparse.ArgumentParser()
        parser.add_argument("shot")
        parser.add_argument("-o", "--output")
        add_export_options(parser)
        words = ["demo", "-o", str(folder / "n.####.exr"), "--frames", "1", "--f-stop", "2"]
        assert not make_export_job(parser.parse_args(words)).options.with_normals
        assert make_export_job(parser.parse_args([*words, "--with-normals"])).options.with_normals
        parser.print_help()
        """,
    )
    assert "--with-normals" in out and "N beside the colour" in out
    assert "--grain {none,fine,coarse}" in out


def test_export_panel_and_its_job_include_new_options(tmp_path):
    run_with_two_new_options(
        tmp_path,
        """
        import argparse
        from dataclasses import replace
        from imgui_bundle import imgui
        from heatlens.fronts.commands.export_options import add_export_options
        from heatlens.fronts.commands.options.field_options import fill_fields
        from heatlens.deliver.export.job import read_job
        from heatlens.core.model.view.view import DisplayOptions
        from heatlens.studio.settings.export_settings import ExportSettings
        from heatlens.studio.ui import widgets
        from heatlens.studio.ui.panels.export_panel import export_panel
        from heatlens.studio.ui.setting_places import SETTINGS
        assert {"normals beside it", "grain"} <= set(SETTINGS["Export"])
        imgui.create_context()
        io = imgui.get_io()
        io.set_ini_filename("")
        io.display_size = (800, 1600)
        io.backend_flags |= imgui.BackendFlags_.renderer_has_textures
        choice, checkbox = widgets.choice, imgui.checkbox
        widgets.choice = lambda words, *more: (
            choice(words, *more), "coarse" if words == "grain" else more[0])[1]
        imgui.checkbox = lambda words, value: (
            checkbox(words, value), (True, words == "normals beside it" or value))[1]
        for kind, name, value in (
            ("EXR (linear)", "with_normals", True), ("PNG (as displayed)", "grain", "coarse")):
            imgui.new_frame()
            imgui.begin("panel")
            settings, _ = export_panel(ExportSettings("/a", "b", kind), None, None)
            imgui.end()
            imgui.render()
            assert getattr(settings, name) == value
            (folder / "job.json").write_text(settings.job(DisplayOptions()))
            told = read_job(folder / "job.json")
            assert getattr(told[0], name) == value
            parser = argparse.ArgumentParser()
            add_export_options(parser)
            args = parser.parse_args([])
            for record in told:
                fill_fields(args, record)
            assert getattr(args, name) == value
        """,
    )


def test_fingerprint_depends_on_new_options_of_its_format(tmp_path):
    run_with_two_new_options(
        tmp_path,
        """
        from dataclasses import replace
        from heatlens.deliver.export.plan import fingerprint_of
        from heatlens.deliver.export.job import ExportJob
        from heatlens.deliver.export.output import parse_output
        from heatlens.core.model.lens.lens import Lens
        from heatlens.core.model.shot.shot import Shot
        from heatlens.render.source.named import source_of
        shot = Shot(Lens(50.0, 2.0, 2.0, 36.0), source="demo")
        def mark(name, **chosen):
            output, options = parse_output(folder / name), MoreOptions(**chosen)
            job = ExportJob(shot, (1,), output, options)
            return fingerprint_of(job, 1, shot.lens, source_of(shot).origin(shot, 1, "stop"))
        assert mark("a.exr") != mark("a.exr", with_normals=True)
        assert mark("a.exr") == mark("a.exr", grain="fine")
        assert mark("a.png") != mark("a.png", grain="fine")
        assert mark("a.png") == mark("a.png", with_normals=True)
        """,
    )


def test_job_file_keeps_every_field(tmp_path):
    options = with_all_fields_other(ExportOptions())
    look, guides = with_all_fields_other(DisplayOptions()), with_all_fields_other(Guides())
    (tmp_path / "job.json").write_text(job_text(options, look, guides))
    assert read_job(tmp_path / "job.json") == (options, look, guides)


@pytest.mark.parametrize(
    ("entry", "message"),
    [
        ({"options": {"compresion": "zip"}}, r"job\.json: options: .*compresion.*compression"),
        ({"options": {"compression": "zap"}}, r"job\.json: options.compression.*zap.*zip"),
        ({"looks": {}}, r"job\.json: .*looks"),
    ],
)
def test_read_job_names_place_of_damaged_entry(tmp_path, entry, message):
    (tmp_path / "job.json").write_text(json.dumps({"heatlens_export_job": 1, **entry}))
    with pytest.raises(InputError, match=message):
        read_job(tmp_path / "job.json")


def test_job_option_fills_options_and_typed_options_win(tmp_path, capsys):
    job = tmp_path / "job.json"
    job.write_text(
        job_text(ExportOptions(frames="2-3", burn_in=True), DisplayOptions(gamma=1.5), Guides(2.39))
    )
    words = ["export", "demo", "-o", str(tmp_path / "n.####.png"), "--f-stop", "2"]
    words += ["--submit", "openjd", "--chunk", "1", "--memory", "1", "--job", str(job)]
    assert main(words) == 0
    out = capsys.readouterr().out
    for word in ("--burn-in", "--gamma=1.5", "--matte=2.39", "--frames=2-3"):
        assert word in out
    assert str(job) not in out
    assert main([*words, "--frames", "7"]) == 0
    assert '"7"' in capsys.readouterr().out
