"""The boards' firmware: its logic on the host, and what the compiled images must be."""
