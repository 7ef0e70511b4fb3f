"""What a bare machine takes over: Debian's mirror as apt knows it, pip's settings and files."""

import os

import pytest
import run_rig  # noqa: F401 - puts the package commands on the path

from commands.bare import host

PEM = "-----BEGIN CERTIFICATE-----\n{}\n-----END CERTIFICATE-----"


@pytest.fixture
def machine(tmp_path, monkeypatch):
    """A machine's folder, and settings of pip here: a file, and variables."""
    for name in ("wheels", "filled", "index/simple", "root/etc"):
        (tmp_path / name).mkdir(parents=True)
    (tmp_path / "root" / str(tmp_path / "filled")[1:]).mkdir(parents=True)
    (tmp_path / "root" / str(tmp_path / "filled")[1:] / "own").write_text("of the machine")
    (tmp_path / "company.pem").write_text("a certificate")
    (tmp_path / "bundle").write_text(f"{PEM.format('first')}\n# text\n{PEM.format('second')}\n")
    (tmp_path / "pip.conf").write_text(
        f"[global]\nfind-links =\n  {tmp_path}/wheels\n  {tmp_path}/filled\n  /no/such/folder\n"
        f"  https://example.org/wheels\ncert = {tmp_path}/company.pem\ntimeout = 9\n"
        f"cache-dir = {tmp_path}\n[install]\nuser = no\n"
    )
    for name in [name for name in os.environ if name.startswith("PIP_")]:
        monkeypatch.delenv(name)
    monkeypatch.setenv("PIP_CONFIG_FILE", str(tmp_path / "pip.conf"))
    monkeypatch.setenv("PIP_INDEX_URL", f"file://{tmp_path}/index/simple/")
    monkeypatch.setattr(host, "BUNDLE", str(tmp_path / "bundle"))
    return tmp_path / "root"


def test_settings_are_taken_over(machine, tmp_path, monkeypatch):
    monkeypatch.setattr(host, "mirror", lambda: "http://m.example.org/debian")
    seen = host.take_over(str(machine), "trixie")
    assert {str(tmp_path / name) for name in ("index", "wheels", "company.pem")} <= set(seen)
    assert not {str(tmp_path / "filled"), str(tmp_path)} & set(seen)
    conf = (machine / "etc" / "pip.conf").read_text()
    assert conf.count("[global]") == 1 and "timeout = 9\n" in conf and "[install]\n" in conf
    assert f"{tmp_path}/index" not in conf  # a variable, as here
    sources = (machine / "etc/apt/sources.list").read_text()
    assert sources == "deb http://m.example.org/debian trixie main\n"
    certificates = sorted((machine / "usr/local/share/ca-certificates").iterdir())
    assert [path.read_text().split("\n")[1] for path in certificates] == ["first", "second"]
    assert not (machine / "etc/ssl").exists()  # ca-certificates is the machine's to install
