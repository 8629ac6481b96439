"""Where the session's loop and the server's thread meet: messages one way, news the other.

Neither waits for the other. What the loop publishes replaces what it published before.

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

_WAITING_MOST = 1000  # messages of all pages that the loop has not followed yet
_MESSAGES_A_TURN = 200

Reply = Callable[[str], None]

REST_S = 0.5  # time that a user keeps the lens after the last touch
WINDOW = "the window"


# Both hands work on one lens: the last touch wins once the other hand has rested for half a second.
# The holder's name is part of the state, so that each side sees who has the lens.
class Hands:
    """Decides which of several users may turn the lens; any thread may ask."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._lock = Lock()
        self._holder = ""
        self._touched_at = 0.0

    def take(self, hand: str) -> bool:
        """Return True if `hand` may turn the lens now, and has it then."""
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


def _nothing() -> None:
    pass


@dataclass(frozen=True, slots=True)
class _Asked:
    hand: str
    message: dict[str, object]
    reply: Reply


@dataclass(eq=False)
class SharedSession:
    """The present state and picture of a shared session, and the messages of its pages.

    wake      makes the session's loop turn; the server calls it
    announce  tells the server that something was published; the loop calls it
    state     what the pages show, by entry; a new object for every change
    picture   the newest picture; None before the first
    waiting   the number of clients that could take a newer picture now
    clients   the number of clients
    is_behind there is a newer picture, which no client could take when it was new
    """

    wake: Callable[[], None] = _nothing
    announce: Callable[[], None] = _nothing
    hands: Hands = field(default_factory=Hands)
    state: Mapping[str, object] = field(default_factory=dict)
    picture: Picture | None = None
    waiting: int = 0
    clients: int = 0
    is_behind: bool = False
    _asked: deque[_Asked] = field(default_factory=deque)

    # For the server

    def ask(self, hand: str, message: dict[str, object], reply: Reply) -> None:
        """Hand a page's message to the loop; `reply` gets a sentence if it cannot be followed."""
        if len(self._asked) >= _WAITING_MOST:
            reply("The session is busy, and has not followed this.")
            return
        self._asked.append(_Asked(hand, message, reply))
        self.wake()

    # For the loop

    @property
    def is_asked(self) -> bool:
        """True while messages wait."""
        return bool(self._asked)

    def follow(self, board: Board) -> bool:
        """Follow the messages that wait; return True if there were any."""
        waiting = [self._asked.popleft() for _ in range(min(len(self._asked), _MESSAGES_A_TURN))]
        for it in waiting:
            try:
                self._follow(board, it)
            except HeatlensError as error:
                it.reply(str(error))
        return bool(waiting)

    def _follow(self, board: Board, it: _Asked) -> None:
        board.check_remote(it.message)
        if board.turns_lens(it.message) and not self.hands.take(it.hand):
            raise InputError(f"{self.hands.holder or 'Another hand'} has the lens.".capitalize())
        board.follow(it.message)

    def publish(self, state: Mapping[str, object], picture: Picture | None) -> None:
        """Replace state and picture for the clients; the announcement wakes the server."""
        if state != self.state or picture is not self.picture:
            self.state, self.picture = state, picture
            self.announce()
