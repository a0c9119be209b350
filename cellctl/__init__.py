"""cellctl: the daemon of a robot cell that builds spoken wishes from reusable voxels."""

import os

# All matrices here are small: threads of the linear algebra would only fight for the cores.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

__version__ = "0.1.0"
