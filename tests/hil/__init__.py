"""The suites that run on a cell that is there: ``make test-hil CONFIG=...``; see the how-to.

They are collected only where ``$CELLCTL_HIL_CONFIG`` names a configuration. Nothing moves before
the operator at the terminal has said yes.
"""
