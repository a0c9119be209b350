"""The tests of cellctl; one folder a room."""
