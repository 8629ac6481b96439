"""Words on the things that a Cryptomatte names."""

_THINGS_TOLD = 20


def thing_lines(things: dict[str, list[str]]) -> list[tuple[str, str]]:
    """Return a line for each Cryptomatte: how many things it names, and the first of them."""
    lines = []
    for layer, names in things.items():
        told, more = ", ".join(names[:_THINGS_TOLD]), len(names) - _THINGS_TOLD
        about = f"{told} and {more} more (--json lists all)" if more > 0 else told
        lines.append(("things", f"{len(names)} in {layer}: {about or 'its manifest is missing'}"))
    return lines
