"""Record the calls of a function or a method, which runs as before."""

from typing import Any

import pytest


def watch_calls(
    monkeypatch: pytest.MonkeyPatch, owner: object, name: str
) -> list[tuple[object, ...]]:
    """Return a list to which each call of `owner.name` adds its positional arguments."""
    calls: list[tuple[object, ...]] = []
    original = getattr(owner, name)

    def record_and_call(*arguments: Any, **keywords: Any) -> Any:
        calls.append(arguments)
        return original(*arguments, **keywords)

    monkeypatch.setattr(owner, name, record_and_call)
    return calls
