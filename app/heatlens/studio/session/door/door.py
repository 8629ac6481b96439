"""The door of a session: plain values out, commands and requests in.

A front end needs nothing else. Named commands take no values ("Undo"), requests are values
(`Focus(2.4)`), and changes are new values for some fields of the lens, the blur or the view. All of
them can be written as a JSON object as well:

    {"do": "Undo"}
    {"do": "Focus", "distance_m": 2.4}
    {"change": "lens", "f_stop": 2.0, "focal_length_mm": 35}
"""

from collections.abc import Mapping
from dataclasses import fields, replace
from functools import partial
from pathlib import Path
from typing import get_type_hints

from heatlens.core.base.errors import HeatlensError, InputError
from heatlens.core.model.lens.lens import Lens
from heatlens.core.model.shot.settings import DefocusSettings
from heatlens.core.model.view.view import ViewState
from heatlens.media.files.json_record import JsonEntry, record_to_json
from heatlens.studio.session.door.named_commands import Command, named_commands
from heatlens.studio.session.door.requests import Request
from heatlens.studio.session.door.state import State, state_of
from heatlens.studio.session.session import Session

_MESSAGE = Path("message")  # where a wrong value was found, as errors name it
REQUESTS: Mapping[str, type[Request]] = {kind.__name__: kind for kind in Request.__subclasses__()}
Changeable = Lens | DefocusSettings | ViewState


class Door:
    """Drives a session for a front end; errors are shown as its message."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self.commands = named_commands(session)
        self._picture, self._picture_key = 0, object()
        self._named = {command.name: command for command in self.commands}

    def state(self) -> State:
        """Return the state to show now."""
        key = self._session.time.scheduler.picture_key
        self._picture += key != self._picture_key
        self._picture_key = key
        return state_of(self._session, self.commands, self._picture)

    def do(self, asked: Request | Command | str) -> None:
        """Do a request, a command, or the command of this name; show why if that is impossible."""
        try:
            self._do(asked)
        except HeatlensError as error:
            self._session.say_error(error)

    def _do(self, asked: Request | Command | str) -> None:
        if isinstance(asked, Request):
            asked.run(self._session)
        else:
            (self._named[asked] if isinstance(asked, str) else asked).do()

    def change(self, changed: Changeable) -> None:
        """Replace the lens at the playhead, the settings of the blur, or the view."""
        editing = self._session.editing
        if isinstance(changed, Lens):
            editing.edit_lens(changed)
        elif isinstance(changed, DefocusSettings):
            editing.edit(replace(editing.shot, defocus=changed))
        else:
            self._session.pictures.view.state = changed

    def choose(self, changed: Changeable) -> None:
        """Do the same as `change`, as an undo step of its own."""
        self._session.editing.settle()
        self.change(changed)
        self._session.editing.settle()

    def answer(self, message: object) -> dict[str, object]:
        """Follow a JSON message; return `{"state": ...}`, or `{"problem": sentence}`."""
        try:
            self.follow(message)
        except HeatlensError as error:
            return {"problem": str(error)}
        return {"state": record_to_json(self.state())}

    def follow(self, data: object) -> None:
        """Follow a JSON message. Raise HeatlensError with a sentence if that is impossible."""
        message = JsonEntry(_MESSAGE, "", data)
        if not isinstance(data, dict):
            message.refuse("it should be an object in braces")
        entries = dict(data)
        if "change" in entries:
            of = JsonEntry(_MESSAGE, "change", entries.pop("change")).choice(list(self._changing()))
            self.change(_changed(self._changing()[of], JsonEntry(_MESSAGE, "", entries)))
        elif "do" in entries:
            name = JsonEntry(_MESSAGE, "do", entries.pop("do")).text()
            self._do(self._asked(name, JsonEntry(_MESSAGE, "", entries)))
        elif entries:
            message.refuse("one of the entries 'do' and 'change' is missing")

    def _asked(self, name: str, values: JsonEntry) -> Request | str:
        if name in REQUESTS:
            return values.record(REQUESTS[name])
        if name not in self._named:
            raise InputError(f"There is no command and no request {name!r}.")
        values.members(())
        return name

    def _changing(self) -> dict[str, Changeable]:
        facts = self._session.facts
        return {"lens": facts.lens, "blur": facts.shot.defocus, "view": facts.view}


def _changed(now: Changeable, values: JsonEntry) -> Changeable:
    hints = get_type_hints(type(now))
    given = {
        name: entry.of_type(hints[name])
        for name, entry in values.members([field.name for field in fields(now)]).items()
    }
    return values.built(partial(replace, now), given)
