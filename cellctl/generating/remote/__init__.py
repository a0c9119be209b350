"""Generators that are reached over the network: Meshy, Tripo, a machine with a GPU."""
