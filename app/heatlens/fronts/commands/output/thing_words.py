"""Words on the things that a Cryptomatte names."""

_THINGS_TOLD = 20


def thing_lines(things: dict[str, list[str]]) -> list[tuple[str, str]]:
    """Return a line for each Cryptomatte: how many things it names, and the first of them."""
    lines = []
    for layer, names in things.items():
        first, more = ", ".join(names[:_THINGS_TOLD]), len(names) - _THINGS_TOLD
        about = f"{first} and {more} more (--json lists all)" if more > 0 else first
        lines.append(("things", f"{len(names)} in {layer}: {about or 'its manifest is missing'}"))
    return lines
