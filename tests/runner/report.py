"""What the test run prints."""

from runner.job import RESULTS, ROOT

SLOWEST = 10
LOG_LINES = 40


def one(job, outcome, number, total):
    """Prints a job's line, and for a failure what failed and the end of its log."""
    word = "FAILED" if outcome.failures else "ok"
    skipped = f", {outcome.skipped} skipped" if outcome.skipped else ""
    print(
        f"[{number}/{total}] {job.key} ... {word} ({outcome.passed} passed,"
        f" {len(outcome.failures)} failed{skipped}, {outcome.seconds:.1f} s,"
        f" {outcome.cpu:.0f} s of CPU)",
        flush=True,
    )
    if not outcome.failures:
        return
    for failure in outcome.failures:
        print("    - " + first_line(failure))
    print(f"    the end of {shown(job.log)}:")
    for line in job.log.read_text(errors="replace").splitlines()[-LOG_LINES:]:
        print("    | " + line, flush=True)


def whole(outcomes, flaky, seconds):
    """Prints slowest tests, flaky jobs, failures and, last, the sum.

    Args:
        outcomes: Dict of Job -> Outcome.
        flaky: Dict of key -> (failed, runs).
        seconds: Wall time of the run [s].
    """
    print_slowest(outcomes)
    if flaky:
        print("\nflaky (failed in some of their last runs, passed in others):")
        for key, (failed, runs) in sorted(flaky.items()):
            print(f"  {key}: failed {failed} of {runs} times")
    failures = [
        f"{job.key}: {first_line(text)}"
        for job, outcome in outcomes.items()
        for text in outcome.failures
    ]
    if failures:
        print("\nfailed (./run test --failed runs these again):")
        print("\n".join("  " + line for line in failures))
    cpu = sum(outcome.cpu for outcome in outcomes.values())
    print(f"\nlogs in {shown(RESULTS)}/, {seconds:.0f} s, {cpu:.0f} s of CPU")
    passed = sum(outcome.passed for outcome in outcomes.values())
    skipped = sum(outcome.skipped for outcome in outcomes.values())
    tail = f", {skipped} skipped" if skipped else ""
    print(f"{passed} passed, {len(failures)} failed{tail}")


def print_slowest(outcomes):
    """Prints the single tests that took longest."""
    cases = [
        (case.seconds, f"{job.key}: {case.name}")
        for job, outcome in outcomes.items()
        for case in outcome.cases
    ]
    if cases:
        print(f"\nslowest {min(SLOWEST, len(cases))} of {len(cases)} tests:")
    for seconds, name in sorted(cases, reverse=True)[:SLOWEST]:
        print(f"  {seconds:6.1f} s  {name}")


def first_line(text):
    """Gives the first line of a text, "" if it has none."""
    return text.partition("\n")[0]


def shown(path):
    """Gives a path as seen from the project's root."""
    return path.relative_to(ROOT) if path.is_relative_to(ROOT) else path
