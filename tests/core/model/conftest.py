"""Fixtures of the model's tests, which neither draw nor need OpenGL."""

import pytest


@pytest.fixture(scope="session", autouse=True)
def command_context() -> None:
    """Replace the fixture of the same name, which makes an OpenGL context."""
