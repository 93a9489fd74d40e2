"""The error that commands print when a link cannot be made or used."""

from sar_tui.drivers.installation import pip_install_extra


class LinkError(Exception):
    """A link cannot be made or used as asked; the message is one or two clear sentences."""


def no_packages() -> str:
    """Return the sentence that says how to install the extra ``link``."""
    how = pip_install_extra("link")
    return f"The link needs Python packages that are not installed here. Install them with: {how}"


def need_packages() -> None:
    """Raise LinkError if the packages of the extra ``link`` are not installed."""
    from importlib.util import find_spec

    if find_spec("zenoh") is None or find_spec("cryptography") is None:
        raise LinkError(no_packages())
