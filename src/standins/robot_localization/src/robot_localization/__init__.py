"""State estimation: measurements -> an extended Kalman filter -> odometry and frames."""

import os

# Counts where numpy is imported after this. The matrices are small: threads would only wait for
# each other, for milliseconds on a busy machine.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
