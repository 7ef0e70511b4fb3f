"""Jobs from other threads run in the owner's thread; results and errors go back."""

import collections
import signal
import threading
import time
from types import SimpleNamespace

import pytest
from bullet_bridge.loop.jobs import JobQueue, QueueClosed


@pytest.fixture(name="owned")
def owned_queue():
    """(queue, owner thread) with the owner at work."""
    jobs, end = JobQueue(), threading.Event()

    def own():
        while not end.is_set():
            jobs.run_pending(wait=0.01)

    owner = threading.Thread(target=own)
    owner.start()
    yield jobs, owner
    end.set()
    owner.join()


def test_result_comes_back_and_the_owner_did_the_work(owned):
    jobs, owner = owned
    assert jobs.call(threading.get_ident, timeout=90) == owner.ident


def queued(jobs, ask, *args):
    """A started thread that calls `ask`, once its job is in the queue."""
    caller = threading.Thread(target=ask, args=args)
    caller.start()
    while not jobs.waiting:
        time.sleep(0.001)
    return caller


def test_exception_reaches_the_caller_and_the_owner_goes_on(owned):
    jobs, _ = owned
    with pytest.raises(ZeroDivisionError):
        jobs.call(lambda: 1 / 0, timeout=90)
    assert jobs.call(lambda: 7, timeout=90) == 7


def test_jobs_that_only_read_do_not_count_as_changes(owned):
    jobs, owner = owned
    assert jobs.read(threading.get_ident, timeout=90) == owner.ident
    with pytest.raises(ZeroDivisionError):
        jobs.read(lambda: 1 / 0, timeout=90)
    idle = JobQueue()
    for ask in (idle.read, idle.call, idle.read):
        caller = queued(idle, ask, lambda: None, 90)
        assert idle.run_pending() == (ask == idle.call)
        caller.join()


def test_a_job_that_failed_counts_as_a_change():
    """It may have changed something before."""
    jobs, errors = JobQueue(), []

    def ask():
        try:
            jobs.call(lambda: 1 / 0, timeout=90)
        except ZeroDivisionError as error:
            errors.append(error)

    caller = queued(jobs, ask)
    assert jobs.run_pending() == 1
    caller.join()
    assert len(errors) == 1


def test_timeout_when_nobody_runs_the_jobs():
    with pytest.raises(TimeoutError, match="did not respond within 0.02 s"):
        JobQueue().call(lambda: None, timeout=0.02)


def test_jobs_run_in_order():
    jobs, done, callers = JobQueue(), [], []
    for number in range(5):
        callers.append(
            threading.Thread(target=jobs.call, args=(lambda n=number: done.append(n), 90))
        )
        callers[-1].start()
        while jobs.waiting <= number:
            time.sleep(0.001)
    assert done == []
    assert jobs.run_pending() == 5
    for caller in callers:
        caller.join()
    assert done == [0, 1, 2, 3, 4]


def test_many_threads_get_their_own_results(owned):
    jobs, _ = owned
    results = {}

    def ask(number):
        results[number] = [jobs.call(lambda k=k: (number, k), timeout=90) for k in range(50)]

    callers = [threading.Thread(target=ask, args=(number,)) for number in range(8)]
    for caller in callers:
        caller.start()
    for caller in callers:
        caller.join()
    assert results == {n: [(n, k) for k in range(50)] for n in range(8)}


def test_run_pending_waits_no_longer_than_requested():
    before = time.monotonic()
    assert JobQueue().run_pending(wait=0.05) == 0
    assert 0.04 < time.monotonic() - before < 60.0
    assert JobQueue().run_pending() == 0


def test_close_ends_waiting_and_later_calls():
    jobs = JobQueue()
    errors = []

    def ask():
        try:
            jobs.call(lambda: 1, timeout=90.0)
        except TimeoutError as error:
            errors.append(error)

    waiting = queued(jobs, ask)
    jobs.close()
    waiting.join(90.0)
    assert not waiting.is_alive()
    ask()
    assert [type(error) for error in errors] == [QueueClosed, QueueClosed]


def test_a_slow_signal_handler_does_not_stop_the_wait():
    """SIGINT during the wait of a paused simulation once left the bridge hanging for ever."""
    jobs, before = JobQueue(), signal.getsignal(signal.SIGALRM)
    signal.signal(signal.SIGALRM, lambda *_: (time.sleep(0.3), jobs.close()))
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.05)
        start = time.monotonic()
        assert jobs.run_pending(wait=0.2) == 0
        assert time.monotonic() - start < 60.0
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)


def test_a_job_whose_caller_timed_out_is_not_run():
    jobs, done = JobQueue(), []
    with pytest.raises(TimeoutError):
        jobs.call(lambda: done.append(1), timeout=0.01)
    assert jobs.waiting == 0 and jobs.run_pending() == 0 and done == []


def test_a_job_that_was_begun_in_time_is_waited_for():
    jobs = JobQueue()

    class JustBegun(collections.deque):
        """The owner takes the job between the time-out and the cancellation."""

        def remove(self, job):
            owner = threading.Thread(target=jobs.run_pending)
            owner.start()
            assert begun.wait(90.0)
            threading.Timer(0.05, go.set).start()
            super().remove(job)

    begun, go = threading.Event(), threading.Event()
    jobs._jobs = jobs._queues[0] = JustBegun()

    def work():
        begun.set()
        go.wait(90.0)
        return "late"

    assert jobs.call(work, timeout=0.01) == "late"


def test_what_ends_the_owner_does_not_hold_up_the_caller():
    jobs, errors = JobQueue(), []

    def ask():
        try:
            jobs.call(lambda: (_ for _ in ()).throw(KeyboardInterrupt()), timeout=90.0)
        except QueueClosed as error:
            errors.append(error)

    caller = queued(jobs, ask)
    with pytest.raises(KeyboardInterrupt):
        jobs.run_pending()
    caller.join(90.0)
    assert len(errors) == 1 and not caller.is_alive()


def test_a_budget_is_kept_and_fair(monkeypatch):
    """Callers that poll got all the time of the simulation."""
    jobs, done, callers = JobQueue(), [], []
    clock = SimpleNamespace(monotonic=lambda: 1.0 + 0.01 * len(done))
    monkeypatch.setattr("bullet_bridge.loop.jobs.time", clock)

    def work(name):
        done.append(name)

    for number in range(4):
        callers.append(queued(jobs, jobs.read, lambda n=number: work(n)))
        while jobs.waiting <= number:
            time.sleep(0.001)
    callers.append(queued(jobs, jobs.call, lambda: work("change")))
    while jobs.waiting < 5:
        time.sleep(0.001)
    assert jobs.run_pending(budget=0.0) == 1 and done == ["change"], "one begins in any case"
    assert jobs.run_pending(budget=0.015) == 0 and done == ["change", 0, 1]
    assert jobs.waiting == 2 and jobs.answered == 3
    callers.append(queued(jobs, jobs.call, lambda: work("another")))
    while jobs.waiting < 3:
        time.sleep(0.001)
    jobs.run_pending()
    assert done[3:] == ["another", 2, 3], "a change does not stand behind those who read"
    for caller in callers:
        caller.join()
