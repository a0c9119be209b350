"""The screen in front of the cell and the one behind it: web pages that read only the bus."""
