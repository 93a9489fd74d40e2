"""A clinic, and a home that has joined it and has said so."""

from pathlib import Path

import pytest

from tests.letterbox.household import Clinic, Home, settle


@pytest.fixture
def clinic(tmp_path: Path) -> Clinic:
    """The clinic of P07 and P08."""
    return Clinic(tmp_path / "clinic", "P07", "P08")


@pytest.fixture
def home(clinic: Clinic, tmp_path: Path) -> Home:
    """The home of P07."""
    found = clinic.home("P07", tmp_path / "home")
    settle(found, clinic)
    return found
