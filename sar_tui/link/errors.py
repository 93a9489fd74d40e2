"""The error that commands print when a link cannot be made or used."""

NO_PACKAGES = (
    "The link needs Python packages that are not installed here. Install them with: pip install 'sar-tui[link]'"
)


class LinkError(Exception):
    """A link cannot be made or used as asked; the message is one or two clear sentences."""


def need_packages() -> None:
    """Raise LinkError if the packages of the extra ``link`` are not installed."""
    from importlib.util import find_spec

    if find_spec("zenoh") is None or find_spec("cryptography") is None:
        raise LinkError(NO_PACKAGES)
