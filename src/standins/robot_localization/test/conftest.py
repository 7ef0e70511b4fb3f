"""Makes the package's module importable from a plain checkout."""

import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.dirname(os.path.abspath(__file__))), "src"))
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # before the first import of numpy
