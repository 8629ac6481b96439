"""Share the session of the window: a popup with its links, and its users in the menu bar."""

from collections import deque

from imgui_bundle import ImVec2, imgui

from heatlens.core.base.errors import HeatlensError
from heatlens.studio.board.board import Board
from heatlens.studio.board.session import Session
from heatlens.studio.share.address import Role
from heatlens.studio.share.session_publisher import DisplayedPicture, SessionPublisher
from heatlens.studio.share.sharing import Sharing, qr_code_rows
from heatlens.studio.ui import rects, texts, theme, widgets
from heatlens.studio.ui.picture.grid import Pictures

_POPUP = "Share with a tablet"
_WORDS = {Role.HAND: "This link turns the lens:", Role.LOOK: "This one looks:"}
_SQUARE_EM = 0.34
_STARTUP_FRAMES = 8  # first frames of a window, which close popups when they arrange the panels
_UPDATE_S = 0.5  # longest time until the menu bar shows that a user has released the lens


class WindowSharing:
    """The sharing of the window's session, and its place in the interface."""

    def __init__(self, session: Session, board: Board, sharing: Sharing) -> None:
        """Prepare the sharing."""
        self._session = session
        self.sharing = sharing
        self._board = board
        self._publisher = SessionPublisher(session, self._board, sharing.shared)
        self._server_messages: deque[str] = deque()  # messages of the server's thread
        self._opens_popup = sharing.is_on

    def share(self) -> None:
        """Share, and show the links."""
        try:
            if not self.sharing.is_on:
                self.sharing.begin(self._server_messages.append)
            self._opens_popup = True
        except HeatlensError as error:
            self._session.show_error(error)

    # Called by the loop

    def run_requests(self) -> bool:
        """Run the requests of the pages; return True if there were any."""
        while self._server_messages:
            self._session.messages.notify(self._server_messages.popleft())
        return self.sharing.shared.follow_messages(self._board)

    def publish(self, pictures: Pictures | None, transform_version: int) -> None:
        """Give the picture of the window to the pages."""

        def shared_picture() -> DisplayedPicture | None:
            """Return what the window shows, for pages."""
            if pictures is None:
                return None
            windows = pictures.data_window, pictures.display_window
            return DisplayedPicture(pictures.a, *windows, pictures.detail, pictures.overlay)

        self._publisher.publish(self._publisher.key(transform_version), shared_picture)

    def seconds_until_needed(self) -> float | None:
        """Return the seconds that the loop may sleep; None for as long as it likes."""
        has_holder = self.sharing.is_on and self.sharing.shared.hands.holder
        waits_s = (self._publisher.seconds_until_needed(), _UPDATE_S if has_holder else None)
        return min((wait_s for wait_s in waits_s if wait_s is not None), default=None)

    # Drawing

    def draw_in_menu_bar(self) -> None:
        """Draw the users at the right of the menu bar, and a button that ends the sharing."""
        if not self.sharing.is_on:
            return
        users, style = self.sharing.clients_text(), imgui.get_style()
        width = sum(imgui.calc_text_size(text).x for text in (users, "End"))
        width += 4 * style.frame_padding.x + 2 * style.item_spacing.x
        imgui.same_line(max(imgui.get_window_width() - width, imgui.get_cursor_pos_x()))
        with texts.colored(theme.colors.live):
            if widgets.small_button(f"{users}###shared", "shared"):
                self._opens_popup = True
        if widgets.small_button("End###end sharing", "end sharing"):
            self.sharing.end()

    def draw_popup(self) -> None:
        """Draw the popup with the links and the code to scan."""
        if self._opens_popup and imgui.get_frame_count() > _STARTUP_FRAMES:
            self._opens_popup = False
            imgui.open_popup(_POPUP)
        center = imgui.get_main_viewport().get_center()
        imgui.set_next_window_pos(center, imgui.Cond_.appearing, ImVec2(0.5, 0.5))
        if not imgui.begin_popup(_POPUP):
            return
        for role, words in _WORDS.items():
            imgui.text(words)
            link = self.sharing.link(role)
            texts.colored_text(link, theme.colors.live)
            imgui.same_line()
            if widgets.small_button(f"Copy###copy {role}", f"copy {role}"):
                imgui.set_clipboard_text(link)
        _draw_code(qr_code_rows(self.sharing.link(Role.HAND)))
        imgui.text("Scan it with the camera of a tablet that reaches this machine.")
        texts.gray_text("`heatlens view --share 192.168.1.20` shares beyond this machine.")
        if widgets.button("End sharing", "end"):
            self.sharing.end()
            imgui.close_current_popup()
        rects.note("share popup")
        imgui.end_popup()


def _draw_code(rows: tuple[tuple[bool, ...], ...]) -> None:
    """Draw a QR code, dark on light in every theme."""
    square_px = _SQUARE_EM * imgui.get_font_size()
    corner, draw = imgui.get_cursor_screen_pos(), imgui.get_window_draw_list()
    size = ImVec2(square_px * len(rows), square_px * len(rows))
    end = ImVec2(corner.x + size.x, corner.y + size.y)
    draw.add_rect_filled(corner, end, theme.pack_color((1.0, 1.0, 1.0, 1.0)))
    for y, row in enumerate(rows):
        for x, is_dark in enumerate(row):
            if is_dark:
                first = ImVec2(corner.x + x * square_px, corner.y + y * square_px)
                last = ImVec2(first.x + square_px, first.y + square_px)
                draw.add_rect_filled(first, last, theme.pack_color((0.0, 0.0, 0.0, 1.0)))
    imgui.dummy(size)
    rects.note("share code")
