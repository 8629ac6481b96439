"""Ask the system how much memory is free."""

from pathlib import Path

_FACTS = Path("/proc/meminfo")


def free_memory_bytes() -> int | None:
    """Return the bytes that Linux could give without swapping; None if they are unknown."""
    try:
        facts = dict(line.split(":", 1) for line in _FACTS.read_text("ascii").splitlines())
        return int(facts["MemAvailable"].split()[0]) * 1024
    except (OSError, KeyError, ValueError):  # not Linux, or an old version of it
        return None
