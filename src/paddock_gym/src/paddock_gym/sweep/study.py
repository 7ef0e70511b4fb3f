"""The search of a sweep: Optuna's samplers, its journal in the folder, trials as processes."""

import dataclasses
import itertools
import json
import os
from concurrent.futures import FIRST_COMPLETED, ThreadPoolExecutor, wait

import optuna
from optuna.storages import JournalStorage
from optuna.storages.journal import JournalFileBackend
from optuna.trial import TrialState

from paddock_gym.contract.hyperparameters import write_json
from paddock_gym.errors import GymError
from paddock_gym.sweep.report import format_value
from paddock_gym.sweep.spec import TRIAL_TYPES, Range
from paddock_gym.sweep.trial import Processes

JOURNAL, SPEC, TRIALS, LOG = "journal.log", "sweep.json", "trials", "log.txt"
MAY_CHANGE = ("trials", "at_once")  # when a sweep continues
TAIL = 60  # lines of a failed trial's log: a traceback, and the params of a reward function


class Study:
    """A sweep in its folder; the same sweep continues with what is there.

    Args:
        log: function of one line.

    Raises:
        GymError: the folder contains another sweep.
    """

    def __init__(self, spec, folder, log=print):
        self.spec, self.folder, self._log = spec, folder, log
        self._trial_type, self._processes = TRIAL_TYPES[spec.of], Processes()
        os.makedirs(folder, exist_ok=True)
        self._store_spec()
        optuna.logging.set_verbosity(optuna.logging.ERROR)
        backend = JournalFileBackend(os.path.join(folder, JOURNAL))
        self._study = optuna.create_study(
            storage=JournalStorage(backend),
            study_name="sweep",
            load_if_exists=True,
        )
        self._study.sampler = self._sampler()
        self._enqueue()

    def _store_spec(self):
        path = os.path.join(self.folder, SPEC)
        mine = json.loads(json.dumps(dataclasses.asdict(self.spec)))
        if os.path.exists(path):
            with open(path, encoding="utf-8") as stream:
                before = json.load(stream)
            for key, value in mine.items():
                if key not in MAY_CHANGE and before.get(key) != value:
                    raise GymError(
                        f"{os.path.relpath(self.folder)} has a sweep whose {key} is "
                        f"{before.get(key)!r}, not {value!r}; delete it, or choose another --name"
                    )
        write_json(path, mine)

    def _sampler(self):
        # A continued sweep samples other values than at its start.
        seed = self.spec.seed + len(self._study.get_trials(deepcopy=False))
        if self.spec.search == "tpe":
            return optuna.samplers.TPESampler(seed=seed, constant_liar=True)
        return optuna.samplers.RandomSampler(seed=seed)

    def _enqueue(self):
        """Enqueue the unfinished trials of an interrupted sweep, and those of a grid."""
        unfinished = self._study.get_trials(states=(TrialState.RUNNING,))
        for trial in unfinished:
            self._study.tell(trial.number, state=TrialState.FAIL)
        to_enqueue = [trial.params for trial in unfinished]
        if self.spec.search == "grid":
            there = self._study.get_trials(states=(TrialState.COMPLETE, TrialState.WAITING))
            there = [trial.system_attrs.get("fixed_params", trial.params) for trial in there]
            combinations = itertools.product(
                *(range(len(values)) for values in self.spec.over.values())
            )
            grid = [dict(zip(self.spec.over, combination)) for combination in combinations]
            to_enqueue = [params for params in grid if params not in there]
        for params in to_enqueue:
            self._study.enqueue_trial(params)

    def rows(self):
        """Finished trials: dicts of number, options, score and report."""
        done = self._study.get_trials(deepcopy=False, states=(TrialState.COMPLETE,))
        return [
            {
                "number": trial.number,
                "options": trial.user_attrs["options"],
                "score": trial.value,
                "report": trial.user_attrs["report"],
            }
            for trial in done
        ]

    def run(self):
        """Run the remaining trials.

        Raises:
            GymError: a trial failed.
            KeyboardInterrupt: Ctrl-C; finished trials stay in the journal.
        """
        left = self.spec.trials - len(self.rows())
        with ThreadPoolExecutor(self.spec.at_once) as pool:
            running = set()
            try:
                while left > 0 or running:
                    while left > 0 and len(running) < self.spec.at_once:
                        running.add(pool.submit(self._trial, self._study.ask()))
                        left -= 1
                    done, running = wait(running, return_when=FIRST_COMPLETED)
                    for future in done:
                        future.result()
            except BaseException:
                self._processes.stop()
                raise

    def _trial(self, trial):
        """Run one trial in a process and record its score."""
        options = {name: self._value(trial, name) for name in self.spec.over}
        folder = os.path.join(self.folder, TRIALS, f"{trial.number:04d}", "files")
        os.makedirs(os.path.dirname(folder), exist_ok=True)
        log = os.path.join(os.path.dirname(folder), LOG)
        command = self._trial_type.command({**self.spec.fixed, **options}, folder)
        status = self._processes.run(command, log)
        if status is None:
            return  # it stays unfinished in the journal and will be repeated
        if status != 0:
            self._study.tell(trial, state=TrialState.FAIL)
            with open(log, encoding="utf-8") as stream:
                tail = "".join(stream.readlines()[-TAIL:])
            raise GymError(f"trial {trial.number} with {options} failed:\n{tail}")
        with open(os.path.join(folder, "report.json"), encoding="utf-8") as stream:
            report = json.load(stream)
        score = self._trial_type.score(report)
        trial.set_user_attr("options", options)
        trial.set_user_attr("report", report)
        self._study.tell(trial, score)
        text = ", ".join(f"{name} {format_value(value)}" for name, value in options.items())
        count = len(self.rows())
        self._log(f"sweep: {count} of {self.spec.trials}: {score:.2f} s with {text}")

    def _value(self, trial, name):
        """A value of an option for a trial."""
        values = self.spec.over[name]
        if not isinstance(values, Range):
            return values[trial.suggest_categorical(name, list(range(len(values))))]
        suggest = trial.suggest_int if values.whole else trial.suggest_float
        return suggest(name, values.low, values.high, log=values.log)
