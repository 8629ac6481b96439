"""Which programs the driver has built, and that new ones are refused."""

import pytest

from heatlens.render.gpu.known_programs import KnownPrograms, NewProgramError
from heatlens.render.gpu.shader_source import ShaderSource


def source(text: str) -> ShaderSource:
    return ShaderSource(text, ("a.comp.glsl",), {})


@pytest.fixture
def known() -> KnownPrograms:
    return KnownPrograms()


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
