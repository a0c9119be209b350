"""The back end that asks a language model."""
