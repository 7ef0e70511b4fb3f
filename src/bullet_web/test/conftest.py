"""The page's files from the sources."""

from pathlib import Path

import pytest

from bullet_web import files


@pytest.fixture
def page_files(monkeypatch):
    """Those of a replay, by name."""
    monkeypatch.setattr(files, "folder", lambda: Path(__file__).parents[1] / "www")
    return files.read(files.REPLAY)
