"""YAML files: their content, or an error message that names them."""

import os

import pytest

from paddock_common import yaml_file

LAUGHS = "".join(f"l{n}: &l{n} [{', '.join([f'*l{n - 1}'] * 9)}]\n" for n in range(1, 12))


@pytest.mark.parametrize(
    "content, message",
    [
        (b"a: [", "is no YAML"),
        (b"[" * 50_000, "nested too deeply"),
        (b"a: 9999-99-99", "is no YAML"),
        (b"a: " + b"9" * 5000, "is no YAML"),
        (b"a: \xff", "is no YAML"),
        (b"\0", "is no YAML"),
        (b"!!python/object/apply:os.mkdir ['made']", "is no YAML"),
        (b" " * (yaml_file.MAX_SIZE + 1), "more than"),
    ],
    ids=lambda value: repr(value[:12]),
)
def test_invalid_yaml_is_named(tmp_path, monkeypatch, content, message):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "f.yaml"
    path.write_bytes(content)
    with pytest.raises(ValueError, match=f"f.yaml .*{message}") as caught:
        yaml_file.read(str(path))
    assert len(str(caught.value)) < 1000 and "\n" not in str(caught.value)
    assert not (tmp_path / "made").exists()


def test_unreadable_files_are_named(tmp_path):
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", tmp_path, "/dev/zero", tmp_path / "none"):
        with pytest.raises(ValueError, match=f"{path} cannot be read"):
            yaml_file.read(str(path))


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
def test_a_file_is_read_in_its_encoding(tmp_path, encoding):
    (tmp_path / "f.yaml").write_bytes("street: Häuserweg\n".encode(encoding))
    assert yaml_file.read(str(tmp_path / "f.yaml")) == {"street": "Häuserweg"}


def test_endless_repetition_is_formatted_briefly():
    data = yaml_file.parse("l0: &l0 [lol]\n" + LAUGHS, "f.yaml")
    assert len(yaml_file.formatted(data)) < 5000
