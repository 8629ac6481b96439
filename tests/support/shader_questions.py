"""Ask functions of a shader library on the GPU, to compare them with those on the processor."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from heatlens.core.base.paths import data_dir
from heatlens.render.gpu.device import Device
from heatlens.render.gpu.resources import Texture
from heatlens.render.gpu.shader_source import assemble, declared_in

_GROUP = 64
_BLOCKS = f"""
layout(local_size_x = {_GROUP}) in;
layout(std430) readonly buffer question_block {{ vec4 questions[]; }};
layout(std430) writeonly buffer answer_block {{ vec4 answers[]; }};
"""


class ShaderQuestions:
    """A compute shader that answers questions, a vec4 each, with functions of a library."""

    def __init__(
        self,
        ctx: Device,
        library: str,
        main: str,
        defines: Mapping[str, int],
        answers: int = 1,
    ) -> None:
        """Compile `main`, which writes `answers` times vec4 to `answers[]` for each question."""
        self._ctx = ctx
        self._answers = answers
        source = assemble(data_dir("shaders"), library, dict(defines))
        source = source.append_functions(_BLOCKS + main)
        self._declared = declared_in([source]).of_kind("uniform")
        self._program = ctx.compute_program(source)

    def ask(
        self,
        questions: NDArray[np.float64],
        uniforms: Mapping[str, object],
        textures: Mapping[str, Texture] | None = None,
    ) -> NDArray:
        """Return (n, answers, 4) for questions (n, 4); uniforms without use are left out."""
        question_buffer = self._ctx.buffer(questions.astype(np.float32).tobytes())
        answer_buffer = self._ctx.buffer(reserve=16 * self._answers * len(questions))
        blocks = {"question_block": question_buffer, "answer_block": answer_buffer}
        declared_uniforms = {
            name: value for name, value in uniforms.items() if name in self._declared
        }
        self._program.bind(textures, None, blocks, declared_uniforms)
        self._program.run((-(-len(questions) // _GROUP),))
        answers = np.frombuffer(answer_buffer.read(), np.float32).reshape(-1, self._answers, 4)
        question_buffer.release()
        answer_buffer.release()
        return answers.astype(np.float64)

    def release(self) -> None:
        """Release the program."""
        self._program.release()
