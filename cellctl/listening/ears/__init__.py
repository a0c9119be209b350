"""Live ears: the microphone in a process of its own, and what it hears as typed events."""
