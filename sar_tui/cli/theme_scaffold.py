"""Creates a new theme as a copy of another."""

import re
from pathlib import Path

from sar_tui.cli.errors import Refused
from sar_tui.cli.scaffold import whole_or_nothing
from sar_tui.plugins import Catalogue

_NAME = "[a-z][a-z0-9]*(-[a-z0-9]+)*"


def make(name: str, model: str, to: Path, catalogue: Catalogue) -> Path:
    """Create the folder of a new theme and return its absolute path. Raises Refused, or PluginError
    without a model.
    """
    if not re.fullmatch(_NAME, name):
        raise Refused(
            f"{name!r} is not a valid name of a theme. Use small letters, such as evening or "
            "warm-light."
        )
    source = catalogue.theme_folder(model)
    folder = to.resolve() / name
    if folder.exists():
        raise Refused(f"{folder} exists already. Choose another name, or another folder with --to.")
    if name in catalogue.theme_names():
        raise Refused(f"There is a theme {name} already. Choose another name.")
    folder.mkdir(parents=True)
    with whole_or_nothing(folder):
        for file in sorted(path for path in source.rglob("*") if path.is_file()):
            copy = folder / file.relative_to(source)
            copy.parent.mkdir(parents=True, exist_ok=True)
            copy.write_bytes(file.read_bytes())
        look = folder / "theme.toml"
        title = f'title = "{name.replace("-", " ").capitalize()}"'
        text = re.sub(
            r"^title\s*=.*$",
            title,
            look.read_text(encoding="utf-8-sig"),
            count=1,
            flags=re.MULTILINE,
        )
        look.write_text(text, encoding="utf-8")
    return folder
