"""Random messages of web pages to a session: commands, requests and changes with extreme values.

    python tests/fuzz/page_messages.py --messages 20000 --seed 7

Each is followed by the loop of `heatlens serve` with a renderer, and what it makes is drawn. It
ends at the first message after which the loop has a fault, and prints the last ones.
"""

import argparse
import json
import random
import sys
import tempfile
from collections import deque
from collections.abc import Iterator
from dataclasses import fields
from pathlib import Path
from threading import Event
from typing import get_type_hints
from unittest.mock import MagicMock

if __name__ == "__main__":
    sys.path[:0] = [str(Path(__file__).parents[1])]
from heatlens.core.base.errors import HeatlensError, InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.view.view import ViewState
from heatlens.render.display.screen_pictures import ScreenPictures
from heatlens.studio.board.board import REMOTE_FIELDS, REQUESTS
from heatlens.studio.board.commands import named_commands
from heatlens.studio.board.session import Session
from heatlens.studio.share.headless import HeadlessLoop
from heatlens.studio.share.page_message import parsed
from heatlens.studio.share.shared import SharedSession

_EDGES = (0, 1, -1, 0.1, 2000, -2000, 30, 31, 1e-300, 1e300, -1e300, 2**63, -(2**63), 1.5, 64, 0.01)
_ODD = ("inf", "", "m", "ft", "01:00", "x" * 300, "\x1b[2J", None, True, [], [1, 2], {}, {"a": 1})
_SLOW = {"Compare with raytraced", "Compare with accumulation", "Compare with scatter"}
_CHANGED = {"lens": Lens, "blur": DefocusSettings, "view": ViewState}


def messages(count: int, seed: int) -> Iterator[dict[str, object]]:
    """Yield parsed random messages, most of which make sense."""
    rng = random.Random(seed)
    remote = {it.name for it in named_commands(MagicMock()) if it.is_remote}
    names = sorted(remote - _SLOW)
    for _ in range(count):
        kind = rng.random()
        if kind < 0.3:
            yield {"do": rng.choice(names)}
            continue
        try:
            random_message = _request(rng) if kind < 0.6 else _change(rng)
            yield parsed(json.dumps(random_message))
        except InputError:
            continue


def _value(rng: random.Random) -> object:
    kind = rng.random()
    if kind < 0.5:
        return rng.choice(_EDGES)
    return rng.uniform(-50, 50) if kind < 0.8 else rng.choice(_ODD)


def _request(rng: random.Random) -> dict[str, object]:
    name = rng.choice(sorted(REQUESTS.keys() - {"Open", "Save"}))
    field_names = [it.name for it in fields(REQUESTS[name])]
    return {"do": name} | {it: _value(rng) for it in field_names if rng.random() < 0.9}


def _change(rng: random.Random) -> dict[str, object]:
    record_name = rng.choice(sorted(_CHANGED))
    all_field_names = sorted(get_type_hints(_CHANGED[record_name]))
    field_names = REMOTE_FIELDS[record_name] if rng.random() < 0.9 else all_field_names
    return {"change": record_name} | {rng.choice(field_names): _value(rng) for _ in range(2)}


class PageSession:
    """A shared session that draws for one page, which does not exist."""

    def __init__(self, session: Session, screen: ScreenPictures) -> None:
        self.session, self.shared = session, SharedSession()
        self.loop = HeadlessLoop(session, screen, self.shared, Event())
        self.faults: list[str] = []
        self.refused = 0
        notify = session.show_error
        session.show_error = lambda error: (self._record_fault(error), notify(error))

    def _record_fault(self, error: HeatlensError) -> None:
        if not isinstance(error, InputError):
            self.faults.append(str(error))

    def _reply(self, sentence: str) -> None:
        self.refused += 1
        if "fault of heatlens" in sentence:
            self.faults.append(sentence)

    def play(self, page_messages: Iterator[dict[str, object]], turns: int = 2) -> int:
        """Apply the messages and draw after each; a fault raises AssertionError."""
        last_messages: deque[object] = deque(maxlen=5)
        count = 0
        for count, message in enumerate(page_messages, 1):  # noqa: B007
            last_messages.append(message)
            self.shared.client_count = self.shared.ready_clients = 1
            self.shared.queue_message("a page", message, self._reply)
            for _ in range(turns):
                self.loop.turn()
            assert not self.faults, f"{self.faults}, after {list(last_messages)}"
        return count


def main() -> None:
    from heatlens.render.frame_renderer import headless_renderer
    from support.evening import session_of, write_plates

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--messages", type=int, default=2000)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        source = write_plates(Path(folder))
        renderer = headless_renderer()
        screen = ScreenPictures(renderer.ctx)
        session = session_of(Path(folder), renderer, screen, source=source)
        page_session = PageSession(session, screen)
        count = page_session.play(messages(args.messages, args.seed))
        session.close()
    print(f"{count} messages, {page_session.refused} refused in a sentence, 0 faults")


if __name__ == "__main__":
    main()
