"""Which OpenGL contexts were made beside that of the run, and by which test."""

import os
from collections.abc import Callable
from typing import Any

import pytest

made: list[str] = []


def noted(make: Callable[..., Any]) -> Callable[..., Any]:
    """Return `make`, which then also notes the test that called it."""

    def make_and_note(*args: Any, **settings: Any) -> Any:
        made.append(os.environ.get("PYTEST_CURRENT_TEST", "between tests"))
        return make(*args, **settings)

    return make_and_note


def note_new(patch: pytest.MonkeyPatch) -> None:
    """Note every context that is made from now on."""
    import moderngl  # here: tests of the model need no OpenGL

    patch.setattr(moderngl, "create_context", noted(moderngl.create_context))


def list_unheld(device: Any) -> None:
    """Let the context list what OpenGL holds and Python does not."""
    device.raw.gc_mode = "context_gc"


def release_unheld(device: Any) -> None:
    """Release what was listed."""
    import moderngl

    unheld = device.raw.objects
    while unheld:
        thing = unheld.popleft()
        if not isinstance(thing, moderngl.InvalidObject):  # released by its owner before
            thing.release()
