"""The compiled programs in the emulated cell's loop, in simulated time."""
