"""The page in front of the cell: what it understood, what it will build, and how that grows."""
