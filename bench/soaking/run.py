"""A run of the soak: sessions one after the other, faults in each, their timeline."""

import random
import signal
import time
from dataclasses import dataclass, field

from figures import BenchError

from soaking.faults import FAULTS, SHUTDOWNS, Failure, ask, rounds
from soaking.limits import POLITE_LIMIT, formatted, violation
from soaking.monitor import Sampler, growth, problems
from soaking.session import Session

CALM = (1.0, 4.0)  # [s] between two faults
RECOVERY = 60.0  # wall time after a fault until all topics deliver [s]
DIGEST_EVERY = 6  # faults between two comparisons of resets
HOLD = ("control", "drive")  # stopped while states are compared: they send commands


@dataclass
class Event:
    """A fault, or a check: begin and end [s since the soak began], name, text, failure or ''."""

    begin: float
    end: float
    name: str
    text: str
    failure: str = ""


@dataclass
class Timeline:
    """What happened: events, samples per session, what else failed."""

    seed: int
    begin: float = field(default_factory=time.monotonic)
    events: list = field(default_factory=list)
    samples: list = field(default_factory=list)
    failures: list = field(default_factory=list)

    def now(self):
        """Wall time since the begin [s]."""
        return time.monotonic() - self.begin

    def fail(self, text):
        """Notes a failure that belongs to no fault."""
        self.failures.append(f"{self.now():.0f} s: {text}")


class Soak:
    """Runs sessions and faults until the time is over.

    Args:
        folder: pathlib.Path for the sessions' logs.
        say: Function of a line of progress.
    """

    def __init__(self, minutes, seed, folder, say=print):
        self._limit, self._folder, self._say = 60.0 * minutes, folder, say
        self.timeline = Timeline(seed)
        self._faults, self._shutdowns = rounds(FAULTS, seed), rounds(SHUTDOWNS, seed + 1)
        self._rng = random.Random(seed + 2)
        self._sessions = 0

    def run(self):
        """Runs it; returns the Timeline."""
        while self.timeline.now() < self._limit:
            remaining = self._limit - self.timeline.now()
            # Long sessions show growth, short ones the begin and the end.
            length = remaining if remaining < 120.0 else self._rng.choice((90.0, 240.0, 900.0))
            self._session(min(length, remaining))
            if self.timeline.failures and self._sessions > 20:
                break
        return self.timeline

    def _session(self, length):
        self._sessions += 1
        name = f"session-{self._sessions}"
        session = Session(self._folder / name)
        self._say(f"{self.timeline.now():6.0f} s  {name}")
        sampler, ended = None, False
        try:
            session.start()
            sampler = Sampler(session, self.timeline.begin)
            sampler.start()
            ended = self._faults_of(session, sampler, self.timeline.now() + length)
        except BenchError as error:
            self.timeline.fail(f"{name}: {error}")
        finally:
            if sampler is not None:
                sampler.stop()
                self.timeline.samples.append(sampler.samples)
                self.timeline.failures += [f"{name}: {text}" for text in growth(sampler.samples)]
            self._end(session, name, ended)

    def _end(self, session, name, ended):
        begin = self.timeline.now()
        if ended:
            session.close()
        else:
            found, files = session.stop(signal.SIGINT)
            text = f"ended within {formatted(found)}"
            failure = violation(found, files, POLITE_LIMIT)
            self._note(Event(begin, self.timeline.now(), "end", text, failure))
        for line in problems((session.folder / "launch.log").read_text(errors="replace")):
            self.timeline.fail(f"{name}: log: {line}")

    def _faults_of(self, session, sampler, end):
        """Faults until the session's time is over; returns whether one has ended it."""
        reference, count = self._digest(session, None), 0
        while self.timeline.now() < end:
            fault, seed = next(self._faults)
            if not self._one(session, sampler, fault, seed):
                return False
            count += 1
            if count % DIGEST_EVERY == 0:
                sampler.calm = False
                self._digest(session, reference)
            sampler.calm = True
            time.sleep(self._rng.uniform(*CALM))
        if self.timeline.now() + 30.0 < self._limit or self._rng.random() < 0.5:
            fault, seed = next(self._shutdowns)
            sampler.calm = False
            sampler.stop()
            return self._one(session, sampler, fault, seed, last=True)
        return False

    def _one(self, session, sampler, fault, seed, last=False):
        """One fault and what has to hold after it; returns whether the session can go on."""
        sampler.calm = False
        begin, name = self.timeline.now(), fault.__name__
        text = failure = ""
        try:
            text = fault(session, random.Random(seed))
            if not last:
                text += f"; all back after {self._recovered(session):.1f} s"
        except Failure as error:
            failure = str(error)
        self._note(Event(begin, self.timeline.now(), name, text, failure))
        if sampler.error and not last:
            self.timeline.fail(sampler.error)
            return False
        return last or session.alive()

    def _note(self, event):
        self.timeline.events.append(event)
        words = f"FAILED {event.failure}" if event.failure else event.text
        self._say(f"{event.begin:6.0f} s  {event.name}: {words}")

    def _recovered(self, session):
        """Waits until every topic has delivered since now; returns the seconds it took.

        Raises:
            Failure: One has not within RECOVERY, or a controller does not run.
        """
        begin = time.monotonic()
        before = self._counts(session)
        while True:
            counts = self._counts(session)
            missing = [topic for topic, count in counts.items() if count <= before[topic]]
            if not missing:
                break
            if time.monotonic() - begin > RECOVERY:
                raise Failure(f"no message on {', '.join(missing)} for {RECOVERY:g} s after it")
            time.sleep(0.2)
        missing = ask(session, what="controllers")["missing"]
        if missing:
            raise Failure(f"controllers of {', '.join(missing)} do not run after it")
        return time.monotonic() - begin

    @staticmethod
    def _counts(session):
        if not session.alive():
            raise Failure(f"the session has ended with it (status {session.launch.poll()})")
        try:
            return session.monitor.request(what="sample")["counts"]
        except BenchError as error:
            raise Failure(str(error)) from None

    def _digest(self, session, reference):
        """Compares what 300 steps from the saved state give with the first time; the answer."""
        begin, failure = self.timeline.now(), ""
        for role in HOLD:
            session.send(role, signal.SIGSTOP)
        try:
            found = ask(session, what="digest")
        except Failure as error:
            found, failure = None, str(error)
        for role in HOLD:
            session.send(role, signal.SIGCONT)
        if found and reference and found["digest"] != reference["digest"]:
            names = [n for n, s in found["states"].items() if s != reference["states"].get(n)]
            failure = f"300 steps after a saved state these are not as before: {', '.join(names)}"
        self._note(Event(begin, self.timeline.now(), "state compared", "bit-identical", failure))
        return found
