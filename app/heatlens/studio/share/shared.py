"""Pass data between the session's loop and the server's thread, without waiting on either side.

Messages of pages go to the loop; state and picture go to the server. A newly published state or
picture replaces the one before.

`Hands` decides which user has the lens: the latest touch wins once the other user rests.
"""

import time
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from threading import Lock

from heatlens.core.base.errors import HeatlensError, InputError
from heatlens.studio.board.board import Board
from heatlens.studio.share.picture import Picture

_MOST_WAITING = 1000  # messages of all pages that the loop has not followed yet
_MESSAGES_PER_TURN = 200

Reply = Callable[[str], None]

REST_S = 0.5  # time that a user keeps the lens after the last touch
WINDOW = "the window"


# Several users turn one lens: the last touch wins once the other user has rested for half a second.
# The holder's name is part of the state; each side therefore sees who has the lens.
class Hands:
    """Decides which of several users may turn the lens; any thread may ask."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._lock = Lock()
        self._holder = ""
        self._touched_at = 0.0

    def try_take(self, hand: str) -> bool:
        """Return True, and give the lens to `hand`, if that user may turn it now."""
        with self._lock:
            now = self._clock()
            if self._holder not in ("", hand) and now - self._touched_at < REST_S:
                return False
            self._holder, self._touched_at = hand, now
            return True

    @property
    def holder(self) -> str:
        """The user who has the lens; "" once it is free."""
        with self._lock:
            is_held = self._clock() - self._touched_at < REST_S
            return self._holder if is_held else ""


def _do_nothing() -> None:
    pass


@dataclass(frozen=True, slots=True)
class _PageMessage:
    hand: str
    message: dict[str, object]
    reply: Reply


@dataclass(eq=False)
class SharedSession:
    """The present state and picture of a shared session, and the messages of its pages.

    wake           makes the session's loop turn; the server calls it
    state          the state that pages show, by entry; a new object for every change
    picture        the newest picture; None before the first
    ready_clients  the number of clients that could take a newer picture now
    client_count   the number of clients
    is_behind      True if there is a newer picture, which no client could take when it was new
    """

    wake: Callable[[], None] = _do_nothing
    hands: Hands = field(default_factory=Hands)
    state: Mapping[str, object] = field(default_factory=dict)
    picture: Picture | None = None
    ready_clients: int = 0
    client_count: int = 0
    is_behind: bool = False
    _messages: deque[_PageMessage] = field(default_factory=deque)
    _announce: Callable[[], None] = _do_nothing
    _is_page_acting: bool = False  # a message of a page is being carried out

    # For the server

    def listen(self, announce: Callable[[], None]) -> None:
        """Call `announce` on the loop's thread whenever something is published."""
        self._announce = announce

    def stop_listening(self) -> None:
        """Call nothing from now on."""
        self._announce = _do_nothing

    def queue_message(self, hand: str, message: dict[str, object], reply: Reply) -> None:
        """Hand a page's message to the loop; `reply` gets a problem if it cannot be followed."""
        if len(self._messages) >= _MOST_WAITING:
            reply("The session is busy, and has not followed this.")
            return
        self._messages.append(_PageMessage(hand, message, reply))
        self.wake()

    # For the loop

    @property
    def has_messages(self) -> bool:
        """True while messages of pages wait to be carried out."""
        return bool(self._messages)

    def follow_messages(self, board: Board) -> bool:
        """Carry out the messages that wait; return True if there were any."""
        messages = [
            self._messages.popleft() for _ in range(min(len(self._messages), _MESSAGES_PER_TURN))
        ]
        for message in messages:
            self._is_page_acting = True
            try:
                self._follow_message(board, message)
            except HeatlensError as error:
                message.reply(str(error))
            finally:
                self._is_page_acting = False
        return bool(messages)

    def other_holder(self) -> str:
        """Take the lens for the window; return the name of the page's user who has it, or ""."""
        if self._is_page_acting or self.hands.try_take(WINDOW):
            return ""
        return self.hands.holder

    def _follow_message(self, board: Board, message: _PageMessage) -> None:
        """Do what a message of a page asks, if that page may turn the lens now."""
        board.check_remote(message.message)
        if board.turns_lens(message.message) and not self.hands.try_take(message.hand):
            holder = self.hands.holder or "someone else"
            raise InputError(f"{holder[0].upper()}{holder[1:]} moves the lens: wait a moment.")
        board.follow(message.message)

    def publish(self, state: Mapping[str, object], picture: Picture | None) -> None:
        """Replace state and picture for the clients; the announcement wakes the server."""
        if state != self.state or picture is not self.picture:
            self.state, self.picture = state, picture
            self._announce()
