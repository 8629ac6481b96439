"""A server of the stream, for the tests of its protocol and its pictures."""

import pytest

from support.tev_peers import serving


@pytest.fixture
def server():
    with serving() as server:
        yield server
