"""Prints a script that completes the commands of ./run in bash.

In one shell, or for good in ~/.bashrc, with the path of this clone:
  source <(./run completion)
  source <(/path/to/paddock/run completion)

TAB then knows commands, options, drivers, tracks, shapes, tests and launch arguments. It asks the
./run that is on the command line, so one script serves every clone.
"""

import argparse

from commands import launching
from commands.cli import subcommand
from commands.parsing import parser_of, values
from commands.table import COMMANDS, DEFAULT

ANY_COMMAND = "@commands"  # asks the shell for the programs on PATH
VALUES = {  # of launch arguments
    "mode": ("original", "ackermann"),
    "odom_source": ("wheels", "ground_truth"),
    "renderer": ("auto", "gl", "tiny"),
    "shadows": ("auto", "true", "false"),
    "antialias": ("auto", "true", "false"),
    "view": ("odom", "lidar"),
}
SWITCH = ("false", "true")
# bash splits words at the ':' and '=' of NAME:=VALUE, so the whole line is handed over, and the
# candidates come back as what stands behind the last of these characters.
SCRIPT = r"""# Completion of Paddock's ./run, for ~/.bashrc: source <(PATH_OF_CLONE/run completion)
_paddock_run() {
  local program candidates
  COMPREPLY=()
  program=$(readlink -f -- "${1/#\~/$HOME}") || return
  if [ ! -e "${program%/*}/commands/table.py" ]; then return; fi
  candidates=$("$program" completion --line "${COMP_LINE:0:COMP_POINT}" \
    --breaks "$COMP_WORDBREAKS" 2>/dev/null) || return
  case $candidates in
    '') ;;
    @commands) mapfile -t COMPREPLY < <(compgen -c -- "$2" | sort -u) ;;
    *) mapfile -t COMPREPLY <<<"$candidates" ;;
  esac
  case ${COMPREPLY[0]:-} in *=) compopt -o nospace 2>/dev/null ;; esac
}
complete -o bashdefault -o default -F _paddock_run run
"""


def add_arguments(parser):
    """Declares what the script itself asks with."""
    parser.add_argument("--line", help=argparse.SUPPRESS)
    parser.add_argument("--breaks", default=":=", help=argparse.SUPPRESS)


def run(options, _rest):
    """Prints the script, or what the end of a line can become."""
    if options.line is None:
        print(SCRIPT, end="")
    else:
        print("\n".join(candidates(options.line, options.breaks)))


def candidates(line, breaks=":="):
    """Lists what the last word of a line can become.

    Args:
        line: The command line up to the cursor, ./run included.
        breaks: Characters at which the shell splits words; of a candidate with one of them, only
            what comes behind is given.

    Returns:
        Sorted words, or ANY_COMMAND alone. With none of them the shell completes file names.
    """
    words = line.split() if not line[-1:].isspace() else [*line.split(), ""]
    if len(words) < 2:
        return []
    before, word = words[1:-1], words[-1]
    choices = _choices(before, word)
    if ANY_COMMAND in choices:
        return [ANY_COMMAND]
    cut = 1 + max((word.rfind(character) for character in ":=" if character in breaks), default=-1)
    return sorted({choice[cut:] for choice in choices if choice.startswith(word)})


def _choices(before, word):
    """Lists whole words that can come after some others."""
    if not before:
        more = ["--help", *_launch_arguments(subcommand(DEFAULT), [], word)] if word else []
        return [*COMMANDS, *more]
    name, given = before[0], before[1:]
    if ":=" in name:
        return _launch_arguments(subcommand(DEFAULT), before, word)
    if name not in COMMANDS:
        return []
    module = subcommand(name)
    parser = parser_of(name, module)
    values_of_option = _values_of_option(parser, given, word)
    if values_of_option is not None:
        return values_of_option
    more = [*parser.words(), *(module.complete(given) if hasattr(module, "complete") else [])]
    return [*more, *_launch_arguments(module, given, word), *_flags(parser, module, given, word)]


def _values_of_option(parser, given, word):
    """Lists the values of the option at hand: --track ea, or --track=ea; None if it is none."""
    flag, equals, _ = word.partition("=")
    known = values(parser.option(flag if equals else given[-1] if given else ""))
    return known and [f"{flag}={value}" if equals else value for value in known]


def _flags(parser, module, given, word):
    if not word.startswith("-") or (given and getattr(module, "COMMAND", False)):
        return []
    return [flag for flag in parser.flags() if flag not in given]


def _launch_arguments(module, given, word):
    """Lists NAME:= of a launch file, or NAME:=VALUE once the name is there."""
    launch = getattr(module, "BACK" if "--back" in given else "LAUNCH", None)
    if launch is None:
        return []
    arguments = launch.arguments()
    name, assigned, _ = word.partition(":=")
    if not assigned:
        taken = {argument.partition(":=")[0] for argument in given}
        return [f"{name}:=" for name in arguments if name not in taken]
    if name == "track" and name in arguments:
        values = launching.track_names()
    elif arguments.get(name, ("",))[0] in SWITCH:
        values = SWITCH
    else:
        values = VALUES.get(name, ()) if name in arguments else ()
    return [f"{name}:={value}" for value in values]
