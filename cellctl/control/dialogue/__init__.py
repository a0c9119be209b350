"""The conversation with the people in front of the cell."""
