"""The whole cell, end to end: real daemon, real client libraries, emulated at the wire."""
