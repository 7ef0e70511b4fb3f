"""Signatures of files: they may say "changed" too often, but never too seldom."""

import os

import pytest

from commands import signature


@pytest.fixture
def signatures(tmp_path, monkeypatch):
    """The module signature, with a folder of its own and files that need not grow old."""
    monkeypatch.setattr(signature, "FOLDER", str(tmp_path / "signatures"))
    monkeypatch.setattr(signature, "RACY", 0)
    return signature


def test_a_signature_tells_what_changed(tmp_path, signatures):
    path, absent = tmp_path / "file", tmp_path / "absent"
    path.write_text("first")
    assert not signatures.unchanged("probe", "key")
    signatures.save("probe", "key", [str(path), str(absent), str(tmp_path)])
    # the folder itself changed with the signature's own folder
    signatures.save("probe", "key", [str(path), str(absent)])
    assert signatures.unchanged("probe", "key")
    assert not signatures.unchanged("probe", "other key")
    absent.write_text("")
    assert not signatures.unchanged("probe", "key")
    absent.unlink()
    assert signatures.unchanged("probe", "key")
    before = path.stat()
    path.write_text("other")
    os.utime(path, ns=(before.st_atime_ns, before.st_mtime_ns))  # same size, same time
    assert not signatures.unchanged("probe", "key")
    path.unlink()
    assert not signatures.unchanged("probe", "key")


def test_no_signature_of_what_changed_just_now(tmp_path, signatures, monkeypatch):
    monkeypatch.setattr(signature, "RACY", 10**18)
    path = tmp_path / "file"
    path.write_text("text")
    signatures.save("probe", "key", [str(path)])
    assert not (tmp_path / "signatures").exists()
    assert not signatures.unchanged("probe", "key")
