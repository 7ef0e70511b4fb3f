"""What faults have in common: how they ask, how they fail, in which order they come.

A fault is a function of a Session and a random.Random that returns what it did, a line.
"""

import random

from figures import BenchError

from soaking.observer import Silent


class Failure(Exception):
    """A promise was not kept; the text says which."""


def ask(session, **question):
    """Has the hands do something.

    Raises:
        Failure: They could not, or it hung.
    """
    try:
        answer = session.hands.ask(**question)
    except Silent as error:
        raise Failure(str(error)) from None
    except BenchError as error:
        raise Failure(f"{question['what']}: {error}") from None
    if "error" in answer:
        raise Failure(answer["error"])
    return answer


def rounds(table, seed):
    """An endless order of faults: each round has all of them, as often as the table says.

    Args:
        table: dict of fault -> how often.
        seed: Number; the same one gives the same order.

    Yields:
        (fault, seed of its own).
    """
    rng = random.Random(seed)
    while True:
        one_round = [fault for fault, count in table.items() for _ in range(count)]
        rng.shuffle(one_round)
        for fault in one_round:
            yield fault, rng.random()
