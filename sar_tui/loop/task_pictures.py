"""Files of pictures in a task's folder."""

from pathlib import Path

SUFFIXES = (".bmp", ".gif", ".jpeg", ".jpg", ".png", ".webp")


def pictures_in(folder: Path) -> list[Path]:
    """Return the files of pictures in a task's folder and the folders in it; none if its code is a
    single file.
    """
    return sorted(
        path for path in folder.rglob("*") if path.suffix.lower() in SUFFIXES and path.is_file()
    )


def picture_file(folder: Path, name: str) -> Path:
    """Return the file that a prompt names. Raises ValueError with a sentence if it is missing, or
    not in the folder.
    """
    path = folder / name
    if not path.resolve().is_relative_to(folder.resolve()):
        raise ValueError(f"The picture {name} is outside the task's folder.")
    if not path.is_file():
        raise ValueError(f"There is no picture {name} in {folder}.")
    return path
