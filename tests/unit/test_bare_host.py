"""What a bare machine takes over: Debian's mirror from apt's lists, pip's settings and files."""

import pytest
import run_rig  # noqa: F401 - puts the package commands on the path

from commands.bare import host

DEBIAN_SOURCES = """\
# a comment
Types: deb deb-src
# another one, with http://old.example.org/debian
URIs: https://mirror.example.org/debian/
Suites: bookworm bookworm-updates
Components: main
Signed-By: /usr/share/keyrings/debian-archive-keyring.gpg

Types: deb
URIs: https://security.example.org/debian-security
Suites: bookworm-security
Components: main
"""
FOLDED = """\
Types:
 deb
URIs:
 https://folded.example.org/debian
Suites: trixie
Components: main contrib
"""
OTHERS = "deb [signed-by=/etc/apt/keyrings/o.gpg] https://o.example.org/debian bookworm main\n"


@pytest.mark.parametrize(
    "files, found",
    [
        ({}, host.FALLBACK),
        ({"sources.list": "deb http://a.example.org/debian bookworm main\n"},
         "http://a.example.org/debian"),
        ({"sources.list": "# deb http://a.example.org/debian bookworm main\n"
                          "deb-src http://b.example.org/debian bookworm main\n"
                          "deb cdrom:[Debian 12]/ bookworm main\n"
                          "deb [ arch=amd64 trusted=no ] http://c.example.org/x/ trixie main #\n"},
         "http://c.example.org/x"),
        ({"sources.list": "deb http://a.example.org/ubuntu noble main\n"}, host.FALLBACK),
        ({"sources.list": "deb http://a.example.org/debian-security bookworm-security main\n"},
         host.FALLBACK),
        ({"sources.list.d/debian.sources": DEBIAN_SOURCES}, "https://mirror.example.org/debian"),
        ({"sources.list.d/debian.sources": "Enabled: no\n" + DEBIAN_SOURCES}, host.FALLBACK),
        ({"sources.list.d/debian.sources": FOLDED}, "https://folded.example.org/debian"),
        ({"sources.list.d/a.list": OTHERS}, host.FALLBACK),
        ({"sources.list.d/a.list": OTHERS, "sources.list.d/debian.sources": DEBIAN_SOURCES},
         "https://mirror.example.org/debian"),
        ({"sources.list.d/a.list": "deb https://c.example.org/code stable main\n"}, host.FALLBACK),
        ({"sources.list.d/mine.list": "deb https://c.example.org/debian/ stable main\n"},
         "https://c.example.org/debian"),
        ({"sources.list.d/debian.sources.bak": DEBIAN_SOURCES}, host.FALLBACK),
        ({"sources.list": "deb file:/srv/debian bookworm main\n"}, host.FALLBACK),
    ],
)  # fmt: skip
def test_the_mirror(tmp_path, files, found):
    for name, text in files.items():
        path = tmp_path / name
        path.parent.mkdir(exist_ok=True)
        path.write_text(text)
    assert host.mirror(str(tmp_path)) == found


def test_what_pip_names(tmp_path):
    wheels, simple, certificate = tmp_path / "wheels", tmp_path / "index" / "simple", tmp_path / "c"
    wheels.mkdir()
    simple.mkdir(parents=True)
    certificate.write_text("x")
    text = (
        f"[global]\nfind-links =\n  {wheels}\n  https://example.org/wheels\n  /no/such/folder\n"
        f"cert = {certificate}\nindex_url = file://{simple}/\ntimeout = 9\n[install]\nuser = no\n"
    )
    folders, files = host.named_by_pip(host.pip_settings(text))
    assert (folders, files) == ([str(tmp_path / "index"), str(wheels)], [str(certificate)])
    assert host.named_by_pip([("find-links", f"{certificate}")])[0] == [str(tmp_path)]
    assert host.pip_settings("no pip.conf at all") == []


@pytest.fixture
def machine(tmp_path, monkeypatch):
    """A machine's folder, and a home with settings of pip here."""
    home = tmp_path / "home"
    for name in ("home/.config/pip", "home/wheels", "home/filled", "root/etc"):
        (tmp_path / name).mkdir(parents=True)
    (tmp_path / "root" / str(home / "filled")[1:]).mkdir(parents=True)
    (tmp_path / "root" / str(home / "filled")[1:] / "own").write_text("of the machine")
    (home / ".config" / "pip" / "pip.conf").write_text(
        f"[global]\nfind-links = {home}/wheels {home}/filled\ncert = {home}/company.pem\n"
    )
    (home / "company.pem").write_text("a certificate")
    monkeypatch.setenv("HOME", str(home))
    monkeypatch.delenv("XDG_CONFIG_HOME", raising=False)
    for name in ("PIP_FIND_LINKS", "PIP_CONFIG_FILE", "PIP_CERT"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(host, "local_certificates", lambda: ["first", "second"])
    return tmp_path / "root"


def test_settings_are_taken_over(machine, tmp_path, monkeypatch):
    home = tmp_path / "home"
    monkeypatch.setattr(host, "mirror", lambda: "http://m.example.org/debian")
    (machine / "etc" / "hosts").symlink_to("/etc/passwd")  # is replaced, and not followed
    folders = host.take_over(str(machine), "trixie")
    assert str(home / "wheels") in folders and str(home / "filled") not in folders
    assert (machine / "root/.config/pip/pip.conf").read_text().startswith("[global]")
    assert (machine / str(home)[1:] / "company.pem").read_text() == "a certificate"
    sources = (machine / "etc/apt/sources.list").read_text()
    assert sources == "deb http://m.example.org/debian trixie main\n"
    certificates = sorted((machine / "usr/local/share/ca-certificates").iterdir())
    assert [path.read_text() for path in certificates] == ["first\n", "second\n"]
    assert not (machine / "etc" / "hosts").is_symlink()
    assert not (machine / "etc/ssl").exists()  # ca-certificates is the machine's to install


def test_variables(monkeypatch):
    for name, value in {"HTTPS_PROXY": "http://p:1", "PIP_INDEX_URL": "http://i", "CI": "1",
                        "PIP_CACHE_DIR": "/c", "PYTHONPATH": "/x"}.items():  # fmt: skip
        monkeypatch.setenv(name, value)
    environ = host.environment()
    assert environ["HTTPS_PROXY"] == "http://p:1" and environ["PIP_INDEX_URL"] == "http://i"
    assert (environ["HOME"], environ["LANG"], environ["CI"]) == ("/root", "C.UTF-8", "1")
    assert not {"PIP_CACHE_DIR", "PYTHONPATH"} & set(environ)
