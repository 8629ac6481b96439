"""Lines of text on the things that a Cryptomatte names."""

_MOST_LISTED_THINGS = 20


def thing_lines(things: dict[str, list[str]]) -> list[tuple[str, str]]:
    """Return a line for each Cryptomatte: how many things it names, and the first of them."""
    lines = []
    for layer, names in things.items():
        first_names = ", ".join(names[:_MOST_LISTED_THINGS])
        unlisted_count = len(names) - _MOST_LISTED_THINGS
        names_text = (
            f"{first_names} and {unlisted_count} more (--json lists all)"
            if unlisted_count > 0
            else first_names
        )
        lines.append(
            ("things", f"{len(names)} in {layer}: {names_text or 'its manifest is missing'}")
        )
    return lines
