"""What the conversation's acts may tell the machine."""

from __future__ import annotations

from cellctl.control.dialogue.table import Act
from cellctl.control.states import Event

EVENTS_OF: dict[Act, tuple[Event, ...]] = {
    Act.CONFIRM: (Event.CONFIRM, Event.CONFIRM_TAKING),
    Act.DECLINE: (Event.DECLINE,),
    Act.CHANGE: (Event.CHANGE,),
    Act.ANOTHER: (Event.CHANGE,),
    Act.BEGIN: (Event.SAY,),
    Act.BEGIN_AGAIN: (Event.SAY,),
    Act.TAKE_APART: (Event.TAKE_APART,),
    Act.HAND_OVER: (Event.BOOK,),
    Act.STOP: (Event.STOP,),
    Act.PAUSE: (Event.PAUSE,),
    Act.CANCEL: (Event.CANCEL,),
    Act.RESUME: tuple(event for event in Event if event.value.startswith("resume_")),
}
"""What each act may tell the machine; the others tell it nothing."""
