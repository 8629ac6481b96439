"""What several tests of sessions without a window begin with."""

import pytest

from support.takes import session_with_walls


@pytest.fixture
def messages() -> list[str]:
    return []


@pytest.fixture(scope="module")
def shared_session(tmp_path_factory):
    with session_with_walls(tmp_path_factory.mktemp("walls")) as session:
        yield session
