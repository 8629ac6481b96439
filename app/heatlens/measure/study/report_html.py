"""A report as one page: no script, nothing from elsewhere, its pictures beside it."""

from html import escape
from urllib.parse import quote

from heatlens import __version__
from heatlens.measure.study.chart import chart_svg
from heatlens.measure.study.crops import flip_inside
from heatlens.measure.study.measured import Row
from heatlens.measure.study.pictures import REFERENCE, SHARP, crop_name, whole_pictures
from heatlens.measure.study.report import Report
from heatlens.measure.study.style import STYLE
from heatlens.model.boxes import Box
from heatlens.plate.plate import FloatImage


def report_html(report: Report) -> str:
    """The whole page, valid HTML 5; every name in it is escaped."""
    title = escape(report.title)
    parts = [_head(report), _table(report), _time(report), _places(report), _methods(report)]
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{title}, ways to blur it</title>\n<style>\n{STYLE}\n</style>\n</head>\n"
        f"<body>\n<main>\n{''.join(parts)}{_foot(report)}</main>\n</body>\n</html>\n"
    )


def duration(seconds: float) -> str:
    """Three digits: 812 ms, 1.24 s."""
    if seconds < 0.9995:
        return f"{1e3 * seconds:.3g} ms"
    return f"{seconds:.3g} s" if seconds < 999.5 else f"{seconds:.0f} s"


def _head(report: Report) -> str:
    facts = "".join(
        f"<div><dt>{escape(label)}</dt><dd>{escape(value)}</dd></div>\n"
        for label, value in report.facts
    )
    return (
        f'<p class="eyebrow">Depth of field, method by method</p>\n'
        f"<h1>{escape(report.title)}</h1>\n"
        f'<p class="finding">{_finding(report)}</p>\n{_warnings(report)}'
        f'<dl class="facts">\n{facts}</dl>\n'
    )


def _finding(report: Report) -> str:
    """The result in a sentence or two."""
    best, quickest = report.best, min(report.rows, key=lambda row: row.seconds)
    what = "the truth" if report.reference.is_truth else escape(report.reference.name)
    words = (
        f"Nearest to {what}: <b>{escape(str(best.method))}</b>, FLIP {best.scores.flip:.4f}, "
        f"in {duration(best.seconds)}."
    )
    if quickest is best:
        return f"{words} Nothing here is quicker."
    return (
        f"{words} The quickest, {escape(str(quickest.method))}, takes "
        f"{duration(quickest.seconds)} at FLIP {quickest.scores.flip:.4f}."
    )


def _warnings(report: Report) -> str:
    said = [f"{sentence}" for sentence in report.left_out]
    if not report.reference.is_truth:
        said.insert(
            0,
            f"There is no truth here. Everything is held against {report.reference.name}, which "
            "is one of the methods: numbers say how alike the methods are, not which is right.",
        )
    return "".join(f'<p class="warning">{escape(sentence)}</p>\n' for sentence in said)


def _table(report: Report) -> str:
    worst = max(row.scores.flip for row in report.rows) or 1.0
    rows = "".join(_table_row(row, worst, row is report.best) for row in report.rows)
    heads = ("Method", "FLIP, mean", "PSNR", "SSIM", "HDR-FLIP", "relMSE", "Time of a frame")
    head = "".join(f'<th scope="col">{name}</th>' for name in heads)
    return (
        '<h2>Results</h2>\n<p class="soft">Sorted by FLIP, what an eye sees flipping between a '
        f"picture and the {_reference_word(report)}: 0 is the same, 1 the worst. "
        f"{escape(report.reference.note)}</p>\n"
        f'<div class="wide"><table>\n<thead><tr>{head}</tr></thead>\n<tbody>\n{rows}</tbody>\n'
        "</table></div>\n"
    )


def _table_row(row: Row, worst: float, is_best: bool) -> str:
    s, name = row.scores, escape(str(row.method))
    detail = f"<span>{escape(row.detail)}</span>" if row.detail else ""
    bar = f'<span class="bar"><i style="width:{100 * s.flip / worst:.1f}%"></i></span>'
    cells = (f"{s.psnr_db:.2f} dB", f"{s.ssim:.4f}", f"{s.flip_hdr:.4f}", f"{s.relmse:.5f}")
    return (
        f'<tr class="{"best" if is_best else "other"}">'
        f'<td><a href="#{name}">{name}</a>{detail}</td>'
        f'<td class="flip">{bar}<b>{s.flip:.4f}</b></td>'
        f"{''.join(f'<td>{cell}</td>' for cell in cells)}<td>{duration(row.seconds)}</td></tr>\n"
    )


def _time(report: Report) -> str:
    most = max(row.runs for row in report.rows)
    frames = f"the median of up to {most} frames" if most > 1 else "that of one frame"
    few = "; of the slowest it is that of the first" if any(not r.runs for r in report.rows) else ""
    return (
        '<h2>Error and time</h2>\n<p class="soft">Low is right, left is quick. Each time is '
        f"{frames} after a warm-up{few}, on {escape(report.machine)}, at "
        f"{report.size[0]} × {report.size[1]} pixels.</p>\n"
        f'<div class="wide">{chart_svg(report.rows, report.best)}</div>\n'
    )


