"""Render HTML 5 pages from templates beside the code; all values are escaped."""

from collections.abc import Callable, Mapping
from pathlib import Path

from heatlens.base.extras import import_extra


def check_pages(purpose: str) -> None:
    """Raise InputError that begins with `purpose` if the package for pages is missing."""
    import_extra("jinja2", purpose, "study")


def page_of(
    purpose: str,
    template: Path,
    values: Mapping[str, object],
    filters: Mapping[str, Callable[..., object]] | None = None,
) -> str:
    """Return the page of a template with these values; a missing value is an error.

    Raises InputError if the package for pages is not installed.
    """
    jinja2 = import_extra("jinja2", purpose, "study")
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(template.parent),
        undefined=jinja2.StrictUndefined,
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters |= dict(filters or {})
    return str(environment.get_template(template.name).render(values))
