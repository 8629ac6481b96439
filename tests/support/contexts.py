"""Which OpenGL contexts were made beside that of the run, and by which test."""

import os
from collections.abc import Callable
from typing import Any

made: list[str] = []


def noted(make: Callable[..., Any]) -> Callable[..., Any]:
    """Return `make`, which then also notes the test that called it."""

    def make_and_note(*args: Any, **settings: Any) -> Any:
        made.append(os.environ.get("PYTEST_CURRENT_TEST", "between tests"))
        return make(*args, **settings)

    return make_and_note
