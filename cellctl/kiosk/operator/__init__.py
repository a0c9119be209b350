"""The page behind its key: for the people who look after the cell."""
