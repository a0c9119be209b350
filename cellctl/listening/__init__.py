"""Microphone, recogniser and request reader: sound -> words -> what to build."""
