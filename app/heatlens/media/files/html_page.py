"""Render HTML 5 pages from templates beside the code, with all values escaped, and PDF of them."""

from collections.abc import Callable, Mapping
from pathlib import Path
from types import ModuleType

from heatlens.core.base.errors import InputError
from heatlens.core.base.extras import import_extra
from heatlens.core.base.outside_text import one_line


def check_pdf(purpose: str) -> None:
    """Raise InputError that begins with `purpose` if what makes a PDF is missing."""
    _import_weasyprint(purpose)


def _import_weasyprint(purpose: str) -> ModuleType:
    """Import WeasyPrint. Raises InputError that begins with `purpose` if it is unusable."""
    try:
        return import_extra("weasyprint", f"{purpose} as PDF")
    except OSError as error:
        raise InputError(
            f"{purpose} as PDF needs the library Pango ({one_line(error)}); Debian calls its "
            "package libpango-1.0-0. A page in HTML needs none."
        ) from error


def render_pdf(purpose: str, page: str) -> bytes:
    """Return an HTML page as PDF; its pictures must be embedded, because nothing is fetched.

    Raises InputError if the package for PDF is missing.
    """
    library = _import_weasyprint(purpose)
    embedded_only = library.URLFetcher(allowed_protocols=("data",))
    pdf: bytes = library.HTML(string=page, url_fetcher=embedded_only).write_pdf()
    return pdf


def render_page(
    template: Path,
    values: Mapping[str, object],
    filters: Mapping[str, Callable[..., object]] | None = None,
) -> str:
    """Return the page of a template with these values; a missing value is an error."""
    import jinja2  # here, because few commands make pages

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
