"""Draw the icon of the program in pixels, from the one drawing of it: `studio/web/icon.svg`.

The drawing consists of rectangles and circles with fill, stroke and opacity.
"""

from importlib import resources
from xml.etree import ElementTree

from PIL import Image, ImageDraw

_FINER = 8  # the shapes are drawn so much larger, which smooths their edges


def icon_svg() -> bytes:
    """Return the drawing, which the page in browsers shows too."""
    return (resources.files("heatlens.studio") / "web" / "icon.svg").read_bytes()


def icon(size_px: int) -> Image.Image:
    """Return the icon as a square RGBA picture."""
    root = ElementTree.fromstring(icon_svg())
    scale = size_px * _FINER / float(root.attrib["viewBox"].split()[2])
    picture = Image.new("RGBA", (size_px * _FINER, size_px * _FINER))
    for shape in root:
        layer = Image.new("RGBA", picture.size)
        _draw_shape(ImageDraw.Draw(layer), shape, scale)
        opacity = float(shape.get("opacity", 1))
        layer.putalpha(layer.getchannel("A").point([round(opacity * a) for a in range(256)]))
        picture = Image.alpha_composite(picture, layer)
    return picture.resize((size_px, size_px), Image.Resampling.BOX)


def _draw_shape(draw: ImageDraw.ImageDraw, shape: ElementTree.Element, scale: float) -> None:
    """Draw a rectangle or a circle, enlarged by `scale`."""
    fill, stroke = (
        None if (color := shape.get(name, "none")) == "none" else color
        for name in ("fill", "stroke")
    )

    def length(name: str) -> float:
        return float(shape.get(name, 0)) * scale

    if shape.tag.endswith("rect"):
        corner = length("width") - 1, length("height") - 1
        draw.rounded_rectangle((0, 0, *corner), length("rx"), fill)
        return
    line_width = length("stroke-width")
    radius = length("r") + line_width / 2
    draw.circle((length("cx"), length("cy")), radius, fill, stroke, round(line_width))
