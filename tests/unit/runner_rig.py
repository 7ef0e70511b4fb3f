"""Jobs for the test runner's own tests."""

import sys

from runner.job import Job

LONG = 60.0  # deadline that a test never reaches [s]


def job(name="some", text="pass", **fields):
    """A job that runs a Python text."""
    head = "import os, signal, subprocess, sys, time\n"
    return Job("unit", name, (sys.executable, "-c", head + text), **fields)


def use_directory(monkeypatch, folder):
    """Puts the directories of all jobs below a folder."""
    monkeypatch.setattr(Job, "directory", property(lambda item: folder / item.stage / item.name))


def write_cases(folder, text):
    """Writes a JUnit file with these <testcase> elements into a folder."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "some.xml").write_text(f"<testsuite>{text}</testsuite>")
