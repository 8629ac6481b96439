"""Record which tests create OpenGL contexts beside the one of the test run."""

import os
from collections.abc import Callable
from typing import Any

import pytest

contexts_made: list[str] = []


def record_calls(make: Callable[..., Any]) -> Callable[..., Any]:
    """Return a wrapper of `make` that also records the test that called it."""

    def make_and_note(*args: Any, **settings: Any) -> Any:
        contexts_made.append(os.environ.get("PYTEST_CURRENT_TEST", "between tests"))
        return make(*args, **settings)

    return make_and_note


def record_new_contexts(patch: pytest.MonkeyPatch) -> None:
    """Record every OpenGL context that is created from now on."""
    import moderngl  # here: tests of the model need no OpenGL

    patch.setattr(moderngl, "create_context", record_calls(moderngl.create_context))


def list_unheld(device: Any) -> None:
    """Let the context list OpenGL objects that Python no longer refers to."""
    from heatlens.render.gpu.opengl.gl_device import GlDevice

    if isinstance(device, GlDevice):
        device.raw.gc_mode = "context_gc"


def release_unheld(device: Any) -> None:
    """Release the listed OpenGL objects."""
    from heatlens.render.gpu.opengl.gl_device import GlDevice

    if not isinstance(device, GlDevice):
        return
    import moderngl

    unheld = device.raw.objects
    while unheld:
        thing = unheld.popleft()
        if not isinstance(thing, moderngl.InvalidObject):  # released by its owner before
            thing.release()
