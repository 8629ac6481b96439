"""The cards of the start screen: what is always there, and a recent file."""

from dataclasses import dataclass
from pathlib import Path

from heatlens.core.base.paths import home_dir
from heatlens.media.documents.shot_file import is_shot_file
from heatlens.media.scene.scene_read import DEMO
from heatlens.render.source.kinds import kind_of


@dataclass(frozen=True)
class Card:
    """A choice on the start screen.

    title    its name
    words    the line under the name
    text     the source to open, see FileCommands.open; None opens the file dialog
    kind     the kind of a recent file, in a word; "" for permanent choices
    picture  the name of a picture in assets/, or None
    """

    title: str
    words: str
    text: str | None
    kind: str = ""
    picture: str | None = None


def built_in_cards(still_life_path: str) -> tuple[Card, ...]:
    """Return the permanent choices; `still_life_path` is the file of the still life."""
    return (
        Card("Demo scene", "A street at night, made for focus", DEMO, picture="demo.webp"),
        Card(
            "Still life",
            "A plate: one frame with depth",
            still_life_path,
            picture="focus_fruit.png",
        ),
        Card("Open ...", "A plate, a sequence or a 3D scene", None),
    )


def recent_card(text: str) -> Card:
    """Return the card of a recent file, with its folder as the second line."""
    path, home = Path(text), home_dir()
    folder = path.parent
    is_in_home = folder.is_relative_to(home) and home != Path(home.anchor)
    words = str(Path("~") / folder.relative_to(home)) if is_in_home else str(folder)
    return Card(path.name, words, text, word_of(text))


def word_of(text: str) -> str:
    """Return the kind of a recent file in a word, judged by its name."""
    return "Shot" if is_shot_file(text) else kind_of(text).word(text)
