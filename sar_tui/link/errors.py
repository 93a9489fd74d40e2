"""What can be wrong with a link, in words."""

NO_PACKAGES = (
    "The link needs Python packages that are not installed here. Install them with: pip install 'sar-tui[link]'"
)


class LinkError(Exception):
    """A link cannot be made or used as asked; one or two clear sentences."""


def need_packages() -> None:
    """See that what the link is made with is installed. Raises LinkError."""
    from importlib.util import find_spec

    if find_spec("zenoh") is None or find_spec("cryptography") is None:
        raise LinkError(NO_PACKAGES)
