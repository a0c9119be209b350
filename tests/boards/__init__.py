"""Tests of the boards' protocol, link and drivers."""
