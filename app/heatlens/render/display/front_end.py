"""Who looks at the pictures: what a session needs to know of the front end that shows it."""

from collections.abc import Callable
from dataclasses import dataclass

from heatlens.render.display.screen_pictures import ScreenPictures


@dataclass(frozen=True, eq=False)
class FrontEnd:
    """A front end; without values, nobody looks at the session.

    wake          makes its loop turn; threads call it
    screen        the pictures on its screen; None without one
    has_window    a window or a page shows the pictures, so the user waits for them
    other_holder  takes the lens for its user; returns the name of another user who has it; "" if
                  nobody else has
    """

    wake: Callable[[], None] = lambda: None
    screen: ScreenPictures | None = None
    has_window: bool = False
    other_holder: Callable[[], str] = lambda: ""
