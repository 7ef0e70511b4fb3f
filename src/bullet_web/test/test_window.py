"""The page in a browser window: which browser, what it gets, what nobody else sees."""

import html
import os
import stat

import pytest
from bullet_web.window import NoWindow, Redirect, find_browser, show

from bullet_web import window

ADDRESS = "http://127.0.0.1:7080/a-token_/"
SCREEN = {"DISPLAY": ":7"}


@pytest.fixture
def browsers(monkeypatch):
    """Sets what Python's webbrowser finds."""

    def give(found):
        def get():
            if found is None:
                raise window.webbrowser.Error("could not locate runnable browser")
            return found

        monkeypatch.setattr(window.webbrowser, "get", get)
        return found

    return give


@pytest.mark.parametrize("environment", [{}, {"DISPLAY": "", "WAYLAND_DISPLAY": ""}])
def test_without_a_display_there_is_no_window(browsers, environment):
    browsers(window.webbrowser.BackgroundBrowser("firefox"))
    with pytest.raises(NoWindow, match=r"there is no display \(neither DISPLAY nor WAYLAND_DIS"):
        find_browser(environment)


@pytest.mark.parametrize(
    "found, reason",
    [
        (None, "there is no browser"),
        (window.webbrowser.GenericBrowser("lynx"), "lynx has no window"),
        (window.webbrowser.Elinks("elinks"), "elinks has no window"),
    ],
)
def test_a_machine_without_a_browser_that_has_a_window(browsers, found, reason):
    browsers(found)
    with pytest.raises(NoWindow, match=reason):
        find_browser(SCREEN)


@pytest.mark.parametrize("name", ["DISPLAY", "WAYLAND_DISPLAY"])
def test_a_browser_on_either_kind_of_display(browsers, name):
    found = browsers(window.webbrowser.BackgroundBrowser("firefox"))
    assert find_browser({name: "0"}) is found


def test_the_users_own_choice_counts(browsers):
    found = browsers(window.webbrowser.GenericBrowser("my-browser"))
    assert find_browser({**SCREEN, "BROWSER": "my-browser"}) is found


def test_the_address_is_in_a_file_of_this_user_alone(tmp_path):
    folder = tmp_path / "new"
    redirect = Redirect(ADDRESS + "?a=1&b=2", str(folder))
    assert stat.S_IMODE(os.stat(redirect.path).st_mode) == 0o600
    text = (folder / os.path.basename(redirect.path)).read_text()
    assert f'content="0; url={html.escape(ADDRESS + "?a=1&b=2")}"' in text
    redirect.remove()
    redirect.remove()
    assert list(folder.iterdir()) == []


def test_the_browser_gets_the_file_and_not_the_address(monkeypatch, tmp_path):
    told = tmp_path / "told"
    script = tmp_path / "browser"
    script.write_text(f'#!/bin/sh\nprintf %s "$1" > {told}\n')
    script.chmod(0o755)
    monkeypatch.setenv("DISPLAY", ":7")
    monkeypatch.setenv("BROWSER", str(script))
    monkeypatch.setattr(window.webbrowser, "_tryorder", None)  # asked for anew
    show(str(tmp_path / "page.html"))
    assert told.read_text() == f"file://{tmp_path}/page.html"


def test_a_browser_that_does_not_start(monkeypatch, browsers):
    monkeypatch.setenv("DISPLAY", ":7")
    browsers(window.webbrowser.BackgroundBrowser("/no/such/browser"))
    with pytest.raises(NoWindow, match="/no/such/browser cannot open it"):
        show("/page.html")
