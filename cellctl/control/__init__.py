"""The daemon: controller, state machine, journal and bus."""
