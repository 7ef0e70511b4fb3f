"""./run ci: somebody's packages built and tested as a CI does it.

workspace.py puts them into a workspace of its own on top of this one, tests.py runs their tests and
gathers what they leave.
"""
