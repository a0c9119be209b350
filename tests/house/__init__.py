"""Tests of the house itself: its environment, its docs, its own checks."""
