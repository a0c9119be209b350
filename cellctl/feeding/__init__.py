"""The conveyor and the inventory: parts to the pick station and back."""
