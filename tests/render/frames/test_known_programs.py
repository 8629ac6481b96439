"""Which programs the driver has built: remembered between starts, and new ones refused."""

import pytest

from heatlens.render.gpu import known_programs
from heatlens.render.gpu.known_programs import KnownPrograms, NewProgramError, ProgramsFile
from heatlens.render.gpu.shader_source import ShaderSource


def source(text: str) -> ShaderSource:
    return ShaderSource(text, ("a.comp.glsl",), {})


@pytest.fixture
def known(monkeypatch) -> KnownPrograms:
    monkeypatch.setattr(known_programs, "KNOWN_PROGRAMS", KnownPrograms())
    return known_programs.KNOWN_PROGRAMS


def test_refuse_new_raises_for_unknown_programs_alone(known):
    known.add([source("a")])
    with known.refuse_new():
        known.add([source("a")])
        with pytest.raises(NewProgramError, match=r"a\.comp\.glsl"):
            known.add([source("b")])
    known.add([source("b")])
    with known.refuse_new():
        known.add([source("b")])
    with known.refuse_new(refuses=False):
        known.add([source("c")])


def test_stages_of_a_program_are_known_in_their_order_alone(known):
    known.add([source("a"), source("b")])
    with known.refuse_new():
        for stages in (["b", "a"], ["ab"], ["a"]):
            with pytest.raises(NewProgramError):
                known.add([source(text) for text in stages])


def test_load_adds_what_was_saved_for_this_driver(known, monkeypatch, tmp_path, ctx):
    known.add([source("a")])
    ProgramsFile(tmp_path / "new", ctx).save()
    later = KnownPrograms()
    monkeypatch.setattr(known_programs, "KNOWN_PROGRAMS", later)
    ProgramsFile(tmp_path / "none", ctx).load()
    assert not later.digests
    ProgramsFile(tmp_path / "new", ctx).load()
    assert later.digests == known.digests


def test_save_in_a_folder_that_cannot_be_made_changes_nothing(known, tmp_path, ctx):
    (tmp_path / "file").write_bytes(b"")
    ProgramsFile(tmp_path / "file" / "below", ctx).save()
    assert (tmp_path / "file").read_bytes() == b""
