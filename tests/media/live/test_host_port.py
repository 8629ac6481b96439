"""Test network addresses: host and port are parsed, and nothing else is accepted."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from heatlens.core.base.outside_text import host_and_port

_V4 = st.ip_addresses(v=4).map(str)
_V6 = st.ip_addresses(v=6).map(str)
_PORTS = st.none() | st.integers(0, 65535)


def _port_suffix(port: int | None) -> str:
    return "" if port is None else f":{port}"


@given(st.just("") | _V4 | st.just("stage-2.local"), _PORTS)
def test_host_and_port_parses_written_address(host: str, port: int | None) -> None:
    assert host_and_port(f" {host}{_port_suffix(port)} ") == (host, port)


@given(_V6, _PORTS)
def test_host_and_port_parses_ipv6_host_in_brackets(host: str, port: int | None) -> None:
    assert host_and_port(f"[{host}]{_port_suffix(port)}") == (host, port)


@pytest.mark.parametrize(
    "text",
    ["::1", "a:b", "a:65536", "a:-1", "a:\u0668", "a/b", "a?b", "a#b", "me@a", "[a", "a:1:2"],
)
def test_host_and_port_rejects_malformed_address(text: str) -> None:
    with pytest.raises(ValueError, match=r"."):
        host_and_port(text)
