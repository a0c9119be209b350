"""cellctl: the daemon of a robot cell that builds spoken wishes from reusable voxels."""

__version__ = "0.1.0"
