"""Checkpoint of a session: the state of its nodes, from which a long session is resumed without a replay of it all.

It is a pickle of plain values and of classes of the framework. `restore` refuses everything else, so that a database
from elsewhere cannot run code.
"""

import io
import pickle
from enum import Enum
from types import MethodType
from typing import Any

from sar_tui.framework.messages import FocusChanged
from sar_tui.framework.session import Session

_PACKAGE = __package__ + "."
_REBUILD = FocusChanged(focused=True, at=0).__reduce__()[0]
"""The function with which msgspec makes a message again from its type and fields."""
_REBUILD_NAME = (getattr(_REBUILD, "__module__", ""), getattr(_REBUILD, "__qualname__", ""))


class CheckpointError(ValueError):
    """The state of a session cannot be saved, or a checkpoint is not one of such a session."""


def save(session: Session) -> bytes:
    """Return the state of a session between two cascades.

    Raises:
        CheckpointError: a node keeps something that is not plain data, such as samples, or the session is broken.
    """
    if session.broken:
        raise CheckpointError("The session is broken.")
    buffer = io.BytesIO()
    try:
        _Pickler(buffer, session).dump(session.state())
    except (pickle.PicklingError, TypeError, AttributeError) as error:
        raise CheckpointError(str(error)) from error
    return buffer.getvalue()


def restore(session: Session, data: bytes) -> None:
    """Bring a new session to a saved state.

    Raises:
        CheckpointError: the data is not a checkpoint of such a session. The session must not be used then.
    """
    try:
        session.restore(_Unpickler(io.BytesIO(data), session).load())
    except Exception as error:  # damaged data can raise anything
        raise CheckpointError(f"{type(error).__name__}: {error}") from error


def _parts(session: Session) -> dict[str, object]:
    """Return the objects that are not saved, because a new session has its own, by name."""
    task = session.task
    return {
        "session": session,
        "bus": session.bus,
        "task": task,
        "parameters": session.parameters,
        "texts": task.tr,
        **{f"node {node.name}": node for node in session.core},
    }


def _is_known(kind: type) -> bool:
    return f"{kind.__module__}.".startswith(_PACKAGE)


class _Pickler(pickle.Pickler):
    def __init__(self, file: io.BytesIO, session: Session) -> None:
        super().__init__(file, protocol=5)
        self._names = {id(part): name for name, part in _parts(session).items()}

    def persistent_id(self, obj: Any) -> tuple[str, str] | None:
        if (name := self._names.get(id(obj))) is not None:
            return name, ""
        if type(obj) is MethodType and (owner := self._names.get(id(obj.__self__))):
            return owner, obj.__name__
        return None

    def reducer_override(self, obj: Any) -> Any:
        kind = obj if isinstance(obj, type) else type(obj)
        if isinstance(obj, Enum) and _is_known(kind):
            return kind, (obj.value,)  # Python before 3.11.4 would call getattr, which is refused
        if _is_known(kind) or obj is _REBUILD:
            return NotImplemented
        raise pickle.PicklingError(f"{obj!r:.200} is not plain data.")


class _Unpickler(pickle.Unpickler):
    def __init__(self, file: io.BytesIO, session: Session) -> None:
        super().__init__(file)
        self._parts = _parts(session)

    def persistent_load(self, pid: Any) -> Any:
        name, method = pid
        part = self._parts[name]
        return getattr(part, method) if method else part

    def find_class(self, module: str, name: str) -> Any:
        if (module, name) == _REBUILD_NAME:
            return _REBUILD
        if module.startswith(_PACKAGE) and "." not in name:
            found = super().find_class(module, name)
            if isinstance(found, type) and found.__module__ == module:
                return found
        raise pickle.UnpicklingError(f"{module}.{name} is not plain data.")
