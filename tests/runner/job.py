"""A job of the test run and what comes of it."""

from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
RESULTS = ROOT / "test-results"
ALONE = 1_000_000  # as `Job.slots`: nothing else runs meanwhile
WAITS = 0.5  # as `Job.slots`: it waits most of the time, two of them need one core


@dataclass(frozen=True)
class Job:
    """One process of the test run.

    Attributes:
        stage: "unit", "lint", "ros", "soak", "learning", "desk", "tutorials" or "long".
        name: What is printed and what a filter matches.
        command: Argument list.
        environment: Variables beyond the inherited ones.
        counted: Whether the job leaves JUnit files; if not, its exit status is its one result.
        slots: As how many jobs it counts among those that run side by side.
    """

    stage: str
    name: str
    command: tuple
    environment: dict = field(default_factory=dict, hash=False)
    counted: bool = True
    slots: float = 1

    @property
    def key(self):
        """Name that no other job has."""
        return f"{self.stage} {self.name}"

    @property
    def directory(self):
        """Where the job's log and JUnit files go."""
        return results_directory(self.stage, self.name)

    @property
    def log(self):
        """File of all that the job prints."""
        return self.directory / "output.txt"


@dataclass(frozen=True)
class Case:
    """One test of a JUnit file: its name and wall time [s]."""

    name: str
    seconds: float


@dataclass
class Outcome:
    """What came of a job: counts, what failed, the cases, wall time and processor time [s]."""

    passed: int = 0
    skipped: int = 0
    failures: list = field(default_factory=list)
    cases: list = field(default_factory=list)
    seconds: float = 0.0
    cpu: float = 0.0


def results_directory(stage, name):
    """Gives the directory of a job's log and JUnit files."""
    return RESULTS / stage / name.replace("/", "-")
