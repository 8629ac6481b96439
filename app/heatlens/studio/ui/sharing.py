"""Share the session of the window: its links in a popup, who is here in the menu bar."""

from collections import deque
from collections.abc import Callable

from imgui_bundle import ImVec2, imgui

from heatlens.core.base.errors import HeatlensError
from heatlens.studio.board.board import Board
from heatlens.studio.session.session import Session
from heatlens.studio.share.address import Role
from heatlens.studio.share.shared import WINDOW
from heatlens.studio.share.sharing import Sharing, squares_of
from heatlens.studio.share.tap import Seen, Tap
from heatlens.studio.ui import probe, texts, theme, widgets
from heatlens.studio.ui.picture.grid import Pictures

_POPUP = "Share with a tablet"
_WORDS = {Role.HAND: "This link turns the lens:", Role.LOOK: "This one may only look:"}
_SQUARE_EM = 0.34
_FRAMES_FIRST = 8  # of a window, which close popups when they arrange the panels
_NEWS_S = 0.5  # longest time until the menu bar tells that a hand rests


class WindowSharing:
    """The sharing of the window's session, and its place in the interface."""

    def __init__(
        self, session: Session, board: Board, sharing: Sharing, wake: Callable[[], None]
    ) -> None:
        """Prepare it; threads call `wake` when a page has said something."""
        self._session = session
        self.sharing = sharing
        self._board = board
        self._tap = Tap(session, self._board, sharing.shared)
        self._news: deque[str] = deque()  # of the server's thread
        self._is_following, self._opens = False, sharing.is_on
        sharing.shared.wake = wake
        session.editing.may_turn = self._may_turn

    def ask(self) -> None:
        """Share, and show the links."""
        try:
            if not self.sharing.is_on:
                self.sharing.begin(self._news.append)
            self._opens = True
        except HeatlensError as error:
            self._session.say_error(error)

    def _may_turn(self) -> bool:
        """Return True unless a page has the lens, and say that it does."""
        hands = self.sharing.shared.hands
        if self._is_following or not self.sharing.is_on or hands.take(WINDOW):
            return True
        self._session.messages.say(f"{hands.holder} has the lens.")
        return False

    # Called by the loop

    def follow(self) -> bool:
        """Do what the pages ask; return True if there was anything."""
        while self._news:
            self._session.messages.say(self._news.popleft())
        self._is_following = True
        try:
            return self.sharing.shared.follow(self._board)
        finally:
            self._is_following = False

    def publish(self, pictures: Pictures | None, transform_version: int) -> None:
        """Give the picture of the window to the pages."""

        def seen() -> Seen | None:
            if pictures is None:
                return None
            windows = pictures.data_window, pictures.display_window
            return Seen(pictures.a, *windows, pictures.detail, pictures.overlay)

        self._tap.publish(self._tap.key(transform_version), seen)

    def seconds_until_needed(self) -> float | None:
        """Return the seconds that the loop may sleep."""
        is_held = self.sharing.is_on and self.sharing.shared.hands.holder
        waits = (self._tap.seconds_until_needed(), _NEWS_S if is_held else None)
        return min((wait for wait in waits if wait is not None), default=None)

    # Drawing

    def draw_in_menu_bar(self) -> None:
        """Draw who is here at the right of the menu bar, and a button that ends the sharing."""
        if not self.sharing.is_on:
            return
        words, style = self.sharing.who(), imgui.get_style()
        width = sum(imgui.calc_text_size(it).x for it in (words, "End"))
        width += 4 * style.frame_padding.x + 2 * style.item_spacing.x
        imgui.same_line(max(imgui.get_window_width() - width, imgui.get_cursor_pos_x()))
        with texts.colored(theme.colors.live):
            if widgets.small_button(f"{words}###shared", "shared"):
                self._opens = True
        if widgets.small_button("End###end sharing", "end sharing"):
            self.sharing.end()

    def draw_popup(self) -> None:
        """Draw the popup with the links and the code to scan."""
        if self._opens and imgui.get_frame_count() > _FRAMES_FIRST:
            self._opens = False
            imgui.open_popup(_POPUP)
        center = imgui.get_main_viewport().get_center()
        imgui.set_next_window_pos(center, imgui.Cond_.appearing, ImVec2(0.5, 0.5))
        if not imgui.begin_popup(_POPUP):
            return
        for role, words in (
            (Role.HAND, "This link turns the lens:"),
            (Role.LOOK, "This one looks:"),
        ):
            imgui.text(words)
            link = self.sharing.link(role)
            texts.colored_text(link, theme.colors.live)
            imgui.same_line()
            if widgets.small_button(f"Copy###copy {role}", f"copy {role}"):
                imgui.set_clipboard_text(link)
        _draw_code(squares_of(self.sharing.link(Role.HAND)))
        imgui.text("Scan it with the camera of a tablet that reaches this machine.")
        texts.grey_text("`heatlens view --share 192.168.1.20` shares beyond this machine.")
        if widgets.button("End sharing", "end"):
            self.sharing.end()
            imgui.close_current_popup()
        probe.note("share popup")
        imgui.end_popup()


def _draw_code(rows: tuple[tuple[bool, ...], ...]) -> None:
    """Draw a QR code, dark on light in every theme."""
    side = _SQUARE_EM * imgui.get_font_size()
    corner, draw = imgui.get_cursor_screen_pos(), imgui.get_window_draw_list()
    size = ImVec2(side * len(rows), side * len(rows))
    end = ImVec2(corner.x + size.x, corner.y + size.y)
    draw.add_rect_filled(corner, end, theme.packed((1.0, 1.0, 1.0, 1.0)))
    for y, row in enumerate(rows):
        for x, is_dark in enumerate(row):
            if is_dark:
                first = ImVec2(corner.x + x * side, corner.y + y * side)
                last = ImVec2(first.x + side, first.y + side)
                draw.add_rect_filled(first, last, theme.packed((0.0, 0.0, 0.0, 1.0)))
    imgui.dummy(size)
    probe.note("share code")
