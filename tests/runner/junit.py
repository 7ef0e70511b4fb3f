"""Counting what JUnit files tell."""

import xml.etree.ElementTree as ElementTree

from runner.job import Case, Outcome

WRAPPER = "rostest.runner.RosTest"  # rostest's own case around the cases of a test node


def count(directory):
    """Adds up the JUnit files below a directory.

    Returns:
        Outcome.
    """
    outcome = Outcome()
    for path in sorted(directory.rglob("*.xml")):
        try:
            cases = list(ElementTree.parse(path).iter("testcase"))
        except ElementTree.ParseError as error:  # the runner died while it wrote
            outcome.failures.append(f"{path.name} is no complete JUnit file: {error}")
            continue
        for case in cases:
            add(outcome, case)
    return outcome


def add(outcome, case):
    """Adds one <testcase> to an outcome."""
    name = f"{case.get('classname')}.{case.get('name')}"
    problem = case.find("failure")
    if problem is None:
        problem = case.find("error")
    if problem is not None:
        text = (problem.get("message") or problem.text or "").strip()
        outcome.failures.append(f"{name}: {text}")
    elif case.find("skipped") is not None:
        outcome.skipped += 1
    elif case.get("classname") != WRAPPER:
        outcome.passed += 1
    if case.get("classname") != WRAPPER:
        outcome.cases.append(Case(name, float(case.get("time") or 0.0)))
