"""The sound system: what hearing and speaking need of it, each in a process of its own."""
