"""The commands of ./run, one module each.

A module has a docstring, which is the command's help, and:

    run(options, rest)      does it; options of argparse, and launch arguments where LAUNCH is set
    USAGE                   what follows the name in the usage line
    add_arguments(parser)   its options, if it has any; `complete` of a type,
                            or of an action, lists values for TAB
    LAUNCH                  the LaunchFile whose NAME:=VALUE arguments it takes, if any; None: those
                            of a file that the caller names
    PASSES_ON               true: run(arguments) gets them all unread, apart from a leading --help
    complete(words)         further words for TAB, given those behind the command
"""