def _places(report: Report) -> str:
    frames = "".join(_frame(box, place, report) for place, box in enumerate(report.crops, 1))
    shown = "".join(_place(report, box, place) for place, box in enumerate(report.crops, 1))
    return (
        "<h2>The same places, side by side</h2>\n"
        '<p class="soft">Where the best and the worst method differ most, pixel for pixel.</p>\n'
        f'<figure class="map">{_image(report, REFERENCE + ".png", _reference_title(report))}'
        f"{frames}</figure>\n{shown}"
    )


def _frame(box: Box, place: int, report: Report) -> str:
    """A crop's outline on the whole picture, a link to the crops."""
    width, height = report.size
    at = {
        "left": box.x0 / width,
        "top": box.y0 / height,
        "width": box.width / width,
        "height": box.height / height,
    }
    style = ";".join(f"{name}:{100 * share:.3f}%" for name, share in at.items())
    return f'<a href="#place-{place}" style="{style}"><b>{place}</b></a>'


def _place(report: Report, box: Box, place: int) -> str:
    figures = "".join(
        _crop(report, what, light, place, box) for what, light in whole_pictures(report)
    )
    return (
        f'<h3 class="place" id="place-{place}">Place {place} '
        f'<span class="soft">{box.width} × {box.height} pixels at ({box.x0}, {box.y0})</span></h3>'
        f'\n<div class="crops" style="--columns:{figures.count("<figure")}">\n{figures}</div>\n'
    )


def _crop(report: Report, what: str, light: FloatImage, place: int, box: Box) -> str:
    titles = {REFERENCE: _reference_title(report), SHARP: "before the lens"}
    title = escape(titles.get(what, what))
    image = (
        f'<img src="{quote(crop_name(what, place))}" width="{box.width}" height="{box.height}" '
        f'loading="lazy" alt="{title}, place {place}">'
    )
    kind = ' class="is-reference"' if what == REFERENCE else ""
    flip = flip_inside(light, report.reference.pixels, box)
    below = "" if what == REFERENCE else f"<br>FLIP here {flip:.3f}"
    return f"<figure{kind}>{image}<figcaption><b>{title}</b>{below}</figcaption></figure>\n"


def _methods(report: Report) -> str:
    word = _reference_word(report)
    sections = "".join(_method(report, row) for row in report.rows)
    return (
        f'<h2>Method by method</h2>\n<p class="soft">Hold the pointer on a picture to see the '
        f"{word} in its place.</p>\n{sections}"
    )


def _method(report: Report, row: Row) -> str:
    name, s = str(row.method), row.scores
    broken = f", {s.nonfinite} pixels of NaN or infinity" if s.nonfinite else ""
    facts = (
        f"FLIP {s.flip:.4f}, PSNR {s.psnr_db:.2f} dB, SSIM {s.ssim:.4f}, "
        f"{duration(row.seconds)}{broken}"
    )
    under = _image(report, f"{REFERENCE}.png", _reference_title(report), "over")
    picture = f'<div class="flips" tabindex="0">{_image(report, f"{name}.png", name)}{under}</div>'
    difference = _image(report, f"{name}-difference.png", f"difference of {name}")
    flip = _image(report, f"{name}-flip.png", f"FLIP of {name}")
    return (
        f'<section class="method" id="{escape(name)}">\n<header><h3>{escape(name)}</h3>'
        f'<span class="soft">{escape(facts)}</span></header>\n<div class="three">\n'
        f"<figure>{picture}<figcaption>The picture</figcaption></figure>\n"
        f"<figure>{difference}<figcaption>The difference, {report.gain:g} times brighter than it "
        f"is</figcaption></figure>\n"
        f"<figure>{flip}<figcaption>FLIP, from black for none to yellow</figcaption></figure>\n"
        "</div>\n</section>\n"
    )


def _image(report: Report, file: str, alt: str, css: str = "") -> str:
    width, height = report.size
    kind = f' class="{css}"' if css else ""
    return (
        f'<img{kind} src="{quote(file)}" width="{width}" height="{height}" loading="lazy" '
        f'alt="{escape(alt)}">'
    )


def _reference_word(report: Report) -> str:
    return "truth" if report.reference.is_truth else "reference"


def _reference_title(report: Report) -> str:
    return "truth" if report.reference.is_truth else report.reference.name


def _foot(report: Report) -> str:
    return (
        '<footer class="soft">\n<p>PSNR, SSIM and FLIP (Andersson et al. 2020) look at the sRGB '
        "picture at exposure 0, HDR-FLIP (Andersson et al. 2021) and relMSE at the light.</p>\n"
        f"<p>heatlens {escape(__version__)}. The numbers for machines are in "
        '<a href="study.json">study.json</a>.</p>\n</footer>\n'
    )
