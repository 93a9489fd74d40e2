"""Checkpoints of a live session: made between attempts, so that a long session is resumed at once."""

import hashlib
from functools import cache
from pathlib import Path
from typing import Any

import msgspec

import sar_tui.framework
from sar_tui.framework import checkpoint
from sar_tui.framework.bus import Record
from sar_tui.framework.messages import AttemptEnded
from sar_tui.framework.session import Session
from sar_tui.store.checkpoints import Checkpoint
from sar_tui.store.provenance import folder_hash
from sar_tui.store.recorder import Recorder

EVERY = 2000
"""Number of messages from one checkpoint to the next: some hundred trials, which are replayed in a moment."""


def program(session: Session, software: dict[str, Any]) -> str:
    """Return a hash of what a state follows from beside inputs: software, sources of the loop, parameters and seed."""
    facts = (software, _loop(), session.task.parameters, session.seed)
    return hashlib.sha256(msgspec.json.encode(facts)).hexdigest()


@cache
def _loop() -> str:
    return folder_hash(Path(sar_tui.framework.__file__).parent)


class Checkpoints:
    """A tap on the bus that gives the recorder a checkpoint when an attempt has ended, if enough happened since."""

    def __init__(self, session: Session, recorder: Recorder, software: dict[str, Any]) -> None:
        self._session = session
        self._recorder = recorder
        self._program = program(session, software)
        self._due: float = EVERY
        session.bus.tap(self)

    def __call__(self, cascade: list[Record]) -> None:
        """Make a checkpoint after a cascade in which an attempt ended."""
        seq = cascade[-1].seq
        if seq < self._due or not any(isinstance(record.message, AttemptEnded) for record in cascade):
            return
        try:
            state = checkpoint.save(self._session)
        except checkpoint.CheckpointError:
            self._due = float("inf")  # such a session is replayed as a whole
            return
        self._recorder.checkpoint = Checkpoint(seq, self._program, state)
        self._due = seq + EVERY
