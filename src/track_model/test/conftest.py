"""Keeps caches out of the home."""

import pathlib

import pytest

PACKAGE = pathlib.Path(__file__).resolve().parents[1]


@pytest.fixture(autouse=True)
def cache_home(tmp_path_factory, monkeypatch, request):
    """One cache for a test module, unless a test requests a separate one (own_cache)."""
    name = request.module.__name__
    store = request.config.__dict__.setdefault("_track_caches", {})
    if name not in store:
        store[name] = tmp_path_factory.mktemp("cache")
    monkeypatch.setenv("XDG_CACHE_HOME", str(store[name]))
    return store[name]


@pytest.fixture
def own_cache(tmp_path, monkeypatch):
    """A fresh cache for one test."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    return tmp_path / "cache" / "paddock" / "tracks"


@pytest.fixture
def package():
    """The package's folder."""
    return PACKAGE
