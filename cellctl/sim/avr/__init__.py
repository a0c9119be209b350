"""The boards as they are compiled: their programs in a simulator, their pins on the cell."""
