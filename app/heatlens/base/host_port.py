"""Split the text of a network address into host and port."""

from urllib.parse import urlsplit


def host_and_port(text: str) -> tuple[str, int | None]:
    """Split "HOST", "HOST:PORT" or ":PORT"; what is not given is "" or None.

    An IPv6 host stands in brackets. Raises ValueError for any other text.
    """
    parts = urlsplit(f"//{text.strip()}")
    if parts.path or parts.query or parts.fragment or parts.username is not None:
        raise ValueError(text)
    return parts.hostname or "", parts.port
