"""Tests of the belt: protocol, driver, service, inventory, and the emulated conveyor."""
