"""Documents: their commands exist, texts of errors are in the sources, tables are the code's."""

import re
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
sys.path[:0] = [
    str(ROOT / "tests" / "tutorials"),
    str(ROOT / "docs" / "tools"),
    str(ROOT / "bench"),
]

import page_commands  # noqa: E402
import results_page  # noqa: E402
import typed  # noqa: E402

from commands.errors import UsageError  # noqa: E402
from commands.subcommands import docs  # noqa: E402

PAGES = sorted(
    [
        ROOT / "README.md",
        ROOT / "CONTRIBUTING.md",
        *(ROOT / "docs").glob("*.md"),
        *(ROOT / "docs" / "api").glob("*.md"),
        *(ROOT / "src").glob("*/README.md"),
    ]
)


def documents():
    """All pages with commands of ours."""
    pages = [*PAGES, *(ROOT / "docs" / "tutorials").glob("*.md"), *(ROOT / "src").rglob("*.md")]
    return sorted({page for page in pages if "build" not in page.parts})


def test_each_command_is_run_or_has_a_reason():
    run, used = page_commands.run_elsewhere(), set()
    for page in documents():
        for line in page_commands.lines(page):
            why = page_commands.reason(line, run)
            assert why is not None, (
                f"{page.relative_to(ROOT)}: {line}: see {page_commands.__file__}"
            )
            used.add(why)
    assert set(page_commands.UNRUN.values()) - used == set()


@pytest.mark.parametrize("path", documents(), ids=lambda path: str(path.relative_to(ROOT)))
def test_words_of_commands_exist(path):
    for line in page_commands.lines(path):
        try:
            typed.check(line)
        except Exception as error:
            raise AssertionError(f"{path.relative_to(ROOT)}: {line}: {error!r}") from None


@pytest.mark.parametrize(
    "line",
    [
        "./run lap --driver lien",
        "./run test crcle",
        "rosservice call /gazebo/pause_phisics",
        "./run exec rostopic pub /cmd_vel geometry_msgs/Twits '{}'",
    ],
)
def test_words_that_do_not_exist_are_found(line):
    with pytest.raises((AssertionError, UsageError)):
        typed.check(line)


def test_each_line_of_a_box_is_read_as_a_command():
    """A program that page_commands does not know would be looked at by no test."""
    for page in documents():
        text = re.sub(r" \\\n\s*", " ", page_commands.FENCE.sub("", page.read_text()))
        boxes = re.findall(r"(?:^|\n)\n((?:    \S[^\n]*\n)+)", text)
        for line in "".join(boxes).splitlines():
            known = page_commands.BOX.match(line) or line.strip()[0] in "<[" or "(" in line
            assert known, f"{page.relative_to(ROOT)}: {line}: see {page_commands.__file__}"


def test_reasons_name_tests_that_exist():
    files = {path.name for path in [*ROOT.glob("tests/**/*.py"), *ROOT.glob("src/*/test/*.py")]}
    named = page_commands.named_tests()
    assert len(named) > 20
    for name in named:
        found = (ROOT / name).is_file() if "/" in name else name in files
        assert found, f"{name}: no such test; see {page_commands.__file__}"


def test_what_is_run_is_on_a_page():
    typed = {line for page in documents() for line in page_commands.lines(page)}
    for line in page_commands.run_elsewhere():
        assert {line, line[len("./run exec ") :]} & typed, line


def test_the_example_of_the_api_runs(capsys):
    text = (ROOT / "docs" / "api" / "world.md").read_text()
    (example,) = re.findall(r"^```python\n(.*?)^```", text, re.DOTALL | re.MULTILINE)
    exec(compile(example, "example.py", "exec"), {})
    time, x, y, z = map(float, re.findall(r"-?[\d.]+(?:e-?\d+)?", capsys.readouterr().out))
    assert (time, x, y) == (1.0, 0.0, 0.0) and abs(z - 0.1) < 1e-3


def sources():
    """All texts of the programs, with the pieces of a string put together and values left out."""
    files = [ROOT / "run", *(ROOT / "commands").rglob("*.py"), *(ROOT / "src").rglob("*.py")]
    text = "\n".join(path.read_text() for path in files)
    return re.sub(r'"\s*\n\s*f?"', "", text.replace("\\\n", ""))


def printed():
    """The texts of docs/problems.md, in the first column of its tables about what is printed."""
    found, printed_here = [], False
    for line in (ROOT / "docs" / "problems.md").read_text().splitlines():
        if line.startswith("| printed") or line.startswith("| seen"):
            printed_here = True
        elif not line.startswith("|"):
            printed_here = False
        elif printed_here and not line.startswith("| ---"):
            found += re.findall(r"`([^`]+)`", line.split(" | ")[0])
    return found


def test_texts_of_errors_are_in_the_sources():
    texts, text = printed(), sources()
    assert len(texts) > 30
    for wanted in texts:
        for piece in wanted.split("..."):
            piece = piece.strip()
            assert piece in text, f"docs/problems.md: no program prints {piece!r} of {wanted!r}"


def test_the_page_of_results_is_that_of_the_files():
    assert (ROOT / "docs" / "results.md").read_text() == results_page.page()


def test_each_section_of_the_bench_is_told_on_the_page_of_results():
    assert set(results_page.TOLD) == set(results_page.SECTIONS)


def test_the_readme_has_the_figure_of_the_page_of_results():
    text = (ROOT / "README.md").read_text()
    assert len(re.findall(r"in \d+ of \d+ worlds of the bench", text)) == 1
    assert results_page.readme() == text


def test_the_readme_has_the_figures_of_the_page_of_paths():
    page = " ".join((ROOT / "docs" / "beside-gazebo.md").read_text().split())
    wanted = re.search(r"\*\*(\d+ of \d+ driven phases of \d+ launch files from \d+ )", page)[1]
    varies = re.search(r"in (\d+) more Gazebo itself", page)[1]
    assert f"{wanted}public repositories; in {varies} more" in (ROOT / "README.md").read_text()


def test_pictures_load_fast():
    films = []
    for folder in (ROOT / "docs").rglob("images"):
        for path in folder.iterdir():
            films += [path] if path.suffix == ".mp4" else []
            largest = 1_500_000 if path.suffix == ".mp4" else 300_000
            assert path.stat().st_size <= largest, path
    assert [path.name for path in films] == ["film.mp4"]


def test_the_film_lasts_a_minute_and_is_on_the_first_page():
    import av

    assert "\n\n[A film of one minute](docs/images/film.mp4)\n" in (ROOT / "README.md").read_text()
    with av.open(str(ROOT / "docs" / "images" / "film.mp4")) as container:
        (stream,) = container.streams
        assert stream.codec_context.name == "h264"
        assert (stream.width, stream.height) == (640, 360)
        assert 50.0 < float(stream.duration * stream.time_base) < 65.0


def test_the_readme_fits_on_two_screens():
    assert len((ROOT / "README.md").read_text().split()) <= 850


def test_what_builds_the_site_is_installed_without_the_packages_of_ros(tmp_path, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", "/opt/ros/noetic/lib/python3/dist-packages")
    made, environ = next(docs._install(str(tmp_path), ""))
    assert "venv" in made and environ["PYTHONNOUSERSITE"] == "1" and "PYTHONPATH" not in environ
