"""./run deps: what the packages of a folder ask for, and who has it.

manifests.py reads their package.xml files, debian.py finds Debian's packages, answer.py puts
everything into one of four lists and prints them.
"""
